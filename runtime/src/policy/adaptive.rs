//! Grids of a resolution of their own for every state: fine where its values change fast, coarse where they do not.
//!
//! All of them cover the same places as the policy's grid, which is the finest one. A look-ahead finds the place after
//! an action in numbers of the finest grid's rings, angles and heights, once for eight actions, and scales them to the
//! counts of the state where each action ends.

use super::error::PolicyError;
use super::grid::{Spot, TargetGrid, interval};
use super::maths::{angle_of, least, nearest_index};
use super::table::{PolicyTable, SegmentRecord};
use crate::lanes::{LANES, Lanes};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Most cells of one state of an adaptive policy: they are counted in floats.
pub const MAX_STATE_CELLS: usize = 1 << 24;

/// Resolution of one state's values, and where they are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct StateGridRecord {
    /// Rings, angles, heights, and 0. [Limit: at least 2, 2 and 1; not above those of the policy's grid]
    pub counts: [i16; 4],
    /// First of the state's cells in the values and best actions of the policy.
    pub first: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<StateGridRecord>() == 16);

impl StateGridRecord {
    /// - `counts`: rings, angles, heights. [Limit: 4096 each]
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

/// Checks that counts are in range and that the states' cells follow each other without gaps.
///
/// - returns the number of cells of all states.
pub(super) fn check_state_grids(grids: &[StateGridRecord], finest: &TargetGrid) -> Result<usize, PolicyError> {
    let mut next = 0usize;
    for (at, g) in grids.iter().enumerate() {
        for ((got, most), least) in g.counts().into_iter().zip(finest.counts()).zip([2, 2, 1]) {
            if got < least || got > most {
                let (got, limit) = (got as usize, most as usize + 1);
                return Err(PolicyError::Index { what: "state grid counts (rings, angles, heights)", at, got, limit });
            }
        }
        if g.counts[3] != 0 || g.reserved != 0 {
            return Err(PolicyError::Index { what: "state grid reserved fields", at, got: 1, limit: 1 });
        }
        if g.first as usize != next {
            let (got, limit) = (g.first as usize, next + 1);
            return Err(PolicyError::Index {
                what: "state grid first cells, which follow each other,",
                at,
                got,
                limit,
            });
        }
        if g.num_cells() > MAX_STATE_CELLS {
            let (got, limit) = (g.num_cells(), MAX_STATE_CELLS + 1);
            return Err(PolicyError::Index { what: "state grid cells", at, got, limit });
        }
        next += g.num_cells();
    }
    Ok(next)
}

impl PolicyTable<'_> {
    /// True where every state has a grid of its own.
    #[inline]
    pub fn is_adaptive(&self) -> bool {
        !self.state_grids.is_empty()
    }

    /// The grid of a state's values and best actions: the policy's own, or a coarser one over the same places.
    /// [Limit: state < num_states]
    #[inline]
    pub fn grid_of(&self, state: u32) -> TargetGrid {
        match self.state_grids.get(state as usize) {
            Some(own) if own.counts() != self.grid.counts() => self.grid.with_counts(own.counts()),
            _ => self.grid,
        }
    }

    /// The cell of a state's own grid that is nearest to a cell of the policy's grid; that cell itself where the policy
    /// is not adaptive. [Limit: state < num_states, cell < num_cells]
    pub fn own_cell(&self, state: u32, cell: usize) -> usize {
        match self.state_grids.get(state as usize) {
            None => cell,
            Some(own) => self.grid.nearest_cell_of(own.counts(), self.grid.cell_centre(cell)),
        }
    }

