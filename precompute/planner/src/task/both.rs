//! Both hands at one thing: the first one leads, the second one follows it frame by frame.

use super::deeds::{CONTACT_S, Problems, next_with, touch};
use super::entries::Deed;
use super::follow::{Followed, Stuck, free_all_along};
use super::grips::Goal;
use super::run::nearest_of;
use super::stage::{Follower, Pin, Stage, Stretch, Surroundings, Whereabouts, hand};
use super::step::Step;
use super::visit::{Change, TRIES, Visit, beside, first_done, reachable};
use crate::clips::with_motion;
use crate::collide::Checker;
use crate::correct::CorrectConfig;
use crate::ik::LimbIk;
use crate::linkage::{Limb, LimbPose, Linkage};
use crate::manipulate::{NotReached, between, misfit, planned};
use crate::planner::{Budget, LimbMotion, Outcome, Planner};
use crate::problem::{Problem, State};
use crate::rotation::Rigid;
use crate::setup::{Allowed, ProblemSpec, Tether};
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
struct Pair {
    who: usize,
    lead: Limb,
    second: Follower,
}

/// End of a limb's path.
#[derive(Clone, Copy)]
enum End {
    Hand(Rigid),
    /// Back into the clip.
    Clip,
}

/// Moves both hands to a thing, which they take at one moment; they keep it in the trunk's frame until something is done with
/// it.
///
/// - `hands`: goals of the step's limb, and of the second one.
pub(super) fn grab(
    stage: &mut Stage<'_>,
    step: &Step,
    (follow, object): (Limb, usize),
    hands: [&[Goal]; 2],
    config: &CorrectConfig<'_>,
) -> Result<Vec<Outcome>, Problems> {
    let (who, lead, [from_s, at_s, _]) = (step.character, step.limb, step.times_s);
    let second = Visit { limb: follow, ..Visit::of(step) };
    for limb in [lead, follow] {
        is_free(stage, who, limb, [from_s, step.times_s[2]])?;
    }
    let name = stage.task.things[object].name.clone();
    touch(stage, &Step { limb: follow, ..step.clone() }, &name, false);
    hold(stage, who, [lead, follow], &name, at_s - CONTACT_S);
    let there = without(stage.around(who, lead, [from_s, at_s]), follow);
    let firsts = reachable(stage, Visit::of(step), hands[0], &there)?;
    let there = without(stage.around(who, follow, [from_s, at_s]), lead);
    let others = reachable(stage, second, hands[1], &there).map_err(|p| of_limb(p, follow))?;
    let mut pairs: Vec<[usize; 2]> =
        (0..firsts.len().min(TRIES)).flat_map(|i| (0..others.len().min(TRIES)).map(move |k| [i, k])).collect();
    pairs.sort_by_key(|[i, k]| (firsts[*i].rank + others[*k].rank, i + k));
    first_done(stage, pairs.into_iter().take(2 * TRIES), None, |stage, [i, k]| {
        let (first, other) = (firsts[i], others[k]);
        let pair = Pair { who, lead, second: Follower { limb: follow, grip: first.hand.local(other.hand) } };
        take(stage, step, pair, object, [&first, &other], config)
    })
}

fn take(
    stage: &mut Stage<'_>,
    step: &Step,
    pair: Pair,
    object: usize,
    [first, other]: [&Goal; 2],
    config: &CorrectConfig<'_>,
) -> Result<Vec<Outcome>, Problems> {
    let Pair { who, lead, second } = pair;
    let [from_s, at_s, _] = step.times_s;
    let there = without(stage.around(who, lead, [from_s, at_s]), second.limb);
    let mut plans = vec![way(stage, (who, lead), [from_s, at_s], End::Hand(first.hand), &there, None, config)?];
    let there = stage.around(who, second.limb, [from_s, at_s]);
    let one = way(stage, (who, second.limb), [from_s, at_s], End::Hand(other.hand), &there, None, config);
    plans.push(one.map_err(|p| of_limb(p, second.limb))?);
    for (limb, target) in [(lead, first.hand), (second.limb, other.hand)] {
        stage.pins.push(Pin { character: who, limb, time_s: at_s, target });
    }
    beside(stage, (who, lead), object, &first.object, [at_s, until_s(stage, step, object)]);
    let offset = first.hand.local(first.object);
    let at = Whereabouts::On { character: who, joint: hand(lead), offset, holder: Some(lead), second: Some(second) };
    stage.lives[object].push(Stretch { from_s: at_s, at });
    keep(stage, pair, [at_s, until_s(stage, step, object)])?;
    Ok(plans)
}

