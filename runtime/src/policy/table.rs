//! Policy tables as they are stored, and the checked view on them.

use super::adaptive::{StateGridRecord, check_state_grids};
use super::error::PolicyError;
use super::grid::{GridRecord, TargetGrid};
use super::moments::PathRecord;
use super::region::RegionRecord;
use super::reward::{Reward, RewardRecord};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::ops::Range;

/// Stands where a state has fewer actions than the table has room for.
pub const NO_ACTION: u8 = 255;
/// Most actions a state may have.
pub const MAX_ACTIONS: usize = 255;

/// What a policy stores beside its slices.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PolicyRecord {
    /// Cells of the target; in an adaptive policy the finest ones.
    pub grid: GridRecord,
    /// How the samples of a [`SegmentRecord`] become a reward.
    pub reward: RewardRecord,
    /// Where the behaviour is active.
    pub region: RegionRecord,
    /// What the grid is around, as seen from the character: x, z. [Unit: m]
    pub centre: [f32; 2],
    /// States of the motion graph.
    pub num_states: u32,
    /// Segments of the motion graph.
    pub num_segments: u32,
    /// Best actions stored per (state, cell). [Limit: 1 to 4]
    pub num_choices: u32,
    /// Discount per frame at the database rate. [Limit: > 0, < 1]
    pub discount: f32,
    /// Values are within this of the optimal ones; in an adaptive policy those it was made of, on the finest grid
    /// everywhere. [Limit: > 0]
    pub epsilon: f32,
    /// Measured largest change of a value in one full sweep over the stored values; in an adaptive policy over those
    /// it was made of.
    pub residual: f32,
    /// Full sweeps it took.
    pub num_sweeps: u32,
    /// 1 where every state has a grid of its own ([`StateGridRecord`]), else 0.
    pub adaptive: u32,
}
const _: () = assert!(size_of::<PolicyRecord>() == 144);

/// What a policy knows of a segment, one cache line. Segments are shared by the actions of many states.
///
/// Places and the displacement are those of the grid, which stands around [`PolicyRecord::centre`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SegmentRecord {
    /// Cosine and sine of the displacement's heading, then its x and z. [Unit: m]
    pub displacement: [f32; 4],
    /// Ground positions of the two inner samples: x, z, x, z. [Unit: m]
    pub inner: [f32; 4],
    /// Weights of the four samples: at the start, the two inner ones, at the end. [Limit: >= 0]
    pub weights: [f32; 4],
    /// Heights of the two inner samples; only read where the grid has heights. [Unit: m]
    pub heights: [f32; 2],
    /// Discount to the power of the segment's frames. [Limit: > 0, < 1]
    pub discount: f32,
    /// State at the end.
    pub end: u32,
}
const _: () = assert!(size_of::<SegmentRecord>() == 64);

impl SegmentRecord {
    /// The sixteen fields, four by four.
    #[inline(always)]
    pub(super) fn quarters(&self) -> &[[f32; 4]; 4] {
        bytemuck::cast_ref(self)
    }

    /// A target after the segment was played: x and z in the new frame, and the distance. [Unit: m]
    #[inline(always)]
    pub fn target_after(&self, target: Vec3) -> [f32; 3] {
        let [c, s, x, z] = self.displacement;
        let (dx, dz) = (target.x - x, target.z - z);
        [c * dx - s * dz, s * dx + c * dz, (dx * dx + dz * dz).sqrt()]
    }
}

/// Checked view on states and their actions: which segment each action plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionTable<'a> {
    offsets: &'a [u32],
    segments: &'a [u32],
    num_segments: usize,
}

impl<'a> ActionTable<'a> {
    /// - `offsets`: actions of state s are `offsets[s]..offsets[s + 1]`. [Size: num_states + 1]
    /// - `segments`: segment of each action. [Size: num_actions] [Limit: < num_segments]
    ///
    /// # Errors
    /// [`PolicyError`] where offsets do not ascend from 0 to the number of actions, a state has no action or more
    /// than [`MAX_ACTIONS`], or a segment does not exist.
    pub fn new(offsets: &'a [u32], segments: &'a [u32], num_segments: usize) -> Result<Self, PolicyError> {
        let (Some(&first), Some(&last)) = (offsets.first(), offsets.last()) else {
            return Err(PolicyError::Length { what: "action offsets", got: 0, expected: 1 });
        };
        if first != 0 {
            return Err(PolicyError::Index { what: "action offsets", at: 0, got: first as usize, limit: 1 });
        }
        if last as usize != segments.len() {
            return Err(PolicyError::Length { what: "actions", got: segments.len(), expected: last as usize });
        }
        for (at, pair) in offsets.windows(2).enumerate() {
            let (got, limit) = (pair[1] as usize, pair[0] as usize + MAX_ACTIONS + 1);
            if pair[1] <= pair[0] || got >= limit {
                return Err(PolicyError::Index { what: "action offsets", at: at + 1, got, limit });
            }
        }
        check_indices("action segments", segments.iter().map(|&s| s as usize), num_segments)?;
        Ok(Self { offsets, segments, num_segments })
    }

