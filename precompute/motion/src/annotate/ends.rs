//! The ends of clips that are not motion: calibration T-poses with the way out of them, and stillness.

use super::contacts::speeds;
use crate::clip::{Clip, Exclusion, ExclusionReason};
use crate::error::{Result, check_ranges};
use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::thresholds::{BODY_STILL_MPS, POSE_HELD_MPS};
use throng_core::{Joint, NUM_JOINTS, Skeleton, skeleton::ARMS};

/// Frames to leave out at the ends of clips.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EndsConfig {
    /// Leave out T-poses and the way into or out of them.
    pub t_pose: bool,
    /// Leave out stillness.
    pub still: bool,
    /// Distance from the clip's end within which a T-pose is searched for (s).
    pub t_pose_within: f32,
    /// Least time of stillness (s).
    pub still_duration: f32,
    /// Speed of the fastest joint below which a body stands still (m/s).
    pub still_speed: f32,
    /// Still frames kept next to the motion, so that standing remains in the database (s).
    pub still_keep: f32,
}

impl Default for EndsConfig {
    fn default() -> Self {
        Self {
            t_pose: true,
            still: true,
            t_pose_within: 1.0,
            still_duration: 0.5,
            still_speed: BODY_STILL_MPS,
            still_keep: 0.3,
        }
    }
}

impl EndsConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`crate::error::BuildError::Key`] names the first one out of it.
    pub fn check(&self) -> Result<()> {
        check_ranges([
            ("t_pose_within", self.t_pose_within, 0.0, 1e4),
            ("still_duration", self.still_duration, 0.0, 1e4),
            ("still_speed", self.still_speed, 0.0, 100.0),
            ("still_keep", self.still_keep, 0.0, 1e4),
        ])
    }
}

/// Angle of arms from straight out to the side above which the T-pose is left (rad).
const ARMS_OUT: f32 = 0.6;

/// Turning speed away from the side below which arms have arrived (rad/s).
const ARRIVED_SPEED: f32 = 0.6;

/// Distance from a clip's end within which a pose counts as the one that the clip is cut in (s).
const EDGE: f32 = 0.1;

/// Least time for which T-poses further inside are held (s).
const MIN_HOLD: f32 = 0.1;

/// Longest way out of a T-pose (s).
const MAX_WAY_OUT: f32 = 2.0;

/// The frames at the clip's start and end that are no motion.
pub fn find_unusable_ends(clip: &Clip, skeleton: &Skeleton, cfg: &EndsConfig) -> Vec<Exclusion> {
    let n = clip.num_frames();
    let poses: Vec<[Vec3; NUM_JOINTS]> = (0..n).map(|f| clip.joint_positions(skeleton, f)).collect();
    let fastest = fastest_joint(&poses, clip.rate_hz);
    let mut out = Vec::new();
    for from_end in [false, true] {
        // Frames are counted from the end that is searched.
        let at = |k: usize| if from_end { n - 1 - k } else { k };
        let mut add = |range: std::ops::Range<usize>, reason| {
            if !range.is_empty() {
                let range = if from_end { n - range.end..n - range.start } else { range };
                out.push(Exclusion { range, reason });
            }
        };
        let posed = if cfg.t_pose { t_pose_frames(&poses, &fastest, at, clip.rate_hz, cfg) } else { 0 };
        add(0..posed, ExclusionReason::TPose);
        let still = (posed..n).take_while(|&k| fastest[at(k)] < cfg.still_speed).count();
        let seconds = |s: f32| (s as f64 * clip.rate_hz).round() as usize;
        if cfg.still && still >= seconds(cfg.still_duration).max(1) {
            add(posed..posed + still.saturating_sub(seconds(cfg.still_keep)), ExclusionReason::Still);
        }
    }
    out.sort_by_key(|e| e.range.start);
    cut_overlaps(out)
}

