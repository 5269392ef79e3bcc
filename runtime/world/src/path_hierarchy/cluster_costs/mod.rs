//! Cluster costs: least costs within clusters, found once for all that are alike.

mod alike;
mod edges;
mod outline;
mod search_graph;

use super::dial::{Arcs, Dial, frames};
use super::plane::CellCost;
use alike::least_across;
use edges::ExitLanding;
pub(super) use outline::ClusterOutline;
use search_graph::SearchGraph;
use serde::{Deserialize, Serialize};

/// Part of the world that a cluster overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum AdjacentPart {
    /// A tile of a floor.
    Tile(u32),
    /// Another cluster.
    Cluster(u32),
}

impl AdjacentPart {
    /// The tile, where it is one.
    pub fn tile(self) -> Option<u32> {
        if let Self::Tile(t) = self { Some(t) } else { None }
    }

    /// The cluster, where it is one.
    pub fn cluster(self) -> Option<u32> {
        if let Self::Cluster(d) = self { Some(d) } else { None }
    }
}

/// Costs within alike clusters, from their entrances to their exits.
///
/// An entrance begins at some cells, and an exit ends at some, each with an additional cost of its own: the tables
/// leave it out, and it is added on entering those cells or leaving from there. Costs to single cells are left to a
/// search by the caller, see [`ClusterCosts::arcs_into`].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ClusterCosts {
    pub num_cells: u32,
    /// Entrances: what each leads from, as a number in [`ClusterOutline::adjacent_parts`], and the cells there, each with what of the way is
    /// counted on coming there.
    pub entrances: Vec<(u32, Vec<CellCost>)>,
    /// Exits: what each leads to.
    #[serde(with = "crate::pod")]
    pub exits: Vec<u32>,
    /// Ends of each exit, with the part of the cost that is added on leaving from there (frames).
    spots: Vec<Vec<(ExitLanding, u16)>>,
    /// Excess of the table over the true costs to each exit (frames).
    #[serde(with = "crate::pod")]
    more: Vec<u16>,
    /// States that each entrance begins at, see [`ClusterCosts::arcs_into`], with what is counted on coming there.
    pub starts: Vec<Vec<(u32, u16)>>,
    /// Least frames to leave by each exit, from each cell (exits * cells).
    #[serde(with = "crate::pod")]
    to_exit: Vec<u16>,
    /// Least frames to leave by each exit, from each entrance (exits * entrances).
    #[serde(with = "crate::pod")]
    across: Vec<u16>,
    /// Arcs into each state.
    back: Arcs<u32>,
}

impl ClusterCosts {
    /// Searches from every entrance and to every exit.
    pub fn new(outline: &ClusterOutline<'_>, search: &mut Dial) -> Self {
        let search_graph = SearchGraph::new(outline);
        let [mut entrances, exits] = search_graph.entrances_and_exits(search);
        let mut out = Self { num_cells: outline.num_cells, ..Self::default() };
        let mut across = Vec::new();
        for alike in &exits {
            search_graph.search_back(alike, search);
            out.to_exit.extend((0..outline.num_cells).map(|c| search.cost(c)));
            across.push(search_graph.costs_of_entrances(search));
            out.exits.push(alike.beyond);
            out.more.push(alike.max_part());
            out.spots.push(alike.places.iter().map(|&(n, part)| (search_graph.landing(n), part)).collect());
        }
        let more = &out.more;
        entrances.iter_mut().for_each(|alike| alike.fit_parts(across.iter().zip(more).map(|(a, m)| (&a[..], *m))));
        for (costs, more) in across.iter().zip(more) {
            out.across.extend(entrances.iter().map(|alike| least_across(alike, costs, *more)));
        }
        for alike in &entrances {
            out.starts.push(alike.places.iter().map(|&(n, part)| (search_graph.entrance_state(n), part)).collect());
            out.entrances.push((
                alike.beyond,
                alike.places.iter().map(|&(n, part)| (search_graph.entrance_cell(n), part)).collect(),
            ));
        }
        out.back = search_graph.back;
        out
    }

    /// True where all entries of a table read from a file are in range, and path lengths can be counted in frames.
    ///
    /// - `longest`: length of the longest link (frames).
    pub fn is_sound(&self, longest: u32) -> bool {
        let (exits, states) = (self.exits.len(), self.num_states());
        let mut starts = self.starts.iter().flatten();
        self.starts.len() == self.entrances.len()
            && self.spots.len() == exits
            && self.more.len() == exits
            && exits.checked_mul(self.num_cells as usize) == Some(self.to_exit.len())
            && exits.checked_mul(self.entrances.len()) == Some(self.across.len())
            && self.num_cells as usize <= states
            && (states as u64).saturating_mul(longest.into()) <= u32::MAX.into()
            && starts.all(|&(state, _)| (state as usize) < states)
            && self.back.is_sound(|&to| to, longest)
    }

    /// Number of states: the cells, those of blocks again where a link must follow, as after a joint between blocks, and
    /// the cells beyond that entrances begin at.
    pub fn num_states(&self) -> usize {
        self.back.num_nodes()
    }

    /// Arcs into a state: the states before it, and their lengths (frames).
    pub fn arcs_into(&self, state: u32) -> &[(u32, u16)] {
        self.back.arcs_from(state)
    }

    /// Least frames from a cell to an exit. What lies at its cells may be below 0.
    pub fn to_exit(&self, out: u32, cell: u32) -> f32 {
        frames(self.to_exit[(out * self.num_cells + cell) as usize]) - f32::from(self.more[out as usize])
    }

    /// Least frames from an entrance to an exit.
    pub fn cost_across(&self, entrance: u32, out: u32) -> f32 {
        frames(self.across[out as usize * self.entrances.len() + entrance as usize])
    }

    /// Ends of an exit: the offset from the tile that it leads through (copies), the cell there, and the cost that is
    /// added on leaving from it.
    pub fn exit_landings(&self, out: u32) -> impl ExactSizeIterator<Item = ([i32; 2], u32, f32)> {
        self.spots[out as usize].iter().map(|(l, part)| (l.offset, l.cell, f32::from(*part)))
    }
}
