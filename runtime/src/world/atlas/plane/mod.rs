//! Least costs on the endless plane of copies of a tile, without obstacles: found once a patch, looked up ever after.
//!
//! They are bounds: whatever stands on the ground, no way over it is faster.

mod far;
mod lattice;
#[cfg(test)]
mod tests;

use super::dial::{Arcs, Dial, UNREACHED};
use crate::patch::{CellRecord, NONE, Patches};
use far::Back;
use glam::Vec3;
use lattice::lattice;

/// Offsets up to this many copies away are in the table. [Unit: copies]
const RADIUS: i32 = 6;
/// Ways may lead this far around them.
const MARGIN: i32 = 2;
const SIDE: i32 = 2 * RADIUS + 1;
/// Offsets of a table. [Size: copies]
const NUM_OFFSETS: usize = (SIDE * SIDE) as usize;

/// A tile whose copies fill a plane. Its cells are of classes: those that are entered across each edge, and the inside.
///
/// Costs to the cells of a class are in rows: one an offset nearby, one a direction for all that is far away.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    /// Steps across each edge, in copies along two directions.
    pub steps: Vec<[i32; 2]>,
    num_cells: u32,
    num_classes: u32,
    back: Back,
    /// What a copy costs at least, for some directions. [Unit: frames/copy]
    prices: Vec<[f32; 2]>,
    /// Least frames from each cell to any cell of a class, beyond what its row costs. [Size: rows * cells]
    costs: Vec<u16>,
    /// What a row costs at least: for a direction, what its price leaves. [Unit: frames] [Size: rows]
    least: Vec<f32>,
    /// The least and the most over cells of a class, beyond what the row costs. [Size: rows * classes]
    spread: Vec<[u16; 2]>,
    /// Most that bounds of ways to the rim of the table are below what these cost. [Unit: frames]
    lack: f32,
}

/// Where costs to one offset are found: for a cell, those of [`Plane::cost`] in a row, and so much more.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Look {
    /// Number of the row.
    pub row: u32,
    /// [Unit: frames]
    pub more: f32,
}

/// What a row is about.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Row {
    /// A class that many copies away.
    Near(u32, [i32; 2]),
    /// Any class far away, by the price of a direction.
    Far([f32; 2]),
}

/// Class of a cell: its edge, past the last one the inside.
pub(crate) fn class(cell: &CellRecord, num_edges: u32) -> u32 {
    if cell.edge == NONE { num_edges } else { cell.edge }
}

impl Plane {
    /// The table of a patch; none for blocks, and for tiles whose copies form a line or no lattice.
    pub fn new(patches: &Patches<'_>, patch: usize) -> Option<Self> {
        let edges = patches.edges_of(patch);
        let vectors: Vec<Vec3> = edges.iter().map(|e| Vec3::from_array(e.step)).collect();
        let steps = lattice(&vectors)?;
        let cells = patches.cells_of(patch);
        let back = arcs_back(patches, patch, &steps);
        let mut out = Self {
            num_cells: cells.len() as u32,
            num_classes: edges.len() as u32 + 1,
            prices: far::prices(&back, cells.len() as u32),
            steps,
            back,
            costs: Vec::new(),
            least: Vec::new(),
            spread: Vec::new(),
            lack: 0.0,
        };
        out.add_far(cells);
        let (mut search, around) = (Dial::default(), out.around());
        for class in 0..out.num_classes {
            out.add_near(cells, class, &around, &mut search);
        }
        out.lack = out.most_lack();
        Some(out)
    }

    /// Calls `visit` for every link that leads to a cell, with how many copies away that leads, the cell that it begins
    /// in, and its frames.
    pub fn for_each_link_to(&self, cell: u32, mut visit: impl FnMut([i32; 2], u32, u16)) {
        self.back.of(cell).iter().for_each(|&((way, from), frames)| visit(way, from, frames));
    }

    /// Number of classes of cells.
    pub fn num_classes(&self) -> u32 {
        self.num_classes
    }

    /// Where costs to cells of a class are found, that many copies away.
    pub fn look(&self, class: u32, way: [i32; 2]) -> Look {
        if way.iter().all(|w| w.abs() <= RADIUS) {
            let row = self.first_near() + class * NUM_OFFSETS as u32 + offset(way);
            return Look { row, more: 0.0 };
        }
        self.look_far(class, way)
    }

