//! State of eight characters, laid out so that one load fetches a value of all eight.

use super::{motion_set::MotionSet, pace};
use crate::body::{BodyState, FootLock, Lane, Lane3, Lanewise, get_lane, lanewise_fields, planar_of_lane, set_lane};
use crate::planar::{Planar, wrap_angle};
use crate::{contacts::Contacts, graph::MotionSegment, skeleton::NUM_JOINTS};
use bytemuck::Zeroable;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::simd::{LANES, Lanes, V};

/// A vector of each character in short integers.
pub(crate) type Code3 = [[i16; LANES]; 3];

/// Codes of a rotation offset a unit: modified Rodrigues parameters are at most 1.
pub(crate) const ROTATION_CODES: f32 = 32767.0;
/// Codes of their rate of change a unit: up to 16, which is 64 rad/s; what is faster is cut off.
pub(crate) const VELOCITY_CODES: f32 = 2048.0;

/// Marks a segment that was not chosen.
pub(crate) const NO_STATE: u32 = u32::MAX;

/// Marks a character that plays a scheduled clip instead of a segment.
pub(crate) const SCHEDULED: u32 = u32::MAX;

/// Writes the vector of one lane as codes.
pub(crate) fn encode(v: &mut Code3, lane: usize, codes: f32, to: Vec3) {
    for (axis, value) in v.iter_mut().zip(to.to_array()) {
        axis[lane] = (value * codes).round().clamp(-32767.0, 32767.0) as i16;
    }
}

/// The vector of one lane of codes.
pub(crate) fn decode(v: &Code3, lane: usize, codes: f32) -> Vec3 {
    Vec3::new(f32::from(v[0][lane]), f32::from(v[1][lane]), f32::from(v[2][lane])) / codes
}

/// Loads the codes of all lanes as floats.
#[inline(always)]
pub(crate) fn load_codes<F: Lanes>(v: &Code3) -> V<F> {
    V::new(F::integers(&v[0]), F::integers(&v[1]), F::integers(&v[2]))
}

/// The inertial offsets of the last transition: what the pose differed by, and how fast that changed.
///
/// Rotation offsets are modified Rodrigues parameters, applied on the parent's side; their velocities are per second.
/// Both are kept as short integers, which halves what a step reads.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct Offsets {
    pub rotation: [Code3; NUM_JOINTS],
    pub rotation_velocity: [Code3; NUM_JOINTS],
    /// Offset of the hips and its rate, in model space (m, m/s).
    pub root: Lane3,
    pub root_velocity: Lane3,
}

impl Offsets {
    pub const ZERO: Self = Self {
        rotation: [[[0; LANES]; 3]; NUM_JOINTS],
        rotation_velocity: [[[0; LANES]; 3]; NUM_JOINTS],
        root: [[0.0; LANES]; 3],
        root_velocity: [[0.0; LANES]; 3],
    };
}

/// State of eight characters.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(crate) struct MotionBlock {
    /// Name by which random choices are drawn, beside the seed and their number.
    pub name: [u64; LANES],
    /// Segment that is played; [`SCHEDULED`] for a scheduled clip.
    pub segment: [u32; LANES],
    /// First frame row of the segment or scheduled clip.
    pub first: [u32; LANES],
    /// Frames after it (> 0, but in lanes without a character).
    pub length: [u32; LANES],
    /// Time since the first frame; below 0 only for a clip that was scheduled long before the last one ends (frames).
    pub time: Lane,
    /// Planar transform from the clip to the world: x, z, heading (m, m, rad).
    pub clip_to_world: Lane3,
    /// Planar root in the world at the last step: x, z, heading (m, m, rad).
    pub root: Lane3,
    /// Height to which the floor is the nearest one, where the ground has several (m).
    pub floor: Lane,
    /// Height of the clip's ground in the world, at time `drift_from` (m).
    pub lift: Lane,
    /// Drift of place and lift that a scheduled clip adds per frame after `drift_from`, along the world's axes
    /// (m/frame).
    pub drift: Lane3,
    /// Drift of the heading, likewise (rad/frame).
    pub turn: Lane,
    /// (frames)
    pub drift_from: Lane,
    /// Rate at which the action is bent (rad/frame).
    pub bend: Lane,
    /// Pace of the segment, see [`super::pace`].
    pub pace: [u32; LANES],
    /// Time until a held character chooses again (frames).
    pub wait: Lane,
    /// Choices in a row at which nothing was clear.
    pub blocked: [u32; LANES],
    /// Time since the last transition (s).
    pub age_s: Lane,
    /// Choices made so far.
    pub num_choices: [u32; LANES],
    /// State of the last choice; [`NO_STATE`] where the segment was not chosen.
    pub choice_state: [u32; LANES],
    /// Planar root in the world at the segment's first frame: x, z, heading (m, m, rad).
    pub choice_root: Lane3,
    /// Contacts at the last step.
    pub contacts: [Contacts; LANES],
    /// Last frame row before the last transition, and first one after it.
    pub change: [[u32; LANES]; 2],
}

