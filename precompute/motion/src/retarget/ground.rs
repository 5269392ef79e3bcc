//! Height of the ground per clip, and its slope per source skeleton, so that feet stand on y = 0.
//!
//! Floors of capture volumes are not level: the first test recordings rise by 1 to 1.5 cm a metre. One that rises more is a
//! volume that was set up tilted, and people in it lean: all is turned upright. Clips whose floor is another one, or
//! moves up or down as time goes by, have a slope of their own. What no plane fits is terrain, and stays.

use super::transfer::RetargetedMotion;
use crate::stance::{self, FootSample};
use glam::{DMat3, DVec3, Quat, Vec3};
use throng_base::{maths, maths::quantile};
use throng_core::{NUM_JOINTS, Skeleton, skeleton::LEGS};

/// Quantile of the heights of standing feet that counts as the ground: low, because feet also stand on things.
const GROUND_QUANTILE: f32 = 0.25;

/// Slope of a floor below which the body is not turned (tangent).
const MAX_SLOPE: f32 = 0.03;

/// Largest slope of a floor (tangent): 8 degrees, on top of which measuring errs; more is terrain.
const MAX_TILT: f32 = 0.16;

/// Greatest speed at which a floor rises or falls (m/s).
const MAX_DRIFT: f32 = 0.03;

/// Distance from a floor within which feet are on it (m).
const FLOOR_NOISE: f32 = 0.02;

/// Distance from a tilted or moving floor within which most feet on it are: those on kerbs and steps are not (m).
const TILT_NOISE: f32 = 0.01;

/// Share of the distances below which a floor fits better.
const CLEARLY: f32 = 0.65;

/// Extent of a clip below which it says little about the slope; about a tilt, less does, such as that from foot to foot (m).
const SLOPE_REACH: f32 = 0.1;
const TILT_REACH: f32 = 0.05;

/// Distances from the floor within which feet count, round by round, for a floor whose slope is not known (m).
const NEARER: [f32; 7] = [f32::INFINITY, 0.16, 0.08, 0.04, 0.04, 0.04, 0.04];

/// Least distance between places at which feet stand, and least time where the floor drifts (m, s). The least number of places
/// beyond the first of each clip shows a floor: a step up is two places, of two feet each, on one plane. More than the most
/// show nothing new.
const APART: (f32, f32) = (0.15, 1.0);
const MIN_PLACES: usize = 5;
const MOST_PLACES: usize = 200;

/// Position of a standing foot at one moment.
#[derive(Clone, Copy, Debug)]
pub struct FootPoint {
    /// Height above that of the joint when the foot stands flat (m).
    pub height: f32,
    /// Quantities on which heights depend: x and z (m) and time (s).
    pub place: Vec3,
}

/// The lowest part of the feet at each frame where it hardly moves; at every frame where there is no such one.
pub fn standing_points(motion: &RetargetedMotion, skeleton: &Skeleton, rate_hz: f64) -> Vec<FootPoint> {
    let frames = motion.root_positions.iter().zip(motion.rotations.chunks(NUM_JOINTS));
    let all =
        stance::lowest_feet(frames.map(|(root, local)| foot_positions(*root, local, skeleton)), skeleton, rate_hz);
    let point = |s: &FootSample| {
        let time_s = (s.frame as f64 / rate_hz) as f32;
        FootPoint { height: s.position.y, place: Vec3::new(s.position.x, s.position.z, time_s) }
    };
    let standing: Vec<FootPoint> = all.iter().filter(|s| s.is_still).map(point).collect();
    if standing.is_empty() { all.iter().map(point).collect() } else { standing }
}

/// Slope of the floor (rise per metre along x and z; none over time) that clips of one source skeleton share, each at a height
/// of its own. Zero where the ground is no plane.
pub fn shared_slope(clips: &[&[FootPoint]]) -> Vec3 {
    let gentle = gentle_slope(clips);
    let Some(tilt) = steep_slope(clips, false).filter(|t| is_steep(*t)) else { return gentle.unwrap_or(Vec3::ZERO) };
    match gentle {
        Some(gentle) if spread(clips, tilt) > CLEARLY * spread(clips, gentle) => gentle,
        _ => tilt,
    }
}

/// The slope of a nearly level floor: least squares, with steps and other outliers dropped.
fn gentle_slope(clips: &[&[FootPoint]]) -> Option<Vec3> {
    let mut slope = Vec3::ZERO;
    for _ in 0..4 {
        let is_plane = slope == Vec3::ZERO || share_within(clips, slope, FLOOR_NOISE) > 0.75;
        slope = fit(clips, slope, (2.0 * FLOOR_NOISE, SLOPE_REACH), false).filter(|s| is_plane && !is_steep(*s))?;
    }
    Some(slope)
}

