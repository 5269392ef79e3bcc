//! A limb that leaves the clip, reaches a goal, and comes back.

use super::deeds::{CONTACT_S, Problems};
use super::grips::{Goal, awkwardness};
use super::held::capsules;
use super::run::nearest_of;
use super::stage::{Pin, Stage, Stretch, Surroundings, Whereabouts};
use super::step::Step;
use crate::collide::Checker;
use crate::correct::CorrectConfig;
use crate::ik::Unreached;
use crate::linkage::Limb;
use crate::manipulate::{NotReached, Reach, reach};
use crate::planner::Outcome;
use crate::problem::{Problem, State};
use crate::rotation::Rigid;
use crate::setup::{Allowed, Level};
use glam::DVec3;

/// Distance below which something supports a thing, or is beside it: they may touch when it is taken and laid down (m).
const BESIDE_M: f64 = 0.02;
/// Most hands within reach for which plans are tried.
pub(super) const TRIES: usize = 6;

/// Change of a thing's placement when the goal is reached.
#[derive(Clone, Copy)]
pub(super) struct Change<'a> {
    pub thing: usize,
    /// Placement of the thing afterwards.
    pub then: &'a dyn Fn(&Goal) -> Whereabouts,
}

/// A limb with the times of its path to a goal and back.
#[derive(Clone, Copy)]
pub(super) struct Visit {
    pub who: usize,
    pub limb: Limb,
    pub times_s: [f64; 3],
    pub hold_s: f64,
    /// Constraint that keeps a held object upright on the way there.
    pub level: Option<Level>,
}

impl Visit {
    pub fn of(step: &Step) -> Self {
        Self { who: step.character, limb: step.limb, times_s: step.times_s, hold_s: step.hold_s, level: None }
    }

    /// The visit of a step with the object in the hand, as goals have it.
    pub fn with(step: &Step, goals: &[Goal]) -> Self {
        let up = goals.first().map(|g| g.hand.local(g.object).rotation * DVec3::Y);
        let level = up.zip(step.level_rad).map(|(up, within_rad)| Level { up, within_rad });
        Self { level, ..Self::of(step) }
    }
}

/// Moves a limb to the first of some goals for which there is a path there and back.
pub(super) fn go(
    stage: &mut Stage<'_>,
    visit: Visit,
    hands: &[Goal],
    change: Option<Change<'_>>,
    config: &CorrectConfig<'_>,
) -> Result<(Vec<Outcome>, Goal), Problems> {
    let Visit { who, limb, times_s: [from_s, at_s, to_s], .. } = visit;
    let busy = |p: &&Pin| p.character == who && p.limb == limb && p.time_s > from_s + 1e-6 && p.time_s < to_s - 1e-6;
    if let Some(pin) = stage.pins.iter().find(busy) {
        let t = pin.time_s;
        return Err(Problems::new(format!("the limb has to be elsewhere at {t:.2} s; begin then, or end before")));
    }
    let there = Surroundings { level: visit.level, ..stage.around(who, limb, [from_s, at_s]) };
    let within = reachable(stage, visit, hands, &there)?;
    first_done(stage, within.iter().take(TRIES), None, |stage, goal| {
        Ok((plan(stage, visit, goal, change, &there, config)?, *goal))
    })
}

/// Does the first of some alternatives that succeeds; failed ones change nothing.
///
/// - `wrong`: failure that is reported in place of the first one.
pub(super) fn first_done<'a, C, T>(
    stage: &mut Stage<'a>,
    tries: impl Iterator<Item = C>,
    mut wrong: Option<Problems>,
    mut does: impl FnMut(&mut Stage<'a>, C) -> Result<T, Problems>,
) -> Result<T, Problems> {
    for one in tries {
        let mut tried = stage.clone();
        match does(&mut tried, one) {
            Ok(done) => {
                *stage = tried;
                return Ok(done);
            }
            Err(e) => _ = wrong.get_or_insert(e),
        }
    }
    Err(wrong.unwrap_or_else(|| Problems::new("there is no grip")))
}

