//! The report of a plan.

use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_planner::correct::CollisionStretch;
use throng_planner::task::{StepOutcome, Task, TaskOutcome};

/// Figures of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct PlanReport {
    /// True if every task was solved.
    pub solved: bool,
    /// Every task, in the file's order.
    pub tasks: Vec<TaskReport>,
    /// Time of the searches until their first paths (s).
    pub first_solution_s: f64,
    /// Time of all plans, with smoothing (s).
    pub total_s: f64,
    /// Number of nodes of all search trees.
    pub nodes: usize,
    /// Collision samples: one pose at one time against everything.
    pub checks: u64,
    /// Sum of the joint rotations in all plans (rad).
    pub path_length_rad: f64,
    /// Root mean square of the joints' jerk before smoothing, the mean of all plans (rad/s^3).
    pub jerk_before: f64,
    /// Root mean square of the joints' jerk after smoothing, the mean of all plans (rad/s^3).
    pub jerk_after: f64,
    /// Least distance of planned limbs from obstacles; none without obstacles (m).
    pub clearance_min_m: Option<f64>,
    /// Least margin of planned joints to their limits (rad).
    pub limit_margin_rad: Option<f64>,
    /// Deepest penetration of planned limbs into obstacles (m).
    pub penetration_max_m: f64,
    /// Largest angle of a face off its gaze target, beyond the limits of the neck; none if `gaze` is off (rad).
    pub gaze_off_rad: Option<f64>,
    /// Increase over the clip of the distance of the centre of mass from the planted feet; none if `balance` is off (m).
    pub off_balance_m: Option<f64>,
    /// Largest distance of a second hand from its grip, also between frames; none if no object is held by two hands (m).
    pub second_hand_off_m: Option<f64>,
    /// Violations that an independent recheck found; the plan fails unless this is 0.
    pub recheck_violations: usize,
    /// Files that were written.
    pub files: Vec<PathBuf>,
    /// Motions that were made, if several were requested.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub variants: Vec<VariantReport>,
}

impl PlanReport {
    /// The margin of the joints to their limits, in words.
    pub fn limits(&self) -> String {
        match self.limit_margin_rad {
            None => "- within limits".into(),
            Some(margin) if margin < 0.0 => format!("{:.3} rad beyond limits", -margin),
            Some(margin) => format!("{margin:.3} rad within limits"),
        }
    }
}

/// Outcome of a task.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TaskReport {
    /// Name of the task, or a description.
    pub name: String,
    /// True if it was solved.
    pub solved: bool,
    /// Reason why it was not solved.
    pub why: Option<String>,
    /// Least distance of an unsolved task: to its target, or between both trees of the search (m).
    pub nearest_m: Option<f64>,
    /// Time at which the target is reached, if the task has one; for a walk up to the target, the time that was found (s).
    pub at_s: Option<f64>,
    /// Collisions of the clip, for a correction.
    pub collisions: Vec<CollisionReport>,
}

/// A time span in which a clip collides.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CollisionReport {
    /// Time span, body part and obstacle.
    #[serde(flatten)]
    pub span: CollisionStretch,
    /// Reason why it remains; none if it was corrected.
    pub why: Option<String>,
}

/// One of several motions.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct VariantReport {
    /// Its seed.
    pub seed: u64,
    /// Difference from the most similar other motion: mean angle of the planned joints (rad).
    pub distance_rad: f64,
}

/// Sums up an outcome.
///
/// - `found`: one or more different outcomes; all fields but `variants` describe the first one.
pub fn plan_report(task: &Task, found: &[(u64, TaskOutcome)]) -> Option<PlanReport> {
    let (_, outcome) = found.first()?;
    let plans: Vec<_> = outcome.done.iter().flat_map(|d| &d.plans).collect();
    // Begins at zero, since the sum of no numbers is negative zero.
    let sum = |of: &dyn Fn(&_) -> f64| plans.iter().map(of).fold(0.0, |sum, v| sum + v);
    let mean = |k: usize| sum(&|p| p.roughness[k].jerk_rms) / plans.len().max(1) as f64;
    let finite = |x: f64| x.is_finite().then_some(x);
    let times_s = task.times_s();
    let held_by_two = outcome.attachments.iter().any(|a| a.second.is_some());
    let one = |(d, at_s): (&StepOutcome, Option<f64>)| {
        let (name, why, nearest_m) = (d.name.clone(), d.reason.clone(), d.nearest_m.and_then(finite));
        TaskReport { name, solved: why.is_none(), why, nearest_m, at_s, collisions: collisions(d) }
    };
    Some(PlanReport {
        solved: outcome.is_solved(),
        tasks: outcome.done.iter().zip(times_s).map(one).collect(),
        first_solution_s: sum(&|p| p.first_solution_s),
        total_s: sum(&|p| p.total_s),
        nodes: plans.iter().map(|p| p.nodes).sum(),
        checks: plans.iter().map(|p| p.checks).sum(),
        path_length_rad: sum(&|p| p.roughness[1].length_rad),
        jerk_before: mean(0),
        jerk_after: mean(1),
        clearance_min_m: finite(outcome.recheck.clearance_min_m),
        limit_margin_rad: finite(-outcome.recheck.outside_limits_rad),
        penetration_max_m: outcome.recheck.penetration_max_m,
        gaze_off_rad: task.gaze.then_some(outcome.recheck.gaze_off_rad),
        off_balance_m: task.balance.then_some(outcome.recheck.off_balance_m),
        second_hand_off_m: held_by_two.then_some(outcome.recheck.second_hand_off_m),
        recheck_violations: outcome.recheck.violations.len(),
        files: Vec::new(),
        variants: if found.len() > 1 { variant_reports(found) } else { Vec::new() },
    })
}

/// Collisions that were corrected, and those that remain.
fn collisions(done: &StepOutcome) -> Vec<CollisionReport> {
    let left = |s: &CollisionStretch| done.unresolved.iter().find(|l| l.span == *s).map(|l| l.why.clone());
    let driven = done.unresolved.iter().map(|l| &l.span).filter(|s| !done.spans.contains(s));
    let one = |s: &CollisionStretch| CollisionReport { span: s.clone(), why: left(s) };
    done.spans.iter().chain(driven).map(one).collect()
}

/// Distances of the variants.
fn variant_reports(found: &[(u64, TaskOutcome)]) -> Vec<VariantReport> {
    let distance = |i: usize| {
        let others = found.iter().enumerate().filter(|(k, _)| *k != i);
        others.map(|(_, (_, o))| o.distance_rad(&found[i].1)).reduce(f64::min).unwrap_or(0.0)
    };
    found.iter().enumerate().map(|(i, (seed, _))| VariantReport { seed: *seed, distance_rad: distance(i) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_beyond_their_limits_are_not_said_to_be_within() {
        let of = |limit_margin_rad| PlanReport { limit_margin_rad, ..PlanReport::default() }.limits();
        let texts = [Some(0.12), Some(-0.001), None].map(of);
        assert_eq!(texts, ["0.120 rad within limits", "0.001 rad beyond limits", "- within limits"]);
    }
}
