//! The policies of a bundle: each takes its rows after those of the one before, and nothing is left over.

use super::{Bundle, tags};
use crate::format::{FormatError, Table};
use crate::policy::{ActionTable, KIND_SPACE_TIME, PolicySlices, PolicyTable, StateGridRecord, TargetGrid};
use std::ops::Range;
use throng_base::Error;

/// Opens all policies: their own checks, names for all, and nothing left over.
pub(super) fn open_policies(t: &Bundle) -> Result<Vec<PolicyTable>, FormatError> {
    let (graph, s, n) = (t.graph(), t.sections(), t.policy_records().len());
    if n > 0 && graph.states.is_empty() {
        return Err(FormatError::layout(format!("there are {n} policies over a motion graph without states")));
    }
    if t.meta().behaviours.len() != n {
        let names = t.meta().behaviours.len();
        return Err(FormatError::layout(format!("META names {names} behaviours, there are {n} policies")));
    }
    let (offsets, segments, errors) = (&graph.action_offsets, &graph.action_segments, &graph.action_errors);
    let actions = ActionTable::new(offsets, segments, errors, graph.segments.len());
    let actions = actions.map_err(|e| FormatError::layout(e.to_string()))?;
    let mut next = SectionCursor::default();
    let policies = (0..n).map(|i| policy(t, &actions, i, &mut next)).collect::<Result<_, _>>()?;
    let lengths = [
        (tags::POLICY_SEGMENTS, s.policy_segments.len(), next.segments),
        (tags::POLICY_PATHS, s.policy_paths.len(), next.paths),
        (tags::POLICY_STATE_GRIDS, s.policy_state_grids.len(), next.state_grids),
        (tags::POLICY_VALUES, s.policy_values.len(), next.values),
        (tags::POLICY_BEST, s.policy_best.len(), next.best),
    ];
    match lengths.into_iter().find(|(_, got, expected)| got != expected) {
        Some((tag, got, expected)) => {
            Err(FormatError::layout(format!("section {tag} has {got} elements, its policies need {expected}")))
        }
        None => Ok(policies),
    }
}

/// First rows of the next policy in each section.
#[derive(Default)]
struct SectionCursor {
    segments: usize,
    paths: usize,
    state_grids: usize,
    values: usize,
    best: usize,
}

/// The policy that begins there.
fn policy(
    t: &Bundle,
    actions: &ActionTable,
    index: usize,
    next: &mut SectionCursor,
) -> Result<PolicyTable, FormatError> {
    let wrong = |e: Error| FormatError::value(tags::POLICIES, index, e.to_string());
    let (s, r) = (t.sections(), &t.policy_records()[index]);
    if r.reward.reserved != 0 {
        return Err(FormatError::value(tags::POLICIES, index, "its reserved fields are not zero"));
    }
    let (num_states, num_segments) = (actions.num_states(), actions.num_segments());
    let num_paths = if r.grid.kind == KIND_SPACE_TIME { num_segments } else { 0 };
    let num_grids = if r.adaptive == 0 { 0 } else { num_states };
    let state_grids = take_rows(&s.policy_state_grids, &mut next.state_grids, num_grids);
    let num_values = match r.adaptive {
        0 => TargetGrid::new(r.grid).map_err(wrong)?.num_cells().saturating_mul(num_states),
        _ => state_grids.iter().fold(0, |sum: usize, g: &StateGridRecord| sum.saturating_add(g.num_cells())),
    };
    let slices = PolicySlices {
        segments: take_rows(&s.policy_segments, &mut next.segments, num_segments),
        paths: take_rows(&s.policy_paths, &mut next.paths, num_paths),
        state_grids,
        values: take_rows(&s.policy_values, &mut next.values, num_values),
        best: take_rows(&s.policy_best, &mut next.best, num_values.saturating_mul(r.num_choices as usize)),
    };
    let policy = PolicyTable::new(r, actions.clone(), slices).map_err(wrong)?;
    let mut ends = policy.segments().iter().zip(&t.graph().segments);
    if let Some(segment) = ends.position(|(p, s)| p.end != s.end) {
        let message = format!("policy {index} has another end than the motion graph");
        return Err(FormatError::value(tags::POLICY_SEGMENTS, segment, message));
    }
    Ok(policy)
}

/// The next rows of a section, or none where they are not all there: the policy's own check then names the lengths.
fn take_rows<T>(all: &Table<T>, next: &mut usize, len: usize) -> Table<T> {
    let rows: Range<usize> = *next..next.saturating_add(len);
    *next = rows.end;
    all.part(rows).unwrap_or_default()
}
