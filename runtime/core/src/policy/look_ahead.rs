//! One-step look-ahead: ranks all actions of a state by reward plus value of the successor (Lee and Lee 2004, section
//! 5).

use super::backup::{SegmentLanes, TargetLanes, back_up};
use super::ranked::RankedActions;
use super::table::{MAX_ACTIONS, PolicyTable};
use glam::Vec3;
use throng_base::error::{check_index, check_length, check_value, ensure};
use throng_base::simd::{LANES, LaneWork, Lanes, dispatch};
use throng_base::{Error, Id, Result};

/// Goal of a look-ahead: one behaviour.
#[derive(Clone, Copy, Debug)]
pub struct LookAheadGoal<'a> {
    /// The behaviour's policy.
    pub policy: &'a PolicyTable,
    /// Weight of the behaviour for each character; 0 where it is inactive (num_characters).
    pub weights: &'a [f32],
    /// Target of each character in its own frame: +Z ahead, +X left, Y the height above ground, or in a space-time grid
    /// the time left (m, s, num_characters).
    pub targets: &'a [Vec3],
}

/// Ranks the actions of every character by the weighted sum of its behaviours.
///
/// Score of an action: sum over goals of weight * (reward + discount^frames * value of the successor). That is the
/// right-hand side of Lee and Lee (2004), equation 4, at the target's exact position, with values interpolated between
/// cells. Where transitions cost something ([`super::RewardRecord::transition_cost`]), the goal's part is less by it.
///
/// Allocates nothing; split by range to run on several threads.
///
/// ```no_run
/// use throng_core::policy::{LookAheadGoal, LookAheadJob, RankedActions};
/// use throng_core::{Bundle, glam::Vec3};
///
/// let bundle = Bundle::open("people.throng")?;
/// let goals = [LookAheadGoal { policy: &bundle.policies()[0], weights: &[1.0], targets: &[Vec3::Z] }];
/// let mut ranked = [RankedActions::NONE];
/// LookAheadJob { goals: &goals, states: &[0], ranked: &mut ranked }.run()?;
/// println!("action {}", ranked[0].best());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LookAheadJob<'a> {
    /// The behaviours; all policies belong to the same motion graph (at least 1).
    pub goals: &'a [LookAheadGoal<'a>],
    /// State of each character (< num_states).
    pub states: &'a [u32],
    /// Output (num_characters).
    pub ranked: &'a mut [RankedActions],
}

impl LookAheadJob<'_> {
    /// Checks the inputs.
    ///
    /// # Errors
    /// [`Error`] where slices differ in length, a state does not exist, a target is not finite or policies
    /// are of different motion graphs.
    pub fn validate(&self) -> Result<()> {
        let n = self.states.len();
        check_length("ranked", self.ranked.len(), n)?;
        for (goal, g) in self.goals.iter().enumerate() {
            check_length("weights", g.weights.len(), n)?;
            check_length("targets", g.targets.len(), n)?;
            check_targets(g.targets)?;
            check_weights(g.weights)?;
            let expected = || format!("policies of one motion graph; that of goal {goal} is another");
            let error = || Error::Length { what: "goals", got: self.goals.len(), expected: expected() };
            // Quick where both are views of one table.
            ensure(g.policy.actions() == self.goals[0].policy.actions(), error)?;
        }
        check_states(self.states, self.goals.first().map_or(0, |g| g.policy.actions().num_states()))
    }

    /// Checks the inputs and ranks the actions.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn run(self) -> Result<()> {
        self.validate()?;
        dispatch(self);
        Ok(())
    }
}

impl LaneWork for LookAheadJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let mut scores = [[0.0; LANES]; MAX_GROUPS];
        for (i, (ranked, &state)) in self.ranked.iter_mut().zip(self.states).enumerate() {
            let mut num_actions = 0;
            for (g, goal) in self.goals.iter().enumerate() {
                num_actions = goal.policy.actions().segments_of(state).len();
                let weight = goal.weights[i];
                if g == 0 {
                    scores[..num_actions.div_ceil(LANES)].fill([0.0; LANES]);
                }
                if weight != 0.0 {
                    let target = goal.policy.grid.clamp(goal.policy.to_grid(goal.targets[i]));
                    goal.policy.add_scores::<F>(state, target, weight, &mut scores);
                }
            }
            *ranked = RankedActions::of_scores::<F>(&mut scores, num_actions);
        }
    }
}

