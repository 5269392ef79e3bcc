//! Pose of the whole body at an instant, and its conversion to a frame of a clip.

use super::{SynthConfig, foot::FootPose, leg::LegShape, side::LateralSide};
use glam::{DQuat, DVec3};
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton};
use throng_motion::clip::{Clip, ClipTag};

/// Least sample rate of the rigs, so that their filters do not depend on the clip's rate (Hz).
const WORKING_RATE: f64 = 120.0;

/// Samples of a rig: whole multiples of the clip's frames.
pub struct Samples {
    /// Times of the samples (s).
    pub times: Vec<f64>,
    /// Time between samples (s).
    pub dt: f64,
    /// Number of samples from one frame to the next.
    pub per_frame: usize,
}

impl Samples {
    /// Samples of a clip.
    pub fn for_clip(duration: f64, rate_hz: f64) -> Self {
        let per_frame = (WORKING_RATE / rate_hz).ceil() as usize;
        let dt = 1.0 / (rate_hz * per_frame as f64);
        let num_frames = (duration * rate_hz).floor() as usize + 1;
        let times = (0..(num_frames - 1) * per_frame + 1).map(|i| i as f64 * dt).collect();
        Self { times, dt, per_frame }
    }

    /// Samples `dt` apart, from 0 until a duration has passed (s).
    pub fn spaced(dt: f64, duration: f64) -> Self {
        let num = (duration / dt).ceil() as usize;
        Self { times: (0..=num).map(|i| i as f64 * dt).collect(), dt, per_frame: 1 }
    }

    /// Number of whole samples in a time.
    pub fn count_within(&self, seconds: f64) -> usize {
        (seconds / self.dt).round() as usize
    }

    /// Sample index of every frame, in order.
    pub fn frames(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.times.len()).step_by(self.per_frame)
    }
}

/// Rotations of one arm relative to their parents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmPose {
    /// Clavicle, relative to the upper chest.
    pub clavicle: DQuat,
    /// Upper arm, relative to the clavicle.
    pub upper_arm: DQuat,
    /// Forearm, relative to the upper arm.
    pub forearm: DQuat,
    /// Hand, relative to the forearm.
    pub hand: DQuat,
}

/// Pose of the whole body at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyPose {
    /// Hips joint in the world (m).
    pub root: DVec3,
    /// World rotation of the hips.
    pub hips: DQuat,
    /// World rotations of spine, chest, upper chest, neck and head.
    pub trunk: [DQuat; 5],
    /// Left and right arm.
    pub arms: [ArmPose; 2],
    /// Left and right foot.
    pub feet: [FootPose; 2],
    /// Directions of the knees, left and right.
    pub knees: [DVec3; 2],
}

/// Position of the upper chest joint of a body (m).
pub fn upper_chest(root: DVec3, hips: DQuat, trunk: &[DQuat; 5], skeleton: &Skeleton) -> DVec3 {
    let offset = |j: Joint| skeleton.offsets[j.index()].as_dvec3();
    root + hips * offset(Joint::Spine) + trunk[0] * offset(Joint::Chest) + trunk[1] * offset(Joint::UpperChest)
}

/// A clip without frames.
pub fn empty_clip(name: String, set: &str, cfg: &SynthConfig) -> Clip {
    Clip {
        source: format!("throng synth {set}, seed {}", cfg.seed),
        ..Clip::new(name, cfg.rate_hz, Vec::new(), Vec::new())
    }
}

/// Adds tags to a clip, in order.
///
/// - `spans`: name, begin and end of each (s).
pub fn add_tags<'a>(clip: &mut Clip, spans: impl IntoIterator<Item = (&'a str, f64, f64)>) {
    let (rate_hz, num_frames) = (clip.rate_hz, clip.num_frames());
    let at = |t: f64| ((t * rate_hz).round().max(0.0) as usize).min(num_frames);
    clip.tags.extend(spans.into_iter().map(|(name, from, to)| ClipTag { name: name.into(), range: at(from)..at(to) }));
    clip.tags.sort_by(|a, b| (a.range.start, a.range.end, &a.name).cmp(&(b.range.start, b.range.end, &b.name)));
}

/// Adds a pose to a clip.
///
/// - `held`: contacts other than those of the feet.
pub fn push_pose(clip: &mut Clip, pose: &BodyPose, held: Contacts, skeleton: &Skeleton) {
    let mut local = [DQuat::IDENTITY; NUM_JOINTS];
    local[Joint::Hips.index()] = pose.hips;
    pose_trunk(&mut local, pose);
    let mut contacts = held;
    for side in LateralSide::BOTH {
        let arm = &pose.arms[side.index()];
        for (joint, q) in side.arm().into_iter().zip([arm.clavicle, arm.upper_arm, arm.forearm, arm.hand]) {
            local[joint.index()] = q;
        }
        pose_leg(&mut local, side, pose, skeleton);
        contacts.insert(pose.feet[side.index()].contacts(side));
    }
    let last = clip.rotations.len().checked_sub(NUM_JOINTS);
    for (j, q) in local.into_iter().enumerate() {
        let q = q.as_quat().normalize();
        let flip = last.is_some_and(|l| clip.rotations[l + j].dot(q) < 0.0);
        clip.rotations.push(if flip { -q } else { q });
    }
    clip.root_positions.push(pose.root.as_vec3());
    clip.contacts.push(contacts);
}

fn pose_trunk(local: &mut [DQuat; NUM_JOINTS], pose: &BodyPose) {
    const CHAIN: [Joint; 5] = [Joint::Spine, Joint::Chest, Joint::UpperChest, Joint::Neck, Joint::Head];
    let mut parent = pose.hips;
    for (joint, world) in CHAIN.into_iter().zip(pose.trunk) {
        local[joint.index()] = parent.inverse() * world;
        parent = world;
    }
}

fn pose_leg(local: &mut [DQuat; NUM_JOINTS], side: LateralSide, pose: &BodyPose, skeleton: &Skeleton) {
    let [thigh, shin, ankle, toe] = side.leg();
    let foot = &pose.feet[side.index()];
    let hip = pose.root + pose.hips * skeleton.offsets[thigh.index()].as_dvec3();
    let leg = LegShape::from_skeleton(skeleton).solve(hip, foot.ankle, pose.knees[side.index()]);
    let knee = DQuat::from_rotation_x(leg.knee);
    local[thigh.index()] = pose.hips.inverse() * leg.thigh;
    local[shin.index()] = knee;
    local[ankle.index()] = (leg.thigh * knee).inverse() * foot.rotation();
    local[toe.index()] = DQuat::from_rotation_x(foot.toe_pitch - foot.pitch);
}
