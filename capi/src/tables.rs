//! Bundles: opening, reading, freeing.

use crate::fault::{
    CallFault, CallResult, ThrongStatus, catch_fault, check_pointer, copy_text, read_slice, read_text, write_result,
};
use crate::handles::HandleTable;
use std::ffi::c_char;
use throng_runtime::{Bundle, Joint, NUM_JOINTS, format::AlignedBytes};

/// Number of joints of every skeleton; parents come before their children.
pub const THRONG_NUM_JOINTS: usize = 22;
const _: () = assert!(THRONG_NUM_JOINTS == NUM_JOINTS);

/// A bundle of tables. Simulations made from it keep working when it is freed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThrongBundle {
    /// Number of the handle; zero is none.
    pub handle: u64,
}

/// A joint of a skeleton in rest pose, where every joint's rotation is the identity in Throng's axes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThrongJoint {
    /// Number of the parent joint; -1 for the first.
    pub parent: i32,
    /// Offset from the parent (m; X left, Y up, Z forward).
    pub offset: [f32; 3],
}

/// All open bundles.
pub static BUNDLES: HandleTable<Bundle> = HandleTable::new();

/// Opens a bundle file. Later changes to the file do not matter.
///
/// # Safety
/// `path` ends with a zero, `bundle` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_bundle_open(path: *const c_char, bundle: *mut ThrongBundle) -> ThrongStatus {
    catch_fault(|| {
        check_pointer("bundle", bundle)?;
        // SAFETY: promised by the caller.
        let path = unsafe { read_text("path", path) }?;
        let opened = Bundle::open(path).map_err(|e| CallFault::from(e).with_path(path))?;
        // SAFETY: promised by the caller.
        unsafe { register_bundle(opened, bundle) }
    })
}

/// Opens a bundle that lies in memory; it is copied.
///
/// # Safety
/// `bytes` points to `size` bytes, `bundle` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_bundle_from_memory(
    bytes: *const u8,
    size: usize,
    bundle: *mut ThrongBundle,
) -> ThrongStatus {
    catch_fault(|| {
        check_pointer("bundle", bundle)?;
        // SAFETY: promised by the caller.
        let bytes = unsafe { read_slice("bytes", bytes, size) }?;
        // SAFETY: promised by the caller.
        unsafe { register_bundle(Bundle::from_bytes(AlignedBytes::from_slice(bytes))?, bundle) }
    })
}

/// # Safety
/// `to` can be written.
unsafe fn register_bundle(bundle: Bundle, to: *mut ThrongBundle) -> CallResult {
    // SAFETY: promised by the caller.
    unsafe { write_result("bundle", to, ThrongBundle { handle: BUNDLES.add(bundle) }) }
}

/// Frees a bundle.
#[unsafe(no_mangle)]
pub extern "C" fn throng_bundle_free(bundle: ThrongBundle) -> ThrongStatus {
    catch_fault(|| BUNDLES.remove("bundle", bundle.handle))
}

/// Writes the number of a behaviour's policy; the error message lists the existing names.
///
/// # Safety
/// `behaviour` ends with a zero, `policy` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_bundle_policy(
    bundle: ThrongBundle,
    behaviour: *const c_char,
    policy: *mut u32,
) -> ThrongStatus {
    catch_fault(|| {
        // SAFETY: promised by the caller.
        let behaviour = unsafe { read_text("behaviour", behaviour) }?;
        let number = BUNDLES.get("bundle", bundle.handle)?.find_policy(behaviour)?;
        // SAFETY: promised by the caller.
        unsafe { write_result("policy", policy, number as u32) }
    })
}

/// Writes the skeleton of a bundle.
///
/// @param joints room for `THRONG_NUM_JOINTS` joints.
///
/// # Safety
/// `joints` has that room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_bundle_skeleton(bundle: ThrongBundle, joints: *mut ThrongJoint) -> ThrongStatus {
    catch_fault(|| {
        let bundle = BUNDLES.get("bundle", bundle.handle)?;
        check_pointer("joints", joints)?;
        for joint in Joint::ALL {
            let parent = joint.parent().map_or(-1, |p| p.index() as i32);
            let record = ThrongJoint { parent, offset: bundle.skeleton().offsets[joint.index()].to_array() };
            // SAFETY: below `THRONG_NUM_JOINTS`, for which the caller promises room.
            unsafe { joints.add(joint.index()).write(record) };
        }
        Ok(())
    })
}

/// Copies the name of a joint, with a zero at its end.
///
/// @return the length of the name, 0 where there is no such joint (bytes).
///
/// # Safety
/// `buffer` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_joint_name(joint: u32, buffer: *mut c_char, size: usize) -> usize {
    let name = Joint::ALL.get(joint as usize).map_or("", |joint| joint.name());
    // SAFETY: promised by the caller.
    unsafe { copy_text(name, buffer, size) }
}
