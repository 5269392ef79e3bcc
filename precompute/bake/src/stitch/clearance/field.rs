//! Distances from a unit on a grid: most balls are clearly in it or clearly not, and need no exact distance.

use super::plan::Plan;
use crate::environment::UnitGeometry;
use glam::Vec3;
use std::sync::Arc;

/// What a grid tells of a ball beside a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) enum Told {
    /// It is clear of the unit by so much at least (m).
    Clear(f32),
    /// It is in the unit.
    Within,
    /// Only the exact geometry tells.
    Unsure,
}

/// Distances from a unit, in its frame.
#[derive(Clone, Debug)]
pub(in crate::stitch) struct Field {
    /// The exact geometry.
    pub geometry: Arc<UnitGeometry>,
    /// Lowest corner of the grid.
    min: Vec3,
    /// Grid cells along x, y and z.
    size: [usize; 3],
    /// Of the middles of grid cells, in bytes.
    distances: Vec<u8>,
    /// The least distance of each column of grid cells (size[0] * size[2]).
    columns: Vec<f32>,
    plan: Plan,
}

impl Field {
    /// Edge length of a grid cell (m).
    const STEP_M: f32 = 0.04;
    /// No distance is off by more than this because of how it is kept, and rounding (m).
    const ROUNDING_M: f32 = 0.5 * PACKED_M + 1e-4;
    const STEPS_PER_M: f32 = 1.0 / Self::STEP_M;
    /// The grid reaches this far from the unit's shapes: [`super::seen::SLACK_M`] beyond balls of 0.08 m, as a body has
    /// that is a sixth larger than the default skeleton's and may be 0.05 m deep. Beyond thicker balls, less is told
    /// apart; a wider grid takes more memory, and time to measure. No ball may be thicker than this (m).
    pub const MARGIN_M: f32 = 0.33;
    /// From the middle of a grid cell to its corners (m).
    const ERROR_M: f32 = 0.5 * 1.732_051 * Self::STEP_M;
    /// No distance in a grid cell is farther than this from what is kept of it (m).
    pub const OFF_M: f32 = Self::ERROR_M + Self::ROUNDING_M;

    /// Most cells of a grid, a byte each.
    const MOST_CELLS: usize = 1 << 31;

    /// True for a unit whose grid would have more than [`Self::MOST_CELLS`].
    pub fn is_too_large(geometry: &UnitGeometry) -> bool {
        Self::size(geometry).into_iter().fold(1, usize::saturating_mul) > Self::MOST_CELLS
    }

    /// Grid cells along x, y and z.
    fn size(geometry: &UnitGeometry) -> [usize; 3] {
        let bounds = geometry.bounds.grown(Self::MARGIN_M);
        let cells = |length: f32| (length / Self::STEP_M).ceil().max(0.0) as usize;
        match geometry.bounds.is_empty() {
            true => [0; 3],
            false => (bounds.max - bounds.min).to_array().map(cells),
        }
    }

