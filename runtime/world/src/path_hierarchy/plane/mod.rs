//! Least costs on the endless plane of copies of a tile, without obstacles: computed once for a patch, then looked up.
//!
//! They are lower bounds for any obstacles on the ground.

mod far;
mod lattice;
#[cfg(test)]
mod tests;

use super::dial::{Arcs, Dial, UNREACHED, frames, whole};
use far::BackwardArcs;
use glam::Vec3;
use lattice::lattice;
use serde::{Deserialize, Serialize};
use throng_core::patch::{CellRecord, NONE, PatchTables};

/// Costs to the cells of a class are in the table up to this many copies away (copies).
const RADIUS: i32 = 6;
/// Radius of offsets with rows for other goals, of which there are many (copies).
const GOAL_RADIUS: i32 = 3;
/// Largest offset for which the best price is in a table (copies).
const FAR: i32 = 48;
/// Prices and least costs of a file are within this of 0: it is more than any path costs, and sums of it are finite
/// (frames).
const CREDIBLE: f32 = 1e9;
/// Margin around the offsets through which paths may lead (copies).
const MARGIN: i32 = 2;

/// Cell, with an additional cost on reaching it (frames).
pub(crate) type CellCost = (u32, u16);

/// Tile whose copies fill a plane. Its cells are of classes: those that are entered across each edge, and the inside.
///
/// Costs to *goals*, which are sets of cells, are in rows: for each goal one row a direction for everything far away,
/// and then one an offset nearby. The first goals are the classes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct TilePlane {
    /// Steps across each edge, in copies along two directions.
    #[serde(with = "crate::pod")]
    pub steps: Vec<[i32; 2]>,
    num_cells: u32,
    /// Cells of each class.
    classes: Vec<Vec<u32>>,
    #[serde(skip)]
    back: BackwardArcs,
    /// Least cost of a copy, for one or more directions (frames/copy).
    #[serde(with = "crate::pod")]
    prices: Vec<[f32; 2]>,
    /// Least rest of a path from any cell to any other, for each price (frames).
    #[serde(with = "crate::pod")]
    leasts: Vec<f32>,
    /// Number of the best price by offset (offsets up to `FAR`).
    #[serde(with = "crate::pod")]
    best_prices: Vec<u16>,
    goals: Vec<PlaneGoal>,
    /// Least frames from each cell, beyond what its row costs (rows * cells).
    #[serde(with = "crate::pod")]
    costs: Vec<u16>,
    /// Least cost of a row; for a direction, the rest after its price (frames, rows).
    #[serde(with = "crate::pod")]
    least: Vec<f32>,
    /// The least over cells of a class, beyond what the row costs (rows * classes).
    #[serde(with = "crate::pod")]
    least_of: Vec<u16>,
    /// Bound of the distance of a row's costs below those of the paths found; infinite without a path (rows).
    #[serde(with = "crate::pod")]
    slack: Vec<f32>,
    /// Goal that consists of one cell alone; [`NONE`] where none does (cells).
    #[serde(with = "crate::pod")]
    goal_of: Vec<u32>,
    /// Cells in which one can stay, and the goal of all of them.
    #[serde(with = "crate::pod")]
    rest_cells: Vec<u32>,
    rest: Option<u32>,
}

/// Goal: cells that paths lead to.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct PlaneGoal {
    /// Cells of the goal, each with its additional cost.
    cells: Vec<CellCost>,
    first_row: u32,
    radius: i32,
}

/// Rows of a goal.
pub(crate) struct GoalRows {
    goal: PlaneGoal,
    rows: Vec<RowCosts>,
}

/// Least cost of a row, costs beyond it, and the rounding lost.
struct RowCosts {
    least: f32,
    beyond: Vec<u16>,
    slack: f32,
}

/// Location of the costs to a goal at an offset: for a cell, the sum of [`TilePlane::cost`] in a row and `more`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CostLookup {
    /// Number of the row.
    pub row: u32,
    /// (frames)
    pub more: f32,
}

