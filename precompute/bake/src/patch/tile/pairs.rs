//! Interactions of two people: two clips of one take, placed across the edges of level ground.
//!
//! The midpoint between the two is placed on the midpoint of an edge, and each stands in a copy of the tile of its own.
//! So each reserves its own ground, walks there and away as to any other rest spot, and the two have the relative
//! placement of the capture.

use super::{TileLayout, TileOutline, TileSource, TileSpot};
use crate::patch::{PairReport, PatchInputs, TileConfig};
use crate::{patch::config::star_text, patch::track::is_slow};
use glam::Vec2;
use throng_core::patch::{LinkRecord, NONE, Placement};
use throng_core::{Planar, planar::wrap_angle};
use throng_motion::{BuildError, ExclusionReason, FrameRange, Result};

/// Longest time from standing still to the beginning of the tagged range, and from its end to standing still (s).
const STANDING_WITHIN_S: f64 = 1.5;
/// Largest distance of a partner's first pose from a pose of rest: joints on average (rad).
const REST_RAD: f32 = 0.2;
/// Least distance of roots from the line between the two (m).
const APART_M: f32 = 0.12;
/// Least and largest distance between partners at the begin (m).
const REACH_M: [f32; 2] = [0.3, 2.0];
/// Largest distance of equal places and headings of rest; the remaining gap is blended at the begin (m, rad).
const SAME_REST: (f32, f32) = (0.03, 0.05);

/// A pose of rest on the tile, as a frame.
pub(super) struct TileRestPose {
    group: u32,
    clip: usize,
    frame: usize,
}

/// An interaction of two people.
pub(super) struct PairTake {
    /// Numbers of the clips of the two.
    clips: [usize; 2],
    /// Frames from standing before to standing after.
    range: FrameRange,
    /// Pose groups of rest at begin and end of the two.
    rest: [[u32; 2]; 2],
    /// 1 + number of the tag.
    tag: u16,
}

/// An interaction across one edge, as links between spots.
pub(super) struct PairLinks {
    /// Edge beyond which the partner is.
    pub edge: u32,
    /// Link in this tile, and that of the partner in the tile beyond the edge.
    pub links: [LinkRecord; 2],
}

/// A frame of standing still for each pose group of rest that allows waiting.
pub(super) fn poses_of_rest(source: &TileSource, groups: &[u32], min_frames: usize) -> Vec<TileRestPose> {
    let waits = |group: &&u32| {
        let mut stops = source.clips.iter().flat_map(|&c| source.tracks[c].standing.iter().map(move |s| (c, s)));
        stops.any(|(c, stop)| {
            let mut frames =
                stop.clone().filter(|&f| source.run_end(c, f) > 0 && source.tracks[c].groups[f] == **group);
            frames.next().is_some_and(|first| frames.next_back().is_some_and(|last| last >= first + min_frames))
        })
    };
    let of = |group: u32| {
        let standing: Vec<(usize, usize)> =
            source.frames_in(group).filter(|&(c, f)| source.tracks[c].is_standing(f)).collect();
        standing.get(standing.len() / 2).map(|&(clip, frame)| TileRestPose { group, clip, frame })
    };
    groups.iter().filter(waits).filter_map(|&g| of(g)).collect()
}

/// Search for interactions in clips.
pub(super) struct PairSearch<'a> {
    pub given: &'a PatchInputs<'a>,
    /// Poses of rest.
    pub rest: &'a [TileRestPose],
}