/// Cuts from exclusions, in the order of their starts, what earlier ones exclude, so that no frame is excluded twice.
pub fn cut_overlaps(sorted: Vec<Exclusion>) -> Vec<Exclusion> {
    let mut out: Vec<Exclusion> = Vec::new();
    for Exclusion { range, reason } in sorted {
        let range = out.last().map_or(0, |l| l.range.end).max(range.start)..range.end;
        if !range.is_empty() {
            out.push(Exclusion { range, reason });
        }
    }
    out
}

/// Speed of the fastest joint at each frame (m/s).
fn fastest_joint(poses: &[[Vec3; NUM_JOINTS]], rate_hz: f64) -> Vec<f32> {
    let mut out = vec![0.0f32; poses.len()];
    for j in 0..NUM_JOINTS {
        let track: Vec<Vec3> = poses.iter().map(|p| p[j]).collect();
        out.iter_mut().zip(speeds(&track, rate_hz)).for_each(|(o, s)| *o = o.max(s));
    }
    out
}

/// Number of frames, counted by `at` from one end, up to where the arms have come down from a T-pose.
fn t_pose_frames(
    poses: &[[Vec3; NUM_JOINTS]],
    fastest: &[f32],
    at: impl Fn(usize) -> usize,
    rate_hz: f64,
    cfg: &EndsConfig,
) -> usize {
    let n = poses.len();
    let seconds = |s: f32| (s as f64 * rate_hz).round() as usize;
    let searched = seconds(cfg.t_pose_within).max(1).min(n);
    let pose = |k: usize| t_pose(&poses[at(k)]);
    let speed = |k: usize| fastest[at(k)];
    let cut = |k: usize| match pose(k) {
        TPose::Full => speed(k) < 2.5 * POSE_HELD_MPS,
        TPose::Half => speed(k) < POSE_HELD_MPS,
        TPose::No => false,
    };
    let hold = seconds(MIN_HOLD).max(1);
    let held = |k: usize| k + hold <= n && (k..k + hold).all(|k| pose(k) == TPose::Full && speed(k) < POSE_HELD_MPS);
    let edge = seconds(EDGE).min(n);
    let Some(first) = (0..edge).find(|&k| cut(k)).or_else(|| (0..searched).find(|&k| held(k))) else { return 0 };
    let last = (first..n).take_while(|&k| pose(k) != TPose::No).last().unwrap_or(first);
    let limit = (last + seconds(MAX_WAY_OUT)).min(n);
    let ways_out = (0..2).map(|side| {
        let angle = |k: usize| angle_from_side(&poses[at(k)], side);
        let arrived = |k: &usize| angle(*k) > ARMS_OUT && (angle(*k) - angle(k - 1)) * (rate_hz as f32) < ARRIVED_SPEED;
        (last + 1..limit).find(arrived).unwrap_or(limit)
    });
    ways_out.max().unwrap_or(limit)
}

/// Angle between an arm, shoulder to hand, and the shoulders' line outwards (rad).
fn angle_from_side(pose: &[Vec3; NUM_JOINTS], side: usize) -> f32 {
    let arms = arms(pose);
    let (shoulder, _, hand) = arms[side];
    (hand - shoulder).angle_between(shoulder - arms[1 - side].0)
}

/// Shoulder, elbow and hand of both arms.
fn arms(pose: &[Vec3; NUM_JOINTS]) -> [(Vec3, Vec3, Vec3); 2] {
    ARMS.map(|[a, b, c]| (pose[a.index()], pose[b.index()], pose[c.index()]))
}

/// Degree to which a pose is a T-pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TPose {
    /// Upright on straight legs, both arms straight and about level out to the sides.
    Full,
    /// Only one arm is straight and about level: markers are often not labelled yet.
    Half,
    /// Something else.
    No,
}

