//! Upper bounds of the gain of a few actions, which let a search skip hopeless branches.

use super::squares::{GroundSquares, PeakCandidates, distances};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use throng_bake::policy::PolicySituation;
use throng_core::policy::{COMBINE_SUM, PolicyTable, Reward, SegmentRecord};

/// Tolerance of bounds against rounding: relative and absolute.
const SLACK: (f32, f32) = (1e-5, 1e-6);
/// Most squares of all states per level of bounds.
const MAX_SQUARES: usize = 1 << 23;
/// Most and fewest squares along a side.
const SIDES: (usize, usize) = (128, 16);

/// Upper bounds of search results, for every state and square of ground with the target. Not for space-time grids.
///
/// Level 0 is the greatest value within the square. Level k is the greatest reward of an action anywhere in the square,
/// plus the discounted bound of level k - 1 over all squares that the action may lead to. Every step takes the greatest
/// possible, so that no sequence of k actions from anywhere in the square can be worth more.
#[derive(Clone, Debug)]
pub struct ValueBounds {
    squares: GroundSquares,
    /// Centre of the grid (m).
    centre: Vec2,
    num_states: usize,
    /// Bounds for sequences of 1, 2, ... actions: [row][state][column].
    levels: Vec<Vec<f32>>,
}

impl ValueBounds {
    /// Bounds for searches of a depth from targets within the grid.
    ///
    /// - `heights`: lowest and highest of the targets; unused in a polar grid (m).
    pub fn new(table: &PolicyTable, depth: usize, heights: [f32; 2]) -> Self {
        let step = |s: &SegmentRecord| Vec2::new(s.displacement[2], s.displacement[3]).length();
        let longest = table.segments().iter().map(step).fold(0.0, f32::max);
        let num_states = table.actions().num_states();
        let side = ((MAX_SQUARES / num_states.max(1)) as f64).sqrt() as usize;
        let reach = 1.01 * (table.grid().radius() + depth as f32 * longest) + 0.1;
        let centre = Vec2::new(table.centre().x, table.centre().z);
        let squares = GroundSquares { side: side.clamp(SIDES.1, SIDES.0), reach };
        let mut bounds = Self { squares, centre, num_states, levels: Vec::new() };
        let mut before = bounds.bounds_of_values(table, heights);
        for _ in 1..depth {
            let level = bounds.bounds_of_actions(table, heights, &bounds.max_of_neighbours(&before));
            bounds.levels.push(level.clone());
            before = level;
        }
        bounds
    }

    /// Upper bound of the worth of `left` actions; infinite if unknown (state exists, left > 0).
    #[inline]
    pub fn upper_bound(&self, left: usize, at: PolicySituation) -> f32 {
        match (self.levels.get(left - 1), self.squares.square_at(Vec2::new(at.target.x, at.target.z) - self.centre)) {
            (Some(level), Some([column, row])) => level[self.index(row, at.state as usize) + column],
            _ => f32::INFINITY,
        }
    }

    /// True if a worth of at most `bound` cannot exceed `floor`, including rounding.
    #[inline]
    pub fn is_hopeless(&self, bound: f32, floor: f32) -> bool {
        bound + (bound.abs() * SLACK.0 + SLACK.1) <= floor
    }

    /// Index of a state's first column in a row of squares.
    fn index(&self, row: usize, state: usize) -> usize {
        (row * self.num_states + state) * self.squares.side
    }

    /// Computes level 0.
    fn bounds_of_values(&self, table: &PolicyTable, heights: [f32; 2]) -> Vec<f32> {
        let s = &self.squares;
        let mut out = vec![0.0; s.side * s.side * self.num_states];
        out.par_chunks_mut(self.num_states * s.side).enumerate().for_each(|(row, out)| {
            for column in 0..s.side {
                let candidates = PeakCandidates::new(table, s.centre(column, row), s.radius(), heights);
                for state in 0..self.num_states {
                    out[state * s.side + column] = candidates.greatest_value(table, state as u32);
                }
            }
        });
        out
    }

