//! Policy stage: all behaviours solved, baked and compared.

use super::adapt::{AdaptiveReport, adapt};
use super::bake::{bake, best_actions};
use super::behaviour::{Approach, BehaviourSpec, Evade, PolicyBehaviour, ThrowPunches, segment_hits};
use super::compare::{Comparison, compare};
use super::promise::{Promise, promise};
use super::{ActionModel, BehaviourKind, PolicyBehaviourConfig, PolicyConfig, PolicySolver, Solution};
use crate::graph::RawMotionGraph;
use glam::Vec2;
use rand_pcg::Pcg64;
use std::io::{self, Write};
use std::time::Instant;
use throng_base::{Comm, maths::quantile};
use throng_core::policy::{
    ActionTable, PathRecord, PolicyRecord, PolicySlices, PolicyTable, SegmentRecord, StateGridRecord,
};
use throng_motion::{BuildError, ClipSet, Progress, Result};

/// All policies of a build, ready to be written.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct PolicyTables {
    /// Actions of state s are `action_offsets[s]..action_offsets[s + 1]` (num_states + 1).
    pub action_offsets: Vec<u32>,
    /// Segment of each action.
    pub action_segments: Vec<u32>,
    /// Distance of each action's transition, 0 if the clip continues (rad).
    pub action_errors: Vec<f32>,
    /// Policies, in the order of the config.
    pub policies: Vec<RawPolicy>,
}

/// One policy, the owned form of [`PolicyTable`].
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct RawPolicy {
    /// Name of its behaviour.
    pub name: String,
    /// Grid, reward and sizes.
    #[serde(with = "throng_motion::pod::one")]
    pub record: PolicyRecord,
    /// Segments (num_segments).
    #[serde(with = "throng_motion::pod")]
    pub segments: Vec<SegmentRecord>,
    /// Paths (num_segments in a space-time grid, else 0).
    #[serde(with = "throng_motion::pod")]
    pub paths: Vec<PathRecord>,
    /// Distances of actions with their costs (num_actions, or 0 where those of the graph count).
    pub errors: Vec<f32>,
    /// State grids (num_states in an adaptive policy, else 0).
    #[serde(with = "throng_motion::pod")]
    pub state_grids: Vec<StateGridRecord>,
    /// Values (num_states * num_cells, in an adaptive policy the cells of all state grids).
    pub values: Vec<f32>,
    /// Best actions (values.len() * num_choices).
    pub best: Vec<u8>,
    /// Report; not part of the bundle.
    pub report: PolicyReport,
}

/// Report of the cost and the quality of a policy.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct PolicyReport {
    /// Name of its behaviour.
    pub name: String,
    /// Cells of the grid; in an adaptive policy those of the finest one.
    pub cells: usize,
    /// (State, cell, action) triples.
    pub pairs: u64,
    /// Full sweeps, the last of which measured the residual.
    pub sweeps: u32,
    /// Sweeps over the greedy action alone.
    pub greedy_sweeps: u32,
    /// Largest change of a value in the last full sweep, made with the runtime's look-ahead over the stored values; in
    /// an adaptive policy over those on the finest grid, from which the stored ones were fitted.
    pub residual: f32,
    /// Proven bound of the distance of values from the optimal ones: residual / (1 - discount of the shortest segment).
    /// In an adaptive policy the error of its grids, in `adaptive`, comes on top.
    pub error_bound: f64,
    /// Bytes of values, best actions, segments, paths, errors and state grids.
    pub bytes: usize,
    /// Bytes of the values only, as stored by Lee and Lee (2004).
    pub value_bytes: usize,
    /// Time from behaviour to tables (s).
    pub seconds: f64,
    /// Single-load answers compared with look-aheads.
    pub comparison: Comparison,
    /// Comparison of the values with what a greedy character collects.
    pub promise: Promise,
    /// Loss of an adaptive policy, compared with uniform grids of equal size.
    pub adaptive: Option<AdaptiveReport>,
}

impl PolicyTables {
    /// The runtime's view of a policy (index < policies.len()).
    ///
    /// # Errors
    /// [`throng_core::Error`] for tables that were changed to be inconsistent; never for the output of [`solve`].
    pub fn table(&self, index: usize) -> throng_core::Result<PolicyTable> {
        let p = &self.policies[index];
        let (offsets, segments) = (&self.action_offsets, &self.action_segments);
        let actions = ActionTable::new(offsets, segments, &self.action_errors, p.segments.len())?;
        let slices = PolicySlices {
            segments: (&p.segments).into(),
            paths: (&p.paths).into(),
            errors: (&p.errors).into(),
            state_grids: (&p.state_grids).into(),
            values: (&p.values).into(),
            best: (&p.best).into(),
        };
        PolicyTable::new(&p.record, actions, slices)
    }
}

