//! Execution of one step: a correction, or a limb that goes to a target and comes back.

use super::stage::{TaskStage, ThingPlacement, arm_of_hand, hand_joint};
use super::step::{Anchor, OtherHand, TaskPlace, TaskStep};
use super::visit::{LimbVisit, PlacementChange, visit_first_goal};
use super::{HandTarget, TaskAction, UnresolvedSpan, both_hands, gaze, lean, nearest_distance};
use crate::correct::{CollisionStretch, CorrectConfig, CorrectionError, correct_clip};
use crate::setup::{AllowedContact, ProblemError};
use crate::{collide::Checker, linkage::Limb, manipulate::ReachError, planner::PlanOutcome, problem::Problem};
use crate::{refuse, rotation::Rigid};
use throng_core::Joint;

/// Time before and after it is reached in which a hand may touch its target (s).
pub(super) const CONTACT_S: f64 = 0.25;
/// Rank penalty of goals from which the next step is impossible.
const LATER: usize = 1 << 20;

/// Reason why a step was not done, and the part of it that was.
#[derive(Clone, Debug, Default)]
pub(super) struct StepFailure {
    pub reason: String,
    pub nearest_m: Option<f64>,
    /// True where the target is out of reach by `nearest_m`.
    pub is_beyond: bool,
    pub plans: Vec<PlanOutcome>,
    pub spans: Vec<CollisionStretch>,
    /// Stretches that stay in a collision, and why.
    pub unresolved: Vec<UnresolvedSpan>,
    /// True keeps what was planned: some stretches of a correction.
    pub keep: bool,
}

impl StepFailure {
    pub fn new(why: impl Into<String>) -> Self {
        Self { reason: why.into(), ..Self::default() }
    }

    /// The failure, with the name of its limb.
    pub fn of_limb(self, limb: Limb) -> Self {
        Self { reason: format!("{}: {}", limb.words(), self.reason), ..self }
    }
}

impl From<String> for StepFailure {
    fn from(why: String) -> Self {
        Self::new(why)
    }
}

impl From<ProblemError> for StepFailure {
    fn from(why: ProblemError) -> Self {
        Self::new(why.to_string())
    }
}

impl From<ReachError> for StepFailure {
    fn from(why: ReachError) -> Self {
        let nearest_m = if let ReachError::Unsolved { why, .. } = &why { nearest_distance(why) } else { None };
        Self { nearest_m, ..Self::new(why.to_string()) }
    }
}

/// Result of a step or a part of it, or the reason why it was not done.
pub(super) type Attempt<T> = Result<T, StepFailure>;
/// Plans of a step.
pub(super) type PlanResult = Attempt<Vec<PlanOutcome>>;
/// Plans of a step, and stretches that collided.
type StepResult = Result<(Vec<PlanOutcome>, Vec<CollisionStretch>), StepFailure>;

/// Runs a step; one that fails may leave a part of it done.
pub(super) fn run_step(stage: &mut TaskStage<'_>, step: &TaskStep) -> StepResult {
    stage.config.plan.search.style = step.style;
    // All times are on frames.
    let rate = stage.actors[step.character].clip.rate_hz;
    let step = &TaskStep { times_s: step.times_s.map(|t| (t * rate).round() / rate), ..step.clone() };
    if step.action == TaskAction::Correct {
        return correct_limb(stage, step);
    }
    let leans = stage.task.lean && step.limb.is_arm();
    let before = leans.then(|| stage.clone());
    // Where the target is out of reach, the trunk may help; a little more with each try.
    let did = run_action(stage, step).or_else(|mut without| {
        let by_m = without.nearest_m.filter(|by_m| without.is_beyond && *by_m <= lean::MOST_M);
        let Some((before, by_m)) = before.zip(by_m) else { return Err(without) };
        for spare_m in lean::SPARE_M {
            let mut leaning = before.clone();
            let tried = lean::lean_to_target(&mut leaning, step, by_m + spare_m);
            match tried.and_then(|()| run_action(&mut leaning, step)) {
                Ok(found) => {
                    *stage = leaning;
                    return Ok(found);
                }
                Err(with) if spare_m == lean::SPARE_M[0] => {
                    without.reason = format!("{}; leaning: {}", without.reason, with.reason);
                }
                Err(_) => {}
            }
        }
        Err(without)
    });
    did.map(|plans| (plans, Vec::new()))
}

