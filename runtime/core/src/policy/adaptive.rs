//! Adaptive policies: each state has a grid of its own, fine where its values change fast and coarse elsewhere.
//!
//! All grids cover the same region as the policy's grid, which is the finest one. A look-ahead locates the target after
//! an action in coordinates of the finest grid, for eight actions at once, and scales these to the counts of the state
//! in which each action ends.

use super::grid::{GridCoordinates, TargetGrid, interval};
use super::maths::{angle_of, least, nearest_index};
use super::table::{PolicyTable, SegmentRecord};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use throng_base::simd::{LANES, Lanes};
use throng_base::{Id, Result, error::check_value};

/// Most cells of one state of an adaptive policy, since cells are counted in `f32`.
pub const MAX_STATE_CELLS: usize = 1 << 24;

/// Resolution of one state's grid, and where its cells are stored.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct StateGridRecord {
    /// Rings, angles, heights, and 0 (at least 2, 2 and 1; not above those of the policy's grid).
    pub counts: [i16; 4],
    /// First of the state's cells in the values and best actions of the policy.
    pub first: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<StateGridRecord>() == 16);

impl StateGridRecord {
    /// - `counts`: rings, angles, heights (4096 each).
    pub fn new(counts: [u32; 3], first: u32) -> Self {
        let [rings, angles, heights] = counts.map(|n| n as i16);
        Self { counts: [rings, angles, heights, 0], first, reserved: 0 }
    }

    /// Rings, angles, heights.
    #[inline]
    pub fn counts(&self) -> [u32; 3] {
        [0, 1, 2].map(|k| self.counts[k].max(0) as u32)
    }

    /// Number of cells.
    #[inline]
    pub fn num_cells(&self) -> usize {
        self.counts().iter().fold(1usize, |all, &n| all.saturating_mul(n as usize))
    }
}

/// Checks that counts are in range and that the cells of the states are contiguous.
///
/// - returns the number of cells of all states.
pub(super) fn check_state_grids(grids: &[StateGridRecord], finest: &TargetGrid) -> Result<usize> {
    let expected = "2 or more (1 height), and no more than the finest grid has";
    let mut next = 0usize;
    for (state, g) in grids.iter().enumerate() {
        let who = Some(Id::first(state));
        for ((got, most), least) in g.counts().into_iter().zip(finest.counts()).zip([2, 2, 1]) {
            let good = (least..=most).contains(&got);
            check_value("state grid count of rings, angles or heights", who, got, good, expected)?;
        }
        check_value("state grid reserved field", who, g.reserved, g.counts[3] == 0 && g.reserved == 0, "0")?;
        check_value("state grid first cell", who, g.first, g.first as usize == next, "the end of the grid before it")?;
        let cells = g.num_cells();
        check_value("state grid number of cells", who, cells as f64, cells <= MAX_STATE_CELLS, "at most 2^24")?;
        next += cells;
    }
    Ok(next)
}

impl PolicyTable {
    /// True if every state has its own grid.
    #[inline]
    pub fn is_adaptive(&self) -> bool {
        !self.rows.state_grids.is_empty()
    }

    /// The grid of a state's values and best actions: the policy's grid, or a coarser one over the same region
    /// (state < num_states).
    #[inline]
    pub fn grid_of(&self, state: u32) -> TargetGrid {
        match self.rows.state_grids.get(state as usize) {
            Some(own) if own.counts() != self.grid.counts() => self.grid.with_counts(own.counts()),
            _ => self.grid,
        }
    }

