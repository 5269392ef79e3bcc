//! The bodies of all frames as spheres, made once: whether a frame collides depends on where it is laid only.

use super::field::Field;
use crate::clip::joint_transforms;
use crate::environment::{Body, Bounds, NUM_SPHERES, Sphere};
use glam::{Quat, Vec3};
use rayon::prelude::*;
use throng_runtime::format::FrameRow;
use throng_runtime::patch::Placement;
use throng_runtime::{Contacts, Joint, Skeleton};

/// Spheres beside each other, as many as processors take at once some times.
const LANES: usize = NUM_SPHERES.next_multiple_of(8);

/// A number for every sphere; what is beyond the last one counts for nothing.
type Lanes = [f32; LANES];

/// Balls no nearer to a box than this and their radius do not touch it, however all is rounded. [Unit: m]
const ROUNDING: f32 = 1e-3;

/// Both feet: they may be in what is walked on.
const FEET: Contacts = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);

/// A body in every frame.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    /// Of every frame, as seen from its root on the ground.
    frames: Vec<Pose>,
    /// At rest, for what does not depend on the frame.
    spheres: [Sphere; NUM_SPHERES],
    /// Radii of the spheres. [Unit: m]
    radii: Lanes,
    /// The widest of all frames. [Unit: m]
    radius: f32,
    /// The lowest and the highest point of all frames. [Unit: m]
    heights: [f32; 2],
}

/// The spheres of one frame.
#[derive(Clone, Copy, Debug)]
struct Pose {
    /// x, y and z of the middle of every sphere.
    centres: [Lanes; 3],
    /// No sphere reaches farther from the vertical through the root. [Unit: m]
    radius: f32,
    /// Lowest and highest point. [Unit: m]
    heights: [f32; 2],
    contacts: Contacts,
}

impl Pose {
    fn new(spheres: &[Sphere; NUM_SPHERES], contacts: Contacts) -> Self {
        let (mut radius, mut heights) = (0f32, [f32::INFINITY, f32::NEG_INFINITY]);
        for s in spheres {
            radius = radius.max(s.centre.with_y(0.0).length() + s.radius);
            heights = [heights[0].min(s.centre.y - s.radius), heights[1].max(s.centre.y + s.radius)];
        }
        let lanes = |axis: usize| lanes(0.0, |s| spheres[s].centre[axis]);
        Self { centres: [lanes(0), lanes(1), lanes(2)], radius, heights, contacts }
    }

    /// The middles of all spheres where the root is.
    fn placed(&self, root: Placement) -> [Lanes; 3] {
        let (sin, cos) = root.heading.sin_cos();
        let [x, y, z] = &self.centres;
        [
            std::array::from_fn(|s| root.x + cos * x[s] + sin * z[s]),
            std::array::from_fn(|s| root.y + y[s]),
            std::array::from_fn(|s| root.z - sin * x[s] + cos * z[s]),
        ]
    }
}

fn lanes(beyond: f32, of: impl Fn(usize) -> f32) -> Lanes {
    std::array::from_fn(|s| if s < NUM_SPHERES { of(s) } else { beyond })
}

/// How far balls are from a box along the axis on which they are farthest. [Unit: m]
fn gaps(shapes: &Bounds, [x, y, z]: &[Lanes; 3], radii: &Lanes) -> Lanes {
    let (middle, half) = (shapes.centre(), 0.5 * (shapes.max - shapes.min));
    std::array::from_fn(|s| {
        let along =
            [(x[s] - middle.x).abs() - half.x, (y[s] - middle.y).abs() - half.y, (z[s] - middle.z).abs() - half.z];
        along[0].max(along[1]).max(along[2]) - radii[s]
    })
}

/// How far a root is from a box, over the ground. [Unit: m]
pub(super) fn beside(shapes: &Bounds, root: Placement) -> f32 {
    let x = (shapes.min.x - root.x).max(root.x - shapes.max.x).max(0.0);
    let z = (shapes.min.z - root.z).max(root.z - shapes.max.z).max(0.0);
    (x * x + z * z).sqrt()
}

