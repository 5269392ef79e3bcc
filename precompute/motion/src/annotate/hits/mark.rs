//! Hits that people mark in sidecar files.

use super::track::{Poses, striking_points, velocities};
use super::{MIN_SPEED, hit_at};
use crate::annotate::sidecar::Place;
use crate::clip::{Clip, FrameRange, Hit, HitKind};
use crate::error::BuildError;
use throng_core::{Joint, Skeleton};

/// A hit that a sidecar marks, in the clip's frames.
#[derive(Clone, Debug, PartialEq)]
pub struct HitMark {
    /// What kind of blow.
    pub kind: HitKind,
    /// The joint that strikes.
    pub joint: Joint,
    /// Where the joint's fastest moment is looked for. Not empty, inside the clip.
    pub range: FrameRange,
    /// Where it is marked.
    pub place: Place,
}

impl HitMark {
    /// The hit at the fastest moment of the range.
    ///
    /// # Errors
    /// Where that frame is left out or the joint does not move.
    pub(super) fn hit(&self, clip: &Clip, poses: &Poses, skeleton: &Skeleton) -> Result<Hit, BuildError> {
        let joint = self.joint.name();
        let refuse = |what: String| Err(self.place.fault(what));
        let tips = striking_points(poses, skeleton, self.joint);
        let moving = velocities(&tips, clip.rate_hz);
        let usable = self.range.clone().filter(|&f| clip.is_usable(f));
        let Some(frame) = usable.max_by(|&a, &b| moving[a].length().total_cmp(&moving[b].length()).then(b.cmp(&a)))
        else {
            return refuse(format!(
                "{:.2} s into clip `{}` nothing is used: the frames are left out. Move the hit or keep the frames.",
                self.range.start as f64 / clip.rate_hz,
                clip.name
            ));
        };
        match hit_at(clip, frame, self.kind.clone(), self.joint, (tips[frame], moving[frame])) {
            Some(hit) => Ok(hit),
            None => refuse(format!(
                "{joint} of clip `{}` moves at {:.3} m/s {:.2} s into it, too slow for a direction to strike in \
                 ({MIN_SPEED} m/s). Move the hit or name another joint.",
                clip.name,
                moving[frame].length(),
                frame as f64 / clip.rate_hz
            )),
        }
    }
}
