//! Runs the steps of a task, one after the other.

use super::stage::{ActorClip, TaskGaze, TaskStage, ThingPlacement, hand_joint};
use super::{StepFailure, Task, TaskAction, TaskCharacter, TaskScenery, both_hands, run_step};
use crate::planner::{PlanError, PlanOutcome, Planners};
use crate::search::{LoggedTrees, TreeLog};
use crate::{correct::CollisionStretch, linkage::Limb, recheck::RecheckReport, refuse};
use serde::Serialize;
use std::error::Error;
use std::sync::atomic::{AtomicBool, Ordering};
use throng_base::error::ensure;
use throng_motion::Clip;

/// Result of one step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepOutcome {
    /// The task's name.
    pub name: String,
    /// Index of the character.
    pub character: usize,
    /// The limb.
    pub limb: Limb,
    /// Every plan that was made.
    pub plans: Vec<PlanOutcome>,
    /// Stretches in which the clip collided, of corrections.
    pub spans: Vec<CollisionStretch>,
    /// Stretches that stay in a collision, and why: limbs cannot mend them, or found no path.
    pub unresolved: Vec<UnresolvedSpan>,
    /// Reason why it was not done.
    pub reason: Option<String>,
    /// Nearest distance to a solution, where it was not done (m).
    pub nearest_m: Option<f64>,
    /// Trees of its searches, where [`RunOptions::keeps_trees`] is set.
    pub trees: Vec<LoggedTrees>,
}

/// Options of a run.
#[derive(Clone, Copy, Default)]
pub struct RunOptions<'a> {
    /// Random seed in place of the file's.
    pub seed: Option<u64>,
    /// Stops the run as soon as it is true: steps that are not done by then leave everything as it was, and say so.
    pub cancel: Option<&'a AtomicBool>,
    /// Called with the number of steps that were done or tried.
    pub on_progress: Option<&'a dyn Fn(usize)>,
    /// True keeps the trees of all searches.
    pub keeps_trees: bool,
    /// Planners of the last run, with whose trees plans go on: things have moved a little since. Results then depend on that
    /// run, too.
    pub planners: Option<&'a Planners>,
}

/// A stretch of a clip that stays in a collision.
#[derive(Clone, Debug, PartialEq)]
pub struct UnresolvedSpan {
    /// The stretch, and the collision.
    pub span: CollisionStretch,
    /// Reason why it stays so, and the way out.
    pub why: String,
    /// True where a part collides that is not the limb's: no motion of the limb helps.
    pub is_driven: bool,
}

impl StepOutcome {
    /// Adds the results of the first try of a correction that was tried again.
    fn merge_first_try(&mut self, first: Self) {
        self.plans.splice(..0, first.plans);
        self.trees.splice(..0, first.trees);
        let spans: Vec<_> = first.spans.into_iter().filter(|s| !self.spans.contains(s)).collect();
        self.spans.splice(..0, spans);
        let left = first.unresolved.into_iter().filter(|l| l.is_driven && !self.unresolved.contains(l));
        let left: Vec<_> = left.collect();
        self.unresolved.splice(..0, left);
        if !self.unresolved.is_empty() {
            self.reason = Some(UnresolvedSpan::describe_all(&self.unresolved));
        }
    }
}

impl UnresolvedSpan {
    /// Reasons of all stretches in one line.
    pub(super) fn describe_all(all: &[Self]) -> String {
        all.iter().map(|l| l.why.as_str()).collect::<Vec<_>>().join("; ")
    }
}

/// Placement of a thing for a time: with a joint of a character, on another thing, or by itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Attachment {
    /// The thing.
    pub object: String,
    /// Character that carries it.
    pub character: Option<String>,
    /// Joint that carries it.
    pub joint: Option<String>,
    /// The other hand that holds it, too.
    pub second: Option<String>,
    /// Thing that it is on.
    pub on: Option<String>,
    /// Begin (s).
    pub from_s: f64,
    /// End: the next placement, or the end of the task (s).
    pub to_s: f64,
    /// Position relative to the joint or the thing, or in the world (m).
    pub at: [f64; 3],
    /// Rotation vector (degrees).
    pub turn_deg: [f64; 3],
}

/// An event: something was touched or switched.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskEvent {
    /// The thing.
    pub object: String,
    /// "touch" or "switch".
    pub what: String,
    /// Character that did it.
    pub character: String,
    /// Time (s).
    pub at_s: f64,
}

/// Result of a task.
#[derive(Clone, Debug)]
pub struct TaskOutcome {
    /// Clips of every character, placed in the scene: before and after.
    pub clips: Vec<[Clip; 2]>,
    /// Results of the steps, in the file's order.
    pub done: Vec<StepOutcome>,
    /// Placements of things that were taken or carried.
    pub attachments: Vec<Attachment>,
    /// Things that were touched and switched.
    pub events: Vec<TaskEvent>,
    /// Gazes of characters whose heads turn to targets.
    pub gazes: Vec<TaskGaze>,
    /// Result of a check by independent means.
    pub recheck: RecheckReport,
    /// Places of everything, before and after, for drawing.
    pub scenery: [TaskScenery; 2],
}