/// Turns the head to the target, if heads do, and runs an action that is no correction.
fn run_action(stage: &mut TaskStage<'_>, step: &TaskStep) -> PlanResult {
    if stage.task.gaze {
        gaze::look_at_target(stage, step);
    }
    let Some(object) = step.object else { return Err(StepFailure::new("there is no object")) };
    if step.action.needs_held_object() { bring_object(stage, step, object) } else { take_object(stage, step, object) }
}

/// Plans each stretch between the moments at which the limb's place is fixed.
fn correct_limb(stage: &mut TaskStage<'_>, step: &TaskStep) -> StepResult {
    let (who, limb) = (step.character, step.limb);
    let rate = stage.actors[who].clip.rate_hz;
    let end_s = stage.actors[who].end_s();
    let [from, _, to] = step.times_s.map(|t| t.clamp(0.0, end_s));
    let pins = stage.pins.iter().filter(|p| p.character == who && p.limb == limb).map(|p| p.time_s);
    let mut cuts: Vec<f64> = pins.filter(|t| from < *t && *t < to).chain([from, to]).collect();
    cuts.sort_by(f64::total_cmp);
    // Stretches in which both hands hold something are not corrected.
    let is_alone = |w: &&[f64]| stage.held_by_both(who, limb, [w[0], w[1]]).is_none();
    let cuts: Vec<[f64; 2]> = cuts.windows(2).filter(is_alone).map(|w| [w[0], w[1]]).collect();
    let (mut plans, mut spans, mut left) = (Vec::new(), Vec::new(), Vec::new());
    let mut nearest_m: Option<f64> = None;
    for within in cuts.into_iter().filter(|w| w[1] - w[0] > 0.5 / rate) {
        let around = stage.surroundings_of_limb(who, limb, within);
        let others = stage.other_bodies(who);
        let spec = stage.limb_spec(who, limb, &around, &others);
        let config = CorrectConfig { search_window_s: Some(within), ..stage.config };
        let (clip, found) = correct_clip(&stage.actors[who].clip, &spec, &config)?;
        stage.actors[who].replace_clip(clip);
        for one in found {
            match one.outcome {
                Ok(outcome) => {
                    plans.push(outcome);
                    stage.record_planned(who, limb, one.window_s);
                    left.extend(one.driven.into_iter().map(|span| {
                        let why = driven_collision_advice(&span, limb);
                        UnresolvedSpan { span, why, is_driven: true }
                    }));
                }
                Err(e) => {
                    if let CorrectionError::Unsolved { why, .. } = &e {
                        nearest_m = nearest_distance(why);
                    }
                    left.push(UnresolvedSpan { span: one.span.clone(), why: e.to_string(), is_driven: false });
                }
            }
            spans.push(one.span);
        }
    }
    if left.is_empty() {
        return Ok((plans, spans));
    }
    let reason = UnresolvedSpan::describe_all(&left);
    Err(StepFailure { reason, nearest_m, is_beyond: false, plans, spans, unresolved: left, keep: true })
}

/// Advice for a collision of the rest of the body.
fn driven_collision_advice(s: &CollisionStretch, limb: Limb) -> String {
    let CollisionStretch { from_s, to_s, part, with, depth_m } = s;
    let other = Limb::ALL.into_iter().find(|l| Joint::from_name(part).is_some_and(|j| l.moves_joint(j)));
    let way = other.map_or_else(|| format!("move {with}"), |l| format!("correct {} too, or move {with}", l.name()));
    let limb = limb.name();
    format!(
        "{part} itself is {depth_m:.3} m too near {with} from {from_s:.2} s to {to_s:.2} s: no motion of {limb} helps; {way}"
    )
}

