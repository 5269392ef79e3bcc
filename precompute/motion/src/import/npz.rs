//! Reads AMASS and other SMPL motion: `.npz` files of NumPy arrays; and what Kimodo generates, in `kimodo`.
//!
//! An SMPL file holds turns of the joints and the path of the pelvis, but no body: lengths are those of an adult. Its world has
//! Z up and is turned to Y up here, because the body at rest has Y up; some have Y up.

mod array;
mod kimodo;

use super::{FrameSink, MAX_JOINTS, SourceClip, archive, content_error};
use crate::error::{ImportError, Warnings, ensure};
use crate::raw::{RawJoint, SourceFormat};
use crate::smpl::{JOINTS, UPRIGHT};
use array::{NpyArray, NpzArrays};
use glam::{DQuat, DVec3, Vec3};
use std::path::Path;
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// Names of the frame rate.
const RATES: [&str; 4] = ["mocap_framerate", "mocap_frame_rate", "fps", "frame_rate"];
const HELP: &str = "Save the motion anew with `numpy.savez`: `poses`, `trans` and `mocap_framerate`";

/// Reads a clip from the bytes of an `.npz` file; `path` is for errors and the clip's name.
///
/// # Errors
/// [`ImportError::Content`] naming the array that is missing, damaged or of another shape.
pub fn parse(bytes: &[u8], path: &Path) -> Result<SourceClip, ImportError> {
    let fail = |message: String| content_error(path, message, HELP);
    let mut arrays = NpzArrays::open(bytes).map_err(fail)?;
    if arrays.has(kimodo::TURNS) {
        return kimodo::parse(arrays, bytes.len(), path);
    }
    let trans = arrays.get("trans").map_err(fail)?;
    let poses = poses(&mut arrays).map_err(fail)?;
    let frames = trans.rows(3).map_err(|e| fail(format!("`trans`: {e}")))?;
    let width = poses.iter().map(|p| p.shape[1]).fold(0, usize::saturating_add);
    if poses.iter().any(|p| p.shape.first() != Some(&frames)) || !(3 * NUM_JOINTS..=3 * MAX_JOINTS).contains(&width) {
        let message =
            format!("expected {frames} rows of {} numbers or more of poses, found {width} a row", 3 * NUM_JOINTS);
        return Err(fail(message));
    }
    ensure(frames != 0, || fail("it has no frames".into()))?;
    let (rate_hz, name) = rate(&mut arrays).map_err(fail)?;
    let turn = if has_y_up(&poses[0], frames) { DQuat::IDENTITY } else { UPRIGHT };
    let mut sink = FrameSink::new(joints(), FrameSink::budget(archive::counted_bytes(path, bytes.len())));
    for frame in 0..frames {
        let numbers: Vec<f64> = poses.iter().flat_map(|p| p.row(frame, p.shape[1])).take(3 * NUM_JOINTS).collect();
        let offset: Vec<f64> = trans.row(frame, 3).collect();
        if numbers.iter().chain(&offset).any(|v| !v.is_finite() || v.abs() > 1e6) {
            return Err(fail(format!("frame {frame}: expected numbers, found one that is none or too large")));
        }
        sink.begin_frame();
        for j in 0..NUM_JOINTS {
            sink.rotations[j] = DQuat::from_scaled_axis(DVec3::from_slice(&numbers[3 * j..3 * j + 3]));
        }
        sink.rotations[0] = turn * sink.rotations[0];
        sink.translations[0] = turn * DVec3::from_slice(&offset);
        ensure(sink.end_frame(), || fail("the file is too short for its frames".into()))?;
    }
    let findings = vec![
        format!("{rate_hz} frames a second: the file says so in `{name}`."),
        "SMPL motion has no lengths of its own: those of an adult are taken.".into(),
    ];
    let clip = sink.into_clip(path, SourceFormat::Npz, rate_hz);
    Ok(SourceClip { clip, declared_metres_per_unit: Some(1.0), findings, warnings: Warnings::default() })
}

/// `poses`, or the arrays into which newer files part it: tables of turns.
fn poses(arrays: &mut NpzArrays<'_>) -> Result<Vec<NpyArray>, String> {
    let parted = !arrays.has("poses") && arrays.has("pose_body");
    let mut of = |name: &str| -> Result<NpyArray, String> {
        let array = arrays.get(name)?;
        let shape = &array.shape;
        ensure(shape.len() == 2, || format!("`{name}`: expected a table, found the shape {shape:?}"))?;
        Ok(array)
    };
    if !parted {
        return Ok(vec![of("poses")?]);
    }
    let (root, body) = (of("root_orient")?, of("pose_body")?);
    let width = root.shape[1];
    ensure(width == 3, || format!("`root_orient`: expected a table of 3 columns, found {width}"))?;
    Ok(vec![root, body])
}

/// True where the body stands along Y rather than Z over the frames; `poses` begins with the turn of the pelvis.
fn has_y_up(poses: &NpyArray, frames: usize) -> bool {
    let up = |f: usize| {
        let turn: Vec<f64> = poses.row(f, poses.shape[1]).take(3).collect();
        let axis = DVec3::from_slice(&turn);
        if axis.is_finite() { DQuat::from_scaled_axis(axis) * DVec3::Y } else { DVec3::Z }
    };
    let mean: DVec3 = (0..frames).map(up).sum();
    mean.y > 0.7 * frames as f64
}

fn rate(arrays: &mut NpzArrays<'_>) -> Result<(f64, &'static str), String> {
    rate_if_any(arrays)?.ok_or_else(|| format!("no frame rate is there: expected `{}`", RATES.join("` or `")))
}

/// The rate that a file names (Hz), and the name of the array.
fn rate_if_any(arrays: &mut NpzArrays<'_>) -> Result<Option<(f64, &'static str)>, String> {
    let Some(name) = RATES.into_iter().find(|n| arrays.has(n)) else { return Ok(None) };
    let rate_hz = arrays.get(name)?.row(0, 1).next().unwrap_or(0.0);
    ensure((0.1..=1e5).contains(&rate_hz), || format!("`{name}`: expected 0.1 to 100000 Hz, found {rate_hz}"))?;
    Ok(Some((rate_hz, name)))
}

/// The body: a T-pose of the default skeleton, parents first in the order of the files.
fn joints() -> Vec<RawJoint> {
    let skeleton = Skeleton::default();
    let index = |j: Joint| JOINTS.iter().position(|(_, role)| *role == j);
    let joint = |(name, role): &(&str, Joint)| {
        let offset = if role.parent().is_some() { skeleton.offsets[role.index()] } else { Vec3::ZERO };
        RawJoint::new((*name).into(), role.parent().and_then(index), offset, false)
    };
    JOINTS.iter().map(joint).collect()
}