    /// Values where eight segments end, interpolated in the grids of the states there, with the place's scale.
    ///
    /// - `height`: number of the height in the finest grid, the same for all.
    #[inline(always)]
    pub(super) fn adaptive_values<F: Lanes, const POLAR: bool>(
        &self,
        records: &[&SegmentRecord; LANES],
        spot: &Spot<F>,
        height: f32,
    ) -> F {
        let of = |lane: usize| &self.state_grids[records[lane].end as usize];
        let grids = [of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)];
        let [rings, angles, heights, _] = F::decode(grids.map(|g| &g.counts));
        let firsts = F::from_array(grids.map(|g| f32::from_bits(g.first)));
        let (one, two) = (F::splat(1.0), F::splat(2.0));
        let [finest_rings, finest_angles, finest_heights] = self.grid.counts().map(|n| n as f32);
        let ring_step = (rings - one) / F::splat(finest_rings - 1.0);
        let (ring, ring_ratio) = interval(spot.ring * ring_step, rings - two);
        let corners = Corners { low: ring * angles, angles, ring_ratio, spot, finest_angles };
        if POLAR || finest_heights == 1.0 {
            return self.corner_values::<F, POLAR>(firsts, &corners);
        }
        let height_step = (heights - one) / F::splat(finest_heights - 1.0);
        let (height, height_ratio) = interval(F::splat(height) * height_step, (heights - two).max(F::splat(0.0)));
        let plane = rings * angles;
        let next = (height + one).min(heights - one);
        let low = self.corner_values::<F, POLAR>(firsts, &Corners { low: corners.low + height * plane, ..corners });
        let high = self.corner_values::<F, POLAR>(firsts, &Corners { low: corners.low + next * plane, ..corners });
        low + (high - low) * height_ratio
    }

    /// Values of one height, interpolated between angles and rings.
    #[inline(always)]
    fn corner_values<F: Lanes, const POLAR: bool>(&self, firsts: F, corners: &Corners<'_, F>) -> F {
        let &Corners { low, angles, ring_ratio, spot, finest_angles } = corners;
        let one = F::splat(1.0);
        let high = low + angles;
        let (values, ratio);
        if POLAR {
            let step = angles / F::splat(finest_angles);
            let (angle, angle_ratio) = interval(spot.angle * step, angles - one);
            let next = F::select_lt(angle + one, angles, angle + one, F::splat(0.0));
            let of = |cell: F| F::gather(self.values, 0, firsts, 1, cell)[0];
            (values, ratio) = ([[of(low + angle), of(low + next)], [of(high + angle), of(high + next)]], angle_ratio);
        } else {
            let step = (angles - one) / F::splat(finest_angles - 1.0);
            let (angle, angle_ratio) = interval(spot.angle * step, angles - F::splat(2.0));
            // The next angle stands beside it.
            let of = |cell: F| F::gather(self.values, 1, firsts, 1, cell);
            (values, ratio) = ([of(low + angle), of(high + angle)], angle_ratio);
        }
        let [near, far] = values.map(|[a, b]| a + (b - a) * ratio);
        spot.scale * (near + (far - near) * ring_ratio)
    }
}

/// Where eight lanes read one height.
#[derive(Clone, Copy)]
struct Corners<'a, F> {
    /// First cell of the lower ring.
    low: F,
    /// Angles of each lane's grid.
    angles: F,
    ring_ratio: F,
    spot: &'a Spot<F>,
    finest_angles: f32,
}

impl TargetGrid {
    /// [`Self::nearest_cell`] of the grid with other counts of (rings, angles, heights), without making it.
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
    use super::super::look_ahead::{Goal, LookAheadJob};
    use super::super::ranked::RankedActions;
    use super::super::reward::{COMBINE_MAX, KERNEL_EXPONENTIAL, RewardRecord};
    use super::super::table::{ActionTable, PolicyRecord, PolicySlices};
    use super::*;
    use crate::lanes::{Array, Work};
    use proptest::prelude::*;

    const STATES: usize = 5;
    const ACTIONS: usize = 11;

    fn grids() -> [TargetGrid; 3] {
        let sector = (Vec3::new(-1.1, 0.3, 1.2), Vec3::new(1.3, 1.3, 1.6));
        [
            TargetGrid::polar(9, 16, 6.0, 0.25, 2.5).expect("a valid grid"),
            TargetGrid::cylinder([8, 9, 6], sector.0, sector.1, 0.5).expect("a valid grid"),
            TargetGrid::cylinder([8, 9, 1], sector.0, sector.1, 0.5).expect("a valid grid"),
        ]
    }

    /// Numbers that look like noise.
    fn noise(seed: u32) -> impl Iterator<Item = f32> {
        (0..).map(move |i: u32| ((i.wrapping_add(seed)) as f32 * 12.9898).sin() * 0.5 + 0.5)
    }

    struct Tables {
        record: PolicyRecord,
        offsets: Vec<u32>,
        actions: Vec<u32>,
        segments: Vec<SegmentRecord>,
        state_grids: Vec<StateGridRecord>,
        values: Vec<f32>,
        best: Vec<u8>,
    }

