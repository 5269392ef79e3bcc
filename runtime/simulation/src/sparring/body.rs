//! Bodies as capsules, which blows strike, and which must not overlap.

use super::config::check_within;
use glam::{Vec2, Vec3};
use throng_base::Result;
use throng_base::maths;
use throng_core::planar::Planar;
use throng_core::body::Mat3x4;
use throng_core::skeleton::{Joint, NUM_JOINTS, Skeleton};
use throng_geometry::Capsule;

/// Struck part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum StruckPart {
    /// The head.
    Head,
    /// The neck.
    Neck,
    /// Chest and waist.
    Trunk,
    /// The pelvis.
    Pelvis,
    /// Upper arm, forearm or hand: the blow is blocked.
    Arm,
    /// Thigh or shin.
    Leg,
}

/// Radii of the capsules of the default skeleton; those of other bodies are scaled by their height
/// (m, 0.001 to 1).
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct BodyShape {
    pub head_m: f32,
    pub neck_m: f32,
    pub chest_m: f32,
    pub waist_m: f32,
    pub pelvis_m: f32,
    pub upper_arm_m: f32,
    pub forearm_m: f32,
    pub hand_m: f32,
    pub thigh_m: f32,
    pub shin_m: f32,
}

impl Default for BodyShape {
    fn default() -> Self {
        Self {
            head_m: 0.1,
            neck_m: 0.06,
            chest_m: 0.12,
            waist_m: 0.12,
            pelvis_m: 0.12,
            upper_arm_m: 0.05,
            forearm_m: 0.045,
            hand_m: 0.05,
            thigh_m: 0.08,
            shin_m: 0.055,
        }
    }
}

impl BodyShape {
    pub(crate) fn check(&self) -> Result<()> {
        for (what, got) in [
            ("body.head_m", self.head_m),
            ("body.neck_m", self.neck_m),
            ("body.chest_m", self.chest_m),
            ("body.waist_m", self.waist_m),
            ("body.pelvis_m", self.pelvis_m),
            ("body.upper_arm_m", self.upper_arm_m),
            ("body.forearm_m", self.forearm_m),
            ("body.hand_m", self.hand_m),
            ("body.thigh_m", self.thigh_m),
            ("body.shin_m", self.shin_m),
        ] {
            check_within(what, got, 1e-3, 1.0, "between 0.001 and 1")?;
        }
        Ok(())
    }
}

/// Number of capsules of a body.
pub const NUM_CAPSULES: usize = 15;
/// Number of core capsules, which come first: head, neck, chest, waist, pelvis.
pub const NUM_CORE: usize = 5;

/// Numbers of the waist, the left forearm, and the left thigh, which the shin follows.
const WAIST: usize = 3;
const FOREARM: usize = 6;
const THIGH: usize = 11;

/// Capsule that is attached to joints.
#[derive(Clone, Copy, Debug)]
struct JointCapsule {
    part: StruckPart,
    /// Joint that is pushed by a blow.
    joint: Joint,
    /// Ends of the axis, each in the frame of a joint (m).
    ends: [(Joint, Vec3); 2],
    radius: f32,
}

/// Capsules of a skeleton's body.
#[derive(Clone, Debug)]
pub struct SparringBody {
    limbs: [JointCapsule; NUM_CAPSULES],
    head_centre: Vec3,
}

/// Height of the top of the head above the ankles, in rest pose (m).
fn standing_height(skeleton: &Skeleton) -> f32 {
    let rest = skeleton.rest_positions();
    rest[Joint::Head.index()].y + skeleton.tips[0].y - rest[Joint::LeftFoot.index()].y
}

impl SparringBody {
    /// Fits capsules to a skeleton.
    pub fn new(skeleton: &Skeleton, shape: &BodyShape) -> Self {
        use Joint::*;
        let rest = skeleton.rest_positions();
        let scale = standing_height(skeleton) / standing_height(&Skeleton::default());
        let at = |j: Joint, offset: Vec3| (j, offset);
        let head_centre = throng_core::characters::head_centre(skeleton);
        // Flat parts are capsules from side to side, shorter than the body is wide by about their radius.
        let side = |j: Joint, outer: Joint, share: f32| {
            let x = Vec3::X * ((rest[outer.index()].x - rest[j.index()].x).abs() * share);
            [(j, x), (j, -x)]
        };
        let joint = |j: Joint| at(j, Vec3::ZERO);
        let limb = |part, joint, ends, radius| JointCapsule { part, joint, ends, radius: radius * scale };
        let hand = |j: Joint| [joint(j), at(j, throng_core::hits::striking_offset(skeleton, j))];
        Self {
            head_centre,
            limbs: [
                limb(StruckPart::Head, Head, [at(Head, head_centre * 0.7), at(Head, head_centre * 1.1)], shape.head_m),
                limb(StruckPart::Neck, Neck, [joint(Neck), joint(Head)], shape.neck_m),
                limb(StruckPart::Trunk, UpperChest, side(UpperChest, LeftUpperArm, 0.4), shape.chest_m),
                limb(StruckPart::Trunk, Chest, [joint(Spine), joint(Chest)], shape.waist_m),
                limb(StruckPart::Pelvis, Hips, side(Hips, LeftThigh, 0.5), shape.pelvis_m),
                limb(StruckPart::Arm, LeftUpperArm, [joint(LeftUpperArm), joint(LeftForearm)], shape.upper_arm_m),
                limb(StruckPart::Arm, LeftForearm, [joint(LeftForearm), joint(LeftHand)], shape.forearm_m),
                limb(StruckPart::Arm, LeftHand, hand(LeftHand), shape.hand_m),
                limb(StruckPart::Arm, RightUpperArm, [joint(RightUpperArm), joint(RightForearm)], shape.upper_arm_m),
                limb(StruckPart::Arm, RightForearm, [joint(RightForearm), joint(RightHand)], shape.forearm_m),
                limb(StruckPart::Arm, RightHand, hand(RightHand), shape.hand_m),
                limb(StruckPart::Leg, LeftThigh, [joint(LeftThigh), joint(LeftShin)], shape.thigh_m),
                limb(StruckPart::Leg, LeftShin, [joint(LeftShin), joint(LeftFoot)], shape.shin_m),
                limb(StruckPart::Leg, RightThigh, [joint(RightThigh), joint(RightShin)], shape.thigh_m),
                limb(StruckPart::Leg, RightShin, [joint(RightShin), joint(RightFoot)], shape.shin_m),
            ],
        }
    }

