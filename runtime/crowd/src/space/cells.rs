//! The cells of space that agents are registered in, and the plans of all of them.

use crate::space::batch::{PlanLanes, VectorLanes};
use crate::{Space, space::plan::MotionPlan};
use std::marker::PhantomData;
use throng_base::prefetch;
use throng_base::simd::{LANES, Lanes};

/// Agents that a bunch holds.
const BUNCH: usize = 6;
/// Most cells: a grid of more is folded.
const MAX_CELLS: usize = 1 << 22;

/// A plan in packed form: one line of memory. With many thousand plans, fetching those of neighbours from memory is
/// most of an event, so that nothing else is beside them, and eight plans are rearranged side by side only when they
/// are computed with.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct PackedPlan {
    /// Position and the time from the start after which it stands.
    position: [f32; 4],
    /// Velocity and radius.
    velocity: [f32; 4],
    /// Acceleration and its limit.
    acceleration: [f32; 4],
    pub start: f64,
    pub end: f64,
}

impl PackedPlan {
    #[inline]
    fn new<V: Space>(plan: &MotionPlan<V>) -> Self {
        let row = |v: V, last: f32| {
            let [x, y, z] = v.coordinates();
            [x, y, z, last]
        };
        Self {
            position: row(plan.position, plan.moving),
            velocity: row(plan.velocity, plan.radius),
            acceleration: row(plan.acceleration, plan.limit),
            start: plan.start,
            end: plan.end,
        }
    }

    /// The plan of an agent.
    #[inline]
    fn unpack_plan<V: Space>(&self, index: u32) -> MotionPlan<V> {
        let vector = |[x, y, z, _]: [f32; 4]| V::from_coordinates([x, y, z]);
        MotionPlan {
            start: self.start,
            end: self.end,
            position: vector(self.position),
            velocity: vector(self.velocity),
            acceleration: vector(self.acceleration),
            moving: self.position[3],
            radius: self.velocity[3],
            limit: self.acceleration[3],
            index,
        }
    }

    /// Eight plans side by side, and their radii.
    #[inline(always)]
    pub fn load_lanes<V: Space, F: Lanes>(of: [&Self; LANES]) -> (PlanLanes<V, F>, F) {
        let ([x, y, z, moving], [u, v, w, radius], [a, b, c, limit]) = (
            F::columns(of.map(|k| &k.position)),
            F::columns(of.map(|k| &k.velocity)),
            F::columns(of.map(|k| &k.acceleration)),
        );
        let (position, velocity) = (VectorLanes::new(x, y, z), VectorLanes::new(u, v, w));
        (PlanLanes { position, velocity, acceleration: VectorLanes::new(a, b, c), moving, limit }, radius)
    }
}

/// Some of the agents of a cell.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
struct AgentBunch {
    agents: [u32; BUNCH],
    /// Number of agents in the cell, if this is its first bunch.
    len: u32,
    /// Bunch of the next ones, if there are more than fit.
    next: u32,
}

/// Logarithms of the numbers of cells of a torus along each axis: as many as `size` takes and `spare` more, but at most
/// `most` in all, as long as an axis has more than `fewest` bits.
pub(crate) fn fold_bits<V: Space>(size: V, side: f32, spare: usize, fewest: u32, most: usize) -> [u32; 3] {
    let mut bits = [0; 3];
    for (axis, &length) in size.coordinates().iter().take(V::DIMENSIONS).enumerate() {
        bits[axis] = ((length / side).min(1e6) as usize + spare).next_power_of_two().trailing_zeros();
    }
    while 1usize << bits.iter().sum::<u32>() > most && bits.iter().any(|&b| b > fewest) {
        let longest = (0..3).max_by_key(|&axis| (bits[axis], axis)).unwrap_or(0);
        bits[longest] -= 1;
    }
    bits
}