impl PairSearch<'_> {
    /// Finds the interactions in the clips that the config names as pairs.
    ///
    /// # Errors
    /// [`BuildError::Key`] for a pattern that no clip matches.
    pub fn find(&self, config: &TileConfig) -> Result<(Vec<PairTake>, Vec<PairReport>)> {
        let given = self.given;
        let (mut takes, mut reports) = (Vec::new(), Vec::new());
        for (i, patterns) in config.pairs.iter().enumerate() {
            let clips = given.clips.clips.iter().enumerate().filter(|(_, c)| !c.mirrored);
            let firsts: Vec<(usize, &str)> =
                clips.filter_map(|(c, clip)| Some((c, star_text(&patterns[0], &clip.name)?))).collect();
            if firsts.is_empty() {
                let why =
                    format!("expected a clip whose name matches {}, found none. Correct the config.", patterns[0]);
                return Err(BuildError::key(format!("pairs[{i}][0]"), why));
            }
            for (first, star) in firsts {
                let partner = patterns[1].replace('*', star);
                let second = given.clips.clips.iter().position(|c| !c.mirrored && c.name == partner);
                let found = match second {
                    Some(second) => self.find_in_range([first, second]),
                    None => vec![Err((String::new(), format!("expected a clip `{partner}`, found none")))],
                };
                let name = &given.clips.clips[first].name;
                for f in found {
                    let (tag, refused) = match &f {
                        Ok(take) => (given.tags[usize::from(take.tag) - 1].clone(), None),
                        Err((tag, why)) => (tag.clone(), Some(why.clone())),
                    };
                    reports.push(PairReport { clips: [name.clone(), partner.clone()], tag, refused, edges: 0 });
                    takes.extend(f);
                }
            }
        }
        Ok((takes, reports))
    }

    /// Interactions in two clips, or the tag with the reason against it.
    fn find_in_range(&self, clips: [usize; 2]) -> Vec<Result<PairTake, (String, String)>> {
        let given = self.given;
        let [a, b] = clips.map(|c| &given.clips.clips[c]);
        if a.num_frames() != b.num_frames() {
            let [(a, n), (b, m)] = [a, b].map(|c| (&c.name, c.num_frames()));
            let why = format!("`{a}` has {n} frames and `{b}` {m}; clips that were captured together are equally long");
            return vec![Err((String::new(), why))];
        }
        let mut out = Vec::new();
        for tag in &a.tags {
            for other in b.tags.iter().filter(|t| t.name == tag.name) {
                let range =
                    tag.range.start.max(other.range.start)..tag.range.end.min(other.range.end).min(a.num_frames());
                if range.len() > given.config.min_link_frames {
                    let found = self.find_standing_ends(clips, &range);
                    let found = found.and_then(|(range, rest)| Ok((keeps_apart(given, clips, range)?, rest)));
                    let number = given.tags.iter().position(|t| *t == tag.name).unwrap_or(0) as u16 + 1;
                    let take = found.map(|(range, rest)| PairTake { clips, range, rest, tag: number });
                    out.push(take.map_err(|why| (tag.name.clone(), why)));
                }
            }
        }
        if out.is_empty() {
            let why = "no tag names what both do at the same time; give them one in their sidecar files";
            out.push(Err((String::new(), why.into())));
        }
        out
    }

    /// The frames from standing of both near the beginning of a range to standing of both near its end, with the
    /// nearest poses of rest.
    fn find_standing_ends(&self, clips: [usize; 2], range: &FrameRange) -> Result<(FrameRange, [[u32; 2]; 2]), String> {
        let given = self.given;
        let (rate, tracks) = (given.clips.clips[clips[0]].rate_hz, clips.map(|c| &given.tracks[c]));
        let near = (STANDING_WITHIN_S * rate) as usize;
        // Frames excluded only for standing still at the end of a clip are usable here; others are not.
        let is_usable = |c: usize, f: usize| {
            let mut excluded = given.clips.clips[c].excluded.iter();
            !excluded.any(|e| e.range.contains(&f) && e.reason != ExclusionReason::Still)
        };
        let stand = |f: usize| {
            clips.iter().zip(tracks).all(|(&c, t)| is_usable(c, f) && is_slow(&given.clips.clips[c], &t.places, f))
        };
        let num = tracks[0].places.len();
        let found = |at: usize, which: &str| {
            let mut standing: Vec<usize> =
                (at.saturating_sub(near)..(at + near).min(num - 1)).filter(|&f| stand(f)).collect();
            standing.sort_by_key(|f| f.abs_diff(at));
            let mut least = f32::MAX;
            for f in standing {
                let [a, b] = clips.map(|c| self.nearest(c, f));
                if a.0.max(b.0) <= REST_RAD {
                    return Ok((f, [a.1, b.1]));
                }
                least = least.min(a.0.max(b.0));
            }
            let at_s = at as f64 / rate;
            let wanted =
                format!("expected both to stand still within {STANDING_WITHIN_S} s of its {which} at {at_s:.1} s");
            Err(match least {
                f32::MAX => wanted,
                off => format!(
                    "{wanted}, as people rest on this tile: joints are {:.0} deg off on average, {:.0} at most are mended",
                    off.to_degrees(),
                    REST_RAD.to_degrees()
                ),
            })
        };
        let ((start, first), (end, last)) = (found(range.start, "beginning")?, found(range.end, "end")?);
        let whole = clips.iter().all(|&c| (start..=end).all(|f| is_usable(c, f)));
        if end < start + given.config.min_link_frames || end - start > usize::from(u16::MAX) || !whole {
            return Err(format!("frames {start} to {end} are too few, too many, or not all of use"));
        }
        Ok((start..end, [first, last]))
    }

    /// Nearest pose of rest to a frame: mean turn of the joints (rad), and its group.
    fn nearest(&self, clip: usize, frame: usize) -> (f32, u32) {
        let given = self.given;
        let pose = &given.clips.clips[clip].frame_rotations(frame)[1..];
        let off = |r: &TileRestPose| {
            let own = &given.clips.clips[r.clip].frame_rotations(r.frame)[1..];
            pose.iter().zip(own).map(|(a, b)| a.angle_between(*b)).sum::<f32>() / pose.len() as f32
        };
        let all = self.rest.iter().map(|r| (off(r), r.group));
        all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f32::MAX, NONE))
    }
}

