//! Overlapping units, which make an environment invalid.

use super::{near::overlapping_pairs, place_patches::Placer};
use crate::environment::{Environment, UnitObject, UnitShape};
use crate::stitch::library::{Library, refusal_error, turn_difference};
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_core::patch::Placement;
use throng_geometry::BoundingBox;
use throng_motion::error::Result;

/// Largest distance of copies of a unit in the same place (m).
const SAME_PLACE_M: f32 = 0.05;

/// A box with any orientation.
#[derive(Clone, Copy, Debug)]
struct OrientedBox {
    centre: Vec3,
    axes: [Vec3; 3],
    half: Vec3,
}

impl OrientedBox {
    /// Box of a shape; bars and triangles are not solid.
    fn from_shape(shape: &UnitShape) -> Option<Self> {
        let UnitShape::Box { at, size, heading_deg, pitch_deg } = shape else { return None };
        let [heading, pitch] = [heading_deg, pitch_deg].map(|deg| deg.to_radians());
        let turn = maths::compose(Quat::from_rotation_y(heading), Quat::from_rotation_x(pitch));
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|a| turn * a);
        Some(Self { centre: Vec3::from_array(*at), axes, half: Vec3::from_array(*size) * 0.5 })
    }

    fn transformed(&self, at: Placement) -> Self {
        let turn = Quat::from_rotation_y(at.heading);
        Self { centre: at.transform_point(self.centre), axes: self.axes.map(|a| turn * a), half: self.half }
    }

    /// Extent from the centre along a direction (m).
    fn half_extent(&self, direction: Vec3) -> f32 {
        (0..3).map(|k| self.half[k] * self.axes[k].dot(direction).abs()).sum()
    }

    fn bounds(&self) -> BoundingBox {
        let r = Vec3::new(self.half_extent(Vec3::X), self.half_extent(Vec3::Y), self.half_extent(Vec3::Z));
        BoundingBox { min: self.centre - r, max: self.centre + r }
    }

    /// Penetration depth of two boxes: the least overlap along the directions that can separate them.
    fn overlap_depth(&self, other: &Self) -> f32 {
        let crossed = self.axes.iter().flat_map(|a| other.axes.iter().map(|b| a.cross(*b)));
        let directions = self.axes.into_iter().chain(other.axes).chain(crossed);
        directions
            .filter_map(Vec3::try_normalize)
            .map(|d| self.half_extent(d) + other.half_extent(d) - (self.centre - other.centre).dot(d).abs())
            .fold(f32::INFINITY, f32::min)
    }
}

impl Placer<'_> {
    /// Checks that no unit overlaps another.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Stage`] names two that do.
    pub fn check_overlaps(&self, environment: &Environment) -> Result<()> {
        let (library, depth_m) = (&self.library, self.config.overlap_m);
        let boxes_of = |unit: &UnitObject| unit.shapes.iter().filter_map(OrientedBox::from_shape).collect();
        let solids: Vec<Vec<OrientedBox>> = library.units.units.iter().map(boxes_of).collect();
        let units = (0u32..).zip(&environment.units);
        let boxes = units.flat_map(|(i, u)| solids[u.unit].iter().map(move |s| (i, s.transformed(u.placement))));
        let placed: Vec<(u32, OrientedBox)> = boxes.collect();
        let refuse = |a: u32, b: u32, how: String| {
            let [a, b] = [a, b].map(|unit| library.describe(environment, unit as usize));
            refusal_error(environment, format!("{a} and {b} {how}"), "Move or remove one of them")
        };
        if let Some((a, b)) = same_place(library, environment) {
            return Err(refuse(a, b, "stand in the same place".into()));
        }
        let bounds: Vec<BoundingBox> = placed.iter().map(|(_, s)| s.bounds().expanded(-0.5 * depth_m)).collect();
        for (i, j) in overlapping_pairs(&bounds, &bounds) {
            let ((a, one), (b, other)) = (placed[i as usize], placed[j as usize]);
            if a < b {
                let depth = one.overlap_depth(&other);
                if depth > depth_m {
                    return Err(refuse(a, b, format!("stand {depth:.2} m in each other")));
                }
            }
        }
        Ok(())
    }
}

/// The first two copies of a unit that stand in the same place.
fn same_place(library: &Library<'_>, environment: &Environment) -> Option<(u32, u32)> {
    let half = Vec3::splat(0.5 * SAME_PLACE_M);
    let at = |i: u32| &environment.units[i as usize];
    let around = |p: Placement| BoundingBox { min: p.translation() - half, max: p.translation() + half };
    let bounds: Vec<BoundingBox> = environment.units.iter().map(|u| around(u.placement)).collect();
    overlapping_pairs(&bounds, &bounds).into_iter().find(|&(i, j)| {
        let (a, b) = (at(i), at(j));
        let alike = || turn_difference(a.placement.heading, b.placement.heading, library.period(a.unit)) < 0.1;
        i < j && a.unit == b.unit && alike()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(at: [f32; 3], heading_deg: f32, pitch_deg: f32) -> OrientedBox {
        OrientedBox::from_shape(&UnitShape::Box { at, size: [1.0; 3], heading_deg, pitch_deg }).unwrap()
    }

    #[test]
    fn depth_is_the_way_out() {
        let one = cube([0.0; 3], 0.0, 0.0);
        assert!((one.overlap_depth(&cube([0.7, 0.0, 0.1], 0.0, 0.0)) - 0.3).abs() < 1e-6);
        assert!((one.overlap_depth(&cube([0.0, 1.2, 0.0], 0.0, 0.0)) + 0.2).abs() < 1e-6);
        // Corner to corner: half a diagonal from the middle each.
        let turned = cube([1.0 + 0.5 * (2f32.sqrt() - 1.0), 0.0, 0.0], 45.0, 0.0);
        assert!(one.overlap_depth(&turned).abs() < 1e-5, "{}", one.overlap_depth(&turned));
    }
}