    /// Number of states.
    pub fn num_states(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Number of actions of all states.
    pub fn num_actions(&self) -> usize {
        self.segments.len()
    }

    /// Number of segments.
    pub fn num_segments(&self) -> usize {
        self.num_segments
    }

    /// True for two views on equal tables; quick where they are views on the same one.
    pub fn is_same(&self, other: &Self) -> bool {
        std::ptr::eq(self.offsets, other.offsets) && std::ptr::eq(self.segments, other.segments) || self == other
    }

    /// Segments of a state's actions, in order. [Size: 1 to 255] [Limit: state < num_states]
    #[inline]
    pub fn segments_of(&self, state: u32) -> &'a [u32] {
        let s = state as usize;
        &self.segments[self.offsets[s] as usize..self.offsets[s + 1] as usize]
    }
}

/// The slices of a policy, borrowed from a bundle.
#[derive(Clone, Copy, Debug, Default)]
pub struct PolicySlices<'a> {
    /// Motion of each segment. [Size: num_segments]
    pub segments: &'a [SegmentRecord],
    /// In a grid of moments, the way of the point that is to be away. [Size: num_segments, 0 in other grids]
    pub paths: &'a [PathRecord],
    /// In an adaptive policy, the resolution of each state. [Size: num_states, 0 in other policies]
    pub state_grids: &'a [StateGridRecord],
    /// Value of each (state, cell). [Size: num_states * num_cells, or the cells of all state grids]
    pub values: &'a [f32],
    /// Best actions of each (state, cell), best first, [`NO_ACTION`] where there are no more.
    /// [Size: values.len() * num_choices]
    pub best: &'a [u8],
}

/// Checked view on one policy: the value of every (state, cell), and the few best actions there (003 section 4.2).
///
/// Answers in two ways: [`super::BestActionJob`] loads the stored best action of the nearest cell,
/// [`super::LookAheadJob`] weighs all actions of a state by their reward and the interpolated value of where they lead.
///
/// # Source
/// J. Lee and K. H. Lee, "Precomputing Avatar Behavior from Human Motion Data", SCA 2004, sections 3 to 5. Differs:
/// values come from full sweeps to a measured residual instead of random updates; rings may lie at growing distances;
/// every state may have a resolution of its own, as section 7 looks forward to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolicyTable<'a> {
    pub(super) grid: TargetGrid,
    pub(super) reward: Reward,
    pub(super) actions: ActionTable<'a>,
    pub(super) segments: &'a [SegmentRecord],
    pub(super) paths: &'a [PathRecord],
    pub(super) state_grids: &'a [StateGridRecord],
    pub(super) values: &'a [f32],
    region: RegionRecord,
    centre: Vec3,
    best: &'a [u8],
    num_choices: usize,
    discount: f32,
}

impl<'a> PolicyTable<'a> {
    /// # Errors
    /// [`PolicyError`] names the slice whose length, index or number does not fit; nothing panics later.
    pub fn new(record: &PolicyRecord, actions: ActionTable<'a>, slices: PolicySlices<'a>) -> Result<Self, PolicyError> {
        let grid = TargetGrid::new(record.grid)?;
        let reward = Reward::new(record.reward)?;
        check_length("policy states", record.num_states as usize, actions.num_states())?;
        check_length("policy segments", record.num_segments as usize, actions.num_segments())?;
        check_length("segments", slices.segments.len(), actions.num_segments())?;
        check_indices("num_choices", [(record.num_choices as usize).wrapping_sub(1)], super::MAX_RANKED)?;
        let num_choices = record.num_choices as usize;
        let num_values = check_resolution(record, &grid, slices.state_grids, actions.num_states())?;
        check_length("values", slices.values.len(), num_values)?;
        // The look-ahead counts places in the table with 32 bits.
        check_indices("number of values", [num_values], u32::MAX as usize)?;
        check_length("best actions", slices.best.len(), num_values * num_choices)?;
        check_numbers("discount", &[record.discount], |v| v > 0.0 && v < 1.0, "between 0 and 1")?;
        let figures = [record.epsilon, record.residual];
        check_numbers("epsilon and residual", &figures, |v| (0.0..1e6).contains(&v), "between 0 and 1e6")?;
        check_numbers("values", slices.values, |v| v.abs() < 1e6, "below 1e6")?;
        check_segments(slices.segments, actions.num_states(), grid.is_polar())?;
        record.region.check()?;
        check_numbers("centre", &record.centre, |v| v.abs() < 1e3, "below 1000")?;
        check_length("paths", slices.paths.len(), if grid.is_moments() { actions.num_segments() } else { 0 })?;
        check_paths(slices.paths)?;
        let table = Self {
            grid,
            reward,
            actions,
            segments: slices.segments,
            paths: slices.paths,
            state_grids: slices.state_grids,
            values: slices.values,
            region: record.region,
            centre: Vec3::new(record.centre[0], 0.0, record.centre[1]),
            best: slices.best,
            num_choices,
            discount: record.discount,
        };
        table.check_best()?;
        Ok(table)
    }

