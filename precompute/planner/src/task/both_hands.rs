//! Both hands at one thing: the first one leads, the second one follows it frame by frame.

use super::actions::{Attempt, CONTACT_S, PlanResult, StepFailure, allow_step_contacts, next_with};
use super::stage::{LimbSurroundings, Pin, PlacementSpan, SecondHand, TaskStage, hand_joint};
use super::visit::{LimbVisit, PlacementChange, TRIES, VisitResult, first_success, reachable_goals};
use super::{FollowError, HandPath, HandTarget, TaskAction, TaskStep};
use crate::linkage::{Limb, LimbPose};
use crate::manipulate::{ReachError, plan_into_clip};
use crate::planner::{LimbMotion, LimbPlanner, PlanOutcome};
use crate::problem::{LimbState, Problem};
use crate::setup::{AllowedContact, ProblemSpec, Tether};
use crate::{clips::with_motion, collide::Checker, ik::LimbIk, refuse, rotation::Rigid};
use throng_core::Joint;

/// Number of paths of the first hand that are tried for one target, each with a seed of its own: the second one cannot follow
/// all.
const SEEDS: u64 = 16;
/// Part of the second arm's reach that is left over along the path (m).
const SPARE_M: f64 = 0.01;

/// Offset of the second hand between frames above which a path is tried after all others (m).
const OFF_M: f64 = 2e-3;

/// Distance of a hand from its grip above which it does not hold the thing (m).
const HELD_M: f64 = 1e-3;

/// A character, and the two hands with which it holds a thing.
#[derive(Clone, Copy)]
struct HandPair {
    who: usize,
    lead: Limb,
    second: SecondHand,
    /// Number of the thing.
    object: usize,
}

/// Path of a limb that is to be planned.
#[derive(Clone, Copy)]
struct LimbPath {
    /// Number of the character.
    who: usize,
    limb: Limb,
    /// Times of its beginning and end (s).
    window_s: [f64; 2],
    /// Transform of the hand at the end; `None` for the path back into the clip.
    goal: Option<Rigid>,
    /// Constraint of the other hand, where it follows.
    tether: Option<Tether>,
}

/// Moves both hands to a thing, which they take at one moment; they keep it in the trunk's frame until something is done with
/// it.
///
/// - `hands`: goals of the step's limb, and of the second one.
pub(super) fn grab_with_both(
    stage: &mut TaskStage<'_>,
    step: &TaskStep,
    follow: Limb,
    object: usize,
    hands: [&[HandTarget]; 2],
) -> PlanResult {
    let (who, lead, [from_s, at_s, _]) = (step.character, step.limb, step.times_s);
    let second = LimbVisit { limb: follow, ..LimbVisit::from_step(step) };
    let check = |limb: Limb| stage.check_unpinned(who, limb, &limb.words(), [from_s, step.times_s[2]]);
    [lead, follow].into_iter().try_for_each(check)?;
    let name = stage.task.things[object].name.clone();
    allow_step_contacts(stage, &TaskStep { limb: follow, ..step.clone() }, &name, false);
    allow_hold_contacts(stage, who, [lead, follow], &name, at_s - CONTACT_S);
    let there = exclude_arm(stage.surroundings_of_limb(who, lead, [from_s, at_s]), follow);
    let firsts = reachable_goals(stage, LimbVisit::from_step(step), hands[0], &there)?;
    let there = exclude_arm(stage.surroundings_of_limb(who, follow, [from_s, at_s]), lead);
    let others = reachable_goals(stage, second, hands[1], &there).map_err(|e| e.of_limb(follow))?;
    let mut pairs: Vec<[usize; 2]> =
        (0..firsts.len().min(TRIES)).flat_map(|i| (0..others.len().min(TRIES)).map(move |k| [i, k])).collect();
    pairs.sort_by_key(|[i, k]| (firsts[*i].rank + others[*k].rank, i + k));
    first_success(stage, pairs.into_iter().take(2 * TRIES), None, |stage, [i, k]| {
        let (first, other) = (firsts[i], others[k]);
        let second = SecondHand { limb: follow, grip: first.hand.to_local(other.hand) };
        let pair = HandPair { who, lead, second, object };
        stage.take_with_both(step, pair, [&first, &other])
    })
}

