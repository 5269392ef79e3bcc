//! Made-up tiles, and floors of them, for tests.

use super::{InstanceRecord, UnitRecord, WorldData, WorldGraph, WorldNode};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use throng_core::patch::{CellRecord, EdgeRecord, KIND_TILE, LinkRecord, NONE, PatchRecord, PatchTables, Placement};

/// A tile with an entry and an exit an edge (cells 0 to 3 and 4 to 7) and some cells inside, and its links.
#[derive(Debug)]
pub(crate) struct Tile {
    patch: PatchRecord,
    edges: Vec<EdgeRecord>,
    cells: Vec<CellRecord>,
    links: Vec<LinkRecord>,
}

const STEPS: [[i32; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];
/// Side of a tile (m).
const SIDE: f32 = 2.0;

impl Tile {
    /// A tile with links, each from a cell to a cell in so many frames.
    pub fn new(num_inside: usize, links: &[(u32, u32, u16)]) -> Self {
        let mut links = links.to_vec();
        links.sort_unstable();
        let mut cells: Vec<_> = (0..4).map(|e| cell(e, 4 + (e ^ 1), CellRecord::IS_ENTRY)).collect();
        cells.extend((0..4).map(|e| cell(e, e ^ 1, CellRecord::IS_EXIT)));
        cells.extend(vec![cell(NONE, NONE, 0); num_inside]);
        for (k, cell) in (0u32..).zip(&mut cells) {
            cell.first_link = links.partition_point(|l| l.0 < k) as u32;
            cell.num_links = links.iter().filter(|l| l.0 == k).count() as u32;
        }
        let edge = |e: usize| EdgeRecord {
            step: [SIDE * STEPS[e][0] as f32, 0.0, SIDE * STEPS[e][1] as f32],
            opposite: e as u32 ^ 1,
        };
        let patch = PatchRecord {
            kind: KIND_TILE,
            first_cell: 0,
            num_cells: cells.len() as u32,
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

    /// Straight on in so many frames, around a corner in so many.
    pub fn crossed_in(straight: u16, corner: u16) -> Self {
        let pairs = (0..4u32).flat_map(|from| (0..4u32).filter(move |&to| to != from).map(move |to| (from, to)));
        let link = |(from, to): (u32, u32)| (from, 4 + to, if to == from ^ 1 { straight } else { corner });
        Self::new(2, &pairs.map(link).collect::<Vec<_>>())
    }

    /// The bundle's view that consists of it.
    pub fn patches(&self) -> PatchTables {
        PatchTables {
            patches: (&[self.patch]).into(),
            edges: (&self.edges).into(),
            cells: (&self.cells).into(),
            links: (&self.links).into(),
            pairs: [].as_slice().into(),
        }
    }

    /// Least frames from a cell to all others, on a wide plane.
    pub fn dijkstra(&self, from: u32) -> BTreeMap<([i32; 2], u32), u32> {
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

    /// A floor of copies of it.
    pub fn floor(&self, places: &BTreeSet<[i32; 2]>) -> WorldData {
        let number: BTreeMap<[i32; 2], u32> = places.iter().copied().zip(0..).collect();
        let num_words = |bits: u32| bits.div_ceil(64);
        let (cell_words, link_words) = (num_words(self.patch.num_cells), num_words(self.patch.num_links));
        let mut out = WorldData::default();
        for (place, &k) in &number {
            let placement = Placement::new(SIDE * place[0] as f32, 0.0, SIDE * place[1] as f32, 0.0);
            out.units.push(UnitRecord { unit: 0, placement });
            out.resources.push(k);
            out.instances.push(InstanceRecord {
                patch: 0,
                first_neighbour: 4 * k,
                placement,
                first_cell_word: cell_words * k,
                first_link_word: link_words * k,
                first_adjacency: 0,
                num_adjacencies: 0,
                first_resource: k,
                num_resources: 1,
            });
            let across = |[u, v]: [i32; 2]| number.get(&[place[0] + u, place[1] + v]).copied().unwrap_or(NONE);
            out.neighbours.extend(STEPS.map(across));
        }
        out.cell_words = vec![u64::MAX; cell_words as usize * number.len()];
        out.link_words = vec![u64::MAX; link_words as usize * number.len()];
        out.check(&self.patches()).expect("the floor is sound");
        out
    }
}

fn cell(edge: u32, twin: u32, flags: u32) -> CellRecord {
    CellRecord {
        placement: Placement::IDENTITY,
        group: 0,
        edge,
        twin,
        flags,
        first_link: 0,
        num_links: 0,
        reserved: [0; 2],
    }
}

fn link(&(from, to, num_frames): &(u32, u32, u16)) -> LinkRecord {
    LinkRecord { from, to, frame: 0, num_frames, tag: 0, start: Placement::IDENTITY, end: Placement::IDENTITY }
}

/// Tiles with two cells inside and some links: from entries and the inside, to exits and the inside.
pub(crate) fn tiles() -> impl Strategy<Value = Tile> {
    let link = (0usize..6, 0u32..6, 20u16..60).prop_map(|(f, t, n)| ([0, 1, 2, 3, 8, 9][f], 4 + t, n));
    prop::collection::vec(link, 8..24).prop_map(|links| Tile::new(2, &links))
}

/// Places of a wide corridor with some side rooms, which lead nowhere else.
pub(crate) fn places(depths: [i32; 3]) -> BTreeSet<[i32; 2]> {
    let rectangle = |[u, v]: [i32; 2], [length, width]: [i32; 2]| {
        (0..length).flat_map(move |l| (0..width).map(move |w| [u + l, v + w]))
    };
    let side_rooms = [[0, 2], [3, 2], [6, 2]].into_iter().zip(depths);
    rectangle([0, 0], [8, 2]).chain(side_rooms.flat_map(|(at, depth)| rectangle(at, [2, depth]))).collect()
}

/// Least frames to a node from all others from which a path leads there.
pub(crate) fn costs_to(graph: &WorldGraph, target: WorldNode) -> BTreeMap<WorldNode, u32> {
    let mut back: BTreeMap<WorldNode, Vec<(WorldNode, u32)>> = BTreeMap::new();
    for from in nodes(graph) {
        graph.for_each_step(from, |step| back.entry(step.to).or_default().push((from, step.num_frames())));
    }
    let (mut queue, mut found) = (BTreeSet::from([(0, target)]), BTreeMap::new());
    while let Some((frames, node)) = queue.pop_first() {
        if found.contains_key(&node) {
            continue;
        }
        found.insert(node, frames);
        queue.extend(back.get(&node).into_iter().flatten().map(|&(from, more)| (frames + more, from)));
    }
    found
}

/// All nodes of a world.
pub(crate) fn nodes(graph: &WorldGraph) -> Vec<WorldNode> {
    let all = |instance| (0..graph.num_cells(instance)).map(move |cell| WorldNode { instance, cell });
    (0..graph.num_instances() as u32).flat_map(all).filter(|n| graph.is_node(*n)).collect()
}