    /// Values at the ends of eight segments, interpolated in the grids of the states there and scaled by `spot.scale`.
    ///
    /// - `height`: height coordinate in the finest grid, the same for all.
    #[inline(always)]
    pub(super) fn adaptive_values<F: Lanes, const POLAR: bool>(
        &self,
        records: &[&SegmentRecord; LANES],
        spot: &GridCoordinates<F>,
        height: f32,
    ) -> F {
        let of = |lane: usize| &self.rows.state_grids[records[lane].end as usize];
        let grids = [of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)];
        let [rings, angles, heights, _] = F::decode(grids.map(|g| &g.counts));
        let firsts = F::from_array(grids.map(|g| f32::from_bits(g.first)));
        let (one, two) = (F::splat(1.0), F::splat(2.0));
        let [finest_rings, finest_angles, finest_heights] = self.grid.counts().map(|n| n as f32);
        let ring_step = (rings - one) / F::splat(finest_rings - 1.0);
        let (ring, ring_ratio) = interval(spot.ring * ring_step, rings - two);
        let corners = GridCorners { low: ring * angles, angles, ring_ratio, spot, finest_angles };
        if POLAR || finest_heights == 1.0 {
            return self.corner_values::<F, POLAR>(firsts, &corners);
        }
        let height_step = (heights - one) / F::splat(finest_heights - 1.0);
        let (height, height_ratio) = interval(F::splat(height) * height_step, (heights - two).max(F::splat(0.0)));
        let plane = rings * angles;
        let next = (height + one).min(heights - one);
        let low = self.corner_values::<F, POLAR>(firsts, &GridCorners { low: corners.low + height * plane, ..corners });
        let high = self.corner_values::<F, POLAR>(firsts, &GridCorners { low: corners.low + next * plane, ..corners });
        low + (high - low) * height_ratio
    }

    /// Values of one height, interpolated between angles and rings.
    #[inline(always)]
    fn corner_values<F: Lanes, const POLAR: bool>(&self, firsts: F, corners: &GridCorners<'_, F>) -> F {
        let &GridCorners { low, angles, ring_ratio, spot, finest_angles } = corners;
        let one = F::splat(1.0);
        let high = low + angles;
        let (values, ratio);
        if POLAR {
            let step = angles / F::splat(finest_angles);
            let (angle, angle_ratio) = interval(spot.angle * step, angles - one);
            let next = F::select_lt(angle + one, angles, angle + one, F::splat(0.0));
            let near = [self.lane_values(firsts, low + angle), self.lane_values(firsts, low + next)];
            let far = [self.lane_values(firsts, high + angle), self.lane_values(firsts, high + next)];
            (values, ratio) = ([near, far], angle_ratio);
        } else {
            let step = (angles - one) / F::splat(finest_angles - 1.0);
            let (angle, angle_ratio) = interval(spot.angle * step, angles - F::splat(2.0));
            // The next angle is stored next to it.
            let near = F::gather(&self.rows.values, 1, firsts, 1, low + angle);
            (values, ratio) = ([near, F::gather(&self.rows.values, 1, firsts, 1, high + angle)], angle_ratio);
        }
        let [near, far] = values.map(|[a, b]| a + (b - a) * ratio);
        spot.scale * (near + (far - near) * ring_ratio)
    }

    /// Values of cells.
    #[inline(always)]
    fn lane_values<F: Lanes>(&self, firsts: F, cells: F) -> F {
        F::gather(&self.rows.values, 0, firsts, 1, cells)[0]
    }
}

/// The cells that eight lanes read at one height.
#[derive(Clone, Copy)]
struct GridCorners<'a, F> {
    /// First cell of the lower ring.
    low: F,
    /// Angles of each lane's grid.
    angles: F,
    ring_ratio: F,
    spot: &'a GridCoordinates<F>,
    finest_angles: f32,
}

