//! Shapes: least costs within districts, found once for all that are alike.

mod draft;
mod plot;

use super::dial::{Arcs, Dial, UNREACHED};
use super::plane::{Look, Plane, Row};
use draft::{Draft, Landing};
pub(super) use plot::Plot;
use std::collections::BTreeSet;

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
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    num_cells: u32,
    num_ins: u32,
    /// Ways in: what each leads from, as a number in [`Plot::beyond`], and the cells there.
    pub ins: Vec<(u32, Vec<u32>)>,
    /// Ways out: what each leads to.
    pub outs: Vec<u32>,
    /// Least frames to leave by each way out, from each cell and then from each way in. [Size: outs * (cells + ins)]
    to_out: Vec<u16>,
    /// Least frames from each way in to each cell. [Size: ins * cells]
    from_in: Vec<u16>,
    /// For each row of a plane and each way out to a tile, least frames from where that leads to on to what the row is
    /// about, as seen from the tile and beyond what the row costs there. [Size: rows * outs]
    landings: Vec<f32>,
    /// Where each way out leads to.
    spots: Vec<Vec<Landing>>,
}

impl Shape {
    /// Searches from every way in and to every way out.
    pub fn new(plot: &Plot<'_, '_>, search: &mut Dial) -> Self {
        let Draft { arcs, leaps, ins, outs, .. } = Draft::new(plot);
        let mut out = Self { num_cells: plot.num_cells, num_ins: ins.len() as u32, ..Self::default() };
        let num_nodes = 2 * plot.num_cells + out.num_ins;
        out.ins = vec![(0, Vec::new()); ins.len()];
        for (&(beyond, _), (n, cells)) in &ins {
            out.ins[(n - 2 * plot.num_cells) as usize] = (beyond, cells.iter().copied().collect());
        }
        out.outs = vec![0; outs.len()];
        outs.iter().for_each(|(key, &n)| out.outs[n as usize] = key.0);
        let on = Arcs::new(num_nodes as usize, arcs.iter().copied());
        let back = Arcs::new(num_nodes as usize, arcs.iter().map(|&(from, to, frames)| (to, from, frames)));
        drop(arcs);
        for k in 0..outs.len() as u32 {
            let sources = leaps.iter().filter(|l| l.out == k).map(|l| (l.from, l.frames));
            search.run(num_nodes as usize, sources, |search, node| {
                back.of(node).iter().for_each(|&(from, frames)| search.reach(from, frames));
            });
            out.to_out.extend((0..plot.num_cells).map(|c| search.cost(c)));
            out.to_out.extend((2 * plot.num_cells..num_nodes).map(|n| search.cost(n)));
            let spots: BTreeSet<Landing> = leaps.iter().filter(|l| l.out == k).map(|l| l.to).collect();
            out.spots.push(spots.into_iter().collect());
        }
        for node in 2 * plot.num_cells..num_nodes {
            search.run(num_nodes as usize, [(node, 0)].into_iter(), |search, node| {
                on.of(node).iter().for_each(|&(to, frames)| search.reach(to, frames));
            });
            out.from_in.extend((0..plot.num_cells).map(|c| search.cost(c)));
        }
        out
    }

    /// Least frames from a cell to a way out.
    pub fn to_out(&self, out: u32, cell: u32) -> f32 {
        frames(self.to_out[(out * (self.num_cells + self.num_ins) + cell) as usize])
    }

    /// Least frames from a way in to a way out.
    pub fn across(&self, way_in: u32, out: u32) -> f32 {
        self.to_out(out, self.num_cells + way_in)
    }

    /// Least frames from a way in to a cell.
    pub fn reach(&self, way_in: u32, cell: u32) -> f32 {
        frames(self.from_in[(way_in * self.num_cells + cell) as usize])
    }

    /// Least frames from where a way out leads to, see [`Plane::look`] from the tile that it leads through.
    pub fn landing(&self, out: u32, look: Look) -> f32 {
        (self.landings[look.row as usize * self.outs.len() + out as usize] + look.more).max(0.0)
    }

    /// Where a way out leads to: how many copies away from the tile that it leads through, and the cell there.
    pub fn spots(&self, out: u32) -> impl Iterator<Item = ([i32; 2], u32)> {
        self.spots[out as usize].iter().map(|l| (l.way, l.cell))
    }

    /// Works out what follows after ways out, when planes know all goals.
    pub fn add_landings(&mut self, plot: &Plot<'_, '_>, planes: &[Option<Plane>]) {
        for (out, (&beyond, spots)) in self.outs.iter().zip(&self.spots).enumerate() {
            let Beyond::Tile(tile) = plot.beyond[beyond as usize] else { continue };
            let Some(plane) = &planes[plot.graph.instance(tile).patch as usize] else { continue };
            for (number, row) in plane.rows().enumerate() {
                let size = (number + 1) * self.outs.len();
                if self.landings.len() < size {
                    self.landings.resize(size, f32::INFINITY);
                }
                let costs = spots.iter().map(|l| from_landing(plane, number as u32, row, l));
                self.landings[number * self.outs.len() + out] = costs.fold(f32::INFINITY, f32::min);
            }
        }
    }
}

/// Least frames from where a way out leads to on to what a row is about, beyond what the row costs from the tile.
fn from_landing(plane: &Plane, number: u32, row: Row, landing: &Landing) -> f32 {
    let [du, dv] = landing.way;
    match row {
        Row::Near(goal, [u, v]) => plane.cost(plane.look(goal, [u - du, v - dv]), landing.cell),
        Row::Far(price) => plane.beyond(number, landing.cell) - price[0] * du as f32 - price[1] * dv as f32,
    }
}

fn frames(cost: u16) -> f32 {
    if cost == UNREACHED { f32::INFINITY } else { f32::from(cost) }
}
