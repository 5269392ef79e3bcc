//! Pruning of tiles: no character that enters may get stuck, and all can be reached from all (Lee, Choi and Lee 2006,
//! section 6).

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use serde::{Deserialize, Serialize};
use throng_core::patch::NONE;

/// Begin or end of links of a tile, for pruning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TileCell {
    /// Entry across this edge.
    Entry(u32),
    /// Exit across edge `.0`, to the entry `.1` of the neighbour.
    Exit(u32, u32),
    /// Rest inside.
    Rest,
}

/// Guarantee for each entry of a tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Freedom {
    /// Each entry leads across every edge, and to rest, within the tile.
    #[default]
    EachTile,
    /// Each entry leads on, and through further tiles across every edge and to rest.
    FurtherTiles,
}

/// A tile's graph.
#[derive(Clone, Debug, PartialEq)]
pub struct TileGraph {
    /// Cells; every entry has one exit that leads to it.
    pub cells: Vec<TileCell>,
    /// Links from an entry or rest to an exit or rest, by cell.
    pub links: Vec<(u32, u32)>,
    /// For each edge, the edges across which a character that entered there must be able to leave.
    pub exit_edges: Vec<Vec<u32>>,
    /// True if a character that entered must be able to rest in the tile.
    pub must_rest: bool,
    /// Sets of edges whose entries belong to one strongly connected component. Ground has one set of all edges; for
    /// motion that does not turn round, as on a slide, each edge is a set by itself.
    pub together: Vec<Vec<u32>>,
}

/// Remaining cells and links of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct PrunedTile {
    /// True for remaining cells (cells.len()).
    pub cells: Vec<bool>,
    /// True for remaining links (links.len()).
    pub links: Vec<bool>,
    /// Number of links removed by the first condition.
    pub directions: usize,
    /// Number of links removed by the second condition.
    pub component: usize,
}

/// Removes cells and links until both conditions hold.
///
/// 1. Every entry can leave across each of its required edges, and reach rest if that is required; others are removed
///    with the exits that lead to them. [`Freedom::FurtherTiles`] skips this condition.
/// 2. On the torus that the tile makes with itself, each set of edges keeps the largest strongly connected component
///    with entries across all of them and, if required, with rest. So everything that the first condition requires
///    within a tile can be reached through further ones.
///
/// Both are enforced alternately until nothing changes; the result may be empty.
///
/// # Source
/// Lee, Choi and Lee 2006, section 6. Differs: reachable rest is a condition too, and the first condition can be
/// skipped.
pub fn prune(graph: &TileGraph, freedom: Freedom) -> PrunedTile {
    let (cells, links) = (vec![true; graph.cells.len()], vec![true; graph.links.len()]);
    let mut left = PrunedTile { cells, links, directions: 0, component: 0 };
    let count = |left: &PrunedTile| left.links.iter().filter(|&&l| l).count();
    loop {
        let before = count(&left);
        if freedom == Freedom::EachTile {
            drop_stuck_entries(graph, &mut left);
        }
        let after_first = count(&left);
        let changed = keep_components(graph, &mut left);
        left.directions += before - after_first;
        left.component += after_first - count(&left);
        if !changed {
            return left;
        }
    }
}

/// One step of the first condition, repeated until it holds.
fn drop_stuck_entries(graph: &TileGraph, left: &mut PrunedTile) {
    loop {
        let reached = exit_edges(graph, left);
        let is_stuck = |&i: &usize| match graph.cells[i] {
            TileCell::Entry(edge) => left.cells[i] && !is_free(graph, edge, &reached[i]),
            _ => false,
        };
        let stuck: Vec<usize> = (0..graph.cells.len()).filter(is_stuck).collect();
        if stuck.is_empty() {
            return;
        }
        stuck.into_iter().for_each(|i| left.cells[i] = false);
        for (i, cell) in graph.cells.iter().enumerate() {
            if let TileCell::Exit(_, twin) = *cell {
                left.cells[i] &= left.cells[twin as usize];
            }
        }
        drop_loose_links(graph, left);
    }
}

/// For each cell, the edges across which its links leave, and [`NONE`] for rest.
fn exit_edges(graph: &TileGraph, left: &PrunedTile) -> Vec<Vec<u32>> {
    let mut reached = vec![Vec::new(); graph.cells.len()];
    for (&(from, to), _) in graph.links.iter().zip(&left.links).filter(|(_, left)| **left) {
        let way = if let TileCell::Exit(edge, _) = graph.cells[to as usize] { edge } else { NONE };
        let of: &mut Vec<u32> = &mut reached[from as usize];
        if !of.contains(&way) {
            of.push(way);
        }
    }
    reached
}

fn is_free(graph: &TileGraph, edge: u32, reached: &[u32]) -> bool {
    graph.exit_edges[edge as usize].iter().all(|way| reached.contains(way))
        && (!graph.must_rest || reached.contains(&NONE))
}

fn drop_loose_links(graph: &TileGraph, left: &mut PrunedTile) {
    for (&(from, to), link) in graph.links.iter().zip(&mut left.links) {
        *link &= left.cells[from as usize] && left.cells[to as usize];
    }
}

/// One step of the second condition; true if it removed anything.
fn keep_components(graph: &TileGraph, left: &mut PrunedTile) -> bool {
    let node = |cell: u32| match graph.cells[cell as usize] {
        TileCell::Exit(_, twin) => twin as usize,
        _ => cell as usize,
    };
    let mut torus = DiGraph::<(), ()>::new();
    graph.cells.iter().for_each(|_| _ = torus.add_node(()));
    let links = || graph.links.iter().enumerate();
    for (_, &(from, to)) in links().filter(|(l, _)| left.links[*l]) {
        torus.add_edge(NodeIndex::new(node(from)), NodeIndex::new(node(to)), ());
    }
    let mut component = vec![usize::MAX; graph.cells.len()];
    let found = tarjan_scc(&torus);
    for (c, nodes) in found.iter().enumerate() {
        nodes.iter().for_each(|n| component[n.index()] = c);
    }
    let mut within = vec![0usize; found.len()];
    for (_, &(from, to)) in links().filter(|(l, _)| left.links[*l]) {
        if component[node(from)] == component[node(to)] {
            within[component[node(from)]] += 1;
        }
    }
    let kept = largest(graph, &found, &within);
    let before = left.clone();
    for i in 0..graph.cells.len() {
        left.cells[i] &= kept.contains(&component[node(i as u32)]);
    }
    for (l, &(from, to)) in links() {
        left.links[l] &= component[node(from)] == component[node(to)];
    }
    drop_loose_links(graph, left);
    before != *left
}

/// For each set of edges, the component with the most cells that has an entry across each of them, and rest if
/// required.
fn largest(graph: &TileGraph, components: &[Vec<NodeIndex>], links_within: &[usize]) -> Vec<usize> {
    let mut kept = Vec::new();
    for edges in &graph.together {
        let has = |c: usize, cell: TileCell| components[c].iter().any(|n| graph.cells[n.index()] == cell);
        let fits = |c: &usize| {
            links_within[*c] > 0
                && edges.iter().all(|&e| has(*c, TileCell::Entry(e)))
                && (!graph.must_rest || has(*c, TileCell::Rest))
        };
        // On a tie, the component with the first cell.
        let rank = |&c: &usize| (components[c].len(), std::cmp::Reverse(components[c].iter().min().copied()));
        kept.extend((0..components.len()).filter(fits).max_by_key(rank));
    }
    kept
}
