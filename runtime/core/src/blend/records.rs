//! The records of the sections that hold blend spaces.

use crate::skeleton::NUM_JOINTS;
use bytemuck::{Pod, Zeroable};

/// Most axes of a blend space.
pub const MAX_AXES: usize = 6;
/// Limit of the weights of a table.
pub const MAX_WEIGHT: f32 = 1e3;
/// Joints padded to whole vectors of eight.
pub const PADDED_JOINTS: usize = NUM_JOINTS.next_multiple_of(8);
/// Numbers of a [`ChannelRow`] and of a blended one.
pub const NUM_CHANNELS: usize = 96;

/// Kinds of axes of a blend space.
pub mod axis {
    /// A number that the caller sets: a manner, or walk 0, jog 1, run 2 (Kim, Kim and Shin 2003a, section 4.1).
    pub const STYLE: u32 = 0;
    /// Speed along the direction that the body faces, negative backwards (m/s).
    pub const SPEED: u32 = 1;
    /// Speed to the body's left (m/s).
    pub const SIDE: u32 = 2;
    /// Turning rate (gyration), positive to the left (rad/s).
    pub const GYRATION: u32 = 3;
}

/// Axis of a blend space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct AxisRecord {
    /// Kind of the axis, see [`axis`].
    pub kind: u32,
    /// Knots of the weight table along it (>= 2).
    pub num_knots: u32,
    /// Value at the first knot.
    pub low: f32,
    /// Value at the last knot (> low + 0.0001).
    pub high: f32,
}

/// A blend space: example motions placed in a parameter box, and tables of their weights and postures (Kim, Kim and
/// Shin 2003a, section 4).
///
/// Its examples are `first_example..first_example + num_examples`. Its weight rows start at `first_weight`: one for
/// every knot of the grid, the last axis running fastest, each of `weight_stride` numbers, of which those beyond
/// `num_examples` are 0. Its posture rows start at `first_row`: one for every phase, each of them a reference row and
/// `num_examples` channel rows.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BlendRecord {
    /// First example.
    pub first_example: u32,
    /// Number of examples (> 0).
    pub num_examples: u32,
    /// Number of axes (1 to MAX_AXES).
    pub num_axes: u32,
    /// Rows of the posture tables over one cycle of generic time; row r lies at r / num_phases, and the last is
    /// followed by the first (2 to 4096).
    pub num_phases: u32,
    /// First number of its weight table.
    pub first_weight: u32,
    /// Numbers of a weight row, a multiple of 8.
    pub weight_stride: u32,
    /// First reference row; the first channel row is `first_channel_row`.
    pub first_row: u32,
    /// First channel row: row (phase, example) lies at `first_channel_row + phase * num_examples + example`.
    pub first_channel_row: u32,
    /// Largest error of a tabulated weight against the exact cardinal function, as the build measured it.
    pub max_weight_error: f32,
    /// Points outside the box: 0 clamps them to it, 1 extrapolates the linear part of the weights.
    pub extrapolate: u32,
    /// The axes.
    pub axes: [AxisRecord; MAX_AXES],
}

/// One example motion: a cycle of steady locomotion.
///
/// The path of an example is the circular arc (or the straight line, or the point) that fits its root's ground path
/// best. Its facing frame at a time lies on the arc, and its heading is that of the arc plus a constant, so that the
/// body faces +Z in it on average.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ExampleRecord {
    /// Position in the parameter box, axis by axis; 0 beyond the last axis.
    pub parameters: [f32; MAX_AXES],
    /// Time of the cycle (s, > 0).
    pub duration_s: f32,
    /// Velocity along its arc in the facing frame: to the left (x), ahead (z) (m/s).
    pub velocity: [f32; 2],
    /// Turning rate along its arc (rad/s).
    pub gyration: f32,
    /// Generic times at which the left foot leaves the ground, the right foot strikes, the right foot leaves; the left
    /// foot strikes at 0. In [0, 1). All 0 for a still example.
    pub keytimes: [f32; 3],
    /// See [`ExampleRecord::IS_STILL`] and [`ExampleRecord::IS_MIRRORED`].
    pub flags: u32,
    /// Clip it was taken from.
    pub clip: u32,
    /// First frame within the clip.
    pub first_frame: u32,
    /// Frames of the cycle.
    pub num_frames: u32,
    /// Zero.
    pub reserved: u32,
}

impl ExampleRecord {
    /// Flag of an example whose feet both stay on the ground.
    pub const IS_STILL: u32 = 1;
    /// Left and right are exchanged against the clip as captured.
    pub const IS_MIRRORED: u32 = 2;
}

/// Reference orientations at one phase (Kim, Kim and Shin 2003a, equation 11): what is as near to those of all examples
/// as can be.
///
/// Components by joint, so that eight joints are loaded at once. Joint 0 is the hips' orientation in the facing frame,
/// the others are relative to their parents. Unit; beyond the joints there are, the identity.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct ReferenceRow {
    /// x, y, z, w, each joint by joint.
    pub components: [[f32; PADDED_JOINTS]; 4],
}

/// The posture of one example at one phase, as numbers that are blended linearly.
///
/// `0..3 * PADDED_JOINTS` are log-displacements from the [`ReferenceRow`], x then y then z, each joint by joint: the
/// orientation is `reference * exp(v)`, where `exp(v)` turns by 2 |v| about v (rad / 2). The rest are the
/// channels of [`channel`].
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct ChannelRow {
    /// The numbers.
    pub values: [f32; NUM_CHANNELS],
}

/// Places of channels in a [`ChannelRow`]. Positions are in the facing frame, of the database skeleton (m).
pub mod channel {
    use super::PADDED_JOINTS;

    /// Log-displacements: x, y and z parts start here.
    pub const LOG: [usize; 3] = [0, PADDED_JOINTS, 2 * PADDED_JOINTS];
    /// Hips: left of the arc, above the ground, ahead of the arc's point.
    pub const HIPS: usize = 3 * PADDED_JOINTS;
    /// Left ankle (the joint `LeftFoot`), relative to the hips, in the facing frame.
    pub const LEFT_ANKLE: usize = HIPS + 3;
    /// Right ankle (the joint `RightFoot`), in the same frame.
    pub const RIGHT_ANKLE: usize = HIPS + 6;
    /// Left hand's joint, in the same frame.
    pub const LEFT_HAND: usize = HIPS + 9;
    /// Right hand's joint, in the same frame.
    pub const RIGHT_HAND: usize = HIPS + 12;
    /// Seconds that pass per unit of generic time: positive, constant between keytimes (Kim, Kim and Shin 2003a,
    /// section 4.2.2) (s).
    pub const RATE: usize = HIPS + 15;
    /// 1 while the left foot stands on the ground, else 0.
    pub const LEFT_CONTACT: usize = HIPS + 16;
    /// 1 while the right foot stands on the ground, else 0.
    pub const RIGHT_CONTACT: usize = HIPS + 17;
    /// 1 while the left hand touches something, else 0.
    pub const LEFT_TOUCH: usize = HIPS + 18;
    /// 1 while the right hand touches something, else 0.
    pub const RIGHT_TOUCH: usize = HIPS + 19;
    /// Velocity along the arc: to the left, ahead (m/s).
    pub const VELOCITY: usize = HIPS + 20;
    /// Turning rate along the arc (rad/s).
    pub const GYRATION: usize = HIPS + 22;
}

const _: () = assert!(channel::GYRATION < NUM_CHANNELS);
const _: () = assert!(size_of::<BlendRecord>() == 40 + MAX_AXES * 16);
const _: () = assert!(size_of::<ExampleRecord>() == 72);