    /// Measures a unit that is not too large.
    pub fn new(geometry: &Arc<UnitGeometry>) -> Self {
        let (bounds, size) = (geometry.bounds.grown(Self::MARGIN_M), Self::size(geometry));
        let mut distances = Vec::with_capacity(size.iter().product());
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let middle = bounds.min + (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * Self::STEP_M;
                    let near = geometry.distance_below(middle, Self::MARGIN_M + Self::ERROR_M);
                    distances.push(packed(near.unwrap_or(f32::INFINITY)));
                }
            }
        }
        let column = |c: usize| {
            let first = c / size[0] * size[0] * size[1] + c % size[0];
            unpacked((0..size[1]).map(|y| distances[first + y * size[0]]).min().unwrap_or(u8::MAX)) - 0.5 * PACKED_M
        };
        let columns: Vec<f32> = (0..size[0] * size[2]).map(column).collect();
        let is_touched = |c: usize| columns[c] <= Self::ERROR_M;
        let plan = Plan::new([bounds.min.x, bounds.min.z], Self::STEP_M, [size[0], size[2]], is_touched);
        Self { geometry: Arc::clone(geometry), min: bounds.min, size, distances, columns, plan }
    }

    /// The unit as seen from above.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The unit is nowhere nearer to the vertical line through a place than this, which is no more than
    /// [`Self::MARGIN_M`] (m).
    pub fn beside(&self, x: f32, z: f32) -> f32 {
        let at = [(x - self.min.x) / Self::STEP_M, (z - self.min.z) / Self::STEP_M];
        if at[0] < 0.0 || at[1] < 0.0 || at[0] >= self.size[0] as f32 || at[1] >= self.size[2] as f32 {
            return Self::MARGIN_M;
        }
        (self.columns[at[1] as usize * self.size[0] + at[0] as usize] - Self::ERROR_M).min(Self::MARGIN_M)
    }

    /// About how far the unit is from the vertical line through a place, below 0 where the line passes through it; for
    /// what is beyond the grid, from the box around it, added to its margin (m).
    pub fn far(&self, x: f32, z: f32) -> f32 {
        let at = [(x - self.min.x) / Self::STEP_M, (z - self.min.z) / Self::STEP_M];
        let size = [self.size[0] as f32, self.size[2] as f32];
        let out = std::array::from_fn::<f32, 2, _>(|a| (-at[a]).max(at[a] - size[a]));
        if out[0] >= 0.0 || out[1] >= 0.0 {
            return Self::MARGIN_M + Self::STEP_M * out[0].max(out[1]);
        }
        self.columns[at[1] as usize * self.size[0] + at[0] as usize]
    }

    /// The grid cells that points are in; for those beyond the grid, others at its rim.
    pub fn cells<const N: usize>(&self, [x, y, z]: &[[f32; N]; 3]) -> [u32; N] {
        let last = self.size.map(|n| n.saturating_sub(1) as f32 + 0.5);
        let along = |v: f32, axis: usize| whole(((v - self.min[axis]) * Self::STEPS_PER_M).max(0.5).min(last[axis]));
        let [x_cells, y_cells, _] = self.size.map(|n| n as u32);
        let mut out = [0; N];
        for (k, cell) in out.iter_mut().enumerate() {
            *cell = (along(z[k], 2) * y_cells + along(y[k], 1)) * x_cells + along(x[k], 0);
        }
        out
    }

    /// About how much farther than `limit` a point in a cell is from the unit: [`Self::OFF_M`] less or more (m).
    ///
    /// - `cell`: as [`Self::cells`]; what is beyond the grid is farther from the unit than that.
    /// - `limit`: what is farther than [`Self::MARGIN_M`] less this is not told apart (m).
    /// - returns less than any distance where only the exact geometry tells.
    pub fn about(&self, cell: u32, limit: f32) -> f32 {
        let is_told = limit - Self::ERROR_M >= LEAST_M || limit == f32::NEG_INFINITY;
        if is_told { unpacked(self.distances[cell as usize]) - limit } else { f32::NEG_INFINITY }
    }

    /// How much farther than `limit` the unit is from a point, as far as the grid tells.
    ///
    /// - `limit`: (<= MARGIN_M - most)
    /// - `most`: what is clearer is not told apart (m).
    pub fn told(&self, p: Vec3, limit: f32, most: f32) -> Told {
        let Some((at, cell)) = self.cell(p) else { return Told::Clear(most) };
        if limit - Self::ERROR_M < LEAST_M {
            return Told::Unsure;
        }
        let farther = unpacked(self.distances[cell]) - limit;
        let off = Self::off(at);
        if farther - off >= most.min(CLOSE_M) {
            return Told::Clear((farther - off).min(most));
        }
        if farther < -off {
            return Told::Within;
        }
        let [least, greatest] = self.between(at, cell);
        if least >= limit {
            Told::Clear((least - limit).min(most))
        } else if greatest < limit {
            Told::Within
        } else {
            Told::Unsure
        }
    }

    /// The least and the greatest distance that a point may have: distances change by no more than the way to where they
    /// are known, and beyond the point, as seen from the unit, that is nearly what they change by.
    fn between(&self, at: Vec3, cell: usize) -> [f32; 2] {
        let whole = truncated(at);
        let from_middle = at - whole - 0.5;
        let (packed, off) = (self.distances[cell], Self::off(at));
        let mut out = [unpacked(packed) - off, unpacked(packed) + off];
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        for (axis, stride) in strides.into_iter().enumerate() {
            for side in [-1.0, 1.0] {
                let other = whole[axis] + side;
                if other < 0.0 || other >= self.size[axis] as f32 {
                    continue;
                }
                let known = self.distances[if side < 0.0 { cell - stride } else { cell + stride }];
                let way = (from_middle.length_squared() - 2.0 * side * from_middle[axis] + 1.0).sqrt() * Self::STEP_M
                    + Self::ROUNDING_M;
                // The least and the greatest of what is kept may stand for less and for more.
                if known >= packed && known > 0 {
                    out[0] = out[0].max(unpacked(known) - way);
                } else if known < packed {
                    out[1] = out[1].min(unpacked(known) + way);
                }
            }
        }
        out
    }

    /// How much farther than `limit` the unit is from a point; none where it is nearer. Slow (m).
    ///
    /// - `most`: what is clearer is not told apart (m).
    pub fn clearance(&self, p: Vec3, limit: f32, most: f32) -> Option<f32> {
        match self.geometry.distance_below(p, limit + most) {
            Some(distance) => (distance >= limit).then_some(distance - limit),
            None => Some(most),
        }
    }

    /// True where the unit is nearer to a point than `limit` (limit <= MARGIN_M).
    pub fn is_nearer(&self, p: Vec3, limit: f32) -> bool {
        match self.told(p, limit, 0.0) {
            Told::Clear(_) => false,
            Told::Within => true,
            Told::Unsure => self.clearance(p, limit, 0.0).is_none(),
        }
    }

    /// A point in steps from the grid's lowest corner, and the number of its grid cell; none beyond the grid.
    fn cell(&self, p: Vec3) -> Option<(Vec3, usize)> {
        let at = (p - self.min) * Self::STEPS_PER_M;
        if at.cmplt(Vec3::ZERO).any() {
            return None;
        }
        let ([x, y, z], size) = (at.to_array().map(|v| v as u32 as usize), self.size);
        (x < size[0] && y < size[1] && z < size[2]).then_some((at, (z * size[1] + y) * size[0] + x))
    }

    /// Distances change by no more than the way to the middle of the grid cell, and rounding (m).
    fn off(at: Vec3) -> f32 {
        (at - truncated(at) - 0.5).length() * Self::STEP_M + Self::ROUNDING_M
    }
}

