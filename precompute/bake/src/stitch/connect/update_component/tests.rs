//! Random worlds, changed at random, against strongly connected components of a graph that is built.

use super::*;
use crate::components::SuccessorGraph;
use crate::stitch::clearance::collision_span::CollisionSpan;
use crate::stitch::connect::component_cells::{ComponentMembership, find_component};
use crate::stitch::connect::crossing::CrossingJoints;
use crate::stitch::connect::joined::{GraphInstance, InstanceOverlap, exits};
use crate::stitch::connect::situation::{PatchSituation, PatchSurroundings};
use crate::stitch::connect::table::JointTable;
use crate::stitch::place::relation::RelativePlacement;
use crate::stitch::sets::bits::all_set;
use bytemuck::Zeroable;
use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::collections::HashMap;
use std::sync::Arc;
use throng_core::patch::{
    CellRecord, EdgeRecord, KIND_BLOCK, KIND_TILE, LinkRecord, PatchRecord, PatchTables, Placement,
};
use throng_world::JointRecord;

const TILE: u32 = 0;
/// Rows of tiles side by side.
const ROWS: usize = 2;
/// Ways in which something may be in the way of a patch.
const VARIANTS: u64 = 4;

/// A tile with four edges, and two blocks, one of which has more cells than a word has bits.
struct Kinds {
    patches: Vec<PatchRecord>,
    edges: Vec<EdgeRecord>,
    cells: Vec<CellRecord>,
    links: Vec<LinkRecord>,
}

impl Kinds {
    fn new(rng: &mut Pcg64Mcg) -> Self {
        let edge = |opposite| EdgeRecord { step: [0.0; 3], opposite };
        let mut out = Self {
            patches: Vec::new(),
            edges: vec![edge(1), edge(0), edge(3), edge(2)],
            cells: Vec::new(),
            links: Vec::new(),
        };
        let end = |e: u32, flags, twin| CellRecord { edge: e, twin, flags, ..CellRecord::zeroed() };
        let inner = CellRecord { edge: NONE, twin: NONE, ..CellRecord::zeroed() };
        let mut tile: Vec<CellRecord> = (0..4).map(|e| end(e, CellRecord::IS_ENTRY, 4 + (e ^ 1))).collect();
        tile.extend((0..4).map(|e| end(e, CellRecord::IS_EXIT, e ^ 1)));
        tile.extend([inner; 3]);
        let starts: Vec<u32> = (0..4).chain(8..11).collect();
        let ends: Vec<u32> = (4..11).collect();
        out.add(KIND_TILE, tile, &starts, &ends, 0.4, rng);
        for (count, share) in [(5u32, 0.3), (70, 0.03)] {
            let all: Vec<u32> = (0..count).collect();
            out.add(KIND_BLOCK, vec![inner; count as usize], &all, &all, share, rng);
        }
        out
    }

    fn add(&mut self, kind: u32, cells: Vec<CellRecord>, starts: &[u32], ends: &[u32], share: f64, rng: &mut Pcg64Mcg) {
        let first_link = self.links.len() as u32;
        let at = Placement::IDENTITY;
        for (&from, &to) in starts.iter().flat_map(|from| ends.iter().map(move |to| (from, to))) {
            if rng.random_bool(share) {
                self.links.push(LinkRecord { from, to, frame: 0, num_frames: 30, tag: 0, start: at, end: at });
            }
        }
        self.patches.push(PatchRecord {
            kind,
            first_cell: self.cells.len() as u32,
            num_cells: cells.len() as u32,
            first_link,
            num_links: self.links.len() as u32 - first_link,
            num_edges: if kind == KIND_TILE { 4 } else { 0 },
            ..PatchRecord::zeroed()
        });
        self.cells.extend(cells);
    }

    fn patches(&self) -> PatchTables {
        PatchTables {
            patches: (&self.patches).into(),
            edges: (&self.edges).into(),
            cells: (&self.cells).into(),
            links: (&self.links).into(),
            pairs: [].as_slice().into(),
        }
    }
}

/// An instance: its identity, its patch, how it stands among units, and the column and row of a tile.
#[derive(Clone, Copy, PartialEq)]
struct Instance {
    id: u64,
    patch: u32,
    variant: u64,
    at: [usize; 2],
}

/// A world that can be changed.
struct World<'k> {
    kinds: &'k Kinds,
    columns: usize,
    instances: Vec<Instance>,
    situations: HashMap<(u32, u64), Arc<PatchSituation>>,
    num_ids: u64,
}

impl<'k> World<'k> {
    fn new(kinds: &'k Kinds, columns: usize, rng: &mut Pcg64Mcg) -> Self {
        let mut out = Self { kinds, columns, instances: Vec::new(), situations: HashMap::new(), num_ids: 0 };
        for k in 0..columns * ROWS {
            out.place(TILE, [k / ROWS, k % ROWS], rng);
        }
        for _ in 0..columns / 2 {
            let (patch, at) = (rng.random_range(1..3), [rng.random_range(0..columns), rng.random_range(0..ROWS)]);
            out.place(patch, at, rng);
        }
        out
    }