/// Brings a thing with both hands to the first place for which there is a path that the second hand can follow.
pub(super) fn bring(
    stage: &mut Stage<'_>,
    step: &Step,
    (second, object): (Follower, usize),
    hands: &[Goal],
    change: Option<Change<'_>>,
    config: &CorrectConfig<'_>,
) -> Result<(Vec<Outcome>, Goal), Problems> {
    let pair = Pair { who: step.character, lead: step.limb, second };
    let Pair { who, lead, second } = pair;
    let [from_s, at_s, to_s] = step.times_s;
    for limb in [lead, second.limb] {
        is_free(stage, who, limb, [from_s, to_s])?;
    }
    let name = stage.task.things[object].name.clone();
    let [held, other] = [lead, second.limb].map(|l| stage.actors[who].joint(hand(l), from_s));
    if held.point(second.grip.position).distance(other.position) > HELD_M {
        let limb = second.limb.name().replace('_', " ");
        return Err(Problems::new(format!("{limb} does not hold `{name}` any more at {from_s:.2} s")));
    }
    touch(stage, &Step { limb: second.limb, ..step.clone() }, &name, false);
    let visit = Visit::with(step, hands);
    let there = without(stage.around(who, lead, [from_s, at_s]), second.limb);
    let there = Surroundings { level: visit.level, ..there };
    let within = reachable(stage, visit, hands, &there)?;
    // Goals have to be reachable for the second hand, too.
    let there = without(stage.around(who, second.limb, [from_s, at_s]), lead);
    let there = without_thing(there, &name);
    let visit = Visit { limb: second.limb, ..Visit::of(step) };
    let mut wrong = None;
    let mut goals = Vec::new();
    for goal in within {
        let other = Goal { hand: goal.hand.then(second.grip), ..goal };
        match reachable(stage, visit, &[other], &there) {
            Ok(_) => goals.push(goal),
            Err(e) => _ = wrong.get_or_insert(of_limb(e, second.limb)),
        }
    }
    let all = || goals.iter().take(TRIES).flat_map(|g| (0..SEEDS).map(move |s| (g, s)));
    let tries = [OFF_M, f64::INFINITY].into_iter().flat_map(|off_m| all().map(move |(g, s)| (g, s, off_m)));
    first_done(stage, tries, wrong, |stage, (goal, seed, off_m)| {
        let budget = Budget { seed: config.budget.seed.wrapping_add(seed << 32), ..config.budget };
        let plans = brought(stage, step, pair, object, (goal, off_m), change, &CorrectConfig { budget, ..*config })?;
        Ok((plans, *goal))
    })
}

