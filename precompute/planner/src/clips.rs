//! Writing planned motion back into clips.

use crate::{linkage::Limb, planner::LimbMotion, rotation::angle_between, setup::ProblemError};
use throng_core::NUM_JOINTS;
use throng_motion::Clip;

/// Difference below which rotations stay as they are, to the bit (rad).
const SAME: f64 = 1e-6;

/// Replaces a limb's rotations of a clip from the first to the last frame of a motion; all else stays, to the bit.
///
/// - `start_s`: time of the clip's frame 0 in the motion's time (s).
///
/// # Errors
/// [`ProblemError::Invalid`] where the motion's frames are not the clip's.
pub fn with_motion(clip: &Clip, start_s: f64, limb: Limb, motion: &LimbMotion<'_>) -> Result<Clip, ProblemError> {
    let misfit = |found: String| {
        let (name, rate_hz, num_frames) = (&clip.name, clip.rate_hz, clip.num_frames());
        let expected = format!("frames of `{name}` ({rate_hz} Hz, {num_frames} frames)");
        ProblemError::Invalid(format!("expected motion on {expected}, found {found}"))
    };
    let first = (motion.start_s - start_s) * clip.rate_hz;
    if (first - first.round()).abs() > 1e-3 || (motion.step_s * clip.rate_hz - 1.0).abs() > 1e-6 {
        return Err(misfit(format!("frames every {} s from frame {first} on", motion.step_s)));
    }
    let first = first.round();
    if first < 0.0 || first as usize + motion.frames.len() > clip.num_frames() {
        return Err(misfit(format!("frames {first} to {}", first + motion.frames.len() as f64)));
    }
    let mut out = clip.clone();
    let joints = limb.joints();
    for (k, pose) in motion.frames.iter().enumerate() {
        let row = (first as usize + k) * NUM_JOINTS;
        for (joint, turn) in joints.iter().zip(pose.0) {
            let at = row + joint.index();
            if angle_between(out.rotations[at].as_dquat().normalize(), turn) > SAME {
                out.rotations[at] = turn.as_quat().normalize();
            }
        }
    }
    // Neighbouring frames keep a positive dot product, also behind the motion's end.
    for joint in joints {
        for frame in 1..out.num_frames() {
            let at = frame * NUM_JOINTS + joint.index();
            if out.rotations[at].dot(out.rotations[at - NUM_JOINTS]) < 0.0 {
                out.rotations[at] = -out.rotations[at];
            }
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linkage::{Limb, LimbPose};
    use crate::rotation::rotation_about;
    use glam::{DVec3, Quat, Vec3};

    #[test]
    fn only_the_limb_changes_and_only_in_its_frames() {
        let clip = Clip::new("c", 30.0, vec![Vec3::Y; 20], vec![Quat::IDENTITY; 20 * NUM_JOINTS]);
        let limb = Limb::LeftArm;
        let mut frames = vec![LimbPose::REST; 6];
        frames[2].0[1] = rotation_about(DVec3::Y, 0.3);
        let motion = LimbMotion { start_s: 5.0 / 30.0, step_s: 1.0 / 30.0, frames: &frames };
        let out = with_motion(&clip, 0.0, limb, &motion).expect("it fits");
        let changed: Vec<usize> = (0..out.rotations.len()).filter(|&i| out.rotations[i] != Quat::IDENTITY).collect();
        assert_eq!(changed, [7 * NUM_JOINTS + limb.joints()[1].index()]);
        let late = LimbMotion { start_s: 0.5, ..motion };
        assert!(with_motion(&clip, 0.0, limb, &late).unwrap_err().to_string().contains("frames 15 to 21"));
        let between = LimbMotion { start_s: 0.05, ..motion };
        assert!(with_motion(&clip, 0.0, limb, &between).is_err());
    }
}
