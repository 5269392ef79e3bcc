//! Control by precomputed policies: a state and a target's place give the next action (003 sections 3 to 5).
//!
//! Two ways to ask, both in batches that allocate nothing: [`BestActionJob`] loads the stored best action of the
//! nearest cell; [`LookAheadJob`] weighs every action by its reward and the value of where it leads, for one
//! behaviour or a weighted sum of several, and ranks the best few, of which [`RankedActions::choose`] takes one.

mod adaptive;
mod backup;
mod best_action;
mod error;
mod grid;
mod look_ahead;
mod maths;
mod moments;
mod ranked;
mod region;
mod reward;
mod table;

pub use adaptive::{MAX_STATE_CELLS, StateGridRecord};
pub use backup::{Backups, GroundTargets};
pub use best_action::BestActionJob;
pub use error::{PolicyError, PolicyJobError};
pub use grid::{GridRecord, KIND_CYLINDER, KIND_MOMENTS, KIND_POLAR, MAX_AXIS, Stencil, TargetGrid};
pub use look_ahead::{Goal, LookAheadJob};
pub use maths::{angle_of, exp_neg, nearest_index};
pub use moments::{PATH_POINTS, PathRecord};
pub use ranked::{MAX_RANKED, RankedActions};
pub use region::RegionRecord;
pub use reward::{COMBINE_MAX, COMBINE_SUM, KERNEL_EXPONENTIAL, KERNEL_WITHIN, Reward, RewardRecord};
pub use table::{ActionTable, MAX_ACTIONS, NO_ACTION, PolicyRecord, PolicySlices, PolicyTable, SegmentRecord};
