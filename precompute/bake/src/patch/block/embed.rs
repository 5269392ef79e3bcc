//! Cells and links of a block (Lee, Choi and Lee 2006, section 4).

use super::BlockSegment;
use crate::patch::{PatchConfig, PatchInputs, inner_cell};
use crate::{cluster::PoseGroups, patch::track::PatchTrack};
use std::collections::{BTreeMap, BTreeSet};
use throng_core::patch::{CellRecord, LinkRecord, NONE, Placement};
use throng_core::planar::wrap_angle;

/// Index of a cell: x, height of the support, z, heading, pose group.
type BlockCellKey = (i32, i32, i32, i32, u32);

/// Sum of the placements in a cell, for their mean.
#[derive(Clone, Copy, Default)]
struct PlacementSum {
    n: f64,
    place: [f64; 3],
    /// Sum of unit vectors: sine and cosine.
    heading: [f64; 2],
}

/// A sub-sequence from one cell to another.
#[derive(Clone, Copy)]
struct CellLink {
    from: u32,
    to: u32,
    tag: u16,
    /// Distance of its ends from the means of their cells, in cells.
    off: f32,
    segment: u32,
    start: u32,
    end: u32,
}

/// Cells of all frames of the segments, and links for their sub-sequences.
///
/// - `heights`: height of the hips over the clip's ground, by frame row (m).
/// - returns cells with links, and the links by the cell they begin in.
pub fn embed(given: &PatchInputs, segments: &[BlockSegment], heights: &[f32]) -> (Vec<CellRecord>, Vec<LinkRecord>) {
    let PatchInputs { tracks, config, .. } = *given;
    let mut keys = BTreeMap::<BlockCellKey, PlacementSum>::new();
    let each = |s: &BlockSegment| s.range.clone();
    for s in segments {
        for f in each(s) {
            if let Some(key) = cell_key(&tracks[s.clip], s, f, config) {
                keys.entry(key).or_default().add(hips_position(&tracks[s.clip], s, f, heights));
            }
        }
    }
    let number: BTreeMap<BlockCellKey, u32> = keys.keys().copied().zip(0..).collect();
    let means: Vec<Placement> = keys.values().map(PlacementSum::mean).collect();
    let mut paths = Vec::new();
    for (i, s) in segments.iter().enumerate() {
        let track = &tracks[s.clip];
        let cell = |f: usize| cell_key(track, s, f, config).map(|k| number[&k]);
        let cells: Vec<Option<u32>> = each(s).map(cell).collect();
        let off = |f: usize, c: u32| distance(hips_position(track, s, f, heights), means[c as usize], config);
        let offs: Vec<f32> = each(s).zip(&cells).map(|(f, c)| c.map_or(0.0, |c| off(f, c))).collect();
        for (a, from) in cells.iter().enumerate() {
            let Some(from) = *from else { continue };
            for b in a + config.min_link_frames..(a + config.max_link_frames).min(cells.len()) {
                let Some(to) = cells[b] else { continue };
                let (start, end) = ((s.range.start + a) as u32, (s.range.start + b) as u32);
                let tag = track.tag_of(&(start as usize..end as usize));
                paths.push(CellLink { from, to, tag, off: offs[a] + offs[b], segment: i as u32, start, end });
            }
        }
    }
    // Cells without links are left out.
    let paths = nearest(paths);
    let used: BTreeSet<u32> = paths.iter().flat_map(|w| [w.from, w.to]).collect();
    let renumbered: BTreeMap<u32, u32> = used.iter().copied().zip(0..).collect();
    let link = |w: &CellLink| {
        let (s, [from, to]) = (&segments[w.segment as usize], [w.from, w.to].map(|cell| renumbered[&cell]));
        LinkRecord { from, to, ..captured_link(&tracks[s.clip], s, w.start as usize, w.end as usize) }
    };
    let links: Vec<LinkRecord> = paths.iter().map(link).collect();
    let all: Vec<(&BlockCellKey, Placement)> = keys.keys().zip(means).collect();
    let cell = |(new, &old): (u32, &u32)| inner_cell(new, all[old as usize].1, all[old as usize].0.4, &links);
    ((0u32..).zip(&used).map(cell).collect(), links)
}

/// A link as captured, without its cells.
pub(super) fn captured_link(track: &PatchTrack, segment: &BlockSegment, start: usize, end: usize) -> LinkRecord {
    let placed = |f: usize| segment.to_block.compose(Placement::from_planar(track.places[f], 0.0));
    let (frame, num_frames) = (track.first_row + start as u32, (end - start) as u16);
    let (tag, start, end) = (track.tag_of(&(start..end)), placed(start), placed(end));
    LinkRecord { from: NONE, to: NONE, frame, num_frames, tag, start, end }
}

fn cell_key(track: &PatchTrack, segment: &BlockSegment, frame: usize, config: &PatchConfig) -> Option<BlockCellKey> {
    let group = track.groups[frame];
    if group == PoseGroups::NO_GROUP {
        return None;
    }
    let p = segment.to_block.compose(track.footing(frame));
    let bin = |v: f32| (v / config.cell_m as f32).floor() as i32;
    let per_turn = (360.0 / config.cell_deg).ceil() as i32;
    let turn = ((p.heading.to_degrees() / config.cell_deg as f32).floor() as i32).rem_euclid(per_turn);
    // The height is rounded, so that the ground is not on the border of two cells.
    Some((bin(p.x), (p.y / config.cell_m as f32).round() as i32, bin(p.z), turn, group))
}

/// Placement of the hips at a frame, in the block's frame.
fn hips_position(track: &PatchTrack, segment: &BlockSegment, frame: usize, root_heights: &[f32]) -> Placement {
    let height = root_heights[track.first_row as usize + frame];
    segment.to_block.compose(Placement::from_planar(track.places[frame], height))
}

/// Distance of a placement from a cell's mean, in cells.
fn distance(p: Placement, mean: Placement, config: &PatchConfig) -> f32 {
    let metres = (p.translation() - mean.translation()).length();
    let degrees = wrap_angle(p.heading - mean.heading).to_degrees();
    (metres / config.cell_m as f32).hypot(degrees / config.cell_deg as f32)
}

impl PlacementSum {
    fn add(&mut self, p: Placement) {
        self.n += 1.0;
        self.place.iter_mut().zip([p.x, p.y, p.z]).for_each(|(sum, v)| *sum += f64::from(v));
        let (sine, cosine) = f64::from(p.heading).sin_cos();
        self.heading = [self.heading[0] + sine, self.heading[1] + cosine];
    }

    fn mean(&self) -> Placement {
        let [x, y, z] = self.place.map(|v| (v / self.n) as f32);
        Placement::new(x, y, z, self.heading[0].atan2(self.heading[1]) as f32)
    }
}

/// Keeps one of all sub-sequences with equal cells and tag: the one with ends nearest to the cells' means; sorted.
fn nearest(mut paths: Vec<CellLink>) -> Vec<CellLink> {
    let between = |w: &CellLink| (w.from, w.to, w.tag);
    paths.sort_unstable_by(|a, b| {
        let place = |w: &CellLink| (w.segment, w.start, w.end);
        between(a).cmp(&between(b)).then(a.off.total_cmp(&b.off)).then(place(a).cmp(&place(b)))
    });
    paths.dedup_by_key(|w| between(w));
    paths
}
