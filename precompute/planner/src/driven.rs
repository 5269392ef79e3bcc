//! Bodies that an external motion drives: transforms of all joints over time (c^M(t) in the paper).

use crate::linkage::{Limb, LimbPose};
use crate::{problem::LimbState, rotation::Rigid, track::SampleTimes};
use glam::{DQuat, DVec3};
use throng_base::maths::slerp;
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_motion::Clip;

/// World transforms of all joints.
pub type JointPlaces = [Rigid; NUM_JOINTS];

/// Least sampling rate: between samples, joints are taken to move in straight lines (Hz).
const RATE_HZ: f64 = 120.0;

/// A body's motion, sampled finely enough that straight lines between samples will do.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenMotion {
    start_s: f64,
    step_s: f64,
    places: Vec<JointPlaces>,
    /// Rotations relative to the parents.
    turns: Vec<[DQuat; NUM_JOINTS]>,
    /// Largest distance of each joint from the straight line between samples (m).
    bend: [f64; NUM_JOINTS],
}

impl DrivenMotion {
    /// Samples the motion of a clip from `from_s` to `to_s`, clip time: between frames, the hips go straight and joints turn
    /// evenly.
    ///
    /// A time outside of the clip has its first or last pose.
    pub fn from_clip(clip: &Clip, skeleton: &Skeleton, from_s: f64, to_s: f64) -> Self {
        let parts = (RATE_HZ / clip.rate_hz).ceil().max(1.0);
        let step_s = 1.0 / (clip.rate_hz * parts);
        // Sample times are the clip's frames, so that these are exact.
        let first = (from_s / step_s).floor();
        let count = ((to_s / step_s).ceil() - first).max(0.0) as usize + 1;
        Self::from_function(first * step_s, step_s, count, skeleton, |t| interpolate_frame(clip, t))
    }

    /// A body that keeps one pose.
    ///
    /// - `root`: position of the hips (m).
    /// - `turns`: rotations relative to the parents, the hips' to the world.
    pub fn from_pose(skeleton: &Skeleton, root: DVec3, turns: [DQuat; NUM_JOINTS]) -> Self {
        Self::from_function(0.0, 1.0, 1, skeleton, |_| (root, turns))
    }

    /// Samples a function: position of the hips and rotations relative to the parents, the hips' to the world.
    ///
    /// - `step_s`: between samples (s, > 0); 1/120 s is fine enough for people.
    pub fn from_function(
        start_s: f64,
        step_s: f64,
        count: usize,
        skeleton: &Skeleton,
        pose: impl Fn(f64) -> (DVec3, [DQuat; NUM_JOINTS]),
    ) -> Self {
        let at = |i: f64| {
            let (root, turns) = pose(start_s + i * step_s);
            (place_joints(skeleton, root, &turns), turns)
        };
        let (places, turns): (Vec<_>, Vec<_>) = (0..count.max(1)).map(|i| at(i as f64)).unzip();
        let mut bend = [0.0f64; NUM_JOINTS];
        for (i, w) in places.windows(2).enumerate() {
            let (middle, _) = at(i as f64 + 0.5);
            for j in 0..NUM_JOINTS {
                let straight = w[0][j].lerp(&w[1][j], 0.5);
                bend[j] = bend[j].max((middle[j].position - straight.position).length());
            }
        }
        // An arc is farthest from its chord in the middle, apart from changes of speed on the way.
        Self { start_s, step_s, places, turns, bend: bend.map(|b| 1.5 * b) }
    }

    /// Times of the first and the last sample (s).
    pub fn window_s(&self) -> [f64; 2] {
        [self.start_s, self.start_s + self.step_s * (self.places.len() - 1) as f64]
    }

    /// Times of the samples.
    pub fn clock(&self) -> SampleTimes {
        SampleTimes::Even { start_s: self.start_s, step_s: self.step_s }
    }

    /// The samples.
    pub fn places(&self) -> &[JointPlaces] {
        &self.places
    }

    /// Largest distance of the joints that count from the straight lines between samples (m).
    pub fn bend_m(&self, counts: impl Fn(Joint) -> bool) -> f64 {
        Joint::ALL.into_iter().filter(|j| counts(*j)).map(|j| self.bend[j.index()]).fold(0.0, f64::max)
    }