    /// Maximum of every square and its eight neighbours, so that one access covers a displaced square.
    fn max_of_neighbours(&self, level: &[f32]) -> Vec<f32> {
        let (side, width) = (self.squares.side, self.num_states * self.squares.side);
        let mut out = vec![0.0; level.len()];
        out.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
            let rows = row.saturating_sub(1)..(row + 2).min(side);
            for state in 0..self.num_states {
                for column in 0..side {
                    let columns = column.saturating_sub(1)..(column + 2).min(side);
                    let of_row = |r: usize| level[self.index(r, state)..][columns.clone()].iter().copied();
                    out[state * side + column] = rows.clone().flat_map(of_row).fold(f32::NEG_INFINITY, f32::max);
                }
            }
        });
        out
    }

    /// Computes the next level.
    ///
    /// - `then`: the previous level, widened.
    fn bounds_of_actions(&self, table: &PolicyTable, heights: [f32; 2], then: &[f32]) -> Vec<f32> {
        let (side, width) = (self.squares.side, self.num_states * self.squares.side);
        let heights = (!table.grid().is_polar()).then_some(heights);
        let mut out = vec![f32::NEG_INFINITY; then.len()];
        out.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
            let mut of_segments = vec![0.0; table.segments().len() * side];
            for (segment, most) in table.segments().iter().zip(of_segments.chunks_exact_mut(side)) {
                self.bounds_of_segment(table.reward(), segment, row, heights, then, most);
            }
            for (state, most) in out.chunks_exact_mut(side).enumerate() {
                let actions = table.actions();
                for (&segment, &error) in actions.segments_of(state as u32).iter().zip(table.errors_of(state as u32)) {
                    let (of_segment, left) =
                        (&of_segments[segment as usize * side..][..side], table.reward().after_transition(error));
                    most.iter_mut().zip(of_segment).for_each(|(m, &s)| *m = m.max(left * s));
                }
            }
        });
        out
    }

    /// Upper bound of the worth of a segment for the squares of a row.
    fn bounds_of_segment(
        &self,
        reward: &Reward,
        segment: &SegmentRecord,
        row: usize,
        heights: Option<[f32; 2]>,
        then: &[f32],
        out: &mut [f32],
    ) {
        for (column, out) in out.iter_mut().enumerate() {
            let centre = self.squares.centre(column, row);
            let [x, z, _] = segment.target_after(Vec3::new(centre.x, 0.0, centre.y));
            let value = match self.squares.square_at(Vec2::new(x, z)) {
                Some([column, row]) => then[self.index(row, segment.end as usize) + column],
                // Targets do not get there within the searched number of actions.
                None => f32::INFINITY,
            };
            *out = most_reward(reward, segment, centre, self.squares.radius(), heights) + segment.discount * value;
        }
    }
}

/// Greatest reward of a segment for any target within a disc.
fn most_reward(reward: &Reward, segment: &SegmentRecord, centre: Vec2, radius: f32, heights: Option<[f32; 2]>) -> f32 {
    let [_, _, end_x, end_z] = segment.displacement;
    let [ax, az, bx, bz] = segment.inner;
    let inner = [Vec3::new(ax, segment.heights[0], az), Vec3::new(bx, segment.heights[1], bz)];
    let samples = [Vec3::ZERO, inner[0], inner[1], Vec3::new(end_x, 0.0, end_z)];
    let r = reward.record();
    let most = |k: usize| {
        let [near, far] = distances(centre, radius, heights, samples[k]);
        let nearest = r.offset.clamp(near, far);
        let farthest = if r.offset - near > far - r.offset { near } else { far };
        segment.weights[k] * reward.kernel(if r.gain > 0.0 { nearest } else { farthest })
    };
    // With heights, the outer samples do not count.
    let counted = if heights.is_some() { 1..3 } else { 0..4 };
    let all = counted.map(most);
    r.gain * if r.combine == COMBINE_SUM { all.sum::<f32>() } else { all.fold(f32::NEG_INFINITY, f32::max) }
}