/// Class of a cell: its edge, past the last one the inside.
pub(crate) fn class_of(cell: &CellRecord, num_edges: u32) -> u32 {
    if cell.edge == NONE { num_edges } else { cell.edge }
}

impl TilePlane {
    /// Table of a patch; none for blocks, and for tiles whose copies form a line or no lattice.
    pub fn new(patches: &PatchTables, patch: usize, search: &mut Dial) -> Option<Self> {
        let edges = patches.edges_of(patch);
        let vectors: Vec<Vec3> = edges.iter().map(|e| Vec3::from_array(e.step)).collect();
        let steps = lattice(&vectors)?;
        let (cells, num_edges) = (patches.cells_of(patch), edges.len() as u32);
        let back = arcs_back(patches, patch, &steps);
        let prices = far::least_prices(&back, cells.len() as u32);
        let mut out = Self {
            steps,
            num_cells: cells.len() as u32,
            classes: (0..=num_edges).map(|c| cells_of(cells, c, num_edges).collect()).collect(),
            back,
            goal_of: vec![NONE; cells.len()],
            rest_cells: (0..cells.len() as u32).filter(|&c| cells[c as usize].has_flags(CellRecord::IS_REST)).collect(),
            ..Self::default()
        };
        let all: Vec<u32> = out.classes.concat();
        for price in prices {
            if let Some(rest) = far::rest_costs(&out.back, price, all.iter().map(|&c| (c, 0)), out.num_cells) {
                out.prices.push(price);
                out.leasts.push(rest.into_iter().fold(f32::INFINITY, f32::min));
            }
        }
        if out.prices.is_empty() {
            // No path costs less than nothing.
            out.prices.push([0.0, 0.0]);
            out.leasts.push(0.0);
        }
        out.best_prices = offsets(FAR).map(|offset| out.best_price(offset) as u16).collect();
        for class in 0..=num_edges as usize {
            let cells: Vec<_> = out.classes[class].iter().map(|&c| (c, 0)).collect();
            let rows = out.rows_of(&cells, RADIUS, search);
            out.add_goal(rows);
        }
        Some(out)
    }

    /// True where all entries of a table read from a file are in range, and costs are numbers.
    ///
    /// - `num_cells`, `num_edges`: of its patch.
    pub fn is_sound(&self, num_cells: u32, num_edges: u32) -> bool {
        let (rows, n, classes) = (self.least.len(), num_cells as usize, num_edges as usize + 1);
        let is_goal = |g: u32| (g as usize) < self.goals.len();
        let num_rows = |g: &PlaneGoal| self.prices.len() + (2 * g.radius as usize + 1).pow(2);
        let goal = |g: &PlaneGoal| {
            (0..=RADIUS).contains(&g.radius)
                && (g.first_row as usize).checked_add(num_rows(g)).is_some_and(|end| end <= rows)
                && g.cells.iter().all(|c| c.0 < num_cells)
        };
        let mut costs = self.prices.iter().flatten().chain(&self.leasts).chain(&self.least);
        costs.all(|c| c.abs() <= CREDIBLE)
            && self.num_cells == num_cells
            && self.classes.len() == classes
            && !self.prices.is_empty()
            && self.leasts.len() == self.prices.len()
            && self.best_prices.len() == (2 * FAR as usize + 1).pow(2)
            && self.best_prices.iter().all(|&p| usize::from(p) < self.prices.len())
            && (self.goals.len() >= classes && self.goals.iter().all(goal))
            && rows.checked_mul(n) == Some(self.costs.len())
            && rows.checked_mul(classes) == Some(self.least_of.len())
            && self.slack.len() == rows
            && (self.goal_of.len() == n && self.goal_of.iter().all(|&g| g == NONE || is_goal(g)))
            && self.rest.is_none_or(is_goal)
    }

