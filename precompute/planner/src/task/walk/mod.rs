//! Characters who walk up to their steps: standing places, paths to them, and times at which limbs set out.

mod gait;
mod route;
mod stand;

use super::{ActorClip, ClipMismatch, Task, TaskStage};
use gait::WalkRecording;
use glam::DVec2;
use stand::StandSearch;
use throng_base::error::ensure;
use throng_core::blend::BlendSpace;

/// Time by which a limb sets out before a walk ends (s).
const EARLY_S: f64 = 0.45;
/// Least time from the end of the walk until hand or foot is at its target, and from its setting out (s).
const THERE_S: f64 = 0.25;
const OUT_S: f64 = 0.85;
/// Time of the limb's path back into the clip (s).
const BACK_S: f64 = 0.9;
/// Time for which a character stands before its next walk (s).
const STAY_S: f64 = 0.35;
/// Time of standing at the beginning and at the end of everything (s).
const REST_S: f64 = 0.5;
/// Most changes of standing places because a limb found no path.
const MOST_TRIES: usize = 12;
/// Longest walk to one step (m).
const FARTHEST_M: f64 = 200.0;
/// Time after which no character sets out for another step (s).
const LONGEST_S: f64 = 3600.0;

/// Motion of a character.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there are as many as characters, once")]
pub enum ActorSource {
    /// A clip.
    Clip(ActorClip),
    /// Walking up to its steps, with bodies of a blend space whose first axis is speed.
    Walks(BlendSpace),
}

/// Clips of characters who walk, and the task with the times at which they are in place.
#[derive(Clone, Debug)]
pub struct WalkedTask {
    /// The task, to be run with the clips.
    pub task: Task,
    /// Clips of all characters.
    pub clips: Vec<ActorClip>,
}

/// Reason why characters cannot walk.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WalkError {
    /// Clips do not fit.
    #[error(transparent)]
    Clips(#[from] ClipMismatch),
    /// The blend space refuses the walk.
    #[error("`{name}`: {source}")]
    Space {
        /// Name of the character.
        name: String,
        /// Reason.
        source: throng_base::Error,
    },
    /// No standing place was found, or no path to one.
    #[error("{task}: {why}")]
    NoPlace {
        /// Name of the task.
        task: String,
        /// Failure of the place that came nearest, and the way out.
        why: String,
    },
}

impl Task {
    /// True where a character walks up to its steps: the walks have to be planned before the task is run.
    pub fn needs_walking(&self) -> bool {
        self.characters.iter().any(|c| c.clip.walk.is_some())
    }

    /// Plans the walks of characters up to their steps: for each step without a time, in the file's order, the nearest standing
    /// place from which the limb reaches its target, within limits and free, and a path there past obstacles. The limb sets out
    /// before the walk ends.
    ///
    /// Where a limb finds no path from a place, the next place is tried, a few times.
    ///
    /// - `actors`: one for each character, in the task's order.
    /// - `rate_hz`: rate of the clips of walking characters, where no character has a clip.
    /// - `seed`: as in [`Task::run`].
    ///
    /// # Errors
    /// [`WalkError`].
    ///
    /// # Source
    /// Shapiro, Kallmann and Faloutsos 2007, section 6.2, last paragraph. Differs: the place to stand is searched, too.
    pub fn plan_walks(&self, actors: &[ActorSource], rate_hz: f64, seed: Option<u64>) -> Result<WalkedTask, WalkError> {
        let mut passed = vec![0; self.steps.len()];
        let mut best: Option<(usize, WalkedTask)> = None;
        for _ in 0..MOST_TRIES {
            let walked = match (self.walk_all(actors, rate_hz, &passed), &best) {
                (Ok(walked), _) => walked,
                (Err(WalkError::NoPlace { .. }), Some(_)) => break,
                (Err(e), _) => return Err(e),
            };
            if !self.needs_walking() {
                return Ok(walked);
            }
            let outcome = walked.task.run(&walked.clips, seed)?;
            let num_done = outcome.done.iter().filter(|d| d.reason.is_none()).count();
            if best.as_ref().is_none_or(|(n, _)| num_done > *n) {
                best = Some((num_done, walked));
            }
            let failed = outcome.done.iter().zip(&self.steps).position(|(d, s)| d.reason.is_some() && !s.is_timed());
            let Some(step) = failed else { break };
            passed[step] += 1;
        }
        // The first round has put one there, or has returned.
        best.map(|(_, walked)| walked)
            .ok_or_else(|| WalkError::NoPlace { task: "the task".into(), why: "nobody walks".into() })
    }

