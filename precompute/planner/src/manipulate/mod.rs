//! Hands and feet that reach for something while the rest of the body does what its clip says.

#[cfg(test)]
mod tests;

use crate::clips::with_motion;
use crate::collide::Checker;
use crate::correct::CorrectConfig;
use crate::ik::Unreached;
use crate::linkage::LimbPose;
use crate::planner::{Budget, Outcome, Planner, Unsolved};
use crate::problem::{Problem, Solid, State};
use crate::rotation::Rigid;
use crate::setup::{Held, ProblemError, ProblemSpec};
use crate::track::Path;
use throng_motion::Clip;

/// A target to reach in time.
#[derive(Clone, Copy, Debug)]
pub struct Reach<'a> {
    /// Where the object is, moving or not.
    pub object: &'a Path,
    /// Hand or foot in the object's frame, in the order in which they are tried.
    pub grips: &'a [Rigid],
    /// When the limb leaves the clip, reaches and is back: t_a < t_b < t_c of the paper, taken to the nearest frames (s).
    pub times_s: [f64; 3],
    /// The solid that is grasped, which is no obstacle on the way back; `None` for a touch.
    pub grasped: Option<&'a str>,
    /// What hand or foot carries on the way back.
    pub carried: &'a [Held],
}

/// Something that hand or foot holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    /// The solid.
    pub object: String,
    /// The joint that holds it.
    pub joint: String,
    /// From then on (s).
    pub from_s: f64,
    /// The object in the joint's frame.
    pub offset: Rigid,
}

/// What came of a reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// Which grip.
    pub grip: usize,
    /// The times, on frames (s).
    pub times_s: [f64; 3],
    /// The plans there and back.
    pub outcomes: [Outcome; 2],
    /// What is held from t_b on.
    pub attachment: Option<Attachment>,
}

/// Why nothing was reached.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotReached {
    /// Times that do not ascend or lie outside of the clip.
    #[error(
        "expected three ascending times within the clip's 0 to {end_s:.2} s, at least a frame apart, found {times_s:?}"
    )]
    Times {
        /// What was said (s).
        times_s: [f64; 3],
        /// Length of the clip (s).
        end_s: f64,
    },
    /// No grip is within reach; of the nearest one.
    #[error("no grip is reached at {time_s:.2} s: {why}")]
    Grip {
        /// (s)
        time_s: f64,
        /// Of the first grip that failed by least, or of the last one.
        why: Unreached<String>,
    },
    /// No problem to plan.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// No way.
    #[error("{what}: {why}")]
    Unsolved {
        /// "there" or "back".
        what: &'static str,
        /// Why.
        why: Unsolved,
    },
}

/// Changes a clip so that a limb reaches a target at t_b and is back in the clip at t_c.
///
/// The pose at t_b comes from inverse kinematics where everything is then; the ways there and back are planned in time with
/// the rest of the motion. Contacts that the task needs, of the hand with what it grasps, are the spec's to allow.
///
/// - `spec`: what is around; its motion is the clip's, its ends are not looked at.
///
/// # Errors
/// [`NotReached`]; the clip stays as it was.
///
/// # Source
/// Shapiro, Kallmann and Faloutsos 2007, section 6.2.
pub fn reach(
    clip: &Clip,
    spec: &ProblemSpec<'_>,
    task: &Reach<'_>,
    config: &CorrectConfig<'_>,
) -> Result<(Clip, Reached), NotReached> {
    let times_s = on_frames(clip, task.times_s)?;
    let [there_s, reach_s, back_s] = times_s;
    let present = |time_s: f64| State { pose: spec.motion.limb_pose(spec.linkage, time_s), time_s };
    let between = |init: State, goal: State| ProblemSpec { init, goal, admit_ends: true, ..spec.clone() };
    let whole = Problem::prepare(&between(present(there_s), present(back_s)))?;
    let (grip, pose) = reached(&whole, task, reach_s)?;
    let held_pose = State { pose, time_s: reach_s };
    let mut planner = Planner::new();
    let there = between(present(there_s), held_pose);
    let (out, first) = planned(clip, &mut planner, &there, config, "there")?;
    let free: Vec<Solid> = spec.solids.iter().filter(|s| Some(s.name.as_str()) != task.grasped).cloned().collect();
    let held: Vec<Held> = spec.held.iter().chain(task.carried).cloned().collect();
    // What was grasped is no longer there to be touched.
    let is_left = |a: &&crate::setup::Allowed| task.grasped.is_none_or(|g| a.with != g);
    let allowed: Vec<_> = spec.allowed.iter().filter(is_left).cloned().collect();
    let back = ProblemSpec { solids: &free, held: &held, allowed: &allowed, ..between(held_pose, present(back_s)) };
    let (out, second) = planned(&out, &mut planner, &back, config, "back")?;
    let joint = spec.linkage.joints()[spec.linkage.len() - 1];
    let attachment = task.grasped.map(|object| Attachment {
        object: object.into(),
        joint: joint.name().into(),
        from_s: reach_s,
        offset: task.grips[grip].local(Rigid::IDENTITY),
    });
    Ok((out, Reached { grip, times_s, outcomes: [first, second], attachment }))
}