/// Groups of eight actions a state may have.
pub(super) const MAX_GROUPS: usize = MAX_ACTIONS.div_ceil(LANES);

/// Values of one query, shared by all its actions.
#[derive(Clone, Copy)]
struct LookAheadQuery {
    /// The target in grid coordinates; a look-ahead has clamped it to the grid.
    target: Vec3,
    /// Kernel of the distance at the start.
    start_kernel: f32,
    /// First cell of the lower and of the upper height.
    height_offsets: [usize; 2],
    /// Ratio between the heights.
    height_ratio: f32,
    /// Height coordinate in the grid, with fraction.
    height_number: f32,
}

impl PolicyTable {
    /// Adds `weight` times the score of each action of a state to `scores`.
    ///
    /// - `target`: relative to the grid's centre.
    #[inline(always)]
    fn add_scores<F: Lanes>(&self, state: u32, target: Vec3, weight: f32, scores: &mut [[f32; LANES]]) {
        let (segments, errors) = (self.actions.segments_of(state), self.errors_of(state));
        if self.grid.is_space_time() {
            let scores = scores.as_flattened_mut();
            for (score, (&segment, &error)) in scores.iter_mut().zip(segments.iter().zip(errors)) {
                let left = self.reward.after_transition(error);
                *score += weight * left * self.score_in_space_time(segment, target);
            }
            return;
        }
        let query = self.query(target);
        match (self.grid.is_polar(), self.is_adaptive()) {
            (true, false) => self.add_scores_of::<F, true, false>(segments, errors, &query, weight, scores),
            (false, false) => self.add_scores_of::<F, false, false>(segments, errors, &query, weight, scores),
            (true, true) => self.add_scores_of::<F, true, true>(segments, errors, &query, weight, scores),
            (false, true) => self.add_scores_of::<F, false, true>(segments, errors, &query, weight, scores),
        }
    }

    #[inline(always)]
    fn add_scores_of<F: Lanes, const POLAR: bool, const ADAPTIVE: bool>(
        &self,
        segments: &[u32],
        errors: &[f32],
        query: &LookAheadQuery,
        weight: f32,
        scores: &mut [[f32; LANES]],
    ) {
        let Vec3 { x, y, z } = query.target;
        let start_kernel = F::splat(query.start_kernel);
        let targets = TargetLanes { x: F::splat(x), y: F::splat(y), z: F::splat(z), start_kernel };
        let (whole, rest) = segments.as_chunks::<LANES>();
        let (whole_errors, rest_errors) = errors.as_chunks::<LANES>();
        for ((segments, errors), scores) in whole.iter().zip(whole_errors).zip(&mut *scores) {
            self.add_group::<F, POLAR, ADAPTIVE>(segments, errors, query, &targets, weight, scores);
        }
        if let (Some(&last), Some(scores)) = (rest.last(), scores.get_mut(whole.len())) {
            let (mut segments, mut errors) = ([last; LANES], [0.0; LANES]);
            segments[..rest.len()].copy_from_slice(rest);
            errors[..rest.len()].copy_from_slice(rest_errors);
            self.add_group::<F, POLAR, ADAPTIVE>(&segments, &errors, query, &targets, weight, scores);
        }
    }

    /// [`Self::add_scores_of`] for eight actions.
    #[inline(always)]
    fn add_group<F: Lanes, const POLAR: bool, const ADAPTIVE: bool>(
        &self,
        segments: &[u32; LANES],
        errors: &[f32; LANES],
        query: &LookAheadQuery,
        targets: &TargetLanes<F>,
        weight: f32,
        scores: &mut [f32; LANES],
    ) {
        let records = &segments.map(|s| &self.rows.segments[s as usize]);
        let (reward, spot) = back_up::<F, POLAR>(&self.grid, &self.reward, records, targets, self.bends);
        let [_, _, discount, end] = SegmentLanes::<F>::quarter(records, 3);
        let value = if ADAPTIVE {
            self.adaptive_values::<F, POLAR>(records, &spot, query.height_number)
        } else {
            let place = self.grid.place::<F, POLAR>(&spot);
            let low = self.values_at(end, &place, query.height_offsets[0]);
            if !POLAR && query.height_ratio > 0.0 {
                let high = self.values_at(end, &place, query.height_offsets[1]);
                low + (high - low) * F::splat(query.height_ratio)
            } else {
                low
            }
        };
        let mut score = reward + discount * value;
        if self.reward.record().transition_cost > 0.0 {
            score = score * self.reward.after_transitions(F::load(errors));
        }
        (F::load(scores) + F::splat(weight) * score).store(scores);
    }

