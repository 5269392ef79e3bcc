//! What every cell of a world is to its largest strongly connected component.

use super::component::{Standing, largest};
use super::joined::Joined;
use super::reach::{Direction, Reached, reach};
use super::rows::ones;

/// What every cell is to the component, as bits. The bit of an exit is that of the entry across the edge; those without
/// a neighbour have none.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Settled {
    /// Cells that belong to it. [Size: words of the graph]
    pub inside: Vec<u64>,
    /// Cells whose motion leads to it. [Size: words of the graph]
    pub leads: Vec<u64>,
}

/// Cells that are tried as one of the component before everything is searched through.
const TRIES: usize = 4;

/// Finds the component; none where no motion goes on for ever.
///
/// A cell that joints lead to, but no motion, belongs to it as well: its links do, and nothing that belongs to the
/// component ends there.
/// - `likely`: instance and cell that probably belong to it.
pub(super) fn settle(graph: &Joined<'_>, likely: Option<(u32, u32)>) -> Option<Settled> {
    let seeds = likely.into_iter().chain(seeds(graph)).take(TRIES);
    seeds.into_iter().find_map(|seed| around(graph, seed)).or_else(|| exact(graph))
}

/// Cells that motion leads on from, of instances all over the world.
fn seeds<'s>(graph: &'s Joined<'_>) -> impl Iterator<Item = (u32, u32)> + 's {
    let part = move |k: usize| ((2 * k + 1) * graph.parts.len() / (2 * TRIES)) as u32;
    (0..TRIES).map(part).filter_map(|part| {
        let cells = (0..graph.cells(part).len() as u32).rev();
        let most = cells.max_by_key(|&c| graph.situation(part).out.members(c).count())?;
        Some((part, most))
    })
}

/// The component that a cell belongs to; none where that is not surely the largest.
fn around(graph: &Joined<'_>, (part, cell): (u32, u32)) -> Option<Settled> {
    let search = |direction| reach(graph, part, cell, direction);
    let (from, to) = rayon::join(|| search(Direction::Forth), || search(Direction::Back));
    if !is_largest(graph, &from, &to) {
        return None;
    }
    let both = |(from, to): (&[u64], &[u64])| from.iter().zip(to).map(|(f, t)| f & t).collect::<Vec<_>>();
    let (mut inside, joined) = (both((&from.moved, &to.moved)), both((&from.joined, &to.joined)));
    inside.iter_mut().zip(joined).for_each(|(m, j)| *m |= j);
    Some(Settled { inside, leads: to.moved })
}

/// True where no other component can have as many nodes as that of all nodes reached in both directions.
///
/// What is in one component is reached in the same directions.
fn is_largest(graph: &Joined<'_>, from: &Reached, to: &Reached) -> bool {
    let mut counts = [0u64; 4];
    for (part, p) in (0u32..).zip(&graph.parts) {
        let exits = &graph.exits[p.patch as usize];
        // No other cells are come to by joints from cells.
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

/// The component by a search through everything.
fn exact(graph: &Joined<'_>) -> Option<Settled> {
    let all = largest(graph)?;
    let (moved, joined) = all.split_at(graph.num_nodes);
    let mut out = Settled { inside: vec![0; graph.num_words], leads: vec![0; graph.num_words] };
    for part in 0..graph.parts.len() as u32 {
        let first = graph.words(part).start;
        for cell in 0..graph.cells(part).len() as u32 {
            let Some(node) = graph.node(part, cell).map(|n| n as usize) else { continue };
            let (word, bit) = (first + cell as usize / 64, 1 << (cell % 64));
            if [moved[node], joined[node]].contains(&Standing::Inside) {
                out.inside[word] |= bit;
            }
            if moved[node] != Standing::DeadEnd {
                out.leads[word] |= bit;
            }
        }
    }
    Some(out)
}

impl Settled {
    /// What a cell of an instance is.
    pub fn standing(&self, graph: &Joined<'_>, part: u32, cell: u32) -> Standing {
        let has = |words: &[u64]| words[graph.words(part).start + cell as usize / 64] & 1 << (cell % 64) != 0;
        match (has(&self.inside), has(&self.leads)) {
            (true, _) => Standing::Inside,
            (false, true) => Standing::Unreached,
            (false, false) => Standing::DeadEnd,
        }
    }

    /// True where any cell of an instance, but for exits, is that.
    pub fn has(&self, graph: &Joined<'_>, part: u32, what: Standing) -> bool {
        let exits = &graph.exits[graph.parts[part as usize].patch as usize];
        let cells = (0u32..).zip(graph.words(part)).zip(exits);
        let mut own = cells.flat_map(|((k, _), e)| ones(!e).map(move |bit| 64 * k + bit));
        let count = graph.cells(part).len() as u32;
        own.any(|cell| cell < count && self.standing(graph, part, cell) == what)
    }

    /// The first cell of an instance, but for exits, that belongs to the component.
    pub fn first_inside(&self, graph: &Joined<'_>, part: u32) -> Option<u32> {
        let exits = &graph.exits[graph.parts[part as usize].patch as usize];
        let words = (0u32..).zip(&self.inside[graph.words(part)]).zip(exits);
        words.map(|((k, w), e)| (k, w & !e)).find(|(_, w)| *w != 0).map(|(k, w)| 64 * k + w.trailing_zeros())
    }
}
