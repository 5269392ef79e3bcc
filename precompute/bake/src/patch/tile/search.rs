//! All sub-sequences of the motion from one spot of a tile to others, by looping over first and last frames (Lee, Choi
//! and Lee 2006, section 6).

use super::{SpotKind, TileLayout, TileOutline, TileSource, crosses_itself};
use crate::{patch::TileConfig, patch::track::PatchTrack};
use glam::Vec2;
use std::collections::BTreeMap;
use throng_core::patch::{LinkRecord, Placement};
use throng_core::{Planar, planar::wrap_angle};

/// Longest link (s).
const MAX_SECONDS: f32 = 12.0;
/// Longest path across a tile, over the straight one.
const DETOUR: f32 = 2.5;
/// Longest time from standing still to the pose of rest of a stopping character, and from that pose to setting out
/// (frames).
const SETTLING_FRAMES: usize = 30;
/// Total turn below which a path cannot cross itself (rad).
const LOOP_RAD: f32 = 3.5;

/// Search for motion between the spots of a tile.
pub(super) struct TileSearch<'a> {
    /// The motion.
    pub source: &'a TileSource<'a>,
    /// Spots of the tile.
    pub layout: &'a TileLayout,
    /// Outline that roots must stay in.
    pub region: &'a TileOutline<'a>,
    /// Limits of editing, and number of kept motions.
    pub config: &'a TileConfig,
    /// Shortest link (frames).
    pub min_frames: usize,
    /// Exits and rest, by pose group.
    pub targets: BTreeMap<u32, Vec<u32>>,
}

/// A first frame, with the placement of its clip in the tile's frame.
struct LinkStart {
    clip: usize,
    frame: usize,
    base: Planar,
}

