//! Geometry of placed units and the ground.

use super::geometry::{ROUNDING, UnitGeometry};
use super::{Environment, PlacedUnit};
use glam::Vec3;
use std::sync::Arc;
use throng_core::patch::Placement;
use throng_geometry::{BoundingBox, BoundsTree};

/// The geometry of an environment: placed units, and the ground y = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedGeometry {
    /// The environment's name.
    pub name: String,
    /// Placed units.
    pub units: Vec<PlacedUnit>,
    geometries: Vec<Arc<UnitGeometry>>,
    tree: BoundsTree,
}

/// Surface point of an environment that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchedSurface {
    /// Number of the placed unit; `None` for the ground.
    pub unit: Option<usize>,
    /// Distance, negative inside boxes, bars and the ground (m).
    pub distance: f32,
    /// The nearest point of the surface, in the world (m).
    pub point: Vec3,
    /// Direction away from the surface there. Unit.
    pub normal: Vec3,
}

impl PlacedGeometry {
    /// The geometry of an environment.
    ///
    /// - `geometries`: of every unit of the set that the environment's numbers index.
    pub fn new(environment: &Environment, geometries: &[Arc<UnitGeometry>]) -> Self {
        let of =
            |u: &PlacedUnit| geometries[u.unit].bounds.mapped(|p| u.placement.transform_point(p)).expanded(ROUNDING);
        let bounds: Vec<BoundingBox> = environment.units.iter().map(of).collect();
        let (name, units) = (environment.name.clone(), environment.units.clone());
        Self { name, units, geometries: geometries.to_vec(), tree: BoundsTree::new(&bounds) }
    }

    /// Geometry of a placed unit in its own frame (unit < units.len()).
    pub fn geometry(&self, unit: usize) -> &UnitGeometry {
        &self.geometries[self.units[unit].unit]
    }

    /// Placement of a placed unit (unit < units.len()).
    pub fn placement(&self, unit: usize) -> Placement {
        self.units[unit].placement
    }

    /// Nearest surface point to a point of the world; `None` at `limit` or farther. On a tie, a unit precedes the
    /// ground.
    pub fn nearest(&self, p: Vec3, limit: f32) -> Option<TouchedSurface> {
        let distance = |i: usize| self.nearest_of_unit(i, p, limit).map_or(f32::INFINITY, |t| t.distance);
        let unit = self.tree.nearest(p, limit, distance).and_then(|(i, _)| self.nearest_of_unit(i, p, limit));
        let ground = TouchedSurface { unit: None, distance: p.y, point: p.with_y(0.0), normal: Vec3::Y };
        match unit {
            Some(u) if u.distance <= ground.distance => Some(u),
            _ => Some(ground).filter(|g| g.distance < limit).or(unit),
        }
    }

    /// Nearest surface point of one placed unit to a point of the world; `None` at `limit` or farther.
    pub fn nearest_of_unit(&self, unit: usize, p: Vec3, limit: f32) -> Option<TouchedSurface> {
        let at = self.placement(unit);
        let n = self.geometry(unit).nearest(at.inverse_transform_point(p), limit)?;
        let normal = at.planar().rotation() * n.normal;
        Some(TouchedSurface { unit: Some(unit), distance: n.distance, point: at.transform_point(n.point), normal })
    }

    /// Calls `visit` for every placed unit whose shapes may lie in a box of the world.
    pub fn overlapping(&self, bounds: &BoundingBox, visit: impl FnMut(usize)) {
        self.tree.overlapping(bounds, visit);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{EnvironmentFile, UnitSet, geometries};
    use super::*;
    use proptest::prelude::*;
    use std::path::Path;

    /// Builds units and their placements from TOML.
    pub fn placed(units: &str, place: &str) -> PlacedGeometry {
        let path = Path::new("u.toml");
        let units = UnitSet::parse(units, path).unwrap();
        let file: EnvironmentFile = toml::from_str(&format!("units = \"u.toml\"\nplace = [{place}]\n")).unwrap();
        PlacedGeometry::new(&file.expand(&units, path).unwrap(), &geometries(&units).unwrap())
    }

    fn yard() -> PlacedGeometry {
        let units = "[[units]]\nname = \"step\"\nshapes = [{ box = { at = [0.0, 0.1, 0.0], size = [2.0, 0.2, 0.5] } }]\n\
                     [[units]]\nname = \"post\"\nshapes = [{ bar = { from = [0.0, 0.0, 0.0], to = [0.0, 2.0, 1.0], \
                     radius = 0.1 } }]\n";
        placed(
            units,
            "{ unit = \"step\", at = [0.0, 0.0, 1.0], repeat = [3, 1, 1], step = [[0.0, 0.2, 0.5], [0.0, 0.0, 0.0], \
             [0.0, 0.0, 0.0]] }, { unit = \"post\", at = [1.0, 0.5, -2.0], heading_deg = 70.0 }",
        )
    }

    proptest! {
        #[test]
        fn the_nearest_of_all_units_and_the_ground_is_found(p in prop::array::uniform3(-3.0f32..3.0)) {
            let (yard, p) = (yard(), Vec3::from(p));
            let found = yard.nearest(p, 50.0).unwrap();
            let scan = (0..yard.units.len()).map(|u| yard.nearest_of_unit(u, p, 99.0).unwrap().distance);
            prop_assert_eq!(found.distance, scan.fold(p.y, f32::min));
            prop_assert!((found.point.distance(p) - found.distance.abs()).abs() < 1e-3);
            let outside = yard.nearest(found.point + found.normal * 0.004, 9.0).unwrap().distance;
            prop_assert!(outside < 0.0041, "{}", outside);
        }
    }

    #[test]
    fn a_tread_is_nearer_than_the_ground_below_and_is_named() {
        let yard = yard();
        let t = yard.nearest(Vec3::new(0.3, 0.43, 1.5), 0.1).unwrap();
        assert_eq!(t.unit, Some(1));
        assert!((t.point.y - 0.4).abs() < 1e-6 && (t.normal - Vec3::Y).length() < 1e-5);
        let t = yard.nearest(Vec3::new(0.3, 0.03, 0.5), 0.1).unwrap();
        assert_eq!((t.unit, t.point.y), (None, 0.0));
        assert_eq!(yard.nearest(Vec3::new(0.0, 3.0, 0.0), 0.1), None);
    }
}