/// Moves a limb to an object, and takes it along if that is wanted.
fn take_object(stage: &mut TaskStage<'_>, step: &TaskStep, object: usize) -> PlanResult {
    let (who, limb, at_s) = (step.character, step.limb, step.times_s[1]);
    let name = stage.task.things[object].name.clone();
    let window_s = [step.times_s[0], step.times_s[2]];
    for limb in [Some(limb), step.second.as_ref().map(|s| s.limb)].into_iter().flatten() {
        if step.action == TaskAction::Grab {
            check_free_to_take(stage, step, limb, object)?;
        }
        check_hand_unshared(stage, who, limb, window_s)?;
    }
    let place = stage.thing_place(object, at_s);
    let mut hands = stage.actors[who].hand_targets(limb, &step.grips, &place, at_s);
    rank_by_next_steps(stage, step, limb, object, &mut hands);
    allow_step_contacts(stage, step, &name, step.action != TaskAction::Reach);
    if let Some(second) = &step.second {
        let mut others = stage.actors[who].hand_targets(second.limb, &second.grips, &place, at_s);
        rank_by_next_steps(stage, step, second.limb, object, &mut others);
        return both_hands::grab_with_both(stage, step, second.limb, object, [&hands, &others]);
    }
    let then = move |goal: &HandTarget| goal.placement_in_hand(who, limb, None);
    let change = (step.action == TaskAction::Grab).then_some(PlacementChange { thing: object, placement_after: &then });
    Ok(visit_first_goal(stage, LimbVisit { change, ..LimbVisit::from_step(step) }, &hands)?.0)
}

/// Lowers the rank of grips with which the object cannot be brought to the places of the limb's next steps with it, until it is
/// let go.
///
/// - `limb`: the step's limb, or the second one.
fn rank_by_next_steps(stage: &TaskStage<'_>, step: &TaskStep, limb: Limb, object: usize, hands: &mut [HandTarget]) {
    let after = |last: &&TaskStep| next_with(stage, last, object).filter(|_| last.action == TaskAction::Carry);
    for next in std::iter::successors(next_with(stage, step, object), after) {
        let (Some(to), who, [from_s, then_s, _]) = (next.to, step.character, next.times_s) else { continue };
        let name = &stage.task.things[object].name;
        let mut around = both_hands::exclude_thing(stage.surroundings_of_limb(who, limb, [from_s, then_s]), name);
        if let Some(second) = &step.second {
            around = both_hands::exclude_arm(around, if limb == step.limb { second.limb } else { step.limb });
        }
        let others = stage.other_bodies(who);
        let spec = stage.limb_spec(who, limb, &around, &others);
        let Ok(problem) = Problem::prepare(&spec) else { continue };
        let mut checker = Checker::default();
        let present = problem.external_pose_at(then_s);
        let places = stage.resolve_place(&to, then_s);
        for goal in &mut *hands {
            let grip = goal.object.to_local(goal.hand);
            if !places.iter().any(|p| problem.solve_reach(&mut checker, &p.compose(grip), then_s, &present).is_ok()) {
                goal.rank += LATER;
            }
        }
    }
}

/// The limb's next step with an object that it holds by then.
pub(super) fn next_with<'s>(stage: &TaskStage<'s>, step: &TaskStep, object: usize) -> Option<&'s TaskStep> {
    let (who, limb, at_s) = (step.character, step.limb, step.times_s[1]);
    let is_same = |s: &&TaskStep| (s.object, s.character, s.limb) == (Some(object), who, limb);
    let later = stage.task.steps.iter().filter(|s| s.action.needs_held_object() && s.times_s[1] > at_s);
    later.filter(is_same).min_by(|a, b| a.times_s[1].total_cmp(&b.times_s[1]))
}