    /// Number of goals.
    pub fn num_goals(&self) -> usize {
        self.goals.len()
    }

    /// Number of a goal that was added.
    pub fn goal(&self, cells: &[CellCost]) -> Option<u32> {
        self.goals.iter().position(|g| g.cells == cells).map(|g| g as u32)
    }

    /// Cells of a goal.
    pub fn cells(&self, goal: u32) -> &[CellCost] {
        &self.goals[goal as usize].cells
    }

    /// The goal of one cell, or of all rest cells where none is given; none where there is no such goal.
    pub fn goal_at(&self, cell: Option<u32>) -> Option<u32> {
        cell.map_or(self.rest, |c| Some(self.goal_of[c as usize])).filter(|g| *g != NONE)
    }

    /// Rest cells, each as a goal, and all of them as one: the most frequent goals.
    pub fn is_rest_goal(&self) -> Vec<Vec<CellCost>> {
        let all = (!self.rest_cells.is_empty()).then(|| self.rest_cells.iter().map(|&c| (c, 0)).collect());
        self.rest_cells.iter().map(|&c| vec![(c, 0)]).chain(all).collect()
    }

    /// Adds the rows of a goal.
    pub fn add_goal(&mut self, rows: GoalRows) {
        let number = self.goals.len() as u32;
        if let [(cell, 0)] = rows.goal.cells[..] {
            self.goal_of[cell as usize] = number;
        }
        if rows.goal.cells.iter().copied().eq(self.rest_cells.iter().map(|&c| (c, 0))) {
            self.rest = Some(number);
        }
        self.goals.push(PlaneGoal { first_row: self.least.len() as u32, ..rows.goal });
        for row in rows.rows {
            self.least.push(row.least);
            self.slack.push(row.slack);
            for class in &self.classes {
                let of = class.iter().map(|&c| row.beyond[c as usize]);
                self.least_of.push(of.min().unwrap_or(UNREACHED));
            }
            self.costs.extend(row.beyond);
        }
    }

    /// Works out the rows of a cell, for goals that are no classes.
    pub fn rows_to(&self, cell: u32, search: &mut Dial) -> GoalRows {
        self.rows_of(&[(cell, 0)], GOAL_RADIUS, search)
    }

