//! The cells of space that members are registered in.

use super::{NONE, Space, plan::Plan};
use serde::{Deserialize, Serialize};

/// Members of a block.
pub(crate) const BLOCK: usize = 8;
/// Most cells: a grid of more is folded.
const MAX_CELLS: usize = 1 << 22;

/// Plans of members that are registered in the same cell, one after the other in memory.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Block<V> {
    len: u32,
    /// Block of more of them.
    next: u32,
    plans: [Plan<V>; BLOCK],
}

/// A grid of square or cubic cells, each with the plans of its members.
///
/// The grid is a torus: what is farther away than its extents shares cells with what is near. That costs a look at
/// members who are far away, but nothing is ever outside, and empty space takes no memory.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Cells<V> {
    side: f32,
    /// Logarithm of the number of cells along each axis.
    bits: [u32; 3],
    first: Vec<u32>,
    blocks: Vec<Block<V>>,
    free: Vec<u32>,
    /// Block and place of every member: `block * BLOCK + place`.
    address: Vec<u32>,
}

impl<V: Space> Cells<V> {
    /// Cells of a side for members with numbers below `capacity`, most of them within `size`.
    pub fn new(side: f32, size: V, capacity: usize) -> Self {
        let mut bits = [0; 3];
        for (axis, &length) in size.coordinates().iter().take(V::DIMENSIONS).enumerate() {
            // Three or more, so that the neighbours of a cell are all different.
            bits[axis] = ((length / side).min(1e6) as usize + 3).next_power_of_two().trailing_zeros();
        }
        let most = (16 * capacity.max(64)).min(MAX_CELLS);
        while 1usize << bits.iter().sum::<u32>() > most && bits.iter().any(|&b| b > 2) {
            let longest = (0..3).max_by_key(|&axis| (bits[axis], axis)).unwrap_or(0);
            bits[longest] -= 1;
        }
        // A chain of blocks is full but for its last one.
        let num_blocks = capacity + capacity / BLOCK + 1;
        let block = Block { next: NONE, ..Block::default() };
        Self {
            side,
            bits,
            first: vec![NONE; 1 << bits.iter().sum::<u32>()],
            blocks: vec![block; num_blocks],
            free: (0..num_blocks as u32).rev().collect(),
            address: vec![NONE; capacity],
        }
    }

    /// Memory that a copy did not bring along.
    pub fn reserve(&mut self) {
        self.free.reserve(self.blocks.len() - self.free.len());
    }

    /// True where they are as large as others, and whole: every chain ends, every address is that of its member.
    pub fn fits(&self, other: &Self) -> bool {
        let same = (self.side, self.bits) == (other.side, other.bits) && self.first.len() == other.first.len();
        if !same || self.blocks.len() != other.blocks.len() || self.address.len() != other.address.len() {
            return false;
        }
        let num_blocks = self.blocks.len() as u32;
        let mut seen = 0;
        let mut is_whole = self.free.len() <= self.blocks.len() && self.free.iter().all(|&f| f < num_blocks);
        for &first in &self.first {
            let mut b = first;
            while b != NONE && is_whole {
                seen += 1;
                is_whole = b < num_blocks && seen <= num_blocks && self.blocks[b as usize].len as usize <= BLOCK;
                if !is_whole {
                    break;
                }
                let block = &self.blocks[b as usize];
                let at = |(i, p): (usize, &Plan<V>)| {
                    self.address.get(p.index as usize).is_some_and(|&a| a as usize == b as usize * BLOCK + i)
                };
                is_whole = block.plans[..block.len as usize].iter().enumerate().all(at);
                b = block.next;
            }
        }
        is_whole
    }

    /// Side of a cell. [Unit: m]
    pub fn side(&self) -> f32 {
        self.side
    }

    /// Number of cells.
    pub fn num_cells(&self) -> usize {
        self.first.len()
    }

    /// Number of cells along each axis before the grid is folded.
    pub fn folds(&self) -> [u32; 3] {
        self.bits.map(|b| 1 << b)
    }

    /// Coordinates of the cell that holds a point, before they are folded.
    #[inline]
    pub fn coordinates(&self, x: V) -> [i32; 3] {
        x.coordinates().map(|c| (c / self.side).floor() as i32)
    }

    /// Centre of a cell. [Unit: m]
    #[inline]
    pub fn centre(&self, at: [i32; 3]) -> V {
        V::from_coordinates(at.map(|c| (c as f32 + 0.5) * self.side))
    }

    /// Number of a cell.
    #[inline]
    pub fn number(&self, at: [i32; 3]) -> u32 {
        let fold = |axis: usize| at[axis] as u32 & ((1 << self.bits[axis]) - 1);
        (((fold(2) << self.bits[1]) | fold(1)) << self.bits[0]) | fold(0)
    }

