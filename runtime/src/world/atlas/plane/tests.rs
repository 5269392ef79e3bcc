//! Tables of made-up tiles against plain Dijkstra on a wide plane.

use super::*;
use crate::patch::{EdgeRecord, KIND_TILE, LinkRecord, PatchRecord, Placement};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// A tile with an entry and an exit an edge (cells 0 to 3 and 4 to 7) and two cells inside, and its links.
struct Tile {
    patch: PatchRecord,
    edges: Vec<EdgeRecord>,
    cells: Vec<CellRecord>,
    links: Vec<LinkRecord>,
}

const STEPS: [[i32; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

impl Tile {
    fn new(links: &[(u32, u32, u16)]) -> Self {
        let cell = |edge, twin, flags| CellRecord {
            placement: Placement::IDENTITY,
            group: 0,
            edge,
            twin,
            flags,
            first_link: 0,
            num_links: 0,
            reserved: [0; 2],
        };
        let mut cells: Vec<_> = (0..4).map(|e| cell(e, 4 + (e ^ 1), CellRecord::IS_ENTRY)).collect();
        cells.extend((0..4).map(|e| cell(e, e ^ 1, CellRecord::IS_EXIT)));
        cells.extend([cell(NONE, NONE, 0); 2]);
        let link = |&(from, to, num_frames): &(u32, u32, u16)| LinkRecord {
            from,
            to,
            frame: 0,
            num_frames,
            tag: 0,
            start: Placement::IDENTITY,
            end: Placement::IDENTITY,
        };
        let edge = |e: usize| EdgeRecord {
            step: [2.0 * STEPS[e][0] as f32, 0.0, 2.0 * STEPS[e][1] as f32],
            opposite: e as u32 ^ 1,
        };
        let patch = PatchRecord {
            kind: KIND_TILE,
            first_cell: 0,
            num_cells: 10,
            first_link: 0,
            num_links: links.len() as u32,
            first_edge: 0,
            num_edges: 4,
            reserved: 0,
            min: [-1.0; 3],
            max: [1.0; 3],
        };
        Self { patch, edges: (0..4).map(edge).collect(), cells, links: links.iter().map(link).collect() }
    }

    fn plane(&self) -> Option<Plane> {
        let patches = Patches {
            patches: std::slice::from_ref(&self.patch),
            edges: &self.edges,
            cells: &self.cells,
            links: &self.links,
        };
        Plane::new(&patches, 0, &mut Dial::default())
    }

    /// Least frames from a cell to all others, on a wide plane.
    fn dijkstra(&self, from: u32) -> BTreeMap<([i32; 2], u32), u32> {
        let (mut queue, mut found) = (BTreeSet::from([(0, ([0, 0], from))]), BTreeMap::new());
        while let Some((frames, (at, cell))) = queue.pop_first() {
            if at.iter().any(|a: &i32| a.abs() > 8) || found.contains_key(&(at, cell)) {
                continue;
            }
            found.insert((at, cell), frames);
            for l in self.links.iter().filter(|l| l.from == cell) {
                let to = &self.cells[l.to as usize];
                let next = match to.edge {
                    NONE => (at, l.to),
                    e => ([at[0] + STEPS[e as usize][0], at[1] + STEPS[e as usize][1]], to.twin),
                };
                queue.insert((frames + u32::from(l.num_frames), next));
            }
        }
        found
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn costs_are_those_of_plain_dijkstra(links in proptest::collection::vec((0usize..6, 0u32..6, 20u16..60), 8..24)) {
        // From entries and the inside, to exits and the inside.
        let links: Vec<_> = links.iter().map(|&(f, t, n)| ([0, 1, 2, 3, 8, 9][f], 4 + t, n)).collect();
        let tile = Tile::new(&links);
        let plane = tile.plane().unwrap();
        for from in [0, 1, 2, 3, 8, 9] {
            let found = tile.dijkstra(from);
            for way in offsets(RADIUS).filter(|o| o[0].abs().max(o[1].abs()) <= 2) {
                for c in 0..5 {
                    let ends = |cell: u32| cell < 4 && cell == c || cell >= 8 && c == 4;
                    let costs = found.iter().filter(|((at, cell), _)| *at == way && ends(*cell)).map(|(_, f)| *f);
                    let best = costs.min().map_or(f32::INFINITY, |f| f as f32);
                    let cost = plane.cost(plane.look(c, way), from);
                    // A longer one than this might lead beyond the rim, which is 9 copies away, and back: there only the
                    // bound is known.
                    let around = 20.0 * (2 * (RADIUS + MARGIN + 1) - 2) as f32;
                    let fits = if best < around { cost == best } else { cost <= best };
                    prop_assert!(fits, "{} to {} {:?}: {} {}", from, c, way, cost, best);
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn far_ways_cost_no_less_than_their_bounds(links in proptest::collection::vec((0usize..6, 0u32..6, 20u16..60), 8..24)) {
        let links: Vec<_> = links.iter().map(|&(f, t, n)| ([0, 1, 2, 3, 8, 9][f], 4 + t, n)).collect();
        let tile = Tile::new(&links);
        let mut plane = tile.plane().unwrap();
        let parts = [1, 9].map(|cell| plane.rows_to(cell, &mut Dial::default()));
        let rows = plane.join(&[(&parts[0], 13), (&parts[1], 0)]);
        plane.add(rows);
        for from in [0, 2, 8] {
            let found = tile.dijkstra(from);
            for way in offsets(8) {
                for goal in 0..6u32 {
                    let part = |cell: u32| plane.cells(goal).iter().find(|c| c.0 == cell).map(|c| u32::from(c.1));
                    let there = found.iter().filter(|((at, _), _)| *at == way);
                    let costs = there.filter_map(|((_, cell), f)| Some(*f + part(*cell)?));
                    let best = costs.min().map_or(f32::INFINITY, |f| f as f32);
                    let bound = plane.cost(plane.look(goal, way), from);
                    prop_assert!(bound <= best, "{} to goal {} {:?}: {} {}", from, goal, way, bound, best);
                }
            }
        }
    }
}

/// Straight on in 50 frames, around a corner in 40.
fn crossed_in(straight: u16, corner: u16) -> Tile {
    let pairs = (0..4u32).flat_map(|from| (0..4u32).filter(move |&to| to != from).map(move |to| (from, to)));
    let link = |(from, to): (u32, u32)| (from, 4 + to, if to == from ^ 1 { straight } else { corner });
    Tile::new(&pairs.map(link).collect::<Vec<_>>())
}

#[test]
fn far_ways_go_on_as_near_ones_do() {
    let plane = crossed_in(50, 40).plane().unwrap();
    // Cell 1 was entered from -x and goes on to +x.
    let cost = plane.cost(plane.look(1, [30, 0]), 1);
    assert!((1485.0..=1500.0).contains(&cost), "{cost}");
    // All the way in zigzag.
    let cost = plane.least_of_all(plane.look(1, [20, 20]));
    assert!((1560.0..=1600.0).contains(&cost), "{cost}");
}

#[test]
fn the_most_from_a_goal_is_at_least_what_its_cells_cost() {
    let plane = crossed_in(50, 40).plane().unwrap();
    for way in [[2, 1], [0, 0], [9, -4]] {
        let most = plane.most(1, way, 2);
        assert!(plane.cells(2).iter().all(|&(c, _)| plane.cost(plane.look(1, way), c) <= most), "{way:?}: {most}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn no_way_to_the_best_cell_costs_more_than_the_most(links in proptest::collection::vec((0usize..6, 0u32..6, 20u16..60), 8..24)) {
        let links: Vec<_> = links.iter().map(|&(f, t, n)| ([0, 1, 2, 3, 8, 9][f], 4 + t, n)).collect();
        let tile = Tile::new(&links);
        let plane = tile.plane().unwrap();
        for from in 0..5 {
            let found: Vec<_> = plane.cells(from).iter().map(|&(c, _)| tile.dijkstra(c)).collect();
            for (to, way) in (0..5).flat_map(|to| offsets(2).map(move |way| (to, way))) {
                let least = |f: &BTreeMap<([i32; 2], u32), u32>| {
                    let ends = f.iter().filter(|((at, cell), _)| *at == way && plane.cells(to).contains(&(*cell, 0)));
                    ends.map(|(_, frames)| *frames).min().map_or(f32::INFINITY, |f| f as f32)
                };
                let worst = found.iter().map(least).fold(0.0, f32::max);
                prop_assert!(plane.most(to, way, from) >= worst, "{} to {} {:?}: {}", from, to, way, worst);
            }
        }
        prop_assert_eq!(plane.most(0, [RADIUS + 1, 0], 1), f32::INFINITY);
    }
}

#[test]
fn tiles_in_a_line_fill_no_plane() {
    assert!(lattice(&[Vec3::X, -Vec3::X]).is_none());
    assert_eq!(lattice(&[Vec3::X, Vec3::new(-1.0, 0.0, 0.5)]), Some(vec![[1, 0], [0, 1]]));
    assert!(lattice(&[Vec3::X, Vec3::Z, Vec3::new(0.5, 0.0, 0.0)]).is_none());
}