/// Brings a thing with both hands to the first place for which there is a path that the second hand can follow.
pub(super) fn bring_with_both(
    stage: &mut TaskStage<'_>,
    step: &TaskStep,
    second: SecondHand,
    object: usize,
    hands: &[HandTarget],
    change: Option<PlacementChange<'_>>,
) -> VisitResult {
    let (who, lead) = (step.character, step.limb);
    let pair = HandPair { who, lead, second, object };
    let [from_s, at_s, to_s] = step.times_s;
    let check = |limb: Limb| stage.check_unpinned(who, limb, &limb.words(), [from_s, to_s]);
    [lead, second.limb].into_iter().try_for_each(check)?;
    let name = stage.task.things[object].name.clone();
    let [held, other] = [lead, second.limb].map(|l| stage.actors[who].joint_place(hand_joint(l), from_s));
    let is_off = held.transform_point(second.grip.position).distance(other.position) > HELD_M;
    let limb = second.limb.words();
    refuse(is_off, format_args!("{limb} does not hold `{name}` any more at {from_s:.2} s"))?;
    allow_step_contacts(stage, &TaskStep { limb: second.limb, ..step.clone() }, &name, false);
    let visit = LimbVisit::with_held_object(step, hands);
    let there = exclude_arm(stage.surroundings_of_limb(who, lead, [from_s, at_s]), second.limb);
    let there = LimbSurroundings { level: visit.level, ..there };
    let within = reachable_goals(stage, visit, hands, &there)?;
    // Goals have to be reachable for the second hand, too.
    let there = exclude_arm(stage.surroundings_of_limb(who, second.limb, [from_s, at_s]), lead);
    let there = exclude_thing(there, &name);
    let visit = LimbVisit { limb: second.limb, ..LimbVisit::from_step(step) };
    let mut wrong = None;
    let mut goals = Vec::new();
    for goal in within {
        let other = HandTarget { hand: goal.hand.compose(second.grip), ..goal };
        match reachable_goals(stage, visit, &[other], &there) {
            Ok(_) => goals.push(goal),
            Err(e) => _ = wrong.get_or_insert(e.of_limb(second.limb)),
        }
    }
    let all = || goals.iter().take(TRIES).flat_map(|g| (0..SEEDS).map(move |s| (g, s)));
    let tries = [OFF_M, f64::INFINITY].into_iter().flat_map(|off_m| all().map(move |(g, s)| (g, s, off_m)));
    first_success(stage, tries, wrong, |stage, (goal, seed, off_m)| {
        let first_seed = stage.config.budget.seed;
        stage.config.budget.seed = first_seed.wrapping_add(seed << 32);
        let plans = bring_to_goal(stage, step, pair, goal, off_m, change)?;
        stage.config.budget.seed = first_seed;
        Ok((plans, *goal))
    })
}

