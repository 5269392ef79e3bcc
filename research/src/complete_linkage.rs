//! Pose groups by complete linkage from the full distance matrix: slow and large. `throng-bake` compares its groups with these
//! in its tests.

use super::Features;
use rayon::prelude::*;
use std::collections::BTreeMap;
use throng_motion::clip::{ClipSet, FrameId};

/// The groups of complete linkage, in order of their first frame, each with its frames ascending.
///
/// - `limit`: distance below which groups are merged.
///
/// Takes four bytes for every pair of frames with equal contacts.
pub fn complete_linkage(clips: &ClipSet, features: &Features, limit: f32) -> Vec<Vec<FrameId>> {
    // Frames share a group only if their contacts agree, as well as those of their neighbours.
    let mut classes = BTreeMap::<[u8; 3], Vec<u32>>::new();
    for (clip, start) in clips.clips.iter().zip(clips.frame_starts()) {
        for run in clip.usable_ranges() {
            for f in run.clone() {
                let neighbours = [f.max(run.start + 1) - 1, f, (f + 1).min(run.end - 1)];
                classes.entry(neighbours.map(|f| clip.contacts[f].0)).or_default().push(start + f as u32);
            }
        }
    }
    let merge = |frames: &Vec<u32>| LinkageMatrix::new(features, frames).merge_below(limit);
    let mut groups: Vec<Vec<FrameId>> = classes.values().flat_map(merge).collect();
    groups.sort();
    groups
}

/// Distances of groups.
struct LinkageMatrix {
    groups: Vec<Vec<FrameId>>,
    /// Distances of group i to groups 0 to i - 1.
    rows: Vec<Vec<f32>>,
}

impl LinkageMatrix {
    fn new(features: &Features, frames: &[u32]) -> Self {
        let distance = |a: u32, b: u32| features.distance(FrameId(a), FrameId(b));
        let row = |i: usize| frames[..i].iter().map(|&b| distance(frames[i], b)).collect();
        Self {
            groups: frames.iter().map(|&f| vec![FrameId(f)]).collect(),
            rows: (0..frames.len()).into_par_iter().map(row).collect(),
        }
    }

    fn distance_mut(&mut self, a: usize, b: usize) -> &mut f32 {
        &mut self.rows[a.max(b)][a.min(b)]
    }

    /// Merges the two nearest groups while they are nearer than `limit`.
    fn merge_below(mut self, limit: f32) -> Vec<Vec<FrameId>> {
        let mut nearest: Vec<Option<(f32, usize)>> = (0..self.groups.len()).map(|i| self.nearest(i)).collect();
        loop {
            let best = (0..nearest.len()).filter_map(|i| nearest[i].map(|(d, j)| (d, i, j)));
            let Some((distance, a, b)) = best.min_by(|x, y| x.0.total_cmp(&y.0)) else { break };
            if distance >= limit {
                break;
            }
            self.merge(a, b);
            for i in 0..nearest.len() {
                if i == a || i == b || nearest[i].is_some_and(|(_, j)| j == a || j == b) {
                    nearest[i] = self.nearest(i);
                }
            }
        }
        self.groups.retain(|g| !g.is_empty());
        self.groups.iter_mut().for_each(|g| g.sort());
        self.groups
    }

    /// Nearest other group; `None` for a merged group.
    fn nearest(&mut self, i: usize) -> Option<(f32, usize)> {
        if self.groups[i].is_empty() {
            return None;
        }
        let others: Vec<usize> = (0..self.groups.len()).filter(|&j| j != i && !self.groups[j].is_empty()).collect();
        others.into_iter().map(|j| (*self.distance_mut(i, j), j)).min_by(|x, y| x.0.total_cmp(&y.0))
    }

    /// Merges `b` into `a`.
    fn merge(&mut self, a: usize, b: usize) {
        let moved = std::mem::take(&mut self.groups[b]);
        self.groups[a].extend(moved);
        for j in (0..self.groups.len()).filter(|&j| j != a && j != b) {
            let farther = (*self.distance_mut(a, j)).max(*self.distance_mut(b, j));
            *self.distance_mut(a, j) = farther;
        }
    }
}
