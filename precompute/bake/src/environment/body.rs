//! Body as spheres along its limbs, to test whether a pose fits among units.

use super::{PlacedGeometry, UnitGeometry};
use glam::{Quat, Vec3};
use throng_core::{BodyVolume, Contacts, Joint, JointCapsule, NUM_JOINTS, Skeleton, patch::Placement};
use throng_geometry::BoundingBox;

/// Number of spheres of a body.
pub const NUM_SPHERES: usize = 32;

/// Both feet.
const FEET: Contacts = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);

/// A body as spheres, each fixed to a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpheres {
    parts: [JointSphere; NUM_SPHERES],
}

/// A sphere in the frame of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
struct JointSphere {
    joint: Joint,
    offset: Vec3,
    radius: f32,
    contact: Contacts,
}

/// A sphere of a body in a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre (m).
    pub centre: Vec3,
    /// Radius (m).
    pub radius: f32,
    /// Joint that carries the sphere.
    pub joint: Joint,
    /// Contacts during any of which the sphere may be pressed into a surface.
    pub contact: Contacts,
}

/// Spheres of a body in a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedSpheres {
    /// The spheres, in the frame of the joints' transforms.
    pub spheres: [Sphere; NUM_SPHERES],
    /// Box around the spheres.
    pub bounds: BoundingBox,
    /// Planted parts.
    pub contacts: Contacts,
}

/// Penetration of a unit by a part of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// Joint of the deepest sphere.
    pub joint: Joint,
    /// Depth of that sphere in the unit (m).
    pub depth: f32,
}

impl BodySpheres {
    /// Spheres along the capsules of a body with a skeleton's proportions.
    pub fn new(skeleton: &Skeleton) -> Self {
        let sphere = |capsule: &JointCapsule, share: f32| JointSphere {
            joint: capsule.joint,
            offset: capsule.ends[0].lerp(capsule.ends[1], share),
            radius: capsule.radius,
            contact: contact(capsule.joint),
        };
        let volume = BodyVolume::new(skeleton);
        let all = volume.capsules.iter().flat_map(|c| shares(c.joint).iter().map(move |share| sphere(c, *share)));
        let all: Vec<JointSphere> = all.collect();
        Self { parts: std::array::from_fn(|i| all[i]) }
    }

    /// The spheres of a pose, in the frame of its joints' transforms.
    pub fn spheres(&self, transforms: &[(Vec3, Quat); NUM_JOINTS]) -> [Sphere; NUM_SPHERES] {
        self.parts.map(|p| {
            let (at, turn) = transforms[p.joint.index()];
            Sphere { centre: at + turn * p.offset, radius: p.radius, joint: p.joint, contact: p.contact }
        })
    }

    /// Spheres, bounds and contacts of a pose.
    pub fn pose(&self, transforms: &[(Vec3, Quat); NUM_JOINTS], contacts: Contacts) -> PosedSpheres {
        let spheres = self.spheres(transforms);
        let bounds = spheres
            .iter()
            .fold(BoundingBox::EMPTY, |b, s| b.union(BoundingBox::around_points([s.centre]).expanded(s.radius)));
        PosedSpheres { spheres, bounds, contacts }
    }
}

/// Places of the spheres along a joint's capsule; none where others cover it (1).
fn shares(joint: Joint) -> &'static [f32] {
    use Joint::*;
    match joint {
        LeftClavicle | RightClavicle => &[],
        Hips | UpperChest => &[0.0, 1.0],
        LeftUpperArm | RightUpperArm | LeftForearm | RightForearm | LeftShin | RightShin => &[0.0, 0.5],
        LeftThigh | RightThigh => &[0.0, 1.0 / 3.0, 2.0 / 3.0],
        LeftFoot | RightFoot => &[0.0],
        _ => &[0.5],
    }
}

/// Contacts in which a joint's spheres may be pressed into a surface.
fn contact(joint: Joint) -> Contacts {
    use Joint::*;
    match joint {
        Hips | LeftThigh | RightThigh => Contacts::SEAT,
        LeftForearm | LeftHand => Contacts::LEFT_HAND,
        RightForearm | RightHand => Contacts::RIGHT_HAND,
        LeftFoot => Contacts::LEFT_HEEL,
        RightFoot => Contacts::RIGHT_HEEL,
        LeftToe => Contacts::LEFT_TOE,
        RightToe => Contacts::RIGHT_TOE,
        _ => Contacts::NONE,
    }
}

impl PosedSpheres {
    /// Deepest sphere in a unit, if deeper than `tolerance`.
    ///
    /// Parts in contact may be pressed in until their centre is `tolerance` below the surface; feet are ignored for
    /// floor units. A mesh has no inside, so only spheres near its surface count.
    ///
    /// - `unit`: placement of the unit in the pose's frame.
    /// - `tolerance`: (m, >= 0)
    pub fn penetration(&self, unit: Placement, geometry: &UnitGeometry, tolerance: f32) -> Option<Penetration> {
        if !geometry.bounds.mapped(|p| unit.transform_point(p)).overlaps(&self.bounds) {
            return None;
        }
        let mut deepest: Option<Penetration> = None;
        for s in self.spheres.iter().filter(|s| !(geometry.floor && FEET.any(s.contact))) {
            let allowed = if self.contacts.any(s.contact) { s.radius + tolerance } else { tolerance };
            let Some(near) = geometry.nearest(unit.inverse_transform_point(s.centre), s.radius - allowed) else {
                continue;
            };
            let depth = s.radius - near.distance;
            if deepest.is_none_or(|d| depth > d.depth) {
                deepest = Some(Penetration { joint: s.joint, depth });
            }
        }
        deepest
    }

