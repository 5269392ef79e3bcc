//! A skeleton as a tree of lengths: parents and children, lengths of segments in the motion, positions of joints.

use super::{super::units::sample_frames, names::Label};
use crate::raw::{RawClip, children_of};
use glam::Vec3;
use throng_base::maths::quantile;

/// Most frames that are examined.
const MAX_FRAMES: usize = 48;

/// A skeleton, and the positions of its joints in some frames of the motion; lengths in units of the file.
///
/// Lengths are those of the motion, not of the rest pose: files whose rest offsets follow some other rule are
/// bodies in their motion alone.
pub struct SkeletonTree<'a> {
    pub clip: &'a RawClip,
    /// Meaning of each joint's name.
    pub labels: Vec<Label>,
    pub children: Vec<Vec<usize>>,
    /// Distance of each joint to its parent, the median over the frames; 0 for roots.
    pub lengths: Vec<f32>,
    /// Length of the longest path along joints below each one.
    pub heights: Vec<f32>,
    /// Joints in an order in which each one and those below it are consecutive: the first index, and the one after the last.
    rows: Vec<[usize; 2]>,
    /// True where neither the joint nor any below it may play a role, by name.
    pub pruned: Vec<bool>,
    /// World positions of all joints, frame by frame.
    pub frames: Vec<Vec<Vec3>>,
}

impl<'a> SkeletonTree<'a> {
    pub fn new(clip: &'a RawClip) -> Self {
        let n = clip.joints.len();
        let sampled: Vec<usize> = sample_frames(clip.num_frames, MAX_FRAMES).collect();
        let children = children_of(clip.joints.iter().map(|j| j.parent));
        let length = |j: usize| {
            let all = sampled.iter().map(|&f| clip.translations[f * n + j].length());
            if clip.joints[j].parent.is_none() { 0.0 } else { quantile(all, [1, 2]).unwrap_or_default() }
        };
        let lengths: Vec<f32> = (0..n).map(length).collect();
        let labels: Vec<Label> = clip.joints.iter().map(|j| Label::from_name(&j.name)).collect();
        let rows = rows(&children, clip);
        let (mut heights, mut pruned) = (vec![0f32; n], vec![true; n]);
        for j in (0..n).rev() {
            let is_end = clip.joints[j].is_end;
            // The end of a chain is treated as its joint is; joints below one that plays no role may play one.
            let parent_is_out = clip.joints[j].parent.is_some_and(|p| labels[p].left_out);
            pruned[j] &= if is_end { parent_is_out } else { labels[j].left_out };
            if let (false, Some(p)) = (pruned[j], clip.joints[j].parent) {
                if !is_end {
                    pruned[p] = false;
                }
                heights[p] = heights[p].max(heights[j] + lengths[j]);
            }
        }
        let frames = sampled.iter().map(|&f| clip.world(f).into_iter().map(|(p, _)| p).collect()).collect();
        Self { clip, labels, children, lengths, heights, rows, pruned, frames }
    }

    /// Joints below one that may play roles, or lead to such.
    pub fn role_children(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        self.children[joint].iter().copied().filter(|&c| !self.pruned[c])
    }

    /// True for a joint that is not the end of a chain.
    pub fn turns(&self, joint: usize) -> bool {
        !self.clip.joints[joint].is_end
    }

    /// True for a joint that may play a role: it turns, and its name does not speak against it.
    pub fn is_candidate(&self, joint: usize) -> bool {
        self.turns(joint) && !self.labels[joint].left_out
    }

    /// A joint and its ancestors, nearest first.
    pub fn path_up(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(joint), |&j| self.clip.joints[j].parent)
    }

    /// True where `above` is `joint` or one of its ancestors.
    pub fn is_above(&self, above: usize, joint: usize) -> bool {
        (self.rows[above][0]..self.rows[above][1]).contains(&self.rows[joint][0])
    }

    /// The nearest joint that is above both.
    pub fn common_ancestor(&self, a: usize, b: usize) -> Option<usize> {
        self.path_up(b).find(|&j| self.is_above(j, a))
    }

    pub fn name(&self, joint: usize) -> &str {
        &self.clip.joints[joint].name
    }

    /// Mean over the frames of a number that some frames lack; `None` where all do.
    pub fn mean(&self, of: impl Fn(&[Vec3]) -> Option<f32>) -> Option<f32> {
        let all: Vec<f32> = self.frames.iter().filter_map(|f| of(f)).filter(|v| v.is_finite()).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f32>() / all.len() as f32)
    }
}

fn rows(children: &[Vec<usize>], clip: &RawClip) -> Vec<[usize; 2]> {
    let mut sizes = vec![1; children.len()];
    for (j, p) in clip.joints.iter().enumerate().rev().filter_map(|(j, joint)| Some((j, joint.parent?))) {
        sizes[p] += sizes[j];
    }
    let mut rows = vec![[0; 2]; children.len()];
    let mut free = 0;
    for (j, joint) in clip.joints.iter().enumerate() {
        if joint.parent.is_none() {
            rows[j] = [free, free + sizes[j]];
            free += sizes[j];
        }
        let mut next = rows[j][0] + 1;
        for &c in &children[j] {
            rows[c] = [next, next + sizes[c]];
            next += sizes[c];
        }
    }
    rows
}
