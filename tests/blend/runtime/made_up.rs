//! A blend space made by hand: a body on two legs that strides at any speed, sideways, back, in curves, or stands.

use bytemuck::Zeroable;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use throng_core::blend::{
    AxisRecord, BlendRecord, BlendSpace, Blends, ChannelRow, ExampleRecord, MAX_AXES, PADDED_JOINTS, ReferenceRow,
    axis, channel,
};
use throng_core::{Joint, Planar, Skeleton};

/// Rows of the posture tables.
pub const PHASES: usize = 32;

/// Tables of one blend space.
pub struct MadeUp {
    pub spaces: Vec<BlendRecord>,
    pub examples: Vec<ExampleRecord>,
    pub weights: Vec<f32>,
    pub references: Vec<ReferenceRow>,
    pub channels: Vec<ChannelRow>,
}

/// How an example strides: left, ahead, turning (m/s, rad/s).
pub type Stride = [f32; 3];

impl MadeUp {
    pub fn view(&self) -> Blends {
        Blends {
            spaces: (&self.spaces).into(),
            examples: (&self.examples).into(),
            weights: (&self.weights).into(),
            references: (&self.references).into(),
            channels: (&self.channels).into(),
            names: vec!["made-up".into()],
            skeleton: Skeleton::default(),
        }
    }

    pub fn space(&self) -> BlendSpace {
        BlendSpace::new(&self.view(), 0).expect("a space")
    }

    /// Twenty examples over speed, side step and turning.
    pub fn locomotion() -> Self {
        let mut strides = vec![[0.0; 3]];
        for turning in [-1.2, 0.0, 1.2] {
            strides.extend([0.8, 1.5, 2.6, 4.0, 5.0].map(|speed| [0.0, speed, turning]));
        }
        strides.extend([[0.7, 0.0, 0.0], [-0.7, 0.0, 0.0], [0.0, -0.8, 0.0], [0.0, 0.0, 1.5]]);
        Self::new(&strides, [13, 5, 7])
    }

    /// Examples of given strides, over a grid of so many knots a axis.
    pub fn new(strides: &[Stride], knots: [u32; 3]) -> Self {
        let stride = strides.len().next_multiple_of(8);
        let mut axes = [AxisRecord::zeroed(); MAX_AXES];
        for (a, (kind, low, high)) in
            [(axis::SPEED, -1.0, 5.0), (axis::SIDE, -1.0, 1.0), (axis::GYRATION, -1.5, 1.5)].into_iter().enumerate()
        {
            axes[a] = AxisRecord { kind, num_knots: knots[a], low, high };
        }
        let record = BlendRecord {
            first_example: 0,
            num_examples: strides.len() as u32,
            num_axes: 3,
            num_phases: PHASES as u32,
            first_weight: 0,
            weight_stride: stride as u32,
            first_row: 0,
            first_channel_row: 0,
            max_weight_error: 0.0,
            extrapolate: 0,
            axes,
        };
        let examples: Vec<_> = strides.iter().map(example).collect();
        let mut channels = Vec::new();
        for phase in 0..PHASES {
            channels.extend(strides.iter().map(|s| row(s, phase as f32 / PHASES as f32)));
        }
        let mut identity = ReferenceRow { components: [[0.0; PADDED_JOINTS]; 4] };
        identity.components[3] = [1.0; PADDED_JOINTS];
        Self {
            spaces: vec![record],
            weights: table(&axes[..3], &examples, stride),
            examples,
            references: vec![identity; PHASES],
            channels,
        }
    }
}

