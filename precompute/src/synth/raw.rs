//! A clip as a file would hold it: named joints with offsets, ends of chains included.

use crate::clip::Clip;
use crate::raw::{RawClip, RawJoint, SourceFormat};
use glam::Quat;
use std::path::PathBuf;
use throng_runtime::{Joint, Skeleton};

/// The file's joints: those of the database skeleton, then the ends of its chains.
fn raw_joints(skeleton: &Skeleton) -> Vec<RawJoint> {
    let own = Joint::ALL.into_iter().map(|j| RawJoint {
        name: j.name().to_owned(),
        parent: j.parent().map(Joint::index),
        offset: skeleton.offsets[j.index()],
        rest_rotation: Quat::IDENTITY,
        is_end: false,
    });
    let hand = |j: Joint| skeleton.offsets[j.index()].normalize_or_zero() * 0.18;
    let ends = [
        (Joint::Head, skeleton.tips[0]),
        (Joint::LeftHand, hand(Joint::LeftHand)),
        (Joint::RightHand, hand(Joint::RightHand)),
        (Joint::LeftToe, skeleton.tips[1]),
        (Joint::RightToe, skeleton.tips[2]),
    ];
    let ends = ends.into_iter().map(|(j, offset)| RawJoint {
        name: format!("{}_end", j.name()),
        parent: Some(j.index()),
        offset,
        rest_rotation: Quat::IDENTITY,
        is_end: true,
    });
    own.chain(ends).collect()
}

/// A clip of the database skeleton as a [`RawClip`], to be written as a file that other tools open.
///
/// Joints are called as [`Joint::name`] calls them; ends of chains are `head_end`, `left_hand_end` and so on.
pub fn to_raw(clip: &Clip, skeleton: &Skeleton) -> RawClip {
    let joints = raw_joints(skeleton);
    let (mut translations, mut rotations) = (Vec::new(), Vec::new());
    for frame in 0..clip.num_frames() {
        let local = clip.frame_rotations(frame);
        for (j, joint) in joints.iter().enumerate() {
            translations.push(if j == 0 { clip.root_positions[frame] } else { joint.offset });
            rotations.push(local.get(j).copied().unwrap_or(Quat::IDENTITY));
        }
    }
    RawClip {
        name: clip.name.clone(),
        path: PathBuf::from(format!("{}.bvh", clip.name)),
        format: SourceFormat::Bvh,
        joints,
        rate_hz: clip.rate_hz,
        num_frames: clip.num_frames(),
        translations,
        rotations,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{SynthConfig, walk};

    #[test]
    fn raw_joints_stand_where_the_clip_has_them() {
        let set = walk(&SynthConfig { minutes: 0.2, ..SynthConfig::default() }).unwrap();
        let raw = to_raw(&set.clips[0], &set.skeleton);
        for frame in (0..raw.num_frames).step_by(50) {
            let world = raw.world(frame);
            for (j, p) in set.clips[0].joint_positions(&set.skeleton, frame).into_iter().enumerate() {
                assert!((world[j].0 - p).length() < 1e-5);
            }
        }
        assert!(raw.joints.iter().enumerate().all(|(i, j)| j.parent.is_none_or(|p| p < i)));
    }
}
