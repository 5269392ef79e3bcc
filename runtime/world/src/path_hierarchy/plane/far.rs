//! Lower bounds of the costs of far paths, which grow with distance.
//!
//! A price for every copy passed along each direction of the lattice is subtracted from the costs of links. As long as
//! no cycle of links then has a negative cost, the rest of the cost from a cell to the target is at least the least
//! rest between their kinds, wherever the copies are; the price of all the copies between is added. Prices without
//! negative cycles lie in a polygon, with a side for some of the cycles of links that lead somewhere at the least cost
//! (least ratio cycles, Lawler 1967); the highest price of any path is at one of its corners.

use super::super::dial::Arcs;
use throng_base::maths;

/// Prices are never higher: where no cycle leads along a direction at all (frames/copy).
const HIGHEST: f32 = 5e3;
/// Prices are that much below what still has no cycle that earns, so that rounding makes none.
const CARE: f32 = 1e-4;
/// Tolerance below 0 of costs that count as none: of a million links together, less than `SLACK` (frames).
const NOTHING: f64 = 1e-8;
/// Bound of the sum of these tolerances and of rounding in table look-ups (frames).
const SLACK: f64 = 0.1;
/// Rounds after which a price is given up: what a path costs is known one link a round where its cells ascend, sooner
/// elsewhere; more of them find bounds for longer paths, and take as much longer where none is found.
const MAX_ROUNDS: usize = 200;
/// A corner that would be lowered by a smaller share is not cut into two: bounds are lower by that share, and searches
/// fewer.
const NEAR: f64 = 2e-3;
/// Prices are no farther from the next ones than that share of the highest one: closer ones would bound paths that are
/// not so far better, and each is one more row for every goal.
const SIDE: f64 = 0.5;
/// Prices that are tried at most, each with a search: corners that are left untried are given up, and bounds in their
/// direction are lower.
const MAX_TRIES: usize = 500;

/// Links into each cell: the offset to their start (copies), and the cell there.
pub(super) type BackwardArcs = Arcs<([i32; 2], u32)>;

/// Prices that earn nothing on any cycle, and between which no others are much higher (frames/copy).
pub(super) fn least_prices(back: &BackwardArcs, num_cells: u32) -> Vec<[f32; 2]> {
    let corner = |at: [f64; 2]| PriceCorner { at: at.map(|a| a * f64::from(HIGHEST)), sound: false };
    let mut corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(corner).to_vec();
    for _ in 0..MAX_TRIES {
        let Some(at) = corners.iter().position(|c| !c.sound) else { break };
        let mut search = PriceSearch::new(num_cells);
        search.costs.fill(0.0);
        if search.run(back, round_down_price(corners[at].at)) {
            corners[at].sound = true;
            continue;
        }
        match search.cycle() {
            Some((offset, frames)) => cut_corner(&mut corners, at, offset, frames),
            None => _ = corners.remove(at),
        }
    }
    corners.retain(|c| c.sound);
    prices_between(&corners.iter().map(|c| c.at).collect::<Vec<_>>()).into_iter().map(round_down_price).collect()
}

/// Corners, and prices on the sides between those that are far from each other: nearer paths get higher bounds from
/// them, since less of those prices is left at the ends.
fn prices_between(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let length = |[u, v]: [f64; 2]| maths::hypot(u, v);
    let longest = corners.iter().map(|&c| length(c)).fold(0.0, f64::max) * SIDE;
    let mut out = Vec::new();
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let side = [b[0] - a[0], b[1] - a[1]];
        let parts = if longest > 0.0 { (length(side) / longest).ceil().max(1.0) } else { 1.0 };
        let at = |k: usize| [0, 1].map(|n| a[n] + side[n] * k as f64 / parts);
        out.extend((0..parts as usize).map(at));
    }
    out
}

/// Rest of the least cost from each cell to some others, each with a cost of its own, after subtracting `price`:
/// infinite where no path leads there.
///
/// - returns none where a cycle has a negative cost, or a cheapest path has more links than rounds are followed.
pub(super) fn rest_costs(
    back: &BackwardArcs,
    price: [f32; 2],
    to: impl Iterator<Item = (u32, u16)>,
    num_cells: u32,
) -> Option<Vec<f32>> {
    let mut search = PriceSearch::new(num_cells);
    to.for_each(|(cell, cost)| search.costs[cell as usize] = f64::from(cost));
    // Subtracts the decreases that were too small to be noticed.
    search.run(back, price).then(|| search.costs.into_iter().map(|c| (c - SLACK) as f32).collect())
}

