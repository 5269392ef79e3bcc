//! Least edited motions between spots.

use std::collections::BTreeMap;
use throng_core::Planar;

/// A sub-sequence of a clip from one spot to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LinkCandidate {
    /// Clip.
    pub clip: usize,
    /// Its first frame.
    pub start: usize,
    /// Its last frame.
    pub end: usize,
    /// Gap at its end: x, z and heading in the tile's frame.
    pub missing: Planar,
    /// Amount of editing: 0 for none, 1 for the most allowed.
    pub cost: f32,
}

/// Best candidates from one spot to each other spot, for each tag.
pub(super) struct BestCandidates {
    variety: usize,
    min_apart: usize,
    kept: BTreeMap<(u32, u16), Vec<LinkCandidate>>,
}

impl BestCandidates {
    /// - `variety`: candidates kept for each end and tag.
    /// - `min_apart`: of candidates that begin nearer to each other in one clip, the least edited is kept (frames).
    pub fn new(variety: usize, min_apart: usize) -> Self {
        Self { variety, min_apart, kept: BTreeMap::new() }
    }

    /// Takes a candidate if it is among the best and then passes a test.
    pub fn offer(&mut self, to: u32, tag: u16, candidate: LinkCandidate, passes: impl FnOnce() -> bool) {
        let kept = self.kept.entry((to, tag)).or_default();
        let close = |c: &LinkCandidate| c.clip == candidate.clip && c.start.abs_diff(candidate.start) < self.min_apart;
        let rank = kept.partition_point(|c| c.cost <= candidate.cost);
        if rank == self.variety || kept[..rank].iter().any(close) || !passes() {
            return;
        }
        kept.retain(|c| !close(c));
        kept.insert(rank, candidate);
        kept.truncate(self.variety);
    }

    /// All kept candidates, with their ends and tags, in order.
    pub fn into_sorted(self) -> impl Iterator<Item = (u32, u16, LinkCandidate)> {
        self.kept.into_iter().flat_map(|((to, tag), kept)| kept.into_iter().map(move |c| (to, tag, c)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(start: usize, cost: f32) -> LinkCandidate {
        LinkCandidate { clip: 0, start, end: start + 50, missing: Planar::IDENTITY, cost }
    }

    #[test]
    fn the_least_edited_are_kept_and_of_neighbours_only_the_best() {
        let mut best = BestCandidates::new(2, 20);
        for (start, cost) in [(0, 0.9), (5, 0.5), (100, 0.7), (108, 0.8), (200, 0.6), (300, 0.1)] {
            best.offer(7, 0, candidate(start, cost), || start != 300);
        }
        let kept: Vec<_> = best.into_sorted().map(|(to, _, c)| (to, c.start)).collect();
        assert_eq!(kept, [(7, 5), (7, 200)]);
    }
}