/// Differences of eight bodies from their clips. Only those of posed blocks count.
///
/// The system provides memory for many only as it is written, which allocators promise for no more than 16 bytes of
/// alignment. They begin large pieces 16 bytes into a page; with 48 more, all that follows lies on cache lines.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct BodyBlock {
    /// 1 from the first pose on, 0 where the block is not posed: then feet and offsets count for nothing.
    pub awake: u32,
    #[serde(skip)]
    pub(super) unused: [u32; 11],
    /// Left, right.
    pub feet: [FootLock; 2],
    pub offsets: Offsets,
    pub state: BodyState,
    #[serde(skip)]
    pub(super) fill: [u32; 4],
}

const _: () = assert!(align_of::<BodyBlock>() <= 16 && size_of::<BodyBlock>().is_multiple_of(64));

impl BodyBlock {
    pub const ZERO: Self = Self {
        awake: 0,
        unused: [0; 11],
        feet: [FootLock::ZERO; 2],
        offsets: Offsets::ZERO,
        state: BodyState::ZERO,
        fill: [0; 4],
    };

    /// Frees a lane. Memory that was never written stays so.
    pub fn clear(&mut self, lane: usize) {
        if self.awake == 1 || self.state.is_used(lane) {
            self.copy_lane(lane, &Self::ZERO, 0);
        }
    }

    /// Copies a lane from another block, which may be asleep.
    pub fn take_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
        match from.awake {
            1 => self.copy_lane(lane, from, from_lane),
            _ => {
                self.clear(lane);
                self.state.copy_lane(lane, &from.state, from_lane);
            }
        }
    }
}

impl MotionBlock {
    pub const ZERO: Self = Self {
        name: [0; LANES],
        segment: [SCHEDULED; LANES],
        first: [0; LANES],
        length: [0; LANES],
        time: [0.0; LANES],
        clip_to_world: [[0.0; LANES]; 3],
        root: [[0.0; LANES]; 3],
        floor: [0.0; LANES],
        lift: [0.0; LANES],
        drift: [[0.0; LANES]; 3],
        turn: [0.0; LANES],
        drift_from: [0.0; LANES],
        bend: [0.0; LANES],
        pace: [pace::NORMAL; LANES],
        wait: [0.0; LANES],
        blocked: [0; LANES],
        age_s: [f32::INFINITY; LANES],
        num_choices: [0; LANES],
        choice_state: [NO_STATE; LANES],
        choice_root: [[0.0; LANES]; 3],
        contacts: [Contacts::NONE; LANES],
        change: [[0; LANES]; 2],
    };

    /// Planar root of one lane at the last step.
    pub fn root(&self, lane: usize) -> Planar {
        planar_of_lane(&self.root, lane)
    }

    /// Frame rows that play.
    pub fn frame_rows(&self) -> [u32; LANES] {
        std::array::from_fn(|lane| self.first[lane] + self.time[lane].max(0.0) as u32)
    }

    /// Planar root of one lane at its segment's first frame.
    pub fn choice_root(&self, lane: usize) -> Planar {
        planar_of_lane(&self.choice_root, lane)
    }