/// Fails where the limb holds something together with the other one.
fn check_hand_unshared(stage: &TaskStage<'_>, who: usize, limb: Limb, window_s: [f64; 2]) -> Result<(), StepFailure> {
    let Some((thing, ..)) = stage.held_by_both(who, limb, window_s) else { return Ok(()) };
    let (limb, name, [from_s, to_s]) = (limb.words(), &stage.task.things[thing].name, window_s);
    Err(StepFailure::new(format!(
        "{limb} and the other one hold `{name}` between {from_s:.2} s and {to_s:.2} s; drop it first"
    )))
}

fn check_free_to_take(stage: &TaskStage<'_>, step: &TaskStep, limb: Limb, object: usize) -> Result<(), StepFailure> {
    let (who, at_s) = (step.character, step.times_s[1]);
    let name = &stage.task.things[object].name;
    if let ThingPlacement::OnJoint { character, holder: Some(by), .. } = stage.placement_at(object, at_s) {
        let by = format!("{}'s {}", stage.task.characters[*character].name, by.words());
        return Err(StepFailure::new(format!("`{name}` is held by {by} already; drop it first, or hand it over")));
    }
    if let Some((other, _)) = stage.held_by(who, limb, at_s) {
        let other = &stage.task.things[other].name;
        return Err(StepFailure::new(format!("the hand holds `{other}`; drop it first")));
    }
    check_unused_later(stage, object, at_s)
}

/// Fails where the object is used later: what was planned for later would no longer hold.
fn check_unused_later(stage: &TaskStage<'_>, object: usize, at_s: f64) -> Result<(), StepFailure> {
    let last = stage.placements[object].last().map_or(f64::NEG_INFINITY, |s| s.from_s);
    let (is_late, name) = (last >= at_s, &stage.task.things[object].name);
    let why = "expected tasks of one object in the order of time";
    Ok(refuse(is_late, format_args!("`{name}` changes hands at {last:.2} s: {why}"))?)
}

/// Brings a held object to a place; keeps it, lays it down or gives it away.
fn bring_object(stage: &mut TaskStage<'_>, step: &TaskStep, object: usize) -> PlanResult {
    let (who, limb, at_s) = (step.character, step.limb, step.times_s[1]);
    let name = stage.task.things[object].name.clone();
    let Some((_, offset)) = stage.held_by(who, limb, at_s).filter(|(held, _)| *held == object) else {
        let limb = limb.words();
        return Err(StepFailure::new(format!("{limb} does not hold `{name}` at {at_s:.2} s; let it grab that first")));
    };
    let Some(to) = step.to else { return Err(StepFailure::new("there is no place to bring it to")) };
    check_unused_later(stage, object, at_s)?;
    let goal = |object: Rigid| HandTarget { rank: 0, hand: object.compose(offset.to_local(Rigid::IDENTITY)), object };
    let hands: Vec<HandTarget> = stage.resolve_place(&to, at_s).into_iter().map(goal).collect();
    allow_step_contacts(stage, step, &name, true);
    let both = stage.held_by_both(who, limb, [at_s - 1e-3, at_s]);
    let until_s = if both.is_some() { both_hands::held_until_s(stage, step, object) } else { at_s };
    hands.iter().for_each(|goal| stage.allow_neighbours(who, limb, object, &goal.object, [at_s, until_s]));
    let placement = placement_after_release(stage, &to, object, at_s)?;
    let change = PlacementChange { thing: object, placement_after: &placement };
    let change = (step.action != TaskAction::Carry).then_some(change);
    let (mut plans, given) = match both {
        Some((_, _, second)) => both_hands::bring_with_both(stage, step, second, object, &hands, change)?,
        None => visit_first_goal(stage, LimbVisit { change, ..LimbVisit::with_held_object(step, &hands) }, &hands)?,
    };
    if let (TaskAction::HandOver, Some(receiver)) = (step.action, &step.receiver) {
        // The receiver's grasp replaces its being laid down.
        stage.placements[object].pop();
        let (who, limb) = (receiver.character, receiver.limb);
        check_hand_unshared(stage, who, limb, [step.times_s[1], step.times_s[2]])?;
        let taken = TaskStep { character: who, limb, ..step.clone() };
        let hands = stage.actors[who].hand_targets(limb, &receiver.grips, &given.object, at_s);
        allow_step_contacts(stage, &taken, &name, true);
        allow_handover_contacts(stage, step, receiver, &name);
        let then = |goal: &HandTarget| goal.placement_in_hand(who, limb, None);
        let change = Some(PlacementChange { thing: object, placement_after: &then });
        plans.extend(visit_first_goal(stage, LimbVisit { change, ..LimbVisit::from_step(&taken) }, &hands)?.0);
    }
    Ok(plans)
}

