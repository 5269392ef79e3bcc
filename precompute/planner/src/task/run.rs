//! Runs the steps of a task, one after the other.

use super::both;
use super::deeds::{Problems, do_step};
use super::entries::Deed;
use super::file::Task;
use super::scenery::Scenery;
use super::stage::{ActorClip, Looked, Stage, Whereabouts, hand};
use crate::correct::{CorrectConfig, Span};
use crate::linkage::Limb;
use crate::planner::{Outcome, Planners, Unsolved};
use crate::recheck::RecheckReport;
use crate::search::{Grown, Trees};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use throng_motion::Clip;

/// Result of one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Done {
    /// The task's name.
    pub name: String,
    /// Index of the character.
    pub character: usize,
    /// The limb.
    pub limb: Limb,
    /// Every plan that was made.
    pub plans: Vec<Outcome>,
    /// Stretches in which the clip collided, of corrections.
    pub spans: Vec<Span>,
    /// Stretches that stay in a collision, and why: limbs cannot mend them, or found no path.
    pub left: Vec<Left>,
    /// Reason why it was not done.
    pub why: Option<String>,
    /// Nearest distance to a solution, where it was not done (m).
    pub nearest_m: Option<f64>,
    /// Trees of its searches, where [`Watch::keeps_trees`] is set.
    pub trees: Vec<Grown>,
}

/// Options of a run.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Random seed in place of the file's.
    pub seed: Option<u64>,
    /// Stops the run as soon as it is true: steps that are not done by then leave everything as it was, and say so.
    pub cancel: Option<&'a AtomicBool>,
    /// Called with the number of steps that were done or tried.
    pub tell: Option<&'a dyn Fn(usize)>,
    /// True keeps the trees of all searches.
    pub keeps_trees: bool,
    /// Planners of the last run, with whose trees plans go on: things have moved a little since. Results then depend on that
    /// run, too.
    pub planners: Option<&'a Planners>,
}

/// A stretch of a clip that stays in a collision.
#[derive(Clone, Debug, PartialEq)]
pub struct Left {
    /// The stretch, and the collision.
    pub span: Span,
    /// Reason why it stays so, and the way out.
    pub why: String,
    /// True where a part collides that is not the limb's: no motion of the limb helps.
    pub is_driven: bool,
}

impl Done {
    /// Adds the results of the first try of a correction that was tried again.
    fn after(&mut self, first: Self) {
        let mut plans = first.plans;
        plans.append(&mut self.plans);
        self.plans = plans;
        let mut spans: Vec<Span> = first.spans.into_iter().filter(|s| !self.spans.contains(s)).collect();
        spans.append(&mut self.spans);
        self.spans = spans;
        let mut trees = first.trees;
        trees.append(&mut self.trees);
        self.trees = trees;
        let mut left: Vec<Left> = first.left.into_iter().filter(|l| l.is_driven && !self.left.contains(l)).collect();
        left.append(&mut self.left);
        if !left.is_empty() {
            self.why = Some(Left::why(&left));
        }
        self.left = left;
    }
}

impl Left {
    /// Reasons of all stretches in one line.
    pub(super) fn why(all: &[Self]) -> String {
        let each: Vec<&str> = all.iter().map(|l| l.why.as_str()).collect();
        each.join("; ")
    }
}

/// Placement of a thing for a time: with a joint of a character, on another thing, or by itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
pub struct Event {
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
    pub done: Vec<Done>,
    /// Placements of things that were taken or carried.
    pub attachments: Vec<Attachment>,
    /// Things that were touched and switched.
    pub events: Vec<Event>,
    /// Gazes of characters whose heads turn to targets.
    pub looks: Vec<Looked>,
    /// Result of a check by independent means.
    pub recheck: RecheckReport,
    /// Places of everything, before and after, for drawing.
    pub scenery: [Scenery; 2],
}

impl TaskOutcome {
    /// True where all steps were done.
    pub fn is_solved(&self) -> bool {
        self.done.iter().all(|d| d.why.is_none())
    }

    /// Difference from the motion of another outcome of the same task: the mean angle between the joints that either changed,
    /// over the frames that either changed (rad).
    pub fn distance_rad(&self, other: &Self) -> f64 {
        let (mut sum, mut count) = (0.0, 0u32);
        for ([before, a], [_, b]) in self.clips.iter().zip(&other.clips) {
            for ((p, q), r) in a.rotations.iter().zip(&b.rotations).zip(&before.rotations) {
                if p != r || q != r {
                    sum += crate::rotation::angle(p.as_dquat().normalize(), q.as_dquat().normalize());
                    count += 1;
                }
            }
        }
        if count > 0 { sum / f64::from(count) } else { 0.0 }
    }
}

