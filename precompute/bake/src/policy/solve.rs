//! Value iteration to a residual that proves the distance from the optimal values (Lee and Lee 2004, section 4.2).

use super::costs::own_errors;
use super::{ActionModel, BackupPairs, MAX_PLANE, PolicyBehaviour, PolicyConfig, RowShape, Sweeper, segment_records};
use crate::{share::share_rows, stages::stage_error};
use throng_base::Comm;
use throng_core::policy::{PathRecord, PolicyRecord, PolicySlices, PolicyTable, SegmentRecord, StateGridRecord};
use throng_motion::{Progress, Result};

/// Values of a solved policy, with measurements.
#[derive(Clone, Debug, Default)]
pub struct Solution {
    /// Record, without best actions yet: one choice, the first action everywhere.
    pub record: PolicyRecord,
    /// Segments (num_segments).
    pub segments: Vec<SegmentRecord>,
    /// Paths (num_segments in a space-time grid, else 0).
    pub paths: Vec<PathRecord>,
    /// Distances of actions with their costs (num_actions, or 0 where those of the model count).
    pub errors: Vec<f32>,
    /// State grids (num_states in an adaptive policy, else 0).
    pub state_grids: Vec<StateGridRecord>,
    /// Values (num_states * num_cells, in an adaptive policy the cells of all state grids).
    pub values: Vec<f32>,
    /// (State, cell, action) triples of a full sweep.
    pub num_pairs: u64,
    /// Full sweeps over all actions; the last one measured the residual.
    pub num_sweeps: u32,
    /// Sweeps over the greedy action alone, in between.
    pub num_greedy_sweeps: u32,
    /// Largest change of the last full sweep.
    pub residual: f32,
}

/// Largest change of a full sweep at which values are within `epsilon` of the optimal ones.
///
/// A sweep shrinks distances at least by the discount of the shortest segment, so that |V - V*| <= |TV - V| / (1 -
/// discount^frames). This is stricter than the epsilon (1 - d) / d that suffices for TV.
pub fn tolerance(epsilon: f64, discount: f64, least_frames: u32) -> f64 {
    epsilon * (1.0 - discount.powi(least_frames as i32))
}

/// Solver of behaviours over the actions of a motion graph.
#[derive(Clone, Copy)]
pub struct PolicySolver<'a> {
    /// Actions of all states.
    pub model: &'a ActionModel,
    /// Precision, and limits of the work.
    pub cfg: &'a PolicyConfig,
    /// Progress of the sweeps.
    pub progress: &'a dyn Progress,
    /// Processes that solve together: each backs up a block of the states, and all have all values after every sweep.
    /// The values are those of one process.
    pub comm: &'a dyn Comm,
}

impl PolicySolver<'_> {
    /// Solves for the optimal values of a behaviour.
    ///
    /// Modified policy iteration: a full sweep over all actions finds the greedy policy, sweeps over that policy only bring
    /// its values near convergence, and so on until a full sweep changes nothing by more than [`tolerance`]. All sweeps
    /// read old values and write new ones, so the result does not depend on the number of threads.
    ///
    /// In a space-time grid, values stay 0 here.
    ///
    /// # Errors
    /// [`throng_motion::BuildError::Stage`] if the grid is too large, or with the last residual after `cfg.max_sweeps`;
    /// [`throng_motion::BuildError::Stopped`]; [`throng_base::Error::Rank`].
    ///
    /// # Source
    /// Values as in Lee and Lee (2004), equation 4, with linear interpolation between cells. Differs: full sweeps instead
    /// of random updates.
    pub fn value_iteration(&self, behaviour: &dyn PolicyBehaviour) -> Result<Solution> {
        let Self { model, cfg, comm, .. } = *self;
        check_size(model, behaviour, cfg)?;
        let mut solution = blank_table(model, behaviour, cfg)?;
        if behaviour.spec().grid.is_space_time() {
            // Every action leaves less time: the few true sweeps of the bake suffice.
            return Ok(solution);
        }
        let shape = RowShape::new(&behaviour.spec().grid);
        let best = vec![0; solution.values.len()];
        let own = comm.own_range(model.num_states());
        let pairs =
            BackupPairs::new(&solution.table(model, &best)?, &solution.segments, model.segments_of(own.clone()));
        let errors = if solution.errors.is_empty() { &model.action_errors } else { &solution.errors };
        let mut sweeper = Sweeper::new(pairs, model, behaviour.spec().reward, errors, own);
        let tolerance = tolerance(cfg.epsilon, behaviour.spec().discount, model.least_frames()) as f32;
        let values = self.iterate(&mut sweeper, tolerance, &mut solution)?;
        drop(sweeper);
        if solution.residual > tolerance {
            let (residual, sweeps) = (solution.residual, solution.num_sweeps);
            let message = format!(
                "behaviour \"{}\": a sweep still changes values by {residual:e} after {sweeps} sweeps, wanted {tolerance:e}",
                behaviour.spec().name
            );
            return Err(stage_error("policy", message, "Raise `max_sweeps` or `epsilon`, or lower `discount`."));
        }
        let cells = values.chunks_exact(shape.stride()).flat_map(|ring| &ring[..shape.angles]);
        solution.values.iter_mut().zip(cells).for_each(|(out, &v)| *out = v);
        Ok(solution)
    }

    /// Alternates full sweeps and sweeps over the greedy policy. Returns the values measured by the last full sweep.
    fn iterate(&self, sweeper: &mut Sweeper, tolerance: f32, solution: &mut Solution) -> Result<Vec<f32>> {
        let Self { cfg, progress, comm, .. } = *self;
        let mut values = vec![0.0; sweeper.num_values()];
        let (mut next, row) = (vec![0.0; sweeper.num_own_values()], sweeper.value_row());
        let largest = |change: f32| comm.max(f64::from(change)).map(|most| most as f32);
        progress.begin("policy", 0, "sweeps");
        loop {
            let residual = largest(sweeper.full(&values, &mut next))?;
            solution.num_sweeps += 1;
            solution.residual = residual;
            progress.advance(1);
            if residual <= tolerance || solution.num_sweeps >= cfg.max_sweeps || residual.is_nan() {
                break;
            }
            share_rows(comm, row, &mut next, &mut values)?;
            // Far from convergence the greedy policy will change anyway; near it, the rest must be below the tolerance.
            let enough = (residual * GREEDY_PRECISION).max(tolerance * GREEDY_TOLERANCE);
            for _ in 0..MAX_GREEDY_SWEEPS {
                progress.check()?;
                let change = largest(sweeper.greedy(&values, &mut next))?;
                share_rows(comm, row, &mut next, &mut values)?;
                solution.num_greedy_sweeps += 1;
                if change <= enough {
                    break;
                }
            }
        }
        progress.end();
        Ok(values)
    }
}

