//! Tilable patches: entries that match exits, motion edited to end there, pruning to a fixed point.

use super::glides::{Glide, NO_GROUP, groups_of, set_of};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::BTreeSet;
use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;
use throng_core::Planar;
use throng_core::patch::{CellRecord, LinkRecord, NONE, Placement};
use throng_core::planar::wrap_angle;
use throng_precompute::clip::{Exclusion, ExclusionReason};
use throng_precompute::cluster::{self, ClusterConfig, PoseGroups};
use throng_precompute::environment::{Environment, PlacedUnit, TileEdges, UnitObject, UnitSet};
use throng_precompute::features::{self, FeaturesConfig};
use throng_precompute::patch::{
    self, CaptureSetting, Freedom, PatchConfig, RawPatch, RawPatches, TileCell, TileConfig, TileGraph, prune,
};
use throng_precompute::progress::Silent;
use throng_precompute::resample::{self, ResampleConfig};
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_precompute::{BuildError, Clip, ClipSet};

const PANEL_M: f32 = 3.0;

fn unit(name: &str, tile: Option<TileEdges>) -> UnitObject {
    UnitObject { name: name.into(), shapes: Vec::new(), region: None, symmetry: 4, tile, floor: true }
}

fn panel() -> UnitSet {
    let steps = vec![[PANEL_M, 0.0, 0.0], [0.0, 0.0, PANEL_M]];
    let edges = TileEdges { steps, widths: vec![PANEL_M; 2], centre: [0.0; 3] };
    UnitSet { units: vec![unit("panel", Some(edges)), unit("rug", None)] }
}

fn with_tile(tile: TileConfig) -> PatchConfig {
    PatchConfig { tiles: vec![tile], ..PatchConfig::default() }
}

/// Twelve minutes of walking and their mirrored copies; six are too few turns for a tile.
static WALK: LazyLock<(ClipSet, PoseGroups)> = LazyLock::new(|| {
    let made = synth::make_set(SynthSet::Walk, &SynthConfig { minutes: 12.0, ..SynthConfig::default() }).unwrap();
    let clips = resample::resample(&made, &ResampleConfig::default()).unwrap();
    let features = features::extract(&clips, &FeaturesConfig::default()).unwrap();
    let groups =
        cluster::group(&clips, &features, &ClusterConfig::default(), &Silent, &throng_core::base::SingleRank).unwrap();
    (clips, groups)
});

static TILE: LazyLock<RawPatches> =
    LazyLock::new(|| built(&WALK.0, &WALK.1, &panel(), &with_tile(TileConfig::for_unit("panel"))).unwrap());

fn built(
    clips: &ClipSet,
    groups: &PoseGroups,
    units: &UnitSet,
    config: &PatchConfig,
) -> Result<RawPatches, BuildError> {
    patch::build(clips, groups, &vec![None; clips.clips.len()], config, units, &Silent)
}

fn links_of<'a>(patch: &'a RawPatch, cell: &CellRecord) -> &'a [LinkRecord] {
    &patch.links[cell.first_link as usize..(cell.first_link + cell.num_links) as usize]
}

#[test]
fn every_entry_can_be_left_across_every_edge_and_come_to_rest() {
    let tile = &TILE.patches[0];
    assert!(tile.links.len() > 2000, "{} links", tile.links.len());
    let entries: Vec<_> = tile.cells.iter().filter(|c| c.has_flags(CellRecord::IS_ENTRY)).collect();
    assert!(entries.len() > 40, "{} entries", entries.len());
    for entry in entries {
        let ways: BTreeSet<u32> = links_of(tile, entry).iter().map(|l| tile.cells[l.to as usize].edge).collect();
        assert_eq!(ways, BTreeSet::from([0, 1, 2, 3, NONE]));
    }
}

#[test]
fn entries_match_the_exits_of_neighbours() {
    let tile = &TILE.patches[0];
    for (i, exit) in tile.cells.iter().enumerate().filter(|(_, c)| c.has_flags(CellRecord::IS_EXIT)) {
        let (entry, edge) = (&tile.cells[exit.twin as usize], tile.edges[exit.edge as usize]);
        assert_eq!((entry.twin, entry.group, entry.edge), (i as u32, exit.group, edge.opposite));
        let [x, y, z] = edge.step;
        let there = Placement::new(x, y, z, 0.0).compose(entry.placement);
        assert!((there.translation() - exit.placement.translation()).length() < 1e-5);
        assert!(wrap_angle(there.heading - exit.placement.heading).abs() < 1e-5);
        assert_eq!(exit.num_links, 0);
    }
}

