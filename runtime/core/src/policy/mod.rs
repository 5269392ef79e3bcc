//! Precomputed policies: the state and the target's position give the next action (Lee and Lee 2004, sections 3 to 5).
//!
//! There are two kinds of queries, both in batches that allocate nothing. [`BestActionJob`] loads the stored best
//! action of the nearest cell. [`LookAheadJob`] ranks the actions by reward plus value of the successor, for one
//! behaviour or a weighted sum of several; [`RankedActions::choose`] picks one of the best.

mod adaptive;
mod backup;
mod best_action;
mod grid;
mod look_ahead;
mod maths;
mod ranked;
mod region;
mod reward;
mod space_time;
mod table;

pub use adaptive::{MAX_STATE_CELLS, StateGridRecord};
pub use backup::{Backups, GroundTargets};
pub use best_action::BestActionJob;
pub use grid::{GridRecord, KIND_CYLINDER, KIND_POLAR, KIND_SPACE_TIME, MAX_AXIS, Stencil, TargetGrid};
pub use look_ahead::{LookAheadGoal, LookAheadJob};
pub use maths::{angle_of, exp_neg, nearest_index};
pub use ranked::{MAX_RANKED, RankedActions};
pub use region::RegionRecord;
pub use reward::{COMBINE_MAX, COMBINE_SUM, KERNEL_EXPONENTIAL, KERNEL_LINEAR, KERNEL_WITHIN, Reward, RewardRecord};
pub use space_time::{PATH_POINTS, PathRecord};
pub use table::{
    ActionTable, MAX_ACTIONS, MAX_BEND, NO_ACTION, PolicyRecord, PolicySlices, PolicyTable, SegmentRecord,
};
