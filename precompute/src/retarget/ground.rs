//! Where the ground is: one height per clip, so that the feet stand on y = 0.

use super::transfer::Motion;
use glam::Vec3;
use throng_runtime::{Joint, NUM_JOINTS, Skeleton};

/// The lowest part of the feet may be standing where it is slower than this. [Unit: m/s]
const STANDING_SPEED: f32 = 0.4;

/// Which of the sorted heights of standing feet counts as the ground: low, because feet also stand on things.
const GROUND_QUANTILE: f32 = 0.25;

/// Height of the ground under a clip. [Unit: m]
///
/// At every frame the lowest of ankles and toes is taken, measured from where that joint is when the foot stands
/// flat; among the frames where it hardly moves, the lower quartile is the ground. A single bad frame, jumps and
/// uneven ground leave that in place.
pub fn height(motion: &Motion, skeleton: &Skeleton, rate_hz: f64) -> f32 {
    let rest = skeleton.rest_positions();
    let feet = [Joint::LeftFoot, Joint::LeftToe, Joint::RightFoot, Joint::RightToe].map(Joint::index);
    let mut standing = Vec::new();
    let mut all = Vec::new();
    let mut before: Option<[Vec3; 4]> = None;
    for (frame, root) in motion.root_positions.iter().enumerate() {
        let local = &motion.rotations[frame * NUM_JOINTS..(frame + 1) * NUM_JOINTS];
        let at = foot_positions(*root, local, skeleton);
        let clearance = |i: usize| at[i].y - rest[feet[i]].y;
        let lowest = (0..4).min_by(|&a, &b| clearance(a).total_cmp(&clearance(b))).unwrap_or(0);
        all.push(clearance(lowest));
        if before.is_some_and(|b| (at[lowest] - b[lowest]).length() * (rate_hz as f32) < STANDING_SPEED) {
            standing.push(clearance(lowest));
        }
        before = Some(at);
    }
    let heights = if standing.is_empty() { &mut all } else { &mut standing };
    heights.sort_by(f32::total_cmp);
    let last = heights.len().saturating_sub(1);
    heights.get((last as f32 * GROUND_QUANTILE) as usize).copied().unwrap_or(0.0)
}

/// World positions of left ankle, left toe, right ankle, right toe.
fn foot_positions(root: Vec3, local: &[glam::Quat], skeleton: &Skeleton) -> [Vec3; 4] {
    use Joint::*;
    let mut out = [Vec3::ZERO; 4];
    for (side, chain) in
        [[LeftThigh, LeftShin, LeftFoot, LeftToe], [RightThigh, RightShin, RightFoot, RightToe]].iter().enumerate()
    {
        let (mut p, mut r) = (root, local[0]);
        for (k, j) in chain.iter().enumerate() {
            p += r * skeleton.offsets[j.index()];
            r *= local[j.index()];
            if k >= 2 {
                out[side * 2 + k - 2] = p;
            }
        }
    }
    out
}