/// Reason why a task cannot use clips.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoClips {
    /// The number of clips is not that of the characters.
    #[error("expected {expected} clips, one for each character, found {found}")]
    Number {
        /// Number of characters.
        expected: usize,
        /// Number of clips.
        found: usize,
    },
    /// The rate of a clip differs from the first one's.
    #[error("`{name}`: expected {expected_hz} frames a second, as the first clip has, found {found_hz}; resample it")]
    Rate {
        /// Name of the character.
        name: String,
        /// Its rate (Hz).
        expected_hz: f64,
        /// Rate of the first clip (Hz).
        found_hz: f64,
    },
    /// A character has to walk first.
    #[error("`{name}` walks up to what it does: its clip is made by `Task::walked`, which gives the task its times")]
    NotWalked {
        /// Name of the character.
        name: String,
    },
    /// A clip is too short to be changed.
    #[error("`{name}`: expected a clip of two frames at least, found {found}")]
    Short {
        /// Name of the character.
        name: String,
        /// Number of frames.
        found: usize,
    },
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
    /// [`NoClips`].
    pub fn run(&self, clips: &[ActorClip], seed: Option<u64>) -> Result<TaskOutcome, NoClips> {
        self.run_watched(clips, &Watch { seed, ..Watch::default() })
    }

    /// Runs a task as [`Task::run`] does, with options.
    ///
    /// # Errors
    /// [`NoClips`].
    pub fn run_watched(&self, clips: &[ActorClip], watch: &Watch<'_>) -> Result<TaskOutcome, NoClips> {
        self.check_clips(clips)?;
        let mut stage = Stage::new(self, clips);
        let before = Scenery::of(&stage);
        let trees = Trees::default();
        let mut config =
            CorrectConfig { trees: watch.keeps_trees.then_some(&trees), planners: watch.planners, ..self.config };
        config.budget.seed = watch.seed.unwrap_or(config.budget.seed);
        config.budget.cancel = watch.cancel;
        let is_cancelled = || watch.cancel.is_some_and(|c| c.load(Ordering::Relaxed));
        let mut num_tried = 0;
        let mut order: Vec<usize> = (0..self.steps.len()).collect();
        order.sort_by_key(|i| self.steps[*i].priority);
        let mut done: Vec<Option<Done>> = vec![None; self.steps.len()];
        let (mut failed, mut late) = (Vec::new(), false);
        for round in 0..3 {
            for i in std::mem::take(if round == 0 { &mut order } else { &mut failed }) {
                let mut one = attempt(&mut stage, i, &config, is_cancelled());
                one.trees = trees.take();
                num_tried += 1;
                watch.tell.iter().for_each(|tell| tell(num_tried));
                if one.why.is_some() && round == 0 {
                    failed.push(i);
                }
                late |= round == 1 && one.why.is_none() && self.steps[i].deed != Deed::Correct;
                if let Some(first) = done[i].take().filter(|_| self.steps[i].deed == Deed::Correct) {
                    one.after(first);
                }
                done[i] = Some(one);
            }
            if round == 1 && late {
                // Hands hold other things now than when they were corrected.
                failed = (0..self.steps.len()).filter(|i| self.steps[*i].deed == Deed::Correct).collect();
            }
        }
        let recheck = super::check::check(&stage);
        let attachments = attachments(&stage);
        let done: Vec<Done> = done.into_iter().flatten().collect();
        let events = events(self, &done);
        let scenery = [before, Scenery::of(&stage)];
        let clips = stage.actors.into_iter().map(|a| [a.before, a.clip]).collect();
        Ok(TaskOutcome { clips, done, attachments, events, looks: stage.looked, recheck, scenery })
    }

    /// Collisions of a character's limbs with the scene: each limb, and a stretch of its clip.
    ///
    /// # Errors
    /// [`NoClips`]; invalid problems, as text.
    pub fn collisions(&self, clips: &[ActorClip], who: usize) -> Result<Vec<(Limb, Span)>, Box<dyn std::error::Error>> {
        self.check_clips(clips)?;
        let stage = Stage::new(self, clips);
        let mut out = Vec::new();
        for limb in Limb::ALL {
            let around = stage.around(who, limb, [0.0, stage.actors[who].end_s()]);
            let others = stage.other_bodies(who);
            let problem = crate::problem::Problem::prepare(&stage.spec(who, limb, &around, &others))?;
            out.extend(crate::correct::collisions(&problem).into_iter().map(|span| (limb, span)));
        }
        Ok(out)
    }

    pub(super) fn check_clips(&self, clips: &[ActorClip]) -> Result<(), NoClips> {
        let (expected, found) = (self.characters.len(), clips.len());
        if expected != found {
            return Err(NoClips::Number { expected, found });
        }
        if let Some(step) = self.steps.iter().find(|s| !s.is_timed()) {
            return Err(NoClips::NotWalked { name: self.characters[step.character].name.clone() });
        }
        for (clip, who) in clips.iter().map(|c| &c.clip).zip(&self.characters) {
            let (expected_hz, found_hz) = (clips[0].clip.rate_hz, clip.rate_hz);
            if expected_hz != found_hz {
                return Err(NoClips::Rate { name: who.name.clone(), expected_hz, found_hz });
            }
            if clip.num_frames() < 2 {
                return Err(NoClips::Short { name: who.name.clone(), found: clip.num_frames() });
            }
        }
        Ok(())
    }
}

