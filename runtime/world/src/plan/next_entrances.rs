//! The cheapest entrances from a tile towards the target.

use crate::path_hierarchy::{CostLookup, TilePlane};

/// Most entrances that are kept for a tile.
const MAX_KEPT: usize = 12;

/// Next entrance from a tile: the location of the costs to it, and the cost from there (frames).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NextEntrance {
    pub lookup: CostLookup,
    pub cost: f32,
}

/// Next entrances from a tile, and the search that found them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NextEntrances {
    pub stamp: u32,
    len: u32,
    /// Entrances kept, sorted by their cost from the best cell of the tile.
    list: [(f32, NextEntrance); MAX_KEPT],
    /// Least cost of the entrances that are not kept.
    others: f32,
}

impl NextEntrances {
    /// An empty list.
    pub fn new(stamp: u32) -> Self {
        Self { stamp, others: f32::INFINITY, ..Self::default() }
    }

    /// Keeps an entrance, or the cost of the worst one.
    pub fn add(&mut self, plane: &TilePlane, entrance: NextEntrance) {
        let least = entrance.cost + plane.least_of_all(entrance.lookup);
        let len = self.len as usize;
        let at = self.list[..len].partition_point(|g| g.0 <= least);
        if least == f32::INFINITY || at == MAX_KEPT {
            self.others = self.others.min(least);
            return;
        }
        if len == MAX_KEPT {
            self.others = self.others.min(self.list[MAX_KEPT - 1].0);
        }
        self.len = (len + 1).min(MAX_KEPT) as u32;
        self.list[at..self.len as usize].rotate_right(1);
        self.list[at] = (least, entrance);
    }

    /// The least cost from a cell of the tile by any of them, or `direct` where that is less.
    pub fn cost(&self, plane: &TilePlane, cell: u32, direct: f32) -> f32 {
        let mut best = direct.min(self.others);
        for (least, entrance) in &self.list[..self.len as usize] {
            if *least >= best {
                break;
            }
            best = best.min(entrance.cost + plane.cost(entrance.lookup, cell));
        }
        best
    }
}