/// Checks that each stays on its side of the line between the two.
fn keeps_apart(given: &PatchInputs, clips: [usize; 2], range: FrameRange) -> Result<FrameRange, String> {
    let rate = given.clips.clips[clips[0]].rate_hz;
    let at = |side: usize, f: usize| {
        let p = given.tracks[clips[side]].places[f];
        Vec2::new(p.x, p.z)
    };
    let apart = at(0, range.start).distance(at(1, range.start));
    if !(REACH_M[0]..=REACH_M[1]).contains(&apart) {
        return Err(format!("expected two who begin {} to {} m apart, found {apart:.2} m", REACH_M[0], REACH_M[1]));
    }
    let middle = midpoint(given, clips, range.start);
    for f in range.clone() {
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            if sign * middle.inverse_transform_point(at(side, f)).y < APART_M {
                let at_s = f as f64 / rate;
                return Err(format!(
                    "one comes within {APART_M} m of the line between the two at {at_s:.1} s: they have no room side by side"
                ));
            }
        }
    }
    Ok(range)
}

/// Midpoint between two at a frame; its heading is from the first to the second.
fn midpoint(given: &PatchInputs, clips: [usize; 2], frame: usize) -> Planar {
    let [a, b] = clips.map(|c| given.tracks[c].places[frame]);
    Planar::new(0.5 * (a.x + b.x), 0.5 * (a.z + b.z), (b.x - a.x).atan2(b.z - a.z))
}

/// Placement of a take in the tile, for an edge: that of the first, and that of the second in the frame of the tile
/// beyond the edge.
fn place_take(given: &PatchInputs, take: &PairTake, edge: usize, region: &TileOutline) -> [Planar; 2] {
    let side = &region.sides[edge];
    let at = region.centre + side.normal * (side.offset - side.normal.dot(region.centre));
    let middle = Planar::new(at.x, at.y, side.normal.x.atan2(side.normal.y));
    let base = middle.compose(midpoint(given, take.clips, take.range.start).inverse());
    let (step, sign) = (region.edges.steps[edge / 2], if edge.is_multiple_of(2) { 1.0 } else { -1.0 });
    [base, Planar::new(base.x - sign * step[0], base.z - sign * step[2], base.heading)]
}

impl TileLayout {
    /// Adds the spots at which partners begin and end.
    ///
    /// - returns links between them, for each take and each edge.
    pub fn add_pairs(
        &mut self,
        given: &PatchInputs,
        takes: &[PairTake],
        region: &TileOutline,
    ) -> Vec<(usize, PairLinks)> {
        let level = region.edges.centre[1];
        let mut out = Vec::new();
        for (number, take) in takes.iter().enumerate() {
            for edge in 0..self.num_edges {
                let bases = place_take(given, take, edge, region);
                let links = [0, 1].map(|side| {
                    let track = &given.tracks[take.clips[side]];
                    let mut ends = [0, 1].map(|end| {
                        let f = if end == 0 { take.range.start } else { take.range.end };
                        let place = bases[side].compose(track.places[f]);
                        let wrapped = Planar { heading: wrap_angle(place.heading), ..place };
                        let spot = self.pair_spot(wrapped, take.rest[end][side], level);
                        (spot, Placement::from_planar(place, level - track.support[f]))
                    });
                    let turns = ends[0].1.heading - wrap_angle(ends[0].1.heading);
                    ends.iter_mut().for_each(|(_, at)| at.heading -= turns);
                    LinkRecord {
                        from: ends[0].0,
                        to: ends[1].0,
                        frame: track.first_row + take.range.start as u32,
                        num_frames: take.range.len() as u16,
                        tag: take.tag | LinkRecord::FOR_TWO,
                        start: ends[0].1,
                        end: ends[1].1,
                    }
                });
                out.push((number, PairLinks { edge: edge as u32, links }));
            }
        }
        out
    }

    /// Spot at which partners begin or end, existing or new. Any pose of rest serves, as the first pose is blended from
    /// it anyway.
    fn pair_spot(&mut self, place: Planar, group: u32, support: f32) -> u32 {
        let is_same = |s: &TileSpot| {
            (s.place.x - place.x).hypot(s.place.z - place.z) < SAME_REST.0
                && wrap_angle(s.place.heading - place.heading).abs() < SAME_REST.1
        };
        if let Some(k) = self.spots[self.first_of_pairs..].iter().position(is_same) {
            return (self.first_of_pairs + k) as u32;
        }
        self.spots.push(TileSpot::at_rest(place, support, group));
        self.spots.len() as u32 - 1
    }
}
