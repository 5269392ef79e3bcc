//! Policy tables as stored, and the checked view of them.

use super::adaptive::{StateGridRecord, check_state_grids};
use super::grid::{GridRecord, TargetGrid};
use super::maths::{greatest, least};
use super::reward::{Reward, RewardRecord};
use super::{region::RegionRecord, space_time::PathRecord};
use crate::format::Table;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::ops::Range;
use throng_base::error::{check_index, check_length, check_value};
use throng_base::{Error, Id, Result, maths};

/// Marks an unused slot for an action.
pub const NO_ACTION: u8 = 255;
/// Most actions a state may have.
pub const MAX_ACTIONS: usize = 255;

/// The fixed-size part of a stored policy.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PolicyRecord {
    /// Grid of the target; in an adaptive policy the finest one.
    pub grid: GridRecord,
    /// Reward of the samples of a [`SegmentRecord`].
    pub reward: RewardRecord,
    /// Active region of the behaviour.
    pub region: RegionRecord,
    /// Centre of the grid in the character's frame: x, z (m).
    pub centre: [f32; 2],
    /// States of the motion graph.
    pub num_states: u32,
    /// Segments of the motion graph.
    pub num_segments: u32,
    /// Best actions stored per (state, cell) (1 to 4).
    pub num_choices: u32,
    /// Discount per frame at the database rate (> 0, < 1).
    pub discount: f32,
    /// Values are within this of the optimal ones (> 0). In an adaptive policy this holds for the values on the finest
    /// grid that it was made from.
    pub epsilon: f32,
    /// Largest change of a value in one full sweep over the stored values, as measured; in an adaptive policy over the
    /// values that it was made from.
    pub residual: f32,
    /// Number of full sweeps.
    pub num_sweeps: u32,
    /// 1 if every state has its own grid ([`StateGridRecord`]), else 0.
    pub adaptive: u32,
}
const _: () = assert!(size_of::<PolicyRecord>() == 144);

/// Data of a segment in a policy, one cache line. Actions of many states share a segment.
///
/// Positions and the displacement are relative to the grid's centre, [`PolicyRecord::centre`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SegmentRecord {
    /// Cosine and sine of the heading of the displacement, then its x and z (m).
    pub displacement: [f32; 4],
    /// Ground positions of the two inner samples: x, z, x, z (m).
    pub inner: [f32; 4],
    /// Weights of the four samples: at the start, the two inner ones, at the end (>= 0).
    pub weights: [f32; 4],
    /// Heights of the two inner samples (m). In a polar grid, which has no heights: the tangent of the largest turn by which the
    /// action is bent, and 1 over the length of its path (1/m); both 0 where it is played as captured.
    pub heights: [f32; 2],
    /// Discount to the power of the segment's frames (> 0, < 1).
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

    /// A target after the segment as captured: x and z in the new frame, and the distance (m).
    #[inline(always)]
    pub fn target_after(&self, target: Vec3) -> [f32; 3] {
        let [c, s, x, z] = self.displacement;
        let (dx, dz) = (target.x - x, target.z - z);
        [c * dx - s * dz, s * dx + c * dz, (dx * dx + dz * dz).sqrt()]
    }

    /// Tangent of half the turn by which the segment is bent in a polar grid, so that it ends nearer to facing a target: all the
    /// turn that is allowed where the target is two lengths of the path or more away, none within one.
    ///
    /// The linear path editing of Lee, Choi and Lee (2006), section 6: the change of heading grows linearly over the action, whose
    /// end is then turned about its start by half of it.
    pub(super) fn half_bend(&self, target: Vec3) -> f32 {
        let [most, per_m] = self.heights;
        let [x, z, distance] = self.target_after(target);
        let most = most * greatest(least(distance * per_m - 1.0, 1.0), 0.0);
        let ahead = greatest(greatest(z, x.abs()), f32::MIN_POSITIVE);
        let aside = x / ahead;
        let aside = aside - greatest(least(aside, STRAIGHT), -STRAIGHT);
        let tangent = greatest(least(aside, most), -most);
        tangent / (1.0 + (1.0 + tangent * tangent).sqrt())
    }
}

