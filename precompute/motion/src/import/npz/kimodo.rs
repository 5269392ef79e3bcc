//! Reads motion that Kimodo generates: turns of all joints, and their places, of the bodies SOMA and SMPL-X.
//!
//! Arrays, joints and their order as in the project's page on output formats; see docs/own-motion.md.

use super::array::{NpyArray, NpzArrays};
use super::{HELP, archive, rate_if_any};
use crate::error::{ImportError, Warnings, ensure};
use crate::import::source::{FrameSink, SourceClip, content_error};
use crate::raw::{RawJoint, SourceFormat};
use crate::smpl;
use glam::{DMat3, DQuat, DVec3};
use std::path::Path;

/// Turns of joints against their parents, as matrices.
pub const TURNS: &str = "local_rot_mats";
/// Places of joints in the world (m).
const PLACES: &str = "posed_joints";
/// Rate of the motion that its models make (Hz).
const RATE_HZ: f64 = 30.0;
/// Largest deviation of a matrix from a rotation.
const MOST_SKEWED: f64 = 0.01;

/// Name, parent and indices of a joint.
type SomaJoint = (&'static str, Option<usize>, [Option<usize>; 2]);

/// Joints of SOMA that are read: name, parent among them, and index in bodies of 77 and of 30 joints. Fingers, eyes and jaw are
/// left out.
const SOMA: [SomaJoint; 26] = [
    ("Hips", None, [Some(0), Some(0)]),
    ("Spine1", Some(0), [Some(1), Some(1)]),
    ("Spine2", Some(1), [Some(2), Some(2)]),
    ("Chest", Some(2), [Some(3), Some(3)]),
    ("Neck1", Some(3), [Some(4), Some(4)]),
    ("Neck2", Some(4), [Some(5), Some(5)]),
    ("Head", Some(5), [Some(6), Some(6)]),
    ("HeadEnd", Some(6), [Some(7), None]),
    ("LeftShoulder", Some(3), [Some(11), Some(10)]),
    ("LeftArm", Some(8), [Some(12), Some(11)]),
    ("LeftForeArm", Some(9), [Some(13), Some(12)]),
    ("LeftHand", Some(10), [Some(14), Some(13)]),
    ("RightShoulder", Some(3), [Some(39), Some(16)]),
    ("RightArm", Some(12), [Some(40), Some(17)]),
    ("RightForeArm", Some(13), [Some(41), Some(18)]),
    ("RightHand", Some(14), [Some(42), Some(19)]),
    ("LeftLeg", Some(0), [Some(67), Some(22)]),
    ("LeftShin", Some(16), [Some(68), Some(23)]),
    ("LeftFoot", Some(17), [Some(69), Some(24)]),
    ("LeftToeBase", Some(18), [Some(70), Some(25)]),
    ("LeftToeEnd", Some(19), [Some(71), None]),
    ("RightLeg", Some(0), [Some(72), Some(26)]),
    ("RightShin", Some(21), [Some(73), Some(27)]),
    ("RightFoot", Some(22), [Some(74), Some(28)]),
    ("RightToeBase", Some(23), [Some(75), Some(29)]),
    ("RightToeEnd", Some(24), [Some(76), None]),
];

/// Reads a clip; its world has Y up, and its lengths are in metres.
///
/// # Errors
/// [`ImportError::Content`] naming the array that is missing, damaged or of another shape.
pub fn parse(mut arrays: NpzArrays<'_>, num_bytes: usize, path: &Path) -> Result<SourceClip, ImportError> {
    let fail = |message: String| content_error(path, message, HELP);
    let (turns, places) = (arrays.get(TURNS).map_err(fail)?, arrays.get(PLACES).map_err(fail)?);
    let [frames, width, 3, 3] = turns.shape[..] else {
        return Err(fail(format!("`{TURNS}`: expected the shape (frames, joints, 3, 3), found {:?}", turns.shape)));
    };
    if places.shape != [frames, width, 3] || frames == 0 {
        return Err(fail(format!("`{PLACES}`: expected {frames} frames of {width} joints, found {:?}", places.shape)));
    }
    let body = body_of(width).map_err(|what| content_error(path, what, "Generate it for SOMA or SMPL-X"))?;
    let turn = |f: usize, j: usize| rotation(&turns, f * width + j).ok_or((f, j));
    let place = |f: usize, j: usize| vector(&places, f * width + j).ok_or((f, j));
    let wrong = |(f, j)| fail(format!("frame {f}, joint {j}: expected a rotation and a place, found none"));
    // Lengths are not named: places in the first frame say them.
    let mut world: Vec<(DVec3, DQuat)> = Vec::with_capacity(body.len());
    let mut joints: Vec<RawJoint> = Vec::with_capacity(body.len());
    for joint in &body {
        let (at, turned) = (place(0, joint.index).map_err(wrong)?, turn(0, joint.index).map_err(wrong)?);
        let above = joint.parent.map(|p| world[p]);
        let offset = above.map_or(DVec3::ZERO, |(p, r)| r.inverse() * (at - p));
        world.push((at, above.map_or(turned, |(_, r)| r * turned)));
        joints.push(RawJoint::new(joint.name.into(), joint.parent, offset.as_vec3(), joint.name.ends_with("End")));
    }
    let given = rate_if_any(&mut arrays).map_err(fail)?;
    let (rate_hz, finding) = match given {
        Some((rate_hz, name)) => (rate_hz, format!("{rate_hz} frames a second: the file says so in `{name}`.")),
        None => (RATE_HZ, format!("{RATE_HZ} frames a second, as Kimodo's models make: the file names no rate.")),
    };
    let mut sink = FrameSink::new(joints, FrameSink::budget(archive::counted_bytes(path, num_bytes)));
    for f in 0..frames {
        sink.begin_frame();
        sink.translations[0] = place(f, body[0].index).map_err(wrong)?;
        for (j, joint) in body.iter().enumerate() {
            sink.rotations[j] = turn(f, joint.index).map_err(wrong)?;
        }
        ensure(sink.end_frame(), || fail("the file is too short for its frames".into()))?;
    }
    let clip = sink.into_clip(path, SourceFormat::Npz, rate_hz);
    let warnings = Warnings::default();
    Ok(SourceClip { clip, declared_metres_per_unit: Some(1.0), findings: vec![finding], warnings })
}

/// A joint that is read.
struct GeneratedJoint {
    name: &'static str,
    parent: Option<usize>,
    /// Index in the arrays.
    index: usize,
}

/// The joints of a body of so many.
fn body_of(width: usize) -> Result<Vec<GeneratedJoint>, String> {
    let soma = |of: usize| {
        let there = SOMA.iter().filter(|(_, _, index)| index[of].is_some());
        let place = |above: &str| SOMA.iter().filter(|s| s.2[of].is_some()).position(|s| s.0 == above);
        let joint = |&(name, parent, index): &(&'static str, Option<usize>, [Option<usize>; 2])| GeneratedJoint {
            name,
            parent: parent.and_then(|p| place(SOMA[p].0)),
            index: index[of].unwrap_or(0),
        };
        there.map(joint).collect()
    };
    match width {
        77 => Ok(soma(0)),
        30 => Ok(soma(1)),
        22 => {
            let parent = |k: usize| smpl::JOINTS[k].1.parent();
            let place = |k: usize| smpl::JOINTS.iter().position(|(_, role)| Some(*role) == parent(k));
            let joint = |k: usize| GeneratedJoint { name: smpl::JOINTS[k].0, parent: place(k), index: k };
            Ok((0..width).map(joint).collect())
        }
        34 => Err("it is motion of a robot (34 joints, as of Unitree's G1), not of a person".into()),
        _ => Err(format!("`{TURNS}`: expected 77 or 30 joints (SOMA) or 22 (SMPL-X), found {width}")),
    }
}

fn vector(array: &NpyArray, row: usize) -> Option<DVec3> {
    let numbers: Vec<f64> = array.row(row, 3).collect();
    let v = DVec3::from_slice(numbers.get(..3)?);
    (v.is_finite() && v.abs().max_element() < 1e6).then_some(v)
}

/// A rotation that is written by rows.
fn rotation(array: &NpyArray, row: usize) -> Option<DQuat> {
    let numbers: Vec<f64> = array.row(row, 9).collect();
    let m = DMat3::from_cols_slice(numbers.get(..9)?).transpose();
    let skewed = (m * m.transpose() - DMat3::IDENTITY).to_cols_array().iter().any(|v| v.abs() > MOST_SKEWED);
    let is_rotation = m.is_finite() && !skewed && m.determinant() > 0.0;
    is_rotation.then(|| DQuat::from_mat3(&m).normalize())
}