    /// World transforms of one joint, sample by sample.
    pub fn joint_places(&self, joint: Joint) -> Vec<Rigid> {
        self.places.iter().map(|p| p[joint.index()]).collect()
    }

    /// State that the motion gives a limb at a time.
    pub fn limb_state(&self, limb: Limb, time_s: f64) -> LimbState {
        LimbState { pose: self.limb_pose(limb, time_s), time_s }
    }

    /// Pose that the motion gives a limb at a time (m^P(t) in the paper).
    pub fn limb_pose(&self, limb: Limb, t: f64) -> LimbPose {
        let at = ((t - self.start_s) / self.step_s).clamp(0.0, (self.turns.len() - 1) as f64);
        let i = (at as usize).min(self.turns.len().saturating_sub(2));
        let to = &self.turns[(i + 1).min(self.turns.len() - 1)];
        LimbPose(limb.joints().map(|j| slerp(self.turns[i][j.index()], to[j.index()], at - i as f64)))
    }
}

/// World transforms of a pose.
pub fn place_joints(skeleton: &Skeleton, root: DVec3, turns: &[DQuat; NUM_JOINTS]) -> JointPlaces {
    let mut out = [Rigid { position: root, rotation: turns[0] }; NUM_JOINTS];
    for joint in &Joint::ALL[1..] {
        let parent = joint.parent().map_or(0, Joint::index);
        let offset = skeleton.offsets[joint.index()].as_dvec3();
        out[joint.index()] = out[parent].compose(Rigid { position: offset, rotation: turns[joint.index()] });
    }
    out
}

fn interpolate_frame(clip: &Clip, t: f64) -> (DVec3, [DQuat; NUM_JOINTS]) {
    let last = clip.num_frames().saturating_sub(1);
    let at = (t * clip.rate_hz).clamp(0.0, last as f64);
    // A time on a frame gives this frame exactly, whatever the rounding.
    let at = if (at - at.round()).abs() < 1e-6 { at.round() } else { at };
    let (i, share) = (at as usize, at.fract());
    let next = (i + 1).min(last);
    let root = clip.root_positions[i].as_dvec3().lerp(clip.root_positions[next].as_dvec3(), share);
    let turn = |f: usize, j: usize| clip.frame_rotations(f)[j].as_dquat().normalize();
    let turns =
        std::array::from_fn(|j| if share == 0.0 { turn(i, j) } else { slerp(turn(i, j), turn(next, j), share) });
    (root, turns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::angle_between;
    use throng_synth::{SynthConfig, SynthSet, make_set};

    #[test]
    fn a_clip_is_where_its_frames_have_it() {
        let set = make_set(SynthSet::Walk, &SynthConfig { minutes: 0.2, clip_seconds: 12.0, ..SynthConfig::default() });
        let set = set.expect("a set");
        let (clip, skeleton) = (&set.clips[0], &set.skeleton);
        let driven = DrivenMotion::from_clip(clip, skeleton, 1.0, 3.0);
        assert!(driven.bend_m(|_| true) < 1e-3, "{}", driven.bend_m(|_| true));
        let [from, to] = driven.window_s();
        assert!((from - 1.0).abs() < 1e-9 && (to - 3.0).abs() < 1e-9);
        let arm = crate::linkage::Limb::LeftArm;
        for frame in [30, 47, 90] {
            let expected = clip.joint_transforms(skeleton, frame);
            let t = frame as f64 / clip.rate_hz;
            let sample = ((t - from) / (to - from) * (driven.places().len() - 1) as f64).round() as usize;
            for (place, (p, _)) in driven.places()[sample].iter().zip(expected) {
                assert!((place.position - p.as_dvec3()).length() < 1e-5);
            }
            let pose = driven.limb_pose(arm, t);
            let own = clip.frame_rotations(frame)[Joint::LeftForearm.index()].as_dquat();
            assert!(angle_between(pose.0[1], own) < 1e-3);
        }
    }

    #[test]
    fn a_still_body_is_one_sample() {
        let s = Skeleton::default();
        let driven = DrivenMotion::from_pose(&s, s.offsets[0].as_dvec3(), [DQuat::IDENTITY; NUM_JOINTS]);
        assert_eq!((driven.places().len(), driven.bend_m(|_| true)), (1, 0.0));
        assert_eq!(driven.limb_pose(crate::linkage::Limb::RightLeg, 5.0), LimbPose::REST);
    }
}