/// Allows both hands to touch an object while it is handed over.
fn allow_handover_contacts(stage: &mut TaskStage<'_>, step: &TaskStep, receiver: &OtherHand, object: &str) {
    let window_s = Some([step.times_s[1] - CONTACT_S, step.times_s[1] + CONTACT_S]);
    let both = [(step.character, step.limb), (receiver.character, receiver.limb)];
    for ([(who, limb), (other, with)], is_one) in [both, [both[1], both[0]]].map(|b| (b, both[0].0 == both[1].0)) {
        let with = if is_one { hand_joint(with).name() } else { &stage.task.characters[other].name };
        let contact = AllowedContact { part: Some(object.into()), other: with.into(), window_s };
        stage.contacts.push((who, limb, contact));
    }
}

/// Placement of a thing once it was let go.
fn placement_after_release(
    stage: &TaskStage<'_>,
    to: &TaskPlace,
    object: usize,
    at_s: f64,
) -> Result<impl Fn(&HandTarget) -> ThingPlacement + use<>, StepFailure> {
    refuse(to.on == Anchor::Thing(object), format_args!("a thing cannot be laid on itself; choose another `on`"))?;
    if let Anchor::Joint(character, joint) = to.on {
        let is_full = arm_of_hand(joint).is_some_and(|l| stage.held_by(character, l, at_s).is_some());
        refuse(is_full, format_args!("that hand holds something already"))?;
    }
    let (on, from) = (to.on, stage.base_of(to, at_s));
    Ok(move |goal: &HandTarget| match on {
        Anchor::World => ThingPlacement::Path(crate::track::RigidPath::Still(goal.object)),
        Anchor::Thing(thing) => ThingPlacement::OnThing { thing, offset: from.to_local(goal.object) },
        Anchor::Joint(character, joint) => {
            let (offset, holder) = (from.to_local(goal.object), arm_of_hand(joint));
            ThingPlacement::OnJoint { character, joint, offset, holder, second: None }
        }
    })
}

/// Allows contacts of a limb, and of what it holds, around the moment of a step.
pub(super) fn allow_step_contacts(stage: &mut TaskStage<'_>, step: &TaskStep, object: &str, with_object: bool) {
    let (who, limb, at_s) = (step.character, step.limb, step.times_s[1]);
    let window_s = Some([at_s - CONTACT_S, at_s + CONTACT_S]);
    let parts = Joint::ALL.into_iter().filter(|j| limb.moves_joint(*j) && !limb.joints()[..2].contains(j));
    let mut add = |part: String, with: &str| {
        stage.contacts.push((who, limb, AllowedContact { part: Some(part), other: with.into(), window_s }));
    };
    for part in parts {
        if with_object {
            add(part.name().into(), object);
        }
        step.contacts.iter().for_each(|c| add(part.name().into(), c));
    }
    step.contacts.iter().for_each(|c| add(object.into(), c));
}