fn bring_to_goal(
    stage: &mut TaskStage<'_>,
    step: &TaskStep,
    pair: HandPair,
    goal: &HandTarget,
    off_m: f64,
    change: Option<PlacementChange<'_>>,
) -> PlanResult {
    let HandPair { who, lead, second, object } = pair;
    let [from_s, at_s, to_s] = step.times_s;
    let there = exclude_arm(stage.surroundings_of_limb(who, lead, [from_s, at_s]), second.limb);
    let there = LimbSurroundings { level: LimbVisit::with_held_object(step, &[*goal]).level, ..there };
    let tether = Some(pair_tether(stage, pair));
    let path = LimbPath { who, limb: lead, window_s: [from_s, at_s], goal: Some(goal.hand), tether };
    let mut plans = vec![plan_limb_path(stage, path, &there)?];
    stage.follow_first_hand(pair, [from_s, at_s], off_m)?;
    stage.pins.push(Pin { character: who, limb: lead, time_s: at_s, target: goal.hand });
    let Some(change) = change else {
        hold_pose(stage, pair, [at_s, held_until_s(stage, step, object)])?;
        return Ok(plans);
    };
    stage.placements[object].push(PlacementSpan { from_s: at_s, placement: (change.placement_after)(goal) });
    end_hold_contacts(stage, pair, at_s + CONTACT_S);
    let back = exclude_arm(stage.surroundings_of_limb(who, lead, [at_s, to_s]), second.limb);
    let path = LimbPath { window_s: [at_s, to_s], goal: None, tether: None, ..path };
    plans.push(plan_limb_path(stage, path, &back)?);
    let back = stage.surroundings_of_limb(who, second.limb, [at_s, to_s]);
    let one = plan_limb_path(stage, LimbPath { limb: second.limb, ..path }, &back);
    plans.push(one.map_err(|e| e.of_limb(second.limb))?);
    Ok(plans)
}

/// Plans and writes the path of a limb to an end.
fn plan_limb_path(stage: &mut TaskStage<'_>, path: LimbPath, around: &LimbSurroundings) -> Attempt<PlanOutcome> {
    let LimbPath { who, limb, window_s, goal, tether } = path;
    let others = stage.other_bodies(who);
    let spec = ProblemSpec { tether, ..stage.limb_spec(who, limb, around, &others) }.between_times(window_s);
    let mut end = spec.goal;
    if let Some(target) = goal {
        let (problem, time_s) = (Problem::prepare(&spec)?, end.time_s);
        let present = problem.external_pose_at(time_s);
        let reached = problem.solve_reach(&mut Checker::default(), &target, time_s, &present);
        end.pose = reached.map_err(|why| ReachError::Target { time_s, why })?;
    }
    let what = if goal.is_none() { "back" } else { "there" };
    let spec = spec.between([spec.init, end]);
    let (clip, outcome) = plan_into_clip(&stage.actors[who].clip, &mut LimbPlanner::new(), &spec, &stage.config, what)?;
    stage.actors[who].replace_clip(clip);
    stage.record_planned(who, limb, window_s);
    Ok(outcome)
}

/// Keeps what both hands hold in place to the clip's end, after a step that failed; where that is impossible, the check reports
/// it.
pub(super) fn hold_until_end(stage: &mut TaskStage<'_>, step: &TaskStep) {
    let (who, [from_s, at_s, _]) = (step.character, step.times_s);
    let Some((thing, lead, second)) = stage.held_by_both(who, step.limb, [from_s, at_s]) else { return };
    let is_later = |p: &Pin| p.character == who && [lead, second.limb].contains(&p.limb) && p.time_s > from_s + 1e-6;
    if !step.action.needs_held_object() || stage.pins.iter().any(is_later) {
        return;
    }
    let (end_s, rate_hz) = (stage.actors[who].end_s(), stage.actors[who].clip.rate_hz);
    let from_s = (from_s * rate_hz).round() / rate_hz;
    let mut kept = stage.clone();
    // Contacts of the thing with its support last longer, too.
    let name = &stage.task.things[thing].name;
    let own = kept.contacts.iter_mut().filter(|c| c.0 == who && c.1 == lead && c.2.part.as_ref() == Some(name));
    own.filter_map(|c| c.2.window_s.as_mut()).filter(|w| w[1] >= from_s).for_each(|w| w[1] = f64::INFINITY);
    if from_s < end_s && hold_pose(&mut kept, HandPair { who, lead, second, object: thing }, [from_s, end_s]).is_ok() {
        *stage = kept;
    }
}

