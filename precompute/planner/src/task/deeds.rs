//! Execution of one step: a correction, or a limb that goes to a target and comes back.

use super::both;
use super::entries::Deed;
use super::gaze;
use super::grips::{Goal, goals};
use super::lean;
use super::run::{Left, nearest_of};
use super::stage::{Stage, Whereabouts, hand};
use super::step::{Anchor, Place, Receiver, Step};
use super::visit::{Change, Visit, beside, go};
use crate::collide::Checker;
use crate::correct::{CorrectConfig, NotCorrected, Span, correct};
use crate::linkage::Limb;
use crate::planner::Outcome;
use crate::problem::Problem;
use crate::rotation::Rigid;
use crate::setup::Allowed;
use throng_core::Joint;

/// Time before and after it is reached in which a hand may touch its target (s).
pub(super) const CONTACT_S: f64 = 0.25;
/// Rank penalty of goals from which the next step is impossible.
const LATER: usize = 1 << 20;

/// Reason why a step was not done, and the part of it that was.
#[derive(Clone, Debug)]
pub(super) struct Problems {
    pub why: String,
    pub nearest_m: Option<f64>,
    /// True where the target is out of reach by `nearest_m`.
    pub is_beyond: bool,
    pub plans: Vec<Outcome>,
    pub spans: Vec<Span>,
    /// Stretches that stay in a collision, and why.
    pub left: Vec<Left>,
    /// True keeps what was planned: some stretches of a correction.
    pub keep: bool,
}

impl Problems {
    pub fn new(why: impl Into<String>) -> Self {
        Self {
            why: why.into(),
            nearest_m: None,
            is_beyond: false,
            plans: Vec::new(),
            spans: Vec::new(),
            left: Vec::new(),
            keep: false,
        }
    }
}

type Did = Result<(Vec<Outcome>, Vec<Span>), Problems>;

/// Runs a step; one that fails may leave a part of it done.
pub(super) fn do_step(stage: &mut Stage<'_>, step: &Step, config: &CorrectConfig<'_>) -> Did {
    let mut config = *config;
    config.plan.search.style = step.style;
    // All times are on frames.
    let rate = stage.actors[step.character].clip.rate_hz;
    let step = &Step { times_s: step.times_s.map(|t| (t * rate).round() / rate), ..step.clone() };
    if step.deed == Deed::Correct {
        return corrected(stage, step, &config);
    }
    let leans = stage.task.lean && step.limb.is_arm();
    let before = leans.then(|| stage.clone());
    let mut did = reached(stage, step, &config);
    // Where the target is out of reach, the trunk may help; a little more with each try.
    let (Some(before), Some(by_m)) = (before, did.as_ref().err().filter(|p| p.is_beyond).and_then(|p| p.nearest_m))
    else {
        return did;
    };
    if by_m > lean::MOST_M {
        return did;
    }
    for spare_m in lean::SPARE_M {
        let mut leaning = before.clone();
        let tried = lean::lean(&mut leaning, step, by_m + spare_m).and_then(|()| reached(&mut leaning, step, &config));
        match (tried, &mut did) {
            (Ok(found), _) => {
                *stage = leaning;
                return Ok(found);
            }
            (Err(with), Err(without)) if spare_m == lean::SPARE_M[0] => {
                without.why = format!("{}; leaning: {}", without.why, with.why);
            }
            (Err(_), _) => {}
        }
    }
    did
}

/// Turns the head to the target, if heads do, and runs the action.
fn reached(stage: &mut Stage<'_>, step: &Step, config: &CorrectConfig<'_>) -> Did {
    if stage.task.gaze {
        gaze::look(stage, step);
    }
    match (step.deed, step.object) {
        (_, None) => Err(Problems::new("there is no object")),
        (Deed::Carry | Deed::Drop | Deed::HandOver, Some(object)) => bring(stage, step, object, config),
        (_, Some(object)) => take(stage, step, object, config),
    }
}

