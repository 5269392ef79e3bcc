//! The bodies of all frames as spheres, made once: whether a frame collides depends on where it is laid only.

use super::field::Field;
use crate::clip::joint_transforms;
use crate::environment::{Body, NUM_SPHERES, Sphere};
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
        Self { frames, spheres }
    }

    /// True where the body of a frame is deeper in a unit than `depth_m`; what is planted may be pressed in by its
    /// whole radius, as [`crate::environment::BodyPose::penetration`] says.
    ///
    /// - `root`: in the unit's frame.
    pub fn collides(&self, frame: usize, root: Placement, unit: &Field, depth_m: f32) -> bool {
        let (pose, shapes) = (&self.frames[frame], &unit.geometry.bounds);
        let x = (shapes.min.x - root.x).max(root.x - shapes.max.x).max(0.0);
        let z = (shapes.min.z - root.z).max(root.z - shapes.max.z).max(0.0);
        let beside = x * x + z * z > pose.radius * pose.radius
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
        let ((sin, cos), floor) = (root.heading.sin_cos(), unit.geometry.floor);
        let counts = move |s: &Sphere| !(floor && FEET.any(s.contact));
        self.spheres.iter().zip(&pose.centres).filter(move |(s, _)| counts(s)).map(move |(s, c)| {
            let p = Vec3::new(root.x + cos * c.x + sin * c.z, root.y + c.y, root.z - sin * c.x + cos * c.z);
            (s, p, if pose.contacts.any(s.contact) { -depth_m } else { s.radius - depth_m })
        })
    }
}
