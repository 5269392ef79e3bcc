//! Body as spheres along its limbs, to test whether a pose fits among units.

use super::{PlacedGeometry, UnitGeometry};
use glam::{Quat, Vec3};
use throng_base::thresholds::REFERENCE_LEG_M;
use throng_core::patch::Placement;
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton};
use throng_geometry::BoundingBox;

/// Number of spheres of a body.
pub const NUM_SPHERES: usize = 31;

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
    /// Spheres of a body with a skeleton's proportions.
    pub fn new(skeleton: &Skeleton) -> Self {
        let mut parts = Vec::with_capacity(NUM_SPHERES);
        let scale = skeleton.leg_length() / REFERENCE_LEG_M;
        let mut add = |joint: Joint, offset: Vec3, radius: f32, contact: Contacts| {
            parts.push(JointSphere { joint, offset, radius: radius * scale, contact });
        };
        trunk(skeleton, &mut add);
        let sides = [
            ([Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand], Contacts::LEFT_HAND),
            ([Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand], Contacts::RIGHT_HAND),
        ];
        for (joints, contact) in sides {
            arm(skeleton, joints, contact, &mut add);
        }
        let left = [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot, Joint::LeftToe];
        let right = [Joint::RightThigh, Joint::RightShin, Joint::RightFoot, Joint::RightToe];
        leg(skeleton, left, skeleton.tips[1], [Contacts::LEFT_HEEL, Contacts::LEFT_TOE], &mut add);
        leg(skeleton, right, skeleton.tips[2], [Contacts::RIGHT_HEEL, Contacts::RIGHT_TOE], &mut add);
        Self { parts: std::array::from_fn(|i| parts[i]) }
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

fn trunk(skeleton: &Skeleton, add: &mut impl FnMut(Joint, Vec3, f32, Contacts)) {
    let thigh = |j: Joint| skeleton.offsets[j.index()];
    add(Joint::Hips, Vec3::ZERO, 0.11, Contacts::SEAT);
    add(Joint::Hips, thigh(Joint::LeftThigh), 0.092, Contacts::SEAT);
    add(Joint::Hips, thigh(Joint::RightThigh), 0.092, Contacts::SEAT);
    add(Joint::Spine, Vec3::ZERO, 0.105, Contacts::NONE);
    add(Joint::Chest, Vec3::ZERO, 0.11, Contacts::NONE);
    let up = 0.3 * skeleton.offsets[Joint::Neck.index()].y;
    for side in [0.07, -0.07] {
        add(Joint::UpperChest, Vec3::new(side, up, 0.0), 0.1, Contacts::NONE);
    }
    add(Joint::Neck, 0.5 * skeleton.offsets[Joint::Head.index()], 0.056, Contacts::NONE);
    add(Joint::Head, 0.5 * skeleton.tips[0], 0.105, Contacts::NONE);
}

fn arm(
    skeleton: &Skeleton,
    [upper, fore, hand]: [Joint; 3],
    contact: Contacts,
    add: &mut impl FnMut(Joint, Vec3, f32, Contacts),
) {
    let (to_elbow, to_wrist) = (skeleton.offsets[fore.index()], skeleton.offsets[hand.index()]);
    add(upper, Vec3::ZERO, 0.06, Contacts::NONE);
    add(upper, 0.5 * to_elbow, 0.05, Contacts::NONE);
    add(fore, Vec3::ZERO, 0.043, Contacts::NONE);
    add(fore, 0.5 * to_wrist, 0.037, contact);
    add(hand, 0.065 * to_wrist.normalize_or_zero(), 0.042, contact);
}

fn leg(
    skeleton: &Skeleton,
    [thigh, shin, foot, toe]: [Joint; 4],
    tip: Vec3,
    [heel, ball]: [Contacts; 2],
    add: &mut impl FnMut(Joint, Vec3, f32, Contacts),
) {
    let (to_knee, to_ankle) = (skeleton.offsets[shin.index()], skeleton.offsets[foot.index()]);
    add(thigh, to_knee / 3.0, 0.08, Contacts::SEAT);
    add(thigh, to_knee * (2.0 / 3.0), 0.07, Contacts::SEAT);
    add(shin, Vec3::ZERO, 0.058, Contacts::NONE);
    add(shin, 0.5 * to_ankle, 0.05, Contacts::NONE);
    add(foot, Vec3::ZERO, 0.042, heel);
    add(toe, 0.4 * tip, 0.03, ball);
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
        // The chest's sphere of 0.11 m is centred on the surface of the wall, the head's of 0.105 m 0.015 m behind it.
        assert!(unit == 0 && p.joint == Joint::Head && (p.depth - 0.12).abs() < 1e-3, "{p:?}");
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
        // Thigh joints 0.76 m up, the seat 0.78 m: deeper than the tolerance, except for a seated body.
        assert!(at_seat(Contacts::NONE).is_some_and(|(_, p)| p.joint == Joint::Hips));
        assert_eq!(at_seat(Contacts::SEAT), None);
    }
}