/// Plans each stretch between the moments at which the limb's place is fixed.
fn corrected(stage: &mut Stage<'_>, step: &Step, config: &CorrectConfig<'_>) -> Did {
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
        let around = stage.around(who, limb, within);
        let others = stage.other_bodies(who);
        let spec = stage.spec(who, limb, &around, &others);
        let config = CorrectConfig { within_s: Some(within), ..*config };
        let (clip, found) =
            correct(&stage.actors[who].clip, &spec, &config).map_err(|e| Problems::new(e.to_string()))?;
        stage.actors[who].change(clip);
        for one in found {
            match one.outcome {
                Ok(outcome) => {
                    plans.push(outcome);
                    stage.note(who, limb, one.window_s);
                    let stays = |s: Span| Left { why: no_help(&s, limb), span: s, is_driven: true };
                    left.extend(one.driven.into_iter().map(stays));
                }
                Err(e) => {
                    if let NotCorrected::Unsolved { why, .. } = &e {
                        nearest_m = nearest_of(why);
                    }
                    left.push(Left { span: one.span.clone(), why: e.to_string(), is_driven: false });
                }
            }
            spans.push(one.span);
        }
    }
    if left.is_empty() {
        return Ok((plans, spans));
    }
    Err(Problems { why: Left::why(&left), nearest_m, is_beyond: false, plans, spans, left, keep: true })
}

/// Advice for a collision of the rest of the body.
fn no_help(s: &Span, limb: Limb) -> String {
    let Span { from_s, to_s, part, with, depth_m } = s;
    let other = Limb::ALL.into_iter().find(|l| Joint::from_name(part).is_some_and(|j| l.moves(j)));
    let way = other.map_or_else(|| format!("move {with}"), |l| format!("correct {} too, or move {with}", l.name()));
    let limb = limb.name();
    format!(
        "{part} itself is {depth_m:.3} m too near {with} from {from_s:.2} s to {to_s:.2} s: no motion of {limb} helps; {way}"
    )
}

/// Moves a limb to an object, and takes it along if that is wanted.
fn take(stage: &mut Stage<'_>, step: &Step, object: usize, config: &CorrectConfig<'_>) -> Did {
    let (who, limb, at_s) = (step.character, step.limb, step.times_s[1]);
    let name = stage.task.things[object].name.clone();
    let window_s = [step.times_s[0], step.times_s[2]];
    for limb in [Some(limb), step.second.as_ref().map(|s| s.limb)].into_iter().flatten() {
        if step.deed == Deed::Grab {
            free_to_take(stage, step, limb, object)?;
        }
        alone(stage, who, limb, window_s)?;
    }
    let place = stage.place(object, at_s);
    let mut hands = goals(&step.grips, &place, &stage.actors[who], limb, at_s);
    look_ahead(stage, step, limb, object, &mut hands);
    touch(stage, step, &name, step.deed != Deed::Reach);
    if let Some(second) = &step.second {
        let mut others = goals(&second.grips, &place, &stage.actors[who], second.limb, at_s);
        look_ahead(stage, step, second.limb, object, &mut others);
        return Ok((both::grab(stage, step, (second.limb, object), [&hands, &others], config)?, Vec::new()));
    }
    let then = move |goal: &Goal| held(who, limb, goal);
    let change = (step.deed == Deed::Grab).then_some(Change { thing: object, then: &then });
    let (plans, _) = go(stage, Visit::of(step), &hands, change, config)?;
    Ok((plans, Vec::new()))
}

/// Lowers the rank of grips with which the object cannot be brought to the places of the limb's next steps with it, until it is
/// let go.
///
/// - `limb`: the step's limb, or the second one.
fn look_ahead(stage: &Stage<'_>, step: &Step, limb: Limb, object: usize, hands: &mut [Goal]) {
    let mut last = step;
    while let Some(next) = next_with(stage, last, object) {
        look_ahead_to(stage, step, next, limb, object, hands);
        if next.deed != Deed::Carry {
            break;
        }
        last = next;
    }
}

fn look_ahead_to(stage: &Stage<'_>, step: &Step, next: &Step, limb: Limb, object: usize, hands: &mut [Goal]) {
    let (Some(to), who, [from_s, then_s, _]) = (next.to, step.character, next.times_s) else { return };
    let name = &stage.task.things[object].name;
    let mut around = both::without_thing(stage.around(who, limb, [from_s, then_s]), name);
    if let Some(second) = &step.second {
        around = both::without(around, if limb == step.limb { second.limb } else { step.limb });
    }
    let others = stage.other_bodies(who);
    let spec = stage.spec(who, limb, &around, &others);
    let Ok(problem) = Problem::prepare(&spec) else { return };
    let mut checker = Checker::default();
    let present = problem.present_at(then_s);
    let places = stage.resolve(&to, then_s);
    for goal in hands {
        let grip = goal.object.local(goal.hand);
        if !places.iter().any(|p| problem.reach(&mut checker, &p.then(grip), then_s, &present).is_ok()) {
            goal.rank += LATER;
        }
    }
}