#[test]
fn links_begin_and_end_exactly_in_their_cells_and_are_edited_within_the_limits() {
    let (tile, config) = (&TILE.patches[0], TileConfig::for_unit("panel"));
    let starts = WALK.0.frame_starts();
    for l in &tile.links {
        for (cell, place) in [(l.from, l.start), (l.to, l.end)] {
            let cell = tile.cells[cell as usize].placement;
            assert!((cell.x - place.x).hypot(cell.z - place.z) < 1e-4 && place.y == 0.0);
            assert!(wrap_angle(cell.heading - place.heading).abs() < 1e-3);
        }
        let c = starts.partition_point(|&s| s <= l.frame) - 1;
        let first = (l.frame - starts[c]) as usize;
        let place = |k: usize| WALK.0.clips[c].planar(first + k);
        let n = usize::from(l.num_frames);
        let step = |k: usize| (place(k + 1).x - place(k).x).hypot(place(k + 1).z - place(k).z);
        let travelled: f32 = (0..n).map(step).sum();
        let base = l.start.planar().compose(place(0).inverse());
        let end = base.compose(place(n));
        let moved = (l.end.x - end.x).hypot(l.end.z - end.z);
        let turned = wrap_angle(l.end.heading - end.heading).abs().to_degrees();
        // Standing and turning on the spot may be edited a little without travelling.
        let rests = [l.from, l.to].iter().all(|&c| tile.cells[c as usize].edge == NONE);
        let (reach, turn) = if rests { (0.05, 10.0) } else { (0.0, 0.0) };
        assert!(moved < (config.edit_m_per_m as f32 * travelled).max(reach) + 1e-3, "{moved} m after {travelled} m");
        assert!(turned < (config.edit_deg_per_m as f32 * travelled).max(turn) + 0.1, "{turned} deg");
        for k in 0..=n {
            let (p, ratio) = (base.compose(place(k)), k as f32 / n as f32);
            let (x, z) = (p.x + ratio * (l.end.x - end.x), p.z + ratio * (l.end.z - end.z));
            assert!(x.abs().max(z.abs()) < PANEL_M / 2.0 + 0.05, "({x}, {z}) is outside");
        }
    }
}

#[test]
fn tiles_of_three_by_three_on_a_torus_are_strongly_connected() {
    check_torus(&TILE.patches[0]);
}

fn check_torus(tile: &RawPatch) {
    let n = tile.cells.len();
    let node = |x: i32, z: i32, cell: u32| {
        let c = &tile.cells[cell as usize];
        if !c.has_flags(CellRecord::IS_EXIT) {
            return ((x + 3 * z) as usize * n) + cell as usize;
        }
        let step = tile.edges[c.edge as usize].step.map(|s| (s / PANEL_M).round() as i32);
        (((x + step[0]).rem_euclid(3) + 3 * (z + step[2]).rem_euclid(3)) as usize * n) + c.twin as usize
    };
    let mut edges = Vec::new();
    for (x, z) in (0..9).map(|i| (i % 3, i / 3)) {
        edges.extend(tile.links.iter().map(|l| (node(x, z, l.from), node(x, z, l.to))));
    }
    let nodes: BTreeSet<usize> = edges.iter().flat_map(|&(a, b)| [a, b]).collect();
    let begins = tile.cells.iter().filter(|c| !c.has_flags(CellRecord::IS_EXIT)).count();
    assert_eq!(nodes.len(), 9 * begins, "every entry and rest is used");
    let backwards: Vec<_> = edges.iter().map(|&(a, b)| (b, a)).collect();
    for edges in [&edges, &backwards] {
        assert_eq!(reached(9 * n, edges, edges[0].0).len(), nodes.len());
    }
}

fn reached(num_nodes: usize, edges: &[(usize, usize)], from: usize) -> BTreeSet<usize> {
    let mut next = vec![Vec::new(); num_nodes];
    for &(a, b) in edges {
        next[a].push(b);
    }
    let (mut seen, mut open) = (BTreeSet::from([from]), vec![from]);
    while let Some(a) = open.pop() {
        open.extend(next[a].iter().copied().filter(|&b| seen.insert(b)));
    }
    seen
}

