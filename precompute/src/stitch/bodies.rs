//! The bodies of all frames as spheres, made once: whether a frame collides depends on where it is laid only.

use crate::clip::joint_transforms;
use crate::environment::{Body, NUM_SPHERES, Sphere, UnitGeometry};
use glam::{Quat, Vec3};
use rayon::prelude::*;
use throng_runtime::format::FrameRow;
use throng_runtime::patch::Placement;
use throng_runtime::{Contacts, Skeleton};

/// Both feet: they may be in what is walked on.
const FEET: Contacts = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);

/// A body in every frame.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    /// Of every frame, as seen from its root on the ground.
    centres: Vec<[Vec3; NUM_SPHERES]>,
    contacts: Vec<Contacts>,
    /// Radius of each sphere, and with which contacts it may be pressed in.
    spheres: [(f32, Contacts); NUM_SPHERES],
    reach: f32,
}

impl Bodies {
    /// Places the spheres of every frame.
    pub fn new(frames: &[FrameRow], contacts: &[Contacts], skeleton: &Skeleton) -> Self {
        let body = Body::new(skeleton);
        let spheres =
            |row: &FrameRow| body.spheres(&joint_transforms(skeleton, Vec3::Y * row.height, |j| row.rotation(j)));
        let centres: Vec<_> = frames.par_iter().map(|row| spheres(row).map(|s| s.centre)).collect();
        let at_rest = body.spheres(&joint_transforms(skeleton, Vec3::ZERO, |_| Quat::IDENTITY));
        let spheres = at_rest.map(|s: Sphere| (s.radius, s.contact));
        let thickest = spheres.iter().map(|s| s.0).fold(0.0, f32::max);
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
        let (turn, at, planted) = (Quat::from_rotation_y(root.heading), root.translation(), self.contacts[frame]);
        self.centres[frame].iter().zip(&self.spheres).any(|(centre, &(radius, contact))| {
            if unit.floor && FEET.any(contact) {
                return false;
            }
            let limit = if planted.any(contact) { -depth_m } else { radius - depth_m };
            unit.nearest(turn * *centre + at, limit).is_some()
        })
    }
}
