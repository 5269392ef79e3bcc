//! Where the ground is: one height per clip and one slope per source skeleton, so that feet stand on y = 0.
//!
//! Floors of capture volumes are not level: the first test recordings rise by 1 to 1.5 cm a metre.

use super::transfer::Motion;
use glam::{Vec2, Vec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// The lowest part of the feet may be standing where it is slower than this (m/s).
const STANDING_SPEED: f32 = 0.4;

/// Which of the sorted heights of standing feet counts as the ground: low, because feet also stand on things.
const GROUND_QUANTILE: f32 = 0.25;

/// Floors slope less than this (tangent); more is terrain.
const MAX_SLOPE: f32 = 0.03;

/// Feet on a floor are nearer to it than this (m).
const FLOOR_NOISE: f32 = 0.02;

/// Clips that stay within this say little about the slope (m).
const SLOPE_REACH: f32 = 0.1;

/// The lowest part of the feet at each frame where it hardly moves: place, and height above where that joint is
/// when the foot stands flat. Every frame where there is no such one (m).
pub fn standing(motion: &Motion, skeleton: &Skeleton, rate_hz: f64) -> Vec<Vec3> {
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
        let point = at[lowest].with_y(clearance(lowest));
        all.push(point);
        if before.is_some_and(|b| (at[lowest] - b[lowest]).length() * (rate_hz as f32) < STANDING_SPEED) {
            standing.push(point);
        }
        before = Some(at);
    }
    if standing.is_empty() { all } else { standing }
}

/// Slope of the floor (rise per metre along x and z) that clips of one source skeleton share, each at a height of
/// its own: least squares, with steps and other outliers dropped. Zero where the ground is no plane.
pub fn slope(clips: &[&[Vec3]]) -> Vec2 {
    let mut slope = Vec2::ZERO;
    for _ in 0..4 {
        let (mut xx, mut xz, mut zz, mut xy, mut zy) = (0.0f64, 0.0f64, 0.0f64, 0.0f64, 0.0f64);
        let (mut kept, mut total) = (0usize, 0usize);
        for points in clips.iter().filter(|p| !p.is_empty()) {
            let level = median(points.iter().map(|p| above(*p, slope)).collect());
            let near: Vec<Vec3> =
                points.iter().copied().filter(|p| (above(*p, slope) - level).abs() < 2.0 * FLOOR_NOISE).collect();
            let mean = near.iter().sum::<Vec3>() / near.len().max(1) as f32;
            for p in &near {
                let d = (*p - mean).as_dvec3();
                xx += d.x * d.x;
                xz += d.x * d.z;
                zz += d.z * d.z;
                xy += d.x * d.y;
                zy += d.z * d.y;
            }
            kept += near.iter().filter(|p| (above(**p, slope) - level).abs() < FLOOR_NOISE).count();
            total += points.len();
        }
        let ridge = total as f64 * f64::from(SLOPE_REACH * SLOPE_REACH);
        let (a, c) = (xx + ridge, zz + ridge);
        let determinant = a * c - xz * xz;
        let is_plane = kept * 4 > total * 3 || slope == Vec2::ZERO;
        if total == 0 || determinant <= 0.0 || !is_plane {
            return Vec2::ZERO;
        }
        slope = Vec2::new(((c * xy - xz * zy) / determinant) as f32, ((a * zy - xz * xy) / determinant) as f32);
        if slope.length() > MAX_SLOPE {
            return Vec2::ZERO;
        }
    }
    slope
}

/// Height of the floor of one clip at the origin, given its slope: the lower quartile of where feet stand, which a
/// bad frame, jumps and steps leave in place (m).
pub fn height(points: &[Vec3], slope: Vec2) -> f32 {
    let mut heights: Vec<f32> = points.iter().map(|p| above(*p, slope)).collect();
    heights.sort_by(f32::total_cmp);
    let last = heights.len().saturating_sub(1);
    heights.get((last as f32 * GROUND_QUANTILE) as usize).copied().unwrap_or(0.0)
}

/// Moves the motion down onto y = 0. The slope is taken out of heights only: it is too small to turn the body for.
pub fn level(motion: &mut Motion, height: f32, slope: Vec2) {
    for p in &mut motion.root_positions {
        p.y -= height + slope.dot(Vec2::new(p.x, p.z));
    }
}

fn above(p: Vec3, slope: Vec2) -> f32 {
    p.y - slope.dot(Vec2::new(p.x, p.z))
}

fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
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
            r = maths::compose(r, local[j.index()]);
            if k >= 2 {
                out[side * 2 + k - 2] = p;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feet that stand along a line on a floor of the given slope, and on a box now and then.
    fn walk(slope: Vec2, offset: f32, boxes: bool) -> Vec<Vec3> {
        let at = |i: usize| {
            let (x, z) = (i as f32 * 0.03, (i as f32 * 0.11).sin());
            let step = if boxes && i.is_multiple_of(10) { 0.3 } else { 0.0 };
            Vec3::new(x, offset + slope.dot(Vec2::new(x, z)) + step + 0.004 * (i as f32 * 1.7).sin(), z)
        };
        (0..200).map(at).collect()
    }

    #[test]
    fn finds_the_floor_that_clips_share_at_different_heights() {
        let truth = Vec2::new(0.01, -0.006);
        let clips = [walk(truth, 0.1, false), walk(truth, -0.3, true)];
        let found = slope(&[&clips[0], &clips[1]]);
        assert!((found - truth).length() < 0.0015, "{found}");
        assert!((height(&clips[1], found) + 0.3).abs() < 0.006);
    }

    #[test]
    fn stairs_are_no_floor() {
        assert_eq!(slope(&[&walk(Vec2::new(0.4, 0.0), 0.0, false)]), Vec2::ZERO);
        let stairs: Vec<Vec3> = (0..200).map(|i| Vec3::new(i as f32 * 0.02, (i / 20) as f32 * 0.17, 0.0)).collect();
        assert_eq!(slope(&[&stairs]), Vec2::ZERO);
        assert_eq!(slope(&[&[]]), Vec2::ZERO);
    }

    #[test]
    fn standing_in_place_shows_no_slope() {
        let points: Vec<Vec3> =
            (0..100).map(|i| Vec3::new(0.01 * (i as f32).sin(), 0.003 * (i as f32).sin(), 0.0)).collect();
        assert!(slope(&[&points]).length() < 0.003);
    }
}
