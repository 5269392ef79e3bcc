//! Geometry of a unit object, computed once.

use super::{UnitObject, UnitSet, UnitSolid, mesh::MAX_TRIANGLES};
use glam::Vec3;
use std::sync::Arc;
use throng_geometry::{BoundingBox, BoundsTree};
use throng_motion::error::{BuildError, Result};

/// Height of a default region above the shapes, enough to hold the hips of a character on them (m).
const REGION_ABOVE: f32 = 1.2;

/// Margin of bounds in trees, against rounding (m).
pub(super) const ROUNDING: f32 = 1e-4;

/// Geometry of a unit object, in its frame.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitGeometry {
    /// Its pieces.
    pub solids: Vec<UnitSolid>,
    /// Box around the pieces; empty if there are none.
    pub bounds: BoundingBox,
    /// Region of hips: a pose with hips in it belongs to the unit.
    pub region: BoundingBox,
    /// True for floors, which are walked on.
    pub floor: bool,
    tree: BoundsTree,
}

/// Surface point of a unit that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestUnitPoint {
    /// Distance, negative inside boxes and bars (m).
    pub distance: f32,
    /// The nearest point of the surface (m).
    pub point: Vec3,
    /// Direction away from the surface there. Unit.
    pub normal: Vec3,
    /// Number of the solid.
    pub solid: usize,
}

impl UnitGeometry {
    /// Builds the geometry of a unit; meshes are read from their files.
    ///
    /// # Errors
    /// [`BuildError::Key`] of the shape, with its file and what is wrong in it.
    pub fn new(unit: &UnitObject) -> Result<Self> {
        let key = |i: usize| format!("shapes[{i}].mesh.file");
        let solid = |(i, shape)| UnitSolid::from_shape(shape).map_err(|e| BuildError::key(key(i), e));
        let solids = unit.shapes.iter().enumerate().map(solid).collect::<Result<Vec<_>, _>>()?;
        let each: Vec<BoundingBox> = solids.iter().map(UnitSolid::bounds).collect();
        let tree = BoundsTree::new(&each.iter().map(|b| b.expanded(ROUNDING)).collect::<Vec<_>>());
        let bounds = each.into_iter().fold(BoundingBox::EMPTY, BoundingBox::union);
        let region = match unit.region {
            Some(r) => BoundingBox { min: Vec3::from(r.min), max: Vec3::from(r.max) },
            None => BoundingBox { max: bounds.max + Vec3::Y * REGION_ABOVE, ..bounds },
        };
        Ok(Self { solids, bounds, region, floor: unit.floor, tree })
    }

    /// Nearest surface point to a point; `None` at `limit` or farther.
    ///
    /// - `p`: in the unit's frame (m).
    /// - `limit`: smaller is faster (m).
    pub fn nearest(&self, p: Vec3, limit: f32) -> Option<NearestUnitPoint> {
        let (solid, _) = self.find_below(p, limit)?;
        let s = self.solids[solid].nearest(p, limit)?;
        Some(NearestUnitPoint { distance: s.distance, point: s.point, normal: s.normal, solid })
    }

    /// Distance of a point, as in [`Self::nearest`] but faster; `None` at `limit` or farther, or without geometry (m).
    ///
    /// - `p`: in the unit's frame (m).
    /// - `limit`: smaller is faster (m).
    pub fn distance_below(&self, p: Vec3, limit: f32) -> Option<f32> {
        self.find_below(p, limit).map(|(_, distance)| distance)
    }

    /// Nearest solid and its distance; `None` at `limit` or farther.
    fn find_below(&self, p: Vec3, limit: f32) -> Option<(usize, f32)> {
        if self.bounds.distance(p) > limit.max(0.0) + ROUNDING {
            return None;
        }
        self.tree.nearest(p, limit, |i| self.solids[i].distance(p, limit))
    }

