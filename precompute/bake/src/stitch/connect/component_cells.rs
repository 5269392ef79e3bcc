//! Membership of every cell of a world in its largest strongly connected component.

use super::joined::JoinedGraph;
use super::reach::{ReachSearch, ReachedNodes, SearchDirection};
use crate::{components::largest, stitch::sets::rows::set_bits};

/// Membership of a cell in the component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::stitch) enum ComponentMembership {
    /// Inside the component.
    Inside,
    /// Leads to the component, but is not reached from it.
    Unreached,
    /// Does not lead to the component.
    DeadEnd,
}

/// Membership of every cell in the component, as bits. The bit of an exit is that of the entry across the edge; exits
/// without a neighbour lead nowhere.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct ComponentCells {
    /// Nodes reached from the component.
    pub from: ReachedNodes,
    /// Nodes that lead to it.
    pub to: ReachedNodes,
    /// Cells in the component (words of the graph).
    pub inside: Vec<u64>,
}

/// Number of cells tried as seeds of the component before a full search.
const TRIES: usize = 4;

/// Finds the component; `None` if no motion continues for ever.
///
/// A cell reached by joints only, not by motion, belongs to it as well: its links do, and nothing in the component ends
/// there.
pub(in crate::stitch) fn find_component(graph: &JoinedGraph) -> Option<ComponentCells> {
    let around = |seed: (u32, u32)| ComponentCells::membership_at(graph, seed);
    let seeded = seed_cells(graph).map(around).find(|component| component.is_largest(graph));
    // Every component has cells reached by motion, which have the first numbers.
    seeded.or_else(|| largest(graph).map(|node| around(graph.instance_of(node))))
}

/// Cells from which motion continues, of instances all over the world.
fn seed_cells<'s>(graph: &'s JoinedGraph) -> impl Iterator<Item = (u32, u32)> + 's {
    let part = move |k: usize| ((2 * k + 1) * graph.parts.len() / (2 * TRIES)) as u32;
    (0..TRIES).map(part).filter_map(|part| {
        let cells = (0..graph.cells(part).len() as u32).rev();
        let most = cells.max_by_key(|&c| graph.situation(part).out.members(c).count())?;
        Some((part, most))
    })
}

impl ComponentCells {
    /// Membership relative to the component of a cell.
    fn membership_at(graph: &JoinedGraph, (part, cell): (u32, u32)) -> Self {
        let search = |direction| {
            let mut search = ReachSearch::new(graph, direction);
            search.start(part, cell);
            search.run()
        };
        let (from, to) = rayon::join(|| search(SearchDirection::Forth), || search(SearchDirection::Back));
        Self::new(from, to)
    }

    /// - `from`: all nodes reached from the component.
    /// - `to`: all nodes that lead to it.
    fn new(from: ReachedNodes, to: ReachedNodes) -> Self {
        let ReachedNodes { mut moved, joined } = from.intersection(&to);
        moved.iter_mut().zip(joined).for_each(|(m, j)| *m |= j);
        Self { from, to, inside: moved }
    }

    /// True if no other component can have as many nodes as that of all nodes reached in both directions.
    ///
    /// All nodes of one component are reached in the same directions.
    fn is_largest(&self, graph: &JoinedGraph) -> bool {
        let (from, to) = (&self.from, &self.to);
        let mut counts = [0u64; 4];
        for (part, p) in (0u32..).zip(&graph.parts) {
            let exits = &graph.exits[p.patch as usize];
            // Only these cells are reached by joints from cells.
            let joins = graph.overlaps_of(part).iter().any(|o| graph.crossing(o).between_cells);
            let cells = graph.cells(part).len();
            for (k, word) in graph.words(part).enumerate() {
                let all = if cells - 64 * k >= 64 { u64::MAX } else { (1 << (cells - 64 * k)) - 1 };
                let mut count = |f: u64, t: u64, which: u64| {
                    let classes = [f & t, f & !t, t & !f, !(f | t)];
                    counts.iter_mut().zip(classes).for_each(|(n, c)| *n += u64::from((c & which).count_ones()));
                };
                count(from.moved[word], to.moved[word], all & !exits[k]);
                if joins {
                    count(from.joined[word], to.joined[word], all & !exits[k]);
                }
            }
        }
        counts[0] > 1 && counts[1..].iter().all(|&n| n < counts[0])
    }

    /// Membership of a cell of an instance.
    pub fn membership(&self, graph: &JoinedGraph, part: u32, cell: u32) -> ComponentMembership {
        let has = |words: &[u64]| words[graph.words(part).start + cell as usize / 64] & 1 << (cell % 64) != 0;
        match (has(&self.inside), has(&self.to.moved)) {
            (true, _) => ComponentMembership::Inside,
            (false, true) => ComponentMembership::Unreached,
            (false, false) => ComponentMembership::DeadEnd,
        }
    }

    /// True if any cell of an instance, except exits, has a given membership.
    pub fn has_membership(&self, graph: &JoinedGraph, part: u32, what: ComponentMembership) -> bool {
        let exits = &graph.exits[graph.parts[part as usize].patch as usize];
        let cells = (0u32..).zip(graph.words(part)).zip(exits);
        let mut own = cells.flat_map(|((k, _), e)| set_bits(!e).map(move |bit| 64 * k + bit));
        let count = graph.cells(part).len() as u32;
        own.any(|cell| cell < count && self.membership(graph, part, cell) == what)
    }
}
