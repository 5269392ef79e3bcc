//! Policies: behaviours solved by value iteration over the motion graph (Lee and Lee 2004, section 4).

mod adapt;
mod bake;
mod behaviour;
mod compare;
mod config;
mod export;
mod follow;
pub mod made_up;
mod model;
mod pairs;
mod policies;
mod promise;
mod solve;
mod sweep;

pub use adapt::{AdaptiveReport, Approximation, adapt};
pub use bake::bake;
pub use behaviour::{Approach, Behaviour, Evade, SegmentHit, Spec, ThrowPunches, segment_hits, segment_records};
pub use compare::{Comparison, compare, random_target};
pub use config::{
    AdaptiveConfig, BehaviourConfig, BehaviourKind, BoundsConfig, CentreConfig, GridConfig, KernelConfig, PolicyConfig,
    RegionConfig, RewardForm,
};
pub use export::write_csv;
pub use follow::{Follow, Played, Situation, collect, play};
pub use model::{ActionModel, SegmentMotion};
pub use policies::{Policy, PolicyReport, PolicyTables, solve, solve_behaviours};
pub use promise::{ENOUGH_KEPT, LEAST_KEPT, Promise, PromisePart, help, promise};
pub use solve::{Solution, shared_value_iteration, tolerance, value_iteration};
