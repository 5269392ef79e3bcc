//! What a troupe remembers of four characters, laid out so that one load fetches a number of all four.

use crate::lanes::{F4, LANES, V4};
use crate::skeleton::NUM_JOINTS;
use glam::Vec3;

/// A number of each of four characters.
pub(crate) type Lane = [f32; LANES];
/// A vector of each of four characters: x, y, z.
pub(crate) type Lane3 = [Lane; 3];

/// Puts the vector of one lane.
pub(crate) fn set(v: &mut Lane3, lane: usize, to: Vec3) {
    for (axis, value) in v.iter_mut().zip(to.to_array()) {
        axis[lane] = value;
    }
}

/// Loads a vector of all lanes.
#[inline(always)]
pub(crate) fn load(v: &Lane3) -> V4 {
    V4::new(F4::load(&v[0]), F4::load(&v[1]), F4::load(&v[2]))
}

/// Stores a vector of all lanes.
#[inline(always)]
pub(crate) fn store(v: &mut Lane3, from: V4) {
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

    /// Forgets one lane.
    pub fn clear(&mut self, lane: usize) {
        for v in self.rotation.iter_mut().chain(&mut self.rotation_velocity) {
            set(v, lane, Vec3::ZERO);
        }
        set(&mut self.root, lane, Vec3::ZERO);
        set(&mut self.root_velocity, lane, Vec3::ZERO);
    }
}

/// The lock of one foot of four characters.
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

    /// Forgets one lane: nothing is planted, so nothing holds at the next step.
    pub fn clear(&mut self, lane: usize) {
        set(&mut self.correction, lane, Vec3::ZERO);
        self.heel_down[lane] = 0.0;
        self.toe_down[lane] = 0.0;
    }
}

/// Everything of four characters that a step reads and writes beside the scalars of `Troupe`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Time since the last transition. [Unit: s]
    pub age_s: Lane,
    /// Left, right.
    pub feet: [FootLock; 2],
    pub offsets: Offsets,
}

impl Block {
    pub const ZERO: Self = Self { age_s: [f32::INFINITY; LANES], feet: [FootLock::ZERO; 2], offsets: Offsets::ZERO };
}
