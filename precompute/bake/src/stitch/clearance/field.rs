//! Distance field of a unit on a grid: most spheres are clearly inside or clearly outside, and need no exact distance.

use super::plan::GroundDistances;
use crate::environment::UnitGeometry;
use glam::Vec3;
use std::sync::Arc;

/// Answer of a distance field for a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) enum FieldAnswer {
    /// Clear of the unit by at least this distance (m).
    Clear(f32),
    /// Inside the unit.
    Within,
    /// Undecided: needs the exact geometry.
    Unsure,
}

/// Distances from a unit, in its frame.
#[derive(Clone, Debug)]
pub(in crate::stitch) struct DistanceField {
    /// The exact geometry.
    pub geometry: Arc<UnitGeometry>,
    /// Lowest corner of the grid.
    min: Vec3,
    /// Grid cells along x, y and z.
    size: [usize; 3],
    /// Distances at the centres of grid cells, in bytes.
    distances: Vec<u8>,
    /// The least distance of each column of grid cells (size[0] * size[2]).
    columns: Vec<f32>,
    /// The unit seen from above.
    pub plan: GroundDistances,
}

impl DistanceField {
    /// Edge length of a grid cell (m).
    const STEP_M: f32 = 0.04;
    /// Largest error of a distance by packing and rounding (m).
    const ROUNDING_M: f32 = 0.5 * PACKED_M + 1e-4;
    const STEPS_PER_M: f32 = 1.0 / Self::STEP_M;
    /// Extent of the grid beyond the unit's shapes: [`super::seen::SLACK_M`] beyond spheres of 0.08 m, those of a body
    /// a sixth larger than the default skeleton's that may be 0.05 m deep. Thicker spheres are distinguished less far;
    /// a wider grid takes more memory, and time to measure. Upper bound of the radius of spheres (m).
    pub const MARGIN_M: f32 = 0.33;
    /// Distance from the centre of a grid cell to its corners (m).
    const ERROR_M: f32 = 0.5 * 1.732_051 * Self::STEP_M;
    /// Largest difference between a distance in a grid cell and the stored one (m).
    pub const OFF_M: f32 = Self::ERROR_M + Self::ROUNDING_M;

    /// Most cells of a grid, one byte each.
    const MOST_CELLS: usize = 1 << 31;

    /// True for a unit whose grid would have more than [`Self::MOST_CELLS`].
    pub fn is_too_large(geometry: &UnitGeometry) -> bool {
        Self::size(geometry).into_iter().fold(1, usize::saturating_mul) > Self::MOST_CELLS
    }

    /// Grid cells along x, y and z.
    fn size(geometry: &UnitGeometry) -> [usize; 3] {
        let bounds = geometry.bounds.expanded(Self::MARGIN_M);
        let cells = |length: f32| (length / Self::STEP_M).ceil().max(0.0) as usize;
        if geometry.bounds.is_empty() { [0; 3] } else { (bounds.max - bounds.min).to_array().map(cells) }
    }

    /// Computes the field of a unit that is not too large.
    pub fn new(geometry: &Arc<UnitGeometry>) -> Self {
        let (bounds, size) = (geometry.bounds.expanded(Self::MARGIN_M), Self::size(geometry));
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
        let plan = GroundDistances::new([bounds.min.x, bounds.min.z], Self::STEP_M, [size[0], size[2]], is_touched);
        Self { geometry: Arc::clone(geometry), min: bounds.min, size, distances, columns, plan }
    }

    /// Lower bound of the distance from the unit to the vertical line through a place, at most [`Self::MARGIN_M`] (m).
    pub fn least_distance_to_line(&self, x: f32, z: f32) -> f32 {
        let at = [(x - self.min.x) / Self::STEP_M, (z - self.min.z) / Self::STEP_M];
        if at[0] < 0.0 || at[1] < 0.0 || at[0] >= self.size[0] as f32 || at[1] >= self.size[2] as f32 {
            return Self::MARGIN_M;
        }
        (self.columns[at[1] as usize * self.size[0] + at[0] as usize] - Self::ERROR_M).min(Self::MARGIN_M)
    }

    /// Approximate distance of the unit from the vertical line through a place, negative if the line passes through it;
    /// beyond the grid, from the box around it, added to its margin (m).
    pub fn distance_to_line(&self, x: f32, z: f32) -> f32 {
        let at = [(x - self.min.x) / Self::STEP_M, (z - self.min.z) / Self::STEP_M];
        let size = [self.size[0] as f32, self.size[2] as f32];
        let out = std::array::from_fn::<f32, 2, _>(|a| (-at[a]).max(at[a] - size[a]));
        if out[0] >= 0.0 || out[1] >= 0.0 {
            return Self::MARGIN_M + Self::STEP_M * out[0].max(out[1]);
        }
        self.columns[at[1] as usize * self.size[0] + at[0] as usize]
    }

