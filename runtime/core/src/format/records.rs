//! The records of the sections that hold motion.

use crate::skeleton::{NUM_JOINTS, Skeleton};
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

/// Scale of a stored rotation component: `i16 / 32767`.
const QUANTUM: f32 = 32767.0;

/// One frame of motion: 192 bytes, three cache lines.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FrameRow {
    /// Planar root within the clip: x, z and heading, which is unwrapped (continuous over a clip's frames).
    /// (m, m, rad)
    pub planar: [f32; 3],
    /// Height of the hips above the ground (m).
    pub height: f32,
    /// Rotations as (x, y, z, w) * 32767; joint 0 is the tilt, the others are relative to their parents.
    /// Neighbouring frames of a clip have a positive dot product (NUM_JOINTS).
    pub rotations: [[i16; 4]; NUM_JOINTS],
}

const _: () = assert!(size_of::<FrameRow>() == 192);

impl FrameRow {
    /// The stored rotation of a joint, normalised. Differs from what was encoded by less than 1e-4 rad.
    pub fn rotation(&self, joint: usize) -> Quat {
        let [x, y, z, w] = self.rotations[joint].map(|v| f32::from(v) / QUANTUM);
        Quat::from_xyzw(x, y, z, w).normalize()
    }

    /// A unit quaternion as it is stored.
    pub fn encode(q: Quat) -> [i16; 4] {
        q.to_array().map(|v| (v.clamp(-1.0, 1.0) * QUANTUM).round() as i16)
    }
}

/// A clip's frames in the section of frame rows.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ClipRecord {
    /// First row.
    pub first_frame: u32,
    /// Number of rows (> 0).
    pub num_frames: u32,
    /// 1 for a mirrored copy, else 0.
    pub mirrored: u32,
    /// Zero.
    pub reserved: u32,
}

/// The database skeleton, see [`Skeleton`].
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SkeletonRecord {
    /// Rest offsets from the parents (m).
    pub offsets: [[f32; 3]; NUM_JOINTS],
    /// Tips of head, left toe and right toe (m).
    pub tips: [[f32; 3]; 3],
}

impl From<&Skeleton> for SkeletonRecord {
    fn from(s: &Skeleton) -> Self {
        Self { offsets: s.offsets.map(|v| v.to_array()), tips: s.tips.map(|v| v.to_array()) }
    }
}

impl From<&SkeletonRecord> for Skeleton {
    fn from(s: &SkeletonRecord) -> Self {
        Self { offsets: s.offsets.map(Vec3::from_array), tips: s.tips.map(Vec3::from_array) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn storing_a_rotation_turns_it_by_less_than_a_ten_thousandth(v in prop::array::uniform4(-1.0f32..1.0)) {
            let q = Quat::from_array(v);
            prop_assume!(q.length() > 0.1);
            let q = q.normalize();
            let mut row = FrameRow::zeroed();
            row.rotations[3] = FrameRow::encode(q);
            let r = row.rotation(3);
            let sine = (q.conjugate() * r).xyz().as_dvec3().length();
            prop_assert!(2.0 * sine < 1e-4, "{}", 2.0 * sine);
        }
    }
}
