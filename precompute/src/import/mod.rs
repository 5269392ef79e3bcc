//! Files to raw clips: BVH and ASF/AMC, in metres, Y up, with a role for every joint that matters.
//!
//! Each format has its own reader that yields the motion in the file's units.
//! Units, up axis and rest pose are then found from the body's size and pose, and a skeleton profile (or a guess
//! by name and topology) says which joint plays which role.

pub mod amc;
pub mod asf;
pub mod bvh;
pub mod config;
mod scan;
mod source;

use crate::{Warnings, raw::RawClip};
pub use config::{Forward, ImportConfig, UpAxis};
use glam::Quat;
pub use source::SourceClip;
use throng_runtime::{Joint, NUM_JOINTS};

/// A clip as read, with everything that was found out about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The motion: metres, Y up, right-handed; the source's own joints.
    pub clip: RawClip,
    /// Which source joint plays which role.
    pub roles: RoleMap,
    /// What the source's zero pose is.
    pub rest_pose: RestPose,
    /// Length of one unit of the file. [Unit: m]
    pub metres_per_unit: f64,
    /// Axis that points up in the file (the clip itself is Y up).
    pub up: UpAxis,
    /// Heading the rest pose faces, about +Y; 0 where the rest pose is not a body. [Unit: rad]
    pub facing: f32,
    /// Body height estimated from the lengths of the segments. [Unit: m]
    pub height: f32,
    /// One sentence for each thing that was detected: what and why.
    pub findings: Vec<String>,
    /// What is odd but tolerable, naming the file.
    pub warnings: Warnings,
}

/// Which source joint plays which role of the database skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleMap {
    /// Index into the clip's joints by role; `None` where the source has no such joint.
    /// Hips, thighs, shins, feet, upper arms and one of neck and head are always there.
    pub joints: [Option<usize>; NUM_JOINTS],
    /// Name of the profile, or `guessed from joint names`.
    pub profile: String,
    /// What the mapping is unsure of, one sentence each.
    pub warnings: Vec<String>,
}

impl RoleMap {
    /// The source joint of a role.
    pub fn get(&self, role: Joint) -> Option<usize> {
        self.joints[role.index()]
    }
}

/// What the pose is that a source skeleton has when all rotations are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestPoseKind {
    /// A body that stands with its arms held out sideways (within 20 degrees).
    TPose,
    /// A body that stands with its arms lowered.
    APose,
    /// Not a standing body: offsets follow some other rule, such as every segment along one axis.
    Other,
}

/// The rest pose of a source and a standing pose to compare with.
#[derive(Clone, Debug, PartialEq)]
pub struct RestPose {
    /// What the zero pose is.
    pub kind: RestPoseKind,
    /// World rotation of every source joint when the body stands upright, legs straight down, facing +Z, and is
    /// as near to a T-pose as is known. Where the zero pose is a body, all entries are the one rotation that
    /// turns it upright and towards +Z (the identity for most files), and limbs point wherever the offsets take
    /// them (an A-pose stays one). Where the zero pose is not a body, rotations of role joints are estimated from
    /// the motion, so that each segment points as it does in a T-pose. Positions follow from the offsets.
    /// [Size: joints.len()]
    pub reference: Vec<Quat>,
    /// What was found and why.
    pub sentence: String,
}
