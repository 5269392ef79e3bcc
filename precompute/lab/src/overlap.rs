//! Overlaps between characters, and their depths.

use glam::{Vec2, Vec3};
use std::collections::{HashMap, HashSet};
use throng_core::skeleton::Skeleton;
use throng_core::stops::{BODY_RADIUS_M, HEAD_RADIUS_M, TRUNK_RADIUS_M};
use throng_core::{Joint, Planar, PosedBody};
use throng_geometry::segment_distance;

/// Side of a cell of the neighbour grid, which no character exceeds (m).
const CELL_M: f32 = 2.0;

/// A character in the scene.
#[derive(Clone, Copy, Debug)]
pub struct PresentCharacter {
    /// Number of the character.
    pub number: usize,
    /// Position on the ground (m).
    pub place: Vec2,
    /// Radius of its disc on the ground; 0 for a character that may be above or below others (m).
    pub radius_m: f32,
    /// Hips, neck and middle of the head, if it has a body (m).
    pub trunk: Option<[Vec3; 3]>,
}

impl PresentCharacter {
    /// A character with a body.
    pub fn with_body(number: usize, body: &PosedBody<'_>, skeleton: &Skeleton) -> Self {
        let Planar { x, z, .. } = body.root;
        let head = body.world(Joint::Head).transform_point3(skeleton.tips[0] * 0.5);
        let trunk = Some([body.position(Joint::Hips), body.position(Joint::Neck), head]);
        Self { number, place: Vec2::new(x, z), radius_m: BODY_RADIUS_M, trunk }
    }
}

/// Measures overlaps from step to step.
///
/// Two characters overlap if the discs around their roots do, or the capsules of trunk and head.
#[derive(Clone, Debug, Default)]
pub struct BodyOverlapMeter {
    pairs: HashSet<(usize, usize)>,
    deepest_m: f32,
}

impl BodyOverlapMeter {
    /// Measures all characters at one time.
    pub fn observe(&mut self, all: &[PresentCharacter]) {
        self.observe_except(all, |_, _| false);
    }

    /// Like [`Self::observe`], except for pairs of characters that `may_meet` allows to be near each other.
    pub fn observe_except(&mut self, all: &[PresentCharacter], may_meet: impl Fn(usize, usize) -> bool) {
        let cell = |p: Vec2| (p / CELL_M).floor().to_array().map(|v| v as i32);
        let mut cells: HashMap<[i32; 2], Vec<usize>> = HashMap::new();
        for (i, a) in all.iter().enumerate() {
            let [x, z] = cell(a.place);
            for near in (-1..=1).flat_map(|dx| (-1..=1).map(move |dz| [x + dx, z + dz])) {
                for &j in cells.get(&near).map_or(&[][..], Vec::as_slice) {
                    let depth = overlap_depth(a, &all[j]);
                    if depth > 0.0 && !may_meet(a.number, all[j].number) {
                        self.pairs.insert((all[j].number.min(a.number), all[j].number.max(a.number)));
                        self.deepest_m = self.deepest_m.max(depth);
                    }
                }
            }
            cells.entry([x, z]).or_default().push(i);
        }
    }

    /// Pairs that overlapped at any time.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// Deepest overlap of any pair; 0 without overlaps (m).
    pub fn deepest_m(&self) -> f32 {
        self.deepest_m
    }
}

/// Overlap depth of two characters; negative if they are apart (m).
pub fn overlap_depth(a: &PresentCharacter, b: &PresentCharacter) -> f32 {
    let on_ground = a.radius_m > 0.0 && b.radius_m > 0.0;
    let discs = if on_ground { a.radius_m + b.radius_m - a.place.distance(b.place) } else { f32::NEG_INFINITY };
    let (Some([hips_a, neck_a, head_a]), Some([hips_b, neck_b, head_b])) = (a.trunk, b.trunk) else { return discs };
    let (trunk_a, trunk_b) = ([hips_a, neck_a], [hips_b, neck_b]);
    let trunks = 2.0 * TRUNK_RADIUS_M - segment_distance(trunk_a, trunk_b);
    let heads = 2.0 * HEAD_RADIUS_M - head_a.distance(head_b);
    let head_trunk = segment_distance([head_a; 2], trunk_b).min(segment_distance([head_b; 2], trunk_a));
    discs.max(trunks).max(heads).max(TRUNK_RADIUS_M + HEAD_RADIUS_M - head_trunk)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn upright(number: usize, x: f32, y: f32) -> PresentCharacter {
        let trunk = Some([Vec3::new(x, y + 0.95, 0.0), Vec3::new(x, y + 1.4, 0.0), Vec3::new(x, y + 1.6, 0.0)]);
        PresentCharacter { number, place: Vec2::new(x, 0.0), radius_m: 0.0, trunk }
    }

    #[test]
    fn people_on_two_floors_do_not_meet() {
        let mut meter = BodyOverlapMeter::default();
        meter.observe(&[upright(0, 0.0, 0.0), upright(1, 0.0, 2.1)]);
        assert_eq!(meter.pairs(), 0);
        meter.observe(&[upright(0, 0.0, 0.0), upright(1, 0.2, 0.0)]);
        assert_eq!(meter.pairs(), 1);
    }

    #[test]
    fn discs_trunks_and_heads_overlap_as_drawn_by_hand() {
        let at = |number, x: f32| PresentCharacter { number, place: Vec2::new(x, 0.0), radius_m: 0.25, trunk: None };
        let mut meter = BodyOverlapMeter::default();
        meter.observe(&[at(0, 0.0), at(1, 0.4), at(2, 5.0)]);
        meter.observe(&[at(0, 0.0), at(1, 0.6), at(2, 0.45)]);
        assert_eq!(meter.pairs(), 3);
        assert!((meter.deepest_m() - 0.35).abs() < 1e-6);
        // Discs apart, but one bows: its head meets the other's trunk.
        let body = |x: f32, lean: f32| PresentCharacter {
            trunk: Some([Vec3::new(x, 1.0, 0.0), Vec3::new(x + lean, 1.3, 0.0), Vec3::new(x + 1.6 * lean, 1.3, 0.0)]),
            ..at(0, x)
        };
        assert!(overlap_depth(&body(0.0, 0.0), &body(0.6, 0.0)) < 0.0);
        assert!((overlap_depth(&body(0.0, 0.3), &body(0.6, 0.0)) - (0.25 - 0.12)).abs() < 1e-6);
    }
}