/// Refuses grids with too many cells or too much memory.
fn check_size(model: &ActionModel, behaviour: &dyn PolicyBehaviour, cfg: &PolicyConfig) -> Result<()> {
    let (grid, name) = (behaviour.spec().grid, behaviour.spec().name);
    let shape = RowShape::new(&grid);
    if !grid.is_space_time() && shape.value_plane() + LANES_TO_SPARE > MAX_PLANE {
        let message = format!("behaviour \"{name}\" has {} cells at one height", shape.plane());
        return Err(stage_error("policy", message, "Use fewer rings or angles: rings * (angles + 1) up to 65000."));
    }
    let (states, segments) = (model.num_states() as f64, model.segments.len() as f64);
    let (cells, plane) = (grid.num_cells() as f64, grid.num_plane_cells() as f64);
    // Three copies of the values, and best actions; for each segment the geometry of a height and the rewards of all
    // cells.
    let bytes = states * cells * (12.0 + f64::from(cfg.choices)) + segments * (12.0 * plane + 4.0 * cells);
    if bytes > MAX_BYTES || states * cells > f64::from(u32::MAX) {
        let [rings, angles, heights] = [shape.rings, shape.angles, shape.heights];
        let message = format!(
            "behaviour \"{name}\": {rings} rings x {angles} angles x {heights} heights for {states} states would take \
             {:.0} GB to solve",
            bytes / 1e9
        );
        return Err(stage_error(
            "policy",
            message,
            "Use fewer rings, angles or heights in `grid`; up to 12 GB are taken.",
        ));
    }
    Ok(())
}

/// Most memory for solving a policy (bytes).
const MAX_BYTES: f64 = 12e9;

/// Spare lanes that keep the corners of the last cell within 16 bits.
const LANES_TO_SPARE: usize = 2;

/// Share of the full sweep's change at which greedy sweeps stop.
const GREEDY_PRECISION: f32 = 0.02;
/// Share of the tolerance at which greedy sweeps stop.
const GREEDY_TOLERANCE: f32 = 0.3;
/// Most greedy sweeps between two full ones.
const MAX_GREEDY_SWEEPS: u32 = 500;

/// A record with zero values.
fn blank_table(model: &ActionModel, behaviour: &dyn PolicyBehaviour, cfg: &PolicyConfig) -> Result<Solution> {
    cfg.check()?;
    let segments = segment_records(behaviour, &model.segments);
    let grid = behaviour.spec().grid;
    let record = PolicyRecord {
        grid: *grid.record(),
        reward: *behaviour.spec().reward.record(),
        region: behaviour.spec().region,
        centre: behaviour.spec().centre.to_array(),
        num_states: model.num_states() as u32,
        num_segments: segments.len() as u32,
        num_choices: 1,
        discount: behaviour.spec().discount as f32,
        epsilon: cfg.epsilon as f32,
        ..PolicyRecord::default()
    };
    let num_values = model.num_states() * grid.num_cells();
    Ok(Solution {
        record,
        segments,
        paths: behaviour.paths().to_vec(),
        errors: own_errors(model, &behaviour.spec()),
        values: vec![0.0; num_values],
        num_pairs: (model.action_segments.len() * grid.num_cells()) as u64,
        residual: f32::INFINITY,
        ..Solution::default()
    })
}

impl Solution {
    /// The runtime's view of the values, with one best action each.
    ///
    /// # Errors
    /// [`throng_motion::BuildError::Stage`] for an inconsistent model.
    pub fn table(&self, model: &ActionModel, best: &[u8]) -> Result<PolicyTable> {
        let fault = |e: throng_core::Error| {
            stage_error("policy", e.to_string(), "The motion graph is not sound: build it again.")
        };
        let slices = PolicySlices {
            segments: (&self.segments).into(),
            paths: (&self.paths).into(),
            errors: (&self.errors).into(),
            state_grids: (&self.state_grids).into(),
            values: (&self.values).into(),
            best: best.into(),
        };
        PolicyTable::new(&self.record, model.action_table().map_err(fault)?, slices).map_err(fault)
    }
}
