//! Overlaps between characters, and their depths.

use glam::{Vec2, Vec3Swizzles};
use std::collections::HashSet;
use throng_core::{BodyVolume, Planar, PosedBody, stops::BODY_RADIUS_M};
use throng_crowd::{Obstacle, Space};
use throng_geometry::{Bounds2d, BoxGrid, Capsule, distance_to_segment};

/// Difference of the heights of two trunks from which they are on two floors (m).
const FLOOR_M: f32 = 1.5;

/// A character in the scene.
#[derive(Clone, Copy, Debug)]
pub struct PresentCharacter {
    /// Number of the character.
    pub number: usize,
    /// Position on the ground (m).
    pub place: Vec2,
    /// Radius of its disc on the ground; 0 for a character that may be above or below others (m).
    pub radius_m: f32,
    /// Trunk, neck and head, if it has a body.
    pub core: Option<[Capsule; BodyVolume::CORE.len()]>,
}

impl PresentCharacter {
    /// A character with a body.
    pub fn with_body(number: usize, body: &PosedBody<'_>, volume: &BodyVolume) -> Self {
        let Planar { x, z, .. } = body.root;
        let core = Some(volume.place_core(|joint, p| body.world(joint).transform_point3(p)));
        Self { number, place: Vec2::new(x, z), radius_m: BODY_RADIUS_M, core }
    }

    /// Box around disc and body, over the ground.
    fn bounds(&self) -> Bounds2d {
        let discs =
            self.core.iter().flatten().flat_map(|c| c.ends.map(|end| Bounds2d::around_disc(end.xz(), c.radius)));
        discs.fold(Bounds2d::around_disc(self.place, self.radius_m), Bounds2d::union)
    }
}

/// Measures overlaps from step to step: of discs and balls, and of characters with bodies.
///
/// Two characters overlap if the discs around their roots do, or the capsules of trunk, neck and head.
#[derive(Clone, Debug, Default)]
pub struct OverlapMeter {
    /// Pairs of discs or balls that overlapped by more than 1 mm, over all frames.
    pub over_1mm: u64,
    /// Pairs of discs or balls that overlapped by more than 1 cm, over all frames.
    pub over_1cm: u64,
    /// Sum of the numbers of discs and balls over all frames.
    pub agent_frames: u64,
    /// Deepest overlap of any pair; 0 without overlaps (m).
    pub deepest_m: f64,
    pairs: HashSet<(usize, usize)>,
    near: NearPairs,
}

impl OverlapMeter {
    /// Measures all characters at one time, except for pairs that `may_meet` allows to be near each other, given their numbers.
    pub fn observe_bodies(&mut self, all: &[PresentCharacter], may_meet: impl Fn(usize, usize) -> bool) {
        self.near.visit(all.iter().map(PresentCharacter::bounds), |i, j| {
            let (a, b) = (&all[i], &all[j]);
            let depth = overlap_depth(a, b);
            if depth > 0.0 && !may_meet(a.number, b.number) {
                self.pairs.insert((b.number.min(a.number), b.number.max(a.number)));
                self.deepest_m = self.deepest_m.max(f64::from(depth));
            }
        });
    }

    /// Measures all discs or balls of a frame.
    ///
    /// - `places`: centres and radii of all agents that have not left (m).
    pub fn observe_discs<V: Space>(&mut self, places: &[(V, f32)]) {
        self.agent_frames += places.len() as u64;
        let bounds = |&(at, radius): &(V, f32)| {
            let [x, y, _] = at.coordinates();
            Bounds2d::around_disc(Vec2::new(x, y), radius)
        };
        self.near.visit(places.iter().map(bounds), |i, j| {
            let (a, b) = (&places[i], &places[j]);
            // In f64, so that the difference of two near places is more exact than the least counted depth.
            let between = (a.0 - b.0).coordinates().map(f64::from);
            let apart = between.iter().map(|c| c * c).sum::<f64>().sqrt();
            let deep = f64::from(a.1) + f64::from(b.1) - apart;
            self.over_1mm += u64::from(deep > 1e-3);
            self.over_1cm += u64::from(deep > 1e-2);
            self.deepest_m = self.deepest_m.max(deep);
        });
    }

    /// Measures overlaps of discs or balls with obstacles, in the same frame.
    pub fn observe_solids<V: Space>(&mut self, places: &[(V, f32)], obstacles: &[Obstacle<V>]) {
        let all =
            places.iter().flat_map(|&(at, radius)| obstacles.iter().map(move |o| depth_in_obstacle(at, radius, o)));
        for deep in all.filter(|d| *d > 0.0) {
            self.over_1mm += u64::from(deep > 1e-3);
            self.over_1cm += u64::from(deep > 1e-2);
            self.deepest_m = self.deepest_m.max(deep);
        }
    }

