//! Tilable patches: motion that enters and leaves on matching edges (Lee, Choi and Lee 2006, section 6).

mod layout;
mod pairs;
mod prune;
mod refusal;
mod region;
mod rest;
mod search;
mod source;
mod vocabulary;

pub use prune::{Freedom, PrunedTile, TileCell, TileGraph, prune};

use super::{PairReport, PatchInputs, PatchReport, RawPatch, TileConfig, inner_cell, is_ground};
use crate::environment::UnitObject;
use layout::{SpotKind, TileLayout, TileSpot, edge_height, lay_out};
use pairs::{PairLinks, PairSearch};
use rayon::prelude::*;
use region::{TileOutline, crosses_itself, lateral};
use search::{BestCandidates, LinkCandidate, TileSearch};
use source::TileSource;
use std::f32::consts::TAU;
use throng_core::patch::{CellRecord, EdgeRecord, KIND_TILE, LinkRecord, NONE, PairRecord, Placement};
use throng_motion::error::{BuildError, Result, ensure};
use vocabulary::TileVocabulary;

/// Shortest link of a tile with two edges. A piece of a slide takes less time than links elsewhere, and is too short
/// for more than one link (frames).
const RISING_FRAMES: usize = 5;

/// Multiples of the configured number of poses that are tried in turn.
const MORE_POSES: [usize; 3] = [1, 2, 4];

/// Makes one tile.
///
/// # Errors
/// [`BuildError::Key`] for a missing unit, one without edges, or patterns without matching clips; [`BuildError::Stage`]
/// if pruning leaves nothing, with the unmet condition.
pub(super) fn build(given: &PatchInputs, config: &TileConfig) -> Result<(RawPatch, PatchReport)> {
    let unit = given.units.units.iter().find(|u| u.name == config.unit);
    let unit = unit.ok_or_else(|| refusal::missing_unit_error(given, config))?;
    let edges = unit.tile.as_ref().ok_or_else(|| refusal::missing_edges_error(unit))?;
    let source = source_of(given, unit, config)?;
    let region = TileOutline::new(edges, config.margin_m as f32);
    let num_edges = 2 * edges.steps.len();
    let usual = given.config.min_link_frames;
    let min_frames = if is_ground(unit) { usual } else { RISING_FRAMES.min(usual) };
    let with_poses = |times: usize| {
        let words = if is_ground(unit) {
            TileVocabulary::from_ground(&source, num_edges, config, times)
        } else {
            TileVocabulary::from_rising(&source, &region, config)
        };
        let mut layout = lay_out(&region, &words, config);
        let rest = pairs::poses_of_rest(&source, &words.rest, min_frames);
        let (takes, reports) = PairSearch { given, rest: &rest }.find(config)?;
        let joints = layout.add_pairs(given, &takes, &region);
        let (source, region, targets) = (&source, &region, layout.targets());
        let links = all_links(&TileSearch { source, layout: &layout, region, config, min_frames, targets });
        let graph = graph_of(unit, &layout, &links);
        Ok::<_, BuildError>(UnprunedTile { unit, region, layout, links, graph, joints, reports })
    };
    // Few poses make a small tile; motion of several kinds needs more of them.
    let mut tried = Vec::new();
    for times in if is_ground(unit) { &MORE_POSES[..] } else { &MORE_POSES[..1] } {
        tried.push(with_poses(*times)?);
        if let Some(made) = tried[tried.len() - 1].prune(given, Freedom::EachTile) {
            return Ok(made);
        }
    }
    let further = tried.iter().find_map(|tile| tile.prune(given, Freedom::FurtherTiles));
    further.ok_or_else(|| refusal::empty_tile_error(&tried[tried.len() - 1], &source))
}

/// A tile before pruning.
struct UnprunedTile<'a> {
    unit: &'a UnitObject,
    region: &'a TileOutline<'a>,
    layout: TileLayout,
    links: Vec<LinkRecord>,
    graph: TileGraph,
    /// Interactions of two people, each with the number of its report.
    joints: Vec<(usize, PairLinks)>,
    reports: Vec<PairReport>,
}

