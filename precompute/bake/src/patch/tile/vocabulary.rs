//! Pose groups in which characters enter, leave and rest.

use super::{TileOutline, TileSource, edge_height};
use crate::{cluster::PoseGroups, patch::TileConfig};
use glam::Vec2;
use std::collections::{BTreeMap, BTreeSet};
use throng_base::thresholds::WALKING_MPS;

/// Largest difference of equal support heights at an edge (m).
pub(super) const LEVEL_M: f32 = 0.05;

/// A pose at an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EdgePose {
    /// Pose group.
    pub group: u32,
    /// Height of the support above the middle of the edge (m).
    pub level: f32,
}

/// Poses at edges and at rest.
pub(super) struct TileVocabulary {
    /// For each edge, the poses in which it is entered.
    pub edge: Vec<Vec<EdgePose>>,
    /// Pose groups of rest.
    pub rest: Vec<u32>,
}

impl TileVocabulary {
    /// Poses of level ground: the most frequent ones of walking, at every edge, and of standing.
    ///
    /// Groups are counted by the strides and stops that pass through them, not by frames: a link needs a pass.
    ///
    /// - `times`: multiple of the configured number of groups.
    pub fn from_ground(source: &TileSource, num_edges: usize, config: &TileConfig, times: usize) -> Self {
        let (mut walking, mut standing) = (BTreeMap::<u32, usize>::new(), BTreeMap::<u32, usize>::new());
        for &c in &source.clips {
            let track = &source.tracks[c];
            let mut before = PoseGroups::NO_GROUP;
            for f in 1..track.places.len() {
                let speed = (track.travelled[f] - track.travelled[f - 1]) * source.rate_hz;
                let group = track.groups[f];
                if speed > WALKING_MPS && group != before && group != PoseGroups::NO_GROUP {
                    *walking.entry(group).or_default() += 1;
                }
                before = group;
            }
            for stop in &track.standing {
                let usable = stop.clone().filter(|&f| source.run_end(c, f) > 0);
                let passed: BTreeSet<u32> = usable.map(|f| track.groups[f]).collect();
                passed.into_iter().for_each(|group| *standing.entry(group).or_default() += 1);
            }
        }
        let words = most_common_poses(walking, times * config.edge_groups);
        let words: Vec<EdgePose> = words.into_iter().map(|group| EdgePose { group, level: 0.0 }).collect();
        Self { edge: vec![words; num_edges], rest: most_common_poses(standing, times * config.rest_groups) }
    }

    /// Poses in which captured copies of a rising tile were crossed: for each edge the most frequent ones of entering
    /// it that also occur in leaving the opposite one.
    pub fn from_rising(source: &TileSource, region: &TileOutline, config: &TileConfig) -> Self {
        let edges = (0..2).map(|edge| {
            let [entered, left] = [edge, edge ^ 1].map(|e| crossings(source, region, e, e == edge));
            let both = entered.into_iter().filter_map(|(word, n)| Some((word, n.min(*left.get(&word)?))));
            let found = most_common_poses(both.collect(), config.edge_groups);
            let word = |(group, level)| EdgePose { group, level: level as f32 * LEVEL_M };
            found.into_iter().map(word).collect()
        });
        Self { edge: edges.collect(), rest: Vec::new() }
    }
}

/// Number of crossings of an edge of the captured copies, by pose group and level.
///
/// - `inward`: true to count entries, false for exits.
fn crossings(source: &TileSource, region: &TileOutline, edge: usize, inward: bool) -> BTreeMap<(u32, i32), usize> {
    let (mut counts, height) = (BTreeMap::new(), edge_height(region.edges, edge));
    for (c, copy) in &source.copies {
        let track = &source.tracks[*c];
        let inset = |f: usize| {
            let p = copy.planar().inverse_transform_point(Vec2::new(track.places[f].x, track.places[f].z));
            if region.is_left(p, region.size / 2.0) { f32::NAN } else { region.inset(edge, p) }
        };
        let mut passed = BTreeSet::new();
        for f in 1..track.places.len() {
            let (before, now) = (inset(f - 1), inset(f));
            // Frames near the crossing may be moved onto the edge too.
            let near = now.abs() < (now - before).abs().max(0.05) && (now > before) == inward && now != before;
            if near && track.groups[f] != PoseGroups::NO_GROUP {
                let level = ((track.support[f] - copy.y - height) / LEVEL_M).round() as i32;
                passed.insert((track.groups[f], level));
            } else {
                std::mem::take(&mut passed).into_iter().for_each(|word| *counts.entry(word).or_default() += 1);
            }
        }
    }
    counts
}

/// The `n` with the highest counts, the first on a tie; sorted by number.
fn most_common_poses<T: Copy + Ord>(counts: BTreeMap<T, usize>, n: usize) -> Vec<T> {
    let mut all: Vec<(T, usize)> = counts.into_iter().collect();
    all.sort_by_key(|&(item, count)| (std::cmp::Reverse(count), item));
    let mut found: Vec<T> = all.into_iter().take(n).map(|(item, _)| item).collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::most_common_poses;

    #[test]
    fn the_commonest_are_chosen_and_the_first_of_equal_ones() {
        let counts = [(1, 2), (2, 5), (3, 2), (4, 9)].into_iter().collect();
        assert_eq!(most_common_poses(counts, 3), [1, 2, 4]);
    }
}
