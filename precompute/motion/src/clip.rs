//! Motion on the database skeleton, editable: what every stage between retargeting and writing works on.

use glam::{Quat, Vec3};
use throng_base::maths;
use throng_core::format::{ClassSpan, MADE_TAG, MotionClass};
use throng_core::{Contacts, Joint, NUM_JOINTS, Planar, Skeleton, hits::KIND_NAMES};

/// A run of frames `[start, end)`.
pub type FrameRange = std::ops::Range<usize>;

/// Frames that may not be used as motion, and the reason.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Exclusion {
    /// The frames.
    pub range: FrameRange,
    /// Reason, as reports print it.
    pub reason: ExclusionReason,
}

/// Reason why frames are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum ExclusionReason {
    /// The calibration pose at a clip's end.
    TPose,
    /// Nothing moves at a clip's end.
    Still,
    /// A range named in the sidecar file.
    Sidecar,
    /// A fault of the recording.
    Glitch,
}

impl std::fmt::Display for ExclusionReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(["T-pose", "still", "sidecar", "glitch"][*self as usize])
    }
}

/// A name on a run of frames.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ClipTag {
    /// The name, as configs and reports use it.
    pub name: String,
    /// The frames.
    pub range: FrameRange,
}

/// A moment at which a joint could deliver a blow (Lee and Lee 2004, section 6).
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ClipHit {
    /// The frame.
    pub frame: usize,
    /// Kind of blow.
    pub kind: HitKind,
    /// The joint that strikes.
    pub joint: Joint,
    /// Effective hitting point, relative to the frame's planar root (m).
    pub position: Vec3,
    /// Direction of its motion, relative to the planar root (unit).
    pub direction: Vec3,
    /// Speed (m/s).
    pub speed_mps: f32,
    /// Speed over that of the fastest hit of its kind in the set (> 0, <= 1).
    pub force: f32,
}

/// Kind of blow.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum HitKind {
    /// With a fist, found by its speed.
    Punch,
    /// With a foot, found by its speed.
    Kick,
    /// Given by a sidecar file, with its name.
    Tag(String),
}

impl HitKind {
    /// The name, as configs, bundles and reports write it.
    pub fn name(&self) -> &str {
        match self {
            Self::Punch => KIND_NAMES[0],
            Self::Kick => KIND_NAMES[1],
            Self::Tag(name) => name,
        }
    }
}

/// A clip on the database skeleton: metres, Y up, right-handed.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Clip {
    /// Unique in its set: the file as seen from the folder that was given, without extension, with folders in front where
    /// needed; a mirrored copy ends in `~mirror`.
    pub name: String,
    /// Path of the motion's file, as the user wrote it.
    pub source: String,
    /// True for a copy with left and right exchanged.
    pub mirrored: bool,
    /// Frames a second (Hz, > 0).
    pub rate_hz: f64,
    /// Hips position in the world (m, num_frames).
    #[serde(with = "crate::pod")]
    pub root_positions: Vec<Vec3>,
    /// Joint rotations relative to the parent; the hips' relative to the world.
    /// (num_frames * NUM_JOINTS), row-major by frame. Unit; neighbouring frames have a positive dot product. Of a clip
    /// whose poses are elsewhere, the hips' alone (num_frames).
    #[serde(with = "crate::pod")]
    pub rotations: Vec<Quat>,
    /// Foot contacts; empty before the annotate stage (num_frames).
    pub contacts: Vec<Contacts>,
    /// Frames left out; from the annotate stage on sorted, not overlapping.
    pub excluded: Vec<Exclusion>,
    /// Named runs of frames.
    pub tags: Vec<ClipTag>,
    /// Effective hits, ascending by frame; empty before the annotate stage.
    pub hits: Vec<ClipHit>,
    /// Class of motion of every frame: spans in order, without gaps; empty before the annotate stage.
    pub classes: Vec<ClassSpan>,
    /// Height of the support under the character: the lowest thing that a planted part touches, between contacts that of the
    /// last one. Empty where all of it is the ground at y = 0 (m, num_frames or 0).
    #[serde(with = "crate::pod")]
    pub support: Vec<f32>,
}

impl Clip {
    /// Motion alone, not annotated: no source, contacts, exclusions, tags, hits or supports.
    ///
    /// - `rate_hz`: frames a second (Hz, > 0).
    /// - `root_positions`, `rotations`: as in the fields.
    pub fn new(name: impl Into<String>, rate_hz: f64, root_positions: Vec<Vec3>, rotations: Vec<Quat>) -> Self {
        Self { name: name.into(), rate_hz, root_positions, rotations, ..Self::default() }
    }

    /// Number of frames.
    pub fn num_frames(&self) -> usize {
        self.root_positions.len()
    }

    /// Drops the poses: root, contacts, hits and names remain.
    pub fn forget_poses(&mut self) {
        if self.has_poses() {
            self.rotations = self.rotations.iter().step_by(NUM_JOINTS).copied().collect();
        }
    }

    /// False where the poses were dropped, as another process has them.
    pub fn has_poses(&self) -> bool {
        self.rotations.len() == self.num_frames() * NUM_JOINTS
    }

    /// Rotation of the hips at one frame.
    pub fn hips_rotation(&self, frame: usize) -> Quat {
        self.rotations[frame * if self.has_poses() { NUM_JOINTS } else { 1 }]
    }

