//! Axes and matrix layouts of engines.

use crate::fault::{CallFault, CallResult, ThrongStatus};
use throng_runtime::{Mat3x4, Planar};

/// Memory layout and axes of matrices.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThrongLayout {
    /// Three rows of four; right-handed, X left, Y up, Z forward, metres.
    Throng = 0,
    /// Unity's `Matrix4x4`, four columns of four; left-handed, X right, Y up, Z forward, metres.
    Unity = 1,
    /// Unreal's `FMatrix` of floats, rows that hold the axes and then the position; left-handed, X forward, Y right, Z up,
    /// centimetres.
    Unreal = 2,
}

/// Number of floats of one matrix: 12 or 16; 0 for a layout that does not exist.
#[unsafe(no_mangle)]
pub extern "C" fn throng_layout_floats(layout: u32) -> usize {
    layout_from_number(layout).map_or(0, matrix_floats)
}

/// The layout with a number, if there is one.
fn layout_from_number(layout: u32) -> Option<ThrongLayout> {
    [ThrongLayout::Throng, ThrongLayout::Unity, ThrongLayout::Unreal].into_iter().find(|l| *l as u32 == layout)
}

/// The layout with a number.
///
/// # Errors
/// [`ThrongStatus::Value`] if there is none.
pub fn checked_layout(layout: u32) -> CallResult<ThrongLayout> {
    let why = || format!("there is no layout {layout}, expected 0 to 2");
    layout_from_number(layout).ok_or_else(|| CallFault::new(ThrongStatus::Value, why()))
}

/// Number of floats of one matrix.
pub fn matrix_floats(layout: ThrongLayout) -> usize {
    if layout == ThrongLayout::Throng { 12 } else { 16 }
}

/// Transform from a character's own frame to the world.
pub fn root_matrix(root: Planar) -> Mat3x4 {
    Mat3x4::from_rotation_translation(root.rotation(), root.translation())
}

/// Source axis and sign of each axis of a layout, and the layout's units per metre.
fn layout_axes(layout: ThrongLayout) -> ([(usize, f32); 3], f32) {
    match layout {
        ThrongLayout::Throng => ([(0, 1.0), (1, 1.0), (2, 1.0)], 1.0),
        ThrongLayout::Unity => ([(0, -1.0), (1, 1.0), (2, 1.0)], 1.0),
        ThrongLayout::Unreal => ([(2, 1.0), (0, -1.0), (1, 1.0)], 100.0),
    }
}

/// Converts a vector to the layout's axes and units.
#[cfg(test)]
fn layout_vector(layout: ThrongLayout, v: [f32; 3]) -> [f32; 3] {
    let (axes, scale) = layout_axes(layout);
    axes.map(|(axis, sign)| sign * v[axis] * scale)
}

/// Writes a matrix in the layout's axes and order ([`matrix_floats`] of them).
pub fn write_matrix(layout: ThrongLayout, m: &Mat3x4, to: &mut [f32]) {
    if layout == ThrongLayout::Throng {
        to.copy_from_slice(m.rows.as_flattened());
        return;
    }
    let (axes, scale) = layout_axes(layout);
    for (c, (from, from_sign)) in axes.into_iter().enumerate() {
        for (r, (axis, sign)) in axes.into_iter().enumerate() {
            to[4 * c + r] = sign * from_sign * m.rows[axis][from];
        }
        to[4 * c + 3] = 0.0;
    }
    for (r, (axis, sign)) in axes.into_iter().enumerate() {
        to[12 + r] = sign * m.rows[axis][3] * scale;
    }
    to[15] = 1.0;
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Quat, Vec3};

    #[test]
    fn engines_see_the_same_points() {
        let (turn, at) = (Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-1.1), Vec3::new(1.0, 2.0, -3.0));
        let m = Mat3x4::from_rotation_translation(turn, at);
        for layout in [ThrongLayout::Unity, ThrongLayout::Unreal] {
            let mut floats = [0.0; 16];
            write_matrix(layout, &m, &mut floats);
            // Column by column; the memory of rows that are multiplied from the left is the same.
            let theirs = Mat4::from_cols_array(&floats);
            assert!((theirs.determinant() - 1.0).abs() < 1e-5, "a rotation stays one");
            for p in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.2, -0.4, 0.9)] {
                let expected = Vec3::from(layout_vector(layout, (turn * p + at).to_array()));
                let found = theirs.transform_point3(layout_vector(layout, p.to_array()).into());
                assert!(found.abs_diff_eq(expected, 1e-3), "{layout:?}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn forward_up_and_right_are_the_engines() {
        let [forward, up, right] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
        let unity = [forward, up, right].map(|v| layout_vector(ThrongLayout::Unity, v));
        assert_eq!(unity, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
        let unreal = [forward, up, right].map(|v| layout_vector(ThrongLayout::Unreal, v));
        assert_eq!(unreal, [[100.0, 0.0, 0.0], [0.0, 0.0, 100.0], [0.0, 100.0, 0.0]]);
    }
}