impl TaskOutcome {
    /// True where all steps were done.
    pub fn is_solved(&self) -> bool {
        self.done.iter().all(|d| d.reason.is_none())
    }

    /// Difference from the motion of another outcome of the same task: the mean angle between the joints that either changed,
    /// over the frames that either changed (rad).
    pub fn distance_rad(&self, other: &Self) -> f64 {
        let (mut sum, mut count) = (0.0, 0u32);
        for ([before, a], [_, b]) in self.clips.iter().zip(&other.clips) {
            for ((p, q), r) in a.rotations.iter().zip(&b.rotations).zip(&before.rotations) {
                if p != r || q != r {
                    sum += crate::rotation::angle_between(p.as_dquat().normalize(), q.as_dquat().normalize());
                    count += 1;
                }
            }
        }
        if count > 0 { sum / f64::from(count) } else { 0.0 }
    }
}

/// Reason why a task cannot use clips: their number, a rate that differs, a clip of one frame, or a character that has to
/// walk first.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct ClipMismatch(String);

impl ClipMismatch {
    pub(super) fn number(expected: usize, found: usize) -> Self {
        Self(format!("expected {expected} clips, one for each character, found {found}"))
    }

    pub(super) fn not_walked(who: &TaskCharacter) -> Self {
        let why = "its clip is made by `Task::walked`, which gives the task its times";
        Self(format!("`{}` walks up to what it does: {why}", who.name))
    }
}

impl Task {
    /// Runs all steps by priority, and in the file's order where it is equal: later ones see the limbs as they were planned
    /// before. A step that fails is tried once more after all others, and otherwise leaves everything as it was; where that
    /// helps, corrections are repeated.
    ///
    /// - `clips`: one for each character, in the task's order; frame 0 is at time 0.
    /// - `seed`: random seed in place of the file's.
    ///
    /// # Errors
    /// [`ClipMismatch`].
    pub fn run(&self, clips: &[ActorClip], seed: Option<u64>) -> Result<TaskOutcome, ClipMismatch> {
        self.run_watched(clips, &RunOptions { seed, ..RunOptions::default() })
    }

    /// Runs a task as [`Task::run`] does, with options.
    ///
    /// # Errors
    /// [`ClipMismatch`].
    pub fn run_watched(&self, clips: &[ActorClip], watch: &RunOptions<'_>) -> Result<TaskOutcome, ClipMismatch> {
        self.check_clips(clips)?;
        let trees = TreeLog::default();
        let mut stage = TaskStage::new(self, clips);
        (stage.config.trees, stage.config.planners) = (watch.keeps_trees.then_some(&trees), watch.planners);
        stage.config.budget.seed = watch.seed.unwrap_or(self.config.budget.seed);
        stage.config.budget.cancel = watch.cancel;
        let before = TaskScenery::from_stage(&stage);
        let is_cancelled = || watch.cancel.is_some_and(|c| c.load(Ordering::Relaxed));
        let mut num_tried = 0;
        let mut order: Vec<usize> = (0..self.steps.len()).collect();
        order.sort_by_key(|i| self.steps[*i].priority);
        let mut done: Vec<Option<StepOutcome>> = vec![None; self.steps.len()];
        let (mut failed, mut late) = (Vec::new(), false);
        for round in 0..3 {
            for i in std::mem::take(if round == 0 { &mut order } else { &mut failed }) {
                let mut one = attempt_step(&mut stage, i, is_cancelled());
                one.trees = trees.take();
                num_tried += 1;
                watch.on_progress.iter().for_each(|tell| tell(num_tried));
                if one.reason.is_some() && round == 0 {
                    failed.push(i);
                }
                late |= round == 1 && one.reason.is_none() && self.steps[i].action != TaskAction::Correct;
                if let Some(first) = done[i].take().filter(|_| self.steps[i].action == TaskAction::Correct) {
                    one.merge_first_try(first);
                }
                done[i] = Some(one);
            }
            if round == 1 && late {
                // Hands hold other things now than when they were corrected.
                failed = (0..self.steps.len()).filter(|i| self.steps[*i].action == TaskAction::Correct).collect();
            }
        }
        let recheck = super::check::check_stage(&stage);
        let attachments = attachments(&stage);
        let done: Vec<StepOutcome> = done.into_iter().flatten().collect();
        let events = events(self, &done);
        let scenery = [before, TaskScenery::from_stage(&stage)];
        let clips = stage.actors.into_iter().map(|a| [a.before, a.clip]).collect();
        Ok(TaskOutcome { clips, done, attachments, events, gazes: stage.gazes, recheck, scenery })
    }

