//! Looking at a point: head, neck and chest turn from where the motion has them, within limits. `tests/bodies.rs` tests it.

use super::{lane_body::LaneBody, lanes::get_lane, sample::LanePose, upper::LayerTick};
use crate::{planar::wrap_angle, skeleton::Joint};
use bytemuck::Zeroable;
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use throng_base::{maths, simd::Lanes};

/// Largest angles of the gaze to a side and up or down of where the body faces (rad).
const RANGE: [f32; 2] = [70.0 * RADIANS, 35.0 * RADIANS];
const RADIANS: f32 = std::f32::consts::PI / 180.0;
/// Distance from the head below which a point is not looked at (m).
const NEAR_M: f32 = 0.2;
/// Fastest turn, and most that it changes (rad/s, rad/s^2).
const RATE: f32 = 4.0;
const ACCELERATION: f32 = 40.0;
/// Angles and rates that cannot be seen (rad, rad/s).
const NONE: f32 = 1e-4;
/// Shares of the turn that chest and neck have; the head has all of it.
const CHEST: f32 = 0.2;
const NECK: f32 = 0.55;

/// Joints from the hips to the head.
const CHAIN: [Joint; 6] = [Joint::Hips, Joint::Spine, Joint::Chest, Joint::UpperChest, Joint::Neck, Joint::Head];

/// Turn of a character's gaze from where its motion faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct Gaze {
    /// Angles to the left and up (rad).
    off: [f32; 2],
    /// Rates of the angles (rad/s).
    rate: [f32; 2],
}

/// The trunk of a pose in model space.
struct GazeTrunk {
    /// World rotations of the chain.
    rotations: [Quat; 6],
    offsets: [Vec3; 6],
    /// (m)
    hips: Vec3,
}

impl Gaze {
    /// A gaze that follows the motion.
    pub const ZERO: Self = Self { off: [0.0; 2], rate: [0.0; 2] };

    /// True where head and motion agree.
    #[inline(always)]
    pub fn is_off(&self) -> bool {
        *self == Self::ZERO
    }

    /// Follows a point and turns the pose of one lane towards it.
    ///
    /// - `point`: in model space (m).
    /// - `still`: how little the chest may turn, 0 to 1: what the arms do is meant to be where it is.
    pub fn turn_pose<F: Lanes>(
        &mut self,
        tick: &LayerTick<'_>,
        point: Option<Vec3>,
        body: &LaneBody,
        lane: usize,
        still: f32,
        pose: &mut LanePose<F>,
    ) {
        let trunk = GazeTrunk::from_pose(pose, body, lane);
        let chest = CHEST * (1.0 - still);
        let forward = direction(maths::rotate(trunk.rotations[5], Vec3::Z));
        let to = point.and_then(|p| {
            let to = p - trunk.head(self.off, chest, forward);
            let [yaw, pitch] = direction(to);
            let seen = yaw.abs() < RANGE[0] && pitch.abs() < RANGE[1] && to.length() > NEAR_M;
            seen.then(|| [wrap_angle(yaw - forward[0]), pitch - forward[1]])
        });
        self.follow(tick, to.unwrap_or_default());
        let turned = trunk.turned(self.off, chest, forward);
        for k in 3..6 {
            let local = maths::compose(turned[k - 1].conjugate(), turned[k]);
            pose.set_rotation(CHAIN[k].index(), lane, maths::normalize_or_identity(local));
        }
    }

    fn follow(&mut self, tick: &LayerTick<'_>, to: [f32; 2]) {
        for ((off, rate), to) in self.off.iter_mut().zip(&mut self.rate).zip(to) {
            tick.follow(off, rate, to, [RATE, ACCELERATION]);
        }
        if to == [0.0; 2] && self.off.iter().chain(&self.rate).all(|v| v.abs() < NONE) {
            *self = Self::ZERO;
        }
    }

    /// True where its numbers can be.
    pub fn is_sound(&self) -> bool {
        self.off.iter().all(|v| v.abs() < 10.0) && self.rate.iter().all(|v| v.abs() <= RATE)
    }
}

impl GazeTrunk {
    fn from_pose<F: Lanes>(pose: &LanePose<F>, body: &LaneBody, lane: usize) -> Self {
        let mut rotations = CHAIN.map(|j| pose.rotation(j.index(), lane));
        (1..6)
            .for_each(|k| rotations[k] = maths::normalize_or_identity(maths::compose(rotations[k - 1], rotations[k])));
        let offsets = CHAIN.map(|j| get_lane(&body.offsets[j.index()], lane));
        let hips = [pose.root.x, pose.root.y, pose.root.z].map(|axis| axis.to_array()[lane]);
        Self { rotations, offsets, hips: Vec3::from_array(hips) }
    }

    /// The chain, turned from where its end faces.
    fn turned(&self, off: [f32; 2], chest: f32, forward: [f32; 2]) -> [Quat; 6] {
        let mut out = self.rotations;
        for (k, share) in [(3, chest), (4, NECK), (5, 1.0)] {
            let [yaw, pitch] = off.map(|v| v * share);
            let turn = maths::compose(maths::rotation_y(forward[0] + yaw), maths::rotation_x(-pitch));
            out[k] = maths::compose(maths::compose(turn, maths::rotation_y(-forward[0])), out[k]);
        }
        out
    }

    /// Position of the head for a turn (m).
    fn head(&self, off: [f32; 2], chest: f32, forward: [f32; 2]) -> Vec3 {
        let turned = self.turned(off, chest, forward);
        (1..6).fold(self.hips, |at, k| at + maths::rotate(turned[k - 1], self.offsets[k]))
    }
}

/// Angles to the left and up of a direction (rad).
fn direction(v: Vec3) -> [f32; 2] {
    [maths::atan2(v.x, v.z), maths::atan2(v.y, maths::hypot(v.x, v.z))]
}