/// Weights that fall off with the distance, exact at the examples that lie on knots.
fn table(axes: &[AxisRecord], examples: &[ExampleRecord], stride: usize) -> Vec<f32> {
    let mut table = Vec::new();
    let value = |a: &AxisRecord, i: u32| a.low + (a.high - a.low) * i as f32 / (a.num_knots - 1) as f32;
    for i in 0..axes[0].num_knots {
        for j in 0..axes[1].num_knots {
            for k in 0..axes[2].num_knots {
                let at = [value(&axes[0], i), value(&axes[1], j), value(&axes[2], k)];
                let near = |e: &ExampleRecord| {
                    let d2: f32 = (0..3).map(|a| (e.parameters[a] - at[a]).powi(2)).sum();
                    1.0 / (d2 * d2 + 1e-6)
                };
                let sum: f32 = examples.iter().map(near).sum();
                let row = examples.iter().map(|e| near(e) / sum);
                table.extend(row.chain(std::iter::repeat(0.0)).take(stride));
            }
        }
    }
    table
}

fn is_still(stride: &Stride) -> bool {
    stride.iter().all(|&v| v == 0.0)
}

/// Time of a cycle: quicker steps at higher speeds (s).
pub fn cycle_s(stride: &Stride) -> f32 {
    if is_still(stride) { 3.0 } else { 1.25 - 0.11 * stride[0].hypot(stride[1]) }
}

fn example(stride: &Stride) -> ExampleRecord {
    let mut parameters = [0.0; MAX_AXES];
    parameters[..3].copy_from_slice(&[stride[1], stride[0], stride[2]]);
    let flags = if is_still(stride) { ExampleRecord::IS_STILL } else { 0 };
    let stance = stance(stride);
    ExampleRecord {
        parameters,
        duration_s: cycle_s(stride),
        velocity: [stride[0], stride[1]],
        gyration: stride[2],
        keytimes: if is_still(stride) { [0.0; 3] } else { [stance, 0.5, (0.5 + stance) % 1.0] },
        flags,
        ..ExampleRecord::zeroed()
    }
}

/// Share of the cycle that a foot is on the ground: no longer than legs reach.
fn stance(stride: &Stride) -> f32 {
    let offset = cycle_s(stride) * stride[0].hypot(stride[1]);
    if is_still(stride) { 1.0 } else { 0.64f32.min(0.72 / offset.max(0.1)) }
}

/// What a foot does at a phase of its own cycle, which begins with its strike.
struct Foot {
    /// Ankle in the facing frame, before the hips are taken away (m).
    ankle: Vec3,
    rotation: Quat,
    down: bool,
}

fn foot(stride: &Stride, side: f32, phase: f32) -> Foot {
    let skeleton = Skeleton::default();
    let rest = skeleton.rest_positions()[Joint::LeftFoot.index()];
    let (stance, cycle_s) = (stance(stride), cycle_s(stride));
    // Planted below the hip where the body is in the middle of the stance.
    let planted = |t: f32| {
        let place = arc(stride, t).inverse().compose(Planar::new(side * rest.x, 0.0, 0.0));
        (Vec2::new(place.x, place.z), place.heading)
    };
    // The heel rises about the ball late in the stance.
    let ball = Skeleton::default().offsets[Joint::LeftToe.index()].with_y(-rest.y);
    let risen = |yaw: f32, pitch: f32| {
        let (flat, rotation) = (Quat::from_rotation_y(yaw), Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch));
        (flat * ball - rotation * ball, rotation)
    };
    let push = if is_still(stride) { 0.0 } else { 0.6 };
    let smooth = |s: f32| s * s * (3.0 - 2.0 * s);
    if phase < stance {
        let (at, yaw) = planted((phase - 0.5 * stance) * cycle_s);
        let (by, rotation) = risen(yaw, push * smooth((phase / stance / 0.4 - 1.5).max(0.0)));
        return Foot { ankle: Vec3::new(at.x, rest.y, at.y) + by, rotation, down: true };
    }
    let (from, to) = (planted(0.5 * stance * cycle_s), planted(-0.5 * stance * cycle_s));
    let s = (phase - stance) / (1.0 - stance);
    let ease = smooth(s);
    let at = from.0.lerp(to.0, ease);
    let lift = 0.06 + 0.05 * stride[0].hypot(stride[1]);
    let height = rest.y + lift * (PI * s).sin().powi(2);
    let (by, rotation) = risen(from.1 + (to.1 - from.1) * ease, push * (1.0 - ease));
    Foot { ankle: Vec3::new(at.x, height, at.y) + by, rotation, down: false }
}

