//! Policies: behaviours solved by value iteration over the motion graph (Lee and Lee 2004, section 4).

mod adapt;
mod bake;
mod behaviour;
mod compare;
mod config;
mod costs;
mod follow;
#[cfg(any(test, feature = "made-up"))]
#[path = "../../tests/common/made_up.rs"]
pub mod made_up;
mod model;
mod pairs;
mod policies;
mod promise;
mod solve;
mod sweep;

pub use adapt::{AdaptiveReport, Approximation, adapt};
pub use bake::bake;
pub use behaviour::{
    ActionCosts, Approach, BehaviourSpec, Evade, PolicyBehaviour, SegmentHit, ThrowPunches, segment_hits,
    segment_records,
};
pub use compare::{Comparison, compare, random_target};
pub use config::{
    AdaptiveConfig, BehaviourKind, BoundsConfig, CentreConfig, CostsConfig, GridConfig, KernelConfig,
    PolicyBehaviourConfig, PolicyConfig, RegionConfig, RewardForm,
};
pub use costs::ActionTraits;
pub use follow::{PlayedAction, PolicySituation, collect_rewards, play};
pub use model::{ActionModel, SegmentMotion};
pub use policies::{PolicyReport, PolicyTables, RawPolicy, solve, write_csv};
pub use promise::{ENOUGH_KEPT, LEAST_KEPT, Promise, PromisePart, help, promise};
pub use solve::{PolicySolver, Solution, tolerance};

use pairs::{BackupPair, BackupPairs, MAX_PLANE, RowShape};
use sweep::Sweeper;
