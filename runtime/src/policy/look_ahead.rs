//! One-step look-ahead: all actions of a state by their reward and the value of where they lead (003 section 5).

use super::error::PolicyJobError;
use super::ranked::RankedActions;
use super::table::{MAX_ACTIONS, PolicyTable, SegmentRecord};
use crate::simd::vectorize;
use glam::{Mat4, Vec3, Vec4};

/// Actions weighed side by side.
const LANES: usize = 16;

/// One behaviour of a look-ahead.
#[derive(Clone, Copy, Debug)]
pub struct Goal<'a> {
    /// The behaviour's policy.
    pub policy: PolicyTable<'a>,
    /// Weight of the behaviour for each character; 0 where it is not active. [Size: num_characters]
    pub weights: &'a [f32],
    /// Target of each character in its own frame: +Z ahead, +X left, Y the height above ground. [Unit: m]
    /// [Size: num_characters]
    pub targets: &'a [Vec3],
}

/// Ranks the actions of every character by the weighted sum of its behaviours.
///
/// Score of an action: sum over goals of weight * (reward + discount^frames * value where it leads), the right-hand
/// side of 003 eq. 4 for the target's exact place, with values interpolated between cells.
///
/// Allocates nothing; split by range to run on several threads.
#[derive(Debug)]
pub struct LookAheadJob<'a> {
    /// The behaviours; all policies are for the same motion graph. [Limit: at least 1]
    pub goals: &'a [Goal<'a>],
    /// State of each character. [Limit: < num_states]
    pub states: &'a [u32],
    /// Output. [Size: num_characters]
    pub ranked: &'a mut [RankedActions],
}

impl LookAheadJob<'_> {
    /// # Errors
    /// [`PolicyJobError`] where slices differ in length, a state does not exist, a target is not finite or policies
    /// are of different motion graphs.
    pub fn validate(&self) -> Result<(), PolicyJobError> {
        let n = self.states.len();
        check_lengths(&[("ranked", self.ranked.len())], n)?;
        for (goal, g) in self.goals.iter().enumerate() {
            check_lengths(&[("weights", g.weights.len()), ("targets", g.targets.len())], n)?;
            check_targets(g.targets)?;
            check_weights(goal, g.weights)?;
            let first = &self.goals[0].policy;
            if !g.policy.actions().is_same(&first.actions()) {
                return Err(PolicyJobError::Graph { goal });
            }
        }
        check_states(self.states, self.goals.first().map_or(0, |g| g.policy.actions().num_states()))
    }

    /// # Errors
    /// As [`Self::validate`].
    pub fn run(self) -> Result<(), PolicyJobError> {
        self.validate()?;
        vectorize(
            #[inline(always)]
            || self.rank(),
        );
        Ok(())
    }

    #[inline(always)]
    fn rank(self) {
        let mut scores = [0.0; MAX_ACTIONS + LANES];
        for (i, (ranked, &state)) in self.ranked.iter_mut().zip(self.states).enumerate() {
            let mut num_actions = 0;
            for (g, goal) in self.goals.iter().enumerate() {
                let segments = goal.policy.actions().segments_of(state);
                num_actions = segments.len();
                let weight = goal.weights[i];
                if g == 0 {
                    scores[..num_actions].fill(0.0);
                }
                if weight != 0.0 {
                    goal.policy.add_scores(segments, goal.targets[i], weight, &mut scores);
                }
            }
            *ranked = RankedActions::NONE;
            for (a, &score) in scores[..num_actions].iter().enumerate() {
                ranked.insert(a as u8, score);
            }
        }
    }
}

/// A target as seen by all actions of a query.
#[derive(Clone, Copy)]
struct Query {
    /// The target, moved into the grid.
    target: Vec3,
    /// Kernel of the distance at the start, which all actions share.
    start_kernel: f32,
    /// First cell of the lower and of the upper height.
    height_offsets: [usize; 2],
    /// Ratio between the heights.
    height_ratio: f32,
}