impl TargetGrid {
    /// [`Self::nearest_cell`] of the grid with other counts (rings, angles, heights), without constructing that grid.
    pub(super) fn nearest_cell_of(&self, counts: [u32; 3], target: Vec3) -> usize {
        let [rings, angles, heights] = counts;
        let finest = self.counts();
        let step = |n: u32, of: u32| n as f32 / of.max(1) as f32;
        let distance = (target.x * target.x + target.z * target.z).sqrt();
        let ring = least(self.ring_number(distance), (finest[0] - 1) as f32) * step(rings - 1, finest[0] - 1);
        let ring = nearest_index(ring, rings - 1);
        let number = self.angle_number(angle_of(target.x, target.z));
        let angle = if self.is_polar() {
            nearest_index(number * step(angles, finest[1]), angles) % angles
        } else {
            let clamped = number.clamp(0.0, (finest[1] - 1) as f32);
            nearest_index(clamped * step(angles - 1, finest[1] - 1), angles - 1)
        };
        let (height, ratio) = self.height_interval(target.y);
        let height = (height as f32 + ratio) * step(heights - 1, finest[2] - 1);
        ((nearest_index(height, heights - 1) * rings + ring) * angles + angle) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::super::BestActionJob;
    use super::super::grid::tests::{polar, sector};
    use super::super::look_ahead::{LookAheadGoal, LookAheadJob};
    use super::super::ranked::RankedActions;
    use super::super::reward::{COMBINE_MAX, KERNEL_EXPONENTIAL, RewardRecord};
    use super::super::table::{ActionTable, PolicyRecord, PolicySlices};
    use super::*;
    use proptest::prelude::*;
    use throng_base::simd::{ArrayLanes, LaneWork};

    const STATES: usize = 5;
    const ACTIONS: usize = 11;

    fn grids() -> [TargetGrid; 3] {
        [polar([9, 16], 6.0, 0.25), sector([8, 9, 6], 0.5), sector([8, 9, 1], 0.5)]
    }

    /// Pseudo-random numbers in 0..1.
    fn noise(seed: u32) -> impl Iterator<Item = f32> {
        (0..).map(move |i: u32| ((i.wrapping_add(seed)) as f32 * 12.9898).sin() * 0.5 + 0.5)
    }

    struct MadeUp {
        record: PolicyRecord,
        offsets: Vec<u32>,
        actions: Vec<u32>,
        errors: Vec<f32>,
        segments: Vec<SegmentRecord>,
        state_grids: Vec<StateGridRecord>,
        values: Vec<f32>,
        best: Vec<u8>,
    }

    impl MadeUp {
        /// States take the counts in turn.
        fn new(grid: &TargetGrid, counts: &[[u32; 3]]) -> Self {
            let mut first = 0;
            let state_grids = (0..STATES).map(|s| {
                let record = StateGridRecord::new(counts[s % counts.len()], first);
                first += record.num_cells() as u32;
                record
            });
            let state_grids: Vec<_> = state_grids.collect();
            let outer = if grid.is_polar() { 0.3 } else { 0.0 };
            let segments = noise(7).take(ACTIONS).enumerate().map(|(i, v)| {
                let turn = 3.0 * (v - 0.5);
                SegmentRecord {
                    displacement: [turn.cos(), turn.sin(), 0.8 * (v - 0.3), 0.4 * v],
                    inner: [0.1 * v, 0.2, 0.3, v],
                    weights: [outer, 0.4, v, outer],
                    heights: [0.4, 1.5],
                    discount: 0.9,
                    end: (i * 3 % STATES) as u32,
                }
            });
            Self {
                record: PolicyRecord {
                    grid: *grid.record(),
                    reward: RewardRecord {
                        transition_cost: 0.8,
                        ..RewardRecord::new(COMBINE_MAX, KERNEL_EXPONENTIAL, 0.7)
                    },
                    num_states: STATES as u32,
                    num_segments: ACTIONS as u32,
                    num_choices: 1,
                    discount: 0.99,
                    epsilon: 1e-4,
                    adaptive: 1,
                    centre: [0.1, -0.2],
                    ..PolicyRecord::default()
                },
                offsets: (0..=STATES as u32).map(|s| s * ACTIONS as u32).collect(),
                actions: (0..STATES).flat_map(|_| 0..ACTIONS as u32).collect(),
                errors: noise(4).take(STATES * ACTIONS).collect(),
                segments: segments.collect(),
                values: noise(1).take(first as usize).collect(),
                best: noise(3).take(first as usize).map(|v| (v * 10.9) as u8).collect(),
                state_grids,
            }
        }

        fn open(&self) -> Result<PolicyTable> {
            let actions = ActionTable::new(&self.offsets, &self.actions, &self.errors, self.segments.len())?;
            let slices = PolicySlices {
                segments: (&self.segments).into(),
                state_grids: (&self.state_grids).into(),
                values: (&self.values).into(),
                best: (&self.best).into(),
                ..PolicySlices::default()
            };
            PolicyTable::new(&self.record, actions, slices)
        }
    }

    /// Counts to test: the finest, coarse ones, one height, odd ones.
    fn shapes(grid: &TargetGrid) -> Vec<[u32; 3]> {
        let [r, a, h] = grid.counts();
        vec![[r, a, h], [2, 2, 1], [r / 2, a, h.min(2)], [r, a / 2, 1], [3, 5, h.min(3)]]
    }

    /// Scores by their definition, action by action, in the grid of the state at the end.
    fn by_definition(table: &PolicyTable, state: u32, target: Vec3) -> Vec<f32> {
        let t = table.grid().clamp(table.to_grid(target));
        let start = table.reward().kernel(t.x.hypot(t.z));
        let score = |(&segment, &error): (&u32, &f32)| {
            let s = &table.segments()[segment as usize];
            let (seen, [x, z, distance]) = table.target_along(segment, t);
            let polar = table.grid().is_polar();
            let reward = if polar {
                table.reward().of_segment::<true>(s, seen, start, distance)
            } else {
                table.reward().of_segment::<false>(s, t, start, distance)
            };
            let value = table.value_in(s.end, &table.grid_of(s.end), Vec3::new(x, t.y, z));
            (-0.8 * error * error).exp() * (reward + s.discount * value)
        };
        table.actions().segments_of(state).iter().zip(table.errors_of(state)).map(score).collect()
    }

    fn scores(table: &PolicyTable, state: u32, target: Vec3) -> Vec<f32> {
        let mut out = vec![0.0; ACTIONS];
        table.action_scores(state, target, &mut out).expect("a sound query");
        out
    }

    #[test]
    fn finest_grid_in_every_state_equals_the_uniform_policy() {
        for grid in grids() {
            let adaptive = MadeUp::new(&grid, &[grid.counts()]);
            let mut uniform = MadeUp::new(&grid, &[grid.counts()]);
            uniform.record.adaptive = 0;
            uniform.state_grids.clear();
            let (a, u) = (adaptive.open().expect("sound"), uniform.open().expect("sound"));
            for (x, z) in noise(20).zip(noise(40)).take(if cfg!(miri) { 2 } else { 500 }) {
                let target = Vec3::new(7.0 * x - 3.0, 1.1 + 0.6 * x, 7.0 * z - 3.0);
                let bits = |t: &PolicyTable| scores(t, 2, target).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&a), bits(&u), "{target}");
                assert_eq!(a.value(3, target).to_bits(), u.value(3, target).to_bits());
                let cell = u.nearest_cell(1, target);
                let own = a.grid.nearest_cell_of(a.rows.state_grids[1].counts(), a.grid.cell_centre(cell));
                assert_eq!((a.nearest_cell(1, target), own), (cell, cell));
                assert_eq!(a.best_of(1, cell), u.best_of(1, cell));
            }
        }
    }

    proptest! {
        #[test]
        fn look_ahead_interpolates_in_the_grid_of_each_state(x in -4.0f32..4.0, y in 1.0f32..1.8, z in -4.0f32..4.0) {
            for grid in grids() {
                let tables = MadeUp::new(&grid, &shapes(&grid));
                let table = tables.open().expect("sound");
                let target = Vec3::new(x, y, z);
                let (got, wanted) = (scores(&table, 0, target), by_definition(&table, 0, target));
                for (a, b) in got.iter().zip(&wanted) {
                    prop_assert!((a - b).abs() < 2e-5, "{:?} {:?}", got, wanted);
                }
                for state in 0..STATES as u32 {
                    let (own, cell) = (table.grid_of(state), table.nearest_cell(state, target));
                    let nearest = own.nearest_cell(table.grid().clamp(table.to_grid(target)));
                    let apart = |c: usize| own.cell_centre(c).distance(table.grid().clamp(table.to_grid(target)));
                    prop_assert!(cell == nearest || (apart(cell) - apart(nearest)).abs() < 1e-2, "{} {}", cell, nearest);
                }
            }
        }

        #[test]
        fn damaged_state_grids_are_refused_or_answer_without_panic(
            at in 0usize..STATES * 16, byte in any::<u8>(), x in any::<f32>(), y in any::<f32>(), z in any::<f32>(),
        ) {
            for grid in grids() {
                let mut tables = MadeUp::new(&grid, &shapes(&grid));
                bytemuck::cast_slice_mut::<_, u8>(&mut tables.state_grids)[at] = byte;
                let changed = tables.state_grids != MadeUp::new(&grid, &shapes(&grid)).state_grids;
                let Ok(policy) = tables.open() else { continue };
                prop_assert!(!changed, "accepted a record that does not tile the values");
                let (states, targets) = ([1u32], [Vec3::new(x, y, z)]);
                let mut ranked = [RankedActions::NONE];
                let goals = [LookAheadGoal { policy: &policy, weights: &[1.0], targets: &targets }];
                let looked = LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run();
                let mut actions = [0];
                let job = BestActionJob { policy: &policy, states: &states, targets: &targets, choice: 0, actions: &mut actions };
                prop_assert_eq!(looked.is_ok(), job.run().is_ok());
            }
        }
    }

    #[test]
    fn refuses_state_grids_that_do_not_tile_the_values() {
        let grid = grids()[1];
        let spoilt = |change: &dyn Fn(&mut MadeUp)| {
            let mut tables = MadeUp::new(&grid, &shapes(&grid));
            assert!(tables.open().is_ok());
            change(&mut tables);
            tables.open().is_err()
        };
        assert!(spoilt(&|t| t.state_grids[0].counts[0] += 1));
        assert!(spoilt(&|t| t.state_grids[1].counts[2] = 0));
        assert!(spoilt(&|t| t.state_grids[1].counts[1] = 1));
        assert!(spoilt(&|t| t.state_grids[1].counts[3] = 1));
        assert!(spoilt(&|t| t.state_grids[4].first += 1));
        assert!(spoilt(&|t| t.state_grids[2].reserved = 1));
        assert!(spoilt(&|t| t.state_grids.truncate(4)));
        assert!(spoilt(&|t| t.state_grids.clear()));
        assert!(spoilt(&|t| t.record.adaptive = 0));
        assert!(spoilt(&|t| t.record.adaptive = 2));
        assert!(spoilt(&|t| t.values.truncate(20)));
        assert!(spoilt(&|t| t.values.push(0.0)));
        assert!(spoilt(&|t| {
            t.best.pop();
        }));
        assert!(spoilt(&|t| t.best[9] = ACTIONS as u8));
        // Finer than the policy's grid, with the same number of cells.
        assert!(spoilt(&|t| t.state_grids[0].counts = [8, 9, 6, 0]));
    }

    #[test]
    fn space_time_grids_have_one_resolution() {
        let grid = TargetGrid::space_time([4, 6, 3], 1.2, 0.8, 0.3).expect("a valid grid");
        let mut tables = MadeUp::new(&grid, &[grid.counts()]);
        tables.record.grid = *grid.record();
        assert!(matches!(tables.open(), Err(throng_base::Error::Index { what: "adaptive", .. })));
    }

    /// Values computed with plain arrays.
    struct ByArrays<'a>(&'a PolicyTable, Vec3);

    impl LaneWork for ByArrays<'_> {
        type Output = Vec<f32>;

        fn run<F: Lanes>(self) -> Vec<f32> {
            let t = self.0.grid().clamp(self.0.to_grid(self.1));
            let records: [&SegmentRecord; LANES] = std::array::from_fn(|i| &self.0.segments()[i]);
            let (x, z) = (F::splat(t.x), F::splat(t.z));
            let spot = self.0.grid().spot::<F, false>(x, z, (x * x + z * z).sqrt());
            self.0.adaptive_values::<F, false>(&records, &spot, 2.6).to_array().to_vec()
        }
    }

    #[test]
    fn registers_and_arrays_give_equal_bits() {
        let grid = grids()[1];
        let tables = MadeUp::new(&grid, &shapes(&grid));
        let table = tables.open().expect("sound");
        for (x, z) in noise(20).zip(noise(40)).take(if cfg!(miri) { 2 } else { 200 }) {
            let target = Vec3::new(4.0 * x - 2.0, 1.4, 3.0 * z - 1.0);
            let arrays = ByArrays(&table, target).run::<ArrayLanes>();
            assert_eq!(arrays, throng_base::simd::dispatch(ByArrays(&table, target)));
        }
    }
}