    /// Rows of a goal from those of its cells, each with its additional cost.
    pub fn join_costs(&self, parts: &[(&GoalRows, u16)]) -> GoalRows {
        let cells = parts.iter().flat_map(|&(rows, cost)| rows.goal.cells.iter().map(move |c| (c.0, c.1 + cost)));
        let goal = PlaneGoal { cells: cells.collect(), first_row: 0, radius: GOAL_RADIUS };
        let num_rows = parts.first().map_or(0, |p| p.0.rows.len());
        let rows = (0..num_rows).map(|k| {
            let row = |p: &(&'_ GoalRows, u16)| p.0.rows[k].least + f32::from(p.1);
            let least = parts.iter().map(row).fold(f32::INFINITY, f32::min);
            let slack = parts.iter().map(|p| p.0.rows[k].slack).fold(0.0, f32::max);
            let mut beyond = vec![UNREACHED; self.num_cells as usize];
            for (rows, cost) in parts {
                let more = (rows.rows[k].least + f32::from(*cost) - least) as u16;
                for (to, from) in beyond.iter_mut().zip(&rows.rows[k].beyond).filter(|(_, from)| **from != UNREACHED) {
                    *to = (*to).min(from.saturating_add(more).min(UNREACHED - 1));
                }
            }
            RowCosts { least, beyond, slack }
        });
        GoalRows { rows: rows.collect(), goal }
    }

    /// Location of the costs to a goal at an offset (copies).
    pub fn lookup(&self, goal: u32, offset: [i32; 2]) -> CostLookup {
        let g = &self.goals[goal as usize];
        if offset.iter().all(|w| w.abs() <= g.radius) {
            let row = g.first_row + self.prices.len() as u32 + offset_number(offset, g.radius);
            return CostLookup { row, more: 0.0 };
        }
        let k = match offset.iter().all(|w| w.abs() <= FAR) {
            true => u32::from(self.best_prices[offset_number(offset, FAR) as usize]),
            false => self.best_price(offset),
        };
        let (p, row) = (self.prices[k as usize], g.first_row + k);
        CostLookup { row, more: p[0] * offset[0] as f32 + p[1] * offset[1] as f32 + self.least[row as usize] }
    }

    /// Number of the price that gives the highest lower bound of a path.
    fn best_price(&self, offset: [i32; 2]) -> u32 {
        let mut best = (0, f32::NEG_INFINITY);
        for ((k, p), least) in (0..).zip(&self.prices).zip(&self.leasts) {
            let cost = p[0] * offset[0] as f32 + p[1] * offset[1] as f32 + least;
            best = if cost > best.1 { (k, cost) } else { best };
        }
        best.0
    }

    /// Cost from a cell; infinite where there is no path (frames).
    pub fn cost(&self, lookup: CostLookup, cell: u32) -> f32 {
        (frames(self.costs[(lookup.row * self.num_cells + cell) as usize]) + lookup.more).max(0.0)
    }

    /// The least cost from any cell of a class (frames).
    pub fn least(&self, lookup: CostLookup, class: u32) -> f32 {
        let beyond = self.least_of[lookup.row as usize * self.classes.len() + class as usize];
        (frames(beyond) + lookup.more).max(0.0)
    }

    /// The least cost from any cell (frames).
    pub fn least_of_all(&self, lookup: CostLookup) -> f32 {
        (0..self.classes.len() as u32).map(|class| self.least(lookup, class)).fold(f32::INFINITY, f32::min)
    }

    /// Highest cost to a goal from any cell of another goal nearby, beyond the cost of that cell there: no path to the
    /// best cell costs more. Infinite where the goal is far away, or the cost is not known (frames).
    pub fn most(&self, to: u32, offset: [i32; 2], from: u32) -> f32 {
        if offset.iter().any(|w| w.abs() > self.goals[to as usize].radius) {
            return f32::INFINITY;
        }
        let lookup = self.lookup(to, offset);
        let costs = self.cells(from).iter().map(|&(cell, cost)| self.cost(lookup, cell) - f32::from(cost));
        costs.fold(0.0, f32::max) + self.slack[lookup.row as usize]
    }

    fn rows_of(&self, cells: &[CellCost], radius: i32, search: &mut Dial) -> GoalRows {
        let mut out = GoalRows { goal: PlaneGoal { cells: cells.to_vec(), first_row: 0, radius }, rows: Vec::new() };
        for (&price, &least) in self.prices.iter().zip(&self.leasts) {
            // Where no more is known, as much is left as of any path.
            let rest = far::rest_costs(&self.back, price, cells.iter().copied(), self.num_cells)
                .unwrap_or_else(|| vec![least; self.num_cells as usize]);
            let least = rest.iter().copied().fold(f32::INFINITY, f32::min);
            let least = if least < f32::INFINITY { least.floor() } else { 0.0 };
            let beyond = rest.iter().map(|r| whole(r - least)).collect();
            out.rows.push(RowCosts { least, beyond, slack: f32::INFINITY });
        }
        self.add_near(&mut out, radius, search);
        out
    }

    /// Adds a row for each offset nearby.
    fn add_near(&self, rows: &mut GoalRows, radius: i32, search: &mut Dial) {
        let (wide, n) = (radius + MARGIN, self.num_cells);
        let across = 2 * wide + 1;
        let number = |[x, z]: [i32; 2], cell: u32| ((x + wide) * across + z + wide) as u32 * n + cell;
        let goal = rows.goal.cells.iter().map(|&(c, cost)| (number([0, 0], c), cost));
        search.run((across * across) as usize * n as usize, goal, |search, state| {
            let (tile, cell) = ((state / n) as i32, state % n);
            let [x, z] = [tile / across - wide, tile % across - wide];
            for &(([dx, dz], from), frames) in self.back.arcs_from(cell) {
                let at = [x - dx, z - dz];
                if at[0].abs() <= wide && at[1].abs() <= wide {
                    search.reach_state(number(at, from), frames);
                }
            }
        });
        // Where no path leads at all, none leads from far away.
        let leads: Vec<bool> = rows.rows[0].beyond.iter().map(|c| *c != UNREACHED).collect();
        for (offset, around) in offsets(radius).zip(self.around(radius)) {
            // The goal lies there as seen from where this is.
            let found = |cell| frames(search.cost(number([-offset[0], -offset[1]], cell)));
            let (mut beyond, mut slack) = (Vec::with_capacity(n as usize), 0f32);
            for cell in 0..n {
                let found = found(cell);
                let cost = if leads[cell as usize] { found.min(around) } else { found };
                beyond.push(whole(cost));
                // The largest stored cost may stand for a larger one.
                let most = if whole(found) >= UNREACHED - 1 { f32::INFINITY } else { found };
                slack = if cost < f32::INFINITY { slack.max(most - cost.floor()) } else { slack };
            }
            rows.rows.push(RowCosts { least: 0.0, beyond, slack });
        }
    }

    /// Lower bound for each offset of the cost of paths that lead farther around than paths are followed for the table.
    fn around(&self, radius: i32) -> Vec<f32> {
        let along = |offset: [i32; 2]| {
            let prices = self.prices.iter().zip(&self.leasts);
            prices.map(|(p, l)| p[0] * offset[0] as f32 + p[1] * offset[1] as f32 + l).fold(0.0, f32::max)
        };
        // A link leads over two copies at most.
        let rims = [radius + MARGIN + 1, radius + MARGIN + 2];
        let rim = rims.iter().flat_map(|&w| (-w..=w).flat_map(move |a| [[a, w], [a, -w], [w, a], [-w, a]]));
        let rim: Vec<_> = rim.map(|r| (r, along(r))).collect();
        let offset = |to: [i32; 2]| {
            rim.iter().map(|(r, out)| out + along([to[0] - r[0], to[1] - r[1]])).fold(f32::INFINITY, f32::min)
        };
        offsets(radius).map(offset).collect()
    }
}

/// Arcs from each cell back to where links to it begin.
fn arcs_back(patches: &PatchTables, patch: usize, steps: &[[i32; 2]]) -> BackwardArcs {
    let cells = patches.cells_of(patch);
    let list = patches.links_of(patch).iter().filter(|l| !l.is_for_two()).map(|l| {
        let to = &cells[l.to as usize];
        let exit = to.has_flags(CellRecord::IS_EXIT);
        let (cell, step) = if exit { (to.twin, steps[to.edge as usize]) } else { (l.to, [0, 0]) };
        (cell, (step, l.from), l.num_frames)
    });
    Arcs::new(cells.len(), list)
}

/// Cells of a class.
fn cells_of(cells: &[CellRecord], of: u32, num_edges: u32) -> impl Iterator<Item = u32> {
    let is = move |c: &CellRecord| !c.has_flags(CellRecord::IS_EXIT) && class_of(c, num_edges) == of;
    cells.iter().enumerate().filter(move |(_, c)| is(c)).map(|(k, _)| k as u32)
}

/// The offsets of a table, in their order (copies).
fn offsets(radius: i32) -> impl Iterator<Item = [i32; 2]> {
    let side = 2 * radius + 1;
    (0..side * side).map(move |n| [n / side - radius, n % side - radius])
}

/// Number of an offset within the table.
fn offset_number([du, dv]: [i32; 2], radius: i32) -> u32 {
    ((du + radius) * (2 * radius + 1) + dv + radius) as u32
}
