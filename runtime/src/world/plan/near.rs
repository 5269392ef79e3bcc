//! What it costs on open ground to come to exactly the cells of a target: around it, which way one faces counts most.

use super::heap::Heap;
use crate::world::atlas::{Look, Plane};

/// How far around the target's tile. [Unit: copies]
const RADIUS: i32 = 1;
const SIDE: i32 = 2 * RADIUS + 1;

/// Costs from all cells of the tiles around a target; memory of the search for them.
#[derive(Clone, Debug)]
pub(super) struct Near {
    /// [Unit: frames] [Size: tiles * cells of a tile]
    costs: Vec<f32>,
    heap: Heap,
    num_cells: u32,
    /// What farther ways cost at least beside those to the best cell of a class. [Unit: frames]
    pub beside: f32,
}

impl Near {
    /// Memory for tiles of at most so many cells.
    pub fn new(num_cells: u32) -> Self {
        let num_states = (SIDE * SIDE) as usize * num_cells as usize;
        Self { costs: vec![0.0; num_states], heap: Heap::new(num_states), num_cells: 0, beside: 0.0 }
    }

    /// Dijkstra backwards from the cells of a target, without obstacles.
    ///
    /// - `least`: the cost to the best cell of the target's classes from a cell so many copies away.
    pub fn run(
        &mut self,
        plane: &Plane,
        num_cells: u32,
        target: impl Iterator<Item = u32>,
        least: impl Fn([i32; 2], u32) -> f32,
    ) {
        self.num_cells = num_cells;
        self.heap.clear();
        self.costs[..(SIDE * SIDE) as usize * num_cells as usize].fill(f32::INFINITY);
        for cell in target {
            self.reach(number([0, 0]) * num_cells + cell, 0.0);
        }
        while let Some((cost, state)) = self.heap.pop() {
            let (tile, cell) = ((state / num_cells) as i32, state % num_cells);
            let [u, v] = [tile / SIDE - RADIUS, tile % SIDE - RADIUS];
            plane.for_each_link_to(cell, |[du, dv], from, frames| {
                let at = [u - du, v - dv];
                if at.iter().all(|a| a.abs() <= RADIUS) {
                    self.reach(number(at) * num_cells + from, cost + f32::from(frames));
                }
            });
        }
        self.beside = f32::INFINITY;
        for at in (0..SIDE * SIDE).map(|t| [t / SIDE - RADIUS, t % SIDE - RADIUS]).filter(|a| *a != [0, 0]) {
            for cell in 0..num_cells {
                let cost = self.costs[(number(at) * num_cells + cell) as usize];
                let more = cost - least([-at[0], -at[1]], cell);
                self.beside = if cost < f32::INFINITY { self.beside.min(more) } else { self.beside };
            }
        }
        self.beside = if self.beside < f32::INFINITY { self.beside.max(0.0) } else { 0.0 };
    }

    /// Cost from a cell of a tile that has the target so many copies away; none where it is farther away.
    pub fn cost(&self, [du, dv]: [i32; 2], cell: u32) -> Option<f32> {
        let near = du.abs() <= RADIUS && dv.abs() <= RADIUS;
        near.then(|| self.costs[(number([-du, -dv]) * self.num_cells + cell) as usize])
    }

    fn reach(&mut self, state: u32, cost: f32) {
        if cost < self.costs[state as usize] {
            self.costs[state as usize] = cost;
            self.heap.push(state, cost);
        }
    }
}

fn number([u, v]: [i32; 2]) -> u32 {
    ((u + RADIUS) * SIDE + v + RADIUS) as u32
}

/// The least cost to any cell of some classes, for [`Near::run`].
pub(super) fn least(plane: &Plane, classes: impl Iterator<Item = u32>, way: [i32; 2], cell: u32) -> f32 {
    let cost = |class| {
        let look: Look = plane.look(class, way);
        plane.cost(look, cell)
    };
    classes.map(cost).fold(f32::INFINITY, f32::min)
}