    /// The part of a score that does not depend on the action.
    #[inline(always)]
    fn query(&self, target: Vec3) -> LookAheadQuery {
        let (height, height_ratio) = self.grid.height_interval(target.y);
        let plane = self.grid.num_plane_cells();
        let low = height as usize * plane;
        let high = if height_ratio > 0.0 { low + plane } else { low };
        let start_kernel = self.reward.kernel((target.x * target.x + target.z * target.z).sqrt());
        let height_number = height as f32 + height_ratio;
        LookAheadQuery { target, start_kernel, height_offsets: [low, high], height_ratio, height_number }
    }

    /// Scores of all actions of a state for one target, in order: what [`LookAheadJob`] ranks.
    ///
    /// - `scores`: (at least the state's number of actions)
    /// - returns the number of actions.
    ///
    /// # Errors
    /// [`Error`] where the state does not exist, the target is not finite or `scores` is too short.
    pub fn action_scores(&self, state: u32, target: Vec3, scores: &mut [f32]) -> Result<usize> {
        check_targets(&[target])?;
        self.scores_at(state, self.grid.clamp(self.to_grid(target)), scores)
    }

    /// Scores all actions as [`Self::action_scores`] does, without clamping a target beyond the grid: rewards are
    /// exact, and values fall with the distance from the grid.
    ///
    /// - `target`: the time left in a space-time grid is not negative.
    ///
    /// # Errors
    /// As [`Self::action_scores`].
    pub fn exact_scores(&self, state: u32, target: Vec3, scores: &mut [f32]) -> Result<usize> {
        check_targets(&[target])?;
        self.scores_at(state, self.to_grid(target), scores)
    }

    fn scores_at(&self, state: u32, target: Vec3, scores: &mut [f32]) -> Result<usize> {
        check_states(&[state], self.actions.num_states())?;
        let (num_actions, got) = (self.actions.segments_of(state).len(), scores.len());
        let expected = || format!("{num_actions} or more, one for each action");
        ensure(got >= num_actions, || Error::Length { what: "scores", got, expected: expected() })?;
        let mut groups = [[0.0; LANES]; MAX_GROUPS];
        dispatch(ActionScoresJob { table: self, state, target, scores: &mut groups });
        scores[..num_actions].copy_from_slice(&groups.as_flattened()[..num_actions]);
        Ok(num_actions)
    }
}

/// Scores of all actions of a state.
struct ActionScoresJob<'a> {
    table: &'a PolicyTable,
    state: u32,
    target: Vec3,
    scores: &'a mut [[f32; LANES]],
}

impl LaneWork for ActionScoresJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        self.table.add_scores::<F>(self.state, self.target, 1.0, self.scores);
    }
}

pub(super) fn check_states(states: &[u32], num_states: usize) -> Result<()> {
    let mut states = states.iter().enumerate();
    states.try_for_each(|(c, &state)| check_index("state", Some(Id::first(c)), state as usize, num_states))
}

fn check_weights(weights: &[f32]) -> Result<()> {
    let mut weights = weights.iter().enumerate();
    weights.try_for_each(|(c, w)| check_value("weight", Some(Id::first(c)), *w, w.abs() <= 1e6, "between -1e6 and 1e6"))
}

pub(super) fn check_targets(targets: &[Vec3]) -> Result<()> {
    let is_place = |t: &Vec3| t.abs().max_element() < 1e15 && !t.is_nan();
    let Some(character) = targets.iter().position(|t| !is_place(t)) else { return Ok(()) };
    let coordinates = ["target x", "target y", "target z"].into_iter().zip(targets[character].to_array());
    coordinates.into_iter().try_for_each(|(what, v)| {
        check_value(what, Some(Id::first(character)), v, v.abs() < 1e15, "finite and below 1e15 m")
    })
}
