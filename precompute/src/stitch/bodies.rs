//! The bodies of all frames as spheres, made once: whether a frame collides depends on where it is laid only.

use super::field::Field;
use crate::clip::joint_transforms;
use crate::environment::{Body, Bounds, NUM_SPHERES, Sphere};
use glam::{Quat, Vec3};
use rayon::prelude::*;
use throng_runtime::format::FrameRow;
use throng_runtime::patch::Placement;
use throng_runtime::{Contacts, Joint, Skeleton};

/// Both feet: they may be in what is walked on.
const FEET: Contacts = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);

/// A body in every frame.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    /// Of every frame, as seen from its root on the ground.
    frames: Vec<Pose>,
    /// At rest, for what does not depend on the frame.
    spheres: [Sphere; NUM_SPHERES],
    /// The widest of all frames. [Unit: m]
    radius: f32,
    /// The lowest and the highest point of all frames. [Unit: m]
    heights: [f32; 2],
}

/// The spheres of one frame.
#[derive(Clone, Copy, Debug)]
struct Pose {
    centres: [Vec3; NUM_SPHERES],
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
        Self { centres: spheres.map(|s| s.centre), radius, heights, contacts }
    }
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
        let radius = frames.iter().map(|f| f.radius).fold(0.0, f32::max);
        let lowest = frames.iter().map(|f| f.heights[0]).fold(f32::INFINITY, f32::min);
        let highest = frames.iter().map(|f| f.heights[1]).fold(f32::NEG_INFINITY, f32::max);
        Self { frames, spheres, radius, heights: [lowest, highest] }
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
        !beside && self.limits(pose, root, unit, depth_m).any(|(_, p, limit)| unit.is_nearer(p, limit))
    }

    /// The joint whose sphere is deepest in a unit, and how deep; none where the body does not collide.
    pub fn deepest(&self, frame: usize, root: Placement, unit: &Field, depth_m: f32) -> Option<(Joint, f32)> {
        let depth = |(s, p, limit): (&Sphere, Vec3, f32)| {
            unit.geometry.nearest(p, limit).map(|n| (s.joint, s.radius - n.distance))
        };
        let all = self.limits(&self.frames[frame], root, unit, depth_m).filter_map(depth);
        all.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Every sphere that counts, its middle in the unit's frame, and how near the unit may be to it.
    fn limits<'s>(
        &'s self,
        pose: &'s Pose,
        root: Placement,
        unit: &Field,
        depth_m: f32,
    ) -> impl Iterator<Item = (&'s Sphere, Vec3, f32)> + use<'s> {
        let floor = unit.geometry.floor;
        self.placed(pose, root, depth_m).filter(move |(s, ..)| !(floor && FEET.any(s.contact)))
    }

    /// Every sphere, its middle where the root is, and how near a unit may be to it.
    fn placed<'s>(
        &'s self,
        pose: &'s Pose,
        root: Placement,
        depth_m: f32,
    ) -> impl Iterator<Item = (&'s Sphere, Vec3, f32)> + use<'s> {
        let (sin, cos) = root.heading.sin_cos();
        self.spheres.iter().zip(&pose.centres).map(move |(s, c)| {
            let p = Vec3::new(root.x + cos * c.x + sin * c.z, root.y + c.y, root.z - sin * c.x + cos * c.z);
            (s, p, if pose.contacts.any(s.contact) { -depth_m } else { s.radius - depth_m })
        })
    }

    /// Discs on the ground, as x, z and radius: what is beside all of them does not collide with a frame's body.
    pub fn shadow(&self, frame: usize, root: Placement, depth_m: f32) -> impl Iterator<Item = [f32; 3]> {
        self.placed(&self.frames[frame], root, depth_m).map(|(_, p, limit)| [p.x, p.z, limit.max(0.0)])
    }
}