    fn look_far(&self, class: u32, way: [i32; 2]) -> Look {
        let mut best = Look { row: 0, more: f32::NEG_INFINITY };
        for (k, p) in self.prices.iter().enumerate() {
            let row = k as u32 * self.num_classes + class;
            let more = p[0] * way[0] as f32 + p[1] * way[1] as f32 + self.least[row as usize];
            best = if more > best.more { Look { row, more } } else { best };
        }
        best
    }

    /// Cost from a cell; infinite where there is no way. [Unit: frames]
    pub fn cost(&self, look: Look, cell: u32) -> f32 {
        (self.beyond(look.row, cell) + look.more).max(0.0)
    }

    /// The least cost from any cell of a class. [Unit: frames]
    pub fn least(&self, look: Look, class: u32) -> f32 {
        (frames(self.spread[(look.row * self.num_classes + class) as usize][0]) + look.more).max(0.0)
    }

    /// The least cost from any cell. [Unit: frames]
    pub fn least_of_all(&self, look: Look) -> f32 {
        (0..self.num_classes).map(|class| self.least(look, class)).fold(f32::INFINITY, f32::min)
    }

    /// The highest cost from any cell of a class, with what bounds of far ways may lack; infinite where there is a cell
    /// without a way. [Unit: frames]
    pub fn most(&self, look: Look, class: u32) -> f32 {
        frames(self.spread[(look.row * self.num_classes + class) as usize][1]) + look.more + if look.row < self.first_near() { self.lack } else { 0.0 }
    }

    /// What a cell costs beyond what its row does; infinite where there is no way. [Unit: frames]
    pub fn beyond(&self, row: u32, cell: u32) -> f32 {
        frames(self.costs[(row * self.num_cells + cell) as usize])
    }

    /// What all rows are about, in their order.
    pub fn rows(&self) -> impl Iterator<Item = Row> {
        let far = self.prices.iter().flat_map(|&p| (0..self.num_classes).map(move |_| Row::Far(p)));
        let near = (0..self.num_classes).flat_map(|class| offsets().map(move |way| Row::Near(class, way)));
        far.chain(near)
    }

    fn first_near(&self) -> u32 {
        self.prices.len() as u32 * self.num_classes
    }

    /// A row for each price and class; prices that turn out to earn are left out.
    fn add_far(&mut self, cells: &[CellRecord]) {
        let mut kept = Vec::new();
        for price in std::mem::take(&mut self.prices) {
            let rest = |c| far::rest(&self.back, price, cells_of(cells, c, self.num_classes - 1), self.num_cells);
            let rests: Option<Vec<_>> = (0..self.num_classes).map(rest).collect();
            let Some(rests) = rests else { continue };
            kept.push(price);
            for rest in rests {
                let least = rest.iter().copied().fold(f32::INFINITY, f32::min);
                let least = if least < f32::INFINITY { least.floor() } else { 0.0 };
                self.add_row(cells, least, &rest.iter().map(|r| r - least).collect::<Vec<_>>());
            }
        }
        self.prices = kept;
    }

    fn add_near(&mut self, cells: &[CellRecord], class: u32, all_around: &[f32], search: &mut Dial) {
        let (wide, n) = (RADIUS + MARGIN, self.num_cells);
        let across = 2 * wide + 1;
        let number = |[x, z]: [i32; 2], cell: u32| ((x + wide) * across + z + wide) as u32 * n + cell;
        let targets = cells_of(cells, class, self.num_classes - 1).map(|c| (number([0, 0], c), 0));
        search.run((across * across) as usize * cells.len(), targets, |search, state| {
            let (tile, cell) = ((state / n) as i32, state % n);
            let [x, z] = [tile / across - wide, tile % across - wide];
            for &(([dx, dz], from), frames) in self.back.of(cell) {
                let at = [x - dx, z - dz];
                if at[0].abs() <= wide && at[1].abs() <= wide {
                    search.reach(number(at, from), frames);
                }
            }
        });
        // Where no way leads at all, none leads from far away.
        let leads = |plane: &Self, cell| plane.prices.is_empty() || plane.beyond(class, cell) < f32::INFINITY;
        let around = |plane: &Self, most, cell| if leads(plane, cell) { most } else { f32::INFINITY };
        for (way, &most) in offsets().zip(all_around) {
            // The target lies there as seen from where this is.
            let cost = |cell| frames(search.cost(number([-way[0], -way[1]], cell))).min(around(self, most, cell));
            let costs: Vec<f32> = (0..n).map(cost).collect();
            self.add_row(cells, 0.0, &costs);
        }
    }