/// Runs a step, or leaves everything as it was.
fn attempt(stage: &mut Stage<'_>, i: usize, config: &CorrectConfig<'_>, is_cancelled: bool) -> Done {
    let step = &stage.task.steps[i];
    let mut done = Done {
        name: step.name.clone(),
        character: step.character,
        limb: step.limb,
        plans: Vec::new(),
        spans: Vec::new(),
        left: Vec::new(),
        why: None,
        nearest_m: None,
        trees: Vec::new(),
    };
    if is_cancelled {
        return Done { why: Some("cancelled before it was begun".into()), ..done };
    }
    let before = stage.clone();
    match do_step(stage, step, config) {
        Ok((plans, spans)) => (done.plans, done.spans) = (plans, spans),
        Err(Problems { why, nearest_m, plans, spans, left, keep, .. }) => {
            if !keep {
                *stage = before;
                both::stay(stage, step);
            }
            (done.why, done.nearest_m, done.plans) = (Some(why), nearest_m, plans);
            (done.spans, done.left) = (spans, left);
        }
    }
    done
}

/// Nearest distance of a search to a solution (m).
pub(super) fn nearest_of(why: &Unsolved) -> Option<f64> {
    match why {
        Unsolved::Spent { nearest_m, .. } => Some(*nearest_m),
        Unsolved::Cancelled { .. } | Unsolved::Rate => None,
    }
}

fn attachments(stage: &Stage<'_>) -> Vec<Attachment> {
    let mut out = Vec::new();
    for (thing, life) in stage.task.things.iter().zip(&stage.lives) {
        if let [one] = &life[..]
            && matches!(one.at, Whereabouts::Path(_))
        {
            continue;
        }
        for (i, s) in life.iter().enumerate() {
            let to_s = life.get(i + 1).map_or(stage.end_s(), |next| next.from_s);
            let (on, place) = match &s.at {
                Whereabouts::Path(path) => ([None, None, None, None], path.at(s.from_s.max(0.0))),
                Whereabouts::On { character, joint, offset, second, .. } => {
                    let who = stage.task.characters[*character].name.clone();
                    let [joint, second] = [Some(*joint), second.map(|s| hand(s.limb))].map(|j| Some(j?.name().into()));
                    ([Some(who), joint, second, None], *offset)
                }
                Whereabouts::OnThing { thing, offset } => {
                    ([None, None, None, Some(stage.task.things[*thing].name.clone())], *offset)
                }
            };
            let [character, joint, second, on] = on;
            let turn_deg = crate::rotation::log(place.rotation) * (180.0 / std::f64::consts::PI);
            out.push(Attachment {
                object: thing.name.clone(),
                character,
                joint,
                second,
                on,
                from_s: s.from_s.max(0.0),
                to_s,
                at: place.position.to_array(),
                turn_deg: turn_deg.to_array(),
            });
        }
    }
    out
}

fn events(task: &Task, done: &[Done]) -> Vec<Event> {
    let all = task.steps.iter().zip(done).filter(|(_, d)| d.why.is_none());
    let touches = all.filter(|(s, _)| matches!(s.deed, Deed::Touch | Deed::Switch));
    let event = |(s, _): (&super::step::Step, &Done)| {
        Some(Event {
            object: task.things[s.object?].name.clone(),
            what: s.deed.name().into(),
            character: task.characters[s.character].name.clone(),
            at_s: s.times_s[1],
        })
    };
    touches.filter_map(event).collect()
}