fn brought(
    stage: &mut Stage<'_>,
    step: &Step,
    pair: Pair,
    object: usize,
    (goal, off_m): (&Goal, f64),
    change: Option<Change<'_>>,
    config: &CorrectConfig<'_>,
) -> Result<Vec<Outcome>, Problems> {
    let Pair { who, lead, second } = pair;
    let [from_s, at_s, to_s] = step.times_s;
    let there = without(stage.around(who, lead, [from_s, at_s]), second.limb);
    let there = Surroundings { level: Visit::with(step, &[*goal]).level, ..there };
    let tether = tether(stage, pair);
    let mut plans = vec![way(stage, (who, lead), [from_s, at_s], End::Hand(goal.hand), &there, Some(tether), config)?];
    follow(stage, pair, [from_s, at_s], off_m)?;
    stage.pins.push(Pin { character: who, limb: lead, time_s: at_s, target: goal.hand });
    let Some(change) = change else {
        keep(stage, pair, [at_s, until_s(stage, step, object)])?;
        return Ok(plans);
    };
    stage.lives[object].push(Stretch { from_s: at_s, at: (change.then)(goal) });
    let_go(stage, pair, at_s + CONTACT_S);
    let back = without(stage.around(who, lead, [at_s, to_s]), second.limb);
    plans.push(way(stage, (who, lead), [at_s, to_s], End::Clip, &back, None, config)?);
    let back = stage.around(who, second.limb, [at_s, to_s]);
    let one = way(stage, (who, second.limb), [at_s, to_s], End::Clip, &back, None, config);
    plans.push(one.map_err(|p| of_limb(p, second.limb))?);
    Ok(plans)
}

/// Plans and writes the path of a limb to an end.
fn way(
    stage: &mut Stage<'_>,
    (who, limb): (usize, Limb),
    window_s: [f64; 2],
    end: End,
    around: &Surroundings,
    tether: Option<Tether>,
    config: &CorrectConfig<'_>,
) -> Result<Outcome, Problems> {
    let others = stage.other_bodies(who);
    let spec = ProblemSpec { tether, ..stage.spec(who, limb, around, &others) };
    let present = window_s.map(|time_s| State { pose: spec.motion.limb_pose(spec.linkage, time_s), time_s });
    let spec = between(&spec, present[0], present[1]);
    let goal = match end {
        End::Clip => present[1],
        End::Hand(target) => {
            let problem = Problem::prepare(&spec).map_err(|e| Problems::new(e.to_string()))?;
            let time_s = window_s[1];
            let reached = problem.reach(&mut Checker::default(), &target, time_s, &problem.present_at(time_s));
            let pose = reached.map_err(|why| Problems::new(NotReached::Target { time_s, why }.to_string()))?;
            State { pose, time_s }
        }
    };
    let what = if matches!(end, End::Clip) { "back" } else { "there" };
    let spec = between(&spec, present[0], goal);
    let done = planned(&stage.actors[who].clip, &mut Planner::new(), &spec, config, what);
    let (clip, outcome) = done.map_err(|e| {
        let nearest_m = if let NotReached::Unsolved { why, .. } = &e { nearest_of(why) } else { None };
        Problems { nearest_m, ..Problems::new(e.to_string()) }
    })?;
    stage.actors[who].change(clip);
    stage.note(who, limb, window_s);
    Ok(outcome)
}

/// Keeps what both hands hold in place to the clip's end, after a step that failed; where that is impossible, the check reports
/// it.
pub(super) fn stay(stage: &mut Stage<'_>, step: &Step) {
    let (who, [from_s, at_s, _]) = (step.character, step.times_s);
    let Some((thing, lead, second)) = stage.held_by_both(who, step.limb, [from_s, at_s]) else { return };
    let is_later = |p: &Pin| p.character == who && [lead, second.limb].contains(&p.limb) && p.time_s > from_s + 1e-6;
    if !step.deed.holds() || stage.pins.iter().any(is_later) {
        return;
    }
    let (end_s, rate_hz) = (stage.actors[who].end_s(), stage.actors[who].clip.rate_hz);
    let from_s = (from_s * rate_hz).round() / rate_hz;
    let mut kept = stage.clone();
    // Contacts of the thing with its support last longer, too.
    let name = &stage.task.things[thing].name;
    let own = kept.contacts.iter_mut().filter(|c| c.0 == who && c.1 == lead && c.2.part.as_ref() == Some(name));
    own.filter_map(|c| c.2.window_s.as_mut()).filter(|w| w[1] >= from_s).for_each(|w| w[1] = f64::INFINITY);
    if from_s < end_s && keep(&mut kept, Pair { who, lead, second }, [from_s, end_s]).is_ok() {
        *stage = kept;
    }
}

