//! The largest strongly connected component, without dead ends.

use super::matches::Link;
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};

/// Event frames and the ways between them: after event i comes either `next[i]`, as the clip goes on, or
/// `next[l.event]` for a link l.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EventGraph {
    /// The event the clip goes on to.
    pub next: Vec<Option<usize>>,
    /// Frames between the event before, exclusive, and this one: what an arrival plays.
    pub frames: Vec<u32>,
    /// The chosen transitions of every event.
    pub links: Vec<Vec<Link>>,
}

impl EventGraph {
    /// True where the clip goes on from `i` to an event of the component.
    pub fn goes_on(&self, i: usize, alive: &[bool]) -> bool {
        self.next[i].is_some_and(|n| alive[n])
    }

    /// True where a link arrives in the component.
    pub fn arrives(&self, link: &Link, alive: &[bool]) -> bool {
        self.goes_on(link.event, alive)
    }

    /// Links of `i` that arrive in the component.
    pub fn jumps<'a>(&'a self, i: usize, alive: &'a [bool]) -> impl Iterator<Item = &'a Link> {
        self.links[i].iter().filter(|l| self.arrives(l, alive))
    }
}

/// Reduces the graph to its largest strongly connected component, measured in frames.
///
/// An event where the clip does not go on must have two links into the component: one it lacks is taken from
/// `spare`, and an event that still has fewer is removed. Both are repeated until nothing changes, so every
/// event of the result leads on, and every one of them to every other.
///
/// - `spare`: possible links of every event, best first.
/// - returns which events are in the component; none may be.
pub(super) fn largest_component(graph: &mut EventGraph, spare: &[Vec<Link>]) -> Vec<bool> {
    let mut alive = vec![true; graph.next.len()];
    loop {
        alive = strongest(graph, &alive);
        let ends: Vec<usize> = (0..alive.len()).filter(|&i| alive[i] && !graph.goes_on(i, &alive)).collect();
        let mut removed = false;
        for i in ends {
            let missing = 2usize.saturating_sub(graph.jumps(i, &alive).count());
            let more: Vec<Link> = spare[i]
                .iter()
                .filter(|l| graph.arrives(l, &alive) && graph.links[i].iter().all(|k| k.event != l.event))
                .take(missing)
                .copied()
                .collect();
            if more.len() < missing {
                alive[i] = false;
                removed = true;
            } else {
                graph.links[i].extend(more);
            }
        }
        if !removed {
            return alive;
        }
    }
}

/// The strongly connected component of most frames among the events alive; the one with the first event on a tie.
fn strongest(graph: &EventGraph, alive: &[bool]) -> Vec<bool> {
    let mut g = DiGraph::<(), (), usize>::default();
    let nodes: Vec<NodeIndex<usize>> = alive.iter().map(|_| g.add_node(())).collect();
    for i in (0..alive.len()).filter(|&i| alive[i]) {
        let targets = graph.next[i].into_iter().chain(graph.links[i].iter().filter_map(|l| graph.next[l.event]));
        for n in targets.filter(|&n| alive[n]) {
            g.update_edge(nodes[i], nodes[n], ());
        }
    }
    let frames = |c: &[NodeIndex<usize>]| c.iter().map(|n| u64::from(graph.frames[n.index()])).sum::<u64>();
    let first = |c: &[NodeIndex<usize>]| c.iter().map(|n| n.index()).min();
    let best = kosaraju_scc(&g)
        .into_iter()
        .filter(|c| c.len() > 1 || g.contains_edge(c[0], c[0]))
        .max_by_key(|c| (frames(c), std::cmp::Reverse(first(c))));
    let mut out = vec![false; alive.len()];
    for n in best.into_iter().flatten() {
        out[n.index()] = true;
    }
    out
}