    /// Body part of a capsule (capsule < NUM_CAPSULES).
    pub fn part_of(&self, capsule: usize) -> StruckPart {
        self.limbs[capsule].part
    }

    /// Joint that is pushed where a capsule is struck (capsule < NUM_CAPSULES).
    pub fn joint_of(&self, capsule: usize) -> Joint {
        self.limbs[capsule].joint
    }

    /// Radius of a forearm (m).
    pub(super) fn forearm_radius(&self) -> f32 {
        self.limbs[FOREARM].radius
    }

    /// Radii of a thigh and a shin (m).
    pub(super) fn leg_radii(&self) -> [f32; 2] {
        [THIGH, THIGH + 1].map(|i| self.limbs[i].radius)
    }

    /// Capsules of a pose in the world.
    pub fn capsules(&self, pose: &WorldPose<'_>) -> [Capsule; NUM_CAPSULES] {
        std::array::from_fn(|i| self.capsule(i, pose))
    }

    /// Core capsules of a pose in the world.
    pub fn core_capsules(&self, pose: &WorldPose<'_>) -> [Capsule; NUM_CORE] {
        std::array::from_fn(|i| self.capsule(i, pose))
    }

    /// Capsules that stop the limbs of an opponent, in the world: the core, and the whole spine between pelvis and neck.
    pub(super) fn obstacle_capsules(&self, pose: &WorldPose<'_>) -> [Capsule; NUM_CORE + 1] {
        let mut all = [self.capsule(WAIST, pose); NUM_CORE + 1];
        all[..NUM_CORE].copy_from_slice(&self.core_capsules(pose));
        let [hips, chest, neck] = [Joint::Hips, Joint::Chest, Joint::Neck].map(|j| pose.point_in_world(j, Vec3::ZERO));
        all[WAIST].ends = [hips, chest];
        all[NUM_CORE].ends = [chest, neck];
        all
    }

    /// Middle of the head in the world (m).
    pub fn head_position(&self, pose: &WorldPose<'_>) -> Vec3 {
        pose.point_in_world(Joint::Head, self.head_centre)
    }

    /// The middle of the head in the head joint's own frame (m).
    pub fn head_centre(&self) -> Vec3 {
        self.head_centre
    }

    fn capsule(&self, i: usize, pose: &WorldPose<'_>) -> Capsule {
        let limb = &self.limbs[i];
        Capsule { ends: limb.ends.map(|(joint, offset)| pose.point_in_world(joint, offset)), radius: limb.radius }
    }
}

/// Pose of a character in the world.
#[derive(Clone, Copy, Debug)]
pub struct WorldPose<'a> {
    pose: &'a [Mat3x4],
    place: Vec3,
    sin: f32,
    cos: f32,
}

impl<'a> WorldPose<'a> {
    /// - `pose`: in model space (NUM_JOINTS).
    pub fn new(pose: &'a [Mat3x4], root: Planar) -> Self {
        let (sin, cos) = maths::sin_cos(root.heading);
        Self { pose: &pose[..NUM_JOINTS], place: root.translation(), sin, cos }
    }

    /// Position of the planar root: x and z (m).
    pub fn root(&self) -> Vec2 {
        Vec2::new(self.place.x, self.place.z)
    }

    /// World position of a point in a joint's frame (m).
    pub fn point_in_world(&self, joint: Joint, offset: Vec3) -> Vec3 {
        let [x, y, z] =
            self.pose[joint.index()].rows.map(|r| r[0] * offset.x + r[1] * offset.y + r[2] * offset.z + r[3]);
        Vec3::new(self.cos * x + self.sin * z, y, self.cos * z - self.sin * x) + self.place
    }
}
