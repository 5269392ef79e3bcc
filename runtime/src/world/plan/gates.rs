//! Gates: the ways on from a tile that cost least.

use crate::world::atlas::{Look, Plane};

/// Ways on that are kept of a tile.
const MAX_GATES: usize = 12;

/// A way on from a tile: where costs to it are found, and what it costs from there. [Unit: frames]
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gate {
    pub look: Look,
    pub cost: f32,
}

/// The ways on from a tile, and the search that found them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gates {
    pub stamp: u32,
    len: u32,
    /// By what they cost from the best cell of the tile.
    list: [(f32, Gate); MAX_GATES],
    /// What those cost at least that are not kept.
    others: f32,
}

impl Gates {
    /// None yet.
    pub fn new(stamp: u32) -> Self {
        Self { stamp, others: f32::INFINITY, ..Self::default() }
    }

    /// Keeps a way on, or the cost of the worst one.
    pub fn add(&mut self, plane: &Plane, gate: Gate) {
        let least = gate.cost + plane.least_of_all(gate.look);
        let len = self.len as usize;
        let at = self.list[..len].partition_point(|g| g.0 <= least);
        if least == f32::INFINITY || at == MAX_GATES {
            self.others = self.others.min(least);
            return;
        }
        if len == MAX_GATES {
            self.others = self.others.min(self.list[MAX_GATES - 1].0);
        }
        self.len = (len + 1).min(MAX_GATES) as u32;
        self.list[at..self.len as usize].rotate_right(1);
        self.list[at] = (least, gate);
    }

    /// The least cost from a cell of the tile by any of them, or `direct` where that is less.
    pub fn cost(&self, plane: &Plane, cell: u32, direct: f32) -> f32 {
        let mut best = direct.min(self.others);
        for (least, gate) in &self.list[..self.len as usize] {
            if *least >= best {
                break;
            }
            best = best.min(gate.cost + plane.cost(gate.look, cell));
        }
        best
    }
}
