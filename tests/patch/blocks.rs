//! Building blocks: found where motion belongs to units, equal wherever they stand, and every sub-sequence a chain of
//! links.

use super::glides::{Glide, clip_of, groups_of, set_of};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::f32::consts::TAU;
use throng_core::Planar;
use throng_core::patch::{CellRecord, KIND_BLOCK, Placement};
use throng_core::planar::wrap_angle;
use throng_precompute::clip::ClipTag;
use throng_precompute::environment::{Environment, PlacedUnit, TileEdges, UnitObject, UnitSet};
use throng_precompute::patch::{self, CaptureSetting, PatchConfig, RawPatches};
use throng_precompute::progress::Silent;
use throng_precompute::{Clip, ClipSet};

const GROUND: usize = 0;
const TABLE: usize = 1;
const DOOR: usize = 2;

fn units() -> UnitSet {
    let edges = TileEdges { steps: vec![[3.0, 0.0, 0.0], [0.0, 0.0, 3.0]], widths: vec![3.0; 2], centre: [0.0; 3] };
    let unit = |name: &str, symmetry, tile: Option<TileEdges>| UnitObject {
        name: name.into(),
        shapes: Vec::new(),
        region: None,
        symmetry,
        floor: tile.is_some(),
        tile,
    };
    UnitSet { units: vec![unit("ground", 4, Some(edges)), unit("table", 4, None), unit("door", 1, None)] }
}

fn setting(placed: &[(usize, Placement)], units_of: Vec<Vec<u32>>) -> Option<CaptureSetting> {
    let units = placed.iter().map(|&(unit, placement)| PlacedUnit { unit, placement }).collect();
    Some(CaptureSetting { environment: Environment { name: "room".into(), units }, units_of })
}

fn built(
    clips: &ClipSet,
    group: impl Fn(usize, usize) -> u32,
    settings: &[Option<CaptureSetting>],
    config: &PatchConfig,
) -> RawPatches {
    patch::build(clips, &groups_of(clips, group), settings, config, &units(), &Silent).unwrap()
}

#[test]
fn motion_from_different_places_gathers_in_one_block() {
    // The same motion by a table with a door beside it, twice: the second time elsewhere, turned, and listed the other
    // way round, with the table turned once more by its symmetry.
    let moved = Placement::new(5.0, 1.0, -2.0, 2.0);
    let (table, door) = (Placement::new(1.0, 0.0, 0.5, 0.3), Placement::new(2.0, 0.0, 0.5, 0.1));
    let quarter = Placement::new(0.0, 0.0, 0.0, TAU / 4.0);
    let here = Glide { frames: 60, ..Glide::default() };
    let there = Glide { start: moved.planar(), ..here };
    let clips = set_of(vec![here.clip("here"), there.clip("there")]);
    let belongs = |first: u32| (0..60).map(|f| if f < 30 { vec![first] } else { vec![1 - first] }).collect();
    let settings = [
        setting(&[(TABLE, table), (DOOR, door)], belongs(0)),
        setting(&[(DOOR, moved.compose(door)), (TABLE, moved.compose(table.compose(quarter)))], belongs(1)),
    ];
    let config = PatchConfig { block_units: vec![2], ..PatchConfig::default() };
    // The ground of the second clip is 1 m below its door.
    let mut raised = clips.clone();
    raised.clips[1].root_positions.iter_mut().for_each(|p| p.y += 1.0);
    raised.clips[1].support = vec![1.0; 60];
    let patches = built(&raised, |_, f| f as u32 / 4, &settings, &config);
    assert_eq!(patches.patches.len(), 1, "{:?}", patches.report);
    assert_eq!((patches.report[0].segments, patches.report[0].frames), (2, 120));
    let alone = built(&set_of(vec![clips.clips[0].clone()]), |_, f| f as u32 / 4, &settings[..1], &config);
    let cells = |p: &RawPatches| p.patches[0].cells.len();
    assert_eq!(cells(&patches), cells(&alone), "the second motion lies in the cells of the first");
    assert_eq!(patches.patches[0].name, "table+door");
    assert_eq!(patches.patches[0].kind, KIND_BLOCK);
    assert_eq!(patches.patches[0].units[0].1, Placement::IDENTITY);
}

#[test]
fn other_arrangements_are_other_blocks_with_names_of_their_own() {
    let clips = set_of(vec![Glide::default().clip("a"), Glide::default().clip("b"), Glide::default().clip("c")]);
    let belongs: Vec<Vec<u32>> = (0..100).map(|f| vec![u32::from(f >= 50)]).collect();
    let beside = |x: f32, heading: f32| {
        setting(&[(TABLE, Placement::IDENTITY), (DOOR, Placement::new(x, 0.0, 0.0, heading))], belongs.clone())
    };
    let settings = [beside(1.0, 0.0), beside(1.06, 0.0), beside(1.0, 0.07)];
    let patches = built(&clips, |_, _| 0, &settings, &PatchConfig::default());
    let names: Vec<&str> = patches.patches.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["table", "door", "table+door", "table+door 2", "table+door 3"]);
}

#[test]
fn ground_panels_are_left_to_the_tiles() {
    let clips = set_of(vec![Glide::default().clip("a")]);
    let belongs = (0..100).map(|f| if f < 40 { vec![0] } else { vec![0, 1] }).collect();
    let settings = [setting(&[(GROUND, Placement::IDENTITY), (TABLE, Placement::new(0.0, 0.0, 2.0, 0.0))], belongs)];
    let patches = built(&clips, |_, _| 0, &settings, &PatchConfig::default());
    let found: Vec<_> = patches.report.iter().map(|r| (r.name.as_str(), r.segments, r.frames)).collect();
    assert_eq!(found, [("table", 1, 60)]);
}