/// Solves the configured behaviours over the motion graph.
///
/// - `comm`: processes that solve together; each backs up a block of the states.
/// - `rng`: for the comparison in the reports; tables do not depend on it.
///
/// # Errors
/// [`BuildError::Key`] for keys out of range or repeated names, [`BuildError::Stage`] if a state has more than 255
/// actions or value iteration does not converge.
pub fn solve(
    clips: &ClipSet,
    graph: &RawMotionGraph,
    behaviours: &[PolicyBehaviourConfig],
    cfg: &PolicyConfig,
    rng: &mut Pcg64,
    progress: &dyn Progress,
    comm: &dyn Comm,
) -> Result<PolicyTables> {
    let model = ActionModel::new(clips, graph)?;
    let hits = segment_hits(clips, graph);
    let rate_hz = clips.clips.first().map_or(30.0, |c| c.rate_hz);
    // The only list of kinds.
    let make = |b: &PolicyBehaviourConfig| -> Result<Box<dyn PolicyBehaviour>> {
        Ok(match b.kind {
            BehaviourKind::Approach => Box::new(Approach::new(b, rate_hz, hit_centre(clips))?),
            BehaviourKind::ThrowPunches => Box::new(ThrowPunches::new(b, rate_hz, &hits)?),
            BehaviourKind::Evade => Box::new(Evade::new(b, clips, graph, comm)?),
        })
    };
    let one = |(i, b)| make(b).map_err(|e| e.within_key(&format!("behaviours[{i}]")));
    let made: Vec<Box<dyn PolicyBehaviour>> = behaviours.iter().enumerate().map(one).collect::<Result<_>>()?;
    let made: Vec<&dyn PolicyBehaviour> = made.iter().map(|b| &**b).collect();
    PolicySolver { model: &model, cfg, progress, comm }.solve_all(&made, rng)
}

/// Centre of hits over ground, in the character's frame: their median distance, in the middle of their directions. The
/// centroid of mirrored hits would be nearer than any of them: x, z (m).
fn hit_centre(clips: &ClipSet) -> Option<Vec2> {
    let places: Vec<Vec2> =
        clips.clips.iter().flat_map(|c| &c.hits).map(|h| Vec2::new(h.position.x, h.position.z)).collect();
    let direction: Vec2 = places.iter().map(|p| p.normalize_or_zero()).sum();
    Some(direction.try_normalize().unwrap_or(Vec2::Y) * quantile(places.iter().map(|p| p.length()), [1, 2])?)
}

impl PolicySolver<'_> {
    /// Solves any behaviours.
    ///
    /// - `rng`: as for [`solve`].
    ///
    /// # Errors
    /// As [`solve`].
    pub fn solve_all(&self, behaviours: &[&dyn PolicyBehaviour], rng: &mut Pcg64) -> Result<PolicyTables> {
        let mut policies: Vec<RawPolicy> = Vec::new();
        for (i, &behaviour) in behaviours.iter().enumerate() {
            let key = format!("behaviours[{i}]");
            if policies.iter().any(|p| p.name == behaviour.spec().name) {
                let why = format!("\"{}\" is there twice; give each its own name", behaviour.spec().name);
                return Err(BuildError::key("name", why).within_key(&key));
            }
            policies.push(self.solve_one(behaviour, rng).map_err(|e| e.within_key(&key))?);
        }
        let ActionModel { action_offsets, action_segments, action_errors, .. } = self.model.clone();
        Ok(PolicyTables { action_offsets, action_segments, action_errors, policies })
    }

    fn solve_one(&self, behaviour: &dyn PolicyBehaviour, rng: &mut Pcg64) -> Result<RawPolicy> {
        let Self { model, cfg, comm, .. } = *self;
        let begin = Instant::now();
        let mut solution = self.value_iteration(behaviour)?;
        let mut best = bake(model, &mut solution, cfg, comm)?;
        behaviour.check_values(&solution.values)?;
        let mut adaptive = None;
        if let Some(config) = behaviour.spec().adaptive {
            let finest = solution;
            solution = adapt(model, &finest, behaviour, &config)?;
            best = best_actions(model, &mut solution, cfg.choices)?;
            adaptive = Some(AdaptiveReport::new(self, behaviour, &finest, &solution, rng)?);
        }
        let seconds = begin.elapsed().as_secs_f64();
        let table = solution.table(model, &best)?;
        let comparison = compare(&table, cfg.compare_samples, rng);
        let BehaviourSpec { name, grid, discount, .. } = behaviour.spec();
        let Solution { record, segments, paths, errors, state_grids, values, residual, .. } = solution;
        let value_bytes = size_of_val(&*values);
        let [own, grids] = [size_of_val(&*errors), size_of_val(&*state_grids)];
        let record_bytes = size_of_val(&*segments) + size_of_val(&*paths) + own + grids;
        let report = PolicyReport {
            name: name.to_owned(),
            cells: grid.num_cells(),
            pairs: solution.num_pairs,
            sweeps: solution.num_sweeps,
            greedy_sweeps: solution.num_greedy_sweeps,
            residual,
            error_bound: f64::from(residual) / (1.0 - discount.powi(model.least_frames() as i32)),
            value_bytes,
            bytes: value_bytes + best.len() + record_bytes,
            seconds,
            comparison,
            promise: promise(&table, name),
            adaptive,
        };
        Ok(RawPolicy { name: name.into(), record, segments, paths, errors, state_grids, values, best, report })
    }
}

/// Writes one row per state and cell: the cell's centre, the value, the best action.
///
/// Header `state,cell,angle_rad,distance_m,height_m,x_m,z_m,value,best_action`; x is to the left, z ahead; the action
/// is an index within the state's actions. In an adaptive policy cells are those of the state's own grid.
///
/// # Errors
/// Errors of `out`.
pub fn write_csv(policy: &PolicyTable, mut out: impl Write) -> io::Result<()> {
    writeln!(out, "state,cell,angle_rad,distance_m,height_m,x_m,z_m,value,best_action")?;
    for state in 0..policy.actions().num_states() as u32 {
        let grid = policy.grid_of(state);
        for (cell, value) in policy.values_of(state).iter().enumerate() {
            let (c, p) = (grid.cell_coordinates(cell), grid.cell_centre(cell) + policy.centre());
            let best = policy.best_of(state, cell)[0];
            writeln!(out, "{state},{cell},{},{},{},{},{},{value},{best}", c.x, c.y, c.z, p.x, p.z)?;
        }
    }
    Ok(())
}