/// Keeps the pose of the first arm, while the second one follows.
fn hold_pose(stage: &mut TaskStage<'_>, pair: HandPair, [at_s, until_s]: [f64; 2]) -> Result<(), StepFailure> {
    let HandPair { who, lead, second, .. } = pair;
    let actor = &stage.actors[who];
    let rate_hz = actor.clip.rate_hz;
    let frames = ((until_s - at_s) * rate_hz).round() as usize;
    if frames == 0 {
        return Ok(());
    }
    let pose = actor.motion.limb_pose(lead, at_s);
    let kept = vec![pose; frames + 1];
    stage.write_frames(who, lead, [at_s, until_s], &kept)?;
    let around = exclude_arm(stage.surroundings_of_limb(who, lead, [at_s, until_s]), second.limb);
    let others = stage.other_bodies(who);
    let spec = stage.limb_spec(who, lead, &around, &others);
    let ends = [at_s, until_s].map(|time_s| LimbState { pose, time_s });
    let problem = Problem::prepare(&spec.between(ends))?;
    let path = HandPath { problem: &problem, targets: &[], start_s: at_s, rate_hz };
    path.check_free_all_along(&mut Checker::default(), &kept).map_err(|(t, with)| {
        StepFailure::new(format!("what both hands hold meets {with} at {t:.2} s; bring it elsewhere"))
    })?;
    stage.follow_first_hand(pair, [at_s, until_s], f64::INFINITY)
}

/// Time until which both hands keep their object after a step: the next step with it, on a frame (s).
pub(super) fn held_until_s(stage: &TaskStage<'_>, step: &TaskStep, object: usize) -> f64 {
    let (actor, at_s) = (&stage.actors[step.character], step.times_s[1]);
    let next = match step.action {
        TaskAction::Drop | TaskAction::HandOver => at_s,
        _ => next_with(stage, step, object).map_or(actor.end_s(), |n| n.times_s[0].max(at_s)),
    };
    (next * actor.clip.rate_hz).round() / actor.clip.rate_hz
}

/// Constraint of the second hand: its shoulder, its grip and its reach.
fn pair_tether(stage: &TaskStage<'_>, pair: HandPair) -> Tether {
    let actor = &stage.actors[pair.who];
    let SecondHand { limb, grip } = pair.second;
    let chain = crate::linkage::Chain::new(limb, &actor.skeleton);
    let limits = actor.limits.limb_limits(limb);
    let [nearest, farthest] = limits.map_or([0.0, f64::MAX], |l| LimbIk::new(&chain, &l).reach_distances());
    let distances_m = [nearest, farthest - SPARE_M];
    Tether { from: limb.joints()[0], wrist: grip.position, distances_m }
}

/// Allows contacts of both hands and of what they hold from now on.
fn allow_hold_contacts(stage: &mut TaskStage<'_>, who: usize, [lead, follow]: [Limb; 2], name: &str, from_s: f64) {
    let moved = Joint::ALL.into_iter().filter(|j| follow.moves_joint(*j));
    let hands = moved.clone().filter(|j| !follow.joints()[..2].contains(j));
    let of_second = hands.map(|j| (follow, Some(j.name().to_owned()), name.to_owned()));
    // Collisions of the arm with the thing are checked where the second hand follows.
    let of_first = moved.map(|j| (lead, Some(name.to_owned()), j.name().to_owned()));
    let window_s = Some([from_s, f64::INFINITY]);
    let all = of_second.chain(of_first);
    stage.contacts.extend(all.map(|(limb, part, with)| (who, limb, AllowedContact { part, other: with, window_s })));
}

/// Ends the contacts of both hands and of what they hold.
fn end_hold_contacts(stage: &mut TaskStage<'_>, pair: HandPair, to_s: f64) {
    let hands = [pair.lead, pair.second.limb];
    let of_pair = stage.contacts.iter_mut().filter(|c| c.0 == pair.who && hands.contains(&c.1));
    let open = of_pair.filter_map(|c| c.2.window_s.as_mut()).filter(|w| w[1] == f64::INFINITY);
    open.for_each(|w| w[1] = to_s);
}

/// Surroundings without the other arm, which is planned after this one and avoids it.
pub(super) fn exclude_arm(mut around: LimbSurroundings, arm: Limb) -> LimbSurroundings {
    let joints = Joint::ALL.into_iter().filter(|j| arm.moves_joint(*j));
    around.allowed.extend(joints.map(|j| AllowedContact { part: None, other: j.name().into(), window_s: None }));
    around
}