impl Query {
    /// Value of a cell of the plane, interpolated between the heights.
    #[inline(always)]
    fn at_height<const POLAR: bool>(&self, values: &[f32], cell: usize) -> f32 {
        if POLAR {
            return values[cell];
        }
        let [low, high] = self.height_offsets.map(|offset| values[offset + cell]);
        low + (high - low) * self.height_ratio
    }
}

/// A lane of segments, field by field: four by four in the order of [`SegmentRecord`].
struct SegmentLanes([[[f32; LANES]; 4]; 4]);

impl SegmentLanes {
    #[inline(always)]
    fn new(records: &[&SegmentRecord; LANES]) -> Self {
        Self([transpose(records, 0), transpose(records, 1), transpose(records, 2), transpose(records, 3)])
    }

    /// One of them.
    #[inline(always)]
    fn lane(&self, l: usize) -> SegmentRecord {
        let of = |k: usize| [self.0[k][0][l], self.0[k][1][l], self.0[k][2][l], self.0[k][3][l]];
        let [height, next_height, discount, end] = of(3);
        let heights = [height, next_height];
        SegmentRecord { displacement: of(0), inner: of(1), weights: of(2), heights, discount, end: end.to_bits() }
    }
}

/// The `k`-th four fields of a lane of segments.
#[inline(always)]
fn transpose(records: &[&SegmentRecord; LANES], k: usize) -> [[f32; LANES]; 4] {
    let column = |l: usize| Vec4::from_array(bytemuck::cast_ref::<SegmentRecord, [[f32; 4]; 4]>(records[l])[k]);
    let mut out = [[0.0; LANES]; 4];
    for first in (0..LANES).step_by(4) {
        let m = Mat4::from_cols(column(first), column(first + 1), column(first + 2), column(first + 3)).transpose();
        out[0][first..first + 4].copy_from_slice(&m.x_axis.to_array());
        out[1][first..first + 4].copy_from_slice(&m.y_axis.to_array());
        out[2][first..first + 4].copy_from_slice(&m.z_axis.to_array());
        out[3][first..first + 4].copy_from_slice(&m.w_axis.to_array());
    }
    out
}