    /// Local rotations of one frame (NUM_JOINTS).
    ///
    /// # Panics
    /// Where the poses were forgotten.
    pub fn frame_rotations(&self, frame: usize) -> &[Quat] {
        assert!(self.has_poses(), "{}: its poses are elsewhere", self.name);
        &self.rotations[frame * NUM_JOINTS..(frame + 1) * NUM_JOINTS]
    }

    /// True if a build has made the clip, and nobody has captured it.
    pub fn is_made(&self) -> bool {
        self.tags.iter().any(|t| t.name == MADE_TAG)
    }

    /// Planar part of the root at one frame; the heading is in (-pi, pi].
    pub fn planar(&self, frame: usize) -> Planar {
        Planar::split(self.root_positions[frame], self.hips_rotation(frame)).0
    }

    /// World positions of all joints at one frame (m).
    pub fn joint_positions(&self, skeleton: &Skeleton, frame: usize) -> [Vec3; NUM_JOINTS] {
        self.joint_transforms(skeleton, frame).map(|t| t.0)
    }

    /// World position and rotation of all joints at one frame.
    pub fn joint_transforms(&self, skeleton: &Skeleton, frame: usize) -> [(Vec3, Quat); NUM_JOINTS] {
        let local = self.frame_rotations(frame);
        joint_transforms(skeleton, self.root_positions[frame], |j| local[j])
    }

    /// Span of the class of a frame; `None` before the annotate stage.
    pub fn span_at(&self, frame: usize) -> Option<&ClassSpan> {
        self.classes.get(self.classes.partition_point(|s| s.frames.end as usize <= frame))
    }

    /// Class of motion of a frame; `None` before the annotate stage.
    pub fn class_at(&self, frame: usize) -> Option<&MotionClass> {
        self.span_at(frame).map(|s| &s.class)
    }

    /// True where the frame may be used.
    pub fn is_usable(&self, frame: usize) -> bool {
        !self.excluded.iter().any(|e| e.range.contains(&frame))
    }

    /// The longest runs of usable frames, in order.
    pub fn usable_ranges(&self) -> Vec<FrameRange> {
        let mut usable = vec![true; self.num_frames()];
        for Exclusion { range, .. } in &self.excluded {
            let end = range.end.min(usable.len());
            usable[range.start.min(end)..end].fill(false);
        }
        runs_where(0..self.num_frames(), |f| usable[f])
    }
}

/// Position and rotation of all joints of a pose.
///
/// - `root_position`: of the hips (m).
/// - `local`: rotation of a joint relative to its parent, by index; the hips' in the frame of `root_position`.
pub fn joint_transforms(
    skeleton: &Skeleton,
    root_position: Vec3,
    local: impl Fn(usize) -> Quat,
) -> [(Vec3, Quat); NUM_JOINTS] {
    let mut out = [(root_position, local(0)); NUM_JOINTS];
    for j in &Joint::ALL[1..] {
        let (p, r) = out[j.parent().map_or(0, Joint::index)];
        out[j.index()] = (p + r * skeleton.offsets[j.index()], maths::compose(r, local(j.index())));
    }
    out
}

/// The longest runs of frames within `range` for which `holds` is true, in order.
pub fn runs_where(range: FrameRange, holds: impl Fn(usize) -> bool) -> Vec<FrameRange> {
    let mut out = Vec::new();
    let mut start = None;
    for f in range.start..=range.end {
        match (f < range.end && holds(f), start) {
            (true, None) => start = Some(f),
            (false, Some(s)) => {
                out.push(s..f);
                start = None;
            }
            _ => {}
        }
    }
    out
}

/// All clips of a build on one skeleton.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ClipSet {
    /// Proportions shared by all clips.
    pub skeleton: Skeleton,
    /// The clips, in the order of the build's input (sorted by path), each mirrored copy after its original.
    pub clips: Vec<Clip>,
}

/// A frame of a [`ClipSet`]: frames of all clips are numbered in one sequence, excluded ones included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct FrameId(pub u32);

impl ClipSet {
    /// First [`FrameId`] of every clip, and past the last one the total (clips.len() + 1).
    pub fn frame_starts(&self) -> Vec<u32> {
        let mut starts = vec![0];
        for c in &self.clips {
            starts.push(starts[starts.len() - 1] + c.num_frames() as u32);
        }
        starts
    }

    /// Kinds of all hits: punch, kick, then those of tags by name.
    pub fn hit_kinds(&self) -> Vec<HitKind> {
        let of_tags = self.clips.iter().flat_map(|c| &c.hits).map(|h| &h.kind).filter(|k| matches!(k, HitKind::Tag(_)));
        let of_tags: std::collections::BTreeSet<_> = of_tags.cloned().collect();
        [HitKind::Punch, HitKind::Kick].into_iter().chain(of_tags).collect()
    }

    /// Number of frames of all clips, excluded ones included.
    pub fn num_frames(&self) -> usize {
        self.clips.iter().map(Clip::num_frames).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_the_longest_ones() {
        let on = [true, true, false, true, false, false, true, true];
        assert_eq!(runs_where(0..8, |f| on[f]), [0..2, 3..4, 6..8]);
        assert_eq!(runs_where(1..7, |f| on[f]), [1..2, 3..4, 6..7]);
        assert!(runs_where(0..8, |_| false).is_empty() && runs_where(3..3, |_| true).is_empty());
    }
}
