//! Skin points of a body that touch its surroundings, and the limits of a contact.

use super::PlacedGeometry;
use glam::{Quat, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::thresholds::{
    BODY_IN_UNIT_M, BUTTOCK_M, FOOT_CONTACT_M, HAND_CONTACT_M, HAND_SKIN_M, HEEL_PER_BALL, REFERENCE_LEG_M,
    SEAT_CONTACT_M,
};
use throng_core::{BodyVolume, Contacts, Joint, NUM_JOINTS, Skeleton};
use throng_motion::error::{BuildError, Result, check_ranges};

/// Limits within which a part of a body counts as planted on the geometry of an environment (Lee, Choi and Lee 2006,
/// section 3).
///
/// The `annotate` table gives speeds, shortest contacts and longest pauses. Lengths are for legs of 0.83 m and scale
/// with the skeleton's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GeometryTouchConfig {
    /// Distance of the sole at which a contact of heel or toe begins (m, <= foot_off).
    pub foot_on: f32,
    /// Distance of the sole at which it ends (m).
    pub foot_off: f32,
    /// Distance of the skin of a hand at which a contact begins (m, <= hand_off).
    pub hand_on: f32,
    /// Distance of the skin of a hand at which it ends (m).
    pub hand_off: f32,
    /// Distance of the seat at which a contact begins (m, <= seat_off).
    pub seat_on: f32,
    /// Distance of the seat at which it ends (m).
    pub seat_off: f32,
    /// Largest depth of an unplanted body part in a unit (m, >= 0).
    pub penetration: f32,
}

impl Default for GeometryTouchConfig {
    fn default() -> Self {
        Self {
            foot_on: FOOT_CONTACT_M[0],
            foot_off: FOOT_CONTACT_M[1],
            hand_on: HAND_CONTACT_M[0],
            hand_off: HAND_CONTACT_M[1],
            seat_on: SEAT_CONTACT_M[0],
            seat_off: SEAT_CONTACT_M[1],
            penetration: BODY_IN_UNIT_M,
        }
    }
}

impl GeometryTouchConfig {
    /// Checks that every number is within its limits.
    ///
    /// # Errors
    /// [`BuildError::Key`] names the setting.
    pub fn check(&self) -> Result<()> {
        let pairs = [
            ("foot_on", self.foot_on, self.foot_off),
            ("hand_on", self.hand_on, self.hand_off),
            ("seat_on", self.seat_on, self.seat_off),
        ];
        for (key, on, off) in pairs {
            if !(on > 0.0 && on <= off && off < 1.0) {
                let why =
                    format!("expected above 0 and at most the distance that ends it, below 1, found {on} and {off}");
                return Err(BuildError::key(key, why));
            }
        }
        check_ranges([("penetration", f64::from(self.penetration), 0.0, 1.0)])
    }
}

/// Parts that contacts distinguish, in the order of their bits.
pub(super) const PARTS: [Contacts; 7] = [
    Contacts::LEFT_HEEL,
    Contacts::LEFT_TOE,
    Contacts::RIGHT_HEEL,
    Contacts::RIGHT_TOE,
    Contacts::LEFT_HAND,
    Contacts::RIGHT_HAND,
    Contacts::SEAT,
];

/// Skin points that may touch something.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SkinPoints {
    /// Points of every part, in the order of [`PARTS`].
    parts: [Vec<SkinPoint>; 7],
    /// Ratio of the skeleton's size to that of the default skeleton.
    pub scale: f32,
}

/// Skin point, fixed to a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SkinPoint {
    joint: Joint,
    offset: Vec3,
    /// Distance of the skin from the point; negative for a hollow (m).
    pub radius: f32,
}

impl SkinPoint {
    /// Position in a pose (m).
    pub fn position(&self, transforms: &[(Vec3, Quat); NUM_JOINTS]) -> Vec3 {
        let (p, r) = transforms[self.joint.index()];
        p + r * self.offset
    }
}