#[test]
fn the_same_motion_makes_the_same_tile_whatever_the_threads() {
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = alone.install(|| built(&WALK.0, &WALK.1, &panel(), &with_tile(TileConfig::for_unit("panel"))).unwrap());
    assert!(again == *TILE);
}

/// The walk, but for the frames that somebody does not want.
fn walk_without(unwanted: impl Fn(&throng_precompute::clip::Clip, usize) -> bool) -> (ClipSet, PoseGroups) {
    let mut clips = WALK.0.clone();
    for clip in &mut clips.clips {
        let ranges = (0..clip.num_frames()).filter(|&f| unwanted(clip, f)).map(|f| f..f + 1);
        clip.excluded = ranges.map(|range| Exclusion { range, reason: ExclusionReason::Sidecar }).collect();
    }
    let starts = clips.frame_starts();
    let mut groups = WALK.1.clone();
    for (c, clip) in clips.clips.iter().enumerate() {
        for f in (0..clip.num_frames()).filter(|&f| !clip.is_usable(f)) {
            groups.groups[starts[c] as usize + f] = NO_GROUP;
        }
    }
    (clips, groups)
}

/// Planar speed of the root (m/s).
fn speed(clip: &throng_precompute::clip::Clip, f: usize) -> f32 {
    let (a, b) = (clip.planar(f.max(1) - 1), clip.planar(f.max(1)));
    (b.x - a.x).hypot(b.z - a.z) * 30.0
}

#[test]
fn walking_that_turns_to_one_side_only_leads_everywhere_through_further_tiles() {
    // Nobody turns left but on the spot.
    let turns = |clip: &throng_precompute::clip::Clip, f: usize| {
        speed(clip, f) > 0.5
            && f + 15 < clip.num_frames()
            && wrap_angle(clip.planar(f + 15).heading - clip.planar(f).heading) > 0.35
    };
    let (clips, groups) = walk_without(turns);
    let patches = built(&clips, &groups, &panel(), &with_tile(TileConfig::for_unit("panel"))).unwrap();
    assert_eq!(patches.report[0].freedom, Freedom::FurtherTiles);
    let tile = &patches.patches[0];
    check_torus(tile);
    for edge in 0..4 {
        assert!(tile.cells.iter().any(|c| c.has_flags(CellRecord::IS_ENTRY) && c.edge == edge), "{edge}");
    }
    assert!(tile.cells.iter().any(|c| c.has_flags(CellRecord::IS_REST)));
    assert_eq!(TILE.report[0].freedom, Freedom::EachTile);
}

#[test]
fn nobody_sits_where_there_is_no_seat() {
    let (mut clips, groups) = WALK.clone();
    let starts = clips.frame_starts();
    let mut seats = BTreeSet::new();
    for (c, clip) in clips.clips.iter_mut().enumerate().filter(|(c, _)| c % 2 == 0) {
        for f in (0..clip.num_frames()).filter(|&f| speed(clip, f) < 0.05).collect::<Vec<_>>() {
            clip.root_positions[f].y *= 0.5;
            seats.insert(starts[c] + f as u32);
        }
    }
    let patches = built(&clips, &groups, &panel(), &with_tile(TileConfig::for_unit("panel"))).unwrap();
    assert!(seats.len() > 1000 && !patches.patches[0].links.is_empty());
    // Those who move while they are low, and so do not sit, may be part of a way, but not for a second.
    let seated = |l: &LinkRecord| seats.range(l.frame..l.frame + u32::from(l.num_frames)).count();
    let longest = patches.patches[0].links.iter().map(seated).max();
    assert!(longest < Some(30), "{longest:?}");
}

#[test]
fn walking_that_never_stops_is_refused() {
    let (clips, groups) = walk_without(|clip, f| speed(clip, f) < 0.2);
    let error = built(&clips, &groups, &panel(), &with_tile(TileConfig::for_unit("panel"))).unwrap_err().to_string();
    assert!(error.contains("`panel`") && error.contains("no walking that stops"), "{error}");
}

#[test]
fn gliding_straight_on_is_refused_with_the_direction_that_is_missing() {
    let clips = set_of(vec![Glide { frames: 300, speed_mps: 1.2, ..Glide::default() }.clip("straight")]);
    let groups = groups_of(&clips, |_, f| (f % 10) as u32);
    let config = with_tile(TileConfig { rest_spots: 1, ..TileConfig::for_unit("panel") });
    let error = built(&clips, &groups, &panel(), &config).unwrap_err().to_string();
    let (lack, motion) = ("no entry can leave back across the same edge", "Add walks that turn round within 3.0 m");
    assert!(error.contains("`panel`") && error.contains(lack) && error.contains(motion), "{error}");
}

