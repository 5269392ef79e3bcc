//! Nets: the graph within a district, ready for searches.

use super::super::dial::{Arcs, Dial, UNREACHED};
use super::alike::{Group, Way, part};
use super::draft::{Draft, Landing, Leap};
use super::{Beyond, Plot};
use std::collections::BTreeMap;

/// The graph within a district. Its nodes are those of [`Draft`].
pub(super) struct Net {
    num_cells: u32,
    num_nodes: usize,
    on: Arcs<u32>,
    /// Turned around.
    pub back: Arcs<u32>,
    leaps: Vec<Leap>,
    /// Where ways in begin: what lies beyond, the class of the cell there, and the cell.
    ins: Vec<(u32, u32, u32)>,
    /// Where ways out end: what lies beyond, the sector, and where that is.
    outs: Vec<(u32, u32, Landing)>,
    /// Whether what lies beyond is a tile.
    is_tile: Vec<bool>,
}

impl Net {
    /// Draws it up.
    pub fn new(plot: &Plot<'_, '_>) -> Self {
        let Draft { arcs, leaps, ins, outs, .. } = Draft::new(plot);
        let num_nodes = 2 * plot.num_cells as usize + ins.len();
        Self {
            num_cells: plot.num_cells,
            num_nodes,
            on: Arcs::new(num_nodes, arcs.iter().copied()),
            back: Arcs::new(num_nodes, arcs.iter().map(|&(from, to, frames)| (to, from, frames))),
            leaps,
            ins: by_number(&ins),
            outs: by_number(&outs),
            is_tile: plot.beyond.iter().map(|b| matches!(b, Beyond::Tile(_))).collect(),
        }
    }

    /// Ways in and out: cells of a kind of which one is as good as another one, but for when one is there.
    pub fn ways(&self, search: &mut Dial) -> [Vec<Way>; 2] {
        let ins = self.groups(self.ins.iter().map(|i| (i.0, i.1)));
        let outs = self.groups(self.outs.iter().map(|o| (o.0, o.1)));
        let to = |group: &Group, search: &mut Dial| {
            self.search_back(&Way::of(group), search);
            self.costs_of_ins(search)
        };
        let costs_out: Vec<_> = outs.iter().map(|g| to(g, search)).collect();
        let from = |group: &Group, search: &mut Dial| {
            self.search_on(&Way::of(group), search);
            self.costs_of_outs(search)
        };
        let costs_in: Vec<_> = ins.iter().map(|g| from(g, search)).collect();
        [part(&ins, &costs_out), part(&outs, &costs_in)]
    }

    /// Searches for the least frames to a way out, and [`Way::most`] more.
    pub fn search_back(&self, way: &Way, search: &mut Dial) {
        let mut more = vec![None; self.outs.len()];
        way.places.iter().for_each(|&(n, part)| more[n as usize] = Some(way.most() - part));
        let sources = self.leaps.iter().filter_map(|l| Some((l.from, l.frames.saturating_add(more[l.to as usize]?))));
        search.run(self.num_nodes, sources, |search, node| {
            self.back.of(node).iter().for_each(|&(from, frames)| search.reach(from, frames));
        });
    }

    /// Searches for the least frames from a way in, and [`Way::most`] more.
    fn search_on(&self, way: &Way, search: &mut Dial) {
        let sources = way.places.iter().map(|&(n, part)| (self.state_in(n), way.most() - part));
        search.run(self.num_nodes, sources, |search, node| {
            self.on.of(node).iter().for_each(|&(to, frames)| search.reach(to, frames));
        });
    }

    /// What was found where ways in begin.
    pub fn costs_of_ins(&self, search: &Dial) -> Vec<u16> {
        (0..self.ins.len() as u32).map(|n| search.cost(self.state_in(n))).collect()
    }

    /// What was found where ways out end.
    fn costs_of_outs(&self, search: &Dial) -> Vec<u16> {
        let mut costs = vec![UNREACHED; self.outs.len()];
        for l in &self.leaps {
            let cost = &mut costs[l.to as usize];
            *cost = (*cost).min(search.cost(l.from).saturating_add(l.frames));
        }
        costs
    }

    /// Node that a way in begins at.
    pub fn state_in(&self, number: u32) -> u32 {
        2 * self.num_cells + number
    }

    /// Cell that a way in begins at.
    pub fn cell_in(&self, number: u32) -> u32 {
        self.ins[number as usize].2
    }

    /// Where a way out ends.
    pub fn landing(&self, number: u32) -> Landing {
        self.outs[number as usize].2
    }

    /// Those with the same key together.
    fn groups(&self, keys: impl Iterator<Item = (u32, u32)>) -> Vec<Group> {
        let mut groups = BTreeMap::new();
        for (number, key) in (0..).zip(keys) {
            let new = || Group { beyond: key.0, is_tile: self.is_tile[key.0 as usize], places: Vec::new() };
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