    /// Calls `f` for the number of every cell around one, itself among them.
    #[inline]
    pub fn around(&self, at: [i32; 3], mut f: impl FnMut(u32)) {
        let depth = if V::DIMENSIONS == 3 { 1 } else { 0 };
        for z in -depth..=depth {
            for y in -1..=1 {
                for x in -1..=1 {
                    f(self.number([at[0] + x, at[1] + y, at[2] + z]));
                }
            }
        }
    }

    /// Plan of a member. [Limit: it is in a cell]
    #[inline]
    pub fn plan(&self, member: u32) -> &Plan<V> {
        self.at(self.address[member as usize])
    }

    /// Where a member's plan is, for [`Cells::at`]. [Limit: it is in a cell]
    #[inline]
    pub fn address(&self, member: u32) -> u32 {
        self.address[member as usize]
    }

    /// Plan at an address that [`Cells::each`] gave.
    #[inline]
    pub fn at(&self, address: u32) -> &Plan<V> {
        &self.blocks[address as usize / BLOCK].plans[address as usize % BLOCK]
    }

    /// Calls `f` for everyone who is registered in a cell, with the address of the plan.
    #[inline]
    pub fn each(&self, cell: u32, mut f: impl FnMut(&Plan<V>, u32)) {
        let mut b = self.first[cell as usize];
        while b != NONE {
            let block = &self.blocks[b as usize];
            for (address, plan) in (b * BLOCK as u32..).zip(&block.plans[..block.len as usize]) {
                f(plan, address);
            }
            b = block.next;
        }
    }

    /// Changes a plan; who comes into another cell is registered there. `from` is the cell where it is registered.
    pub fn set(&mut self, from: u32, to: u32, plan: &Plan<V>) {
        if from == to {
            let address = self.address[plan.index as usize] as usize;
            self.blocks[address / BLOCK].plans[address % BLOCK] = *plan;
        } else {
            self.remove(from, plan.index);
            self.insert(to, plan);
        }
    }

    /// Registers a member in a cell.
    pub fn insert(&mut self, cell: u32, plan: &Plan<V>) {
        let mut b = self.first[cell as usize];
        // The first block of a chain is the one with room.
        if b == NONE || self.blocks[b as usize].len as usize == BLOCK {
            let Some(fresh) = self.free.pop() else { return };
            self.blocks[fresh as usize].len = 0;
            self.blocks[fresh as usize].next = b;
            self.first[cell as usize] = fresh;
            b = fresh;
        }
        let block = &mut self.blocks[b as usize];
        block.plans[block.len as usize] = *plan;
        self.address[plan.index as usize] = b * BLOCK as u32 + block.len;
        block.len += 1;
    }

    /// Takes a member out of its cell. The last one of the cell takes its place.
    pub fn remove(&mut self, cell: u32, member: u32) {
        let address = self.address[member as usize];
        let first = self.first[cell as usize];
        let block = &mut self.blocks[first as usize];
        block.len -= 1;
        let last = block.plans[block.len as usize];
        if block.len == 0 {
            self.first[cell as usize] = block.next;
            self.free.push(first);
        }
        self.blocks[address as usize / BLOCK].plans[address as usize % BLOCK] = last;
        self.address[last.index as usize] = address;
        self.address[member as usize] = NONE;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn holds_whom_a_list_of_cells_holds(work in proptest::collection::vec((0u32..60, 0i32..3, 0..3), 1..300)) {
            let mut cells = Cells::<Vec2>::new(1.0, Vec2::splat(4.0), 60);
            let mut list = vec![None; 60];
            for (member, x, kind) in work {
                let to = cells.number([x, 0, 0]);
                let plan = Plan { index: member, limit: x as f32, ..Plan::default() };
                match (list[member as usize], kind) {
                    (None, _) => {
                        cells.insert(to, &plan);
                        list[member as usize] = Some(to);
                    }
                    (Some(from), 0) => {
                        cells.remove(from, member);
                        list[member as usize] = None;
                    }
                    (Some(from), _) => {
                        cells.set(from, to, &plan);
                        list[member as usize] = Some(to);
                    }
                }
                for cell in 0..cells.num_cells() as u32 {
                    let mut there = Vec::new();
                    cells.each(cell, |p, _| there.push(p.index));
                    there.sort_unstable();
                    let want: Vec<u32> = (0..60).filter(|&m| list[m as usize] == Some(cell)).collect();
                    prop_assert_eq!(&there, &want);
                    prop_assert!(there.iter().all(|&m| cells.plan(m).index == m));
                }
            }
        }
    }

    #[test]
    fn cells_around_one_are_all_different() {
        let flat = Cells::<Vec2>::new(2.0, Vec2::splat(1.0), 4);
        let deep = Cells::<Vec3>::new(2.0, Vec3::new(90.0, 1.0, 1.0), 4);
        let mut seen = Vec::new();
        flat.around([-1, 7, 0], |c| seen.push(c));
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 9);
        seen.clear();
        deep.around([-1, 7, 3], |c| seen.push(c));
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 27);
    }
}