impl SkinPoints {
    /// Skin points of a body with a skeleton's proportions.
    pub fn new(skeleton: &Skeleton) -> Self {
        let scale = skeleton.leg_length() / REFERENCE_LEG_M;
        let [left_heel, left_toe] = foot(skeleton, Joint::LeftFoot, Joint::LeftToe, skeleton.tips[1]);
        let [right_heel, right_toe] = foot(skeleton, Joint::RightFoot, Joint::RightToe, skeleton.tips[2]);
        let hands = [Joint::LeftHand, Joint::RightHand].map(|j| hand(skeleton, j, scale));
        let [left_hand, right_hand] = hands;
        let parts = [left_heel, left_toe, right_heel, right_toe, left_hand, right_hand, seat(skeleton, scale)];
        Self { parts, scale }
    }

    /// The points of one part (part < 7).
    pub fn points_of(&self, part: usize) -> &[SkinPoint] {
        &self.parts[part]
    }

    /// Distances that begin and end a contact of a part (m).
    pub fn limits(&self, part: usize, cfg: &GeometryTouchConfig) -> [f32; 2] {
        let limits = match part {
            0..=3 => [cfg.foot_on, cfg.foot_off],
            4..=5 => [cfg.hand_on, cfg.hand_off],
            _ => [cfg.seat_on, cfg.seat_off],
        };
        limits.map(|l| l * self.scale)
    }
}

/// Sole of the heel, and of ball and toes; the arch between them belongs to the ball and is hollow.
fn foot(skeleton: &Skeleton, foot: Joint, toe: Joint, tip: Vec3) -> [Vec<SkinPoint>; 2] {
    let rest = skeleton.rest_positions();
    let (ankle, ball) = (rest[foot.index()].y, rest[toe.index()].y);
    let to_ball = skeleton.offsets[toe.index()];
    let probe =
        |joint: Joint, x: f32, y: f32, z: f32, radius: f32| SkinPoint { joint, offset: Vec3::new(x, y, z), radius };
    let heel = vec![probe(foot, 0.0, -ankle, -HEEL_PER_BALL * to_ball.z, 0.0), probe(foot, 0.0, -ankle, 0.0, 0.0)];
    let arch = probe(foot, 0.5 * to_ball.x, -ankle, 0.5 * to_ball.z, -0.015);
    let toes = vec![probe(toe, 0.0, -ball, 0.0, 0.0), probe(toe, tip.x, -ball, tip.z, 0.0), arch];
    [heel, toes]
}

/// Wrist, palm and fingers.
fn hand(skeleton: &Skeleton, hand: Joint, scale: f32) -> Vec<SkinPoint> {
    let along = skeleton.offsets[hand.index()].normalize_or_zero() * scale;
    let probes = [(0.0, HAND_SKIN_M[0]), (0.06, HAND_SKIN_M[0]), (0.12, HAND_SKIN_M[1])];
    probes.map(|(at, radius)| SkinPoint { joint: hand, offset: along * at, radius: radius * scale }).to_vec()
}

/// Buttocks and the upper halves of the thighs.
fn seat(skeleton: &Skeleton, scale: f32) -> Vec<SkinPoint> {
    let mut out = Vec::with_capacity(4);
    for (thigh, shin) in [(Joint::LeftThigh, Joint::LeftShin), (Joint::RightThigh, Joint::RightShin)] {
        out.push(SkinPoint { joint: thigh, offset: Vec3::ZERO, radius: BUTTOCK_M * scale });
        out.push(SkinPoint {
            joint: thigh,
            offset: skeleton.offsets[shin.index()] / 3.0,
            radius: BodyVolume::radius_m(thigh) * scale,
        });
    }
    out
}

/// Finds the placed units that poses belong to (Lee, Choi and Lee 2006, section 4).
#[derive(Clone, Debug, PartialEq)]
pub struct UnitMembership {
    probes: SkinPoints,
    touch: GeometryTouchConfig,
}

impl UnitMembership {
    /// For a skeleton's proportions.
    pub fn new(skeleton: &Skeleton, touch: &GeometryTouchConfig) -> Self {
        Self { probes: SkinPoints::new(skeleton), touch: touch.clone() }
    }