/// Slope of the floor of one clip, including its rise over time (m/s): the shared one of its source skeleton, unless that does
/// not fit and another one does.
pub fn own_slope(points: &[FootPoint], shared: Vec3) -> Vec3 {
    let points = &[points];
    let mut best = (shared, spread(points, shared));
    for drifts in [false, true] {
        if best.1 < FLOOR_NOISE {
            break;
        }
        let found = steep_slope(points, drifts).map(|s| (s, spread(points, s)));
        best = found.filter(|f| f.1 < CLEARLY * best.1).unwrap_or(best);
    }
    best.0
}

/// True for floors for which bodies are turned upright.
pub fn is_steep(slope: Vec3) -> bool {
    slope.truncate().length() > MAX_SLOPE
}

/// The rotation that lays a floor level.
pub fn upright_turn(slope: Vec3) -> Quat {
    Quat::from_rotation_arc(Vec3::new(-slope.x, 1.0, -slope.y).normalize(), Vec3::Y)
}

/// The slope of a floor that may be steep, where enough steps lie on one plane.
fn steep_slope(clips: &[&[FootPoint]], drifts: bool) -> Option<Vec3> {
    let found = NEARER.into_iter().try_fold(Vec3::ZERO, |slope, near| fit(clips, slope, (near, TILT_REACH), drifts))?;
    let is_floor = found.truncate().length() < MAX_TILT && found.z.abs() < MAX_DRIFT;
    let fits = || {
        let places: Vec<_> = clips.iter().map(|c| group_by_place(c, drifts && !is_steep(found))).collect();
        let known: usize = places.iter().map(|p| p.len().saturating_sub(1)).sum();
        known >= MIN_PLACES && share_of_places(clips, &places, found) > 0.75
    };
    (is_floor && share_within(clips, found, TILT_NOISE) > 0.75 && fits()).then_some(found)
}

/// One round of least squares over the points near the present floor (m); time counts where it drifts.
fn fit(clips: &[&[FootPoint]], slope: Vec3, (near, reach): (f32, f32), drifts: bool) -> Option<Vec3> {
    let (mut squares, mut heights) = (DMat3::ZERO, DVec3::ZERO);
    let mut total = 0usize;
    let counts = if drifts { Vec3::ONE } else { Vec3::new(1.0, 1.0, 0.0) };
    for points in clips.iter().filter(|p| !p.is_empty()) {
        let level = level_of(points, slope);
        let near = points.iter().filter(|p| (above(p, slope) - level).abs() < near);
        let near: Vec<(f32, Vec3)> = near.map(|p| (p.height, p.place * counts)).collect();
        let (height, place) = near.iter().fold((0.0, Vec3::ZERO), |(h, p), n| (h + n.0, p + n.1));
        let (height, place) = (height / near.len().max(1) as f32, place / near.len().max(1) as f32);
        for (h, p) in &near {
            let d = (*p - place).as_dvec3();
            squares += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
            heights += d * f64::from(*h - height);
        }
        total += points.len();
    }
    let ridge = total as f64 * f64::from(reach * reach);
    (total > 0).then(|| ((squares + DMat3::from_diagonal(DVec3::splat(ridge))).inverse() * heights).as_vec3())
}

/// Share of the points within a distance of the floors of their clips (m).
fn share_within(clips: &[&[FootPoint]], slope: Vec3, near: f32) -> f32 {
    let (mut kept, mut total) = (0usize, 0usize);
    for points in clips {
        let level = level_of(points, slope);
        kept += points.iter().filter(|p| (above(p, slope) - level).abs() < near).count();
        total += points.len();
    }
    kept as f32 / total.max(1) as f32
}

/// Distance from the floors of their clips within which nine in ten points are (m).
fn spread(clips: &[&[FootPoint]], slope: Vec3) -> f32 {
    let levels = clips.iter().map(|points| (points, level_of(points, slope)));
    let far = levels.flat_map(|(points, level)| points.iter().map(move |p| (above(p, slope) - level).abs()));
    value_at_share(far.collect(), 0.9)
}

/// The median height of the points (m).
fn level_of(points: &[FootPoint], slope: Vec3) -> f32 {
    quantile(points.iter().map(|p| above(p, slope)), [1, 2]).unwrap_or_default()
}

