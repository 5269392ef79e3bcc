//! Counts how often people walk into each other.

use glam::Vec3;
use std::collections::{BTreeSet, HashMap};

/// Radius of a trunk: narrower than shoulders, so that passing shoulder to shoulder is no overlap (m).
pub const TRUNK_RADIUS_M: f32 = 0.15;

/// Edge length of the grid that finds neighbours (m).
const GRID_M: f32 = 1.0;

/// Counts the times at which the trunks of two characters come into each other: a capsule from hips to neck each.
///
/// A pair that stays inside each other counts once, until it has come apart.
#[derive(Clone, Debug, Default)]
pub struct TrunkMeter {
    inside: BTreeSet<(u32, u32)>,
    count: u64,
    deepest_m: f32,
}

impl TrunkMeter {
    /// Looks at all characters at one moment.
    ///
    /// - `trunks`: hips and neck in the world (m, number of characters).
    pub fn observe(&mut self, trunks: &[[Vec3; 2]]) {
        let cell = |p: Vec3| ((p.x / GRID_M).floor() as i32, (p.z / GRID_M).floor() as i32);
        let mut grid: HashMap<(i32, i32), Vec<u32>> = HashMap::new();
        for (i, t) in trunks.iter().enumerate() {
            grid.entry(cell(t[0])).or_default().push(i as u32);
        }
        let mut inside = BTreeSet::new();
        for (i, t) in trunks.iter().enumerate() {
            let (x, z) = cell(t[0]);
            let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dz| (x + dx, z + dz)));
            let others = around.filter_map(|c| grid.get(&c)).flatten().filter(|&&j| j as usize > i);
            for &j in others {
                let depth = 2.0 * TRUNK_RADIUS_M - segment_distance(*t, trunks[j as usize]);
                if depth > 0.0 {
                    inside.insert((i as u32, j));
                    self.deepest_m = self.deepest_m.max(depth);
                }
            }
        }
        self.count += inside.difference(&self.inside).count() as u64;
        self.inside = inside;
    }

    /// Times at which two came into each other.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Deepest that two were inside each other (m).
    pub fn deepest_m(&self) -> f32 {
        self.deepest_m
    }
}

/// Distance between two segments (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.9).
fn segment_distance([p1, q1]: [Vec3; 2], [p2, q2]: [Vec3; 2]) -> f32 {
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f) = (d1.length_squared(), d2.length_squared(), d2.dot(r));
    let (c, b) = (d1.dot(r), d1.dot(d2));
    let clamp = |v: f32| v.clamp(0.0, 1.0);
    if a < 1e-12 || e < 1e-12 {
        let s = if a < 1e-12 { 0.0 } else { clamp(-c / a) };
        let t = if e < 1e-12 { 0.0 } else { clamp((f + s * b) / e) };
        return (p1 + d1 * s - p2 - d2 * t).length();
    }
    let parallel = a * e - b * b;
    let mut s = if parallel > 1e-12 { clamp((b * f - c * e) / parallel) } else { 0.0 };
    let mut t = (b * s + f) / e;
    if !(0.0..=1.0).contains(&t) {
        t = clamp(t);
        s = clamp((b * t - c) / a);
    }
    (p1 + d1 * s - p2 - d2 * t).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn upright(x: f32, z: f32) -> [Vec3; 2] {
        [Vec3::new(x, 0.95, z), Vec3::new(x, 1.5, z)]
    }

    #[test]
    fn a_pair_counts_once_until_it_has_come_apart() {
        let mut meter = TrunkMeter::default();
        let apart = [upright(0.0, 0.0), upright(1.0, 0.0), upright(0.0, -0.99)];
        let together = [upright(0.0, 0.0), upright(-0.2, 0.0), upright(0.0, -0.99)];
        for (people, count) in [(&apart, 0), (&together, 1), (&together, 1), (&apart, 1), (&together, 2)] {
            meter.observe(people);
            assert_eq!(meter.count(), count);
        }
        assert!((meter.deepest_m() - 0.1).abs() < 1e-6);
    }

    #[test]
    fn people_on_two_floors_do_not_meet() {
        let mut meter = TrunkMeter::default();
        let above = upright(0.0, 0.0).map(|p| p + Vec3::Y * 2.1);
        meter.observe(&[upright(0.0, 0.0), above]);
        assert_eq!(meter.count(), 0);
    }

    proptest! {
        #[test]
        fn segments_are_as_far_apart_as_their_nearest_samples(v in prop::array::uniform12(-2.0f32..2.0)) {
            let p = |i: usize| Vec3::new(v[3 * i], v[3 * i + 1], v[3 * i + 2]);
            let (a, b) = ([p(0), p(1)], [p(2), p(3)]);
            let at = |s: [Vec3; 2], i: u32| s[0].lerp(s[1], i as f32 / 60.0);
            let pairs = (0..=60).flat_map(|i| (0..=60).map(move |j| (i, j)));
            let sampled = pairs.map(|(i, j)| (at(a, i) - at(b, j)).length()).fold(f32::INFINITY, f32::min);
            let exact = segment_distance(a, b);
            prop_assert!(exact <= sampled + 1e-4 && sampled <= exact + 0.12, "{exact} {sampled}");
        }
    }
}
