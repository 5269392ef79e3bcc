//! Tasks as files: characters, things, and actions of limbs.

mod actions;
mod both_hands;
mod check;
mod entries;
mod file;
mod follow;
mod gaze;
mod grips;
mod held_capsules;
mod lean;
mod mesh;
mod preview;
mod run;
mod scenery;
mod stage;
mod step;
#[cfg(test)]
mod tests;
mod visit;
mod walk;
mod write_back;

pub use entries::{PaceEntry, WalkEntry};
pub use file::{ClipEntry, Task, TaskCharacter, TaskThing, ThingStart, WornFigure};
pub use preview::{MeshPreview, StepPreview};
pub use run::{Attachment, ClipMismatch, RunOptions, StepOutcome, TaskEvent, TaskOutcome, UnresolvedSpan};
pub use scenery::{Handle, TaskScenery};
pub use stage::{ActorClip, TaskGaze};
pub use throng_motion::import::obj::triangles as obj_triangles;
pub use walk::{ActorSource, WalkError, WalkedTask};

use actions::{CONTACT_S, PlanResult, StepFailure, run_step};
use entries::TaskAction;
use follow::{FollowError, HandPath};
use grips::{HandTarget, awkwardness};
use held_capsules::capsules_around;
use lean::ease;
use mesh::open_edges;
use preview::{object_target, solve_hands};
use run::nearest_distance;
use stage::{Pin, PlannedLimb, SecondHand, StageActor, TaskStage, ThingPlacement, TrunkLean, hand_joint, palm};
use step::{Anchor, NameTable, ObjectGrip, TaskPlace, TaskStep};