/// Groups the points by the place at which they stand; over time it is another one where the floor drifts.
fn group_by_place(points: &[FootPoint], drifts: bool) -> Vec<Vec<&FootPoint>> {
    let mut places: Vec<Vec<&FootPoint>> = Vec::new();
    for p in points {
        let is_near = |place: &Vec<&FootPoint>| {
            let by = (p.place - place[0].place).abs();
            by.truncate().length() <= APART.0 && !(drifts && by.z > APART.1)
        };
        match places.iter().position(is_near) {
            Some(place) => places[place].push(p),
            None if places.len() < MOST_PLACES => places.push(vec![p]),
            None => {}
        }
    }
    places
}

/// Share of the places at which most feet are near to the floor, whatever the time they stand there.
fn share_of_places(clips: &[&[FootPoint]], places: &[Vec<Vec<&FootPoint>>], slope: Vec3) -> f32 {
    let (mut kept, mut total) = (0usize, 0usize);
    for (points, places) in clips.iter().zip(places) {
        let level = level_of(points, slope);
        let far =
            |place: &[&FootPoint]| value_at_share(place.iter().map(|p| (above(p, slope) - level).abs()).collect(), 0.5);
        kept += places.iter().filter(|place| far(place) < TILT_NOISE).count();
        total += places.len();
    }
    kept as f32 / total.max(1) as f32
}

/// Height of the floor of one clip at the origin, given its slope: the lower quartile of the heights of standing feet, which is
/// robust to bad frames, jumps and steps (m).
pub fn floor_height(points: &[FootPoint], slope: Vec3) -> f32 {
    value_at_share(points.iter().map(|p| above(p, slope)).collect(), GROUND_QUANTILE)
}

/// Moves the motion down onto y = 0. The remaining slope is taken out of heights only: it is too small to turn the body for.
pub fn level_motion(motion: &mut RetargetedMotion, height: f32, slope: Vec3, rate_hz: f64) {
    for (f, p) in motion.root_positions.iter_mut().enumerate() {
        p.y -= height + slope.dot(Vec3::new(p.x, p.z, (f as f64 / rate_hz) as f32));
    }
}

fn above(p: &FootPoint, slope: Vec3) -> f32 {
    p.height - slope.dot(p.place)
}