/// Grid of square or cubic cells, each with its agents.
///
/// The grid is a torus: places beyond its extents share cells with places within. That costs a look at agents that are
/// far away, but no place is ever outside, and there are at most 16 cells for each agent, or 1024.
#[derive(Clone, Debug)]
pub(crate) struct CellGrid<V> {
    /// Side of a cell (m).
    pub side: f32,
    per_m: f32,
    /// Logarithm of the number of cells along each axis.
    bits: [u32; 3],
    pub num_cells: usize,
    /// The first bunch of every cell, and after them those that cells with many agents take.
    bunches: Vec<AgentBunch>,
    /// Bunches that no cell has.
    free: Vec<u32>,
    /// Packed plans, by agent.
    plans: Vec<PackedPlan>,
    space: PhantomData<V>,
}

impl<V: Space> CellGrid<V> {
    /// Cells of a side for agents with numbers below `capacity`, most of them within `size`.
    pub fn new(side: f32, size: V, capacity: usize) -> Self {
        // Three or more, so that the neighbours of a cell are all different.
        let bits = fold_bits(size, side, 3, 2, (16 * capacity.max(64)).min(MAX_CELLS));
        let num_cells = 1 << bits.iter().sum::<u32>();
        // No agent takes more than a full bunch does.
        let num_bunches = num_cells + capacity / BUNCH;
        let mut cells = Self {
            side,
            per_m: side.recip(),
            bits,
            num_cells,
            bunches: vec![AgentBunch::default(); num_bunches],
            free: Vec::with_capacity(num_bunches - num_cells),
            plans: vec![PackedPlan::default(); capacity],
            space: PhantomData,
        };
        cells.clear();
        cells
    }

    /// Removes all agents.
    pub fn clear(&mut self) {
        self.bunches[..self.num_cells].iter_mut().for_each(|b| b.len = 0);
        self.free.clear();
        self.free.extend((self.num_cells as u32..self.bunches.len() as u32).rev());
    }