/// Checked view of states and their actions: which segment each action plays, and how far off its first frame is.
#[derive(Clone, Debug, PartialEq)]
pub struct ActionTable {
    offsets: Table<u32>,
    segments: Table<u32>,
    errors: Table<f32>,
    num_segments: usize,
}

impl ActionTable {
    /// Checks and wraps the slices.
    ///
    /// - `offsets`: actions of state s are `offsets[s]..offsets[s + 1]` (num_states + 1).
    /// - `segments`: segment of each action (num_actions, < num_segments).
    /// - `errors`: distance between the state's frame and the segment's first one, 0 where the clip goes on (rad,
    ///   num_actions).
    ///
    /// # Errors
    /// [`Error`] where offsets do not ascend from 0 to the number of actions, a state has no action or more
    /// than [`MAX_ACTIONS`], a segment does not exist, or an error is no distance.
    pub fn new(
        offsets: impl Into<Table<u32>>,
        segments: impl Into<Table<u32>>,
        errors: impl Into<Table<f32>>,
        num_segments: usize,
    ) -> Result<Self> {
        let (offsets, segments, errors) = (offsets.into(), segments.into(), errors.into());
        let (Some(&first), Some(&last)) = (offsets.first(), offsets.last()) else {
            return Err(Error::Length { what: "action offsets", got: 0, expected: "1 or more".into() });
        };
        check_value("first action offset", None, first, first == 0, "0")?;
        check_length("actions", segments.len(), last as usize)?;
        check_length("action errors", errors.len(), segments.len())?;
        check_numbers("action error", None, &errors, |e| (0.0..1e9).contains(&e), "a distance")?;
        for (state, pair) in offsets.windows(2).enumerate() {
            let good = pair[1] > pair[0] && (pair[1] - pair[0]) as usize <= MAX_ACTIONS;
            check_value("end of the actions", Some(Id::first(state)), pair[1], good, "1 to 255 after their begin")?;
        }
        check_indices("action segments", segments.iter().map(|&s| s as usize), num_segments)?;
        Ok(Self { offsets, segments, errors, num_segments })
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

    /// Segments of a state's actions, in order (1 to 255, state < num_states).
    #[inline]
    pub fn segments_of(&self, state: u32) -> &[u32] {
        &self.segments[self.actions_of(state)]
    }

    /// The actions of a state.
    #[inline]
    fn actions_of(&self, state: u32) -> Range<usize> {
        let s = state as usize;
        self.offsets[s] as usize..self.offsets[s + 1] as usize
    }
}

/// The rows of a policy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolicySlices {
    /// Motion of each segment (num_segments).
    pub segments: Table<SegmentRecord>,
    /// Path of the guarded point over each segment, on a space-time grid (num_segments, 0 on other grids).
    pub paths: Table<PathRecord>,
    /// Distance of each action that costs as much as its transition and all else that the behaviour counts of it
    /// (num_actions, or 0 where [`RewardRecord::own_errors`] is 0) (rad).
    pub errors: Table<f32>,
    /// Resolution of each state, in an adaptive policy (num_states, 0 in other policies).
    pub state_grids: Table<StateGridRecord>,
    /// Value of each (state, cell) (num_states * num_cells, or the cells of all state grids).
    pub values: Table<f32>,
    /// Best actions of each (state, cell), best first, padded with [`NO_ACTION`] (values.len() * num_choices).
    pub best: Table<u8>,
}

/// Checked view of one policy: the value and the best few actions of every (state, cell) (Lee and Lee 2004, section
/// 4.2).
///
/// [`super::BestActionJob`] loads the stored best action of the nearest cell; [`super::LookAheadJob`] ranks all actions
/// of a state by reward plus interpolated value of the successor.
///
/// # Source
/// J. Lee and K. H. Lee, "Precomputing Avatar Behavior from Human Motion Data", SCA 2004, sections 3 to 5. Differs:
/// values come from full sweeps to a measured residual instead of random updates; the distance between rings may grow;
/// every state may have its own resolution, which section 7 suggests.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyTable {
    pub(super) grid: TargetGrid,
    pub(super) reward: Reward,
    pub(super) actions: ActionTable,
    pub(super) rows: PolicySlices,
    region: RegionRecord,
    centre: Vec3,
    num_choices: usize,
    discount: f32,
    /// True where actions are bent ([`SegmentRecord::half_bend`]).
    pub(super) bends: bool,
}

