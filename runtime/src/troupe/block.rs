//! What a troupe remembers of eight characters, laid out so that one load fetches a number of all four.

use crate::contacts::Contacts;
use crate::lanes::{LANES, Lanes, V};
use crate::planar::{Planar, wrap_angle};
use crate::skeleton::NUM_JOINTS;
use glam::Vec3;

/// A number of each of eight characters.
pub(crate) type Lane = [f32; LANES];
/// A vector of each of eight characters: x, y, z.
pub(crate) type Lane3 = [Lane; 3];

/// Puts the vector of one lane.
pub(crate) fn set(v: &mut Lane3, lane: usize, to: Vec3) {
    for (axis, value) in v.iter_mut().zip(to.to_array()) {
        axis[lane] = value;
    }
}

/// Loads a vector of all lanes.
#[inline(always)]
pub(crate) fn load<F: Lanes>(v: &Lane3) -> V<F> {
    V::new(F::load(&v[0]), F::load(&v[1]), F::load(&v[2]))
}

/// Stores a vector of all lanes.
#[inline(always)]
pub(crate) fn store<F: Lanes>(v: &mut Lane3, from: V<F>) {
    from.x.store(&mut v[0]);
    from.y.store(&mut v[1]);
    from.z.store(&mut v[2]);
}

/// The inertial offsets of the last transition: what the pose differed by, and how fast that changed.
///
/// Rotation offsets are modified Rodrigues parameters, applied on the parent's side; their velocities are per second.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Offsets {
    pub rotation: [Lane3; NUM_JOINTS],
    pub rotation_velocity: [Lane3; NUM_JOINTS],
    /// Of the hips, in model space. [Unit: m, m/s]
    pub root: Lane3,
    pub root_velocity: Lane3,
}

impl Offsets {
    pub const ZERO: Self = Self {
        rotation: [[[0.0; LANES]; 3]; NUM_JOINTS],
        rotation_velocity: [[[0.0; LANES]; 3]; NUM_JOINTS],
        root: [[0.0; LANES]; 3],
        root_velocity: [[0.0; LANES]; 3],
    };
}

/// The lock of one foot of eight characters.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct FootLock {
    /// What is added to the foot's position, in world space. [Unit: m]
    pub correction: Lane3,
    /// Where ankle and toe were sampled at the last step, in world space. [Unit: m]
    pub ankle: Lane3,
    pub toe: Lane3,
    /// 1 where heel, toe were planted at the last step, else 0.
    pub heel_down: Lane,
    pub toe_down: Lane,
}

impl FootLock {
    pub const ZERO: Self = Self {
        correction: [[0.0; LANES]; 3],
        ankle: [[0.0; LANES]; 3],
        toe: [[0.0; LANES]; 3],
        heel_down: [0.0; LANES],
        toe_down: [0.0; LANES],
    };
}

/// Everything a troupe remembers of eight characters.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Segment that is played.
    pub segment: [u32; LANES],
    /// Time within it. [Unit: frames] [Limit: >= 0]
    pub time: Lane,
    /// Planar transform from the clip to the world: x, z, heading. [Unit: m, m, rad]
    pub clip_to_world: Lane3,
    /// Planar root in the world at the last step: x, z, heading. [Unit: m, m, rad]
    pub root: Lane3,
    /// How fast the action is bent. [Unit: rad/frame]
    pub bend: Lane,
    /// Time since the last transition. [Unit: s]
    pub age_s: Lane,
    /// Choices made so far.
    pub num_choices: [u32; LANES],
    /// Contacts at the last step.
    pub contacts: [Contacts; LANES],
    /// Left, right.
    pub feet: [FootLock; 2],
    pub offsets: Offsets,
}

impl Block {
    pub const ZERO: Self = Self {
        segment: [0; LANES],
        time: [0.0; LANES],
        clip_to_world: [[0.0; LANES]; 3],
        root: [[0.0; LANES]; 3],
        bend: [0.0; LANES],
        age_s: [f32::INFINITY; LANES],
        num_choices: [0; LANES],
        contacts: [Contacts::NONE; LANES],
        feet: [FootLock::ZERO; 2],
        offsets: Offsets::ZERO,
    };

    /// Planar root of one lane at the last step.
    pub fn root(&self, lane: usize) -> Planar {
        planar(&self.root, lane)
    }

    /// Planar transform from the clip to the world of one lane.
    pub fn clip_to_world(&self, lane: usize) -> Planar {
        planar(&self.clip_to_world, lane)
    }

    /// Replaces it; the heading is wrapped.
    pub fn set_clip_to_world(&mut self, lane: usize, to: Planar) {
        set(&mut self.clip_to_world, lane, Vec3::new(to.x, to.z, wrap_angle(to.heading)));
    }
}

fn planar(v: &Lane3, lane: usize) -> Planar {
    Planar::new(v[0][lane], v[1][lane], v[2][lane])
}
