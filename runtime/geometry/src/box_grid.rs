//! Grid of boxes in the plane.

use crate::plane::Bounds2d;
use glam::Vec2;

/// Side of a cell of a grid (m).
const CELL_M: f32 = 3.0;
const NONE: u32 = u32::MAX;

/// Numbered boxes in a hash grid, found by region.
#[derive(Clone, Debug)]
pub struct BoxGrid {
    slots: Vec<BoxSlot>,
    /// First box of each bucket (a power of two).
    buckets: Vec<u32>,
    /// Largest half extent of any box along an axis (m).
    most_half_m: f32,
}

#[derive(Clone, Copy, Debug)]
struct BoxSlot {
    /// Bounds of the box; empty where there is none.
    bounds: Bounds2d,
    /// Next and previous boxes in its bucket.
    next: u32,
    before: u32,
}

const FREE: BoxSlot = BoxSlot { bounds: Bounds2d::EMPTY, next: NONE, before: NONE };

impl Default for BoxGrid {
    fn default() -> Self {
        Self::with_capacity(0)
    }
}

impl BoxGrid {
    /// Empty grid with room for `capacity` boxes; more boxes allocate memory.
    pub fn with_capacity(capacity: usize) -> Self {
        let buckets = (2 * capacity).next_power_of_two().max(16);
        Self { slots: Vec::with_capacity(capacity), buckets: vec![NONE; buckets], most_half_m: 0.0 }
    }

    /// Removes all boxes.
    pub fn clear(&mut self) {
        self.slots.clear();
        self.buckets.fill(NONE);
        self.most_half_m = 0.0;
    }

    /// Inserts a box, or replaces the one of that number.
    pub fn set(&mut self, number: usize, bounds: Bounds2d) {
        self.remove(number);
        if number >= self.slots.len() {
            self.slots.resize(number + 1, FREE);
            if 2 * self.slots.len() > self.buckets.len() {
                self.grow();
            }
        }
        self.slots[number] = BoxSlot { bounds, ..FREE };
        self.link(number);
    }

    /// Removes a box, if it is there.
    pub fn remove(&mut self, number: usize) {
        let Some(&BoxSlot { bounds, next, before }) = self.slots.get(number) else { return };
        if bounds == Bounds2d::EMPTY {
            return;
        }
        match before {
            NONE => {
                let bucket = self.bucket(cell_at(box_centre(&bounds)));
                self.buckets[bucket] = next;
            }
            before => self.slots[before as usize].next = next,
        }
        if next != NONE {
            self.slots[next as usize].before = before;
        }
        self.slots[number] = FREE;
    }

    /// Calls `found` for every box that intersects `bounds`, in no particular order, until it returns false.
    #[inline]
    pub fn visit_intersecting(&self, bounds: &Bounds2d, mut found: impl FnMut(usize) -> bool) {
        let wide = bounds.expanded_by(self.most_half_m);
        let (low, high) = (cell_at(wide.min), cell_at(wide.max));
        let meets = |at: usize| self.slots[at].bounds.intersects(bounds);
        let size = [0, 1].map(|k| i64::from(high[k]) - i64::from(low[k]) + 1);
        if size[0].saturating_mul(size[1]) > 4 * self.slots.len() as i64 {
            // Fewer boxes than cells.
            (0..self.slots.len()).all(|at| !meets(at) || found(at));
            return;
        }
        // Cells of one bucket are met together: each box is found where its own cell is.
        for z in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let here = [x, z];
                let mut at = self.buckets[self.bucket(here)];
                while at != NONE {
                    let slot = &self.slots[at as usize];
                    if meets(at as usize) && cell_at(box_centre(&slot.bounds)) == here && !found(at as usize) {
                        return;
                    }
                    at = slot.next;
                }
            }
        }
    }

    fn link(&mut self, number: usize) {
        let bounds = self.slots[number].bounds;
        self.most_half_m = self.most_half_m.max(0.5 * (bounds.max - bounds.min).max_element());
        let bucket = self.bucket(cell_at(box_centre(&bounds)));
        let next = self.buckets[bucket];
        self.slots[number] = BoxSlot { bounds, next, before: NONE };
        if next != NONE {
            self.slots[next as usize].before = number as u32;
        }
        self.buckets[bucket] = number as u32;
    }

    fn grow(&mut self) {
        let buckets = (4 * self.slots.len()).next_power_of_two();
        self.buckets.clear();
        self.buckets.resize(buckets, NONE);
        for number in 0..self.slots.len() {
            if self.slots[number].bounds != Bounds2d::EMPTY {
                self.link(number);
            }
        }
    }

    fn bucket(&self, [x, z]: [i32; 2]) -> usize {
        let hash = (x as u32).wrapping_mul(0x9E37_79B1) ^ (z as u32).wrapping_mul(0x85EB_CA77);
        (hash ^ hash >> 15) as usize & (self.buckets.len() - 1)
    }
}

fn box_centre(bounds: &Bounds2d) -> Vec2 {
    0.5 * (bounds.min + bounds.max)
}

/// Cell of a place. Whole negative numbers get a cell one lower than rounding down gives, which does no harm.
fn cell_at(place: Vec2) -> [i32; 2] {
    (place * (1.0 / CELL_M)).to_array().map(|v| (v as i32).saturating_sub(i32::from(v < 0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn boxes_beyond_all_cells_are_found() {
        let mut grid = BoxGrid::with_capacity(2);
        let boxes = [-1e14f32, 1e14].map(|x| Bounds2d::around_disc(Vec2::splat(x), 1.0));
        (0..2).for_each(|n| grid.set(n, boxes[n]));
        for (n, bounds) in boxes.iter().enumerate() {
            let mut found = Vec::new();
            grid.visit_intersecting(bounds, |n| {
                found.push(n);
                true
            });
            assert_eq!(found, [n]);
        }
    }

    proptest! {
        /// Against a list of all boxes, while boxes come, change and go.
        #[test]
        fn boxes_are_found_as_in_a_list(steps in proptest::collection::vec((0usize..40, -30.0f32..30.0, -30.0f32..30.0, 0.0f32..6.0, any::<bool>()), 1..120)) {
            let (mut grid, mut list) = (BoxGrid::with_capacity(4), [Bounds2d::EMPTY; 40]);
            for (number, x, z, half, stays) in steps {
                let bounds = Bounds2d::around_disc(Vec2::new(x, z), half);
                let mut found = Vec::new();
                grid.visit_intersecting(&bounds, |n| {
                    found.push(n);
                    true
                });
                found.sort_unstable();
                let wanted: Vec<usize> = (0..40).filter(|&n| list[n].intersects(&bounds)).collect();
                prop_assert_eq!(found, wanted);
                if stays {
                    grid.set(number, bounds);
                    list[number] = bounds;
                } else {
                    grid.remove(number);
                    list[number] = Bounds2d::EMPTY;
                }
                prop_assert_eq!(grid.slots.get(number).map_or(Bounds2d::EMPTY, |s| s.bounds), list[number]);
            }
        }
    }
}