    /// Plans of all agents, in an order in which to insert them gives the same cells.
    pub fn plans(&self) -> Vec<MotionPlan<V>> {
        let mut plans = Vec::new();
        for cell in 0..self.num_cells as u32 {
            self.for_each_in_cell(cell, |plan| plans.push(*plan));
        }
        plans
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

    /// Centre of a cell (m).
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

    /// Coordinate of a cell along an axis, after the grid was folded.
    #[inline]
    pub fn folded(&self, cell: u32, axis: usize) -> usize {
        let below: u32 = self.bits[..axis].iter().sum();
        (cell >> below) as usize & ((1 << self.bits[axis]) - 1)
    }

    /// Coordinates of a cell, after the grid was folded.
    #[inline]
    pub fn coordinates_of(&self, cell: u32) -> [i32; 3] {
        [0, 1, 2].map(|axis| self.folded(cell, axis) as i32)
    }

    /// Calls `f` for the number of every cell around one, itself among them.
    #[inline]
    pub fn for_each_cell_around(&self, at: [i32; 3], mut f: impl FnMut(u32)) {
        let depth = if V::DIMENSIONS == 3 { 1 } else { 0 };
        for z in -depth..=depth {
            for y in -1..=1 {
                for x in -1..=1 {
                    f(self.number([at[0].wrapping_add(x), at[1].wrapping_add(y), at[2].wrapping_add(z)]));
                }
            }
        }
    }

    /// Plan of an agent (it is in a cell).
    #[inline]
    pub fn plan(&self, agent: u32) -> MotionPlan<V> {
        self.packed_plan(agent).unpack_plan(agent)
    }

    /// Plan of an agent in packed form, see [`CellGrid::plan`].
    #[inline]
    pub fn packed_plan(&self, agent: u32) -> &PackedPlan {
        &self.plans[agent as usize]
    }

    /// Calls `f` for each bunch of a cell: with it, and how many there are in it.
    #[inline(always)]
    fn each_bunch(&self, cell: u32, mut f: impl FnMut(&[u32; BUNCH], usize)) {
        let mut bunch = &self.bunches[cell as usize];
        let mut left = bunch.len as usize;
        while left > BUNCH {
            f(&bunch.agents, BUNCH);
            left -= BUNCH;
            bunch = &self.bunches[bunch.next as usize];
        }
        f(&bunch.agents, left);
    }

    /// Calls `f` for every agent of a cell.
    #[inline]
    pub fn for_each_in_cell(&self, cell: u32, mut f: impl FnMut(&MotionPlan<V>)) {
        self.each_bunch(cell, |agents, len| agents[..len].iter().for_each(|&m| f(&self.plan(m))));
    }

    /// Numbers of all agents of the cells around one.
    ///
    /// - `room`: scratch memory that they are written to.
    #[inline]
    pub fn agents_around<'a>(&self, at: [i32; 3], room: &'a mut Vec<u32>) -> &'a [u32] {
        let mut num = 0;
        self.for_each_cell_around(at, |cell| {
            self.each_bunch(cell, |agents, len| {
                // Of a known size, so that it is copied at once; what is not there is overwritten by the next ones.
                if room.len() < num + BUNCH {
                    room.resize(num + BUNCH, 0);
                }
                room[num..num + BUNCH].copy_from_slice(agents);
                num += len;
            });
        });
        &room[..num]
    }

    /// Memory for the numbers of all agents, see [`CellGrid::agents_around`].
    pub fn agent_buffer(capacity: usize) -> Vec<u32> {
        Vec::with_capacity(capacity + BUNCH)
    }

    /// Prefetches the plan of an agent.
    #[inline]
    pub fn prefetch(&self, agent: u32) {
        prefetch(self.packed_plan(agent));
    }

    /// Prefetches the cells around one, without plans.
    #[inline]
    pub fn prefetch_cells(&self, at: [i32; 3]) {
        self.for_each_cell_around(at, |cell| prefetch(&self.bunches[cell as usize]));
    }

    /// Prefetches the plans of agents in the cells around one: of the first few of each cell.
    #[inline]
    pub fn prefetch_plans(&self, at: [i32; 3]) {
        self.for_each_cell_around(at, |cell| {
            let bunch = &self.bunches[cell as usize];
            bunch.agents.iter().take(bunch.len as usize).for_each(|&m| self.prefetch(m));
        });
    }

    /// Changes a plan, and the cell of its agent from `from` to `to`.
    pub fn set(&mut self, from: u32, to: u32, plan: &MotionPlan<V>) {
        if from == to {
            self.plans[plan.index as usize] = PackedPlan::new(plan);
        } else {
            self.remove(from, plan.index);
            self.insert(to, plan);
        }
    }

    /// Registers an agent in a cell.
    pub fn insert(&mut self, cell: u32, plan: &MotionPlan<V>) {
        self.plans[plan.index as usize] = PackedPlan::new(plan);
        let len = self.bunches[cell as usize].len as usize;
        let mut last = self.bunch(cell, len.saturating_sub(1));
        if len > 0 && len.is_multiple_of(BUNCH) {
            let Some(fresh) = self.free.pop() else { return };
            self.bunches[last as usize].next = fresh;
            last = fresh;
        }
        self.bunches[last as usize].agents[len % BUNCH] = plan.index;
        self.bunches[cell as usize].len += 1;
    }

    /// Removes an agent from its cell. The last one of the cell takes its place.
    pub fn remove(&mut self, cell: u32, agent: u32) {
        let Some(last) = (self.bunches[cell as usize].len as usize).checked_sub(1) else { return };
        let bunch = self.bunch(cell, last);
        let moved = self.bunches[bunch as usize].agents[last % BUNCH];
        if last > 0 && last.is_multiple_of(BUNCH) {
            self.free.push(bunch);
        }
        self.bunches[cell as usize].len -= 1;
        let mut at = cell;
        for _ in 0..=last / BUNCH {
            let bunch = &mut self.bunches[at as usize];
            if let Some(place) = bunch.agents.iter_mut().find(|m| **m == agent) {
                *place = moved;
                return;
            }
            at = bunch.next;
        }
    }

    /// Bunch of the n-th one in a cell.
    #[inline]
    fn bunch(&self, cell: u32, n: usize) -> u32 {
        (0..n / BUNCH).fold(cell, |bunch, _| self.bunches[bunch as usize].next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::batch::nth_vector;
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;
    use throng_base::simd::ArrayLanes;

    proptest! {
        #[test]
        fn cells_equal_brute_force_lists(work in proptest::collection::vec((0u32..60, 0i32..3, 0..3), 1..300)) {
            let mut cells = CellGrid::<Vec2>::new(1.0, Vec2::splat(4.0), 60);
            let mut list = vec![None; 60];
            for (agent, x, kind) in work {
                let to = cells.number([x, 0, 0]);
                let plan = MotionPlan { index: agent, limit: x as f32, ..MotionPlan::default() };
                match (list[agent as usize], kind) {
                    (None, _) => {
                        cells.insert(to, &plan);
                        list[agent as usize] = Some(to);
                    }
                    (Some(from), 0) => {
                        cells.remove(from, agent);
                        list[agent as usize] = None;
                    }
                    (Some(from), _) => {
                        cells.set(from, to, &plan);
                        list[agent as usize] = Some(to);
                    }
                }
                for cell in 0..cells.num_cells as u32 {
                    let mut there = Vec::new();
                    cells.for_each_in_cell(cell, |p| there.push(p.index));
                    there.sort_unstable();
                    let want: Vec<u32> = (0..60).filter(|&m| list[m as usize] == Some(cell)).collect();
                    prop_assert_eq!(&there, &want);
                    let is_last = |&m: &u32| cells.number([cells.plan(m).limit as i32, 0, 0]) == cell;
                    prop_assert!(there.iter().all(is_last), "the plan that was set last");
                }
            }
            let plans = cells.plans();
            cells.clear();
            for plan in &plans {
                cells.insert(cells.number([plan.limit as i32, 0, 0]), plan);
            }
            prop_assert_eq!(cells.plans(), plans, "the same order");
        }
    }

    /// Eight plans, each of its own kind, as they are kept.
    fn are_kept<V: Space>() {
        let plan = |i: u32| {
            let vector = |k: f32| V::from_coordinates([k + i as f32, k * 0.1, k - i as f32]);
            let (position, velocity, acceleration) = (vector(1.0), vector(2.0), vector(3.0));
            let (moving, radius, limit) = (4.0 + i as f32, 0.1 * i as f32, 6.0 - 0.5 * i as f32);
            let (start, end) = (1e6 + f64::from(i) * 1e-7, 2e6);
            MotionPlan { start, end, position, velocity, acceleration, moving, radius, limit, index: i }
        };
        let kept: [PackedPlan; LANES] = std::array::from_fn(|i| PackedPlan::new(&plan(i as u32)));
        let (plans, radius) = PackedPlan::load_lanes::<V, ArrayLanes>(kept.each_ref());
        for i in 0..LANES {
            let want = plan(i as u32);
            assert_eq!(kept[i].unpack_plan::<V>(want.index), want);
            let vectors =
                [plans.position, plans.velocity, plans.acceleration].map(|v| nth_vector::<V>(&v.to_arrays(), i));
            assert_eq!(vectors, [want.position, want.velocity, want.acceleration]);
            let numbers = [plans.moving, plans.limit, radius].map(|n| n.to_array()[i]);
            assert_eq!(numbers, [want.moving, want.limit, want.radius]);
        }
    }

    #[test]
    fn each_plan_takes_one_cache_line() {
        assert_eq!((size_of::<PackedPlan>(), align_of::<PackedPlan>()), (64, 64));
        are_kept::<Vec2>();
        are_kept::<Vec3>();
    }

    #[test]
    fn cells_around_one_are_all_different() {
        let flat = CellGrid::<Vec2>::new(2.0, Vec2::splat(1.0), 4);
        let deep = CellGrid::<Vec3>::new(2.0, Vec3::new(90.0, 1.0, 1.0), 4);
        let mut seen = Vec::new();
        flat.for_each_cell_around([-1, 7, 0], |c| seen.push(c));
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 9);
        seen.clear();
        deep.for_each_cell_around([-1, 7, 3], |c| seen.push(c));
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 27);
    }
}
