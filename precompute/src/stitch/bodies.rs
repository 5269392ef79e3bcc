//! The bodies of all frames as spheres, made once: whether a frame collides depends on where it is laid only.

use crate::clip::joint_transforms;
use crate::environment::{Body, NUM_SPHERES, Sphere, UnitGeometry};
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
    centres: Vec<[Vec3; NUM_SPHERES]>,
    contacts: Vec<Contacts>,
    /// At rest, for what does not depend on the frame.
    spheres: [Sphere; NUM_SPHERES],
    reach: f32,
}

impl Bodies {
    /// Places the spheres of every frame.
    pub fn new(frames: &[FrameRow], contacts: &[Contacts], skeleton: &Skeleton) -> Self {
        let body = Body::new(skeleton);
        let spheres =
            |row: &FrameRow| body.spheres(&joint_transforms(skeleton, Vec3::Y * row.height, |j| row.rotation(j)));
        let centres: Vec<_> = frames.par_iter().map(|row| spheres(row).map(|s| s.centre)).collect();
        let spheres = body.spheres(&joint_transforms(skeleton, Vec3::ZERO, |_| Quat::IDENTITY));
        let thickest = spheres.iter().map(|s| s.radius).fold(0.0, f32::max);
        let farthest = |c: &[Vec3; NUM_SPHERES]| c.iter().map(|p| p.length()).fold(0.0, f32::max);
        let reach = centres.par_iter().map(farthest).reduce(|| 0.0, f32::max) + thickest;
        Self { centres, contacts: contacts.to_vec(), spheres, reach }
    }

    /// No body reaches farther from its root on the ground than this. [Unit: m]
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// True where the body of a frame is deeper in a unit than `depth_m`; what is planted may be pressed in by its
    /// whole radius, as [`crate::environment::BodyPose::penetration`] says.
    ///
    /// - `root`: in the unit's frame.
    pub fn collides(&self, frame: usize, root: Placement, unit: &UnitGeometry, depth_m: f32) -> bool {
        self.inside(frame, root, unit, depth_m).next().is_some()
    }

    /// The joint whose sphere is deepest in a unit, and how deep; none where the body does not collide.
    pub fn deepest(&self, frame: usize, root: Placement, unit: &UnitGeometry, depth_m: f32) -> Option<(Joint, f32)> {
        self.inside(frame, root, unit, depth_m).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Joint and depth of every sphere that is too deep in a unit.
    fn inside<'s>(
        &'s self,
        frame: usize,
        root: Placement,
        unit: &'s UnitGeometry,
        depth_m: f32,
    ) -> impl Iterator<Item = (Joint, f32)> + use<'s> {
        let (turn, at, planted) = (Quat::from_rotation_y(root.heading), root.translation(), self.contacts[frame]);
        self.centres[frame].iter().zip(&self.spheres).filter_map(move |(centre, sphere)| {
            if unit.floor && FEET.any(sphere.contact) {
                return None;
            }
            let limit = if planted.any(sphere.contact) { -depth_m } else { sphere.radius - depth_m };
            let nearest = unit.nearest(turn * *centre + at, limit)?;
            Some((sphere.joint, sphere.radius - nearest.distance))
        })
    }
}