fn value_at_share(mut values: Vec<f32>, share: f32) -> f32 {
    values.sort_by(f32::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((last as f32 * share) as usize).copied().unwrap_or(0.0)
}

/// World positions of left ankle, left toe, right ankle, right toe.
fn foot_positions(root: Vec3, local: &[glam::Quat], skeleton: &Skeleton) -> [Vec3; 4] {
    let mut out = [Vec3::ZERO; 4];
    for (side, chain) in LEGS.iter().enumerate() {
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
    fn walk(slope: Vec3, offset: f32, boxes: bool) -> Vec<FootPoint> {
        let at = |i: usize| {
            let (x, z) = (i as f32 * 0.03, (i as f32 * 0.11).sin());
            let step = if boxes && i.is_multiple_of(10) { 0.3 } else { 0.0 };
            let place = Vec3::new(x, z, 0.1 * i as f32);
            FootPoint { height: offset + slope.dot(place) + step + 0.004 * (i as f32 * 1.7).sin(), place }
        };
        (0..200).map(at).collect()
    }

    /// Feet that go forth along x, at heights of their own.
    fn along(height: impl Fn(f32) -> f32) -> Vec<FootPoint> {
        let at = |x: f32| FootPoint { height: height(x), place: Vec3::new(x, 0.1 * (7.0 * x).sin(), x) };
        (0..200).map(|i| at(i as f32 * 0.02)).collect()
    }

    #[test]
    fn finds_the_floor_that_clips_share_at_different_heights() {
        let truth = Vec3::new(0.01, -0.006, 0.0);
        let clips = [walk(truth, 0.1, false), walk(truth, -0.3, true)];
        let found = shared_slope(&[&clips[0], &clips[1]]);
        assert!((found - truth).length() < 0.0015, "{found}");
        assert!((floor_height(&clips[1], found) + 0.3).abs() < 0.006);
    }

    #[test]
    fn tilts_of_up_to_eight_degrees_are_floors_whichever_way_they_go() {
        for k in 0..24 {
            let (degrees, distance) = (1.0 + 7.0 * k as f32 / 23.0, 2.4 * k as f32);
            let truth = (Vec3::X * distance.cos() + Vec3::Y * distance.sin()) * degrees.to_radians().tan();
            let clips = [walk(truth, 0.1, false), walk(truth, -0.3, true)];
            let found = shared_slope(&[&clips[0], &clips[1]]);
            // At 4 m, so many millimetres.
            assert!((found - truth).length() < 0.004, "{degrees} degrees: {found} is not {truth}");
        }
    }

    #[test]
    fn stairs_kerbs_and_ramps_are_no_floor() {
        assert_eq!(shared_slope(&[&walk(Vec3::X * 0.4, 0.0, false)]), Vec3::ZERO);
        for (rise, tread) in [(0.17, 0.4), (0.17, 1.0), (0.17, 2.0), (0.1, 1.0), (0.06, 0.6), (0.05, 0.8), (0.3, 2.0)] {
            let stairs = along(|x| (x / tread).floor() * rise);
            assert_eq!(shared_slope(&[&stairs]), Vec3::ZERO, "{rise} {tread}");
            assert_eq!(own_slope(&stairs, Vec3::ZERO), Vec3::ZERO, "{rise} {tread}");
        }
        // Who stands, goes up a step and stands there, for however long, whichever foot is lowest.
        for (rise, distance, between) in [(0.1, 0.8, 0), (0.1, 1.0, 1), (0.12, 1.5, 2), (0.17, 1.5, 2), (0.2, 2.5, 3)] {
            let stand = |x: f32, y: f32, from: f32| {
                (0..150).map(move |f| {
                    let side = if f / 10 % 2 == 0 { 0.1 } else { -0.1 };
                    FootPoint {
                        height: y + 0.002 * (f as f32).sin(),
                        place: Vec3::new(x, side, from + f as f32 / 30.0),
                    }
                })
            };
            let on_the_way = |k: i32| {
                let x = distance * k as f32 / (between + 1) as f32;
                (0..10)
                    .map(move |f| FootPoint { height: 0.0, place: Vec3::new(x, 0.1, 5.0 + k as f32 + f as f32 / 30.0) })
            };
            let step: Vec<FootPoint> = stand(0.0, 0.0, 0.0)
                .chain((1..=between).flat_map(on_the_way))
                .chain(stand(distance, rise, 10.0))
                .collect();
            assert_eq!(
                own_slope(&step, shared_slope(&[&step])).truncate(),
                glam::Vec2::ZERO,
                "{rise} {distance} {between}"
            );
        }
        for ramp in [along(|x| 0.2 * (x - 2.0).max(0.0)), along(|x| 0.1 * (3.0 * x).sin())] {
            assert_eq!(own_slope(&ramp, shared_slope(&[&ramp])), Vec3::ZERO);
        }
        assert_eq!(shared_slope(&[&[]]), Vec3::ZERO);
    }

    #[test]
    fn a_clip_on_a_floor_of_its_own_is_laid_on_that_one() {
        for (k, drift) in [0.0, 0.004, -0.01, 0.02].into_iter().enumerate() {
            let truth = Vec3::new(0.05, -0.04, drift);
            let points = walk(truth, 0.2, k % 2 == 1);
            let found = own_slope(&points, Vec3::X * 0.01);
            // Who goes straight on cannot tell what rises with the way from what rises with time.
            assert!(is_steep(found) && share_within(&[&points], found, TILT_NOISE) > 0.85, "{found} is not {truth}");
        }
        // Who stands where he is and sinks is no terrain; a single step tells nothing.
        let still = |n: usize| -> Vec<FootPoint> {
            (0..n).map(|i| FootPoint { height: -0.001 * i as f32, place: Vec3::Z * (0.1 * i as f32) }).collect()
        };
        assert!((own_slope(&still(200), Vec3::ZERO).z + 0.01).abs() < 1e-3);
        assert_eq!(own_slope(&walk(Vec3::X * 0.08, 0.0, false)[..20], Vec3::ZERO), Vec3::ZERO);
        // The shared one stays where it fits.
        let shared = Vec3::X * 0.01;
        assert_eq!(own_slope(&walk(shared, 0.2, false), shared), shared);
    }

    #[test]
    fn standing_in_place_shows_no_slope() {
        let at = |i: f32| FootPoint { height: 0.003 * i.sin(), place: Vec3::new(0.01 * i.sin(), 0.0, 0.1 * i) };
        let points: Vec<FootPoint> = (0..100).map(|i| at(i as f32)).collect();
        assert!(shared_slope(&[&points]).length() < 0.003);
    }
}
