//! Blend spaces: bodies blended from a few example motions, at any speed, turning rate and style (Kim, Kim and Shin 2003a,
//! section 4).

mod activity;
mod grid;
mod posture;
mod records;
mod rows;
mod slopes;
mod space;
mod warp;

pub(crate) use activity::ActivitySample;
pub use activity::{Activity, ActivityId, ActivitySet, ArmPlaces};
pub use grid::{MAX_KNOTS, WeightGrid};
pub use posture::BlendedPosture;
pub(crate) use posture::smooth_share;
pub use space::BlendSpace;

use crate::{format::Table, skeleton::Skeleton};

pub use records::{
    AxisRecord, BlendRecord, ChannelRow, ExampleRecord, MAX_AXES, MAX_WEIGHT, NUM_CHANNELS, PADDED_JOINTS,
    ReferenceRow, axis, channel,
};

/// The blend spaces of a bundle. Clones share the rows.
#[derive(Clone, Debug)]
pub struct Blends {
    /// The spaces; names of their axes and examples are in `Meta::blends`.
    pub spaces: Table<BlendRecord>,
    /// Examples of all spaces.
    pub examples: Table<ExampleRecord>,
    /// Weight tables of all spaces.
    pub weights: Table<f32>,
    /// Reference rows of all spaces.
    pub references: Table<ReferenceRow>,
    /// Channel rows of all spaces.
    pub channels: Table<ChannelRow>,
    /// Names of the spaces (spaces.len()).
    pub names: Vec<String>,
    /// The skeleton that the examples move.
    pub skeleton: Skeleton,
}
