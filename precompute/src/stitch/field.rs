//! Distances from a unit on a grid: most balls are clearly in it or clearly not, and need no exact distance.

use super::plan::Plan;
use crate::environment::UnitGeometry;
use glam::Vec3;
use std::sync::Arc;

/// Distances from a unit, in its frame.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// The exact geometry.
    pub geometry: Arc<UnitGeometry>,
    /// Lowest corner of the grid.
    min: Vec3,
    /// Grid cells along x, y and z.
    size: [usize; 3],
    /// Of the middles of grid cells, in bytes.
    distances: Vec<u8>,
    /// The least distance of each column of grid cells. [Size: size[0] * size[2]]
    columns: Vec<f32>,
    plan: Plan,
}

impl Field {
    /// Edge length of a grid cell. [Unit: m]
    const STEP_M: f32 = 0.04;
    /// No distance is off by more than this because of how it is kept, and rounding. [Unit: m]
    const ROUNDING_M: f32 = 0.5 * PACKED_M + 1e-4;
    const STEPS_PER_M: f32 = 1.0 / Self::STEP_M;
    /// The grid reaches this far from the unit's shapes. No ball may be thicker. [Unit: m]
    pub const MARGIN_M: f32 = 0.2;
    /// From the middle of a grid cell to its corners. [Unit: m]
    const ERROR_M: f32 = 0.5 * 1.732_051 * Self::STEP_M;

    /// Measures a unit.
    pub fn new(geometry: &Arc<UnitGeometry>) -> Self {
        let bounds = geometry.bounds.grown(Self::MARGIN_M);
        let cells = |length: f32| (length / Self::STEP_M).ceil().max(0.0) as usize;
        let size = match geometry.bounds.is_empty() {
            true => [0; 3],
            false => (bounds.max - bounds.min).to_array().map(cells),
        };
        let mut distances = Vec::with_capacity(size.iter().product());
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let middle = bounds.min + (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * Self::STEP_M;
                    let near = geometry.nearest(middle, Self::MARGIN_M + Self::ERROR_M);
                    distances.push(packed(near.map_or(f32::INFINITY, |n| n.distance)));
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
    /// [`Self::MARGIN_M`]. [Unit: m]
    pub fn beside(&self, x: f32, z: f32) -> f32 {
        let at = [(x - self.min.x) / Self::STEP_M, (z - self.min.z) / Self::STEP_M];
        if at[0] < 0.0 || at[1] < 0.0 || at[0] >= self.size[0] as f32 || at[1] >= self.size[2] as f32 {
            return Self::MARGIN_M;
        }
        (self.columns[at[1] as usize * self.size[0] + at[0] as usize] - Self::ERROR_M).min(Self::MARGIN_M)
    }

    /// About how far the unit is from the vertical line through a place, below 0 where the line passes through it; for
    /// what is beyond the grid, from the box around it, added to its margin. [Unit: m]
    pub fn far(&self, x: f32, z: f32) -> f32 {
        let at = [(x - self.min.x) / Self::STEP_M, (z - self.min.z) / Self::STEP_M];
        let size = [self.size[0] as f32, self.size[2] as f32];
        let out = std::array::from_fn::<f32, 2, _>(|a| (-at[a]).max(at[a] - size[a]));
        if out[0] >= 0.0 || out[1] >= 0.0 {
            return Self::MARGIN_M + Self::STEP_M * out[0].max(out[1]);
        }
        self.columns[at[1] as usize * self.size[0] + at[0] as usize]
    }

    /// How much farther than `limit` the unit is from a point, or a little less; none where it is nearer. [Unit: m]
    ///
    /// - `limit`: [Limit: <= MARGIN_M - most]
    /// - `most`: what is more is not told apart.
    pub fn clearance(&self, p: Vec3, limit: f32, most: f32) -> Option<f32> {
        let Some((at, cell)) = self.cell(p) else { return Some(most) };
        let exact = || match self.geometry.nearest(p, limit + most) {
            Some(near) => (near.distance >= limit).then_some(near.distance - limit),
            None => Some(most),
        };
        if limit - Self::ERROR_M < LEAST_M {
            return exact();
        }
        let distance = unpacked(self.distances[cell]);
        if distance - Self::ERROR_M - Self::ROUNDING_M >= limit + most {
            return Some(most);
        }
        let off = Self::off(at);
        match distance - off - limit {
            clear if clear >= 0.0 => Some(clear.min(most)),
            _ if distance + off < limit => None,
            _ => exact(),
        }
    }

    /// True where the unit is nearer to a point than `limit`. [Limit: limit <= MARGIN_M]
    pub fn is_nearer(&self, p: Vec3, limit: f32) -> bool {
        let Some((at, cell)) = self.cell(p) else { return false };
        if limit - Self::ERROR_M < LEAST_M {
            return self.geometry.nearest(p, limit).is_some();
        }
        let distance = unpacked(self.distances[cell]);
        if distance - Self::ERROR_M - Self::ROUNDING_M >= limit {
            return false;
        }
        let off = Self::off(at);
        if distance - off >= limit {
            return false;
        }
        distance + off < limit || self.geometry.nearest(p, limit).is_some()
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

    /// Distances change by no more than the way to the middle of the grid cell, and rounding. [Unit: m]
    fn off(at: Vec3) -> f32 {
        // Whole steps are 0 or more.
        let whole = Vec3::from(at.to_array().map(|v| v as u32 as f32));
        (at - whole - 0.5).length() * Self::STEP_M + Self::ROUNDING_M
    }
}

/// Steps in which distances are kept. [Unit: m]
const PACKED_M: f32 = 0.002;
/// The least distance that is told from others. [Unit: m]
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

    proptest! {
        #[test]
        fn says_what_the_exact_geometry_says(p in prop::array::uniform3(-0.8f32..1.5), limit in -0.1f32..0.2) {
            thread_local!(static FIELD: Field = Field::new(&post()));
            let p = Vec3::from(p);
            FIELD.with(|f| assert_eq!(f.is_nearer(p, limit), f.geometry.nearest(p, limit).is_some()));
        }

        #[test]
        fn is_no_clearer_than_the_exact_geometry_says(
            p in prop::array::uniform3(-0.8f32..1.5), limit in -0.1f32..0.1, most in 0.0f32..0.1
        ) {
            thread_local!(static FIELD: Field = Field::new(&post()));
            let p = Vec3::from(p);
            FIELD.with(|f| {
                let (found, exact) = (f.clearance(p, limit, most), f.geometry.distance(p) - limit);
                assert_eq!(found.is_none(), exact < 0.0);
                assert!(found.is_none_or(|found| found <= exact + 1e-5 && found >= exact.min(most) - 0.08));
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
