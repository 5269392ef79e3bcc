//! Distances from a unit on a grid: most balls are clearly in it or clearly not, and need no exact distance.

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
    distances: Vec<f32>,
}

impl Field {
    /// Edge length of a grid cell. [Unit: m]
    const STEP_M: f32 = 0.06;
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
                    distances.push(near.map_or(f32::INFINITY, |n| n.distance));
                }
            }
        }
        Self { geometry: Arc::clone(geometry), min: bounds.min, size, distances }
    }

    /// True where the unit is nearer to a point than `limit`. [Limit: limit <= MARGIN_M]
    pub fn is_nearer(&self, p: Vec3, limit: f32) -> bool {
        let at = (p - self.min) / Self::STEP_M;
        if at.cmplt(Vec3::ZERO).any() {
            return false;
        }
        let ([x, y, z], size) = (at.to_array().map(|v| v as usize), self.size);
        if x >= size[0] || y >= size[1] || z >= size[2] {
            return false;
        }
        let distance = self.distances[(z * size[1] + y) * size[0] + x];
        if distance - Self::ERROR_M >= limit {
            return false;
        }
        distance + Self::ERROR_M < limit || self.geometry.nearest(p, limit).is_some()
    }
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
    }
}
