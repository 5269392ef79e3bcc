//! Frames as points whose Euclidean distance is never above the distance of the features.

use super::Features;
use super::row::LINEAR;
use glam::{Mat3, Quat, Vec3};
use throng_core::NUM_JOINTS;
use throng_motion::clip::FrameId;

/// Dimensions of the embedding: a rotation matrix a joint, the Euclidean features, the vertical in the root's frame.
pub(super) const EMBEDDING: usize = 9 * (NUM_JOINTS - 1) + LINEAR + 3;

impl Features {
    /// The point of a frame.
    ///
    /// Rotations count as the chord `2 sin(a / 2)` instead of the angle `a`: of rotation matrices for the joints,
    /// which do not tell `q` from `-q`, and of the vertical in the root's frame, which a turn about it leaves alone.
    pub(super) fn embed(&self, frame: FrameId) -> [f32; EMBEDDING] {
        let row = &self.rows[frame.0 as usize];
        let mut out = [0.0; EMBEDDING];
        let (joints, rest) = out.split_at_mut(9 * (NUM_JOINTS - 1));
        for (j, place) in joints.chunks_exact_mut(9).enumerate() {
            let matrix = Mat3::from_quat(Quat::from_xyzw(row.x[j], row.y[j], row.z[j], row.w[j]));
            // The entries of two matrices an angle `a` apart differ by sqrt(8) sin(a / 2).
            place.copy_from_slice(&(matrix * (0.5 * self.joint_weights[j]).sqrt()).to_cols_array());
        }
        rest[..LINEAR].copy_from_slice(&row.linear);
        let vertical = row.root.conjugate() * Vec3::Y * self.orientation_weight.sqrt();
        rest[LINEAR..].copy_from_slice(&vertical.to_array());
        out
    }
}