impl TileSearch<'_> {
    /// Links from an entry to exits and rest, or from rest to exits.
    pub fn links_from(&self, from: u32) -> Vec<LinkRecord> {
        let mut best = BestCandidates::new(self.config.variety, self.min_frames);
        for start in self.starts(from) {
            self.offer_from(from, &start, &mut best);
        }
        best.into_sorted().map(|(to, tag, c)| self.link_record(from, to, tag, &c)).collect()
    }

    /// First frames in the spot's pose group, in order.
    fn starts(&self, from: u32) -> Vec<LinkStart> {
        let spot = &self.layout.spots[from as usize];
        let placed = |clip: usize, frame: usize| {
            let base = spot.place.compose(self.source.tracks[clip].places[frame].inverse());
            LinkStart { clip, frame, base }
        };
        let begins = |&(c, f): &(usize, usize)| match spot.kind {
            SpotKind::Rest => self.source.tracks[c].leaves_rest(f),
            _ => self.source.copies.is_empty() || self.is_captured_at(from, c, f),
        };
        self.source.frames_in(spot.group).filter(begins).map(|(c, f)| placed(c, f)).collect()
    }

    /// True if a frame was captured at the spot of some copy of the tile, within reach of editing.
    fn is_captured_at(&self, from: u32, clip: usize, frame: usize) -> bool {
        let spot = &self.layout.spots[from as usize];
        let (reach, turn) = self.tolerance(self.region.size);
        let at = self.source.tracks[clip].footing(frame);
        self.source.copies.iter().filter(|(c, _)| *c == clip).any(|(_, copy)| {
            let local = copy.to_local(at);
            (local.x - spot.place.x).hypot(local.z - spot.place.z) <= reach
                && wrap_angle(local.heading - spot.place.heading).abs() <= turn
                && (local.y - spot.support).abs() <= super::vocabulary::LEVEL_M
        })
    }

    /// Largest shift and turn of the end after a travelled distance (m, rad).
    fn tolerance(&self, travelled: f32) -> (f32, f32) {
        (self.config.edit_m_per_m as f32 * travelled, (self.config.edit_deg_per_m as f32).to_radians() * travelled)
    }

    /// Offers all sub-sequences that begin with one frame.
    fn offer_from(&self, from: u32, start: &LinkStart, best: &mut BestCandidates) {
        let track = &self.source.tracks[start.clip];
        let last = (start.frame + (MAX_SECONDS * self.source.rate_hz) as usize)
            .min(self.source.run_end(start.clip, start.frame).saturating_sub(1));
        for end in start.frame + 1..=last {
            let place = start.base.compose(track.places[end]);
            let travelled = track.travelled[end] - track.travelled[start.frame];
            let (reach, turn) = self.tolerance(travelled);
            if self.region.is_left(Vec2::new(place.x, place.z), reach + 0.1) {
                return;
            }
            if end < start.frame + self.min_frames {
                continue;
            }
            for &to in self.targets.get(&track.groups[end]).into_iter().flatten() {
                let spot = &self.layout.spots[to as usize];
                let (dx, dz) = (spot.place.x - place.x, spot.place.z - place.z);
                if dx.abs() > reach || dz.abs() > reach || dx.hypot(dz) > reach {
                    continue;
                }
                let dh = wrap_angle(spot.place.heading - place.heading);
                if dh.abs() > turn || !self.is_suitable(from, to, track, start.frame, end) {
                    continue;
                }
                let cost = (dx.hypot(dz) / reach).hypot(dh / turn);
                let missing = Planar::new(dx, dz, dh);
                let candidate = LinkCandidate { clip: start.clip, start: start.frame, end, missing, cost };
                let tag = track.tag_of(&(start.frame..end));
                best.offer(to, tag, candidate, || self.is_plausible(from, to, start, &candidate));
            }
        }
    }

    /// True if the frames stand and walk as motion between the spots should.
    fn is_suitable(&self, from: u32, to: u32, track: &PatchTrack, start: usize, end: usize) -> bool {
        let (from, to) = (&self.layout.spots[from as usize], &self.layout.spots[to as usize]);
        // Frames in which the character stands.
        let within = (track.stood[end] - track.stood[start]) as usize;
        match (from.kind, to.kind) {
            (SpotKind::Rest, SpotKind::Rest) => false,
            (_, SpotKind::Rest) => track.has_just_stopped(end) && within <= SETTLING_FRAMES,
            (SpotKind::Rest, _) => within <= SETTLING_FRAMES,
            // The support rises from spot to spot as in the clip.
            _ => {
                let missing = (to.support - from.support) - (track.support[end] - track.support[start]);
                within == 0 && missing.abs() <= super::vocabulary::LEVEL_M
            }
        }
    }

    /// True if the edited path stays within the tile, does not cross itself and makes no great detour.
    fn is_plausible(&self, from: u32, to: u32, start: &LinkStart, c: &LinkCandidate) -> bool {
        let track = &self.source.tracks[c.clip];
        let mut path: Vec<(Vec2, f32)> = Vec::with_capacity(c.end - c.start + 1);
        for frame in c.start..=c.end {
            let ratio = (frame - c.start) as f32 / (c.end - c.start) as f32;
            let placed = start.base.compose(track.places[frame]);
            let p = Vec2::new(placed.x + ratio * c.missing.x, placed.z + ratio * c.missing.z);
            let walked = path.last().map_or(0.0, |&(q, walked)| walked + p.distance(q));
            path.push((p, walked));
        }
        let turned = track.places[c.end].heading - track.places[c.start].heading;
        let straight = path[0].0.distance(path[path.len() - 1].0).max(self.region.size / 2.0);
        path[path.len() - 1].1 <= DETOUR * straight
            && self.region.contains(self.layout, from, to, &path)
            && (turned.abs() < LOOP_RAD || !crosses_itself(&path))
    }

    /// A link from one spot to another.
    pub fn link_record(&self, from: u32, to: u32, tag: u16, c: &LinkCandidate) -> LinkRecord {
        let track = &self.source.tracks[c.clip];
        let [a, b] = [from, to].map(|s| &self.layout.spots[s as usize]);
        let turned = track.places[c.end].heading - track.places[c.start].heading + c.missing.heading;
        let end = Planar { heading: a.place.heading + turned, ..b.place };
        LinkRecord {
            from,
            to,
            frame: track.first_row + c.start as u32,
            num_frames: (c.end - c.start) as u16,
            tag,
            start: Placement::from_planar(a.place, a.support - track.support[c.start]),
            end: Placement::from_planar(end, b.support - track.support[c.end]),
        }
    }
}

impl PatchTrack {
    /// True if the character is about to leave its place.
    fn leaves_rest(&self, frame: usize) -> bool {
        self.standing.iter().any(|r| r.contains(&frame) && r.end - frame <= SETTLING_FRAMES)
    }

    /// True if the character has stopped recently.
    fn has_just_stopped(&self, frame: usize) -> bool {
        self.standing.iter().any(|r| r.contains(&frame) && frame - r.start <= SETTLING_FRAMES)
    }
}

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