    /// Planar transform from the clip to the world of one lane.
    pub fn clip_to_world(&self, lane: usize) -> Planar {
        planar_of_lane(&self.clip_to_world, lane)
    }

    /// Drift of one lane per frame (m/frame).
    pub fn drift_per_frame(&self, lane: usize) -> Vec3 {
        get_lane(&self.drift, lane)
    }

    /// Height of the clip's ground in one lane at a time within what it plays (m).
    pub fn lift_at(&self, lane: usize, time: f32) -> f32 {
        self.lift[lane] + self.drift[1][lane] * (time - self.drift_from[lane])
    }

    /// Planar root of one lane at the end of what it plays.
    pub fn root_at_end(&self, lane: usize, motion_set: &MotionSet) -> Planar {
        let last = motion_set.planar_root(self.first[lane] + self.length[lane]);
        let (end, drift) = (self.clip_to_world(lane).compose(last), self.drift_per_frame(lane));
        let frames = self.length[lane] as f32 - self.drift_from[lane];
        let heading = end.heading + self.turn[lane] * frames;
        Planar::new(end.x + drift.x * frames, end.z + drift.z * frames, heading)
    }

    /// Places a character at the end of a segment, on the frame of the state there.
    pub fn start_at_state(&mut self, lane: usize, motion_set: &MotionSet, root: Planar, frame: u32, segment: u32) {
        self.set_segment(lane, segment, &motion_set.graph.segments[segment as usize]);
        self.time[lane] = self.length[lane] as f32;
        self.set_clip_to_world(lane, root.compose(motion_set.planar_root(frame).inverse()));
        let whole = motion_set.graph.segments[segment as usize].displacement();
        self.set_choice_root(lane, root.compose(whole.inverse()));
        set_lane(&mut self.root, lane, Vec3::new(root.x, root.z, root.heading));
    }

    /// Notes a transition from one frame row to another.
    pub fn set_change(&mut self, lane: usize, from: u32, to: u32) {
        self.change[0][lane] = from;
        self.change[1][lane] = to;
    }

    /// Plays a segment of the motion graph, which stands on the ground; time is left as it is.
    pub fn set_segment(&mut self, lane: usize, id: u32, segment: &MotionSegment) {
        self.segment[lane] = id;
        self.first[lane] = segment.start;
        self.length[lane] = segment.num_frames;
        self.lift[lane] = 0.0;
        set_lane(&mut self.drift, lane, Vec3::ZERO);
        self.turn[lane] = 0.0;
        self.drift_from[lane] = 0.0;
        self.bend[lane] = 0.0;
        self.pace[lane] = pace::NORMAL;
    }

    /// Replaces the planar root at the segment's first frame.
    pub fn set_choice_root(&mut self, lane: usize, to: Planar) {
        set_lane(&mut self.choice_root, lane, Vec3::new(to.x, to.z, to.heading));
    }

    /// Replaces it; the heading is wrapped.
    pub fn set_clip_to_world(&mut self, lane: usize, to: Planar) {
        set_lane(&mut self.clip_to_world, lane, Vec3::new(to.x, to.z, wrap_angle(to.heading)));
    }
}

lanewise_fields!(Offsets { rotation, rotation_velocity, root, root_velocity });
lanewise_fields!(MotionBlock {
    name,
    segment,
    first,
    length,
    time,
    clip_to_world,
    root,
    floor,
    lift,
    drift,
    turn,
    drift_from,
    bend,
    pace,
    wait,
    blocked,
    age_s,
    num_choices,
    choice_state,
    choice_root,
    contacts,
    change
});

impl Lanewise for BodyBlock {
    fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
        let Self { awake: _, unused: _, feet, offsets, state, fill: _ } = self;
        feet.copy_lane(lane, &from.feet, from_lane);
        offsets.copy_lane(lane, &from.offsets, from_lane);
        state.copy_lane(lane, &from.state, from_lane);
    }

    fn is_near(&self, lane: usize) -> bool {
        let Self { awake, unused: _, feet, offsets, state, fill: _ } = self;
        *awake <= 1 && feet.is_near(lane) && offsets.is_near(lane) && state.is_near(lane)
    }
}
