//! Fits patches into an environment by matching their units (Lee, Choi and Lee 2006, section 5).

use super::{place_patches::Placer, relation::RelativePlacement};
use crate::environment::{Environment, PlacedUnit};
use crate::stitch::library::{normalised, turn_difference};
use std::collections::{HashMap, HashSet};
use std::f32::consts::TAU;
use throng_core::patch::{EdgeRecord, NONE, Placement};

/// Largest distance of matching units, in the patch's frame (m).
const TOLERANCE_M: f32 = 0.02;
/// Largest heading difference of matching units, modulo their symmetry (rad).
const TOLERANCE: f32 = 1.0 * std::f32::consts::PI / 180.0;

/// A patch fitted to placed units.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct FittedPatch {
    /// Number of the patch.
    pub patch: u32,
    /// The patch's frame in the world.
    pub placement: Placement,
    /// Placed units, in the order of the patch's.
    pub units: Vec<u32>,
}

impl FittedPatch {
    /// Relative placement of a placed unit that obstructs the instance; `None` for its own.
    pub fn obstacle(&self, number: u32, unit: &PlacedUnit) -> Option<RelativePlacement> {
        let relation = || RelativePlacement::new(self.patch, self.placement, unit.unit as u32, unit.placement);
        (!self.units.contains(&number)).then(relation)
    }
}

/// Index of placed units by number and place.
pub(in crate::stitch) struct UnitIndex<'a> {
    environment: &'a Environment,
    buckets: HashMap<(usize, [i32; 3]), Vec<u32>>,
}

impl<'a> UnitIndex<'a> {
    /// Edge length of a bucket (m).
    const BUCKET_M: f32 = 0.5;

    /// Indexes all units of an environment.
    pub fn new(environment: &'a Environment) -> Self {
        let mut buckets: HashMap<_, Vec<u32>> = HashMap::new();
        for (i, u) in (0u32..).zip(&environment.units) {
            let p = u.placement.translation().to_array().map(Self::bucket);
            buckets.entry((u.unit, p)).or_default().push(i);
        }
        Self { environment, buckets }
    }

    fn bucket(v: f32) -> i32 {
        (v / Self::BUCKET_M).floor() as i32
    }

    /// Placed units of a given number with their origin within `radius` of a place, nearest first (radius < BUCKET_M).
    pub fn units_near(&self, unit: usize, at: Placement, radius: f32) -> Vec<u32> {
        let p = at.translation();
        let side = |k: usize, axis: usize| if k >> axis & 1 == 0 { -radius } else { radius };
        let corner = |k: usize| std::array::from_fn(|axis| Self::bucket(p[axis] + side(k, axis)));
        let mut corners: Vec<[i32; 3]> = (0..8).map(corner).collect();
        corners.sort_unstable();
        corners.dedup();
        let distance = |i: u32| (self.environment.units[i as usize].placement.translation() - p).length();
        let mut found: Vec<u32> =
            corners.iter().filter_map(|c| self.buckets.get(&(unit, *c))).flatten().copied().collect();
        found.retain(|&i| distance(i) <= radius);
        found.sort_by(|&i, &j| distance(i).total_cmp(&distance(j)).then(i.cmp(&j)));
        found
    }

    /// Placed unit of a given number at a placement, modulo turns by `period`.
    fn unit_at(&self, unit: usize, at: Placement, period: f32) -> Option<u32> {
        let heading = |i: &u32| self.environment.units[*i as usize].placement.heading;
        self.units_near(unit, at, TOLERANCE_M)
            .into_iter()
            .find(|i| turn_difference(heading(i), at.heading, period) <= TOLERANCE)
    }
}

impl Placer<'_> {
    /// Every set of placed units that matches a patch's units, once, ascending by its first unit, the patch and the turn.
    pub fn fit_patches(&self, index: &UnitIndex<'_>) -> Vec<FittedPatch> {
        let Self { library, patterns, .. } = self;
        let mut of_unit = vec![Vec::new(); library.units.units.len()];
        patterns.iter().enumerate().for_each(|(p, pattern)| of_unit[pattern.units[0].0].push(p));
        let mut seen = HashSet::new();
        let mut out = Vec::new();
        for (i, placed) in (0u32..).zip(&index.environment.units) {
            let period = library.period(placed.unit);
            let base = normalised(placed.placement, period);
            for &p in &of_unit[placed.unit] {
                let turns = library.units.units[placed.unit].symmetry.max(1);
                for turn in 0..turns {
                    let frame = base.compose(Placement::new(0.0, 0.0, 0.0, turn as f32 * period));
                    let Some(units) = self.matching_units(p, index, i, frame) else { continue };
                    let mut set = units.clone();
                    set.sort_unstable();
                    if seen.insert((p, set)) {
                        out.push(FittedPatch { patch: p as u32, placement: frame.with_wrapped_heading(), units });
                    }
                }
            }
        }
        out
    }

    /// Placed units of a patch in this frame, beginning with `first`.
    fn matching_units(&self, patch: usize, index: &UnitIndex<'_>, first: u32, frame: Placement) -> Option<Vec<u32>> {
        let mut units = vec![first];
        for &(unit, at) in &self.patterns[patch].units[1..] {
            let found = index.unit_at(unit, frame.compose(at), self.library.period(unit))?;
            if units.contains(&found) {
                return None;
            }
            units.push(found);
        }
        Some(units)
    }

    /// Instance across every edge of every tile; [`NONE`] without one.
    ///
    /// - returns the neighbours and, for each instance, the index of its first.
    pub fn neighbours(&self, index: &UnitIndex<'_>, fitted: &[FittedPatch]) -> (Vec<u32>, Vec<u32>) {
        let Self { patches, patterns, .. } = self;
        let is_tile = |f: &FittedPatch| patterns[f.patch as usize].is_tile;
        let tiles: HashMap<(u32, u32), u32> = fitted
            .iter()
            .enumerate()
            .filter(|(_, f)| is_tile(f))
            .map(|(i, f)| ((f.patch, f.units[0]), i as u32))
            .collect();
        let across = |f: &FittedPatch, edge: &EdgeRecord| {
            let [x, y, z] = edge.step;
            let place = f.placement.compose(Placement::new(x, y, z, 0.0));
            let unit = patterns[f.patch as usize].units[0].0;
            let other = |i: u32| tiles.get(&(f.patch, i)).copied();
            let heading = f.placement.heading;
            let same_way = |&i: &u32| turn_difference(fitted[i as usize].placement.heading, heading, TAU) <= TOLERANCE;
            index.units_near(unit, place, TOLERANCE_M).into_iter().filter_map(other).find(same_way).unwrap_or(NONE)
        };
        let (mut out, mut first) = (Vec::new(), Vec::with_capacity(fitted.len()));
        for f in fitted {
            first.push(out.len() as u32);
            if is_tile(f) {
                out.extend(patches.edges_of(f.patch as usize).iter().map(|e| across(f, e)));
            }
        }
        // At the tolerance, rounding may make only one of two instances find the other.
        for (i, f) in fitted.iter().enumerate() {
            for (e, edge) in patches.edges_of(f.patch as usize).iter().enumerate() {
                let at = first[i] as usize + e;
                let back = |o: u32| out[(first[o as usize] + edge.opposite) as usize];
                if out[at] != NONE && back(out[at]) != i as u32 {
                    out[at] = NONE;
                }
            }
        }
        (out, first)
    }
}
