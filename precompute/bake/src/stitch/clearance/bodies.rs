//! Bodies of all frames as spheres, computed once: whether a frame collides depends only on its placement.

use super::field::{DistanceField, FieldAnswer};
use crate::environment::{BodySpheres, NUM_SPHERES, Sphere};
use crate::{stitch::library::Library, stitch::sets::rows::set_bits};
use glam::{Quat, Vec3};
use rayon::prelude::*;
use throng_core::{Contacts, Joint, format::FrameRow, patch::Placement};
use throng_geometry::BoundingBox;
use throng_motion::clip::joint_transforms;

/// Number of spheres, padded to whole vector registers.
const LANES: usize = NUM_SPHERES.next_multiple_of(8);

/// A number for every sphere; the padding is ignored.
type SphereLanes = [f32; LANES];

/// Both feet, which may be inside floors.
const FEET: Contacts = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);

/// Room of a body beside a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) enum UnitRoom {
    /// Distance by which the unit may be moved (m).
    Clear(f32),
    /// Collision: this point is too near to the unit.
    Taken(BodyPoint),
}

/// A sphere of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) struct BodyPoint {
    /// Centre, in the frame of the unit or of a patch.
    pub centre: Vec3,
    /// Least distance of a unit from the centre (m).
    pub limit: f32,
}

/// Number of combinations of planted parts.
const PLANTED: usize = 1 << u8::BITS;

/// Bodies of all frames.
#[derive(Clone, Debug)]
pub(in crate::stitch) struct FrameBodies {
    /// Spheres of every frame, relative to its root on the ground.
    frames: Vec<FrameSpheres>,
    /// Extents of every frame (frames.len()).
    pub reaches: Vec<FrameReach>,
    /// Spheres at rest, for frame-independent data.
    spheres: [Sphere; NUM_SPHERES],
    /// Least distance of a unit from the centre of each sphere, by planted parts; first for other units, then for
    /// floors (m, 2 * PLANTED).
    limits: Vec<SphereLanes>,
    /// Clearance beyond which spheres are not distinguished, as grids end there (m).
    farthest: f32,
    /// Largest distance of any body from the vertical through its root (m).
    pub radius: f32,
    /// Lowest and highest point of all frames (m).
    heights: [f32; 2],
}

/// The spheres of one frame.
#[derive(Clone, Copy, Debug)]
struct FrameSpheres {
    /// x, y and z of the centre of every sphere.
    centres: [SphereLanes; 3],
    contacts: Contacts,
}

/// Extent of the body of one frame, which is compact and separates most bodies from a unit by itself.
#[derive(Clone, Copy, Debug)]
pub(in crate::stitch) struct FrameReach {
    /// Largest distance of a sphere from the vertical through the root (m).
    pub radius: f32,
    /// Lowest and highest point (m).
    heights: [f32; 2],
}

impl FrameReach {
    fn new(spheres: &[Sphere; NUM_SPHERES]) -> Self {
        let (mut radius, mut heights) = (0f32, [f32::INFINITY, f32::NEG_INFINITY]);
        for s in spheres {
            radius = radius.max(s.centre.with_y(0.0).length() + s.radius);
            heights = [heights[0].min(s.centre.y - s.radius), heights[1].max(s.centre.y + s.radius)];
        }
        Self { radius, heights }
    }

    /// Lower bound of the distance of any sphere from a unit, from the root's place only (m).
    ///
    /// - `root`: in the unit's frame.
    pub fn least_distance(&self, root: Placement, unit: &DistanceField) -> f32 {
        let (shapes, beside) = (&unit.geometry.bounds, unit.plan.least_distance(root.x, root.z));
        let above = root.y + self.heights[0] - shapes.max.y;
        let below = shapes.min.y - root.y - self.heights[1];
        (beside - self.radius).max(above).max(below)
    }
}