    /// - `passed`: number of places of each step that were rejected before.
    fn walk_all(&self, sources: &[ActorSource], rate_hz: f64, passed: &[usize]) -> Result<WalkedTask, WalkError> {
        let (expected, found) = (self.characters.len(), sources.len());
        ensure(expected == found, || ClipMismatch::number(expected, found))?;
        let known = sources.iter().find_map(|s| if let ActorSource::Clip(c) = s { Some(c.clip.rate_hz) } else { None });
        let rate_hz = known.unwrap_or(rate_hz);
        let mut gaits: Vec<Option<WalkRecording>> = Vec::new();
        let mut clips = Vec::new();
        for (source, who) in sources.iter().zip(&self.characters) {
            let (space, walk) = match (source, &who.clip.walk) {
                (ActorSource::Clip(clip), _) => {
                    clips.push(clip.clone());
                    gaits.push(None);
                    continue;
                }
                (ActorSource::Walks(_), None) => return Err(ClipMismatch::not_walked(who).into()),
                (ActorSource::Walks(space), Some(walk)) => (space, walk),
            };
            let begin = || {
                let heading = walk.heading_deg.to_radians();
                let mut gait = WalkRecording::new(space, DVec2::from(walk.from), heading, rate_hz)?;
                match walk.pace.is_empty() {
                    true => gait.stand_until(REST_S)?,
                    false => gait.walk_at_pace(&walk.pace)?,
                }
                Ok(gait)
            };
            let gait = begin().map_err(|source| WalkError::Space { name: who.name.clone(), source })?;
            clips.push(ActorClip { clip: gait.clip(&who.name), skeleton: space.skeleton().clone() });
            gaits.push(Some(gait));
        }
        let mut task = self.clone();
        for (who, gait) in gaits.into_iter().enumerate() {
            let goes_on = self.characters[who].clip.walk.as_ref().is_some_and(|w| !w.pace.is_empty());
            let Some(mut gait) = gait.filter(|_| !goes_on) else { continue };
            let wrong = |source| WalkError::Space { name: self.characters[who].name.clone(), source };
            let mut end_s = 0.0f64;
            for i in 0..task.steps.len() {
                if task.steps[i].character != who || task.steps[i].is_timed() {
                    continue;
                }
                let (times_s, after) = walk_to_step(&task, &clips, i, &gait, passed[i])?;
                task.steps[i].times_s = times_s;
                gait = after;
                end_s = end_s.max(times_s[2]);
                clips[who].clip = gait.clip(&self.characters[who].name);
            }
            gait.gaze_target = None;
            gait.stand_until(end_s.max(gait.time_s()) + REST_S).map_err(wrong)?;
            clips[who].clip = gait.clip(&self.characters[who].name);
        }
        Ok(WalkedTask { task, clips })
    }
}

/// Times at which the limb of a step sets out, is there and is back (s), and the walker.
type StepWalk = Result<([f64; 3], WalkRecording), WalkError>;

/// Walks to a place from which a step can be done, and stands there for as long as it takes.
fn walk_to_step(task: &Task, clips: &[ActorClip], i: usize, gait: &WalkRecording, mut passed: usize) -> StepWalk {
    let step = &task.steps[i];
    let who = step.character;
    let speed_mps = task.characters[who].clip.walk.as_ref().map_or(1.2, |w| w.speed_mps);
    let wrong = |source| WalkError::Space { name: task.characters[who].name.clone(), source };
    // Time at which the limb is back from its step before.
    let same = |s: &&super::step::TaskStep| s.character == who && s.limb == step.limb && s.is_timed();
    let free_s = task.steps[..i].iter().filter(same).map(|s| s.times_s[2]).fold(0.0, f64::max);
    let mut wanted = StandSearch::new(TaskStage::new(task, clips), step, gait);
    let (from, heading) = gait.place();
    let stands = wanted.candidate_places(speed_mps);
    let nowhere = |why: String| Err(WalkError::NoPlace { task: step.name.clone(), why });
    if let Some(far_m) = stands.iter().map(|s| s.position.distance(from)).find(|m| *m > FARTHEST_M) {
        return nowhere(format!("it is {far_m:.0} m away, expected {FARTHEST_M} m at most; begin nearer"));
    }
    if gait.time_s() > LONGEST_S {
        return nowhere(format!("it begins after {LONGEST_S} s; do the rest in another task file"));
    }
    // Places that need no bend come first.
    let upright = stands.iter().map(|stand| (stand, false));
    let leaning = stands.iter().map(|stand| (stand, true)).filter(|_| task.lean && step.limb.is_arm());
    for (stand, leans) in upright.chain(leaning) {
        wanted.leans = leans;
        if !wanted.is_free(stand) || !wanted.is_reached_at(wanted.pose_at(stand), stand.at_s) {
            continue;
        }
        let mut after = gait.clone();
        after.gaze_target = Some(wanted.target(stand.at_s).position);
        let is_here = stand.position == from && stand.heading == heading;
        let mut walked_s = after.time_s();
        if !is_here {
            let Some(path) = wanted.route_obstacles(stand).find_path(from, stand.position) else { continue };
            walked_s = after.walk_along(&path, speed_mps).map_err(wrong)?;
            after.turn_to(stand.heading).map_err(wrong)?;
        }
        let from_s = (walked_s - EARLY_S).max(free_s).max(0.0);
        let at_s = (after.time_s() + THERE_S).max(from_s + OUT_S);
        let held_s = at_s + step.hold_s;
        after.stand_until(at_s).map_err(wrong)?;
        if !wanted.is_reached_at(after.pose(), at_s) {
            continue;
        }
        after.stand_until(held_s + STAY_S).map_err(wrong)?;
        if !wanted.is_walk_free(&after, [from_s, held_s + BACK_S]) {
            continue;
        }
        if passed > 0 {
            passed -= 1;
            continue;
        }
        return Ok(([from_s, at_s, held_s + BACK_S], after));
    }
    nowhere(wanted.failure_reason())
}
