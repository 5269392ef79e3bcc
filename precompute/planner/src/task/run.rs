//! Does what a task says, one thing after the other.

use super::file::{Deed, Step, Task};
use crate::body::BodyShape;
use crate::correct::{Corrected, correct};
use crate::driven::Driven;
use crate::limits::BodyLimits;
use crate::linkage::{Limb, Linkage};
use crate::manipulate::{Reach, Reached, reach};
use crate::problem::{Solid, State};
use crate::setup::{Allowed, ProblemSpec};
use throng_core::Skeleton;
use throng_motion::Clip;

/// How long before it is reached and after a hand may touch what it reaches for (s).
const CONTACT_S: f64 = 0.25;

/// What came of one thing to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Done {
    /// Every stretch in which the limb collided.
    Corrected(Vec<Corrected>),
    /// It was reached.
    Reached(Box<Reached>),
    /// It was not, and why.
    Not(String),
}

/// What came of a task.
#[derive(Clone, Debug)]
pub struct TaskOutcome {
    /// The clip with all that succeeded.
    pub clip: Clip,
    /// For each thing to do, in the file's order: the limb, and what came of it.
    pub done: Vec<(Limb, Done)>,
}

impl TaskOutcome {
    /// True where everything was done.
    pub fn is_solved(&self) -> bool {
        self.done.iter().all(|(_, done)| match done {
            Done::Corrected(spans) => spans.iter().all(|c| c.outcome.is_ok()),
            Done::Reached(_) => true,
            Done::Not(_) => false,
        })
    }
}

impl Task {
    /// Does everything in the file's order: what comes later sees the limbs as they were planned before. What cannot be done
    /// leaves the clip as it was.
    ///
    /// - `clip`: on `skeleton`; its frame 0 is at time 0.
    pub fn run(&self, clip: &Clip, skeleton: &Skeleton) -> TaskOutcome {
        let limits = BodyLimits::built_in(skeleton);
        let shape = BodyShape::fitted(skeleton);
        let mut out = TaskOutcome { clip: clip.clone(), done: Vec::new() };
        let mut solids = self.solids.clone();
        for step in &self.steps {
            let last_s = out.clip.num_frames().saturating_sub(1) as f64 / out.clip.rate_hz;
            let motion = Driven::of_clip(&out.clip, skeleton, 0.0, last_s);
            let linkage = Linkage::limb(step.limb);
            let ends = [0.0, last_s].map(|time_s| State { pose: motion.limb_pose(linkage, time_s), time_s });
            let spec = ProblemSpec::new(skeleton, linkage, &limits, &motion, &shape, ends);
            let spec = ProblemSpec { solids: &solids, clearance_m: self.clearance_m, ..spec };
            let done = match step.deed {
                Deed::Correct => corrected(self, &mut out.clip, &spec),
                Deed::Touch | Deed::Grab => reached(self, step, &mut out.clip, &spec),
            };
            if let (Deed::Grab, Done::Reached(_), Some(object)) = (step.deed, &done, step.object) {
                // It is in the hand from then on, and no obstacle to what follows.
                solids.retain(|s| s.name != self.solids[object].name);
            }
            out.done.push((step.limb, done));
        }
        out
    }
}

fn corrected(task: &Task, clip: &mut Clip, spec: &ProblemSpec<'_>) -> Done {
    match correct(clip, spec, &task.config) {
        Ok((changed, spans)) => {
            *clip = changed;
            Done::Corrected(spans)
        }
        Err(e) => Done::Not(e.to_string()),
    }
}

fn reached(task: &Task, step: &Step, clip: &mut Clip, spec: &ProblemSpec<'_>) -> Done {
    let Some(object) = step.object.map(|i| &task.solids[i]) else { return Done::Not("there is no object".into()) };
    if !spec.solids.iter().any(|s: &Solid| s.name == object.name) {
        return Done::Not(format!("`{}` is held already", object.name));
    }
    let at_s = step.times_s[1];
    let [.., wrist_or_ankle] = step.limb.joints();
    let allowed = [Allowed {
        part: Some(wrist_or_ankle.name().into()),
        with: object.name.clone(),
        window_s: Some([at_s - CONTACT_S, at_s + CONTACT_S]),
    }];
    let spec = ProblemSpec { allowed: &allowed, ..spec.clone() };
    let grasped = (step.deed == Deed::Grab).then_some(object.name.as_str());
    let reach_for = Reach { object: &object.path, grips: &step.grips, times_s: step.times_s, grasped, carried: &[] };
    match reach(clip, &spec, &reach_for, &task.config) {
        Ok((changed, reached)) => {
            *clip = changed;
            Done::Reached(Box::new(reached))
        }
        Err(e) => Done::Not(e.to_string()),
    }
}