    /// Pairs of characters that overlapped at any time.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }
}

/// Finder of boxes on the ground that intersect.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearPairs {
    grid: BoxGrid,
}

impl NearPairs {
    /// Calls `found` once with the numbers of every two boxes that intersect, the later one first, and of some that nearly do.
    pub fn visit(&mut self, boxes: impl Iterator<Item = Bounds2d>, mut found: impl FnMut(usize, usize)) {
        self.grid.clear();
        for (i, bounds) in boxes.enumerate() {
            // More than what rounding takes off the sides of both boxes.
            let slack = 1e-3 + 1e-6 * bounds.min.abs().max(bounds.max.abs()).max_element();
            let bounds = bounds.expanded_by(slack);
            self.grid.visit_intersecting(&bounds, |j| {
                found(i, j);
                true
            });
            self.grid.set(i, bounds);
        }
    }
}

/// Overlap depth of two characters; negative if they are apart (m).
pub fn overlap_depth(a: &PresentCharacter, b: &PresentCharacter) -> f32 {
    // Discs on two floors do not meet.
    let height = |c: &PresentCharacter| c.core.map(|core| core[0].ends[0].y);
    let is_on_one_floor = height(a).zip(height(b)).is_none_or(|(a, b)| (a - b).abs() < FLOOR_M);
    let on_ground = a.radius_m > 0.0 && b.radius_m > 0.0 && is_on_one_floor;
    let discs = if on_ground { a.radius_m + b.radius_m - a.place.distance(b.place) } else { f32::NEG_INFINITY };
    let (Some(a), Some(b)) = (&a.core, &b.core) else { return discs };
    BodyVolume::overlap_depth(a, b, discs)
}

