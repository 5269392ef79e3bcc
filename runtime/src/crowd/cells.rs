//! The cells of space that members are registered in.

use super::eights::{Plans, Vectors};
use super::{NONE, Space, plan::Plan};
use crate::lanes::Lanes;
use std::marker::PhantomData;

/// Members of a block.
pub(crate) const BLOCK: usize = 8;
/// Most cells: a grid of more is folded.
const MAX_CELLS: usize = 1 << 22;

/// One number of each member of a block.
pub(crate) type Eight = [f32; BLOCK];

/// Plans of members that are registered in the same cell: each number of all of them side by side, so that they are
/// looked at together. What every look at them needs comes first. In 2-D the third coordinates
/// are never touched; where many thousands are, fetching the rest of their neighbours' blocks from memory is most of an
/// event.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Block {
    pub start: [f64; BLOCK],
    pub moving: Eight,
    pub radius: Eight,
    pub limit: Eight,
    pub axes: [Axis; 3],
    pub end: [f64; BLOCK],
    pub index: [u32; BLOCK],
    /// Block of more of them, which is full.
    next: u32,
}

/// One coordinate of eight motions.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Axis {
    pub position: Eight,
    pub velocity: Eight,
    pub acceleration: Eight,
}

/// Who is registered in a cell.
#[derive(Clone, Copy, Debug)]
struct Chain {
    /// The first block: the one with room.
    first: u32,
    /// Members in all blocks.
    len: u32,
}

impl Chain {
    const EMPTY: Self = Self { first: NONE, len: 0 };

    /// Members in the first block.
    #[inline(always)]
    fn len_of_first(self) -> usize {
        (self.len as usize + BLOCK - 1) % BLOCK + 1
    }
}

/// One vector of eight.
#[inline(always)]
pub(crate) fn nth<V: Space>(of: &[Eight; 3], i: usize) -> V {
    let third = if V::DIMENSIONS == 3 { of[2][i] } else { 0.0 };
    V::from_coordinates([of[0][i], of[1][i], third])
}

impl Block {
    /// Plan of one of its members.
    #[inline]
    pub fn plan<V: Space>(&self, i: usize) -> Plan<V> {
        Plan {
            start: self.start[i],
            end: self.end[i],
            position: self.vector(i, |a| &a.position),
            velocity: self.vector(i, |a| &a.velocity),
            acceleration: self.vector(i, |a| &a.acceleration),
            moving: self.moving[i],
            radius: self.radius[i],
            limit: self.limit[i],
            index: self.index[i],
        }
    }

    #[inline(always)]
    fn vector<V: Space>(&self, i: usize, of: impl Fn(&Axis) -> &Eight) -> V {
        let third = if V::DIMENSIONS == 3 { of(&self.axes[2])[i] } else { 0.0 };
        V::from_coordinates([of(&self.axes[0])[i], of(&self.axes[1])[i], third])
    }

    /// Plans of all of them.
    #[inline(always)]
    pub fn plans<V: Space, F: Lanes>(&self) -> Plans<V, F> {
        let [x, y, z] = &self.axes;
        Plans {
            position: Vectors::load_each([&x.position, &y.position, &z.position]),
            velocity: Vectors::load_each([&x.velocity, &y.velocity, &z.velocity]),
            acceleration: Vectors::load_each([&x.acceleration, &y.acceleration, &z.acceleration]),
            moving: F::load(&self.moving),
            limit: F::load(&self.limit),
        }
    }

    /// Puts a plan in a place.
    #[inline]
    pub fn put<V: Space>(&mut self, i: usize, plan: &Plan<V>) {
        (self.start[i], self.end[i]) = (plan.start, plan.end);
        let (x, v, a) = (plan.position.coordinates(), plan.velocity.coordinates(), plan.acceleration.coordinates());
        for axis in 0..V::DIMENSIONS {
            let axes = &mut self.axes[axis];
            (axes.position[i], axes.velocity[i], axes.acceleration[i]) = (x[axis], v[axis], a[axis]);
        }
        (self.moving[i], self.radius[i], self.limit[i]) = (plan.moving, plan.radius, plan.limit);
        self.index[i] = plan.index;
    }
}

