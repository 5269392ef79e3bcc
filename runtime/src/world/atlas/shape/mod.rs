//! Shapes: least costs within districts, found once for all that are alike.

mod alike;
mod draft;
mod net;
mod plot;

use super::dial::{Arcs, Dial, UNREACHED};
use super::plane::Spot;
use alike::least_across;
use draft::Landing;
use net::Net;
pub(super) use plot::Plot;

/// What a district overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Beyond {
    /// A tile of a region.
    Tile(u32),
    /// Another district.
    District(u32),
}

impl Beyond {
    /// The tile, where it is one.
    pub fn tile(self) -> Option<u32> {
        if let Self::Tile(t) = self { Some(t) } else { None }
    }

    /// The district, where it is one.
    pub fn district(self) -> Option<u32> {
        if let Self::District(d) = self { Some(d) } else { None }
    }
}

/// Costs within districts that are alike: from where they are entered, to where they are left.
///
/// A way in begins at some cells, and a way out ends at some, each of them so much before or after the others: costs
/// leave that out, which is counted where one comes to those cells or goes on from there. Costs to single cells are for
/// who asks for them to search for, see [`Shape::back`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    num_cells: u32,
    /// Ways in: what each leads from, as a number in [`Plot::beyond`], and the cells there, each with what of the way is
    /// counted on coming there.
    pub ins: Vec<(u32, Vec<Spot>)>,
    /// Ways out: what each leads to.
    pub outs: Vec<u32>,
    /// Where each way out leads to, with what of the way is counted on going on from there. [Unit: frames]
    spots: Vec<Vec<(Landing, u16)>>,
    /// What costs to a way out are in the table beyond what they are. [Unit: frames]
    more: Vec<u16>,
    /// States that each way in begins at, see [`Shape::back`], with what is counted on coming there.
    starts: Vec<Vec<(u32, u16)>>,
    /// Least frames to leave by each way out, from each cell. [Size: outs * cells]
    to_out: Vec<u16>,
    /// The same from each way in. [Size: outs * ins]
    across: Vec<u16>,
    /// What leads to each state.
    back: Arcs<u32>,
}

impl Shape {
    /// Searches from every way in and to every way out.
    pub fn new(plot: &Plot<'_, '_>, search: &mut Dial) -> Self {
        let net = Net::new(plot);
        let [mut ins, outs] = net.ways(search);
        let mut out = Self { num_cells: plot.num_cells, ..Self::default() };
        let mut across = Vec::new();
        for way in &outs {
            net.search_back(way, search);
            out.to_out.extend((0..plot.num_cells).map(|c| search.cost(c)));
            across.push(net.costs_of_ins(search));
            out.outs.push(way.beyond);
            out.more.push(way.most());
            out.spots.push(way.places.iter().map(|&(n, part)| (net.landing(n), part)).collect());
        }
        let more = &out.more;
        ins.iter_mut().for_each(|way| way.fit(across.iter().zip(more).map(|(a, m)| (&a[..], *m))));
        for (costs, more) in across.iter().zip(more) {
            out.across.extend(ins.iter().map(|way| least_across(way, costs, *more)));
        }
        for way in &ins {
            out.starts.push(way.places.iter().map(|&(n, part)| (net.state_in(n), part)).collect());
            out.ins.push((way.beyond, way.places.iter().map(|&(n, part)| (net.cell_in(n), part)).collect()));
        }
        out.back = net.back;
        out
    }

    /// Number of states: the cells, those of blocks again where a link must follow, as after a joint between blocks, and
    /// the cells beyond that ways in begin at.
    pub fn num_states(&self) -> usize {
        self.back.num_nodes()
    }

    /// From where a state is come to, in so many frames.
    pub fn back(&self, state: u32) -> &[(u32, u16)] {
        self.back.of(state)
    }

    /// States that a way in begins at, each with what of the way is counted on coming there.
    pub fn starts(&self, way_in: u32) -> &[(u32, u16)] {
        &self.starts[way_in as usize]
    }

    /// Least frames from a cell to a way out. What lies at its cells may be below 0.
    pub fn to_out(&self, out: u32, cell: u32) -> f32 {
        frames(self.to_out[(out * self.num_cells + cell) as usize]) - f32::from(self.more[out as usize])
    }

    /// Least frames from a way in to a way out.
    pub fn across(&self, way_in: u32, out: u32) -> f32 {
        frames(self.across[out as usize * self.ins.len() + way_in as usize])
    }

    /// Where a way out leads to: how many copies away from the tile that it leads through, the cell there, and what is
    /// counted on going on from it.
    pub fn spots(&self, out: u32) -> impl ExactSizeIterator<Item = ([i32; 2], u32, f32)> {
        self.spots[out as usize].iter().map(|(l, part)| (l.way, l.cell, f32::from(*part)))
    }
}

fn frames(cost: u16) -> f32 {
    if cost == UNREACHED { f32::INFINITY } else { f32::from(cost) }
}
