//! Hits that people mark in sidecar files.

use super::track::{Poses, tip, velocity};
use super::{MIN_SPEED, hit_at};
use crate::clip::{Clip, ClipHit, FrameRange, HitKind};
use crate::{annotate::sidecar::SidecarPlace, error::Result};
use throng_core::{Joint, Skeleton};

/// A hit that a sidecar marks, in the clip's frames.
#[derive(Clone, Debug, PartialEq)]
pub struct HitMark {
    /// Kind of blow.
    pub kind: HitKind,
    /// The joint that strikes.
    pub joint: Joint,
    /// Range in which the joint's fastest moment is searched for. Not empty, inside the clip.
    pub range: FrameRange,
    /// Place in a file at which the hit is marked.
    pub place: SidecarPlace,
}

impl HitMark {
    /// The hit at the fastest moment of the range.
    ///
    /// # Errors
    /// Errors where that frame is left out, or the joint does not move.
    pub(super) fn hit(&self, clip: &Clip, poses: &Poses, skeleton: &Skeleton) -> Result<ClipHit> {
        let joint = self.joint.name();
        let refuse = |what: String| Err(self.place.fault(what));
        let tip = |f: usize| tip(&poses[f], skeleton, self.joint);
        let moving = |f: usize| (f, velocity(&tip, poses.len(), f, clip.rate_hz));
        let usable = self.range.clone().filter(|&f| clip.is_usable(f)).map(moving);
        let Some((frame, moving)) = usable.max_by(|a, b| a.1.length().total_cmp(&b.1.length()).then(b.0.cmp(&a.0)))
        else {
            return refuse(format!(
                "{:.2} s into clip `{}` nothing is used: the frames are left out. Move the hit or keep the frames.",
                self.range.start as f64 / clip.rate_hz,
                clip.name
            ));
        };
        match hit_at(clip, frame, self.kind.clone(), self.joint, (tip(frame), moving)) {
            Some(hit) => Ok(hit),
            None => refuse(format!(
                "{joint} of clip `{}` moves at {:.3} m/s {:.2} s into it, too slow for a direction to strike in \
                 ({MIN_SPEED} m/s). Move the hit or name another joint.",
                clip.name,
                moving.length(),
                frame as f64 / clip.rate_hz
            )),
        }
    }
}