impl FrameSpheres {
    fn new(spheres: &[Sphere; NUM_SPHERES], contacts: Contacts) -> Self {
        let lanes = |axis: usize| lanes(0.0, |s| spheres[s].centre[axis]);
        Self { centres: [lanes(0), lanes(1), lanes(2)], contacts }
    }

    /// Centres of all spheres for a root.
    fn placed(&self, root: Placement) -> [SphereLanes; 3] {
        let (sin, cos) = root.heading.sin_cos();
        let [x, y, z] = &self.centres;
        [
            std::array::from_fn(|s| root.x + cos * x[s] + sin * z[s]),
            std::array::from_fn(|s| root.y + y[s]),
            std::array::from_fn(|s| root.z - sin * x[s] + cos * z[s]),
        ]
    }
}

fn lanes(beyond: f32, of: impl Fn(usize) -> f32) -> SphereLanes {
    std::array::from_fn(|s| if s < NUM_SPHERES { of(s) } else { beyond })
}

/// Least distance of a unit from the centre of each sphere: a body may be `depth_m` deep in it, and planted parts
/// deeper by their whole radius, as in [`crate::environment::PosedSpheres`] (m).
fn limits(spheres: &[Sphere; NUM_SPHERES], depth_m: f32) -> Vec<SphereLanes> {
    let limit = |s: &Sphere, contacts: Contacts, floor: bool| match (floor && FEET.any(s.contact), s.contact) {
        (true, _) => f32::NEG_INFINITY,
        (false, contact) if contacts.any(contact) => -depth_m,
        (false, _) => s.radius - depth_m,
    };
    let of = |k: usize| {
        let contacts = Contacts((k % PLANTED) as u8);
        lanes(f32::NEG_INFINITY, |s| limit(&spheres[s], contacts, k >= PLANTED))
    };
    (0..2 * PLANTED).map(of).collect()
}

impl FrameBodies {
    /// Places the spheres of every frame.
    ///
    /// - `depth_m`: allowed depth of bodies in units (m).
    pub fn new(library: &Library<'_>, depth_m: f32) -> Self {
        let Library { frames, contacts, skeleton, rotation_code, .. } = *library;
        let body = BodySpheres::new(skeleton);
        let pose = |(row, &contacts): (&FrameRow, &Contacts)| {
            let joints = joint_transforms(skeleton, Vec3::Y * row.height, |j| rotation_code.rotation(row, j));
            let spheres = body.spheres(&joints);
            (FrameSpheres::new(&spheres, contacts), FrameReach::new(&spheres))
        };
        let (frames, reaches): (Vec<FrameSpheres>, Vec<FrameReach>) = frames.par_iter().zip(contacts).map(pose).unzip();
        let spheres = body.spheres(&joint_transforms(skeleton, Vec3::ZERO, |_| Quat::IDENTITY));
        let limits = limits(&spheres, depth_m);
        let thickest = limits.iter().flatten().copied().fold(0.0, f32::max);
        let farthest = (DistanceField::MARGIN_M - thickest).max(0.0);
        let radius = reaches.iter().map(|r| r.radius).fold(0.0, f32::max);
        let lowest = reaches.iter().map(|r| r.heights[0]).fold(f32::INFINITY, f32::min);
        let highest = reaches.iter().map(|r| r.heights[1]).fold(f32::NEG_INFINITY, f32::max);
        Self { frames, reaches, spheres, limits, farthest, radius, heights: [lowest, highest] }
    }

    /// Box of the root positions for which a body may touch something in a box.
    pub fn root_bounds(&self, shapes: &BoundingBox) -> BoundingBox {
        let side = Vec3::new(self.radius, 0.0, self.radius);
        BoundingBox {
            min: shapes.min - side - Vec3::Y * self.heights[1],
            max: shapes.max + side - Vec3::Y * self.heights[0],
        }
    }

    /// True if the body of a frame collides with a unit.
    ///
    /// - `root`: in the unit's frame.
    pub fn collides(&self, frame: usize, root: Placement, unit: &DistanceField) -> bool {
        if self.reaches[frame].least_distance(root, unit) > 0.0 {
            return false;
        }
        matches!(self.room(frame, root, unit, 0.0), UnitRoom::Taken(_))
    }