/// A grid of square or cubic cells, each with the plans of its members.
///
/// The grid is a torus: what is farther away than its extents shares cells with what is near. That costs a look at
/// members who are far away, but nothing is ever outside, and empty space takes no memory.
#[derive(Clone, Debug)]
pub(crate) struct Cells<V> {
    side: f32,
    per_m: f32,
    /// Logarithm of the number of cells along each axis.
    bits: [u32; 3],
    chains: Vec<Chain>,
    blocks: Vec<Block>,
    free: Vec<u32>,
    /// Block and place of every member: `block * BLOCK + place`.
    address: Vec<u32>,
    space: PhantomData<V>,
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
            per_m: side.recip(),
            bits,
            chains: vec![Chain::EMPTY; 1 << bits.iter().sum::<u32>()],
            blocks: vec![block; num_blocks],
            free: (0..num_blocks as u32).rev().collect(),
            address: vec![NONE; capacity],
            space: PhantomData,
        }
    }

    /// Takes everybody out.
    pub fn clear(&mut self) {
        self.chains.fill(Chain::EMPTY);
        self.address.fill(NONE);
        self.free.clear();
        self.free.extend((0..self.blocks.len() as u32).rev());
    }

    /// Everybody's plans, so that to insert them one after the other gives the same cells.
    pub fn plans(&self) -> Vec<Plan<V>> {
        let mut plans = Vec::new();
        for cell in 0..self.chains.len() as u32 {
            let start = plans.len();
            self.each_block(cell, |block, _, len| plans.extend((0..len).rev().map(|i| block.plan(i))));
            // The last block of a chain was filled first.
            plans[start..].reverse();
        }
        plans
    }

    /// Side of a cell. [Unit: m]
    pub fn side(&self) -> f32 {
        self.side
    }

    /// Number of cells.
    pub fn num_cells(&self) -> usize {
        self.chains.len()
    }

    /// Number of cells along each axis before the grid is folded.
    pub fn folds(&self) -> [u32; 3] {
        self.bits.map(|b| 1 << b)
    }

    /// Coordinates of the cell that holds a point, before they are folded.
    #[inline]
    pub fn coordinates(&self, x: V) -> [i32; 3] {
        (x * self.per_m).floor()
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
                    f(self.number([at[0].wrapping_add(x), at[1].wrapping_add(y), at[2].wrapping_add(z)]));
                }
            }
        }
    }

    /// Plan of a member. [Limit: it is in a cell]
    #[inline]
    pub fn plan(&self, member: u32) -> Plan<V> {
        let (block, place) = self.place(member);
        self.blocks[block as usize].plan(place)
    }

    /// Number of the block of a member, and its place there. [Limit: it is in a cell]
    #[inline]
    pub fn place(&self, member: u32) -> (u32, usize) {
        let address = self.address[member as usize];
        (address / BLOCK as u32, address as usize % BLOCK)
    }

    /// Block of a number that [`Cells::each_block`] gave.
    #[inline]
    pub fn block(&self, number: u32) -> &Block {
        &self.blocks[number as usize]
    }

    /// Calls `f` for every block of a cell, with its number and that of its members.
    #[inline(always)]
    pub fn each_block(&self, cell: u32, mut f: impl FnMut(&Block, u32, usize)) {
        let chain = self.chains[cell as usize];
        let (mut left, mut len, mut b) = (chain.len as usize, chain.len_of_first(), chain.first);
        while left > 0 {
            let block = &self.blocks[b as usize];
            f(block, b, len);
            left -= len;
            (b, len) = (block.next, BLOCK);
        }
    }

    /// Calls `f` for everyone who is registered in a cell.
    #[inline]
    pub fn each(&self, cell: u32, mut f: impl FnMut(&Plan<V>)) {
        self.each_block(cell, |block, _, len| (0..len).for_each(|i| f(&block.plan(i))));
    }

    /// Reads a little of every line of memory that a look at those around a cell needs: the processor then fetches all of them at the same
    /// time, and they are at hand when they are looked at. Changes nothing.
    pub fn fetch(&self, at: [i32; 3]) {
        let mut sum = 0.0;
        self.around(at, |cell| {
            let chain = self.chains[cell as usize];
            if chain.len > 0 {
                let block = &self.blocks[chain.first as usize];
                let [x, y, z] = &block.axes;
                sum += block.start[0] as f32 + block.moving[0] + block.limit[0] + block.end[0] as f32;
                sum += x.velocity[0] + y.position[0] + y.acceleration[0];
                if V::DIMENSIONS == 3 {
                    sum += z.velocity[0];
                }
            }
        });
        std::hint::black_box(sum);
    }

    /// Most blocks that the cells around one can have.
    pub fn most_around(&self) -> usize {
        self.address.len() / BLOCK + 3usize.pow(V::DIMENSIONS as u32)
    }

    /// Changes a plan; who comes into another cell is registered there. `from` is the cell where it is registered.
    pub fn set(&mut self, from: u32, to: u32, plan: &Plan<V>) {
        if from == to {
            let address = self.address[plan.index as usize] as usize;
            self.blocks[address / BLOCK].put(address % BLOCK, plan);
        } else {
            self.remove(from, plan.index);
            self.insert(to, plan);
        }
    }

    /// Registers a member in a cell.
    pub fn insert(&mut self, cell: u32, plan: &Plan<V>) {
        let mut chain = self.chains[cell as usize];
        if (chain.len as usize).is_multiple_of(BLOCK) {
            let Some(fresh) = self.free.pop() else { return };
            self.blocks[fresh as usize].next = chain.first;
            chain.first = fresh;
        }
        chain.len += 1;
        let place = chain.len_of_first() - 1;
        self.blocks[chain.first as usize].put(place, plan);
        self.address[plan.index as usize] = chain.first * BLOCK as u32 + place as u32;
        self.chains[cell as usize] = chain;
    }

    /// Takes a member out of its cell. The last one of the cell takes its place.
    pub fn remove(&mut self, cell: u32, member: u32) {
        let mut chain = self.chains[cell as usize];
        let (block, place) = self.place(member);
        let first = &self.blocks[chain.first as usize];
        let (last_place, next) = (chain.len_of_first() - 1, first.next);
        let last = first.plan::<V>(last_place);
        if last_place == 0 {
            self.free.push(chain.first);
            chain.first = next;
        }
        chain.len -= 1;
        self.chains[cell as usize] = chain;
        self.blocks[block as usize].put(place, &last);
        self.address[last.index as usize] = block * BLOCK as u32 + place as u32;
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
                    cells.each(cell, |p| there.push(p.index));
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
