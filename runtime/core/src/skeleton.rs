//! The skeleton: joints, parents, rest offsets.

use glam::Vec3;
use throng_base::thresholds::HEEL_PER_BALL;

/// Joints of the database skeleton.
pub const NUM_JOINTS: usize = 22;

/// Declares the joints, in the order of their indices, with their names in snake_case and their parents.
macro_rules! joints {
    ($($joint:ident $name:literal $parent:expr,)+) => {
        /// The joints of the database skeleton, parents before children.
        #[allow(missing_docs)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "snake_case")]
        #[repr(u8)]
        pub enum Joint {
            $($joint,)+
        }

        impl Joint {
            /// Every joint, in index order.
            pub const ALL: [Self; NUM_JOINTS] = [$(Self::$joint,)+];

            /// The joint's name in snake_case, as profiles, configs and reports write it.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$joint => $name,)+
                }
            }

            /// The parent joint; `None` for the hips.
            pub const fn parent(self) -> Option<Self> {
                match self {
                    $(Self::$joint => $parent,)+
                }
            }
        }
    };
}

joints! {
    Hips "hips" None,
    Spine "spine" Some(Self::Hips),
    Chest "chest" Some(Self::Spine),
    UpperChest "upper_chest" Some(Self::Chest),
    Neck "neck" Some(Self::UpperChest),
    Head "head" Some(Self::Neck),
    LeftClavicle "left_clavicle" Some(Self::UpperChest),
    LeftUpperArm "left_upper_arm" Some(Self::LeftClavicle),
    LeftForearm "left_forearm" Some(Self::LeftUpperArm),
    LeftHand "left_hand" Some(Self::LeftForearm),
    RightClavicle "right_clavicle" Some(Self::UpperChest),
    RightUpperArm "right_upper_arm" Some(Self::RightClavicle),
    RightForearm "right_forearm" Some(Self::RightUpperArm),
    RightHand "right_hand" Some(Self::RightForearm),
    LeftThigh "left_thigh" Some(Self::Hips),
    LeftShin "left_shin" Some(Self::LeftThigh),
    LeftFoot "left_foot" Some(Self::LeftShin),
    LeftToe "left_toe" Some(Self::LeftFoot),
    RightThigh "right_thigh" Some(Self::Hips),
    RightShin "right_shin" Some(Self::RightThigh),
    RightFoot "right_foot" Some(Self::RightShin),
    RightToe "right_toe" Some(Self::RightFoot),
}