/// Keeps the pose of the first arm, while the second one follows.
fn keep(stage: &mut Stage<'_>, pair: Pair, [at_s, until_s]: [f64; 2]) -> Result<(), Problems> {
    let Pair { who, lead, second } = pair;
    let actor = &stage.actors[who];
    let rate_hz = actor.clip.rate_hz;
    let frames = ((until_s - at_s) * rate_hz).round() as usize;
    if frames == 0 {
        return Ok(());
    }
    let pose = actor.motion.limb_pose(Linkage::limb(lead), at_s);
    let kept = vec![pose; frames + 1];
    put(stage, (who, lead), [at_s, until_s], &kept)?;
    let around = without(stage.around(who, lead, [at_s, until_s]), second.limb);
    let others = stage.other_bodies(who);
    let spec = stage.spec(who, lead, &around, &others);
    let ends = [at_s, until_s].map(|time_s| State { pose, time_s });
    let problem = Problem::prepare(&between(&spec, ends[0], ends[1])).map_err(|e| Problems::new(e.to_string()))?;
    free_all_along(&problem, &mut Checker::default(), &kept, at_s, rate_hz).map_err(|(t, with)| {
        Problems::new(format!("what both hands hold meets {with} at {t:.2} s; bring it elsewhere"))
    })?;
    follow(stage, pair, [at_s, until_s], f64::INFINITY)
}

/// Time until which both hands keep their object after a step: the next step with it, on a frame (s).
pub(super) fn until_s(stage: &Stage<'_>, step: &Step, object: usize) -> f64 {
    let (actor, at_s) = (&stage.actors[step.character], step.times_s[1]);
    let next = if step.deed == Deed::Drop || step.deed == Deed::HandOver {
        at_s
    } else {
        next_with(stage, step, object).map_or(actor.end_s(), |n| n.times_s[0].max(at_s))
    };
    (next * actor.clip.rate_hz).round() / actor.clip.rate_hz
}

/// Lets the second hand follow the first one, frame by frame.
///
/// - `most_off_m`: its largest offset between frames, where joints turn evenly.
fn follow(stage: &mut Stage<'_>, pair: Pair, window_s: [f64; 2], most_off_m: f64) -> Result<(), Problems> {
    let Pair { who, lead, second: Follower { limb, grip } } = pair;
    let around = stage.around(who, limb, window_s);
    let others = stage.other_bodies(who);
    let spec = stage.spec(who, limb, &around, &others);
    let ends = window_s.map(|time_s| State { pose: spec.motion.limb_pose(spec.linkage, time_s), time_s });
    let spec = between(&spec, ends[0], ends[1]);
    let problem = Problem::prepare(&spec).map_err(|e| Problems::new(e.to_string()))?;
    let (actor, start_s) = (&stage.actors[who], window_s[0]);
    let rate_hz = actor.clip.rate_hz;
    let frames = 0..=((window_s[1] - start_s) * rate_hz).round() as usize;
    let target = |k: usize| actor.joint(hand(lead), start_s + k as f64 / rate_hz).then(grip);
    let targets: Vec<Rigid> = frames.map(target).collect();
    let cannot = |(t, why): Stuck| {
        let limb = limb.name().replace('_', " ");
        Problems::new(format!("{limb} cannot follow the other hand at {t:.2} s: {why}"))
    };
    let followed = Followed { problem: &problem, targets: &targets, start_s, rate_hz };
    let poses = followed.poses(&ends[0].pose).map_err(cannot)?;
    let (off_m, t) = followed.most_off(&poses, |t| actor.joint(hand(lead), t).then(grip));
    if off_m > most_off_m {
        return Err(cannot((t, format!("it would be off by {off_m:.4} m between frames"))));
    }
    put(stage, (who, limb), window_s, &poses)
}

