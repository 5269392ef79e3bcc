//! Level of detail: a distant character is a record of 32 bytes, from which a vertex shader computes the pose.

use crate::fault::{CallFault, ThrongStatus, catch_fault, check_pointer, copy_records, read_slice, write_result};
use crate::layout::{checked_layout, matrix_floats, write_matrix};
use crate::stage::ThrongSimulation;
use crate::tables::{BUNDLES, ThrongBundle};
use glam::Vec2;
use throng_base::error::ensure;
use throng_runtime::characters::{Detail, MotionSet, PoseInstance, SampleJob};
use throng_runtime::{Mat3x4, NUM_JOINTS};

/// Record from which a GPU poses a character with the frame rows of its bundle (32 bytes; `throng_bundle_write_rows`).
///
/// The pose is `mix(mix(row_a, row_a + 1, frac), mix(row_b, row_b + 1, frac), blend)`: the playing motion, and the motion
/// that a transition fades out. It stands at (x, y, z) and is turned by the heading, in Throng's axes: that is
/// (-x, y, z) and -heading in Unity, (100 z, -100 x, 100 y) and a yaw of -heading in Unreal.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrongInstance {
    /// Frame row; the next row is of the same clip, or `frac` is 0.
    pub row_a: u32,
    /// Frame row of the motion that fades out; `row_a` without a transition.
    pub row_b: u32,
    /// Fraction of the way to the next rows (65535 is 1).
    pub frac: u16,
    /// Weight of `row_b` (65535 is 1).
    pub blend: u16,
    /// Number of the character's place, to vary its appearance (< capacity).
    pub variant: u32,
    /// Position along X, to the left of heading 0 (m).
    pub x: f32,
    /// Height of the ground (m).
    pub y: f32,
    /// Position along Z (m).
    pub z: f32,
    /// Heading about +Y from +Z (rad).
    pub heading: f32,
}

const _: () = assert!(size_of::<ThrongInstance>() == 32 && size_of::<PoseInstance>() == 32);

/// Eye of the viewer, and distances up to which characters are detailed. Their paths do not depend on it.
///
/// Eight characters of neighbouring rows have one level: that of the nearest.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrongDetail {
    /// Position of the eye along X (m).
    pub eye_x: f32,
    /// Position of the eye along Z (m).
    pub eye_z: f32,
    /// Distance up to which planted feet stay in place; -1 for no character (m).
    pub full_m: f32,
    /// Distance up to which poses are computed, at least `full_m`; the matrices of others stay as they were (m).
    pub posed_m: f32,
}

/// Sets which characters are posed in the next steps.
///
/// @param detail null to pose all characters, which is the default.
///
/// # Safety
/// `detail` is null or can be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_set_detail(
    simulation: ThrongSimulation,
    detail: *const ThrongDetail,
) -> ThrongStatus {
    catch_fault(|| {
        // SAFETY: one record, or none where it is null; promised by the caller.
        let given = unsafe { read_slice("detail", detail, usize::from(!detail.is_null())) }?;
        let detail =
            |d: &ThrongDetail| Detail { eye: Vec2::new(d.eye_x, d.eye_z), full_m: d.full_m, posed_m: d.posed_m };
        simulation.with(|stage| Ok(stage.characters_mut()?.set_detail(given.first().map(detail))?))
    })
}

/// Copies the records of all characters, in the order of rows. There are none unless `ThrongCharactersConfig.instances`.
///
/// @param instances room for `capacity` records.
/// @param count number of records; those beyond `capacity` are left out.
///
/// # Safety
/// `instances` has this room, `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_instances(
    simulation: ThrongSimulation,
    instances: *mut ThrongInstance,
    capacity: usize,
    count: *mut usize,
) -> ThrongStatus {
    simulation.call(|stage| {
        let all = stage.characters_mut()?.instances().iter().map(|r| {
            let &PoseInstance { row_a, row_b, frac_blend: [frac, blend], variant, x, y, z, heading, .. } = r;
            ThrongInstance { row_a, row_b, frac, blend, variant, x, y, z, heading }
        });
        // SAFETY: promised by the caller.
        unsafe { copy_records(all, instances, capacity, count) }
    })
}

/// Writes the number of frame rows of a bundle.
///
/// # Safety
/// `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_bundle_num_rows(bundle: ThrongBundle, count: *mut usize) -> ThrongStatus {
    catch_fault(|| {
        let found = BUNDLES.get("bundle", bundle.handle)?.frames().len();
        // SAFETY: promised by the caller.
        unsafe { write_result("count", count, found) }
    })
}

/// Writes the poses of all frame rows, once for a bundle: the matrix from each joint to the character's own frame. To skin
/// a body, multiply such a matrix by the inverse of the joint's matrix at rest, which has no rotation.
///
/// @param matrices room for rows times `THRONG_NUM_JOINTS` matrices, without gaps.
/// @param size its length (bytes).
/// @param layout a `ThrongLayout`.
///
/// # Safety
/// `matrices` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_bundle_write_rows(
    bundle: ThrongBundle,
    matrices: *mut f32,
    size: usize,
    layout: u32,
) -> ThrongStatus {
    catch_fault(|| {
        let bundle = BUNDLES.get("bundle", bundle.handle)?;
        let layout = checked_layout(layout)?;
        check_pointer("matrices", matrices)?;
        let (rows, each) = (bundle.frames().len(), NUM_JOINTS * matrix_floats(layout));
        let why = || format!("`matrices` has {size} bytes, expected {} for {rows} rows", 4 * rows * each);
        ensure(size >= 4 * rows * each, || CallFault::new(ThrongStatus::TooSmall, why()))?;
        let (motion_set, ratios) = (&MotionSet::new(&bundle), &[0.0][..]);
        let mut pose = [Mat3x4::default(); NUM_JOINTS];
        for row in 0..rows {
            SampleJob { motion_set, frames: &[row as u32], ratios, matrices: &mut pose }.run()?;
            // SAFETY: ends within `size`, for which the caller promises room; every bit pattern is a float.
            let to = unsafe { std::slice::from_raw_parts_mut(matrices.add(row * each), each) };
            for (to, joint) in to.chunks_exact_mut(matrix_floats(layout)).zip(&pose) {
                write_matrix(layout, joint, to);
            }
        }
        Ok(())
    })
}
