//! Links that stay in place: standing, turning on the spot, and tagged activities.

use super::{BestCandidates, LinkCandidate, SpotKind, TileLayout, TileSearch};
use crate::patch::track::PatchTrack;
use std::{collections::BTreeMap, f32::consts::TAU};
use throng_core::patch::{LinkRecord, Placement};
use throng_core::{Planar, planar::wrap_angle};
use throng_motion::clip::FrameRange;

/// Largest shift of the end of standing or turning (m).
const REACH_M: f32 = 0.05;
/// Largest turn of the end of standing or turning (rad).
const TURN_RAD: f32 = 0.17;
/// Largest distance of the root from where it stood (m).
const SWAY_M: f32 = 0.4;
/// Longest time from rest to rest, except in tagged ranges (frames).
const MAX_FRAMES: usize = 120;
/// Largest distance from begin to end of a tagged range (m, rad).
const RETURN: RestTolerance = RestTolerance { reach_m: 0.3, turn_rad: 0.35 };

/// Largest edit that brings a motion to the place and heading of rest where it should end.
#[derive(Clone, Copy)]
struct RestTolerance {
    /// Largest offset (m).
    reach_m: f32,
    /// Largest turn (rad).
    turn_rad: f32,
}

/// Pose groups of rest at begin and end, and number of heading steps.
type RestChange = (u32, u32, usize);

/// Links between the rest spots of a tile, each of which stays in its place.
pub(super) fn links(search: &TileSearch) -> Vec<LinkRecord> {
    let groups: Vec<u32> = {
        let rest = search.layout.spots.iter().filter(|s| s.kind == SpotKind::Rest);
        rest.map(|s| s.group).collect::<std::collections::BTreeSet<_>>().into_iter().collect()
    };
    let mut rest = RestSearch { search, groups: &groups, found: BTreeMap::new() };
    for (clip, start) in groups.iter().flat_map(|&from| search.source.frames_in(from)) {
        rest.offer_standing_from(clip, start);
    }
    search.source.clips.iter().for_each(|&clip| rest.offer_behaviours(clip));
    let mut out = Vec::new();
    for ((from, to, _), best) in rest.found {
        for (_, tag, candidate) in best.into_sorted() {
            out.extend(links_at_all_spots(search, [from, to], tag, &candidate));
        }
    }
    out
}

/// Search for the best candidates of every change.
struct RestSearch<'a> {
    search: &'a TileSearch<'a>,
    /// Pose groups of rest.
    groups: &'a [u32],
    found: BTreeMap<RestChange, BestCandidates>,
}

impl RestSearch<'_> {
    /// Offers all standing and turning that begins with one frame.
    fn offer_standing_from(&mut self, clip: usize, start: usize) {
        let search = self.search;
        let track = &search.source.tracks[clip];
        if !track.is_standing(start) {
            return;
        }
        for end in start + 1..search.source.run_end(clip, start).min(start + MAX_FRAMES + 1) {
            let moved = track.places[start].to_local(track.places[end]);
            if moved.x.hypot(moved.z) > SWAY_M {
                return;
            }
            if end - start >= search.min_frames && self.groups.contains(&track.groups[end]) && track.is_standing(end) {
                let travelled = track.travelled[end] - track.travelled[start];
                let reach_m = REACH_M.max(search.config.edit_m_per_m as f32 * travelled);
                let turn_rad = TURN_RAD.max((search.config.edit_deg_per_m as f32).to_radians() * travelled);
                self.offer_run(clip, &(start..end), RestTolerance { reach_m, turn_rad });
            }
        }
    }

    /// Offers the clip's tagged ranges that begin and end at rest in one place.
    fn offer_behaviours(&mut self, clip: usize) {
        let (search, groups) = (self.search, self.groups);
        let track = &search.source.tracks[clip];
        for range in search.source.tag_ranges(clip) {
            let rests = |f: &usize| groups.contains(&track.groups[*f]) && track.is_standing(*f);
            let Some(first) = range.clone().find(rests) else { continue };
            let near = |f: &usize| {
                let moved = track.places[first].to_local(track.places[*f]);
                moved.x.hypot(moved.z) <= RETURN.reach_m && wrap_angle(moved.heading).abs() <= RETURN.turn_rad
            };
            let last = range.clone().rev().find(|f| rests(f) && near(f) && *f < search.source.run_end(clip, first));
            let Some(last) = last.filter(|&l| l >= first + search.min_frames.max(range.len() / 2)) else { continue };
            if last - first <= usize::from(u16::MAX) {
                self.offer_run(clip, &(first..last), RETURN);
            }
        }
    }

    /// Offers one run of frames as a change of pose and heading, if near enough to one.
    fn offer_run(&mut self, clip: usize, range: &FrameRange, tolerance: RestTolerance) {
        let search = self.search;
        let track = &search.source.tracks[clip];
        let moved = track.places[range.start].to_local(track.places[range.end]);
        let RestTolerance { reach_m: reach, turn_rad: turn } = tolerance;
        let num = search.config.rest_headings;
        let steps = (moved.heading / TAU * num as f32).round();
        let missing = Planar::new(-moved.x, -moved.z, steps * TAU / num as f32 - moved.heading);
        let moved_by = missing.x.hypot(missing.z);
        if moved_by > reach || missing.heading.abs() > turn {
            return;
        }
        let cost = (moved_by / reach).hypot(missing.heading / turn);
        let candidate = LinkCandidate { clip, start: range.start, end: range.end, missing, cost };
        let change = (track.groups[range.start], track.groups[range.end], steps.rem_euclid(num as f32) as usize);
        let best =
            self.found.entry(change).or_insert_with(|| BestCandidates::new(search.config.variety, search.min_frames));
        best.offer(0, track.tag_of(range), candidate, || true);
    }
}

/// One link for every place and heading of rest.
fn links_at_all_spots<'a>(
    search: &'a TileSearch,
    [from, to]: [u32; 2],
    tag: u16,
    c: &'a LinkCandidate,
) -> impl Iterator<Item = LinkRecord> + 'a {
    let track = &search.source.tracks[c.clip];
    let turned = track.places[c.end].heading - track.places[c.start].heading + c.missing.heading;
    let spots =
        search.layout.spots.iter().enumerate().filter(move |(_, s)| s.kind == SpotKind::Rest && s.group == from);
    // Partners wait for each other at pair spots; activities of one person take place elsewhere.
    let spots = spots.filter(move |(i, _)| tag == 0 || *i < search.layout.first_of_pairs);
    spots.filter_map(move |(i, spot)| {
        let end = Planar { heading: spot.place.heading + turned, ..spot.place };
        let link = search.link_record(i as u32, search.layout.rest_spot_at(end, to)?, tag, c);
        Some(LinkRecord { end: Placement::from_planar(end, spot.support - track.support[c.end]), ..link })
    })
}

impl PatchTrack {
    /// True if the character stands still.
    pub fn is_standing(&self, frame: usize) -> bool {
        self.stood[frame + 1] > self.stood[frame]
    }
}

impl TileLayout {
    /// Rest spot at a place, up to full turns, in a pose.
    fn rest_spot_at(&self, place: Planar, group: u32) -> Option<u32> {
        let found = self.spots.iter().position(|s| {
            s.kind == SpotKind::Rest
                && s.group == group
                && (s.place.x - place.x).hypot(s.place.z - place.z) < 1e-3
                && wrap_angle(s.place.heading - place.heading).abs() < 1e-3
        });
        found.map(|i| i as u32)
    }
}
