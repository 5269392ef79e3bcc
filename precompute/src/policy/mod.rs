//! Policies: behaviours solved by value iteration over the motion graph (003 section 4).

mod behaviour;
mod config;
pub mod made_up;
mod model;
mod pairs;
mod solve;
mod sweep;

pub use behaviour::{Approach, Behaviour, segment_records};
pub use config::{ApproachReward, BehaviourConfig, GridConfig, PolicyConfig};
pub use model::{ActionModel, SegmentMotion};
pub use solve::{Solution, tolerance, value_iteration};