#[test]
fn units_and_clips_that_are_not_there_are_named() {
    let clips = set_of(vec![Glide::default().clip("straight")]);
    let groups = groups_of(&clips, |_, _| 0);
    let refusal = |tile: TileConfig| built(&clips, &groups, &panel(), &with_tile(tile)).unwrap_err().to_string();
    let error = refusal(TileConfig::for_unit("pannel"));
    assert!(error.contains("`pannel`") && error.contains("`panel`, `rug`"), "{error}");
    assert!(refusal(TileConfig::for_unit("rug")).contains("`rug` has no edges"));
    let error = refusal(TileConfig { clips: vec!["walk_*".into()], ..TileConfig::for_unit("panel") });
    assert!(error.contains("walk_*"), "{error}");
}

/// A flight of three copies of a ramp of 1.4 m by 0.7 m, and a character that glides up it, 14 frames a copy.
fn ramp() -> (ClipSet, PoseGroups, Vec<Option<CaptureSetting>>, UnitSet) {
    let edges = TileEdges { steps: vec![[0.0, 0.7, 1.4]], widths: vec![1.2], centre: [0.0, 0.35, 0.7] };
    let units = UnitSet { units: vec![unit("ramp", Some(edges))] };
    let world = Placement::new(2.0, 0.5, -1.0, FRAC_PI_2);
    let copy = |i: usize| {
        let up = i as f32;
        PlacedUnit { unit: 0, placement: world.compose(Placement::new(0.0, 0.7 * up, 1.4 * up, 0.0)) }
    };
    let environment = Environment { name: "flight".into(), units: (0..3).map(copy).collect() };
    let start = world.compose(Placement::new(0.0, 0.0, -0.7, 0.0));
    let mut clip = Glide { start: start.planar(), frames: 56, speed_mps: 3.0, ..Glide::default() }.clip("up");
    clip.support = (0..56).map(|f| world.y + (0.1 * f as f32 - 0.7) * 0.5).collect();
    for (root, support) in clip.root_positions.iter_mut().zip(&clip.support) {
        root.y += support;
    }
    let clips = set_of(vec![clip]);
    let groups = groups_of(&clips, |_, f| (f % 14) as u32);
    let settings = vec![Some(CaptureSetting { environment, units_of: vec![Vec::new(); 56] })];
    (clips, groups, settings, units)
}

#[test]
fn a_rising_tile_is_climbed_from_copy_to_copy() {
    let (clips, groups, settings, units) = ramp();
    let tile = TileConfig { slots: 1, headings: 0, ..TileConfig::for_unit("ramp") };
    let config = PatchConfig { min_link_frames: 10, max_link_frames: 20, ..with_tile(tile) };
    let patches = patch::build(&clips, &groups, &settings, &config, &units, &Silent).unwrap();
    let tile = &patches.patches[0];
    assert!(!tile.links.is_empty());
    for l in &tile.links {
        let (from, to) = (&tile.cells[l.from as usize], &tile.cells[l.to as usize]);
        assert!(
            from.has_flags(CellRecord::IS_ENTRY) && from.edge == 1 && to.has_flags(CellRecord::IS_EXIT) && to.edge == 0
        );
        // The frame beside the edge may be moved onto it.
        assert!((13..=15).contains(&l.num_frames), "{}", l.num_frames);
        assert!((from.placement.z.abs() < 1e-4) && (to.placement.z - 1.4).abs() < 1e-4);
        // Heights are not edited: a frame beside the edge is one frame's rise off.
        assert!((to.placement.y - from.placement.y - 0.7).abs() < 0.06, "{:?} {:?}", from.placement, to.placement);
        // The hips are where the cells say.
        let first = l.frame as usize;
        let hips = |k: usize| clips.clips[0].root_positions[first + k].y;
        assert!((l.start.y + hips(0) - from.placement.y).abs() < 0.01);
        assert!((l.end.y + hips(usize::from(l.num_frames)) - to.placement.y).abs() < 0.01);
    }
    let entries = tile.cells.iter().filter(|c| c.has_flags(CellRecord::IS_ENTRY));
    assert!(entries.clone().count() > 0);
    for e in entries {
        assert!((e.placement.y - tile.cells[e.twin as usize].placement.y + 0.7).abs() < 1e-4);
    }
}

