//! Best actions of every (state, cell), found with the runtime's own look-ahead, which also verifies the values.

use super::{ActionModel, PolicyConfig, Solution, tolerance};
use crate::{share::share_rows, stages::stage_error};
use rayon::prelude::*;
use throng_base::Comm;
use throng_core::policy::{LookAheadGoal, LookAheadJob, PolicyTable, RankedActions};
use throng_motion::error::Result;

/// Best actions of a policy, best first (num_states * num_cells * num_choices).
///
/// Every (state, cell) queries the runtime's look-ahead with the target at the cell's centre, so that the single-load
/// answer there equals the look-ahead's. The pass is also one true sweep: the largest difference between a best score
/// and the stored value is the residual kept in `solution.record`. If the solver's arithmetic leaves it above the
/// tolerance, the scores become the values and the pass is repeated.
///
/// - `comm`: processes that bake together; each ranks a block of the states.
///
/// # Errors
/// [`throng_motion::error::BuildError::Key`] for a setting out of its range;
/// [`throng_motion::error::BuildError::Stage`] with the residual if `cfg.max_sweeps` do
/// not suffice; [`throng_base::Error::Rank`].
pub fn bake(model: &ActionModel, solution: &mut Solution, cfg: &PolicyConfig, comm: &dyn Comm) -> Result<Vec<u8>> {
    cfg.check()?;
    let wanted = tolerance(cfg.epsilon, f64::from(solution.record.discount), model.least_frames()) as f32;
    let first_actions = vec![0; solution.values.len()];
    loop {
        let (scores, actions) = rank_all(&solution.table(model, &first_actions)?, cfg.choices, comm)?;
        let changes = scores.iter().zip(&solution.values).map(|(score, v)| (score - v).abs());
        let residual = changes.fold(0.0, f32::max);
        (solution.residual, solution.record.residual) = (residual, residual);
        solution.num_sweeps += 1;
        if residual <= wanted {
            solution.record.num_sweeps = solution.num_sweeps;
            solution.record.num_choices = cfg.choices;
            return Ok(actions);
        }
        if solution.num_sweeps >= cfg.max_sweeps {
            let message = format!("a sweep still changes values by {residual:e}, wanted {wanted:e}");
            return Err(stage_error("policy", message, "Raise `max_sweeps` or `epsilon`, or lower `discount`."));
        }
        solution.values = scores;
    }
}

/// Best actions at the centres of an adaptive policy's cells, best first (values.len() * num_choices).
///
/// # Errors
/// [`throng_motion::error::BuildError::Stage`] where the solution does not fit the model.
pub(super) fn best_actions(model: &ActionModel, solution: &mut Solution, num_choices: u32) -> Result<Vec<u8>> {
    solution.record.num_choices = 1;
    let table = solution.table(model, &vec![0; solution.values.len()])?;
    let of_state = |state: usize| best_actions_of(&rank_state(&table, state as u32), num_choices).collect::<Vec<u8>>();
    let actions: Vec<Vec<u8>> = (0..model.num_states()).into_par_iter().map(of_state).collect();
    solution.record.num_choices = num_choices;
    Ok(actions.concat())
}

/// Scores of the best actions of every (state, cell), and the best actions (num_choices each); all states have equally
/// many cells.
fn rank_all(table: &PolicyTable, num_choices: u32, comm: &dyn Comm) -> Result<(Vec<f32>, Vec<u8>)> {
    let (num_states, num_cells) = (table.actions().num_states(), table.grid().num_cells());
    let (own, choices) = (comm.own_range(num_states), num_cells * num_choices as usize);
    let (mut scores, mut actions) = (vec![0.0; own.len() * num_cells], vec![0; own.len() * choices]);
    let rows = scores.par_chunks_mut(num_cells).zip(actions.par_chunks_mut(choices));
    rows.zip(own).for_each(|((scores, actions), state)| {
        let ranked = rank_state(table, state as u32);
        scores.iter_mut().zip(&ranked).for_each(|(score, r)| *score = r.scores[0]);
        actions.iter_mut().zip(best_actions_of(&ranked, num_choices)).for_each(|(action, best)| *action = best);
    });
    let mut all_scores = vec![0.0; num_states * num_cells];
    let mut all_actions = vec![0; num_states * choices];
    share_rows(comm, num_cells, &mut scores, &mut all_scores)?;
    share_rows(comm, choices, &mut actions, &mut all_actions)?;
    Ok((all_scores, all_actions))
}

/// The first `num_choices` best actions of each cell.
fn best_actions_of(ranked: &[RankedActions], num_choices: u32) -> impl Iterator<Item = u8> {
    ranked.iter().flat_map(move |r| r.actions.into_iter().take(num_choices as usize))
}

fn rank_state(table: &PolicyTable, state: u32) -> Vec<RankedActions> {
    let grid = table.grid_of(state);
    let n = grid.num_cells();
    let targets: Vec<_> = (0..n).map(|c| grid.cell_centre(c) + table.centre()).collect();
    let (states, weights) = (vec![state; n], vec![1.0; n]);
    let mut ranked = vec![RankedActions::NONE; n];
    let goals = [LookAheadGoal { policy: table, weights: &weights, targets: &targets }];
    let job = LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked };
    job.run().expect("slices have one length, states exist and centres are finite");
    ranked
}