fn t_pose(pose: &[Vec3; NUM_JOINTS]) -> TPose {
    use Joint::*;
    let at = |j: Joint| pose[j.index()];
    let direction = |a: Joint, b: Joint| (at(b) - at(a)).normalize_or_zero();
    let upright = direction(Hips, Neck).y > 0.9;
    let legs = direction(LeftThigh, LeftFoot).y < -0.9 && direction(RightThigh, RightFoot).y < -0.9;
    let left = direction(RightUpperArm, LeftUpperArm);
    let out = arms(pose).map(|(shoulder, elbow, hand)| {
        let upper = (elbow - shoulder).normalize_or_zero();
        let lower = (hand - elbow).normalize_or_zero();
        let whole = (hand - shoulder).normalize_or_zero();
        (-0.6..0.45).contains(&whole.y) && upper.dot(lower) > 0.8 && whole.dot(left).abs() > 0.8
    });
    match (upright && legs, out) {
        (true, [true, true]) => TPose::Full,
        (true, [true, false] | [false, true]) => TPose::Half,
        _ => TPose::No,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    /// Frames with the arms lowered by the given angles, standing; the root moves where `speed` says.
    fn clip(angles: &[f32], speed: &[f32]) -> Clip {
        let s = Skeleton::default();
        let mut z = 0.0;
        let mut rotations = vec![Quat::IDENTITY; angles.len() * NUM_JOINTS];
        for (f, a) in angles.iter().enumerate() {
            rotations[f * NUM_JOINTS + Joint::LeftUpperArm.index()] = Quat::from_rotation_z(-a);
            rotations[f * NUM_JOINTS + Joint::RightUpperArm.index()] = Quat::from_rotation_z(*a);
        }
        let root_positions = speed.iter().map(|v| {
            z += v / 30.0;
            s.offsets[0] + Vec3::Z * z
        });
        Clip::new("c", 30.0, root_positions.collect(), rotations)
    }

    #[test]
    fn a_t_pose_is_left_out_with_the_way_out_of_it() {
        let angles: Vec<f32> =
            (0..120).map(|f| if f < 30 { 0.0 } else { ((f - 30) as f32 / 20.0).min(1.0) * 1.3 }).collect();
        let c = clip(&angles, &[0.2; 120]);
        let found = find_unusable_ends(&c, &Skeleton::default(), &EndsConfig::default());
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].reason, ExclusionReason::TPose);
        assert_eq!(found[0].range.start, 0);
        assert!((49..=52).contains(&found[0].range.end), "{found:?}");
        let mut back: Vec<f32> = angles;
        back.reverse();
        let found = find_unusable_ends(&clip(&back, &[0.2; 120]), &Skeleton::default(), &EndsConfig::default());
        assert_eq!((found.len(), found[0].range.end), (1, 120));
        assert!((68..=71).contains(&found[0].range.start), "{found:?}");
    }

    #[test]
    fn stillness_is_left_out_at_the_ends_and_kept_in_the_middle() {
        let mut speed = [0.0; 200];
        speed[40..80].fill(1.0);
        speed[120..150].fill(1.0);
        let c = clip(&[1.4; 200], &speed);
        let found = find_unusable_ends(&c, &Skeleton::default(), &EndsConfig::default());
        let ranges: Vec<_> = found.iter().map(|e| (e.range.clone(), e.reason)).collect();
        // Speeds are central differences: the frame before the first step moves already.
        assert_eq!(ranges, [(0..30, ExclusionReason::Still), (159..200, ExclusionReason::Still)]);
    }

    #[test]
    fn a_short_pause_is_kept() {
        let mut speed = [1.0; 60];
        speed[..10].fill(0.0);
        assert!(find_unusable_ends(&clip(&[1.4; 60], &speed), &Skeleton::default(), &EndsConfig::default()).is_empty());
    }

    #[test]
    fn a_clip_of_nothing_else_is_left_out_once() {
        let found = find_unusable_ends(&clip(&[0.0; 50], &[0.0; 50]), &Skeleton::default(), &EndsConfig::default());
        assert_eq!(found, [Exclusion { range: 0..50, reason: ExclusionReason::TPose }]);
    }
}