/// Goals that inverse kinematics reaches, the best first.
pub(super) fn reachable(
    stage: &Stage<'_>,
    visit: Visit,
    hands: &[Goal],
    there: &Surroundings,
) -> Result<Vec<Goal>, Problems> {
    let Visit { who, limb, times_s: [from_s, at_s, to_s], .. } = visit;
    let actor = &stage.actors[who];
    if !(from_s >= 0.0 && to_s <= actor.end_s() + 1e-6) {
        let times = NotReached::Times { times_s: [from_s, at_s, to_s], end_s: actor.end_s() };
        return Err(Problems::new(times.to_string()));
    }
    let others = stage.other_bodies(who);
    let spec = stage.spec(who, limb, there, &others);
    let ends = [from_s, to_s].map(|time_s| State { pose: actor.motion.limb_pose(spec.linkage, time_s), time_s });
    let [init, goal] = ends;
    let spec = crate::setup::ProblemSpec { init, goal, ..spec };
    let problem = Problem::prepare(&spec).map_err(|e| Problems::new(e.to_string()))?;
    let mut checker = Checker::default();
    let present = problem.present_at(at_s);
    let mut out: Vec<(f64, Goal)> = Vec::new();
    let mut nearest: Option<Unreached<String>> = None;
    for goal in hands {
        match problem.reach(&mut checker, &goal.hand, at_s, &present) {
            Ok(pose) => {
                let placed = problem.place(&State { pose, time_s: at_s });
                out.push((awkwardness(problem.chain(), &placed, &pose), *goal));
            }
            Err(why) => {
                if nearest.as_ref().is_none_or(|n| why.farness() < n.farness()) {
                    nearest = Some(why);
                }
            }
        }
    }
    if let (true, Some(why)) = (out.is_empty(), nearest) {
        let nearest_m = if let Unreached::OutOfReach { by_m } = &why { Some(*by_m) } else { None };
        let why = NotReached::Target { time_s: at_s, why }.to_string();
        return Err(Problems { nearest_m, is_beyond: nearest_m.is_some(), ..Problems::new(why) });
    }
    out.sort_by(|a, b| a.1.rank.cmp(&b.1.rank).then(a.0.total_cmp(&b.0)));
    Ok(out.into_iter().map(|(_, goal)| goal).collect())
}

fn plan(
    stage: &mut Stage<'_>,
    visit: Visit,
    goal: &Goal,
    change: Option<Change<'_>>,
    there: &Surroundings,
    config: &CorrectConfig<'_>,
) -> Result<Vec<Outcome>, Problems> {
    let Visit { who, limb, times_s, hold_s, .. } = visit;
    let [from_s, at_s, to_s] = times_s;
    if let Some(change) = change {
        beside(stage, (who, limb), change.thing, &goal.object, [at_s; 2]);
        stage.lives[change.thing].push(Stretch { from_s: at_s, at: (change.then)(goal) });
    }
    let back = stage.around(who, limb, [at_s, to_s]);
    let others = stage.other_bodies(who);
    let spec = stage.spec(who, limb, there, &others);
    let back_spec = stage.spec(who, limb, &back, &others);
    let task = Reach { targets: std::slice::from_ref(&goal.hand), times_s, hold_s, back: Some(&back_spec) };
    let (clip, reached) = reach(&stage.actors[who].clip, &spec, &task, config).map_err(|e| {
        let nearest_m = match &e {
            NotReached::Unsolved { why, .. } => nearest_of(why),
            _ => None,
        };
        Problems { nearest_m, ..Problems::new(e.to_string()) }
    })?;
    stage.actors[who].change(clip);
    stage.note(who, limb, [from_s, at_s]);
    stage.note(who, limb, [at_s, to_s]);
    stage.pins.push(Pin { character: who, limb, time_s: at_s, target: goal.hand });
    Ok(reached.outcomes.to_vec())
}

/// Allows a thing to touch its support, and things beside it, while it is taken or laid down.
///
/// - `at_s`, `until_s`: time at which it is there, and time from which it may be moved away.
pub(super) fn beside(
    stage: &mut Stage<'_>,
    (who, limb): (usize, Limb),
    thing: usize,
    place: &Rigid,
    [at_s, until_s]: [f64; 2],
) {
    let own: Vec<_> = stage.task.things[thing].shapes.iter().flat_map(capsules).collect();
    let mut names = Vec::new();
    for (i, other) in stage.task.things.iter().enumerate().filter(|(i, _)| *i != thing) {
        let there = stage.place(i, at_s);
        let is_near = other.shapes.iter().any(|shape| {
            own.iter().any(|(core, radius)| {
                let local = core.map(|p| there.local_point(place.point(p)));
                shape.distance(&local, radius + BESIDE_M) < radius + BESIDE_M
            })
        });
        if is_near {
            names.push(other.name.clone());
        }
    }
    let window_s = Some([at_s - CONTACT_S, until_s + CONTACT_S]);
    let part = stage.task.things[thing].name.clone();
    for with in names {
        let contact = (who, limb, Allowed { part: Some(part.clone()), with, window_s });
        if !stage.contacts.contains(&contact) {
            stage.contacts.push(contact);
        }
    }
}
