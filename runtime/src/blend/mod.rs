//! Blend spaces: a body from a few example motions, at any speed, turning rate and style (000 section 4).

mod error;
mod grid;
mod ground;
mod posture;
mod records;
mod slopes;
mod space;
pub mod walkers;
mod warp;

pub use error::BlendError;
pub use grid::{MAX_KNOTS, WeightGrid};
pub use ground::{Ground, HeightField};
pub use posture::Posture;
pub use space::BlendSpace;

pub use records::{
    AxisRecord, BlendRecord, ChannelRow, ExampleRecord, MAX_AXES, MAX_WEIGHT, NUM_CHANNELS, PADDED_JOINTS,
    ReferenceRow, axis, channel,
};

/// View on the blend spaces of a bundle.
#[derive(Clone, Copy, Debug)]
pub struct Blends<'a> {
    /// The spaces; their names, and those of their axes and examples, are `Meta::blends`.
    pub spaces: &'a [BlendRecord],
    /// Examples of all spaces.
    pub examples: &'a [ExampleRecord],
    /// Weight tables of all spaces.
    pub weights: &'a [f32],
    /// Reference rows of all spaces.
    pub references: &'a [ReferenceRow],
    /// Channel rows of all spaces.
    pub channels: &'a [ChannelRow],
}