/// Legs: thigh, shin, foot, toe.
pub const LEGS: [[Joint; 4]; 2] = [
    [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot, Joint::LeftToe],
    [Joint::RightThigh, Joint::RightShin, Joint::RightFoot, Joint::RightToe],
];
/// Arms: upper arm, forearm, hand.
pub const ARMS: [[Joint; 3]; 2] = [
    [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
    [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
];

impl Joint {
    /// Index in pose arrays.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The joint of that snake_case name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|j| j.name() == name)
    }

    /// Joint of the other side; joints of the middle are their own.
    pub const fn mirrored(self) -> Self {
        let i = self as usize;
        Self::ALL[match i {
            6..=9 | 14..=17 => i + 4,
            10..=13 | 18..=21 => i - 4,
            _ => i,
        }]
    }
}

/// A skeleton with the topology of [`Joint`] and proportions of its own.
///
/// Rest pose: every joint's rest rotation is the identity in model space (local axes are the model axes:
/// X left, Y up, Z forward), the character stands in a T-pose: legs straight down, feet pointing along +Z,
/// arms straight out along +X (left) and -X (right), palms down. The left side is +X.
///
/// ```
/// use throng_core::{Joint, Skeleton};
///
/// let adult = Skeleton::default();
/// assert!((adult.height() - 1.75).abs() < 0.05);
/// assert!(adult.rest_positions()[Joint::LeftHand.index()].x > 0.0, "the left side is +X");
/// ```
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Skeleton {
    /// Offset from the parent joint in rest pose; the hips' is their height above the ground (m).
    pub offsets: [Vec3; NUM_JOINTS],
    /// End of the head from the head joint, and of each toe from the toe joint, in rest pose
    /// (head top, left toe tip, right toe tip). Only drawing and heights use it (m).
    pub tips: [Vec3; 3],
}

impl Skeleton {
    /// Length of a leg: thigh plus shin, the mean of both sides (m).
    pub fn leg_length(&self) -> f32 {
        use Joint::*;
        [LeftShin, LeftFoot, RightShin, RightFoot].iter().map(|j| self.offsets[j.index()].length()).sum::<f32>() * 0.5
    }

    /// Height of the top of the head in the rest pose (m).
    pub fn height(&self) -> f32 {
        self.rest_positions()[Joint::Head.index()].y + self.tips[0].y
    }

    /// Factor and offset that put the hips of a database's motion on this body: their height is scaled, then the offset
    /// is added, so that both stand on the ground (factor, m).
    pub fn hips_over(&self, database: &Self) -> [f32; 2] {
        let scale = self.leg_length() / database.leg_length();
        let rise = |s: &Self| {
            let rest = s.rest_positions();
            let feet = 0.5 * (rest[Joint::LeftFoot.index()].y + rest[Joint::RightFoot.index()].y);
            let hips = 0.5 * (s.offsets[Joint::LeftThigh.index()].y + s.offsets[Joint::RightThigh.index()].y);
            feet - hips
        };
        [scale, rise(self) - scale * rise(database)]
    }

    /// Rest positions of all joints in model space (m).
    pub fn rest_positions(&self) -> [Vec3; NUM_JOINTS] {
        let mut p = [Vec3::ZERO; NUM_JOINTS];
        for j in Joint::ALL {
            let base = j.parent().map_or(Vec3::ZERO, |q| p[q.index()]);
            p[j.index()] = base + self.offsets[j.index()];
        }
        p
    }

    /// Bottoms of the left and the right heel, from the ankle in the foot's frame: as far behind the ankle as feet are
    /// for their length (m).
    pub fn heels(&self) -> [Vec3; 2] {
        let rest = self.rest_positions();
        let feet = [(Joint::LeftFoot, Joint::LeftToe), (Joint::RightFoot, Joint::RightToe)];
        feet.map(|(foot, toe)| Vec3::new(0.0, -rest[foot.index()].y, -HEEL_PER_BALL * self.offsets[toe.index()].z))
    }
}

impl Default for Skeleton {
    /// An adult of 1.75 m (segment lengths after Winter, *Biomechanics and Motor Control of Human Movement*,
    /// table of segment lengths as fractions of body height).
    fn default() -> Self {
        use Joint::*;
        let mut o = [Vec3::ZERO; NUM_JOINTS];
        let mut set = |j: Joint, x: f32, y: f32, z: f32| o[j.index()] = Vec3::new(x, y, z);
        set(Hips, 0.0, 0.955, 0.0);
        set(Spine, 0.0, 0.095, 0.0);
        set(Chest, 0.0, 0.125, 0.0);
        set(UpperChest, 0.0, 0.13, 0.0);
        set(Neck, 0.0, 0.19, 0.0);
        set(Head, 0.0, 0.09, 0.015);
        for (s, clavicle, arm, forearm, hand) in [
            (1.0, LeftClavicle, LeftUpperArm, LeftForearm, LeftHand),
            (-1.0, RightClavicle, RightUpperArm, RightForearm, RightHand),
        ] {
            set(clavicle, s * 0.03, 0.14, 0.0);
            set(arm, s * 0.155, 0.0, 0.0);
            set(forearm, s * 0.29, 0.0, 0.0);
            set(hand, s * 0.255, 0.0, 0.0);
        }
        for (s, thigh, shin, foot, toe) in
            [(1.0, LeftThigh, LeftShin, LeftFoot, LeftToe), (-1.0, RightThigh, RightShin, RightFoot, RightToe)]
        {
            set(thigh, s * 0.092, -0.045, 0.0);
            set(shin, 0.0, -0.42, 0.0);
            set(foot, 0.0, -0.41, 0.0);
            set(toe, 0.0, -0.06, 0.135);
        }
        Self { offsets: o, tips: [Vec3::new(0.0, 0.2, 0.0), Vec3::new(0.0, 0.0, 0.07), Vec3::new(0.0, 0.0, 0.07)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parents_come_first_and_mirroring_is_its_own_inverse() {
        for (i, j) in Joint::ALL.into_iter().enumerate() {
            assert_eq!(j.index(), i);
            assert!(j.parent().is_none_or(|p| p.index() < i));
            assert_eq!(j.mirrored().mirrored(), j);
            assert_eq!(j.mirrored().name().replace("right", "left"), j.name().replace("right", "left"));
            assert_eq!(Joint::from_name(j.name()), Some(j));
        }
    }

    #[test]
    fn the_default_skeleton_has_legs_of_reference() {
        assert_eq!(Skeleton::default().leg_length(), throng_base::thresholds::REFERENCE_LEG_M);
    }
}