/// Depth of a disc or ball in a static obstacle; below zero outside (m).
fn depth_in_obstacle<V: Space>(at: V, radius: f32, obstacle: &Obstacle<V>) -> f64 {
    let apart = match obstacle {
        &Obstacle::Ball { centre, radius } => (at - centre).length() - radius,
        &Obstacle::Wall { from, to, radius } => distance_to_segment(at, [from, to]) - radius,
        &Obstacle::Box { min, max } => {
            let beyond = (at - Space::min(Space::max(at, min), max)).length();
            let room = Space::min(at - min, max - at).coordinates();
            let inside = room.into_iter().take(V::DIMENSIONS).fold(f32::INFINITY, f32::min);
            if inside > 0.0 { -inside } else { beyond }
        }
        Obstacle::Polygon { corners } => {
            let sides = || corners.iter().zip(corners.iter().cycle().skip(1));
            let beside = sides().map(|(&a, &b)| distance_to_segment(at, [a, b])).fold(f32::INFINITY, f32::min);
            let p = at.on_ground();
            let crossed = sides()
                .map(|(a, b)| [a.on_ground(), b.on_ground()])
                .filter(|[a, b]| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y));
            if crossed.count() % 2 == 1 { -beside } else { beside }
        }
        _ => f32::INFINITY,
    };
    f64::from(radius) - f64::from(apart)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec2, Vec3};

    #[test]
    fn the_deeper_a_disc_is_in_an_obstacle_the_deeper_it_counts() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(Vec2::from_array);
        for solid in [
            Obstacle::Box { min: Vec2::ZERO, max: Vec2::splat(4.0) },
            Obstacle::Polygon { corners: square.to_vec() },
            Obstacle::Wall { from: Vec2::new(2.0, 2.0), to: Vec2::new(2.0, 2.0), radius: 2.0 },
        ] {
            for (x, depth) in [(-1.0, -0.75), (-0.25, 0.0), (0.0, 0.25), (1.0, 1.25), (2.0, 2.25), (3.5, 0.75)] {
                let found = depth_in_obstacle(Vec2::new(x, 2.0), 0.25, &solid);
                assert!((found - depth).abs() < 1e-5, "{found} in place of {depth} at {x} of {solid:?}");
            }
        }
    }
    use proptest::prelude::*;
    use throng_core::{Mat3x4, Skeleton};

    /// A body whose hips are bent forwards (rad).
    fn bent(number: usize, at: Vec3, angle: f32) -> PresentCharacter {
        let skeleton = Skeleton::default();
        let rest = skeleton.rest_positions();
        let pose = rest.map(|p| {
            let turn = Quat::from_rotation_x(angle);
            Mat3x4::from_rotation_translation(turn, rest[0] + turn * (p - rest[0]) + Vec3::Y * at.y)
        });
        let body = PosedBody { root: Planar::new(at.x, at.z, 0.0), model: &pose };
        PresentCharacter::with_body(number, &body, &BodyVolume::new(&skeleton))
    }

    fn upright(number: usize, x: f32, y: f32) -> PresentCharacter {
        PresentCharacter { radius_m: 0.0, ..bent(number, Vec3::new(x, y, 0.0), 0.0) }
    }

    #[test]
    fn people_on_two_floors_do_not_meet() {
        let mut meter = OverlapMeter::default();
        meter.observe_bodies(&[upright(0, 0.0, 0.0), upright(1, 0.0, 2.1)], |_, _| false);
        assert_eq!(meter.pairs(), 0);
        meter.observe_bodies(&[upright(0, 0.0, 0.0), upright(1, 0.2, 0.0)], |_, _| false);
        assert_eq!(meter.pairs(), 1);
    }

    #[test]
    fn discs_trunks_and_heads_overlap_as_drawn_by_hand() {
        let at = |number, x: f32| PresentCharacter { number, place: Vec2::new(x, 0.0), radius_m: 0.25, core: None };
        let mut meter = OverlapMeter::default();
        meter.observe_bodies(&[at(0, 0.0), at(1, 0.4), at(2, 5.0)], |_, _| false);
        meter.observe_bodies(&[at(0, 0.0), at(1, 0.6), at(2, 0.45)], |_, _| false);
        assert_eq!(meter.pairs(), 3);
        assert!((meter.deepest_m - 0.35).abs() < 1e-6);
        // Discs apart, but one bows by a right angle: its head, 0.74 m from the hips at its end and of 0.1 m, meets the
        // other's hips of 0.12 m.
        let (first, other) = (bent(0, Vec3::ZERO, 0.0), bent(1, Vec3::Z * 0.8, 0.0));
        assert!(overlap_depth(&first, &other) < 0.0);
        let bows = bent(0, Vec3::ZERO, std::f32::consts::FRAC_PI_2);
        let head = 0.095 + 0.125 + 0.13 + 0.19 + 0.09 + 0.55 * 0.2;
        let deep = overlap_depth(&bows, &other);
        // In a bow the head's joint is 15 mm below the neck's.
        assert!((deep - (0.1 + 0.12 - (0.8f32 - head).hypot(0.015))).abs() < 2e-3, "{deep}");
    }

    fn brute<V: Space>(places: &[(V, f32)], more: f32) -> u64 {
        let pairs = (0..places.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let deep = |i: usize, j: usize| places[i].1 + places[j].1 - (places[i].0 - places[j].0).length();
        pairs.filter(|&(i, j)| deep(i, j) > more).count() as u64
    }

    proptest! {
        #[test]
        fn every_pair_counts_once(
            flat in prop::collection::vec(([-9.0f32..9.0, -3.0f32..3.0], 0.1f32..0.6), 0..120),
            high in prop::collection::vec(([-9.0f32..9.0, -3.0f32..3.0, -4.0f32..4.0], 0.1f32..0.6), 0..120),
        ) {
            let flat: Vec<(Vec2, f32)> = flat.into_iter().map(|(p, r)| (p.into(), r)).collect();
            let mut meter = OverlapMeter::default();
            meter.observe_discs(&flat);
            // A hair of difference between f32 and f64 decides few pairs.
            let (low, high_count) = (brute(&flat, 1e-3 + 1e-5), brute(&flat, 1e-3 - 1e-5));
            prop_assert!((low..=high_count).contains(&meter.over_1mm), "{} {low} {high_count}", meter.over_1mm);
            let high: Vec<(Vec3, f32)> = high.into_iter().map(|(p, r)| (p.into(), r)).collect();
            let mut meter = OverlapMeter::default();
            meter.observe_discs(&high);
            prop_assert!((brute(&high, 1e-2 + 1e-5)..=brute(&high, 1e-2 - 1e-5)).contains(&meter.over_1cm));
        }
    }

    #[test]
    fn depth_is_exact_far_from_the_origin_and_far_apart() {
        let mut meter = OverlapMeter::default();
        let places = [[0.0, 0.0], [0.5, 0.0], [9e4, 9e4]].map(|p| (Vec2::from(p), 0.3));
        meter.observe_discs(&places);
        meter.observe_discs(&places[..1]);
        assert_eq!([meter.over_1mm, meter.over_1cm, meter.agent_frames], [1, 1, 4]);
        assert!((meter.deepest_m - 0.1).abs() < 1e-6, "{}", meter.deepest_m);
        meter.observe_discs::<Vec2>(&[]);
    }
}