    /// Distance by which a unit may be moved without touching the body of a frame, or the sphere that collides.
    ///
    /// A reported sphere is about the deepest of those clearly in the unit, as it stays there longest when the unit is
    /// moved on. The exact geometry is used if none is clearly inside.
    ///
    /// - `root`: in the unit's frame.
    /// - `most`: larger clearances are not distinguished, nor those above [`DistanceField::MARGIN_M`] less the thickest
    ///   sphere (m).
    pub fn room(&self, frame: usize, root: Placement, unit: &DistanceField, most: f32) -> UnitRoom {
        let pose = &self.frames[frame];
        let (centres, limits) = (pose.placed(root), self.limits(pose, unit));
        let cells = unit.cells(&centres);
        let (mut about, mut nearest) = ([f32::INFINITY; LANES], (0, f32::INFINITY));
        for (s, here) in about.iter_mut().enumerate().take(NUM_SPHERES) {
            *here = unit.excess_estimate(cells[s], limits[s]);
            nearest = if *here < nearest.1 { (s, *here) } else { nearest };
        }
        let nearest = nearest.0;
        // Once the nearest is known, most others are clearly farther.
        let (mut least, mut unsure) = (most.min(self.farthest), 0u64);
        for s in std::iter::once(nearest).chain((0..NUM_SPHERES).filter(|s| *s != nearest)) {
            if about[s] >= least + DistanceField::OFF_M {
                continue;
            }
            let ball = BodyPoint { centre: sphere_position(&centres, s), limit: limits[s] };
            match unit.excess_at(ball.centre, ball.limit, least) {
                FieldAnswer::Clear(clear) => least = least.min(clear),
                FieldAnswer::Within => return UnitRoom::Taken(ball),
                FieldAnswer::Unsure => unsure |= 1 << s,
            }
        }
        for s in set_bits(unsure).map(|s| s as usize) {
            let ball = BodyPoint { centre: sphere_position(&centres, s), limit: limits[s] };
            match unit.clearance(ball.centre, ball.limit, least) {
                Some(clear) => least = least.min(clear),
                None => return UnitRoom::Taken(ball),
            }
        }
        UnitRoom::Clear(least)
    }

    /// Joint of the sphere deepest in a unit, and its depth; `None` without a collision.
    pub fn deepest(&self, frame: usize, root: Placement, unit: &DistanceField) -> Option<(Joint, f32)> {
        let pose = &self.frames[frame];
        let (centres, limits) = (pose.placed(root), self.limits(pose, unit));
        let depth = |s: usize| {
            let (sphere, found) = (&self.spheres[s], unit.geometry.nearest(sphere_position(&centres, s), limits[s]));
            found.map(|n| (sphere.joint, sphere.radius - n.distance))
        };
        (0..NUM_SPHERES).filter_map(depth).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Least distance of a unit from the centre of each sphere (m).
    fn limits(&self, pose: &FrameSpheres, unit: &DistanceField) -> &SphereLanes {
        &self.limits[usize::from(unit.geometry.floor) * PLANTED + usize::from(pose.contacts.0)]
    }

    /// Discs on the ground, as x, z and radius: a unit outside all of them does not collide with a frame's body.
    pub fn shadow(&self, frame: usize, root: Placement) -> impl Iterator<Item = [f32; 3]> {
        let pose = &self.frames[frame];
        let (centres, limits) = (pose.placed(root), &self.limits[usize::from(pose.contacts.0)]);
        (0..NUM_SPHERES).map(move |s| [centres[0][s], centres[2][s], limits[s].max(0.0)])
    }
}

/// Centre of a sphere.
fn sphere_position([x, y, z]: &[SphereLanes; 3], sphere: usize) -> Vec3 {
    Vec3::new(x[sphere], y[sphere], z[sphere])
}

#[cfg(test)]
mod tests;