#[test]
fn mirrored_copies_of_motion_in_an_environment_are_not_laid_on_level_ground() {
    let (mut clips, _, mut settings, _) = ramp();
    let mut copy = clips.clips[0].clone();
    (copy.name, copy.mirrored) = ("up~mirror".into(), true);
    clips.clips.push(copy);
    settings.push(None);
    settings[0].as_mut().unwrap().environment.units.clear();
    let groups = groups_of(&clips, |_, f| (f % 14) as u32);
    let config = with_tile(TileConfig::for_unit("panel"));
    let error = patch::build(&clips, &groups, &settings, &config, &panel(), &Silent).unwrap_err().to_string();
    assert!(error.contains("a clip captured in no environment"), "{error}");
}

/// A tile of a few entries and rests with random links.
fn random_graph(seed: u64, density: f64) -> TileGraph {
    let mut rng = Pcg64::seed_from_u64(seed);
    let (ground, per_edge, rests) = (rng.random_bool(0.7), rng.random_range(1..4u32), rng.random_range(0..3));
    let num_edges = if ground { 4 } else { 2 };
    let entries = num_edges * per_edge;
    let mut cells: Vec<TileCell> = (0..entries).map(|i| TileCell::Entry(i / per_edge)).collect();
    cells.extend((0..entries).map(|i| TileCell::Exit((i / per_edge) ^ 1, i)));
    cells.extend((0..rests).map(|_| TileCell::Rest));
    let mut links = Vec::new();
    for (from, a) in cells.iter().enumerate().filter(|(_, c)| !matches!(c, TileCell::Exit(..))) {
        for (to, b) in cells.iter().enumerate().filter(|(_, c)| !matches!(c, TileCell::Entry(_))) {
            let far = !ground && matches!((a, b), (TileCell::Entry(e), TileCell::Exit(x, _)) if e == x);
            if !far && rng.random_bool(density) {
                links.push((from as u32, to as u32));
            }
        }
    }
    let all: Vec<u32> = (0..num_edges).collect();
    TileGraph {
        cells,
        links,
        exit_edges: all.iter().map(|&e| if ground { all.clone() } else { vec![e ^ 1] }).collect(),
        must_rest: ground && rests > 0,
        together: if ground { vec![all] } else { all.iter().map(|&e| vec![e]).collect() },
    }
}

/// Links that are left, by trying everything again after every single change.
fn naive_prune(g: &TileGraph, freedom: Freedom) -> Vec<bool> {
    let node = |c: u32| if let TileCell::Exit(_, twin) = g.cells[c as usize] { twin } else { c };
    let mut left = vec![true; g.links.len()];
    loop {
        let before = left.clone();
        let strict = freedom == Freedom::EachTile;
        while let Some(stuck) = (0..g.cells.len() as u32).find(|&i| strict && is_stuck(g, &left, i)) {
            for (l, &(from, to)) in g.links.iter().enumerate() {
                left[l] &= from != stuck && node(to) != stuck;
            }
        }
        let alive = || g.links.iter().zip(&left).filter(|(_, l)| **l).map(|(&(a, b), _)| (node(a), node(b)));
        let edges: Vec<(usize, usize)> = alive().map(|(a, b)| (a as usize, b as usize)).collect();
        let from: Vec<BTreeSet<usize>> = (0..g.cells.len()).map(|i| reached(g.cells.len(), &edges, i)).collect();
        let component = |i: usize| -> Vec<usize> {
            (0..g.cells.len()).filter(|&j| from[i].contains(&j) && from[j].contains(&i)).collect()
        };
        let mut kept = BTreeSet::new();
        for edges_together in &g.together {
            let mut best: Vec<usize> = Vec::new();
            for i in 0..g.cells.len() {
                let c = component(i);
                let has = |cell: TileCell| c.iter().any(|&n| g.cells[n] == cell);
                let whole = edges_together.iter().all(|&e| has(TileCell::Entry(e)));
                let lives = edges.iter().any(|(a, b)| c.contains(a) && c.contains(b));
                if lives && whole && (!g.must_rest || has(TileCell::Rest)) && c.len() > best.len() {
                    best = c;
                }
            }
            kept.extend(best.iter().map(|&n| (n, best[0])));
        }
        let home = |n: u32| kept.iter().find(|k| k.0 == n as usize).map(|k| k.1);
        for (l, &(a, b)) in g.links.iter().enumerate() {
            left[l] &= home(node(a)).is_some() && home(node(a)) == home(node(b));
        }
        if left == before {
            return left;
        }
    }
}