    fn place(&mut self, patch: u32, at: [usize; 2], rng: &mut Pcg64Mcg) {
        self.num_ids += 1;
        // Mostly nothing is in the way.
        let variant = rng.random_range(0..2 * VARIANTS).saturating_sub(VARIANTS);
        let instance = Instance { id: self.num_ids, patch, variant, at };
        let place = rng.random_range(0..=self.instances.len());
        self.instances.insert(place, instance);
    }

    fn change(&mut self, rng: &mut Pcg64Mcg) {
        let which = rng.random_range(0..self.instances.len());
        match rng.random_range(0..4) {
            0 => _ = self.instances.remove(which),
            1 => {
                let at = [rng.random_range(0..self.columns), rng.random_range(0..ROWS)];
                let is_free = !self.instances.iter().any(|i| i.patch == TILE && i.at == at);
                let patch = if is_free { TILE } else { rng.random_range(1..3) };
                self.place(patch, at, rng);
            }
            _ => self.instances[which].variant = rng.random_range(0..VARIANTS),
        }
    }

    fn situation(&mut self, patch: u32, variant: u64) -> Arc<PatchSituation> {
        let make = || {
            let mut rng = Pcg64Mcg::seed_from_u64(variant ^ u64::from(patch) << 8);
            let num_links = self.kinds.patches[patch as usize].num_links as usize;
            let mut mask = vec![0; all_set(num_links).len()];
            if variant > 0 {
                (0..num_links as u32)
                    .filter(|_| rng.random_bool(0.4))
                    .for_each(|l| mask[l as usize / 64] |= 1 << (l % 64));
            }
            let surroundings = PatchSurroundings { patch, obstacles: Vec::new() };
            Arc::new(PatchSituation::new(&self.kinds.patches(), surroundings, std::iter::once(mask.as_slice())))
        };
        Arc::clone(self.situations.entry((patch, variant)).or_insert_with(make))
    }

    /// Joints between two instances, the same whenever both are there; none where they are apart.
    fn table(&self, a: &Instance, b: &Instance) -> Option<Arc<JointTable>> {
        let apart = a.at[0].abs_diff(b.at[0]) + a.at[1].abs_diff(b.at[1]);
        if b.patch == TILE || a.patch != TILE && a.id >= b.id || apart > 1 {
            return None;
        }
        let mut rng = Pcg64Mcg::seed_from_u64(a.id << 20 | b.id);
        let [pa, pb] = [a, b].map(|i| &self.kinds.patches[i.patch as usize]);
        let joint = |rng: &mut Pcg64Mcg| {
            let b = rng.random_range(0..pb.num_cells);
            let (a, a_offset) = match a.patch {
                TILE => (rng.random_range(0..pa.num_links), rng.random_range(5..25)),
                _ => (rng.random_range(0..pa.num_cells), NONE),
            };
            JointRecord { a, a_offset, b, reserved: 0 }
        };
        let mut joints: Vec<JointRecord> = (0..rng.random_range(0..12)).map(|_| joint(&mut rng)).collect();
        joints.sort_unstable();
        joints.dedup();
        let mut by_b: Vec<u32> = (0..joints.len() as u32).collect();
        by_b.sort_by_key(|&j| joints[j as usize].b);
        (!joints.is_empty()).then(|| Arc::new(JointTable { joints, by_b, shares_floor: false }))
    }

    fn joined(&mut self) -> JoinedGraph {
        let instances = self.instances.clone();
        let patches = self.kinds.patches();
        let mut out = JoinedGraph {
            exits: exits(&patches),
            patches: patches.clone(),
            parts: Vec::new(),
            neighbours: Vec::new(),
            situations: instances.iter().map(|i| self.situation(i.patch, i.variant)).collect(),
            overlaps: Vec::new(),
            crossings: Vec::new(),
            crossing_of: Vec::new(),
            shares_floor: Vec::new(),
            num_nodes: 0,
            num_words: 0,
        };
        let mut overlaps: Vec<Vec<InstanceOverlap>> = vec![Vec::new(); instances.len()];
        let pairs = (0..instances.len()).flat_map(|a| (0..instances.len()).map(move |b| (a, b)));
        for (a, b) in pairs.filter(|(a, b)| a != b) {
            let Some(table) = self.table(&instances[a], &instances[b]) else { continue };
            let hit = |link: u32| Some(CollisionSpan { first: (link % 30) as u16, last: (link % 30) as u16 });
            let kinds = [instances[a].patch, instances[b].patch];
            let crossing = out.crossings.len() as u32;
            let relation = RelativePlacement::new(kinds[0], Placement::IDENTITY, kinds[1], Placement::IDENTITY);
            out.crossings.push(Arc::new(CrossingJoints::new(&patches, relation, &table, &out.situations[a], hit)));
            overlaps[a].push(InstanceOverlap { other: b as u32, side: 0, pair: crossing, crossing });
            overlaps[b].push(InstanceOverlap { other: a as u32, side: 1, pair: crossing, crossing });
        }
        for (k, (i, own)) in instances.iter().zip(overlaps).enumerate() {
            let record = &self.kinds.patches[i.patch as usize];
            out.parts.push(GraphInstance {
                patch: i.patch,
                first_node: out.num_nodes as u32,
                first_word: out.num_words as u32,
                situation: k as u32,
                first_neighbour: out.neighbours.len() as u32,
                first_overlap: out.overlaps.len() as u32,
                num_overlaps: own.len() as u32,
            });
            out.num_nodes += record.num_cells as usize;
            out.num_words += out.exits[i.patch as usize].len();
            out.overlaps.extend(own);
            let [x, z] = i.at;
            let beside = [[x + 1, z], [x.wrapping_sub(1), z], [x, z + 1], [x, z.wrapping_sub(1)]];
            let tile = |at: [usize; 2]| instances.iter().position(|i| i.patch == TILE && i.at == at);
            let neighbours = beside.map(|at| tile(at).map_or(NONE, |n| n as u32));
            out.neighbours.extend(neighbours.iter().take(record.num_edges as usize));
        }
        out
    }
}

