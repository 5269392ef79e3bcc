//! Search graphs: the graph within a cluster, ready for searches.

use super::super::dial::{Arcs, Dial, UNREACHED};
use super::alike::{AlikePlaces, PlaceGroup, part_groups};
use super::edges::{ClusterEdges, ExitLanding, ExitStep};
use super::{AdjacentPart, ClusterOutline};
use std::collections::BTreeMap;

/// The graph within a cluster. Its nodes are those of [`ClusterEdges`].
pub(super) struct SearchGraph {
    num_cells: u32,
    num_nodes: usize,
    on: Arcs<u32>,
    /// Turned around.
    pub back: Arcs<u32>,
    exit_steps: Vec<ExitStep>,
    /// Starts of entrances: the part of the world beyond, the class of the cell there, and the cell.
    entrances: Vec<(u32, u32, u32)>,
    /// Ends of exits: the part of the world beyond, the sector, and the landing.
    exits: Vec<(u32, u32, ExitLanding)>,
    /// Whether what lies beyond is a tile.
    is_tile: Vec<bool>,
}

impl SearchGraph {
    /// Draws it up.
    pub fn new(outline: &ClusterOutline<'_>) -> Self {
        let ClusterEdges { arcs, exit_steps, entrances, exits, .. } = ClusterEdges::new(outline);
        let num_nodes = 2 * outline.num_cells as usize + entrances.len();
        Self {
            num_cells: outline.num_cells,
            num_nodes,
            on: Arcs::new(num_nodes, arcs.iter().copied()),
            back: Arcs::new(num_nodes, arcs.iter().map(|&(from, to, frames)| (to, from, frames))),
            exit_steps,
            entrances: by_number(&entrances),
            exits: by_number(&exits),
            is_tile: outline.adjacent_parts.iter().map(|b| matches!(b, AdjacentPart::Tile(_))).collect(),
        }
    }

    /// Entrances and exits: groups of cells that differ by the time of arrival alone.
    pub fn entrances_and_exits(&self, search: &mut Dial) -> [Vec<AlikePlaces>; 2] {
        let entrances = self.groups(self.entrances.iter().map(|i| (i.0, i.1)));
        let exits = self.groups(self.exits.iter().map(|o| (o.0, o.1)));
        let to = |group: &PlaceGroup, search: &mut Dial| {
            self.search_back(&AlikePlaces::from_group(group), search);
            self.costs_of_entrances(search)
        };
        let costs_out: Vec<_> = exits.iter().map(|g| to(g, search)).collect();
        let from = |group: &PlaceGroup, search: &mut Dial| {
            self.search_on(&AlikePlaces::from_group(group), search);
            self.costs_of_exits(search)
        };
        let costs_in: Vec<_> = entrances.iter().map(|g| from(g, search)).collect();
        [part_groups(&entrances, &costs_out), part_groups(&exits, &costs_in)]
    }

    /// Searches for the least frames to an exit, and [`AlikePlaces::max_part`] more.
    pub fn search_back(&self, alike: &AlikePlaces, search: &mut Dial) {
        let mut more = vec![None; self.exits.len()];
        alike.places.iter().for_each(|&(n, part)| more[n as usize] = Some(alike.max_part() - part));
        let sources =
            self.exit_steps.iter().filter_map(|l| Some((l.from, l.frames.saturating_add(more[l.to as usize]?))));
        search.run(self.num_nodes, sources, |search, node| {
            self.back.arcs_from(node).iter().for_each(|&(from, frames)| search.reach_state(from, frames));
        });
    }

    /// Searches for the least frames from an entrance, and [`AlikePlaces::max_part`] more.
    fn search_on(&self, alike: &AlikePlaces, search: &mut Dial) {
        let sources = alike.places.iter().map(|&(n, part)| (self.entrance_state(n), alike.max_part() - part));
        search.run(self.num_nodes, sources, |search, node| {
            self.on.arcs_from(node).iter().for_each(|&(to, frames)| search.reach_state(to, frames));
        });
    }

    /// Costs found at the starts of entrances.
    pub fn costs_of_entrances(&self, search: &Dial) -> Vec<u16> {
        (0..self.entrances.len() as u32).map(|n| search.cost(self.entrance_state(n))).collect()
    }

    /// Costs found at the ends of exits.
    fn costs_of_exits(&self, search: &Dial) -> Vec<u16> {
        let mut costs = vec![UNREACHED; self.exits.len()];
        for l in &self.exit_steps {
            let cost = &mut costs[l.to as usize];
            *cost = (*cost).min(search.cost(l.from).saturating_add(l.frames));
        }
        costs
    }

    /// Node that an entrance begins at.
    pub fn entrance_state(&self, number: u32) -> u32 {
        2 * self.num_cells + number
    }

    /// Cell that an entrance begins at.
    pub fn entrance_cell(&self, number: u32) -> u32 {
        self.entrances[number as usize].2
    }

    /// End of an exit.
    pub fn landing(&self, number: u32) -> ExitLanding {
        self.exits[number as usize].2
    }

    /// Groups of places with the same key.
    fn groups(&self, keys: impl Iterator<Item = (u32, u32)>) -> Vec<PlaceGroup> {
        let mut groups = BTreeMap::new();
        for (number, key) in (0..).zip(keys) {
            let new = || PlaceGroup { beyond: key.0, is_tile: self.is_tile[key.0 as usize], places: Vec::new() };
            groups.entry(key).or_insert_with(new).places.push(number);
        }
        groups.into_values().collect()
    }
}

/// Keys in the order of their numbers, which are 0 and up.
fn by_number<K: Copy>(numbers: &BTreeMap<K, u32>) -> Vec<K> {
    let mut list: Vec<_> = numbers.iter().map(|(k, n)| (*n, *k)).collect();
    list.sort_by_key(|l| l.0);
    list.into_iter().map(|l| l.1).collect()
}
