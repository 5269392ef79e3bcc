//! Facade for applications: the types that they write, of all crates of the runtime, under one name.
//!
//! A bundle (`*.throng`) is opened as [`Bundle`]; [`characters::PolicyCharacters`] and [`walkers::Walkers`] are
//! [`CharacterGroup`]s that move and pose people. [`policy`] answers single queries without characters. Features add `crowd`
//! (agents without bodies), `world` (patch worlds), `simulation` (scenes) and `sparring`.
//!
//! Every name is listed here, and a test counts the types. A program that needs more depends on the crate that has it.

pub use throng_base::ground::ReservedRegion;
pub use throng_base::limits::STEP_S;
pub use throng_base::{Error, Executor, Id, Inline, Result, glam};
#[cfg(feature = "rayon")]
pub use throng_core::Rayon;
pub use throng_core::{
    AdoptReport, Bundle, CharacterGroup, Joint, Mat3x4, NUM_JOINTS, OrderStatus, PlainBody, Planar, PosedBodies,
    Skeleton,
};
pub use throng_geometry::Capsule2d;

/// Files of bundles.
pub mod format {
    pub use throng_core::format::{AlignedBytes, FormatError, VERSION};
}

/// What bodies of all kinds share: the ground that they stand on, what they do beside walking, and their events.
///
/// ```no_run
/// use throng_runtime::body::{ArmLayer, BodyEventKind, BodyLayers};
/// use throng_runtime::characters::{CharactersConfig, PolicyCharacters, Spawn};
/// use throng_runtime::{Bundle, CharacterGroup, Inline, Planar, glam::Vec3};
///
/// let bundle = Bundle::open("people.throng")?;
/// let mut people = PolicyCharacters::with_capacity(&bundle, 10, CharactersConfig::default())?;
/// let id = people.spawn(Spawn::standing_at(Planar::IDENTITY))?;
/// people.order(id, bundle.policy("approach")?.order_towards(Vec3::new(0.0, 0.0, 9.0)))?;
/// // It walks there, waves and looks at somebody; walkers do so by `Control::layers`.
/// let arms = [None, Some(ArmLayer::Wave)];
/// people.set_layers(id, BodyLayers { arms, look_at: Some(Vec3::new(2.0, 1.6, 5.0)), ..BodyLayers::NONE })?;
/// for _ in 0..600 {
///     people.step(1.0 / 60.0, &Inline)?;
///     for (_, step) in people.events().iter().filter(|(_, event)| event.kind == BodyEventKind::Footstep) {
///         println!("a foot is at {}, {} of the loudest", step.at, step.strength);
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub mod body {
    pub use throng_core::body::{ArmLayer, BodyEvent, BodyEventKind, BodyLayers, HeightField};
}

/// Characters that choose their motion by policies.
pub mod characters {
    pub use throng_core::characters::{
        ActionChoice, AvoidConfig, CharactersConfig, Detail, MotionSet, PolicyCharacters, PolicyOrder, PoseInstance,
        SampleJob, Spawn,
    };
}

/// Answers of policies, without characters.
pub mod policy {
    pub use throng_core::policy::{BestActionJob, LookAheadGoal, LookAheadJob, RankedActions};
}

/// Characters that follow a trajectory, blended from examples.
pub mod walkers {
    pub use throng_core::blend::BlendSpace;
    pub use throng_core::walkers::{Control, Performance, WalkerStart, Walkers, WalkersConfig};
}

/// Agents without bodies, which never overlap.
#[cfg(feature = "crowd")]
pub mod crowd {
    pub use throng_crowd::{
        Agent, AgentOrder, AgentStatus, AtEnd, Crowd, CrowdConfig, CrowdError, CrowdEventKind, CrowdSetup, ForceField,
        Obstacle, Route, Streets,
    };
}

/// People in a world of motion patches.
#[cfg(feature = "world")]
pub mod world {
    pub use throng_world::World;
    pub use throng_world::inhabitants::{
        InhabitantEvent, InhabitantGoal, Inhabitants, InhabitantsConfig, scatter_rest_nodes,
    };
}

/// Scenes: all kinds of motion on one clock, and the actions that an application adds to them.
#[cfg(feature = "simulation")]
pub mod simulation {
    pub use throng_simulation::scenario::{
        ActionArguments, ActionCommand, ActionRegistry, PrimitiveBehaviour, PrimitiveInput, WalkCommand, WordKind,
    };
    pub use throng_simulation::{CharacterEvent, Order, Pedestrians, Scene, Simulation, SimulationEvent};
}

/// Boxers, in pairs and before a target.
#[cfg(feature = "simulation")]
pub mod sparring {
    pub use throng_simulation::sparring::{BlowLanding, Sparring, SparringConfig, TargetPractice};
}

/// The program in the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