    fn most_lack(&self) -> f32 {
        let rim = || offsets().filter(|o| o[0].abs().max(o[1].abs()) == RADIUS);
        let pairs = (0..self.num_classes).flat_map(|c| rim().map(move |o| (c, o)));
        let lacks = pairs.flat_map(|(class, way)| {
            let (near, far) = (self.look(class, way), self.look_far(class, way));
            (0..self.num_cells).map(move |cell| self.cost(near, cell) - self.cost(far, cell))
        });
        lacks.filter(|l| *l < f32::INFINITY).fold(0.0, f32::max)
    }

    fn add_row(&mut self, cells: &[CellRecord], least: f32, costs: &[f32]) {
        let first = self.costs.len();
        let whole = |c: f32| if c < f32::INFINITY { c.floor().min(f32::from(UNREACHED) - 1.0) as u16 } else { UNREACHED };
        self.costs.extend(costs.iter().copied().map(whole));
        self.least.push(least);
        for c in 0..self.num_classes {
            let of = || cells_of(cells, c, self.num_classes - 1).map(|cell| self.costs[first + cell as usize]);
            self.spread.push([of().min().unwrap_or(UNREACHED), of().max().unwrap_or(UNREACHED)]);
        }
    }

    /// For each offset, what a way costs at least that leads farther around than ways are followed for the table.
    fn around(&self) -> Vec<f32> {
        let classes = self.num_classes as usize;
        let leasts = self.least.chunks(classes).map(|l| l.iter().copied().fold(f32::INFINITY, f32::min));
        let prices: Vec<_> = self.prices.iter().copied().zip(leasts).collect();
        let along = |way: [i32; 2]| {
            prices.iter().map(|(p, l)| p[0] * way[0] as f32 + p[1] * way[1] as f32 + l).fold(0.0, f32::max)
        };
        // A link leads over two copies at most.
        let rims = [RADIUS + MARGIN + 1, RADIUS + MARGIN + 2];
        let rim = rims.iter().flat_map(|&w| (-w..=w).flat_map(move |a| [[a, w], [a, -w], [w, a], [-w, a]]));
        let rim: Vec<_> = rim.map(|r| (r, along(r))).collect();
        let way = |to: [i32; 2]| {
            rim.iter().map(|(r, out)| out + along([to[0] - r[0], to[1] - r[1]])).fold(f32::INFINITY, f32::min)
        };
        offsets().map(way).collect()
    }
}

/// Arcs from each cell back to where links to it begin.
fn arcs_back(patches: &Patches<'_>, patch: usize, steps: &[[i32; 2]]) -> Back {
    let cells = patches.cells_of(patch);
    let list = patches.links_of(patch).iter().map(|l| {
        let to = &cells[l.to as usize];
        let exit = to.is(CellRecord::IS_EXIT);
        let (cell, step) = if exit { (to.twin, steps[to.edge as usize]) } else { (l.to, [0, 0]) };
        (cell, (step, l.from), l.num_frames)
    });
    Arcs::new(cells.len(), list)
}

/// Cells of a class.
fn cells_of(cells: &[CellRecord], of: u32, num_edges: u32) -> impl Iterator<Item = u32> {
    let is = move |c: &CellRecord| !c.is(CellRecord::IS_EXIT) && class(c, num_edges) == of;
    cells.iter().enumerate().filter(move |(_, c)| is(c)).map(|(k, _)| k as u32)
}

/// The offsets of a table, in their order. [Unit: copies]
pub(super) fn offsets() -> impl Iterator<Item = [i32; 2]> {
    (0..SIDE * SIDE).map(|n| [n / SIDE - RADIUS, n % SIDE - RADIUS])
}

/// Number of an offset within the table.
fn offset([du, dv]: [i32; 2]) -> u32 {
    ((du + RADIUS) * SIDE + dv + RADIUS) as u32
}

fn frames(cost: u16) -> f32 {
    if cost == UNREACHED { f32::INFINITY } else { f32::from(cost) }
}
