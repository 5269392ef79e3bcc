//! Steps of struck characters away from hard blows: the action in that direction that begins most like the current pose.

use super::config::{StaggerConfig, check_within};
use glam::{Vec2, Vec3};
use throng_base::{Result, maths};
use throng_core::characters::{Blow, MotionSet, SampleJob};
use throng_core::skeleton::{Joint, NUM_JOINTS};
use throng_core::{Mat3x4, Planar};

/// Joints that poses are compared by.
const COMPARED_JOINTS: [Joint; 6] =
    [Joint::Head, Joint::Hips, Joint::LeftHand, Joint::RightHand, Joint::LeftFoot, Joint::RightFoot];
/// Least and largest length of a step away (m).
const STEP_LENGTH_M: [f32; 2] = [0.2, 0.9];
/// Least cosine of the angle between a step away and the blow (1).
const ASIDE: f32 = 0.5;
/// Cost of a metre of wrong step length, in metres of pose difference (1).
const LENGTH_WEIGHT: f32 = 0.3;
/// Difference in pose by which a step along the blow may be worse than one at a right angle (m).
const STRAIGHT_M: f32 = 0.2;

impl StaggerConfig {
    pub(super) fn check(&self) -> Result<()> {
        check_within("stagger.force", self.force, 0.0, 10.0, "between 0 and 10")?;
        check_within("stagger.alike_m", self.alike_m, 0.0, 1.0, "between 0 and 1")
    }
}

/// Action that can serve as a step away.
#[derive(Clone, Copy, Debug)]
struct StepAway {
    segment: u32,
    /// Direction of the step, of unit length.
    direction: Vec2,
    /// Length of the step (m).
    length_m: f32,
    /// Positions of the compared joints at its beginning, relative to the planar root (m).
    joint_positions: [Vec3; COMPARED_JOINTS.len()],
}

/// All actions without a blow that can serve as steps away.
#[derive(Clone, Debug, Default)]
pub(crate) struct StepsAway(Vec<StepAway>);

impl StepsAway {
    /// # Errors
    /// As [`SampleJob::run`].
    pub fn new(motion_set: &MotionSet) -> Result<Self> {
        let mut steps = Vec::new();
        for (i, segment) in motion_set.graph().segments.iter().enumerate() {
            let [x, z, _] = segment.displacement;
            let offset = Vec2::new(x, z);
            if !(STEP_LENGTH_M[0]..STEP_LENGTH_M[1]).contains(&offset.length())
                || motion_set.hits_of(i as u32).next().is_some()
            {
                continue;
            }
            let mut pose = [Mat3x4::default(); NUM_JOINTS];
            let (frames, ratios) = (&[segment.start], &[0.0]);
            SampleJob { motion_set, frames, ratios, matrices: &mut pose }.run()?;
            let looks = COMPARED_JOINTS.map(|j| pose[j.index()].translation());
            let (direction, length_m) = (offset.normalize(), offset.length());
            steps.push(StepAway { segment: i as u32, direction, length_m, joint_positions: looks });
        }
        Ok(Self(steps))
    }

    /// Best step away of a struck character; `None` where no action leads there from a similar pose.
    ///
    /// The stronger the blow, the longer the step.
    pub fn best_step(&self, config: &StaggerConfig, pose: &[Mat3x4], root: Planar, blow: &Blow) -> Option<u32> {
        let local = maths::rotate(root.rotation().conjugate(), blow.direction);
        let [shortest, longest] = STEP_LENGTH_M;
        let strength = (blow.force - config.force) / (1.0 - config.force).max(0.01);
        let length_m = shortest + (longest - shortest) * strength.clamp(0.0, 1.0);
        let along = Vec2::new(local.x, local.z).try_normalize()?;
        let looks = COMPARED_JOINTS.map(|j| pose[j.index()].translation());
        let steps = self.0.iter().filter_map(|step| {
            let straight = step.direction.dot(along);
            let sum: f32 = looks.iter().zip(&step.joint_positions).map(|(a, b)| a.distance(*b)).sum();
            let off = sum / COMPARED_JOINTS.len() as f32;
            let is_fit = straight >= ASIDE && off <= config.alike_m;
            let other_length = LENGTH_WEIGHT * (step.length_m - length_m).abs();
            is_fit.then_some((off + STRAIGHT_M * (1.0 - straight) + other_length, step.segment))
        });
        steps.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, segment)| segment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stronger_the_blow_the_longer_the_step() {
        let step = |(segment, length_m): (u32, f32)| StepAway {
            segment,
            direction: Vec2::Y,
            length_m,
            joint_positions: [Vec3::ZERO; COMPARED_JOINTS.len()],
        };
        let steps = StepsAway([(3, 0.25), (5, 0.5), (9, 0.85)].map(step).to_vec());
        let (pose, config) = ([Mat3x4::default(); NUM_JOINTS], StaggerConfig::default());
        let best = |force: f32| {
            let blow = Blow { direction: Vec3::Z, force, ..Blow::NONE };
            steps.best_step(&config, &pose, Planar::IDENTITY, &blow)
        };
        let middle = 0.5 * (config.force + 1.0);
        assert_eq!([config.force, middle, 1.0].map(best), [Some(3), Some(5), Some(9)]);
    }
}