impl Bodies {
    /// Places the spheres of every frame.
    pub fn new(frames: &[FrameRow], contacts: &[Contacts], skeleton: &Skeleton) -> Self {
        let body = Body::new(skeleton);
        let pose = |(row, &contacts): (&FrameRow, &Contacts)| {
            let joints = joint_transforms(skeleton, Vec3::Y * row.height, |j| row.rotation(j));
            Pose::new(&body.spheres(&joints), contacts)
        };
        let frames: Vec<Pose> = frames.par_iter().zip(contacts).map(pose).collect();
        let spheres = body.spheres(&joint_transforms(skeleton, Vec3::ZERO, |_| Quat::IDENTITY));
        let radii = lanes(f32::NEG_INFINITY, |s| spheres[s].radius);
        let radius = frames.iter().map(|f| f.radius).fold(0.0, f32::max);
        let lowest = frames.iter().map(|f| f.heights[0]).fold(f32::INFINITY, f32::min);
        let highest = frames.iter().map(|f| f.heights[1]).fold(f32::NEG_INFINITY, f32::max);
        Self { frames, spheres, radii, radius, heights: [lowest, highest] }
    }

    /// No body reaches farther from the vertical through its root than this. [Unit: m]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Where a root must be for a body to touch what is in a box.
    pub fn around(&self, shapes: &Bounds) -> Bounds {
        let side = Vec3::new(self.radius, 0.0, self.radius);
        Bounds {
            min: shapes.min - side - Vec3::Y * self.heights[1],
            max: shapes.max + side - Vec3::Y * self.heights[0],
        }
    }

    /// True where the body of a frame is deeper in a unit than `depth_m`; what is planted may be pressed in by its
    /// whole radius, as [`crate::environment::BodyPose::penetration`] says.
    ///
    /// - `root`: in the unit's frame.
    pub fn collides(&self, frame: usize, root: Placement, unit: &Field, depth_m: f32) -> bool {
        let (pose, shapes) = (&self.frames[frame], &unit.geometry.bounds);
        let beside = beside(shapes, root) > pose.radius
            || root.y + pose.heights[1] < shapes.min.y
            || root.y + pose.heights[0] > shapes.max.y;
        if beside {
            return false;
        }
        let centres = pose.placed(root);
        let gaps = gaps(shapes, &centres, &self.radii);
        (0..NUM_SPHERES).filter(|&s| gaps[s] < ROUNDING).any(|s| {
            let limit = self.limit(pose, s, unit, depth_m);
            limit.is_some_and(|limit| unit.is_nearer(at(&centres, s), limit))
        })
    }

    /// The joint whose sphere is deepest in a unit, and how deep; none where the body does not collide.
    pub fn deepest(&self, frame: usize, root: Placement, unit: &Field, depth_m: f32) -> Option<(Joint, f32)> {
        let pose = &self.frames[frame];
        let centres = pose.placed(root);
        let depth = |s: usize| {
            let limit = self.limit(pose, s, unit, depth_m)?;
            let sphere = &self.spheres[s];
            unit.geometry.nearest(at(&centres, s), limit).map(|n| (sphere.joint, sphere.radius - n.distance))
        };
        (0..NUM_SPHERES).filter_map(depth).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// How near a unit may be to the middle of a sphere; none where it does not matter. [Unit: m]
    fn limit(&self, pose: &Pose, sphere: usize, unit: &Field, depth_m: f32) -> Option<f32> {
        let walked_on = unit.geometry.floor && FEET.any(self.spheres[sphere].contact);
        (!walked_on).then(|| self.nearness(pose, sphere, depth_m))
    }

    /// How near anything may be to the middle of a sphere. [Unit: m]
    fn nearness(&self, pose: &Pose, sphere: usize, depth_m: f32) -> f32 {
        let s = &self.spheres[sphere];
        if pose.contacts.any(s.contact) { -depth_m } else { s.radius - depth_m }
    }

    /// Discs on the ground, as x, z and radius: what is beside all of them does not collide with a frame's body.
    pub fn shadow(&self, frame: usize, root: Placement, depth_m: f32) -> impl Iterator<Item = [f32; 3]> {
        let pose = &self.frames[frame];
        let centres = pose.placed(root);
        (0..NUM_SPHERES).map(move |s| [centres[0][s], centres[2][s], self.nearness(pose, s, depth_m).max(0.0)])
    }
}

/// The middle of a sphere.
fn at([x, y, z]: &[Lanes; 3], sphere: usize) -> Vec3 {
    Vec3::new(x[sphere], y[sphere], z[sphere])
}