impl PolicyTable<'_> {
    /// Adds `weight` times the score of each action to `scores`.
    ///
    /// - `segments`: of the actions; `scores` has room for whole lanes.
    #[inline(always)]
    fn add_scores(&self, segments: &[u32], target: Vec3, weight: f32, scores: &mut [f32]) {
        let query = self.query(target);
        for (segments, scores) in segments.chunks(LANES).zip(scores.as_chunks_mut::<LANES>().0) {
            let last = segments.len() - 1;
            let records = std::array::from_fn(|l| &self.segments[segments[l.min(last)] as usize]);
            let q = if self.grid.is_polar() {
                self.score_lanes::<true>(&query, records)
            } else {
                self.score_lanes::<false>(&query, records)
            };
            for l in 0..LANES {
                scores[l] += weight * q[l];
            }
        }
    }

    /// What does not depend on the action.
    #[inline(always)]
    fn query(&self, target: Vec3) -> Query {
        let target = self.grid.clamp(target);
        let (height, height_ratio) = self.grid.height_interval(target.y);
        let plane = self.grid.num_plane_cells();
        let low = height as usize * plane;
        let high = if height_ratio > 0.0 { low + plane } else { low };
        let start_kernel = self.reward.kernel((target.x * target.x + target.z * target.z).sqrt());
        Query { target, start_kernel, height_offsets: [low, high], height_ratio }
    }

    /// Scores of a lane of actions: reward + discount^frames * value.
    ///
    /// Plain loops over a lane's arrays, one step each, which the compiler turns into vector instructions.
    #[inline(always)]
    fn score_lanes<const POLAR: bool>(&self, query: &Query, records: [&SegmentRecord; LANES]) -> [f32; LANES] {
        let segments = SegmentLanes::new(&records);
        let (grid, reward) = (self.grid, self.reward);
        let mut rewards = [0.0; LANES];
        let (mut low, mut angle, mut next_angle) = ([0; LANES], [0; LANES], [0; LANES]);
        let (mut ring_ratio, mut angle_ratio, mut scale) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let segment = segments.lane(l);
            let [x, z, distance] = segment.target_after(query.target);
            let s = grid.stencil_at::<POLAR>(x, z, distance);
            (low[l], angle[l], next_angle[l]) = (s.ring * grid.record().num_angles, s.angle, s.next_angle);
            (ring_ratio[l], angle_ratio[l], scale[l]) = (s.ring_ratio, s.angle_ratio, s.scale * segment.discount);
            rewards[l] = reward.of_segment::<POLAR>(&segment, query.target, query.start_kernel, distance);
        }
        let num_angles = grid.record().num_angles as usize;
        let corners = |l: usize| {
            let values = self.values_of(records[l].end);
            let (a, b) = ((low[l] + angle[l]) as usize, (low[l] + next_angle[l]) as usize);
            let at = |cell: usize| query.at_height::<POLAR>(values, cell);
            Vec4::new(at(a), at(b), at(a + num_angles), at(b + num_angles))
        };
        for (first, reward) in (0..LANES).step_by(4).zip(rewards.as_chunks_mut::<4>().0) {
            let lanes = Mat4::from_cols(corners(first), corners(first + 1), corners(first + 2), corners(first + 3));
            let c = lanes.transpose();
            let [t, u, scale] = [&angle_ratio, &ring_ratio, &scale].map(|x| Vec4::from_slice(&x[first..]));
            let near = c.x_axis + (c.y_axis - c.x_axis) * t;
            let far = c.z_axis + (c.w_axis - c.z_axis) * t;
            *reward = (Vec4::from_array(*reward) + scale * (near + (far - near) * u)).to_array();
        }
        rewards
    }

    /// Scores of all actions of a state for one target, in order: what [`LookAheadJob`] ranks.
    ///
    /// - `scores`: [Size: at least the state's number of actions]
    /// - returns the number of actions.
    ///
    /// # Errors
    /// [`PolicyJobError`] where the state does not exist, the target is not finite or `scores` is too short.
    pub fn action_scores(&self, state: u32, target: Vec3, scores: &mut [f32]) -> Result<usize, PolicyJobError> {
        check_states(&[state], self.actions.num_states())?;
        check_targets(&[target])?;
        let segments = self.actions.segments_of(state);
        if scores.len() < segments.len() {
            let (got, expected) = (scores.len(), segments.len());
            return Err(PolicyJobError::Length { what: "scores", got, expected });
        }
        let mut padded = [0.0; MAX_ACTIONS + LANES];
        self.add_scores(segments, target, 1.0, &mut padded);
        scores[..segments.len()].copy_from_slice(&padded[..segments.len()]);
        Ok(segments.len())
    }
}

pub(super) fn check_lengths(slices: &[(&'static str, usize)], expected: usize) -> Result<(), PolicyJobError> {
    match slices.iter().find(|s| s.1 != expected) {
        Some(&(what, got)) => Err(PolicyJobError::Length { what, got, expected }),
        None => Ok(()),
    }
}

pub(super) fn check_states(states: &[u32], num_states: usize) -> Result<(), PolicyJobError> {
    match states.iter().enumerate().find(|&(_, &s)| s as usize >= num_states) {
        Some((character, &state)) => Err(PolicyJobError::State { character, state, num_states }),
        None => Ok(()),
    }
}

fn check_weights(goal: usize, weights: &[f32]) -> Result<(), PolicyJobError> {
    match weights.iter().position(|w| w.is_nan() || w.abs() > 1e6) {
        Some(character) => Err(PolicyJobError::Weight { goal, character }),
        None => Ok(()),
    }
}

pub(super) fn check_targets(targets: &[Vec3]) -> Result<(), PolicyJobError> {
    let is_place = |t: &Vec3| t.abs().max_element() < 1e15 && !t.is_nan();
    match targets.iter().position(|t| !is_place(t)) {
        Some(character) => Err(PolicyJobError::Target { character }),
        None => Ok(()),
    }
}