    /// The target grid; in an adaptive policy the finest one, see [`Self::grid_of`].
    pub fn grid(&self) -> &TargetGrid {
        &self.grid
    }

    /// The reward.
    pub fn reward(&self) -> &Reward {
        &self.reward
    }

    /// Where the behaviour is active, in the character's frame.
    pub fn region(&self) -> &RegionRecord {
        &self.region
    }

    /// What the grid is around, in the character's frame. [Unit: m]
    pub fn centre(&self) -> Vec3 {
        self.centre
    }

    /// A target of the character's frame, as the grid counts. [Unit: m]
    #[inline]
    pub fn to_grid(&self, target: Vec3) -> Vec3 {
        target - self.centre
    }

    /// The target in the middle of a cell of a state's grid, in the character's frame. [Unit: m]
    /// [Limit: state < num_states, cell < that grid's num_cells]
    pub fn cell_target(&self, state: u32, cell: usize) -> Vec3 {
        self.grid_of(state).cell_centre(cell) + self.centre
    }

    /// The cell of a state's grid that is nearest to a target in the character's frame. [Limit: state < num_states]
    #[inline]
    pub fn nearest_cell(&self, state: u32, target: Vec3) -> usize {
        let target = self.to_grid(target);
        match self.state_grids.get(state as usize) {
            None => self.grid.nearest_cell(target),
            Some(own) => self.grid.nearest_cell_of(own.counts(), target),
        }
    }

    /// States and their actions.
    pub fn actions(&self) -> ActionTable<'a> {
        self.actions
    }

    /// Motion of each segment.
    pub fn segments(&self) -> &'a [SegmentRecord] {
        self.segments
    }

    /// In a grid of moments, the way of the guarded point over each segment; else none.
    pub fn paths(&self) -> &'a [PathRecord] {
        self.paths
    }

    /// Best actions stored per (state, cell).
    pub fn num_choices(&self) -> usize {
        self.num_choices
    }

    /// Number of values of all states.
    pub fn num_values(&self) -> usize {
        self.values.len()
    }

    /// Discount per frame at the database rate.
    pub fn discount(&self) -> f32 {
        self.discount
    }

    /// Places of a state's cells in the values. [Limit: state < num_states]
    #[inline]
    fn cells_of(&self, state: u32) -> Range<usize> {
        let (first, n) = match self.state_grids.get(state as usize) {
            None => (state as usize * self.grid.num_cells(), self.grid.num_cells()),
            Some(own) => (own.first as usize, own.num_cells()),
        };
        first..first + n
    }

    /// Values of a state. [Size: num_cells of its grid] [Limit: state < num_states]
    #[inline]
    pub fn values_of(&self, state: u32) -> &'a [f32] {
        &self.values[self.cells_of(state)]
    }

    /// The stored best actions of a cell of a state's grid, best first. [Size: num_choices]
    /// [Limit: state < num_states, cell < that grid's num_cells]
    #[inline]
    pub fn best_of(&self, state: u32, cell: usize) -> &'a [u8] {
        let at = (self.cells_of(state).start + cell) * self.num_choices;
        &self.best[at..at + self.num_choices]
    }

    /// Value of a state with the target at a place in the character's frame, interpolated. [Limit: state < num_states]
    pub fn value(&self, state: u32, target: Vec3) -> f32 {
        self.value_in(state, &self.grid_of(state), self.grid.clamp(self.to_grid(target)))
    }

    /// Value of a state at a place in its grid, interpolated. [Limit: state < num_states]
    #[inline]
    pub(super) fn value_in(&self, state: u32, grid: &TargetGrid, at: Vec3) -> f32 {
        let stencil = grid.stencil(at.x, at.z);
        let n = grid.num_plane_cells();
        let values = self.values_of(state);
        let (height, ratio) = grid.height_interval(at.y);
        let of = |h: usize| stencil.interpolate(&values[h * n..][..n], grid.record().num_angles);
        let low = of(height as usize);
        if ratio > 0.0 { low + (of(height as usize + 1) - low) * ratio } else { low }
    }

    /// Every stored action exists in its state, and every cell has a first choice.
    fn check_best(&self) -> Result<(), PolicyError> {
        for state in 0..self.actions.num_states() as u32 {
            let limit = self.actions.segments_of(state).len();
            let cells = self.cells_of(state);
            let row = cells.start * self.num_choices..cells.end * self.num_choices;
            for (at, &a) in row.clone().zip(&self.best[row]) {
                let none_allowed = at % self.num_choices > 0;
                if usize::from(a) >= limit && !(a == NO_ACTION && none_allowed) {
                    return Err(PolicyError::Index { what: "best actions", at, got: a.into(), limit });
                }
            }
        }
        Ok(())
    }
}