impl PolicyTable {
    /// Checks and wraps the record and slices of a policy.
    ///
    /// # Errors
    /// [`Error`] names the slice whose length, index or number does not fit; nothing panics later.
    pub fn new(record: &PolicyRecord, actions: ActionTable, slices: PolicySlices) -> Result<Self> {
        let grid = TargetGrid::new(record.grid)?;
        let reward = Reward::new(record.reward)?;
        check_length("policy states", record.num_states as usize, actions.num_states())?;
        check_length("policy segments", record.num_segments as usize, actions.num_segments())?;
        check_length("segments", slices.segments.len(), actions.num_segments())?;
        check_indices("num_choices", [(record.num_choices as usize).wrapping_sub(1)], super::MAX_RANKED)?;
        let num_choices = record.num_choices as usize;
        let num_values = check_resolution(record, &grid, &slices.state_grids)?;
        check_length("values", slices.values.len(), num_values)?;
        // The look-ahead counts places in the table with 32 bits.
        check_indices("number of values", [num_values], u32::MAX as usize)?;
        check_length("best actions", slices.best.len(), num_values.saturating_mul(num_choices))?;
        check_numbers("discount", None, &[record.discount], |v| v > 0.0 && v < 1.0, "between 0 and 1")?;
        let figures = [record.epsilon, record.residual];
        check_numbers("epsilon and residual", None, &figures, |v| (0.0..1e6).contains(&v), "between 0 and 1e6")?;
        let mut values = slices.values.iter().enumerate();
        values.try_for_each(|(at, &v)| check_value("value", Some(Id::first(at)), v, v.abs() < 1e6, "below 1e6"))?;
        check_segments(&slices.segments, actions.num_states(), grid.is_polar())?;
        record.region.check()?;
        check_numbers("centre", None, &record.centre, |v| v.abs() < 1e3, "below 1000")?;
        check_length("paths", slices.paths.len(), if grid.is_space_time() { actions.num_segments() } else { 0 })?;
        check_paths(&slices.paths)?;
        check_length("own errors", slices.errors.len(), record.reward.own_errors as usize * actions.num_actions())?;
        check_numbers("own error", None, &slices.errors, |e| (0.0..1e9).contains(&e), "a distance")?;
        let bends = grid.is_polar() && slices.segments.iter().any(|s| s.heights[0] > 0.0);
        let centre = Vec3::new(record.centre[0], 0.0, record.centre[1]);
        let (rows, region, discount) = (slices, record.region, record.discount);
        let table = Self { grid, reward, actions, rows, region, centre, num_choices, discount, bends };
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

    /// Active region of the behaviour, in the character's frame.
    pub fn region(&self) -> &RegionRecord {
        &self.region
    }

    /// Centre of the grid in the character's frame (m).
    pub fn centre(&self) -> Vec3 {
        self.centre
    }

    /// A target relative to the grid's centre (m).
    #[inline]
    pub fn to_grid(&self, target: Vec3) -> Vec3 {
        target - self.centre
    }

    /// The cell of a state's grid that is nearest to a target in the character's frame (state < num_states).
    #[inline]
    pub fn nearest_cell(&self, state: u32, target: Vec3) -> usize {
        let target = self.to_grid(target);
        match self.rows.state_grids.get(state as usize) {
            None => self.grid.nearest_cell(target),
            Some(own) => self.grid.nearest_cell_of(own.counts(), target),
        }
    }

    /// States and their actions.
    pub fn actions(&self) -> &ActionTable {
        &self.actions
    }

    /// Distances of a state's actions from its frame, in order, with all that the behaviour counts beside (1 to 255,
    /// state < num_states) (rad).
    #[inline]
    pub fn errors_of(&self, state: u32) -> &[f32] {
        let own = if self.rows.errors.is_empty() { &self.actions.errors } else { &self.rows.errors };
        &own[self.actions.actions_of(state)]
    }

    /// Motion of each segment.
    pub fn segments(&self) -> &[SegmentRecord] {
        &self.rows.segments
    }

    /// Turn by which a segment is bent towards a target in the character's frame (rad, segment < num_segments).
    pub fn bend(&self, segment: u32, target: Vec3) -> f32 {
        let half = if self.bends { self.segments()[segment as usize].half_bend(self.to_grid(target)) } else { 0.0 };
        2.0 * maths::atan2(half, 1.0)
    }

    /// A target relative to the grid's centre, as the samples of a segment see it while it is bent, and where it lies after the
    /// segment: x, z and the distance (m, segment < num_segments).
    pub fn target_along(&self, segment: u32, target: Vec3) -> (Vec3, [f32; 3]) {
        let record = &self.segments()[segment as usize];
        let half = if self.bends { record.half_bend(target) } else { 0.0 };
        let cos = (1.0 + half * half).sqrt().recip();
        let sin = half * cos;
        let turned = |x: f32, z: f32| [cos * x - sin * z, sin * x + cos * z];
        let [x, z] = turned(target.x, target.z);
        let seen = Vec3::new(x, target.y, z);
        let [x, z, distance] = record.target_after(seen);
        let [x, z] = turned(x, z);
        (seen, [x, z, distance])
    }

    /// Path of the guarded point over each segment, on a space-time grid; else empty.
    pub fn paths(&self) -> &[PathRecord] {
        &self.rows.paths
    }

    /// Best actions stored per (state, cell).
    pub fn num_choices(&self) -> usize {
        self.num_choices
    }

    /// Number of values of all states.
    pub fn num_values(&self) -> usize {
        self.rows.values.len()
    }

    /// Discount per frame at the database rate.
    pub fn discount(&self) -> f32 {
        self.discount
    }

    /// Range of a state's cells within the values (state < num_states).
    #[inline]
    fn cells_of(&self, state: u32) -> Range<usize> {
        let (first, n) = match self.rows.state_grids.get(state as usize) {
            None => (state as usize * self.grid.num_cells(), self.grid.num_cells()),
            Some(own) => (own.first as usize, own.num_cells()),
        };
        first..first + n
    }

    /// Values of a state (num_cells of its grid, state < num_states).
    #[inline]
    pub fn values_of(&self, state: u32) -> &[f32] {
        &self.rows.values[self.cells_of(state)]
    }

    /// The stored best actions of a cell of a state's grid, best first (num_choices, state < num_states, cell <
    /// num_cells of that grid).
    #[inline]
    pub fn best_of(&self, state: u32, cell: usize) -> &[u8] {
        let at = (self.cells_of(state).start + cell) * self.num_choices;
        &self.rows.best[at..at + self.num_choices]
    }

    /// Interpolated value of a state for a target in the character's frame (state < num_states).
    pub fn value(&self, state: u32, target: Vec3) -> f32 {
        self.value_in(state, &self.grid_of(state), self.grid.clamp(self.to_grid(target)))
    }

    /// Interpolated value of a state for a target relative to the grid's centre (state < num_states).
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

    /// Checks that every stored action exists in its state and that every cell has a first choice.
    fn check_best(&self) -> Result<()> {
        for state in 0..self.actions.num_states() as u32 {
            let limit = self.actions.segments_of(state).len();
            let cells = self.cells_of(state);
            let row = cells.start * self.num_choices..cells.end * self.num_choices;
            for (at, &a) in row.clone().zip(&self.rows.best[row]) {
                let none_allowed = at % self.num_choices > 0;
                if usize::from(a) >= limit && !(a == NO_ACTION && none_allowed) {
                    check_index("best action", Some(Id::first(at)), a.into(), limit)?;
                }
            }
        }
        Ok(())
    }
}

/// Checks the resolution of the states. Returns the number of values.
fn check_resolution(record: &PolicyRecord, grid: &TargetGrid, state_grids: &[StateGridRecord]) -> Result<usize> {
    let num_states = record.num_states as usize;
    check_indices("adaptive", [record.adaptive as usize], if grid.is_space_time() { 1 } else { 2 })?;
    if record.adaptive == 0 {
        check_length("state grids", state_grids.len(), 0)?;
        return Ok(num_states.saturating_mul(grid.num_cells()));
    }
    check_length("state grids", state_grids.len(), num_states)?;
    check_state_grids(state_grids, grid)
}

fn check_indices(what: &'static str, indices: impl IntoIterator<Item = usize>, limit: usize) -> Result<()> {
    let mut indices = indices.into_iter().enumerate();
    indices.try_for_each(|(at, got)| check_index(what, Some(Id::first(at)), got, limit))
}

fn check_numbers(
    what: &'static str,
    who: Option<Id>,
    numbers: &[f32],
    is_good: impl Fn(f32) -> bool,
    expected: &'static str,
) -> Result<()> {
    numbers.iter().try_for_each(|&got| check_value(what, who, got, is_good(got), expected))
}

/// Checks that paths are finite and have a duration.
fn check_paths(paths: &[PathRecord]) -> Result<()> {
    for (at, p) in paths.iter().enumerate() {
        let who = Some(Id::first(at));
        check_numbers("path points", who, p.points.as_flattened(), |v| v.abs() < 1e6, "below 1e6")?;
        check_numbers("path duration", who, &[p.duration_s], |v| v > 1e-6 && v < 1e6, "between 1e-6 and 1e6")?;
    }
    Ok(())
}

/// Tangent of the angle up to which a target lies straight ahead: for less, nobody bends a path.
pub(super) const STRAIGHT: f32 = 0.03;

/// Tangent of the largest turn by which an action may be bent.
pub const MAX_BEND: f32 = 1.0;

/// Checks that ends exist, numbers are finite and below their limits, and factors are in range.
fn check_segments(segments: &[SegmentRecord], num_states: usize, polar: bool) -> Result<()> {
    check_indices("segment end", segments.iter().map(|s| s.end as usize), num_states)?;
    let moderate = |v: f32| v.abs() < 1e6;
    for (at, s) in segments.iter().enumerate() {
        let who = Some(Id::first(at));
        check_numbers("segment displacement", who, &s.displacement, moderate, "below 1e6")?;
        check_numbers("segment samples", who, &s.inner, moderate, "below 1e6")?;
        check_numbers("segment heights", who, &s.heights, moderate, "below 1e6")?;
        let bends = |v: f32| !polar || (0.0..=MAX_BEND).contains(&v);
        check_numbers("segment bend", who, &s.heights[..1], bends, "between 0 and 1, as a tangent")?;
        check_numbers("segment weights", who, &s.weights, |v| (0.0..1e6).contains(&v), "between 0 and 1e6")?;
        check_numbers("segment discount", who, &[s.discount], |v| v > 0.0 && v < 1.0, "between 0 and 1")?;
        let outer = [s.weights[0], s.weights[3]];
        check_numbers("segment outer weights", who, &outer, |v| polar || v == 0.0, "0, as in a grid with heights")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path of 1 m ahead that may be bent by 0.2 rad a metre.
    fn ahead() -> SegmentRecord {
        SegmentRecord { displacement: [1.0, 0.0, 0.0, 1.0], heights: [0.2f32.tan(), 1.0], ..SegmentRecord::default() }
    }

    #[test]
    fn bending_turns_towards_the_target_and_keeps_its_limit() {
        let bend = |x: f32, z: f32| 2.0 * ahead().half_bend(Vec3::new(x, 0.0, z)).atan();
        assert!((bend(0.5, 5.0) - (0.5f32 / 4.0 - STRAIGHT).atan()).abs() < 1e-6);
        assert_eq!(bend(0.1, 5.0), 0.0, "nearly straight ahead");
        for (x, z, most) in [(5.0, 1.0, 0.2), (-5.0, 1.0, -0.2), (1.0, -9.0, 0.2), (0.0, 5.0, 0.0)] {
            assert!((bend(x, z) - most).abs() < 1e-6, "{x} {z}");
        }
        // Within a length of the path of its end it is played as captured, from two lengths on it is bent by all of the turn.
        assert_eq!(bend(0.5, 1.5), 0.0);
        assert!((0.05..0.15).contains(&bend(1.5, 1.0)), "{}", bend(1.5, 1.0));
        let unbent = SegmentRecord { heights: [0.0; 2], ..ahead() };
        assert_eq!(unbent.half_bend(Vec3::new(5.0, 0.0, 1.0)), 0.0);
    }
}
