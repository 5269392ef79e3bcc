//! Hands and feet that reach for a target while the rest of the body follows its clip.

#[cfg(test)]
mod tests;

use crate::clips::with_motion;
use crate::collide::Checker;
use crate::correct::CorrectConfig;
use crate::ik::IkError;
use crate::planner::{LimbMotion, LimbPlanner, PlanError, PlanOutcome};
use crate::problem::{LimbState, Problem};
use crate::rotation::Rigid;
use crate::setup::{ProblemError, ProblemSpec};
use throng_base::error::ensure;
use throng_motion::Clip;

/// A target to reach in time.
#[derive(Clone, Copy, Debug)]
pub struct ReachTask<'a> {
    /// Transform of hand or foot at t_b.
    pub target: Rigid,
    /// Times at which the limb leaves the clip, reaches and is back: t_a < t_b < t_c of the paper, taken to the nearest frames
    /// (s).
    pub times_s: [f64; 3],
    /// Time after t_b for which the limb keeps its pose, in the frame of the joint that carries it (s).
    pub hold_s: f64,
    /// Surroundings on the path back, where a grasped object is in the hand.
    pub return_spec: &'a ProblemSpec<'a>,
}

/// Reason why a target was not reached.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReachError {
    /// The target is not within reach.
    #[error("not reached at {time_s:.2} s: {why}")]
    Target {
        /// (s)
        time_s: f64,
        /// Reason of the failure.
        why: IkError<String>,
    },
    /// The problem is invalid, times among it.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// No path was found.
    #[error("{what}: {why}")]
    Unsolved {
        /// "there" or "back".
        what: &'static str,
        /// Reason of the failure.
        why: PlanError,
    },
}

/// Changes a clip so that a limb reaches a target at t_b and is back in the clip at t_c.
///
/// Inverse kinematics gives the pose at t_b, with everything where it is then; the paths there and back are planned in time
/// with the rest of the motion. The spec has to allow contacts that the task needs, of the hand with the grasped object.
///
/// - `spec`: the surroundings; its motion is the clip's, its ends are not used.
///
/// # Errors
/// [`ReachError`]; the clip stays as it was.
///
/// # Source
/// Shapiro, Kallmann and Faloutsos 2007, section 6.2.
pub fn reach_target(
    clip: &Clip,
    spec: &ProblemSpec<'_>,
    task: &ReachTask<'_>,
    config: &CorrectConfig<'_>,
) -> Result<(Clip, [PlanOutcome; 2]), ReachError> {
    let [there_s, reach_s, back_s] = on_frames(clip, task.times_s)?;
    let held_s = ((reach_s + task.hold_s) * clip.rate_hz).round() / clip.rate_hz;
    if !(held_s >= reach_s && held_s < back_s) {
        let (hold_s, most_s) = (task.hold_s, back_s - reach_s);
        let why = format!("expected to hold for less than the {most_s:.2} s until the limb is back, found {hold_s} s");
        return Err(ProblemError::Invalid(why).into());
    }
    let present = |time_s: f64| spec.motion.limb_state(spec.limb, time_s);
    let whole = Problem::prepare(&spec.between_times([there_s, back_s]))?;
    let present_pose = whole.external_pose_at(reach_s);
    let reached = whole.solve_reach(&mut Checker::default(), &task.target, reach_s, &present_pose);
    let pose = reached.map_err(|why| ReachError::Target { time_s: reach_s, why })?;
    let at_target = LimbState { pose, time_s: reach_s };
    let mut planner = LimbPlanner::new();
    let there = spec.between([present(there_s), at_target]);
    let (out, first) = plan_into_clip(clip, &mut planner, &there, config, "there")?;
    let kept = vec![pose; ((held_s - reach_s) * clip.rate_hz).round() as usize + 1];
    let kept = LimbMotion { start_s: reach_s, step_s: 1.0 / clip.rate_hz, frames: &kept };
    let out = with_motion(&out, 0.0, spec.limb, &kept)?;
    let ends = [LimbState { time_s: held_s, ..at_target }, present(back_s)];
    let back = task.return_spec.between(ends);
    let (out, second) = plan_into_clip(&out, &mut planner, &back, config, "back")?;
    Ok((out, [first, second]))
}

fn on_frames(clip: &Clip, times_s: [f64; 3]) -> Result<[f64; 3], ProblemError> {
    let last = clip.num_frames().saturating_sub(1) as f64;
    let frames = times_s.map(|t| (t * clip.rate_hz).round());
    let ascend = frames[0] >= 0.0 && frames[0] < frames[1] && frames[1] < frames[2] && frames[2] <= last;
    ensure(ascend, || wrong_times(times_s, last / clip.rate_hz))?;
    Ok(frames.map(|f| f / clip.rate_hz))
}

/// The error of times that do not ascend or lie outside of a clip.
pub(crate) fn wrong_times(times_s: [f64; 3], end_s: f64) -> ProblemError {
    let within = format!("within the clip's 0 to {end_s:.2} s, at least a frame apart");
    ProblemError::Invalid(format!("expected three ascending times {within}, found {times_s:?}"))
}

/// Plans from a spec's start to its goal, and writes the motion into the clip.
pub(crate) fn plan_into_clip(
    clip: &Clip,
    planner: &mut LimbPlanner,
    spec: &ProblemSpec<'_>,
    config: &CorrectConfig<'_>,
    what: &'static str,
) -> Result<(Clip, PlanOutcome), ReachError> {
    let problem = Problem::new(spec)?;
    let outcome = config.run(planner, &problem, clip.rate_hz);
    match (outcome.why, planner.motion()) {
        (None, Some(motion)) => Ok((with_motion(clip, 0.0, spec.limb, &motion)?, outcome)),
        (why, _) => Err(ReachError::Unsolved { what, why: why.unwrap_or(PlanError::Rate) }),
    }
}
