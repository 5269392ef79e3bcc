//! Bodies as capsules, which blows strike, and which must not overlap.

use super::config::check_within;
use glam::{Vec2, Vec3};
use throng_base::{Result, maths};
use throng_core::skeleton::{Joint, NUM_JOINTS, Skeleton};
use throng_core::{BodyVolume, body::Mat3x4, planar::Planar};
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

/// Radii of the capsules of the default skeleton; those of other bodies are scaled by the length of
/// their legs (m, 0.001 to 1).
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
        let radius_m = BodyVolume::radius_m;
        Self {
            head_m: radius_m(Joint::Head),
            neck_m: radius_m(Joint::Neck),
            chest_m: radius_m(Joint::UpperChest),
            waist_m: radius_m(Joint::Chest),
            pelvis_m: radius_m(Joint::Hips),
            upper_arm_m: radius_m(Joint::LeftUpperArm),
            forearm_m: radius_m(Joint::LeftForearm),
            hand_m: radius_m(Joint::LeftHand),
            thigh_m: radius_m(Joint::LeftThigh),
            shin_m: radius_m(Joint::LeftShin),
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
pub const NUM_CAPSULES: usize = STRUCK.len();
/// Number of core capsules, which come first: [`BodyVolume::CORE`].
pub const NUM_CORE: usize = BodyVolume::CORE.len();

/// Joints whose capsules are struck: the core, arms and legs.
const STRUCK: [Joint; 16] = {
    use Joint::*;
    let [a, b, c, d, e, f] = BodyVolume::CORE;
    let [g, h, i] = [LeftUpperArm, LeftForearm, LeftHand];
    let [j, k, l] = [RightUpperArm, RightForearm, RightHand];
    [a, b, c, d, e, f, g, h, i, j, k, l, LeftThigh, LeftShin, RightThigh, RightShin]
};

/// Capsules of a skeleton's body.
#[derive(Clone, Debug)]
pub struct SparringBody {
    volume: BodyVolume,
    head_centre: Vec3,
}

impl SparringBody {
    /// Volume of a skeleton's body, with the radii of a shape.
    pub fn new(skeleton: &Skeleton, shape: &BodyShape) -> Self {
        use Joint::*;
        let scale = BodyVolume::scale(skeleton);
        let mut volume = BodyVolume::new(skeleton);
        for joint in STRUCK {
            volume.capsules[joint.index()].radius = scale
                * match joint {
                    Head => shape.head_m,
                    Neck => shape.neck_m,
                    UpperChest => shape.chest_m,
                    Hips => shape.pelvis_m,
                    LeftUpperArm | RightUpperArm => shape.upper_arm_m,
                    LeftForearm | RightForearm => shape.forearm_m,
                    LeftHand | RightHand => shape.hand_m,
                    LeftThigh | RightThigh => shape.thigh_m,
                    LeftShin | RightShin => shape.shin_m,
                    _ => shape.waist_m,
                };
        }
        Self { volume, head_centre: throng_core::characters::head_centre(skeleton) }
    }

    /// Body part of a capsule (capsule < NUM_CAPSULES).
    pub fn part_of(&self, capsule: usize) -> StruckPart {
        match capsule {
            0 => StruckPart::Head,
            1 => StruckPart::Neck,
            2..=4 => StruckPart::Trunk,
            5 => StruckPart::Pelvis,
            6..=11 => StruckPart::Arm,
            _ => StruckPart::Leg,
        }
    }

    /// Joint that is pushed where a capsule is struck: its own, or the chest for the waist (capsule < NUM_CAPSULES).
    pub fn joint_of(&self, capsule: usize) -> Joint {
        match STRUCK[capsule] {
            Joint::Spine => Joint::Chest,
            joint => joint,
        }
    }

    /// Capsules of all joints, in their own frames.
    pub(super) fn volume(&self) -> &BodyVolume {
        &self.volume
    }

    /// Capsules of a pose in the world.
    pub fn capsules(&self, pose: &WorldPose<'_>) -> [Capsule; NUM_CAPSULES] {
        STRUCK.map(|joint| self.volume.capsules[joint.index()].placed(|j, p| pose.point_in_world(j, p)))
    }

    /// Core capsules of a pose in the world, which stop the limbs of an opponent.
    pub fn core_capsules(&self, pose: &WorldPose<'_>) -> [Capsule; NUM_CORE] {
        self.volume.place_core(|joint, p| pose.point_in_world(joint, p))
    }

    /// Middle of the head in the world (m).
    pub fn head_position(&self, pose: &WorldPose<'_>) -> Vec3 {
        pose.point_in_world(Joint::Head, self.head_centre)
    }

    /// The middle of the head in the head joint's own frame (m).
    pub fn head_centre(&self) -> Vec3 {
        self.head_centre
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