    /// Collisions of a character's limbs with the scene: each limb, and a stretch of its clip.
    ///
    /// # Errors
    /// [`ClipMismatch`]; invalid problems, as text.
    pub fn collisions(&self, clips: &[ActorClip], who: usize) -> Result<Vec<(Limb, CollisionStretch)>, Box<dyn Error>> {
        self.check_clips(clips)?;
        let stage = TaskStage::new(self, clips);
        let mut out = Vec::new();
        for limb in Limb::ALL {
            let whole_s = [0.0, stage.actors[who].end_s()];
            let problem = stage.limb_problem(who, limb, &stage.surroundings_of_limb(who, limb, whole_s), whole_s)?;
            out.extend(crate::correct::find_collisions(&problem).into_iter().map(|span| (limb, span)));
        }
        Ok(out)
    }

    pub(super) fn check_clips(&self, clips: &[ActorClip]) -> Result<(), ClipMismatch> {
        let (expected, found) = (self.characters.len(), clips.len());
        ensure(expected == found, || ClipMismatch::number(expected, found))?;
        if let Some(step) = self.steps.iter().find(|s| !s.is_timed()) {
            return Err(ClipMismatch::not_walked(&self.characters[step.character]));
        }
        for (clip, who) in clips.iter().map(|c| &c.clip).zip(&self.characters) {
            let (name, first_hz, hz) = (&who.name, clips[0].clip.rate_hz, clip.rate_hz);
            let rate = format_args!(
                "`{name}`: expected {first_hz} frames a second, as the first clip has, found {hz}; resample it"
            );
            refuse(first_hz != hz, rate).map_err(ClipMismatch)?;
            let found = clip.num_frames();
            let length = format_args!("`{name}`: expected a clip of two frames at least, found {found}");
            refuse(found < 2, length).map_err(ClipMismatch)?;
        }
        Ok(())
    }
}

/// Runs a step, or leaves everything as it was.
fn attempt_step(stage: &mut TaskStage<'_>, i: usize, is_cancelled: bool) -> StepOutcome {
    let step = &stage.task.steps[i];
    let before = stage.clone();
    let did = match is_cancelled {
        true => Err(StepFailure { keep: true, ..StepFailure::new("cancelled before it was begun") }),
        false => run_step(stage, step),
    };
    if did.as_ref().is_err_and(|e| !e.keep) {
        *stage = before;
        both_hands::hold_until_end(stage, step);
    }
    let (reason, StepFailure { nearest_m, plans, spans, unresolved, .. }) = match did {
        Ok((plans, spans)) => (None, StepFailure { plans, spans, ..StepFailure::default() }),
        Err(failure) => (Some(failure.reason.clone()), failure),
    };
    let (name, character, limb, trees) = (step.name.clone(), step.character, step.limb, Vec::new());
    StepOutcome { name, character, limb, plans, spans, unresolved, reason, nearest_m, trees }
}

/// Nearest distance of a search to a solution (m).
pub(super) fn nearest_distance(why: &PlanError) -> Option<f64> {
    if let PlanError::Spent { nearest_m, .. } = why { Some(*nearest_m) } else { None }
}

fn attachments(stage: &TaskStage<'_>) -> Vec<Attachment> {
    let mut out = Vec::new();
    for (thing, life) in stage.task.things.iter().zip(&stage.placements) {
        if let [one] = &life[..]
            && matches!(one.placement, ThingPlacement::Path(_))
        {
            continue;
        }
        for (i, s) in life.iter().enumerate() {
            let to_s = life.get(i + 1).map_or(stage.end_s(), |next| next.from_s);
            let from_s = s.from_s.max(0.0);
            let (place, carrier) = match &s.placement {
                ThingPlacement::Path(path) => (path.place_at(from_s), Attachment::default()),
                ThingPlacement::OnJoint { character, joint, offset, second, .. } => {
                    let character = Some(stage.task.characters[*character].name.clone());
                    let joints = [Some(*joint), second.map(|s| hand_joint(s.limb))];
                    let [joint, second] = joints.map(|j| Some(j?.name().into()));
                    (*offset, Attachment { character, joint, second, ..Attachment::default() })
                }
                ThingPlacement::OnThing { thing, offset } => {
                    let on = Some(stage.task.things[*thing].name.clone());
                    (*offset, Attachment { on, ..Attachment::default() })
                }
            };
            let turn_deg = (crate::rotation::log(place.rotation) * (180.0 / std::f64::consts::PI)).to_array();
            let (object, at) = (thing.name.clone(), place.position.to_array());
            out.push(Attachment { object, from_s, to_s, at, turn_deg, ..carrier });
        }
    }
    out
}

fn events(task: &Task, done: &[StepOutcome]) -> Vec<TaskEvent> {
    let all = task.steps.iter().zip(done).filter(|(_, d)| d.reason.is_none());
    let touches = all.filter(|(s, _)| matches!(s.action, TaskAction::Touch | TaskAction::Switch));
    let event = |(s, _): (&super::step::TaskStep, &StepOutcome)| {
        let (object, character) = (task.things[s.object?].name.clone(), task.characters[s.character].name.clone());
        Some(TaskEvent { object, what: s.action.name().into(), character, at_s: s.times_s[1] })
    };
    touches.filter_map(event).collect()
}