fn on_frames(clip: &Clip, times_s: [f64; 3]) -> Result<[f64; 3], NotReached> {
    let last = clip.num_frames().saturating_sub(1) as f64;
    let frames = times_s.map(|t| (t * clip.rate_hz).round());
    let ascend = frames[0] >= 0.0 && frames[0] < frames[1] && frames[1] < frames[2] && frames[2] <= last;
    if !ascend {
        return Err(NotReached::Times { times_s, end_s: last / clip.rate_hz });
    }
    Ok(frames.map(|f| f / clip.rate_hz))
}

/// The first grip that is reached, and the pose that does.
fn reached(problem: &Problem, task: &Reach<'_>, time_s: f64) -> Result<(usize, LimbPose), NotReached> {
    let mut checker = Checker::default();
    let object = task.object.at(time_s);
    let present = problem.present_at(time_s);
    let mut nearest: Option<Unreached<String>> = None;
    for (i, grip) in task.grips.iter().enumerate() {
        match problem.reach(&mut checker, &object.then(*grip), time_s, &present) {
            Ok(pose) => return Ok((i, pose)),
            Err(why) => {
                let is_nearer = match (&nearest, &why) {
                    (Some(Unreached::OutOfReach { by_m: a }), Unreached::OutOfReach { by_m: b }) => b < a,
                    (Some(Unreached::OutOfLimits { by_rad: a, .. }), Unreached::OutOfLimits { by_rad: b, .. }) => b < a,
                    (Some(Unreached::OutOfReach { .. }) | None, _) => true,
                    (Some(_), _) => false,
                };
                if is_nearer {
                    nearest = Some(why);
                }
            }
        }
    }
    let why = nearest.unwrap_or(Unreached::OutOfReach { by_m: f64::INFINITY });
    Err(NotReached::Grip { time_s, why })
}

fn planned(
    clip: &Clip,
    planner: &mut Planner,
    spec: &ProblemSpec<'_>,
    config: &CorrectConfig<'_>,
    what: &'static str,
) -> Result<(Clip, Outcome), NotReached> {
    let problem = Problem::new(spec)?;
    let budget = Budget { rate_hz: clip.rate_hz, ..config.budget };
    let outcome = planner.plan(&problem, &config.plan, &budget);
    match (outcome.why, planner.motion()) {
        (None, Some(motion)) => {
            let misfit =
                |e: crate::clips::Misfit| ProblemError::Value { what: e.to_string(), expected: "the clip's frames" };
            Ok((with_motion(clip, 0.0, spec.linkage, &motion).map_err(misfit)?, outcome))
        }
        (why, _) => Err(NotReached::Unsolved { what, why: why.unwrap_or(Unsolved::Rate) }),
    }
}
