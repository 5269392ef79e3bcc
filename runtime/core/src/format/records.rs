//! The records of the sections that hold motion.

use crate::skeleton::{NUM_JOINTS, Skeleton};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Frame of motion: 96 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FrameRow {
    /// Planar root within the clip: x, z and heading, which is unwrapped (continuous over a clip's frames).
    /// (m, m, rad)
    pub planar: [f32; 3],
    /// Height of the hips above the ground (m).
    pub height: f32,
    /// Rotations of all joints, packed as the bundle's [`super::RotationCode`] says.
    pub rotations: [u8; ROTATION_BYTES],
}

impl FrameRow {
    /// The planar root, and the height of the hips.
    #[inline(always)]
    pub(crate) fn root(&self) -> &[f32; 4] {
        // The first four numbers of the row.
        bytemuck::from_bytes(&bytemuck::bytes_of(self)[..16])
    }
}

/// Bytes of a frame's rotations.
pub const ROTATION_BYTES: usize = 80;

const _: () = assert!(size_of::<FrameRow>() == 96);

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