    /// Grid cells of points; cells at the rim for points beyond the grid.
    pub fn cells<const N: usize>(&self, [x, y, z]: &[[f32; N]; 3]) -> [u32; N] {
        let last = self.size.map(|n| n.saturating_sub(1) as f32 + 0.5);
        let along =
            |v: f32, axis: usize| floor_steps(((v - self.min[axis]) * Self::STEPS_PER_M).max(0.5).min(last[axis]));
        let [x_cells, y_cells, _] = self.size.map(|n| n as u32);
        let mut out = [0; N];
        for (k, cell) in out.iter_mut().enumerate() {
            *cell = (along(z[k], 2) * y_cells + along(y[k], 1)) * x_cells + along(x[k], 0);
        }
        out
    }

    /// Approximate excess of a point's distance from the unit over `limit`: off by at most [`Self::OFF_M`] (m).
    ///
    /// - `cell`: from [`Self::cells`]; points beyond the grid are farther from the unit than that.
    /// - `limit`: excesses above [`Self::MARGIN_M`] less this are not distinguished (m).
    /// - returns less than any distance if only the exact geometry can tell.
    pub fn excess_estimate(&self, cell: u32, limit: f32) -> f32 {
        let is_known = limit - Self::ERROR_M >= LEAST_M || limit == f32::NEG_INFINITY;
        if is_known { unpacked(self.distances[cell as usize]) - limit } else { f32::NEG_INFINITY }
    }

    /// Excess of a point's distance from the unit over `limit`, as far as the grid can tell.
    ///
    /// - `limit`: (<= MARGIN_M - most)
    /// - `most`: larger excesses are not distinguished (m).
    pub fn excess_at(&self, p: Vec3, limit: f32, most: f32) -> FieldAnswer {
        let Some((at, cell)) = self.cell(p) else { return FieldAnswer::Clear(most) };
        if limit - Self::ERROR_M < LEAST_M {
            return FieldAnswer::Unsure;
        }
        let farther = unpacked(self.distances[cell]) - limit;
        let off = Self::rounding_error(at);
        if farther - off >= most.min(CLOSE_M) {
            return FieldAnswer::Clear((farther - off).min(most));
        }
        if farther < -off {
            return FieldAnswer::Within;
        }
        let [least, greatest] = self.distance_range(at, cell);
        if least >= limit {
            FieldAnswer::Clear((least - limit).min(most))
        } else if greatest < limit {
            FieldAnswer::Within
        } else {
            FieldAnswer::Unsure
        }
    }

    /// Range of the distance at a point: distances change by at most the way to a cell centre, and by nearly all of it
    /// if that lies beyond the point, seen from the unit.
    fn distance_range(&self, at: Vec3, cell: usize) -> [f32; 2] {
        let whole = truncated(at);
        let from_middle = at - whole - 0.5;
        let (packed, off) = (self.distances[cell], Self::rounding_error(at));
        let mut out = [unpacked(packed) - off, unpacked(packed) + off];
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        for (axis, stride) in strides.into_iter().enumerate() {
            for side in [-1.0, 1.0] {
                let other = whole[axis] + side;
                if other < 0.0 || other >= self.size[axis] as f32 {
                    continue;
                }
                let known = self.distances[if side < 0.0 { cell - stride } else { cell + stride }];
                let distance = (from_middle.length_squared() - 2.0 * side * from_middle[axis] + 1.0).sqrt()
                    * Self::STEP_M
                    + Self::ROUNDING_M;
                // The least and the greatest stored values may stand for less and for more.
                if known >= packed && known > 0 {
                    out[0] = out[0].max(unpacked(known) - distance);
                } else if known < packed {
                    out[1] = out[1].min(unpacked(known) + distance);
                }
            }
        }
        out
    }

    /// Exact excess of a point's distance from the unit over `limit`; `None` if it is nearer. Slow (m).
    ///
    /// - `most`: larger excesses are not distinguished (m).
    pub fn clearance(&self, p: Vec3, limit: f32, most: f32) -> Option<f32> {
        match self.geometry.distance_below(p, limit + most) {
            Some(distance) => (distance >= limit).then_some(distance - limit),
            None => Some(most),
        }
    }

