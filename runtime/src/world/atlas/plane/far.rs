//! Far ways: bounds on what they cost that grow with distance, one for each of some directions.
//!
//! Take a price for every copy that one goes along each direction of the lattice, off what links cost. As long as no
//! cycle of links earns more than it costs, what is left from a cell to the target is at least the least way between
//! their kinds, wherever the copies are; the price of all the copies between comes on top. The highest such price in a
//! direction is that of the cycle of links that goes along it at the least cost (least ratio cycle, Lawler 1967).

use super::super::dial::Arcs;

/// Directions that prices are found for.
const DIRECTIONS: usize = 24;
/// Prices are never higher: where no cycle leads along a direction at all. [Unit: frames/copy]
const HIGHEST: f32 = 5e3;
/// Prices are that much below what still has no cycle that earns, so that rounding makes none.
const CARE: f32 = 1e-4;
/// What is below 0 by less costs nothing: of a million links together, less than `SLACK`. [Unit: frames]
const NOTHING: f64 = 1e-8;
/// What all that, and the rounding of sums that are looked up, come to at most. [Unit: frames]
const SLACK: f64 = 0.1;
/// Rounds after which prices are given up for lower ones.
const MAX_ROUNDS: usize = 200;

/// From each cell back to where links to it begin: how many copies away that leads, and the cell.
pub(super) type Back = Arcs<([i32; 2], u32)>;

/// Prices that earn nothing on any cycle. [Unit: frames/copy]
pub(super) fn prices(back: &Back, num_cells: u32) -> Vec<[f32; 2]> {
    let angle = |k: usize| k as f32 / DIRECTIONS as f32 * std::f32::consts::TAU;
    (0..DIRECTIONS).filter_map(|k| price(back, num_cells, [angle(k).cos(), angle(k).sin()])).collect()
}

/// What `price` leaves of the least cost from each cell to some: infinite where no way leads there.
///
/// - returns none where a cycle earns.
pub(super) fn rest(back: &Back, price: [f32; 2], to: &[u32], num_cells: u32) -> Option<Vec<f32>> {
    let mut search = Search::new(num_cells);
    to.iter().for_each(|&cell| search.costs[cell as usize] = 0.0);
    // Whoever was not noticed to cost so little less is not counted.
    search.run(back, price).then(|| search.costs.into_iter().map(|c| (c - SLACK) as f32).collect())
}

/// The highest price along a direction, a little less for care; none where there are no cycles to go by.
fn price(back: &Back, num_cells: u32, along: [f32; 2]) -> Option<[f32; 2]> {
    let mut factor = HIGHEST;
    for _ in 0..MAX_ROUNDS {
        let price = along.map(|a| a * factor);
        let mut search = Search::new(num_cells);
        search.costs.fill(0.0);
        if search.run(back, price) {
            return Some(price);
        }
        // Newton's method (Dinkelbach 1967): the cycle that earns sets the price, until none does.
        let ratio = search.cycle(along)?;
        factor = (ratio as f32 * (1.0 - CARE)).min(factor * (1.0 - CARE));
    }
    None
}

/// Least costs with prices (Bellman and Ford), and the links that they come by.
struct Search {
    costs: Vec<f64>,
    /// The cell that follows on the way from each, how far away that is, and the frames.
    next: Vec<Option<(u32, [i32; 2], u16)>>,
    /// The round that a cell was last met in, in looking for cycles.
    met: Vec<u32>,
    /// A cell of a cycle that earns.
    on_cycle: Option<u32>,
}

impl Search {
    fn new(num_cells: u32) -> Self {
        let n = num_cells as usize;
        Self { costs: vec![f64::INFINITY; n], next: vec![None; n], met: vec![0; n], on_cycle: None }
    }

    /// True where no cycle earns.
    fn run(&mut self, back: &Back, price: [f32; 2]) -> bool {
        let price = price.map(f64::from);
        for _ in 0..MAX_ROUNDS {
            let mut changed = false;
            for cell in 0..self.costs.len() as u32 {
                let cost = self.costs[cell as usize];
                if cost == f64::INFINITY {
                    continue;
                }
                for &((way, from), frames) in back.of(cell) {
                    let total = cost + f64::from(frames) - price[0] * f64::from(way[0]) - price[1] * f64::from(way[1]);
                    if total < self.costs[from as usize] - NOTHING {
                        self.costs[from as usize] = total;
                        self.next[from as usize] = Some((cell, way, frames));
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

    /// What the cycle that was found costs a copy along a direction; none where there is none, or it leads elsewhere.
    fn cycle(&self, along: [f32; 2]) -> Option<f64> {
        let along = along.map(f64::from);
        let first = self.on_cycle?;
        let (mut cell, mut cost, mut far) = (first, 0.0, 0.0);
        loop {
            let (next, way, frames) = self.next[cell as usize]?;
            cost += f64::from(frames);
            far += along[0] * f64::from(way[0]) + along[1] * f64::from(way[1]);
            cell = next;
            if cell == first {
                return (far > 0.0).then(|| cost / far);
            }
        }
    }
}
