//! Building blocks: sets of units on which motion was captured, with that motion (Lee, Choi and Lee 2006, section 4).

mod embed;
mod shape;

use super::{PatchInputs, PatchReport, RawPatch, is_ground, track::PatchTrack};
use crate::environment::PlacedUnit;
use rayon::prelude::*;
use shape::BlockShape;
use std::collections::BTreeSet;
use throng_core::patch::{KIND_BLOCK, LinkRecord, Placement};
use throng_motion::{FrameRange, Progress, StopRequested, runs_where};

/// Frames of a clip that were captured within one block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BlockSegment {
    /// Clip.
    pub clip: usize,
    /// Frames.
    pub range: FrameRange,
    /// Placement of the clip's world in the block's frame.
    pub to_block: Placement,
}

/// A block with the motion found on its copies.
struct BuildingBlock {
    shape: BlockShape,
    segments: Vec<BlockSegment>,
}

/// Finds the blocks of all clips and embeds the motion in them.
///
/// - returns blocks of one unit, then of two and so on as `config.block_units` lists them, each in the order of the
///   motion, named by their units; blocks without any link are left out.
///
/// # Errors
/// [`StopRequested`] if the progress is stopped.
pub fn build(given: &PatchInputs, progress: &dyn Progress) -> Result<Vec<(RawPatch, PatchReport)>, StopRequested> {
    let mut blocks = Vec::new();
    given.config.block_units.iter().for_each(|&k| find_blocks(given, k, &mut blocks));
    progress.begin("patch", blocks.len() as u64, "blocks");
    let root_heights: Vec<f32> = given.clips.clips.iter().flat_map(|c| &c.root_positions).map(|p| p.y).collect();
    let patch = |b: &BuildingBlock| {
        progress.check()?;
        let patch = embed::embed(given, &b.segments, &root_heights);
        progress.advance(1);
        Ok(patch)
    };
    let made: Vec<_> = blocks.par_iter().map(patch).collect::<Result<_, StopRequested>>()?;
    let mut out = Vec::new();
    for (block, (cells, links)) in blocks.iter().zip(made).filter(|(_, (_, links))| !links.is_empty()) {
        let placed = block.shape.units.iter().map(|p| (given.units.units[p.unit].name.clone(), p.placement));
        let units: Vec<(String, Placement)> = placed.collect();
        let name = units.iter().map(|u| u.0.as_str()).collect::<Vec<_>>().join("+");
        let report = PatchReport {
            name: name.clone(),
            segments: block.segments.len(),
            frames: block.segments.iter().map(|s| s.range.len()).sum(),
            cells: cells.len(),
            links: links.len(),
            ..PatchReport::default()
        };
        let whole = whole_segment_links(given.tracks, &block.segments);
        let bounds = given.bounds.extent_of_links(given.tracks, &whole);
        out.push((RawPatch { name, units, kind: KIND_BLOCK, cells, links, bounds, ..RawPatch::default() }, report));
    }
    progress.end();
    Ok(out)
}

/// Adds the blocks of `k` units, or their motion to existing ones.
fn find_blocks(given: &PatchInputs, k: usize, blocks: &mut Vec<BuildingBlock>) {
    let PatchInputs { tracks, units, .. } = *given;
    for (clip, setting) in given.settings.iter().enumerate() {
        let Some(setting) = setting else { continue };
        // Tiles hold the motion over ground panels; a block with one would tie the other units to its place.
        let counts = |u: u32| !is_ground(&units.units[setting.environment.units[u as usize].unit]);
        let track = &tracks[clip];
        let of_frame = |f: usize| match track.run_end[f] {
            0 => Vec::new(),
            _ => setting.units_of[f].iter().copied().filter(|&u| counts(u)).collect(),
        };
        let units_of: Vec<Vec<u32>> = (0..setting.units_of.len()).map(of_frame).collect();
        for (set, ranges) in spans(&units_of, k) {
            let placed: Vec<PlacedUnit> = set.iter().map(|&u| setting.environment.units[u as usize].clone()).collect();
            let long = ranges.into_iter().filter(|r| r.len() > given.config.min_link_frames);
            let mut segments = long.map(|range| BlockSegment { clip, range, to_block: Placement::IDENTITY }).peekable();
            if segments.peek().is_none() {
                continue;
            }
            let fits = |(b, block): (usize, &BuildingBlock)| Some((block.shape.fit(&placed, units)?, b));
            let (to_block, block) = blocks.iter().enumerate().find_map(fits).unwrap_or_else(|| {
                let (shape, to_block) = BlockShape::new(&placed);
                blocks.push(BuildingBlock { shape, segments: Vec::new() });
                (to_block, blocks.len() - 1)
            });
            blocks[block].segments.extend(segments.map(|s| BlockSegment { to_block, ..s }));
        }
    }
}

/// Links that play whole segments, for the bounds of bodies in them.
fn whole_segment_links(tracks: &[PatchTrack], segments: &[BlockSegment]) -> Vec<LinkRecord> {
    let links = segments.iter().flat_map(|s| {
        let step = usize::from(u16::MAX);
        let cuts = (s.range.start..s.range.end - 1).step_by(step);
        cuts.map(move |a| embed::captured_link(&tracks[s.clip], s, a, (a + step).min(s.range.end - 1)))
    });
    links.collect()
}

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