    /// True if the unit is nearer to a point than `limit` (limit <= MARGIN_M).
    pub fn is_nearer(&self, p: Vec3, limit: f32) -> bool {
        match self.excess_at(p, limit, 0.0) {
            FieldAnswer::Clear(_) => false,
            FieldAnswer::Within => true,
            FieldAnswer::Unsure => self.clearance(p, limit, 0.0).is_none(),
        }
    }

    /// A point in steps from the grid's lowest corner, with its grid cell; `None` beyond the grid.
    fn cell(&self, p: Vec3) -> Option<(Vec3, usize)> {
        let at = (p - self.min) * Self::STEPS_PER_M;
        if at.cmplt(Vec3::ZERO).any() {
            return None;
        }
        let ([x, y, z], size) = (at.to_array().map(|v| v as u32 as usize), self.size);
        (x < size[0] && y < size[1] && z < size[2]).then_some((at, (z * size[1] + y) * size[0] + x))
    }

    /// Upper bound of the change of distance to the centre of the grid cell, including rounding (m).
    fn rounding_error(at: Vec3) -> f32 {
        (at - truncated(at) - 0.5).length() * Self::STEP_M + Self::ROUNDING_M
    }
}

/// Integer part of non-negative steps.
fn truncated(at: Vec3) -> Vec3 {
    Vec3::from(at.to_array().map(|v| v as i32 as f32))
}

/// Integer part of a number of steps, but one less for exactly an odd number, as ties round to even; read from the
/// mantissa, which vectorizes (>= 0.5, < 2^22).
fn floor_steps(steps: f32) -> u32 {
    const ONE_STEP: f32 = 8_388_608.0;
    (steps + (ONE_STEP - 0.5)).to_bits() & 0x007f_ffff
}

/// Unit of stored distances (m).
const PACKED_M: f32 = 0.0025;
/// Clearance above which more exactness is useless: a smaller one saves accesses to adjacent grid cells, but shortens
/// the moves of units after which bodies must be sampled again (m).
const CLOSE_M: f32 = 0.06;
/// Least distance that is distinguished (m).
const LEAST_M: f32 = -0.2;

/// A distance packed in a byte, so that the relevant part of a world's fields stays in the processor's cache.
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
            DistanceField::is_too_large(&UnitGeometry::new(&set.units[0]).unwrap())
        };
        assert!(!is_too_large("[100, 8, 100]") && !is_too_large("[9999, 1, 0.1]"));
        assert!(is_too_large("[100, 100, 100]") && is_too_large("[9999, 9999, 9999]"));
    }

    proptest! {
        #[test]
        fn says_what_the_exact_geometry_says(p in prop::array::uniform3(-0.8f32..1.5), limit in -0.1f32..0.2) {
            thread_local!(static FIELD: DistanceField = DistanceField::new(&post()));
            let p = Vec3::from(p);
            FIELD.with(|f| assert_eq!(f.is_nearer(p, limit), f.geometry.nearest(p, limit).is_some()));
        }

        #[test]
        fn is_no_clearer_than_the_exact_geometry_says(
            p in prop::array::uniform3(-0.8f32..1.5), limit in -0.1f32..0.12, most in 0.0f32..0.2
        ) {
            thread_local!(static FIELD: DistanceField = DistanceField::new(&post()));
            let p = Vec3::from(p);
            FIELD.with(|f| {
                let exact = f.geometry.distance(p) - limit;
                let [cell] = f.cells(&p.to_array().map(|v| [v]));
                assert!(f.excess_estimate(cell, limit) < most + DistanceField::OFF_M || exact >= most);
                let near = |found: f32| found <= exact + 1e-5 && found >= exact.min(most) - 0.08;
                match f.excess_at(p, limit, most) {
                    FieldAnswer::Clear(found) => assert!(near(found) && exact >= 0.0, "{found} {exact}"),
                    FieldAnswer::Within => assert!(exact < 0.0, "{exact}"),
                    FieldAnswer::Unsure => assert!(exact.abs() < 0.08, "{exact}"),
                }
                let found = f.clearance(p, limit, most);
                assert_eq!(found.is_none(), exact < 0.0);
                assert!(found.is_none_or(near));
            });
        }

        #[test]
        fn nothing_on_a_vertical_is_nearer_than_it_says(p in prop::array::uniform3(-0.8f32..1.5)) {
            thread_local!(static FIELD: DistanceField = DistanceField::new(&post()));
            let p = Vec3::from(p);
            FIELD.with(|f| {
                let (beside, exact) = (f.least_distance_to_line(p.x, p.z), f.geometry.distance(p));
                assert!(beside <= exact + 1e-4, "{beside} {exact}");
                assert!(beside <= DistanceField::MARGIN_M);
            });
        }
    }
}