    /// The placed units that a pose belongs to, ascending: a planted part touches the unit's geometry, or the hips are
    /// in its region.
    ///
    /// - `transforms`: position and rotation of all joints, in the frame of the environment.
    ///
    /// # Source
    /// Lee, Choi and Lee (2006), section 4. Differs: the hips, not the whole body, intersect the box, so that a pose belongs to few units.
    pub fn units_of(
        &self,
        transforms: &[(Vec3, Quat); NUM_JOINTS],
        contacts: Contacts,
        environment: &PlacedGeometry,
    ) -> Vec<usize> {
        let hips = transforms[Joint::Hips.index()].0;
        let touches = |part: usize, u: usize| {
            let [_, off] = self.probes.limits(part, &self.touch);
            let near = |p: &SkinPoint| environment.nearest_of_unit(u, p.position(transforms), off + p.radius).is_some();
            self.probes.points_of(part).iter().any(near)
        };
        let planted: Vec<usize> = (0..PARTS.len()).filter(|&part| contacts.any(PARTS[part])).collect();
        let is_in = |&u: &usize| {
            let at = environment.placement(u).inverse_transform_point(hips);
            environment.geometry(u).region.contains(at) || planted.iter().any(|&part| touches(part, u))
        };
        (0..environment.units.len()).filter(is_in).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::placed::tests::placed;
    use super::*;
    use throng_motion::clip::joint_transforms;

    #[test]
    fn settings_outside_their_limits_are_named() {
        let fault = |cfg: GeometryTouchConfig| cfg.check().unwrap_err().to_string();
        GeometryTouchConfig::default().check().unwrap();
        assert!(
            fault(GeometryTouchConfig { hand_on: 0.2, ..GeometryTouchConfig::default() })
                .starts_with("hand_on: expected above 0")
        );
        assert!(
            fault(GeometryTouchConfig { seat_on: f32::NAN, ..GeometryTouchConfig::default() }).starts_with("seat_on")
        );
        assert!(
            fault(GeometryTouchConfig { penetration: -0.1, ..GeometryTouchConfig::default() })
                .starts_with("penetration")
        );
    }

    #[test]
    fn soles_of_a_standing_body_are_on_the_ground_and_palms_beyond_the_wrists() {
        let s = Skeleton::default();
        let t = throng_motion::clip::joint_transforms(&s, s.offsets[0], |_| Quat::IDENTITY);
        let probes = SkinPoints::new(&s);
        for part in 0..4 {
            assert!(probes.points_of(part).iter().all(|p| p.position(&t).y.abs() < 1e-5), "{part}");
        }
        let palm = probes.points_of(4)[1].position(&t);
        assert!((palm - t[Joint::LeftHand.index()].0 - Vec3::X * 0.06).length() < 1e-4, "{palm}");
    }

    #[test]
    fn poses_belong_to_what_they_touch_and_to_the_regions_their_hips_are_in() {
        let units = "[[units]]\nname = \"panel\"\nshapes = [{ box = { at = [0.0, -0.05, 0.0], size = [2.0, 0.1, 2.0] } \
                     }]\n[[units]]\nname = \"step\"\nshapes = [{ box = { at = [0.0, 0.1, 0.0], size = [1.0, 0.2, 0.4] \
                     } }]\nregion = { min = [-0.5, 5.0, -0.2], max = [0.5, 6.0, 0.2] }\n";
        let e = placed(
            units,
            "{ unit = \"panel\", at = [0.0, 0.0, 0.0] }, { unit = \"panel\", at = [0.0, 0.0, 2.0] }, \
             { unit = \"step\", at = [0.0, 0.0, 0.3] }",
        );
        let s = Skeleton::default();
        let belonging = UnitMembership::new(&s, &GeometryTouchConfig::default());
        let of = |at: Vec3, contacts: u8| {
            let t = joint_transforms(&s, s.offsets[0] + at, |_| Quat::IDENTITY);
            belonging.units_of(&t, Contacts(contacts), &e)
        };
        // Toes over the edge between panels: hips in the first one, toes on the second.
        assert_eq!(of(Vec3::Z * 0.9, 15), [0, 1]);
        assert_eq!(of(Vec3::Z * 0.9, 5), [0], "the toes are not planted");
        assert_eq!(of(Vec3::new(0.0, 0.2, 0.3), 15), [0, 2], "feet on the step, hips above the panel");
        assert_eq!(of(Vec3::new(0.0, 0.2, 0.3), 0), [0]);
        assert_eq!(of(Vec3::new(0.0, 4.4, 0.3), 0), [2]);
        assert!(of(Vec3::X * 4.0, 15).is_empty());
    }
}