    impl Tables {
        /// Every state has each of the counts in turn.
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
                    heights: [1.3, 1.5],
                    discount: 0.9,
                    end: (i * 3 % STATES) as u32,
                }
            });
            Self {
                record: PolicyRecord {
                    grid: *grid.record(),
                    reward: RewardRecord::new(COMBINE_MAX, KERNEL_EXPONENTIAL, 0.7),
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
                segments: segments.collect(),
                values: noise(1).take(first as usize).collect(),
                best: noise(3).take(first as usize).map(|v| (v * 10.9) as u8).collect(),
                state_grids,
            }
        }

        fn open(&self) -> Result<PolicyTable<'_>, PolicyError> {
            let actions = ActionTable::new(&self.offsets, &self.actions, self.segments.len())?;
            let slices = PolicySlices {
                segments: &self.segments,
                paths: &[],
                state_grids: &self.state_grids,
                values: &self.values,
                best: &self.best,
            };
            PolicyTable::new(&self.record, actions, slices)
        }
    }

    /// Shapes of all kinds: the finest, coarse ones, one height, odd ones.
    fn shapes(grid: &TargetGrid) -> Vec<[u32; 3]> {
        let [r, a, h] = grid.counts();
        vec![[r, a, h], [2, 2, 1], [r / 2, a, h.min(2)], [r, a / 2, 1], [3, 5, h.min(3)]]
    }

    /// Scores as they are defined, one action after the other, with the state's own grid.
    fn by_definition(table: &PolicyTable<'_>, state: u32, target: Vec3) -> Vec<f32> {
        let t = table.grid().clamp(table.to_grid(target));
        let start = table.reward().kernel(t.x.hypot(t.z));
        let score = |&segment: &u32| {
            let s = &table.segments()[segment as usize];
            let [x, z, distance] = s.target_after(t);
            let polar = table.grid().is_polar();
            let reward = if polar {
                table.reward().of_segment::<true>(s, t, start, distance)
            } else {
                table.reward().of_segment::<false>(s, t, start, distance)
            };
            reward + s.discount * table.value_in(s.end, &table.grid_of(s.end), Vec3::new(x, t.y, z))
        };
        table.actions().segments_of(state).iter().map(score).collect()
    }

    fn scores(table: &PolicyTable<'_>, state: u32, target: Vec3) -> Vec<f32> {
        let mut out = vec![0.0; ACTIONS];
        table.action_scores(state, target, &mut out).expect("a sound query");
        out
    }

    #[test]
    fn the_finest_grid_everywhere_gives_the_uniform_policy_bit_by_bit() {
        for grid in grids() {
            let adaptive = Tables::new(&grid, &[grid.counts()]);
            let mut uniform = Tables::new(&grid, &[grid.counts()]);
            uniform.record.adaptive = 0;
            uniform.state_grids.clear();
            let (a, u) = (adaptive.open().expect("sound"), uniform.open().expect("sound"));
            for (x, z) in noise(20).zip(noise(40)).take(500) {
                let target = Vec3::new(7.0 * x - 3.0, 1.1 + 0.6 * x, 7.0 * z - 3.0);
                let bits = |t: &PolicyTable<'_>| scores(t, 2, target).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&a), bits(&u), "{target}");
                assert_eq!(a.value(3, target).to_bits(), u.value(3, target).to_bits());
                let cell = u.nearest_cell(1, target);
                assert_eq!((a.nearest_cell(1, target), a.own_cell(1, cell)), (cell, cell));
                assert_eq!(a.best_of(1, cell), u.best_of(1, cell));
            }
        }
    }

    proptest! {
        #[test]
        fn look_ahead_interpolates_in_every_state_s_own_grid(x in -4.0f32..4.0, y in 1.0f32..1.8, z in -4.0f32..4.0) {
            for grid in grids() {
                let tables = Tables::new(&grid, &shapes(&grid));
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
        fn any_state_grid_is_refused_or_answers_without_a_panic(
            at in 0usize..STATES * 16, byte in any::<u8>(), x in any::<f32>(), y in any::<f32>(), z in any::<f32>(),
        ) {
            for grid in grids() {
                let mut tables = Tables::new(&grid, &shapes(&grid));
                bytemuck::cast_slice_mut::<_, u8>(&mut tables.state_grids)[at] = byte;
                let changed = tables.state_grids != Tables::new(&grid, &shapes(&grid)).state_grids;
                let Ok(policy) = tables.open() else { continue };
                prop_assert!(!changed, "a record that does not tile the values is accepted");
                let (states, targets) = ([1u32], [Vec3::new(x, y, z)]);
                let mut ranked = [RankedActions::NONE];
                let goals = [Goal { policy, weights: &[1.0], targets: &targets }];
                let looked = LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run();
                let mut actions = [0];
                let job = BestActionJob { policy, states: &states, targets: &targets, choice: 0, actions: &mut actions };
                prop_assert_eq!(looked.is_ok(), job.run().is_ok());
            }
        }
    }

    #[test]
    fn refuses_what_does_not_tile_the_values() {
        let grid = grids()[1];
        let spoilt = |change: &dyn Fn(&mut Tables)| {
            let mut tables = Tables::new(&grid, &shapes(&grid));
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
        // Larger than its policy's grid, in a swap that keeps the number of cells.
        assert!(spoilt(&|t| t.state_grids[0].counts = [8, 9, 6, 0]));
    }

    #[test]
    fn grids_of_moments_have_one_resolution() {
        let grid = TargetGrid::moments([4, 6, 3], 1.2, 0.8, 0.3).expect("a valid grid");
        let mut tables = Tables::new(&grid, &[grid.counts()]);
        tables.record.grid = *grid.record();
        assert!(matches!(tables.open(), Err(PolicyError::Index { what: "adaptive", .. })));
    }

    /// Scores by plain arrays.
    struct ByArrays<'a>(&'a PolicyTable<'a>, Vec3);

    impl Work for ByArrays<'_> {
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
    fn registers_and_arrays_give_the_same_bits() {
        let grid = grids()[1];
        let tables = Tables::new(&grid, &shapes(&grid));
        let table = tables.open().expect("sound");
        for (x, z) in noise(20).zip(noise(40)).take(200) {
            let target = Vec3::new(4.0 * x - 2.0, 1.4, 3.0 * z - 1.0);
            let arrays = ByArrays(&table, target).run::<Array>();
            assert_eq!(arrays, crate::lanes::dispatch(ByArrays(&table, target)));
        }
    }
}