    /// Distance of a point, negative inside boxes and bars; infinite without geometry (m).
    pub fn distance(&self, p: Vec3) -> f32 {
        self.distance_below(p, f32::INFINITY).unwrap_or(f32::INFINITY)
    }
}

/// Builds the geometry of every unit (units.units.len()).
///
/// # Errors
/// As [`UnitGeometry::new`].
pub fn geometries(units: &UnitSet) -> Result<Vec<Arc<UnitGeometry>>> {
    with_triangles(units, MAX_TRIANGLES)
}

/// Builds the geometry of every unit, with at most `most` triangles in all.
pub(super) fn with_triangles(units: &UnitSet, most: usize) -> Result<Vec<Arc<UnitGeometry>>> {
    let mut triangles = 0;
    let one = |(i, unit)| {
        let within = |e: BuildError| e.within_key(&format!("units[{i}]"));
        let geometry = UnitGeometry::new(unit).map_err(within)?;
        let of_meshes = geometry.solids.iter().map(|s| if let UnitSolid::Mesh(t) = s { t.corners().len() } else { 0 });
        triangles += of_meshes.sum::<usize>();
        if triangles > most {
            let why =
                format!("the meshes of all units may have {most} triangles at most, found more; make them simpler");
            return Err(within(BuildError::key("shapes", why)));
        }
        Ok(Arc::new(geometry))
    };
    units.units.iter().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::path::Path;

    fn ladder() -> UnitGeometry {
        let text = "[[units]]\nname = \"ladder\"\nshapes = [\n\
            { box = { at = [0.0, 1.0, 0.1], size = [0.6, 2.0, 0.04] } },\n\
            { bar = { from = [-0.3, 0.3, 0.0], to = [0.3, 0.3, 0.0], radius = 0.02 } },\n\
            { bar = { from = [-0.3, 0.6, 0.0], to = [0.3, 0.6, 0.0], radius = 0.02 } },\n\
            { bar = { from = [-0.3, 0.9, 0.0], to = [0.3, 0.9, 0.0], radius = 0.02 } },\n\
            { bar = { from = [-0.3, 1.2, 0.0], to = [0.3, 1.2, 0.0], radius = 0.02 } },\n\
            { bar = { from = [-0.3, 1.5, 0.0], to = [0.3, 1.5, 0.0], radius = 0.02 } }]\n";
        UnitGeometry::new(&UnitSet::parse(text, Path::new("u.toml")).unwrap().units[0]).unwrap()
    }

    proptest! {
        #[test]
        fn the_nearest_of_all_solids_is_found(p in prop::array::uniform3(-2.0f32..2.0), limit in 0.01f32..3.0) {
            let (g, p) = (ladder(), Vec3::from(p));
            let scan = g.solids.iter().map(|s| s.nearest(p, 99.0).unwrap().distance).fold(f32::INFINITY, f32::min);
            prop_assert_eq!(g.distance(p), scan);
            prop_assert_eq!(g.nearest(p, limit).map(|n| n.distance), Some(scan).filter(|s| *s < limit));
            prop_assert_eq!(g.distance_below(p, limit), Some(scan).filter(|s| *s < limit));
        }
    }

    #[test]
    fn regions_reach_above_the_shapes_unless_they_are_named() {
        let g = ladder();
        assert!((g.region.max.y - 3.2).abs() < 1e-6 && g.region.min == g.bounds.min);
        let text = "[[units]]\nname = \"a\"\nregion = { min = [0.0, 0.0, 0.0], max = [1.0, 2.0, 3.0] }\n";
        let g = UnitGeometry::new(&UnitSet::parse(text, Path::new("u.toml")).unwrap().units[0]).unwrap();
        assert_eq!(g.region, BoundingBox { min: Vec3::ZERO, max: Vec3::new(1.0, 2.0, 3.0) });
        assert_eq!((g.distance(Vec3::ZERO), g.nearest(Vec3::ZERO, 1.0)), (f32::INFINITY, None));
    }
}