/// Whole steps, which are 0 or more.
fn truncated(at: Vec3) -> Vec3 {
    Vec3::from(at.to_array().map(|v| v as i32 as f32))
}

/// The whole part of a number of steps, but one less for exactly an odd number, as ties are rounded to even; the mantissa
/// says it, of which processors take many at a time (>= 0.5, < 2^22).
fn whole(steps: f32) -> u32 {
    const ONE_STEP: f32 = 8_388_608.0;
    (steps + (ONE_STEP - 0.5)).to_bits() & 0x007f_ffff
}

/// Steps in which distances are kept (m).
const PACKED_M: f32 = 0.0025;
/// What is clearer than this need not be told more exactly: a smaller one saves looks at the grid cells beside, but units
/// can be moved less far before bodies are looked at again (m).
const CLOSE_M: f32 = 0.06;
/// The least distance that is told from others (m).
const LEAST_M: f32 = -0.2;

/// A distance in a byte: of a world's units, those that matter stay at hand.
fn packed(distance: f32) -> u8 {
    ((distance - LEAST_M) / PACKED_M).round() as u8
}

fn unpacked(packed: u8) -> f32 {
    LEAST_M + PACKED_M * f32::from(packed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::UnitSet;
    use proptest::prelude::*;
    use std::path::Path;

    fn post() -> Arc<UnitGeometry> {
        let text = "[[units]]\nname = \"post\"\nshapes = [{ bar = { from = [0.0, 0.0, 0.0], to = [0.3, 1.0, 0.0], radius \
                    = 0.1 } }, { box = { at = [0.0, 0.1, 0.0], size = [0.5, 0.2, 0.4], pitch_deg = 20.0 } }]\n";
        Arc::new(UnitGeometry::new(&UnitSet::parse(text, Path::new("u.toml")).unwrap().units[0]).unwrap())
    }

    #[test]
    fn a_unit_of_a_hundred_metres_is_too_large_where_it_is_as_high() {
        let is_too_large = |size: &str| {
            let text =
                format!("[[units]]\nname = \"hall\"\nshapes = [{{ box = {{ at = [0, 0, 0], size = {size} }} }}]\n");
            let set = UnitSet::parse(&text, Path::new("u.toml")).unwrap();
            Field::is_too_large(&UnitGeometry::new(&set.units[0]).unwrap())
        };
        assert!(!is_too_large("[100, 8, 100]") && !is_too_large("[9999, 1, 0.1]"));
        assert!(is_too_large("[100, 100, 100]") && is_too_large("[9999, 9999, 9999]"));
    }

    proptest! {
        #[test]
        fn says_what_the_exact_geometry_says(p in prop::array::uniform3(-0.8f32..1.5), limit in -0.1f32..0.2) {
            thread_local!(static FIELD: Field = Field::new(&post()));
            let p = Vec3::from(p);
            FIELD.with(|f| assert_eq!(f.is_nearer(p, limit), f.geometry.nearest(p, limit).is_some()));
        }

        #[test]
        fn is_no_clearer_than_the_exact_geometry_says(
            p in prop::array::uniform3(-0.8f32..1.5), limit in -0.1f32..0.12, most in 0.0f32..0.2
        ) {
            thread_local!(static FIELD: Field = Field::new(&post()));
            let p = Vec3::from(p);
            FIELD.with(|f| {
                let exact = f.geometry.distance(p) - limit;
                let [cell] = f.cells(&p.to_array().map(|v| [v]));
                assert!(f.about(cell, limit) < most + Field::OFF_M || exact >= most);
                let near = |found: f32| found <= exact + 1e-5 && found >= exact.min(most) - 0.08;
                match f.told(p, limit, most) {
                    Told::Clear(found) => assert!(near(found) && exact >= 0.0, "{found} {exact}"),
                    Told::Within => assert!(exact < 0.0, "{exact}"),
                    Told::Unsure => assert!(exact.abs() < 0.08, "{exact}"),
                }
                let found = f.clearance(p, limit, most);
                assert_eq!(found.is_none(), exact < 0.0);
                assert!(found.is_none_or(near));
            });
        }

        #[test]
        fn nothing_on_a_vertical_is_nearer_than_it_says(p in prop::array::uniform3(-0.8f32..1.5)) {
            thread_local!(static FIELD: Field = Field::new(&post()));
            let p = Vec3::from(p);
            FIELD.with(|f| {
                let (beside, exact) = (f.beside(p.x, p.z), f.geometry.distance(p));
                assert!(beside <= exact + 1e-4, "{beside} {exact}");
                assert!(beside <= Field::MARGIN_M);
            });
        }
    }
}