/// True for an entry that is still in use and misses a way out or rest.
fn is_stuck(g: &TileGraph, left: &[bool], cell: u32) -> bool {
    let TileCell::Entry(edge) = g.cells[cell as usize] else { return false };
    let links = || g.links.iter().zip(left).filter(|(_, l)| **l).map(|(l, _)| *l);
    let exit = g.cells.iter().position(|c| matches!(c, TileCell::Exit(_, twin) if *twin == cell)).unwrap() as u32;
    let used = links().any(|(a, b)| a == cell || b == exit);
    let leads = |fits: &dyn Fn(TileCell) -> bool| links().any(|(a, b)| a == cell && fits(g.cells[b as usize]));
    let free = g.exit_edges[edge as usize].iter().all(|&way| leads(&|c| matches!(c, TileCell::Exit(e, _) if e == way)));
    used && !(free && (!g.must_rest || leads(&|c| c == TileCell::Rest)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn pruning_ends_where_trying_everything_ends(seed in any::<u64>(), density in 0.1f64..0.9, strict in any::<bool>()) {
        let graph = random_graph(seed, density);
        let freedom = if strict { Freedom::EachTile } else { Freedom::FurtherTiles };
        let pruned = prune(&graph, freedom);
        prop_assert_eq!(&pruned.links, &naive_prune(&graph, freedom));
        let gone = pruned.links.iter().filter(|l| !**l).count();
        prop_assert_eq!(pruned.directions + pruned.component, gone);
        for (l, &(a, b)) in graph.links.iter().enumerate().filter(|(l, _)| pruned.links[*l]) {
            prop_assert!(pruned.cells[a as usize] && pruned.cells[b as usize], "link {l} has its cells");
        }
    }
}

#[test]
fn headings_of_entries_spread_about_straight_ahead() {
    let tile = &TILE.patches[0];
    for c in tile.cells.iter().filter(|c| c.has_flags(CellRecord::IS_ENTRY)) {
        let step = tile.edges[c.edge as usize].step;
        let ahead = (-step[0]).atan2(-step[2]);
        assert!(wrap_angle(c.placement.heading - ahead).abs() < PI / 6.0 + 1e-3);
        assert!((c.placement.x * step[0] + c.placement.z * step[2] - PANEL_M * PANEL_M / 2.0).abs() < 1e-3);
    }
}

/// Walking, and what two people do together, of whom some lack what it takes.
fn with_partners() -> (ClipSet, PoseGroups) {
    let config = SynthConfig { minutes: 0.5, ..SynthConfig::for_set(SynthSet::Office) };
    let made =
        resample::resample(&synth::make_set(SynthSet::Office, &config).unwrap(), &ResampleConfig::default()).unwrap();
    let (mut clips, mut groups) = (WALK.0.clone(), WALK.1.clone());
    let pairs: Vec<_> = made.clips.into_iter().filter(|c| c.name.starts_with("office_pair") && !c.mirrored).collect();
    let mut longer = pairs[..2].to_vec();
    let (root, contact) = (*longer[1].root_positions.last().unwrap(), *longer[1].contacts.last().unwrap());
    longer[1].root_positions.push(root);
    let last = longer[1].rotations[longer[1].rotations.len() - throng_core::NUM_JOINTS..].to_vec();
    longer[1].rotations.extend(last);
    longer[1].contacts.push(contact);
    let mut unnamed = pairs[..2].to_vec();
    unnamed[1].tags.clear();
    let mut near = pairs[..2].to_vec();
    near[1].root_positions.iter_mut().for_each(|p| p.z -= 0.7);
    for (what, mut two) in [("longer", longer), ("unnamed", unnamed), ("near", near)] {
        two.iter_mut().zip(["a", "b"]).for_each(|(c, who)| c.name = format!("{what}_{who}"));
        clips.clips.extend(two);
    }
    clips.clips.push(Clip { name: "alone_a".into(), ..pairs[0].clone() });
    clips.clips.extend(pairs);
    groups.groups.resize(clips.num_frames(), NO_GROUP);
    (clips, groups)
}

#[test]
fn two_who_were_captured_together_stand_across_an_edge_as_they_did() {
    let (clips, groups) = with_partners();
    let names = ["longer", "unnamed", "near", "alone"].map(|n| format!("{n}*"));
    let patterns = std::iter::once("office_pair_*".to_owned()).chain(names);
    let pairs = patterns.map(|p| [format!("{p}_a"), format!("{p}_b")]);
    let walks = vec!["walk_*".to_owned()];
    let tile = TileConfig { clips: walks, pairs: pairs.collect(), ..TileConfig::for_unit("panel") };
    let built = built(&clips, &groups, &panel(), &with_tile(tile)).unwrap();
    let (patch, report) = (&built.patches[0], &built.report[0].pairs);
    let found: Vec<&str> = report.iter().filter(|r| r.refused.is_none()).map(|r| r.tag.as_str()).collect();
    assert_eq!(found, ["chat", "dispute", "handshake", "handover", "dance"], "{report:?}");
    assert!(report.iter().filter(|r| r.refused.is_none()).all(|r| r.edges == 4), "{report:?}");
    let why =
        |name: &str| report.iter().find(|r| r.clips[0].starts_with(name)).and_then(|r| r.refused.clone()).unwrap();
    for (name, reason) in [
        ("longer", "equally long"),
        ("unnamed", "no tag names what both do"),
        ("near", "begin 0.3 to 2 m apart, found 0.18 m"),
        ("alone", "expected a clip `alone_b`, found none"),
    ] {
        assert!(why(name).contains(reason), "{name}: {}", why(name));
    }
    assert_eq!(patch.pairs.len(), 5 * 4);
    // Brute force: where each frame of both lies, beside where the clips have it.
    let starts = clips.frame_starts();
    let placed_frame = |l: &LinkRecord, k: u32| {
        let c = starts.partition_point(|&s| s <= l.frame) - 1;
        let place = |k: u32| clips.clips[c].planar((l.frame - starts[c] + k) as usize);
        let [first, here, last] = [0, k, u32::from(l.num_frames)].map(place);
        let [at, end] = [here, last].map(|p| l.start.planar().compose(first.to_local(p)));
        let share = k as f32 / f32::from(l.num_frames);
        let missing = [l.end.x - end.x, l.end.z - end.z, wrap_angle(l.end.heading - end.heading)];
        assert!(missing.iter().all(|m| m.abs() < 1e-4), "nothing is edited: {missing:?}");
        (Planar::new(at.x + share * missing[0], at.z + share * missing[1], at.heading + share * missing[2]), here)
    };
    for p in &patch.pairs {
        let [own, other] = [p.link, p.partner_link].map(|l| &patch.links[l as usize]);
        assert!(own.is_for_two() && own.tag == other.tag && own.num_frames == other.num_frames);
        let [x, _, z] = patch.edges[p.edge as usize].step;
        for k in 0..=u32::from(own.num_frames) {
            let ((a, captured_a), (b, captured_b)) = (placed_frame(own, k), placed_frame(other, k));
            for at in [a, b] {
                assert!(at.x.abs().max(at.z.abs()) < PANEL_M / 2.0 - 0.1, "each stays on ground of its own: {at:?}");
            }
            let is = a.to_local(Planar::new(b.x + x, b.z + z, b.heading));
            let was = captured_a.to_local(captured_b);
            let off = (is.x - was.x).hypot(is.z - was.z).max(wrap_angle(is.heading - was.heading).abs());
            assert!(off < 1e-4, "{off} at frame {k} of {p:?}");
            assert!(
                was.x.hypot(was.z) < 1.3 && (wrap_angle(was.heading).abs() - PI).abs() < 0.3,
                "face to face: {was:?}"
            );
        }
        for (l, end) in [(own, own.from), (own, own.to), (other, other.from), (other, other.to)] {
            let cell = &patch.cells[end as usize];
            assert!(cell.has_flags(CellRecord::IS_REST), "one can wait there");
            let near = if end == l.from { l.start } else { l.end };
            let off = (cell.placement.x - near.x).hypot(cell.placement.z - near.z);
            assert!(off < 0.03 + 1e-4, "{off} m from the place of rest");
        }
    }
    // Nobody does alone what two do, and everybody can come and go.
    for l in patch.links.iter().filter(|l| l.tag != 0 && !l.is_for_two()) {
        assert!(patch.pairs.iter().all(|p| patch.links[p.link as usize].from != l.from));
    }
}