/// The limb's next step with an object that it holds by then.
pub(super) fn next_with<'s>(stage: &Stage<'s>, step: &Step, object: usize) -> Option<&'s Step> {
    let (who, limb, at_s) = (step.character, step.limb, step.times_s[1]);
    let is_next = |s: &&Step| {
        s.deed.holds() && (s.object, s.character, s.limb) == (Some(object), who, limb) && s.times_s[1] > at_s
    };
    stage.task.steps.iter().filter(is_next).min_by(|a, b| a.times_s[1].total_cmp(&b.times_s[1]))
}

/// Placement of a thing in the hand of a goal.
pub(super) fn held(character: usize, limb: Limb, goal: &Goal) -> Whereabouts {
    let offset = goal.hand.local(goal.object);
    Whereabouts::On { character, joint: hand(limb), offset, holder: Some(limb), second: None }
}

/// Fails where the limb holds something together with the other one.
fn alone(stage: &Stage<'_>, who: usize, limb: Limb, window_s: [f64; 2]) -> Result<(), Problems> {
    let Some((thing, ..)) = stage.held_by_both(who, limb, window_s) else { return Ok(()) };
    let (limb, name) = (limb.name().replace('_', " "), &stage.task.things[thing].name);
    let [from_s, to_s] = window_s;
    Err(Problems::new(format!(
        "{limb} and the other one hold `{name}` between {from_s:.2} s and {to_s:.2} s; drop it first"
    )))
}

fn free_to_take(stage: &Stage<'_>, step: &Step, limb: Limb, object: usize) -> Result<(), Problems> {
    let (who, at_s) = (step.character, step.times_s[1]);
    let name = &stage.task.things[object].name;
    if let Whereabouts::On { character, holder: Some(by), .. } = stage.stretch(object, at_s) {
        let by = format!("{}'s {}", stage.task.characters[*character].name, by.name().replace('_', " "));
        return Err(Problems::new(format!("`{name}` is held by {by} already; drop it first, or hand it over")));
    }
    if let Some((other, _)) = stage.held_by(who, limb, at_s) {
        let other = &stage.task.things[other].name;
        return Err(Problems::new(format!("the hand holds `{other}`; drop it first")));
    }
    settled(stage, object, at_s)
}

/// Fails where the object is used later: what was planned for later would no longer hold.
fn settled(stage: &Stage<'_>, object: usize, at_s: f64) -> Result<(), Problems> {
    let last = stage.lives[object].last().map_or(f64::NEG_INFINITY, |s| s.from_s);
    if last < at_s {
        return Ok(());
    }
    let name = &stage.task.things[object].name;
    Err(Problems::new(format!(
        "`{name}` changes hands at {last:.2} s: expected tasks of one object in the order of time"
    )))
}

