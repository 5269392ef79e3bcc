//! Motion as a file holds it: the source's own joints, in metres, Y up, before any retargeting.

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::hash::{DefaultHasher, Hasher};
use std::path::PathBuf;
use throng_base::maths;

/// One joint of a source skeleton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RawJoint {
    /// Name as written in the file. End sites are joints too and are named `PARENT_end`.
    pub name: String,
    /// Index of the parent, always smaller than the joint's own; `None` for roots.
    pub parent: Option<usize>,
    /// Rest offset from the parent, in the parent's rest axes (m).
    pub offset: Vec3,
    /// Rest rotation relative to the parent (identity for BVH; for ASF the segments' rest axes are folded in such a way that
    /// rest rotations are the identity too).
    pub rest_rotation: Quat,
    /// True for the end of a chain, which has no rotation of its own.
    pub is_end: bool,
}

impl RawJoint {
    /// A joint whose rest rotation is the identity.
    pub fn new(name: String, parent: Option<usize>, offset: Vec3, is_end: bool) -> Self {
        Self { name, parent, offset, rest_rotation: Quat::IDENTITY, is_end }
    }
}

/// The children of every joint or node, given its parent.
pub(crate) fn children_of(parents: impl ExactSizeIterator<Item = Option<usize>>) -> Vec<Vec<usize>> {
    let mut out = vec![Vec::new(); parents.len()];
    parents.enumerate().for_each(|(child, parent)| parent.into_iter().for_each(|p: usize| out[p].push(child)));
    out
}

/// The formats read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SourceFormat {
    /// Biovision hierarchy.
    Bvh,
    /// Acclaim skeleton and motion.
    AsfAmc,
    /// SMPL motion in NumPy arrays.
    Npz,
    /// glTF 2.0, as text or binary.
    Gltf,
    /// Autodesk FBX.
    Fbx,
}

/// A clip as read: source joints, metres, Y up, right-handed, facing not yet normalised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RawClip {
    /// File stem; `/` and the name within the file follow where it holds several clips.
    pub name: String,
    /// The file the motion was read from; a clip of several has a path as if the file were a folder.
    pub path: PathBuf,
    /// Its format.
    pub format: SourceFormat,
    /// Joints, parents first.
    pub joints: Vec<RawJoint>,
    /// Frames a second (Hz, > 0).
    pub rate_hz: f64,
    /// Number of frames.
    pub num_frames: usize,
    /// Local translations relative to the parent (a joint without position channels repeats its offset).
    /// (m, num_frames * joints.len())
    #[serde(with = "crate::pod")]
    pub translations: Vec<Vec3>,
    /// Local rotations relative to the parent (num_frames * joints.len()).
    #[serde(with = "crate::pod")]
    pub rotations: Vec<Quat>,
}

impl RawClip {
    /// A hash of the motion, whatever the names of its file and its joints.
    pub fn motion_hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        hasher.write_usize(self.num_frames);
        hasher.write(bytemuck::cast_slice(&self.rotations));
        hasher.write(bytemuck::cast_slice(&self.translations));
        hasher.finish()
    }

    /// True where the numbers of both motions are the same.
    pub fn has_motion_of(&self, other: &Self) -> bool {
        self.rate_hz == other.rate_hz
            && self.num_frames == other.num_frames
            && self.rotations == other.rotations
            && self.translations == other.translations
    }

    /// Model-to-world positions and rotations of every joint at one frame (joints.len()).
    pub fn world(&self, frame: usize) -> Vec<(Vec3, Quat)> {
        let n = self.joints.len();
        let mut out: Vec<(Vec3, Quat)> = Vec::with_capacity(n);
        for (j, joint) in self.joints.iter().enumerate() {
            let (t, r) = (self.translations[frame * n + j], self.rotations[frame * n + j]);
            out.push(match joint.parent {
                None => (t, r),
                Some(p) => (out[p].0 + out[p].1 * t, maths::compose(out[p].1, r)),
            });
        }
        out
    }

    /// Model-to-world position and rotation of one joint at one frame, as in [`RawClip::world`].
    pub fn world_of(&self, joint: usize, frame: usize) -> (Vec3, Quat) {
        let at = |j: usize| frame * self.joints.len() + j;
        let local = |j: usize| (self.translations[at(j)], self.rotations[at(j)]);
        let path: Vec<usize> = std::iter::successors(Some(joint), |&j| self.joints[j].parent).collect();
        let steps = path.into_iter().rev().map(local);
        steps.reduce(|above, (t, r)| (above.0 + above.1 * t, maths::compose(above.1, r))).unwrap_or_default()
    }
}
