//! Motion back to files: clips as raw clips, takes of many characters, and the writers of glTF, USD, BVH, NPZ and CSV.

pub mod bvh;
mod csv;
pub(crate) mod glb;
mod instances;
mod npz;
pub(crate) mod scratch;
pub(crate) mod take;
mod usd;

pub(crate) use csv::quoted;
pub use csv::{positions_csv, take_csv};
pub use glb::Glb;
pub use instances::{CrowdInstance, InstanceRecording};
pub use npz::{write_amass, write_npz};
pub use take::{ActorPose, Take, TakeActor, TakeWriter};
pub use usd::usda;

use crate::raw::{RawClip, RawJoint, SourceFormat};
use crate::{clip::Clip, error::Result, files::write_atomically};
use glam::{Quat, Vec3};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use throng_core::{Joint, Skeleton};

/// Joints with the names of their roles, and the ends of head and toes `NAME_end`; rest rotations are the identity.
fn joints(skeleton: &Skeleton) -> Vec<RawJoint> {
    let tips = [Joint::Head, Joint::LeftToe, Joint::RightToe];
    let joint = |j: Joint| {
        let offset = skeleton.offsets[j.index()];
        RawJoint::new(j.name().into(), j.parent().map(Joint::index), offset, false)
    };
    let tip =
        |(tip, offset): (Joint, Vec3)| RawJoint::new(format!("{}_end", tip.name()), Some(tip.index()), offset, true);
    Joint::ALL.into_iter().map(joint).chain(tips.into_iter().zip(skeleton.tips).map(tip)).collect()
}

/// A clip as a raw clip: joints have the names of their roles, the ends of head and toes `NAME_end`.
///
/// The hips' rest offset is their standing height; rest rotations are the identity, so the rest pose is the T-pose.
pub fn to_raw(clip: &Clip, skeleton: &Skeleton) -> RawClip {
    let (joints, num_frames) = (joints(skeleton), clip.num_frames());
    let mut translations = Vec::with_capacity(num_frames * joints.len());
    let mut rotations = Vec::with_capacity(num_frames * joints.len());
    for frame in 0..num_frames {
        translations.push(clip.root_positions[frame]);
        translations.extend(joints[1..].iter().map(|j| j.offset));
        rotations.extend_from_slice(clip.frame_rotations(frame));
        rotations.extend([Quat::IDENTITY; 3]);
    }
    let (name, path, format) = (clip.name.clone(), clip.source.clone().into(), SourceFormat::Bvh);
    RawClip { name, path, format, joints, rate_hz: clip.rate_hz, num_frames, translations, rotations }
}

/// Writes a file for each actor who is ever present: `NAME-7.bvh` of number 7, or `NAME.bvh` where there is one.
///
/// - `write`: writes the actor of a number.
/// - returns the files.
///
/// # Errors
/// Errors of [`write_atomically`].
pub fn write_each_actor(
    take: &Take,
    out: &Path,
    write: impl Fn(usize, &mut dyn Write) -> io::Result<()>,
) -> Result<Vec<PathBuf>> {
    let there = (0..take.actors().len()).filter(|&a| !take.actors()[a].present_frames.is_empty());
    let file_of = |a: usize| match take.actors() {
        [_] => out.to_path_buf(),
        actors => {
            let stem = out.file_stem().unwrap_or_default().to_string_lossy();
            let extension = out.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
            out.with_file_name(format!("{stem}-{}{extension}", actors[a].number))
        }
    };
    there.map(|a| write_atomically(&file_of(a), |w| write(a, w)).map(|()| file_of(a))).collect()
}