/// Clips of a tile, and the copies of a rising one that they were captured on.
fn source_of<'a>(given: &PatchInputs<'a>, unit: &UnitObject, config: &TileConfig) -> Result<TileSource<'a>> {
    let mut clips = Vec::new();
    let mut copies = Vec::new();
    for (c, (clip, setting)) in given.clips.clips.iter().zip(given.settings).enumerate() {
        let named = config.clips.iter().any(|p| super::config::matches(p, &clip.name));
        // The mirrored copy of a clip in an environment lacks support.
        let afloat = setting.is_none() && clip.mirrored && c > 0 && given.settings[c - 1].is_some();
        if afloat || !named && !config.clips.is_empty() {
            continue;
        }
        match setting {
            None if is_ground(unit) => clips.push(c),
            Some(_) if is_ground(unit) && named => clips.push(c),
            Some(setting) if !is_ground(unit) => {
                let placed = setting.environment.units.iter();
                let of_unit: Vec<_> = placed.filter(|p| given.units.units[p.unit].name == unit.name).collect();
                if !of_unit.is_empty() {
                    clips.push(c);
                }
                copies.extend(of_unit.iter().map(|p| (c, p.placement)));
            }
            _ => {}
        }
    }
    ensure(!clips.is_empty(), || refusal::missing_clips_error(unit, config))?;
    Ok(TileSource::new(given.clips, given.tracks, clips, copies))
}

/// Links between all spots, sorted.
fn all_links(search: &TileSearch) -> Vec<LinkRecord> {
    let begins = |i: &u32| search.layout.spots[*i as usize].kind != SpotKind::Exit;
    let spots = (0..search.layout.spots.len() as u32).filter(begins);
    let turned = search.layout.quarter_turn();
    let from: Vec<u32> = if let Some(turned) = &turned { first_turns(turned, spots) } else { spots.collect() };
    let found = from.par_iter().flat_map_iter(|&s| search.links_from(s));
    let mut links: Vec<LinkRecord> = match &turned {
        Some(turned) => found.flat_map_iter(|l| all_turns(turned, l)).collect(),
        None => found.collect(),
    };
    links.extend(rest::links(search));
    links.sort_by_key(|l| (l.from, l.to, l.tag, l.frame, l.num_frames));
    links
}

/// Graph of a tile for pruning.
fn graph_of(unit: &UnitObject, layout: &TileLayout, links: &[LinkRecord]) -> TileGraph {
    let cells = layout.spots.iter().map(|s| match s.kind {
        SpotKind::Entry => TileCell::Entry(s.edge),
        SpotKind::Exit => TileCell::Exit(s.edge, s.twin),
        SpotKind::Rest => TileCell::Rest,
    });
    let all: Vec<u32> = (0..layout.num_edges as u32).collect();
    let ground = is_ground(unit);
    TileGraph {
        cells: cells.collect(),
        links: links.iter().map(|l| (l.from, l.to)).collect(),
        exit_edges: all.iter().map(|&e| if ground { all.clone() } else { vec![e ^ 1] }).collect(),
        must_rest: ground,
        together: if ground { vec![all] } else { all.iter().map(|&e| vec![e]).collect() },
    }
}