/// Checks the resolution of the states. Returns the number of values.
fn check_resolution(
    record: &PolicyRecord,
    grid: &TargetGrid,
    state_grids: &[StateGridRecord],
    num_states: usize,
) -> Result<usize, PolicyError> {
    check_indices("adaptive", [record.adaptive as usize], if grid.is_moments() { 1 } else { 2 })?;
    if record.adaptive == 0 {
        check_length("state grids", state_grids.len(), 0)?;
        return Ok(num_states * grid.num_cells());
    }
    check_length("state grids", state_grids.len(), num_states)?;
    check_state_grids(state_grids, grid)
}

fn check_length(what: &'static str, got: usize, expected: usize) -> Result<(), PolicyError> {
    if got == expected { Ok(()) } else { Err(PolicyError::Length { what, got, expected }) }
}

fn check_indices(
    what: &'static str,
    indices: impl IntoIterator<Item = usize>,
    limit: usize,
) -> Result<(), PolicyError> {
    match indices.into_iter().enumerate().find(|&(_, got)| got >= limit) {
        Some((at, got)) => Err(PolicyError::Index { what, at, got, limit }),
        None => Ok(()),
    }
}

fn check_numbers(
    what: &'static str,
    numbers: &[f32],
    is_good: impl Fn(f32) -> bool,
    expected: &'static str,
) -> Result<(), PolicyError> {
    match numbers.iter().enumerate().find(|&(_, &v)| !is_good(v)) {
        Some((at, &got)) => Err(PolicyError::Value { what, at, got, expected }),
        None => Ok(()),
    }
}

/// Paths are finite and take time.
fn check_paths(paths: &[PathRecord]) -> Result<(), PolicyError> {
    for p in paths {
        check_numbers("path points", p.points.as_flattened(), |v| v.abs() < 1e6, "below 1e6")?;
        check_numbers("path duration", &[p.duration_s], |v| v > 1e-6 && v < 1e6, "between 1e-6 and 1e6")?;
    }
    Ok(())
}

/// Ends exist, numbers are finite and moderate, factors are in range.
fn check_segments(segments: &[SegmentRecord], num_states: usize, polar: bool) -> Result<(), PolicyError> {
    check_indices("segment end", segments.iter().map(|s| s.end as usize), num_states)?;
    let moderate = |v: f32| v.abs() < 1e6;
    for (at, s) in segments.iter().enumerate() {
        let named = |result: Result<(), PolicyError>| {
            result.map_err(|e| match e {
                PolicyError::Value { what, got, expected, .. } => PolicyError::Value { what, at, got, expected },
                other => other,
            })
        };
        named(check_numbers("segment displacement", &s.displacement, moderate, "below 1e6"))?;
        named(check_numbers("segment samples", &s.inner, moderate, "below 1e6"))?;
        named(check_numbers("segment heights", &s.heights, moderate, "below 1e6"))?;
        named(check_numbers("segment weights", &s.weights, |v| (0.0..1e6).contains(&v), "between 0 and 1e6"))?;
        named(check_numbers("segment discount", &[s.discount], |v| v > 0.0 && v < 1.0, "between 0 and 1"))?;
        let outer = [s.weights[0], s.weights[3]];
        named(check_numbers("segment outer weights", &outer, |v| polar || v == 0.0, "0, as in a grid with heights"))?;
    }
    Ok(())
}