/// Writes poses into a clip.
fn put(
    stage: &mut Stage<'_>,
    (who, limb): (usize, Limb),
    window_s: [f64; 2],
    frames: &[LimbPose],
) -> Result<(), Problems> {
    let clip = &stage.actors[who].clip;
    let motion = LimbMotion { start_s: window_s[0], step_s: 1.0 / clip.rate_hz, frames };
    let clip = with_motion(clip, 0.0, Linkage::limb(limb), &motion);
    let clip = clip.map_err(|e| Problems::new(misfit(e).to_string()))?;
    stage.actors[who].change(clip);
    stage.note(who, limb, window_s);
    Ok(())
}

/// Constraint of the second hand: its shoulder, its grip and its reach.
fn tether(stage: &Stage<'_>, pair: Pair) -> Tether {
    let actor = &stage.actors[pair.who];
    let linkage = Linkage::limb(pair.second.limb);
    let chain = crate::linkage::Chain::new(linkage, &actor.skeleton);
    let limits = actor.limits.of_linkage(linkage);
    let [nearest, farthest] = limits.map_or([0.0, f64::MAX], |l| LimbIk::new(&chain, &l).distances());
    let distances_m = [nearest, farthest - SPARE_M];
    Tether { from: pair.second.limb.joints()[0], at: pair.second.grip.position, distances_m }
}

/// Allows contacts of both hands and of what they hold from now on.
fn hold(stage: &mut Stage<'_>, who: usize, [lead, follow]: [Limb; 2], name: &str, from_s: f64) {
    let moved = Joint::ALL.into_iter().filter(|j| follow.moves(*j));
    let hands = moved.clone().filter(|j| !follow.joints()[..2].contains(j));
    let of_second = hands.map(|j| (follow, Some(j.name().to_owned()), name.to_owned()));
    // Collisions of the arm with the thing are checked where the second hand follows.
    let of_first = moved.map(|j| (lead, Some(name.to_owned()), j.name().to_owned()));
    let window_s = Some([from_s, f64::INFINITY]);
    let all = of_second.chain(of_first);
    stage.contacts.extend(all.map(|(limb, part, with)| (who, limb, Allowed { part, with, window_s })));
}

/// Ends the contacts of both hands and of what they hold.
fn let_go(stage: &mut Stage<'_>, pair: Pair, to_s: f64) {
    let of_pair = |c: &&mut (usize, Limb, Allowed)| c.0 == pair.who && [pair.lead, pair.second.limb].contains(&c.1);
    let open = stage.contacts.iter_mut().filter(of_pair).filter_map(|c| c.2.window_s.as_mut());
    open.filter(|w| w[1] == f64::INFINITY).for_each(|w| w[1] = to_s);
}

/// Surroundings without the other arm, which is planned after this one and avoids it.
pub(super) fn without(mut around: Surroundings, arm: Limb) -> Surroundings {
    let joints = Joint::ALL.into_iter().filter(|j| arm.moves(*j));
    around.allowed.extend(joints.map(|j| Allowed { part: None, with: j.name().into(), window_s: None }));
    around
}

/// Surroundings without a thing that moves along with the limb.
pub(super) fn without_thing(mut around: Surroundings, name: &str) -> Surroundings {
    around.solids.retain(|s| s.name != name);
    around.allowed.retain(|a| a.with != name && a.part.as_deref() != Some(name));
    around
}

fn is_free(stage: &Stage<'_>, who: usize, limb: Limb, [from_s, to_s]: [f64; 2]) -> Result<(), Problems> {
    let busy = |p: &&Pin| p.character == who && p.limb == limb && p.time_s > from_s + 1e-6 && p.time_s < to_s - 1e-6;
    match stage.pins.iter().find(busy) {
        Some(pin) => {
            let (limb, t) = (limb.name().replace('_', " "), pin.time_s);
            Err(Problems::new(format!("{limb} has to be elsewhere at {t:.2} s; begin then, or end before")))
        }
        None => Ok(()),
    }
}

/// The failure, with the name of the limb.
fn of_limb(problems: Problems, limb: Limb) -> Problems {
    let why = format!("{}: {}", limb.name().replace('_', " "), problems.why);
    Problems { why, ..problems }
}
