//! The policies of a bundle: each takes its rows after those of the one before, and nothing is left over.

use super::check::{check_used, refuse};
use super::{Bundle, tags};
use crate::format::{FormatError, Table};
use crate::policy::{ActionTable, KIND_SPACE_TIME, PolicySlices, PolicyTable, StateGridRecord, TargetGrid};
use throng_base::{Error, error::ensure};

/// Opens all policies: their own checks, names for all, and nothing left over.
pub(super) fn open_policies(t: &Bundle) -> Result<Vec<PolicyTable>, FormatError> {
    let (graph, s, n) = (t.graph(), t.sections(), t.policy_records().len());
    let fault = format!("there are {n} policies over a motion graph without states");
    ensure(n == 0 || !graph.states.is_empty(), || FormatError::layout(fault))?;
    let names = t.meta().behaviours.len();
    let fault = format!("META names {names} behaviours, there are {n} policies");
    ensure(names == n, || FormatError::layout(fault))?;
    let (offsets, segments, errors) = (&graph.action_offsets, &graph.action_segments, &graph.action_errors);
    let actions = ActionTable::new(offsets, segments, errors, graph.segments.len());
    let actions = actions.map_err(|e| FormatError::layout(e.to_string()))?;
    let mut rest = PolicySlices {
        segments: s.policy_segments.clone(),
        paths: s.policy_paths.clone(),
        errors: s.action_errors.part(errors.len()..s.action_errors.len()).unwrap_or_default(),
        state_grids: s.policy_state_grids.clone(),
        values: s.policy_values.clone(),
        best: s.policy_best.clone(),
    };
    let policies = (0..n).map(|i| policy(t, &actions, i, &mut rest)).collect::<Result<_, _>>()?;
    let sections = [
        (tags::POLICY_SEGMENTS, s.policy_segments.len(), rest.segments.len()),
        (tags::POLICY_PATHS, s.policy_paths.len(), rest.paths.len()),
        (tags::ACTION_ERRORS, s.action_errors.len(), rest.errors.len()),
        (tags::POLICY_STATE_GRIDS, s.policy_state_grids.len(), rest.state_grids.len()),
        (tags::POLICY_VALUES, s.policy_values.len(), rest.values.len()),
        (tags::POLICY_BEST, s.policy_best.len(), rest.best.len()),
    ];
    sections.into_iter().try_for_each(|(tag, len, rest)| check_used(tag, len, (len - rest) as u64, "policies"))?;
    Ok(policies)
}

/// The policy whose rows begin `rest`, which is left with those of the policies after it.
fn policy(t: &Bundle, actions: &ActionTable, at: usize, rest: &mut PolicySlices) -> Result<PolicyTable, FormatError> {
    let wrong = |e: Error| FormatError::value(tags::POLICIES, at, e.to_string());
    let r = &t.policy_records()[at];
    let (num_states, num_segments) = (actions.num_states(), actions.num_segments());
    let num_errors = if r.reward.own_errors == 0 { 0 } else { actions.num_actions() };
    let num_paths = if r.grid.kind == KIND_SPACE_TIME { num_segments } else { 0 };
    let state_grids = take_rows(&mut rest.state_grids, if r.adaptive == 0 { 0 } else { num_states });
    let num_values = match r.adaptive {
        0 => TargetGrid::new(r.grid).map_err(wrong)?.num_cells().saturating_mul(num_states),
        _ => state_grids.iter().fold(0, |sum: usize, g: &StateGridRecord| sum.saturating_add(g.num_cells())),
    };
    let slices = PolicySlices {
        segments: take_rows(&mut rest.segments, num_segments),
        paths: take_rows(&mut rest.paths, num_paths),
        errors: take_rows(&mut rest.errors, num_errors),
        state_grids,
        values: take_rows(&mut rest.values, num_values),
        best: take_rows(&mut rest.best, num_values.saturating_mul(r.num_choices as usize)),
    };
    let policy = PolicyTable::new(r, actions.clone(), slices).map_err(wrong)?;
    let other_end = policy.segments().iter().zip(&t.graph().segments).position(|(p, s)| p.end != s.end);
    refuse(tags::POLICY_SEGMENTS, other_end, &format!("policy {at} has another end than the motion graph"))?;
    Ok(policy)
}

/// Takes the first rows off, or none where they are not all there: the policy's own check then names the lengths.
fn take_rows<T>(rest: &mut Table<T>, len: usize) -> Table<T> {
    let Some(rows) = rest.part(0..len) else { return Table::default() };
    *rest = rest.part(len..rest.len()).unwrap_or_default();
    rows
}
