//! Level of detail: who is far away leaves a record of 32 bytes, from which a vertex shader makes the pose.

use crate::fault::{Fault, ThrongStatus, call, check_pointer, copy_records};
use crate::layout::{floats, layout_of, write};
use crate::stage::{ThrongSimulation, with};
use crate::tables::{BUNDLES, ThrongBundle};
use glam::Vec2;
use throng_runtime::characters::{Detail, Instance, MotionSet, SampleJob};
use throng_runtime::{Mat3x4, NUM_JOINTS};

/// What a GPU needs to pose a character from the frame rows of its bundle (32 bytes; `throng_bundle_write_rows`).
///
/// The pose is `mix(mix(row_a, row_a + 1, frac), mix(row_b, row_b + 1, frac), blend)`: what is played, and what a
/// transition left and fades out. It stands at (x, y, z) and is turned by the heading, in Throng's axes: that is
/// (-x, y, z) and -heading in Unity, (100 z, -100 x, 100 y) and a yaw of -heading in Unreal.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrongInstance {
    /// Frame row; the one after it is of the same clip, or `frac` is 0.
    pub row_a: u32,
    /// Frame row of what fades out; `row_a` where nothing does.
    pub row_b: u32,
    /// How far to the next rows (65535 is 1).
    pub frac: u16,
    /// The weight of `row_b` (65535 is 1).
    pub blend: u16,
    /// Number of the character's place, for looks (< capacity).
    pub variant: u32,
    /// Along X, to the left of heading 0 (m).
    pub x: f32,
    /// Height of the ground there (m).
    pub y: f32,
    /// Along Z (m).
    pub z: f32,
    /// About +Y from +Z (rad).
    pub heading: f32,
}

const _: () = assert!(size_of::<ThrongInstance>() == 32 && size_of::<Instance>() == 32);

/// Where characters are looked at from, and who is near enough for what. They go where they would go without it.
///
/// Eight characters whose rows are neighbours have one level: that of the nearest.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrongDetail {
    /// The eye, along X (m).
    pub eye_x: f32,
    /// The eye, along Z (m).
    pub eye_z: f32,
    /// Feet stay in place up to this distance; -1 for nobody (m).
    pub full_m: f32,
    /// Poses are computed up to this distance, at least `full_m`; the matrices of others stay as they were (m).
    pub posed_m: f32,
}

/// Says who is posed in the next steps.
///
/// @param detail null for everybody, as it is at first.
///
/// # Safety
/// `detail` is null or can be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_set_detail(
    simulation: ThrongSimulation,
    detail: *const ThrongDetail,
) -> ThrongStatus {
    call(|| {
        let detail = match detail.is_null() {
            true => None,
            false => {
                check_pointer("detail", detail)?;
                // SAFETY: neither null nor out of line; promised by the caller.
                let d = unsafe { detail.read() };
                Some(Detail { eye: Vec2::new(d.eye_x, d.eye_z), full_m: d.full_m, posed_m: d.posed_m })
            }
        };
        with(simulation.handle, |stage, _| stage.cast()?.set_detail(detail).map_err(Fault::from))
    })
}

/// Copies the records of everybody, in the order of rows. None are there unless `ThrongCharactersConfig.instances`.
///
/// @param instances room for `capacity` records.
/// @param count how many there are; more than `capacity` are left out.
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
    call(|| {
        with(simulation.handle, |stage, _| {
            let all = stage.cast()?.instances().iter().map(|r| ThrongInstance {
                row_a: r.row_a,
                row_b: r.row_b,
                frac: r.frac_blend[0],
                blend: r.frac_blend[1],
                variant: r.variant,
                x: r.x,
                y: r.y,
                z: r.z,
                heading: r.heading,
            });
            // SAFETY: promised by the caller.
            unsafe { copy_records(all, instances, capacity, count) }
        })
    })
}

/// How many frame rows a bundle has.
///
/// # Safety
/// `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_bundle_num_rows(bundle: ThrongBundle, count: *mut usize) -> ThrongStatus {
    call(|| {
        let found = BUNDLES.get("bundle", bundle.handle)?.frames().len();
        // SAFETY: promised by the caller.
        unsafe { crate::fault::write("count", count, found) }
    })
}

/// Writes the poses of all frame rows, once for a bundle: the matrix from each joint to the character's own frame. A body
/// is skinned by such a matrix after the inverse of the joint's one at rest, which does not turn.
///
/// @param matrices rows times `THRONG_NUM_JOINTS` matrices, without gaps.
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
    call(|| {
        let bundle = BUNDLES.get("bundle", bundle.handle)?;
        let layout = layout_of(layout)?;
        check_pointer("matrices", matrices)?;
        let (rows, each) = (bundle.frames().len(), NUM_JOINTS * floats(layout));
        if size < 4 * rows * each {
            let why = format!("`matrices` has {size} bytes, expected {} for {rows} rows", 4 * rows * each);
            return Err(Fault::new(ThrongStatus::TooSmall, why));
        }
        let (motion_set, ratios) = (&MotionSet::new(&bundle), &[0.0][..]);
        let mut pose = [Mat3x4::default(); NUM_JOINTS];
        for row in 0..rows {
            SampleJob { motion_set, frames: &[row as u32], ratios, matrices: &mut pose }.run()?;
            // SAFETY: ends within `size`, for which the caller promises room; every bit pattern is a float.
            let to = unsafe { std::slice::from_raw_parts_mut(matrices.add(row * each), each) };
            for (to, joint) in to.chunks_exact_mut(floats(layout)).zip(&pose) {
                write(layout, joint, to);
            }
        }
        Ok(())
    })
}
