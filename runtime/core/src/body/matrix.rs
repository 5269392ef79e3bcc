//! Poses as matrices: what a renderer takes.

use glam::{Mat4, Quat, Vec3};

/// A rigid transform as three rows of four: `[R | t]`, row-major, the layout of a GPU's 3x4 matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(16))]
pub struct Mat3x4 {
    /// Row i holds the i-th output coordinate: three columns of the rotation, then the translation.
    pub rows: [[f32; 4]; 3],
}

impl Mat3x4 {
    /// The translation (m).
    pub fn translation(&self) -> Vec3 {
        Vec3::new(self.rows[0][3], self.rows[1][3], self.rows[2][3])
    }

    /// The transform from a rotation and a translation.
    pub fn from_rotation_translation(rotation: Quat, translation: Vec3) -> Self {
        let m = glam::Mat3::from_quat(rotation).transpose();
        let row = |r: Vec3, t: f32| [r.x, r.y, r.z, t];
        Self { rows: [row(m.x_axis, translation.x), row(m.y_axis, translation.y), row(m.z_axis, translation.z)] }
    }

    /// The matrix as a 4x4 matrix.
    pub fn to_mat4(&self) -> Mat4 {
        let [a, b, c] = self.rows;
        Mat4::from_cols_array_2d(&[a, b, c, [0.0, 0.0, 0.0, 1.0]]).transpose()
    }

    /// The rotation.
    pub fn rotation(&self) -> Quat {
        Quat::from_mat4(&self.to_mat4())
    }
}

impl std::ops::Mul for Mat3x4 {
    type Output = Self;

    /// First `joint`, then `self`.
    fn mul(self, joint: Self) -> Self {
        let row = |a: [f32; 4]| {
            let column = |c: usize| a[0] * joint.rows[0][c] + a[1] * joint.rows[1][c] + a[2] * joint.rows[2][c];
            [column(0), column(1), column(2), column(3) + a[3]]
        };
        Self { rows: self.rows.map(row) }
    }
}

/// A joint's transform relative to its parent.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct LocalTransform {
    /// (x, y, z, w).
    pub rotation: [f32; 4],
    /// (m)
    pub translation: [f32; 3],
    /// Zero; keeps records at 32 bytes.
    pub padding: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_transform_points_as_the_parts_do() {
        let (r, t) = (Quat::from_rotation_y(0.4) * Quat::from_rotation_x(1.0), Vec3::new(1.0, 2.0, 3.0));
        let m = Mat3x4::from_rotation_translation(r, t);
        let p = Vec3::new(0.3, -0.2, 0.9);
        assert!(m.to_mat4().transform_point3(p).abs_diff_eq(r * p + t, 1e-6));
        assert!(m.rotation().dot(r).abs() > 0.999_999);
        assert_eq!(m.translation(), t);
        let twice = (m * m).to_mat4().transform_point3(p);
        assert!(twice.abs_diff_eq(r * (r * p + t) + t, 1e-5));
    }
}