/// What every cell is, by Tarjan's algorithm on the whole graph; none where no node leads back to itself.
fn expected(graph: &JoinedGraph) -> Option<Vec<Vec<ComponentMembership>>> {
    let count = SuccessorGraph::num_nodes(graph);
    let mut whole = DiGraph::<(), ()>::new();
    (0..count).for_each(|_| _ = whole.add_node(()));
    for node in 0..count as u32 {
        graph
            .successors(node)
            .for_each(|to| _ = whole.add_edge(NodeIndex::new(node as usize), NodeIndex::new(to as usize), ()));
    }
    let leads_back = |c: &Vec<NodeIndex>| c.len() > 1 || whole.contains_edge(c[0], c[0]);
    let components: Vec<_> = tarjan_scc(&whole).into_iter().filter(leads_back).collect();
    let most = components.iter().map(Vec::len).max()?;
    let main = components.into_iter().filter(|c| c.len() == most).min_by_key(|c| c.iter().min().copied())?;
    let mut leads = vec![false; count];
    let mut open: Vec<NodeIndex> = main.clone();
    main.iter().for_each(|n| leads[n.index()] = true);
    while let Some(node) = open.pop() {
        let before = whole.neighbors_directed(node, petgraph::Direction::Incoming);
        open.extend(before.filter(|n| !std::mem::replace(&mut leads[n.index()], true)));
    }
    let mut inside = vec![false; count];
    main.iter().for_each(|n| inside[n.index()] = true);
    let standing = |part: u32, cell: u32| match graph.node(part, cell).map(|n| n as usize) {
        Some(n) if inside[n] || inside[n + count / 2] => ComponentMembership::Inside,
        Some(n) if leads[n] => ComponentMembership::Unreached,
        _ => ComponentMembership::DeadEnd,
    };
    let of_part = |part: u32| (0..graph.cells(part).len() as u32).map(|cell| standing(part, cell)).collect();
    Some((0..graph.parts.len() as u32).map(of_part).collect())
}

fn found(graph: &JoinedGraph, component: &ComponentCells) -> Vec<Vec<ComponentMembership>> {
    let of_part = |part: u32| {
        (0..graph.cells(part).len() as u32).map(|cell| component.membership(graph, part, cell)).collect::<Vec<_>>()
    };
    (0..graph.parts.len() as u32).map(of_part).collect()
}

/// Changes a random world some times: how often it was settled without searching through everything.
fn follow(seed: u64) -> Result<usize, TestCaseError> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let kinds = Kinds::new(&mut rng);
    let columns = rng.random_range(14..30);
    let mut world = World::new(&kinds, columns, &mut rng);
    let mut joined = world.joined();
    let Some(mut component) = find_component(&joined, None) else { return Ok(0) };
    prop_assert_eq!(Some(found(&joined, &component)), expected(&joined));
    let mut soon = 0;
    for _ in 0..4 {
        let was = world.instances.clone();
        (0..rng.random_range(1..3)).for_each(|_| world.change(&mut rng));
        let changed = world.joined();
        let number = |i: &Instance| was.iter().position(|w| w == i).map_or(NONE, |k| k as u32);
        let same = world.instances.iter().map(number).collect();
        let before = PriorGraph { joined: &joined, component: &component, previous_of: same };
        let resettled = update_component(&before, &changed);
        let now = find_component(&changed, Some(&before));
        prop_assert_eq!(now.as_ref().map(|now| found(&changed, now)), expected(&changed));
        let Some(now) = now else { break };
        if let Some(resettled) = resettled {
            soon += 1;
            // What is kept for the next change is what a search through everything gives.
            prop_assert_eq!(Some(resettled), find_component(&changed, None));
        }
        (joined, component) = (changed, now);
    }
    Ok(soon)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_changed_world_is_settled_as_the_whole_graph_says(seed in any::<u64>()) {
        follow(seed)?;
    }
}

#[test]
fn many_changes_are_settled_near_by() {
    let soon: usize = (0..50).map(|seed| follow(seed).expect("as the whole graph says")).sum();
    assert!(soon > 65, "{soon} of at most 200");
}
