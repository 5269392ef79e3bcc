//! Recorded runs of scenes, worlds and blends: played, stopped, stepped, and rewound over their last minute.
//!
//! The crowd of a bundle is a scene, too. Scenes record a state every second and every input; a step in between is
//! reproduced by repeating the steps from the state before it, bit for bit. Worlds and blends record poses.

pub mod agents;
mod blend;
mod blending;
mod choices;
mod figures;
mod input;
mod reel;
mod scene;
mod world;

pub use blend::{BlendMoment, BlendRun};
pub use blending::{BlendCompanions, Blending, LEGS, SIZES};
pub use choices::{ActionCandidate, BehaviourScore, ChoiceReason, explain_choice};
pub use choices::{GoalSubject, PolicyChooser, RecordedChoice, RunGoal};
pub use figures::{BlowMark, BlowResult, BoutFigures, Slip, StepFigures};
pub use input::{MAX_TARGET_M, RunInput, SceneChoice};
pub use reel::{PlayHead, Reel};
pub use scene::{SceneFork, SceneRun, detail_level, is_at_target, target_home};
pub use world::{InhabitantsMoment, WorldRun};

/// Steps a second of simulated time (Hz).
pub const STEP_HZ: f32 = 60.0;