/// Brings a held object to a place; keeps it, lays it down or gives it away.
fn bring(stage: &mut Stage<'_>, step: &Step, object: usize, config: &CorrectConfig<'_>) -> Did {
    let (who, limb, at_s) = (step.character, step.limb, step.times_s[1]);
    let name = stage.task.things[object].name.clone();
    let offset = match stage.held_by(who, limb, at_s) {
        Some((held, offset)) if held == object => offset,
        _ => {
            let limb = limb.name().replace('_', " ");
            return Err(Problems::new(format!("{limb} does not hold `{name}` at {at_s:.2} s; let it grab that first")));
        }
    };
    let Some(to) = step.to else { return Err(Problems::new("there is no place to bring it to")) };
    settled(stage, object, at_s)?;
    let goal = |object: Rigid| Goal { rank: 0, hand: object.then(offset.local(Rigid::IDENTITY)), object };
    let hands: Vec<Goal> = stage.resolve(&to, at_s).into_iter().map(goal).collect();
    touch(stage, step, &name, true);
    let both = stage.held_by_both(who, limb, [at_s - 1e-3, at_s]);
    let until_s = if both.is_some() { both::until_s(stage, step, object) } else { at_s };
    hands.iter().for_each(|goal| beside(stage, (who, limb), object, &goal.object, [at_s, until_s]));
    let laid = laid(stage, &to, object, at_s)?;
    let then = |goal: &Goal| laid(goal);
    let change = (step.deed != Deed::Carry).then_some(Change { thing: object, then: &then });
    let (mut plans, given) = match both {
        Some((_, _, second)) => both::bring(stage, step, (second, object), &hands, change, config)?,
        None => go(stage, Visit::with(step, &hands), &hands, change, config)?,
    };
    if let (Deed::HandOver, Some(receiver)) = (step.deed, &step.receiver) {
        // The receiver's grasp replaces its being laid down.
        stage.lives[object].pop();
        let (who, limb) = (receiver.character, receiver.limb);
        alone(stage, who, limb, [step.times_s[1], step.times_s[2]])?;
        let taken = Step { character: who, limb, ..step.clone() };
        let hands = goals(&receiver.grips, &given.object, &stage.actors[who], limb, at_s);
        touch(stage, &taken, &name, true);
        meet(stage, step, receiver, &name);
        let then = |goal: &Goal| held(who, limb, goal);
        let change = Some(Change { thing: object, then: &then });
        plans.extend(go(stage, Visit::of(&taken), &hands, change, config)?.0);
    }
    Ok((plans, Vec::new()))
}

/// Allows both hands to touch an object while it is handed over.
fn meet(stage: &mut Stage<'_>, step: &Step, receiver: &Receiver, object: &str) {
    let window_s = Some([step.times_s[1] - CONTACT_S, step.times_s[1] + CONTACT_S]);
    let both = [(step.character, step.limb), (receiver.character, receiver.limb)];
    for ([(who, limb), (other, with)], is_one) in [both, [both[1], both[0]]].map(|b| (b, both[0].0 == both[1].0)) {
        let with = if is_one { hand(with).name() } else { &stage.task.characters[other].name };
        let contact = Allowed { part: Some(object.into()), with: with.into(), window_s };
        stage.contacts.push((who, limb, contact));
    }
}

/// Placement of a thing once it was let go.
fn laid(
    stage: &Stage<'_>,
    to: &Place,
    object: usize,
    at_s: f64,
) -> Result<impl Fn(&Goal) -> Whereabouts + use<>, Problems> {
    if to.on == Anchor::Thing(object) {
        return Err(Problems::new("a thing cannot be laid on itself; choose another `on`"));
    }
    let mut holder = None;
    if let Anchor::Joint(character, joint) = to.on {
        holder = [Limb::LeftArm, Limb::RightArm].into_iter().find(|l| hand(*l) == joint);
        if holder.is_some_and(|l| stage.held_by(character, l, at_s).is_some()) {
            return Err(Problems::new("that hand holds something already"));
        }
    }
    let (on, from) = (to.on, stage.base_of(to, at_s));
    Ok(move |goal: &Goal| match on {
        Anchor::World => Whereabouts::Path(crate::track::Path::Still(goal.object)),
        Anchor::Thing(thing) => Whereabouts::OnThing { thing, offset: from.local(goal.object) },
        Anchor::Joint(character, joint) => {
            Whereabouts::On { character, joint, offset: from.local(goal.object), holder, second: None }
        }
    })
}

/// Allows contacts of a limb, and of what it holds, around the moment of a step.
pub(super) fn touch(stage: &mut Stage<'_>, step: &Step, object: &str, with_object: bool) {
    let (who, limb, at_s) = (step.character, step.limb, step.times_s[1]);
    let window_s = Some([at_s - CONTACT_S, at_s + CONTACT_S]);
    let parts = Joint::ALL.into_iter().filter(|j| limb.moves(*j) && !limb.joints()[..2].contains(j));
    let mut add = |part: String, with: &str| {
        stage.contacts.push((who, limb, Allowed { part: Some(part), with: with.into(), window_s }));
    };
    for part in parts {
        if with_object {
            add(part.name().into(), object);
        }
        step.contacts.iter().for_each(|c| add(part.name().into(), c));
    }
    step.contacts.iter().for_each(|c| add(object.into(), c));
}
