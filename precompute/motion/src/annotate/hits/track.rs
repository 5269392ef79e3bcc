//! Motion of a limb over a clip, by which hits are found.

use crate::clip::Clip;
use glam::{Quat, Vec3};
use throng_core::{Joint, NUM_JOINTS, Skeleton, hits::striking_point};

/// Speeds are differences over at least this time on either side, so that thresholds mean the same at any rate.
/// (s)
const DIFFERENCE: f64 = 1.0 / 30.0;

/// World positions and rotations of the joints, by frame.
pub type Poses = [[(Vec3, Quat); NUM_JOINTS]];

/// The joints of a limb that strikes: shoulder or hip, elbow or knee, and the wrist or ankle that strikes.
pub type StrikingLimb = [Joint; 3];

/// Left and right leg.
pub const STRIKING_LEGS: [StrikingLimb; 2] = {
    use Joint::*;
    [[LeftThigh, LeftShin, LeftFoot], [RightThigh, RightShin, RightFoot]]
};

/// How one limb moves (num_frames each).
#[derive(Clone, Debug, PartialEq)]
pub struct LimbTrack {
    /// The tip of the fist or the ball of the foot, in the world (m).
    pub tips: Vec<Vec3>,
    /// Velocity of the tip in the world (m/s).
    pub velocities: Vec<Vec3>,
    /// Direction of forearm or shin, towards the end, of unit length.
    pub axes: Vec<Vec3>,
    /// Speed of the tip along that axis, relative to the hips' way over the ground (m/s).
    pub thrusts: Vec<f32>,
    /// Speed of the tip, relative to the hips' way over the ground (m/s).
    pub speeds: Vec<f32>,
    /// Distance from shoulder to wrist or hip to ankle, as a share of the limb's length.
    pub extensions: Vec<f32>,
}

impl LimbTrack {
    /// Follows a limb.
    pub fn new(poses: &Poses, skeleton: &Skeleton, [root, middle, end]: StrikingLimb, rate_hz: f64) -> Self {
        let tips: Vec<Vec3> = poses.iter().map(|p| tip(p, skeleton, end)).collect();
        let velocities = velocities(&tips, rate_hz);
        let path: Vec<Vec3> = poses.iter().map(|p| p[0].0.with_y(0.0)).collect();
        let own: Vec<Vec3> = velocities.iter().zip(self::velocities(&path, rate_hz)).map(|(v, w)| *v - w).collect();
        let at = |pose: &[(Vec3, Quat); NUM_JOINTS], j: Joint| pose[j.index()].0;
        let axes: Vec<Vec3> = poses.iter().map(|p| (at(p, end) - at(p, middle)).normalize_or_zero()).collect();
        let length: f32 = [middle, end].iter().map(|j| skeleton.offsets[j.index()].length()).sum();
        Self {
            thrusts: own.iter().zip(&axes).map(|(v, axis)| v.dot(*axis)).collect(),
            speeds: own.iter().map(|v| v.length()).collect(),
            extensions: poses.iter().map(|p| at(p, end).distance(at(p, root)) / length.max(1e-6)).collect(),
            tips,
            velocities,
            axes,
        }
    }
}

/// World position of a joint's striking point, in one pose (m).
pub fn tip(pose: &[(Vec3, Quat); NUM_JOINTS], skeleton: &Skeleton, joint: Joint) -> Vec3 {
    let (at, turn) = pose[joint.index()];
    striking_point(skeleton, joint, at, turn)
}

/// Velocities by central differences, one-sided at the ends (m/s, num_frames).
pub fn velocities(positions: &[Vec3], rate_hz: f64) -> Vec<Vec3> {
    (0..positions.len()).map(|f| velocity(&|f| positions[f], positions.len(), f, rate_hz)).collect()
}

/// Velocity at one of `num` frames, as [`velocities`] measures it.
pub fn velocity(position: &impl Fn(usize) -> Vec3, num: usize, frame: usize, rate_hz: f64) -> Vec3 {
    let reach = ((DIFFERENCE * rate_hz).round() as usize).max(1);
    let (a, b) = (frame.saturating_sub(reach), (frame + reach).min(num - 1));
    (position(b) - position(a)) * (rate_hz as f32 / (b - a).max(1) as f32)
}

/// World positions and rotations of all joints at every frame of a clip.
pub fn poses(clip: &Clip, skeleton: &Skeleton) -> Vec<[(Vec3, Quat); NUM_JOINTS]> {
    (0..clip.num_frames()).map(|f| clip.joint_transforms(skeleton, f)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocities_are_the_same_at_any_rate() {
        for rate in [24.0, 30.0, 60.0, 120.0] {
            let path: Vec<Vec3> = (0..100).map(|f| Vec3::X * (f as f32 / rate as f32)).collect();
            assert!(velocities(&path, rate).iter().all(|v| (*v - Vec3::X).length() < 1e-4), "{rate} Hz");
        }
        assert_eq!(velocities(&[Vec3::X], 30.0), [Vec3::ZERO]);
        assert!(velocities(&[], 30.0).is_empty());
    }
}