    /// Placed unit with the deepest sphere, if deeper than `tolerance`; the ground is ignored.
    pub fn penetration_in(&self, geometry: &PlacedGeometry, tolerance: f32) -> Option<(usize, Penetration)> {
        let mut deepest: Option<(usize, Penetration)> = None;
        geometry.overlapping(&self.bounds, |u| {
            let found = self.penetration(geometry.placement(u), geometry.geometry(u), tolerance);
            if let Some(p) = found.filter(|p| deepest.is_none_or(|d| (p.depth, d.0) > (d.1.depth, u))) {
                deepest = Some((u, p));
            }
        });
        deepest
    }
}

#[cfg(test)]
mod tests {
    use super::super::placed::tests::placed;
    use super::*;
    use throng_motion::clip::joint_transforms;

    fn standing(at: Vec3) -> [(Vec3, Quat); NUM_JOINTS] {
        let s = Skeleton::default();
        joint_transforms(&s, s.offsets[0] + at, |_| Quat::IDENTITY)
    }

    fn pose(at: Vec3, contacts: Contacts) -> PosedSpheres {
        BodySpheres::new(&Skeleton::default()).pose(&standing(at), contacts)
    }

    #[test]
    fn spheres_cover_the_body_from_head_to_toe() {
        let p = pose(Vec3::ZERO, Contacts::NONE);
        let top = Skeleton::default().rest_positions()[Joint::Head.index()].y + Skeleton::default().tips[0].y;
        assert!((p.bounds.max.y - top).abs() < 0.02 && p.bounds.min.y.abs() < 0.02, "{:?}", p.bounds);
        assert!((p.bounds.max.x + p.bounds.min.x).abs() < 1e-6 && p.bounds.max.x > 0.8);
        for (joint, (at, _)) in Joint::ALL.into_iter().zip(standing(Vec3::ZERO)) {
            let off = p.spheres.iter().map(|s| s.centre.distance(at) - s.radius).fold(9.0, f32::min);
            assert!(off < 0.05, "{}: {off}", joint.name());
        }
    }

    const UNITS: &str = "[[units]]\nname = \"wall\"\nshapes = [{ box = { at = [0.0, 1.0, 0.0], size = [4.0, 2.0, 0.2] \
                         } }]\n[[units]]\nname = \"deck\"\nfloor = true\nshapes = [{ box = { at = [0.0, -0.5, 0.0], \
                         size = [4.0, 1.0, 4.0] } }]\n[[units]]\nname = \"chair\"\nshapes = [{ box = { at = [0.0, \
                         0.4, 0.0], size = [0.5, 0.8, 0.3] } }]\n";

    #[test]
    fn a_body_in_a_wall_is_found_and_one_beside_it_is_not() {
        let wall = placed(UNITS, "{ unit = \"wall\", at = [0.0, 0.0, 2.0] }");
        assert_eq!(pose(Vec3::Z * 1.7, Contacts::NONE).penetration_in(&wall, 0.06), None);
        let (unit, p) = pose(Vec3::Z * 1.9, Contacts::NONE).penetration_in(&wall, 0.06).unwrap();
        // The trunk's spheres of 0.12 m are centred on the surface of the wall, the head's of 0.1 m is 0.015 m behind it.
        assert!(unit == 0 && p.joint != Joint::Head && (p.depth - 0.12).abs() < 1e-3, "{p:?}");
        assert_eq!(pose(Vec3::Z * 3.0, Contacts::NONE).penetration_in(&wall, 0.06), None);
    }

    #[test]
    fn feet_may_sink_into_floors_and_planted_parts_into_what_they_touch() {
        let deck = placed(UNITS, "{ unit = \"deck\", at = [0.0, 0.1, 0.0] }");
        assert_eq!(pose(Vec3::ZERO, Contacts::NONE).penetration_in(&deck, 0.06), None);
        let chair = placed(UNITS, "{ unit = \"chair\", at = [0.0, 0.05, 0.0] }");
        let found = pose(Vec3::ZERO, Contacts::NONE).penetration_in(&chair, 0.06);
        assert!(found.is_some());
        let seat = placed(UNITS, "{ unit = \"chair\", at = [0.0, -0.02, 0.0] }");
        let hips_down = |contacts| pose(Vec3::new(0.0, -0.15, 0.0), contacts).spheres;
        let at_seat = |contacts: Contacts| {
            // Only the trunk: the legs of a standing body would be in the chair.
            let mut p = pose(Vec3::new(0.0, -0.15, 0.0), contacts);
            p.spheres = hips_down(contacts).map(|s| {
                let keep = matches!(s.joint, Joint::Hips);
                if keep { s } else { Sphere { centre: Vec3::Y * 50.0, ..s } }
            });
            p.penetration_in(&seat, 0.06)
        };
        // Hips 0.805 m up with a radius of 0.12 m, the seat 0.78 m: deeper than the tolerance, except for a seated body.
        assert!(at_seat(Contacts::NONE).is_some_and(|(_, p)| p.joint == Joint::Hips));
        assert_eq!(at_seat(Contacts::SEAT), None);
    }
}