#[test]
fn who_stands_still_may_stay_and_levels_are_apart() {
    // Up a ladder: the same place on the ground and the same pose at two heights.
    let mut clip = clip_of("ladder", &[Planar::IDENTITY; 100]);
    clip.support = (0..100).map(|f| if f < 50 { 0.0 } else { 0.3 }).collect();
    clip.root_positions.iter_mut().zip(&clip.support).for_each(|(p, s)| p.y += s);
    clip.tags = vec![ClipTag { name: "hold".into(), range: 50..100 }];
    let settings = [setting(&[(DOOR, Placement::IDENTITY)], vec![vec![0]; 100])];
    let patches = built(&set_of(vec![clip]), |_, _| 0, &settings, &PatchConfig::default());
    let patch = &patches.patches[0];
    let mut heights: Vec<f32> = patch.cells.iter().map(|c| c.placement.y).collect();
    heights.sort_by(f32::total_cmp);
    assert_eq!(heights.len(), 2);
    assert!((heights[0] - 0.95).abs() < 1e-4 && (heights[1] - 1.25).abs() < 1e-4, "{heights:?}");
    assert!(patch.cells.iter().all(|c| c.has_flags(CellRecord::IS_REST)));
    assert_eq!(patches.link_tags, ["hold"]);
    assert!(patch.links.iter().any(|l| l.tag == 1) && patch.links.iter().any(|l| l.tag == 0));
    assert!(patch.bounds[0][1] <= 0.1 && patch.bounds[1][1] > 1.5, "{:?}", patch.bounds);
}

/// A walk on a coarse lattice that comes back to the same cells now and then.
fn lattice_walk(steps: &[(u8, u8)]) -> (Clip, Vec<u32>) {
    let at = |s: u8| Planar::new(0.05 + 0.1 * f32::from(s % 3), 0.05 + 0.1 * f32::from(s / 3), 0.0);
    (
        clip_of("lattice", &steps.iter().map(|s| at(s.0)).collect::<Vec<_>>()),
        steps.iter().map(|s| u32::from(s.1)).collect(),
    )
}

/// All pairs that chains of the given pairs join.
fn closure(pairs: &BTreeSet<(usize, usize)>) -> BTreeSet<(usize, usize)> {
    let mut all = pairs.clone();
    loop {
        let more: Vec<_> =
            all.iter().flat_map(|&(a, b)| pairs.range((b, 0)..=(b, usize::MAX)).map(move |&(_, c)| (a, c))).collect();
        let before = all.len();
        all.extend(more);
        if all.len() == before {
            return all;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn chains_of_links_reach_what_arbitrary_sub_sequences_reach(
        steps in prop::collection::vec((0u8..9, 0u8..2), 10..40), gap in 5usize..35
    ) {
        let (clip, groups) = lattice_walk(&steps);
        let config = PatchConfig {
            min_link_frames: 4,
            max_link_frames: 8,
            block_units: vec![1],
            ..PatchConfig::default()
        };
        // The unit is left for one frame, which makes two segments.
        let belongs: Vec<Vec<u32>> = (0..steps.len()).map(|f| if f == gap { vec![] } else { vec![0] }).collect();
        let clips = set_of(vec![clip]);
        let settings = [setting(&[(DOOR, Placement::IDENTITY)], belongs.clone())];
        let patches = built(&clips, |_, f| groups[f], &settings, &config);
        let mut wanted = BTreeSet::new();
        let number = |f: usize| usize::from(steps[f].0) * 2 + groups[f] as usize;
        for a in 0..steps.len() {
            for b in a + 4..steps.len() {
                if (a..=b).all(|f| f != gap) {
                    wanted.insert((number(a), number(b)));
                }
            }
        }
        let mut found = BTreeSet::new();
        for p in &patches.patches {
            let named: BTreeMap<u32, usize> = p.cells.iter().enumerate().map(|(i, c)| {
                let at = |v: f32| ((v - 0.05) / 0.1).round() as usize;
                (i as u32, (at(c.placement.x) + 3 * at(c.placement.z)) * 2 + c.group as usize)
            }).collect();
            prop_assert_eq!(named.values().collect::<BTreeSet<_>>().len(), p.cells.len(), "cells are apart");
            found.extend(p.links.iter().map(|l| (named[&l.from], named[&l.to])));
            for l in &p.links {
                // As captured: nothing is edited.
                let clip = &clips.clips[0];
                for (frame, place) in [(l.frame, l.start), (l.frame + u32::from(l.num_frames), l.end)] {
                    let at = clip.planar(frame as usize);
                    prop_assert!((at.x - place.x).hypot(at.z - place.z) < 1e-5 && place.y == 0.0);
                    prop_assert!(wrap_angle(at.heading - place.heading).abs() < 1e-5);
                }
                prop_assert!((4..8).contains(&l.num_frames));
            }
        }
        prop_assert_eq!(closure(&found), closure(&wanted));
        let stays: usize = patches.patches.iter().flat_map(|p| &p.cells).filter(|c| c.has_flags(CellRecord::IS_REST)).count();
        prop_assert_eq!(stays, found.iter().filter(|(a, b)| a == b).count());
    }
}