impl UnprunedTile<'_> {
    /// Patch of the cells and links that remain after pruning; `None` if no link does.
    fn prune(&self, given: &PatchInputs, freedom: Freedom) -> Option<(RawPatch, PatchReport)> {
        let Self { unit, region, layout, links, .. } = self;
        let pruned = prune(&self.graph, freedom);
        if !pruned.links.contains(&true) {
            return None;
        }
        let mut number = vec![NONE; layout.spots.len()];
        let alive: Vec<usize> = (0..layout.spots.len()).filter(|&i| pruned.cells[i]).collect();
        for (new, &old) in alive.iter().enumerate() {
            number[old] = new as u32;
        }
        let renumbered = |l: &LinkRecord| LinkRecord { from: number[l.from as usize], to: number[l.to as usize], ..*l };
        let links: Vec<LinkRecord> =
            links.iter().zip(&pruned.links).filter(|(_, left)| **left).map(|(l, _)| renumbered(l)).collect();
        let (links, pairs, reports) = self.add_pairs(links, &pruned.cells, renumbered);
        let cells = (0u32..).zip(&alive).map(|(new, &old)| {
            let s = &layout.spots[old];
            let placement = Placement::from_planar(s.place, s.support + given.hips[s.group as usize]);
            let inner = inner_cell(new, placement, s.group, &links);
            let flags = match s.kind {
                SpotKind::Entry => CellRecord::IS_ENTRY,
                SpotKind::Exit => CellRecord::IS_EXIT,
                SpotKind::Rest => inner.flags,
            };
            let twin = if s.twin == NONE { NONE } else { number[s.twin as usize] };
            CellRecord { edge: s.edge, twin, flags, ..inner }
        });
        let cells: Vec<CellRecord> = cells.collect();
        let used: std::collections::BTreeSet<u32> =
            links.iter().flat_map(|l| l.frame..=l.frame + u32::from(l.num_frames)).collect();
        let report = PatchReport {
            name: unit.name.clone(),
            segments: links.len(),
            frames: used.len(),
            cells: cells.len(),
            links: links.len(),
            pruned_directions: pruned.directions,
            freedom,
            pruned_component: pruned.component,
            pairs: reports,
        };
        let edge = |e: usize| {
            let sign = if e.is_multiple_of(2) { 1.0 } else { -1.0 };
            EdgeRecord { step: region.edges.steps[e / 2].map(|v| sign * v), opposite: e as u32 ^ 1 }
        };
        let patch = RawPatch {
            name: unit.name.clone(),
            units: vec![(unit.name.clone(), Placement::IDENTITY)],
            kind: KIND_TILE,
            edges: (0..layout.num_edges).map(edge).collect(),
            bounds: given.bounds.extent_of_links(given.tracks, &links),
            cells,
            links,
            pairs,
        };
        Some((patch, report))
    }

    /// Adds the links of interactions, if all their cells remain.
    fn add_pairs(
        &self,
        mut links: Vec<LinkRecord>,
        alive: &[bool],
        renumbered: impl Fn(&LinkRecord) -> LinkRecord,
    ) -> (Vec<LinkRecord>, Vec<PairRecord>, Vec<PairReport>) {
        let mut reports = self.reports.clone();
        let mut found: Vec<usize> = (0..reports.len()).filter(|&r| reports[r].refused.is_none()).collect();
        let stays: std::collections::BTreeSet<u32> = links.iter().filter(|l| l.from == l.to).map(|l| l.from).collect();
        let is_left = |l: &LinkRecord| {
            let ends = [l.from, l.to].iter().all(|&c| alive[c as usize]);
            ends && [renumbered(l).from, renumbered(l).to].iter().all(|c| stays.contains(c))
        };
        let left: Vec<_> = self.joints.iter().filter(|(_, j)| j.links.iter().all(is_left)).collect();
        for (number, _) in &left {
            reports[found[*number]].edges += 1;
        }
        found.retain(|&r| reports[r].edges == 0);
        for r in found {
            reports[r].refused = Some(
                "no motion leads to where both begin and away from where they end, or nobody can wait there".into(),
            );
        }
        let joined = |j: &PairLinks| j.links.map(|l| renumbered(&l));
        let key = |l: &LinkRecord| (l.from, l.to, l.tag, l.frame, l.num_frames);
        links.extend(left.iter().flat_map(|(_, j)| joined(j)));
        links.sort_by_key(key);
        let number = |l: &LinkRecord| links.partition_point(|k| key(k) < key(l)) as u32;
        let pair = |(_, j): &&(usize, PairLinks)| {
            let [own, other] = joined(j);
            PairRecord { patch: 0, edge: j.edge, link: number(&own), partner_link: number(&other) }
        };
        let mut pairs: Vec<PairRecord> = left.iter().map(pair).collect();
        pairs.sort_by_key(|p| (p.edge, p.link, p.partner_link));
        (links, pairs, reports)
    }
}

/// Spots from which links must be searched: the first of each orbit of quarter turns.
fn first_turns(turned: &[u32], spots: impl Iterator<Item = u32>) -> Vec<u32> {
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
fn all_turns(turned: &[u32], link: LinkRecord) -> impl Iterator<Item = LinkRecord> {
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
