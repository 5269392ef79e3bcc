//! Spots at which links of a tile may begin and end: entries and exits on its edges, rest inside.

use super::{TileOutline, TileVocabulary, lateral};
use crate::{environment::TileEdges, patch::TileConfig};
use glam::Vec2;
use std::collections::BTreeMap;
use std::f32::consts::{PI, TAU};
use throng_core::{Planar, patch::NONE};

/// Purpose of a spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SpotKind {
    /// Begin of links.
    Entry,
    /// End of links.
    Exit,
    /// Begin and end of links.
    Rest,
}

/// A place, heading and pose at which links begin or end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TileSpot {
    /// Planar root in the tile's frame.
    pub place: Planar,
    /// Height of the support (m).
    pub support: f32,
    /// Pose group.
    pub group: u32,
    /// Edge that is entered or left here; [`NONE`] inside.
    pub edge: u32,
    /// Entry of the neighbour for an exit, and vice versa; [`NONE`] inside.
    pub twin: u32,
    /// Purpose.
    pub kind: SpotKind,
}

impl TileSpot {
    /// A rest spot.
    pub fn at_rest(place: Planar, support: f32, group: u32) -> Self {
        Self { place, support, group, edge: NONE, twin: NONE, kind: SpotKind::Rest }
    }
}

/// All spots of a tile: entries, then exits in the same order seen from the neighbours, then rest.
pub(super) struct TileLayout {
    /// The spots.
    pub spots: Vec<TileSpot>,
    /// Number of edges.
    pub num_edges: usize,
    /// First of the spots at which two people begin or end an interaction.
    pub first_of_pairs: usize,
}

/// Spots along the edges and inside, regardless of whether motion can serve them.
pub(super) fn lay_out(region: &TileOutline, words: &TileVocabulary, config: &TileConfig) -> TileLayout {
    let edges = region.edges;
    let num_edges = 2 * edges.steps.len();
    let mut entries = Vec::new();
    for edge in 0..num_edges {
        let (step, width) = (edges.steps[edge / 2], edges.widths[edge / 2]);
        let ahead = -region.sides[edge].normal;
        let middle = region.centre - ahead * (step[0].hypot(step[2]) / 2.0);
        let room = (width / 2.0 - region.margin).max(0.0);
        let height = edge_height(edges, edge);
        for slot in 0..config.slots {
            let aside = if config.slots > 1 { slot as f32 * 2.0 / (config.slots - 1) as f32 - 1.0 } else { 0.0 };
            let p = middle + lateral(ahead) * (aside * room);
            for turn in -(config.headings as i32)..=config.headings as i32 {
                let off = turn as f32 * (config.heading_step_deg as f32).to_radians();
                let place = Planar::new(p.x, p.y, ahead.x.atan2(ahead.y) + off);
                entries.extend(words.edge[edge].iter().map(|w| TileSpot {
                    place,
                    support: height + w.level,
                    group: w.group,
                    edge: edge as u32,
                    twin: NONE,
                    kind: SpotKind::Entry,
                }));
            }
        }
    }
    let num_entries = entries.len();
    let exits: Vec<TileSpot> = entries.iter().enumerate().map(|(i, e)| exit_for_entry(e, i, edges)).collect();
    entries.iter_mut().zip(num_entries as u32..).for_each(|(e, exit)| e.twin = exit);
    let rest = rest_spots(region, words, config);
    let spots: Vec<TileSpot> = entries.into_iter().chain(exits).chain(rest).collect();
    TileLayout { first_of_pairs: spots.len(), spots, num_edges }
}

/// Height of the middle of an edge (m).
pub(super) fn edge_height(edges: &TileEdges, edge: usize) -> f32 {
    let half = edges.steps[edge / 2][1] / 2.0;
    edges.centre[1] + if edge.is_multiple_of(2) { half } else { -half }
}

/// Exit that leads to an entry of the neighbour: in this tile's frame, across the opposite edge.
fn exit_for_entry(entry: &TileSpot, number: usize, edges: &TileEdges) -> TileSpot {
    let edge = entry.edge ^ 1;
    let step = edges.steps[edge as usize / 2];
    let sign = if edge.is_multiple_of(2) { 1.0 } else { -1.0 };
    let place = Planar::new(entry.place.x + sign * step[0], entry.place.z + sign * step[2], entry.place.heading);
    let support = entry.support + sign * step[1];
    TileSpot { place, support, edge, twin: number as u32, kind: SpotKind::Exit, ..*entry }
}

/// Rest spots, in a square about the centre of level ground; other units have no pose groups of rest.
fn rest_spots(region: &TileOutline, words: &TileVocabulary, config: &TileConfig) -> Vec<TileSpot> {
    let mut out = Vec::new();
    let insets = (0..region.sides.len()).map(|s| region.inset(s, region.centre));
    let half = insets.fold(f32::MAX, f32::min) - 2.0 * region.margin;
    let n = config.rest_spots;
    let level = region.edges.centre[1];
    let at = |k: usize| half.max(0.0) * (2.0 * (k as f32 + 0.5) / n as f32 - 1.0);
    for spot in 0..n * n {
        for turn in 0..config.rest_headings {
            let heading = turn as f32 * TAU / config.rest_headings as f32;
            let heading = if heading > PI { heading - TAU } else { heading };
            let place = Planar::new(region.centre.x + at(spot % n), region.centre.y + at(spot / n), heading);
            out.extend(words.rest.iter().map(|&group| TileSpot::at_rest(place, level, group)));
        }
    }
    out
}

impl TileLayout {
    /// Exits and rest, by pose group.
    pub fn targets(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut targets = BTreeMap::<u32, Vec<u32>>::new();
        for (i, spot) in (0u32..).zip(&self.spots).filter(|(_, s)| s.kind != SpotKind::Entry) {
            targets.entry(spot.group).or_default().push(i);
        }
        targets
    }

    /// For each spot, then for each edge, the one a quarter turn (from +Z to +X) farther; `None` for a tile without
    /// that symmetry.
    pub fn quarter_turn(&self) -> Option<Vec<u32>> {
        let quarter = Planar::new(0.0, 0.0, TAU / 4.0);
        let key = |s: &TileSpot, p: Planar| {
            let turn = (p.heading.rem_euclid(TAU) * 1000.0).round() as i64 % (TAU * 1000.0).round() as i64;
            let mm = |v: f32| (v * 1000.0).round() as i64;
            (s.kind as u8, s.group, mm(p.x), mm(p.z), turn, mm(s.support))
        };
        let numbered = self.spots.iter().enumerate();
        let all: BTreeMap<_, u32> = numbered.map(|(i, s)| (key(s, s.place), i as u32)).collect();
        self.spots.iter().map(|s| all.get(&key(s, quarter.compose(s.place))).copied()).collect()
    }

    /// Direction of leaving a tile across `to` for a character that entered across `from`, in words.
    pub fn direction(region: &TileOutline, from: u32, to: u32) -> &'static str {
        let ahead = -region.sides[from as usize].normal;
        let out: Vec2 = region.sides[to as usize].normal;
        let (along, left) = (ahead.dot(out), lateral(ahead).dot(out));
        match (along > 0.7, along < -0.7, left > 0.0) {
            (true, ..) => "straight ahead",
            (_, true, _) => "back across the same edge",
            (_, _, true) => "to the left",
            _ => "to the right",
        }
    }
}
