//! Symmetry of square tiles under a quarter turn: links found for one edge serve all four.

use std::f32::consts::TAU;
use throng_core::patch::{LinkRecord, Placement};

/// Spots from which links must be searched: the first of each orbit of quarter turns.
pub(super) fn first_turns(turned: &[u32], spots: impl Iterator<Item = u32>) -> Vec<u32> {
    let first = |spot: u32| {
        let mut other = turned[spot as usize];
        while other > spot {
            other = turned[other as usize];
        }
        other == spot
    };
    spots.filter(|&s| first(s)).collect()
}

/// All images under quarter turns of a link that begins in the first spot of its orbit, itself included.
pub(super) fn all_turns(turned: &[u32], link: LinkRecord) -> impl Iterator<Item = LinkRecord> {
    let quarter = Placement::new(0.0, 0.0, 0.0, TAU / 4.0);
    let next = move |l: &LinkRecord| {
        let (from, to) = (turned[l.from as usize], turned[l.to as usize]);
        let [start, end] = [l.start, l.end].map(|p| quarter.compose(p));
        (from != link.from).then_some(LinkRecord { from, to, start, end, ..*l })
    };
    std::iter::successors(Some(link), next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn a_link_is_turned_through_all_of_its_set_once() {
        let turned = [1, 2, 3, 0, 4];
        assert_eq!(first_turns(&turned, 0..5), [0, 4]);
        let link = LinkRecord { from: 0, to: 4, start: Placement::new(0.0, 0.0, 1.0, 0.0), ..LinkRecord::zeroed() };
        let all: Vec<_> = all_turns(&turned, link).collect();
        assert_eq!(all.iter().map(|l| (l.from, l.to)).collect::<Vec<_>>(), [(0, 4), (1, 4), (2, 4), (3, 4)]);
        assert!((all[1].start.x - 1.0).abs() < 1e-6 && (all[2].start.z + 1.0).abs() < 1e-6);
        assert!((all[3].start.heading - 3.0 * TAU / 4.0).abs() < 1e-5);
    }
}
