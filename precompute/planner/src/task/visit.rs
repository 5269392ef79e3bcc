//! A limb that leaves the clip, reaches a goal, and comes back.

use super::stage::{LimbSurroundings, Pin, PlacementSpan, TaskStage, ThingPlacement};
use super::{CONTACT_S, HandTarget, PlanResult, StepFailure, TaskStep, awkwardness, capsules_around, solve_hands};
use crate::manipulate::{ReachError, ReachTask, reach_target, wrong_times};
use crate::problem::{LimbState, Problem};
use crate::setup::{AllowedContact, ProblemSpec, UprightConstraint};
use crate::{ik::IkError, linkage::Limb, planner::PlanOutcome, rotation::Rigid};
use glam::DVec3;

/// Distance below which something supports a thing, or is beside it: they may touch when it is taken and laid down (m).
const BESIDE_M: f64 = 0.02;
/// Most hands within reach for which plans are tried.
pub(super) const TRIES: usize = 6;

/// Change of a thing's placement when the goal is reached.
#[derive(Clone, Copy)]
pub(super) struct PlacementChange<'a> {
    pub thing: usize,
    /// Placement of the thing afterwards.
    pub placement_after: &'a dyn Fn(&HandTarget) -> ThingPlacement,
}

/// A limb with the times of its path to a goal and back.
#[derive(Clone, Copy)]
pub(super) struct LimbVisit<'a> {
    pub who: usize,
    pub limb: Limb,
    pub times_s: [f64; 3],
    pub hold_s: f64,
    /// Constraint that keeps a held object upright on the way there.
    pub level: Option<UprightConstraint>,
    pub change: Option<PlacementChange<'a>>,
}

/// Plans, and the goal that they reach.
pub(super) type VisitResult = Result<(Vec<PlanOutcome>, HandTarget), StepFailure>;

impl LimbVisit<'_> {
    pub fn from_step(step: &TaskStep) -> Self {
        let &TaskStep { character: who, limb, times_s, hold_s, .. } = step;
        Self { who, limb, times_s, hold_s, level: None, change: None }
    }

    /// The visit of a step with the object in the hand, as goals have it.
    pub fn with_held_object(step: &TaskStep, goals: &[HandTarget]) -> Self {
        let up = goals.first().map(|g| g.hand.to_local(g.object).rotation * DVec3::Y);
        let level = up.zip(step.level_rad).map(|(up, within_rad)| UprightConstraint { up, within_rad });
        Self { level, ..Self::from_step(step) }
    }

    /// Plans the path to a goal and back.
    fn plan(self, stage: &mut TaskStage<'_>, goal: &HandTarget, there: &LimbSurroundings) -> PlanResult {
        let Self { who, limb, times_s, hold_s, change, .. } = self;
        let [from_s, at_s, to_s] = times_s;
        if let Some(change) = change {
            stage.allow_neighbours(who, limb, change.thing, &goal.object, [at_s; 2]);
            stage.placements[change.thing]
                .push(PlacementSpan { from_s: at_s, placement: (change.placement_after)(goal) });
        }
        let back = stage.surroundings_of_limb(who, limb, [at_s, to_s]);
        let others = stage.other_bodies(who);
        let spec = stage.limb_spec(who, limb, there, &others);
        let back_spec = stage.limb_spec(who, limb, &back, &others);
        let task = ReachTask { target: goal.hand, times_s, hold_s, return_spec: &back_spec };
        let (clip, outcomes) = reach_target(&stage.actors[who].clip, &spec, &task, &stage.config)?;
        stage.actors[who].replace_clip(clip);
        stage.record_planned(who, limb, [from_s, at_s]);
        stage.record_planned(who, limb, [at_s, to_s]);
        stage.pins.push(Pin { character: who, limb, time_s: at_s, target: goal.hand });
        Ok(outcomes.to_vec())
    }
}

