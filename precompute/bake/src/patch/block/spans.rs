//! Runs of frames that belong to a set of units.

use std::collections::BTreeSet;
use throng_motion::clip::{FrameRange, runs_where};

/// Every set of `k` units that a run of frames belongs to, with its longest runs.
///
/// - `units_of`: the units each frame belongs to.
/// - returns the sets in order, ascending, with the runs in which every frame belongs to at least one of the set and
///   each of the set to at least one frame.
///
/// # Source
/// Lee, Choi and Lee 2006, section 4.
pub fn spans(units_of: &[Vec<u32>], k: usize) -> Vec<(Vec<u32>, Vec<FrameRange>)> {
    let mut sets: BTreeSet<Vec<u32>> = units_of.iter().flatten().map(|&u| vec![u]).collect();
    for _ in 1..k {
        sets = sets.iter().flat_map(|set| extended(units_of, set)).collect();
    }
    let spans = sets.into_iter().map(|set| (runs_of(units_of, &set), set));
    spans.filter(|(runs, _)| !runs.is_empty()).map(|(runs, set)| (set, runs)).collect()
}

/// A set with one more unit, for each that occurs in one of its runs or at the frame after.
///
/// No set is missed: its first run begins with a run of the set without its last-occurring unit.
fn extended(units_of: &[Vec<u32>], set: &[u32]) -> Vec<Vec<u32>> {
    let mut more = BTreeSet::new();
    for run in runs_of(units_of, set) {
        let reached = run.start..(run.end + 1).min(units_of.len());
        more.extend(units_of[reached].iter().flatten().copied().filter(|u| !set.contains(u)));
    }
    let with = |u: u32| {
        let mut out = [set, &[u]].concat();
        out.sort_unstable();
        out
    };
    more.into_iter().map(with).collect()
}

fn runs_of(units_of: &[Vec<u32>], set: &[u32]) -> Vec<FrameRange> {
    let mut found = runs_where(0..units_of.len(), |f| units_of[f].iter().any(|u| set.contains(u)));
    found.retain(|r| set.iter().all(|u| units_of[r.clone()].iter().any(|units| units.contains(u))));
    found
}

#[cfg(test)]
#[expect(clippy::single_range_in_vec_init, reason = "a list of one span is what is meant")]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_runs_of_one_unit_and_of_two_are_found() {
        let units_of = [vec![], vec![1], vec![1, 2], vec![2], vec![], vec![1], vec![3], vec![1]];
        assert_eq!(
            spans(&units_of, 1),
            [(vec![1], vec![1..3, 5..6, 7..8]), (vec![2], vec![2..4]), (vec![3], vec![6..7])]
        );
        assert_eq!(spans(&units_of, 2), [(vec![1, 2], vec![1..4]), (vec![1, 3], vec![5..8])]);
    }

    proptest! {
        #[test]
        fn no_set_is_missed(masks in prop::collection::vec(0u32..32, 0..30), k in 1usize..4) {
            let units_of: Vec<Vec<u32>> = masks.iter().map(|m| (0..5).filter(|u| m >> u & 1 == 1).collect()).collect();
            let mut naive = Vec::new();
            for set in (1u32..32).filter(|m| m.count_ones() as usize == k) {
                let set: Vec<u32> = (0..5).filter(|u| set >> u & 1 == 1).collect();
                let found = runs_of(&units_of, &set);
                if !found.is_empty() {
                    naive.push((set, found));
                }
            }
            naive.sort_by(|a, b| a.0.cmp(&b.0));
            prop_assert_eq!(spans(&units_of, k), naive);
        }
    }
}