/// Facing frame after a time (s).
fn arc(stride: &Stride, t: f32) -> Planar {
    let [left, ahead, turning] = *stride;
    let steps = 64;
    let dt = t / steps as f32;
    (0..steps).fold(Planar::IDENTITY, |at, _| at.compose(Planar::new(left * dt, ahead * dt, turning * dt)))
}

/// The channels of an example at a generic time.
fn row(stride: &Stride, phase: f32) -> ChannelRow {
    let skeleton = Skeleton::default();
    let mut row = ChannelRow { values: [0.0; 96] };
    let speed = stride[0].hypot(stride[1]);
    let bob = if is_still(stride) { 0.0 } else { 0.012 + 0.004 * speed };
    let hips = Vec3::new(0.0, 0.885 - 0.006 * speed - bob * (2.0 * TAU * phase).cos(), 0.0);
    let mut put = |at: usize, v: Vec3| row.values[at..at + 3].copy_from_slice(&v.to_array());
    put(channel::HIPS, hips);
    let feet = [foot(stride, 1.0, phase), foot(stride, -1.0, (phase + 0.5) % 1.0)];
    for (side, foot) in feet.iter().enumerate() {
        put([channel::LEFT_ANKLE, channel::RIGHT_ANKLE][side], foot.ankle - hips);
    }
    for (hand, side) in [(channel::LEFT_HAND, 1.0), (channel::RIGHT_HAND, -1.0)] {
        put(hand, Vec3::new(side * 0.2, 0.0, 0.1 * side * (TAU * phase).cos()));
    }
    for (side, foot) in feet.iter().enumerate() {
        bend_leg(&mut row, &skeleton, side, hips, foot);
        row.values[[channel::LEFT_CONTACT, channel::RIGHT_CONTACT][side]] = f32::from(u8::from(foot.down));
    }
    row.values[channel::RATE] = cycle_s(stride);
    row.values[channel::VELOCITY] = stride[0];
    row.values[channel::VELOCITY + 1] = stride[1];
    row.values[channel::GYRATION] = stride[2];
    row
}

/// Thigh, shin and foot that reach the ankle, the knee ahead.
fn bend_leg(row: &mut ChannelRow, skeleton: &Skeleton, side: usize, hips: Vec3, foot: &Foot) {
    let joints =
        [[Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot], [Joint::RightThigh, Joint::RightShin, Joint::RightFoot]]
            [side];
    let [l1, l2] = [joints[1], joints[2]].map(|j| skeleton.offsets[j.index()].length());
    let offset = foot.ankle - hips - skeleton.offsets[joints[0].index()];
    let d = offset.length().min(0.999 * (l1 + l2));
    let knee = PI - ((l1 * l1 + l2 * l2 - d * d) / (2.0 * l1 * l2)).clamp(-1.0, 1.0).acos();
    let hip = ((l1 * l1 + d * d - l2 * l2) / (2.0 * l1 * d)).clamp(-1.0, 1.0).acos();
    let thigh = Quat::from_rotation_arc(Vec3::NEG_Y, offset.normalize()) * Quat::from_rotation_x(-hip);
    let shin = Quat::from_rotation_x(knee);
    put_rotation(row, joints[0], thigh);
    put_rotation(row, joints[1], shin);
    put_rotation(row, joints[2], (thigh * shin).inverse() * foot.rotation);
}

/// Puts a rotation, whose reference is the identity.
pub fn put_rotation(row: &mut ChannelRow, joint: Joint, q: Quat) {
    let log = q.to_scaled_axis() * 0.5;
    for (start, v) in channel::LOG.into_iter().zip(log.to_array()) {
        row.values[start + joint.index()] = v;
    }
}