/// Moves a limb to the first of some goals for which there is a path there and back.
pub(super) fn visit_first_goal(stage: &mut TaskStage<'_>, visit: LimbVisit<'_>, hands: &[HandTarget]) -> VisitResult {
    let LimbVisit { who, limb, times_s: [from_s, at_s, to_s], .. } = visit;
    stage.check_unpinned(who, limb, "the limb", [from_s, to_s])?;
    let there = LimbSurroundings { level: visit.level, ..stage.surroundings_of_limb(who, limb, [from_s, at_s]) };
    let within = reachable_goals(stage, visit, hands, &there)?;
    first_success(stage, within.iter().take(TRIES), None, |stage, goal| Ok((visit.plan(stage, goal, &there)?, *goal)))
}

/// Does the first of some alternatives that succeeds; failed ones change nothing.
///
/// - `wrong`: failure that is reported in place of the first one.
pub(super) fn first_success<'a, C, T>(
    stage: &mut TaskStage<'a>,
    tries: impl Iterator<Item = C>,
    mut wrong: Option<StepFailure>,
    mut does: impl FnMut(&mut TaskStage<'a>, C) -> Result<T, StepFailure>,
) -> Result<T, StepFailure> {
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
    Err(wrong.unwrap_or_else(|| StepFailure::new("there is no grip")))
}

/// Goals that inverse kinematics reaches, the best first.
pub(super) fn reachable_goals(
    stage: &TaskStage<'_>,
    visit: LimbVisit<'_>,
    hands: &[HandTarget],
    there: &LimbSurroundings,
) -> Result<Vec<HandTarget>, StepFailure> {
    let LimbVisit { who, limb, times_s: [from_s, at_s, to_s], .. } = visit;
    let actor = &stage.actors[who];
    if !(from_s >= 0.0 && to_s <= actor.end_s() + 1e-6) {
        return Err(wrong_times(visit.times_s, actor.end_s()).into());
    }
    let others = stage.other_bodies(who);
    let spec = stage.limb_spec(who, limb, there, &others);
    let problem = Problem::prepare(&ProblemSpec { admit_ends: false, ..spec.between_times([from_s, to_s]) })?;
    let (poses, nearest) = solve_hands(&problem, hands, at_s);
    let reached = hands.iter().zip(poses).filter_map(|(goal, pose)| Some((pose?, *goal)));
    let rated = reached.map(|(pose, goal)| {
        let placed = problem.place_chain(&LimbState { pose, time_s: at_s });
        (awkwardness(&problem.chain, &placed, &pose), goal)
    });
    let mut out: Vec<(f64, HandTarget)> = rated.collect();
    if let (true, Some(why)) = (out.is_empty(), nearest) {
        let nearest_m = if let IkError::OutOfReach { by_m } = &why { Some(*by_m) } else { None };
        let is_beyond = nearest_m.is_some();
        return Err(StepFailure { nearest_m, is_beyond, ..ReachError::Target { time_s: at_s, why }.into() });
    }
    out.sort_by(|a, b| a.1.rank.cmp(&b.1.rank).then(a.0.total_cmp(&b.0)));
    Ok(out.into_iter().map(|(_, goal)| goal).collect())
}

impl TaskStage<'_> {
    /// Allows a thing to touch its support, and things beside it, while it is taken or laid down.
    ///
    /// - `at_s`, `until_s`: time at which it is there, and time from which it may be moved away.
    pub fn allow_neighbours(&mut self, who: usize, limb: Limb, thing: usize, place: &Rigid, [at_s, until_s]: [f64; 2]) {
        let own: Vec<_> = self.task.things[thing].shapes.iter().flat_map(capsules_around).collect();
        let window_s = Some([at_s - CONTACT_S, until_s + CONTACT_S]);
        let part = &self.task.things[thing].name;
        for (i, other) in self.task.things.iter().enumerate().filter(|(i, _)| *i != thing) {
            let there = self.thing_place(i, at_s);
            let is_near = other.shapes.iter().any(|shape| {
                own.iter().any(|(core, radius)| {
                    let local = core.map(|p| there.local_point(place.transform_point(p)));
                    shape.distance(&local, radius + BESIDE_M) < radius + BESIDE_M
                })
            });
            let contact = AllowedContact { part: Some(part.clone()), other: other.name.clone(), window_s };
            if is_near && !self.contacts.contains(&(who, limb, contact.clone())) {
                self.contacts.push((who, limb, contact));
            }
        }
    }
}