/// Surroundings without a thing that moves along with the limb.
pub(super) fn exclude_thing(mut around: LimbSurroundings, name: &str) -> LimbSurroundings {
    around.solids.retain(|s| s.name != name);
    around.allowed.retain(|a| a.other != name && a.part.as_deref() != Some(name));
    around
}

impl TaskStage<'_> {
    /// Moves both hands to their goals at a thing, which they then hold.
    fn take_with_both(&mut self, step: &TaskStep, pair: HandPair, [first, other]: [&HandTarget; 2]) -> PlanResult {
        let HandPair { who, lead, second, object } = pair;
        let [from_s, at_s, _] = step.times_s;
        let there = exclude_arm(self.surroundings_of_limb(who, lead, [from_s, at_s]), second.limb);
        let path = LimbPath { who, limb: lead, window_s: [from_s, at_s], goal: Some(first.hand), tether: None };
        let mut plans = vec![plan_limb_path(self, path, &there)?];
        let there = self.surroundings_of_limb(who, second.limb, [from_s, at_s]);
        let path = LimbPath { limb: second.limb, goal: Some(other.hand), ..path };
        plans.push(plan_limb_path(self, path, &there).map_err(|e| e.of_limb(second.limb))?);
        let pin = |(limb, target)| Pin { character: who, limb, time_s: at_s, target };
        self.pins.extend([(lead, first.hand), (second.limb, other.hand)].map(pin));
        self.allow_neighbours(who, lead, object, &first.object, [at_s, held_until_s(self, step, object)]);
        let placement = first.placement_in_hand(who, lead, Some(second));
        self.placements[object].push(PlacementSpan { from_s: at_s, placement });
        hold_pose(self, pair, [at_s, held_until_s(self, step, object)])?;
        Ok(plans)
    }

    /// Lets the second hand follow the first one, frame by frame.
    ///
    /// - `most_off_m`: its largest offset between frames, where joints turn evenly.
    fn follow_first_hand(&mut self, pair: HandPair, window_s: [f64; 2], most_off_m: f64) -> Result<(), StepFailure> {
        let HandPair { who, lead, second: SecondHand { limb, grip }, .. } = pair;
        let problem = self.limb_problem(who, limb, &self.surroundings_of_limb(who, limb, window_s), window_s)?;
        let (actor, start_s) = (&self.actors[who], window_s[0]);
        let rate_hz = actor.clip.rate_hz;
        let target = |time_s: f64| actor.joint_place(hand_joint(lead), time_s).compose(grip);
        let frames = 0..=((window_s[1] - start_s) * rate_hz).round() as usize;
        let targets: Vec<Rigid> = frames.map(|k| target(start_s + k as f64 / rate_hz)).collect();
        let cannot = |(t, why): FollowError| {
            StepFailure::new(format!("{} cannot follow the other hand at {t:.2} s: {why}", limb.words()))
        };
        let followed = HandPath { problem: &problem, targets: &targets, start_s, rate_hz };
        let poses = followed.poses(&problem.init.pose).map_err(cannot)?;
        let (off_m, t) = followed.largest_offset(&poses, target);
        if off_m > most_off_m {
            return Err(cannot((t, format!("it would be off by {off_m:.4} m between frames"))));
        }
        self.write_frames(who, limb, window_s, &poses)
    }

    /// Writes poses into a clip.
    fn write_frames(&mut self, who: usize, limb: Limb, window_s: [f64; 2], frames: &[LimbPose]) -> Attempt<()> {
        let clip = &self.actors[who].clip;
        let motion = LimbMotion { start_s: window_s[0], step_s: 1.0 / clip.rate_hz, frames };
        let clip = with_motion(clip, 0.0, limb, &motion)?;
        self.actors[who].replace_clip(clip);
        self.record_planned(who, limb, window_s);
        Ok(())
    }
}