/// A corner of the polygon of prices; sound where no cycle is known to earn by it.
#[derive(Clone, Copy)]
struct PriceCorner {
    at: [f64; 2],
    sound: bool,
}

/// A little lower.
fn round_down_price(price: [f64; 2]) -> [f32; 2] {
    price.map(|p| p as f32 * (1.0 - CARE))
}

/// Cuts off a corner by which a cycle earns (Sutherland and Hodgman 1974).
fn cut_corner(corners: &mut Vec<PriceCorner>, at: usize, offset: [f64; 2], frames: f64) {
    let earns = |c: &PriceCorner| c.at[0] * offset[0] + c.at[1] * offset[1] - frames;
    let share = frames / (earns(&corners[at]) + frames);
    if share > 1.0 - NEAR {
        corners[at].at = corners[at].at.map(|a| a * share.min(1.0 - f64::from(CARE)));
        return;
    }
    let mut left = Vec::with_capacity(corners.len() + 1);
    for (c, next) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (here, there) = (earns(c), earns(next));
        if here <= 0.0 {
            left.push(*c);
        }
        if (here <= 0.0) != (there <= 0.0) {
            let t = here / (here - there);
            let between = |k: usize| c.at[k] + t * (next.at[k] - c.at[k]);
            left.push(PriceCorner { at: [between(0), between(1)], sound: false });
        }
    }
    *corners = left;
}

/// Least costs with prices (Bellman and Ford), and the links that they come by.
struct PriceSearch {
    costs: Vec<f64>,
    /// The cell that follows on the way from each, how far away that is, and the frames.
    next: Vec<Option<(u32, [i32; 2], u16)>>,
    /// The round that a cell was last met in, in looking for cycles.
    met: Vec<u32>,
    /// A cell of a cycle that earns.
    on_cycle: Option<u32>,
}

impl PriceSearch {
    fn new(num_cells: u32) -> Self {
        let n = num_cells as usize;
        Self { costs: vec![f64::INFINITY; n], next: vec![None; n], met: vec![0; n], on_cycle: None }
    }

    /// True where no cycle earns.
    fn run(&mut self, back: &BackwardArcs, price: [f32; 2]) -> bool {
        let price = price.map(f64::from);
        for _ in 0..MAX_ROUNDS {
            let mut changed = false;
            for cell in 0..self.costs.len() as u32 {
                let cost = self.costs[cell as usize];
                if cost == f64::INFINITY {
                    continue;
                }
                for &((offset, from), frames) in back.arcs_from(cell) {
                    let total =
                        cost + f64::from(frames) - price[0] * f64::from(offset[0]) - price[1] * f64::from(offset[1]);
                    if total < self.costs[from as usize] - NOTHING {
                        self.costs[from as usize] = total;
                        self.next[from as usize] = Some((cell, offset, frames));
                        changed = true;
                    }
                }
            }
            if !changed {
                return true;
            }
            self.on_cycle = self.find_cycle();
            if self.on_cycle.is_some() {
                return false;
            }
        }
        false
    }

    /// A cell from which the links followed lead back to it.
    fn find_cycle(&mut self) -> Option<u32> {
        self.met.fill(0);
        for first in 0..self.next.len() as u32 {
            let mut cell = first;
            while self.met[cell as usize] == 0 {
                self.met[cell as usize] = first + 1;
                let Some((next, ..)) = self.next[cell as usize] else { break };
                cell = next;
                if self.met[cell as usize] == first + 1 {
                    return Some(cell);
                }
            }
        }
        None
    }

    /// Offset of the cycle that was found (copies), and its frames.
    fn cycle(&self) -> Option<([f64; 2], f64)> {
        let first = self.on_cycle?;
        let (mut cell, mut cost, mut far) = (first, 0.0, [0.0; 2]);
        loop {
            let (next, offset, frames) = self.next[cell as usize]?;
            cost += f64::from(frames);
            far = [far[0] + f64::from(offset[0]), far[1] + f64::from(offset[1])];
            cell = next;
            if cell == first {
                return Some((far, cost));
            }
        }
    }
}
