//! Things that agents take, carry and put down: where they are, in which hand, and what hands reach for meanwhile.

use super::followers::Followers;
use crate::scenario::{Handling, NoStance, SIDES};
use crate::scene::{Carried, ThingConfig};
use glam::{Quat, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use throng_base::maths;
use throng_core::blend::{ActivityId, ActivitySet};
use throng_core::hits::FIST_PER_FOREARM;
use throng_core::walkers::{Performing, Reach};
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Planar, Skeleton};

/// Forearm and hand of each arm: both ends of the forearm.
const ARMS: [[Joint; 2]; 2] = [[Joint::LeftForearm, Joint::LeftHand], [Joint::RightForearm, Joint::RightHand]];

/// How long before the grasp a hand begins to turn to the thing, and how long it leaves it afterwards, at least (s).
const NEARS_S: f32 = 0.45;
const LEAVES_S: f32 = 0.5;
/// The same for each metre that the thing lies lower or higher than the motion takes the palm: hips and trunk go about as fast as
/// those of captured people who sit down and crouch, whose hips take 0.7 to 1.6 s and pass no more than 0.8 m/s (s/m).
const BENDS_S_PER_M: f32 = 1.5;
/// A hand has come to the thing this long before the grasp (s).
const EARLY_S: f32 = 0.05;
/// Time in which a thing that was grasped beside the palm slides into it, or off it where it is put down (s).
const EASE_S: f32 = 0.25;
/// Time in which a forearm is raised to carry a thing level, or sinks again (s).
const CARRY_S: f32 = 0.5;
/// Where a thing is carried level: beside the middle, above the hips, before them (m).
const LEVEL_M: [f32; 3] = [0.14, 0.14, 0.34];
/// Height at which agents without bodies hold things, and how near they come to them (m).
const HELD_M: f32 = 1.0;
const BODILESS_REACH_M: f32 = 0.6;
/// How near to its stand is there (m).
const STAND_M: f32 = 0.15;
/// How much farther off one stands where what a thing lies on is in the way (m).
const FARTHER_M: f32 = 0.1;
/// A body stands at most so far beside the middle of its disc, where its hand is nearer to the thing (m).
const ASIDE_M: f32 = 0.25;
/// A hand closes or opens where its palm is this near to where the thing lies or goes (m).
const MEETS_M: f32 = 0.03;
/// Share of an arm's length within which a palm comes to a thing above the shoulder, and how near to it one stands at most (m).
const STRETCHED: f32 = 0.96;
const CLOSEST_M: f32 = 0.2;
/// Nothing in a snapshot is farther off, and no time of its motion longer (m, s).
const MOST_M: f32 = 1e6;
const MOST_S: f32 = 1e6;
/// Width of a bin of [`Handled::off`], and number of bins (m).
const BIN_M: f32 = 0.01;
const BINS: usize = 32;

/// A thing of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Thing {
    /// Where it is (m).
    pub at: Vec3,
    /// How it is turned (x, y, z, w).
    pub turn: [f32; 4],
    /// In whose hand it is.
    pub keeper: Option<u32>,
    /// Which hand: 0 left, 1 right. That of the last one where it is in none.
    side: u8,
    /// How it is turned as seen from the hand, or from the root where it is carried level; how it was turned in the hand where it
    /// was put down.
    grip: [f32; 4],
    /// The hand has just closed around it.
    is_new: bool,
    /// How far it was from where it belongs, as seen from the palm, or from its place in the world (m); it fades.
    off: Vec3,
    /// Share of `off` that is left.
    ease: f32,
    /// Where it lies, where it is in no hand (m).
    rest: Vec3,
    /// What is being done with it, by whom.
    handling: Option<(u32, Handling, Grasp)>,
    /// The moment of the grasp has come, and the palm was not there.
    is_missed: bool,
    /// What was being done is done or missed, and its motion is over.
    is_over: bool,
    /// How far the forearm is raised for it (0 to 1).
    raised: f32,
}

/// True for a place where things of a snapshot, and what bodies look at, may be (m).
pub(super) fn is_near(at: &Vec3) -> bool {
    at.abs().cmple(Vec3::splat(MOST_M)).all()
}

/// An agent, and its number in the crowd.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Who {
    pub agent: u32,
    /// Agents take the bodies of their group in turn, by this number.
    pub number: usize,
}

/// The motion by which a thing is taken or put down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Grasp {
    /// None for agents without a body, or without such motion: it is done at once.
    activity: Option<ActivityId>,
    side: u8,
    /// When the hand closes or opens (s).
    moment_s: f32,
    /// How long the motion goes on afterwards, before it fades (s).
    after_s: f32,
    /// Where the palm of the body is then, as seen from the root (m).
    palm: Vec3,
    /// What its palm moves about when the arm is stretched, and how far it comes (m).
    around: Vec3,
    reach_m: f32,
}

impl Grasp {
    /// How far a hand is at a place, some time before the grasp, or after it where that is negative (0 to 1): people who bend down
    /// take their time.
    fn near(&self, height: f32, before_s: f32) -> f32 {
        let bends_s = BENDS_S_PER_M * (height - self.palm.y).abs();
        smooth(match before_s > 0.0 {
            true => 1.0 - (before_s - EARLY_S) / NEARS_S.max(bends_s.min(self.moment_s - EARLY_S)),
            false => 1.0 + before_s / LEAVES_S.max(bends_s.min(self.after_s)),
        })
    }

    /// How far from a thing one stands, over the ground (m): as the motion has it, or nearer where the thing is high; `None`
    /// where it is too high.
    fn stand_m(&self, height: f32) -> Option<f32> {
        let usual = self.palm.with_y(0.0).length();
        let over = height - self.around.y;
        if over <= 0.0 || usual < 1e-3 {
            return Some(usual);
        }
        let ahead = self.palm.with_y(0.0) / usual;
        let along = self.around.dot(ahead);
        let aside = (self.around - ahead * along).with_y(0.0).length_squared();
        let flat = self.reach_m * self.reach_m - over * over - aside;
        (flat > 0.0).then(|| usual.min(along + flat.sqrt())).filter(|stand| *stand >= CLOSEST_M.min(usual))
    }
}

/// What hands have done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Handled {
    /// Things that were taken.
    pub taken: u32,
    /// Things that were put down.
    pub put: u32,
    /// Times that somebody could not reach a thing, or where it was to be put.
    pub missed: u32,
    /// How far the palm was from the thing as it was taken, or from where it was put: numbers in bins of 10 mm, the last one
    /// for all that is farther.
    off: [u32; BINS],
}

impl Handled {
    fn count(&mut self, puts: bool, off_m: f32) {
        (self.taken, self.put) = (self.taken + u32::from(!puts), self.put + u32::from(puts));
        self.off[((off_m / BIN_M) as usize).min(BINS - 1)] += 1;
    }

    /// How far palms were from things as they took them, and from where they put them down, at a share of all (0 to 1), rounded
    /// up to 10 mm (m); 0 where nothing was taken.
    pub fn off_m(&self, share: f64) -> f32 {
        let wanted = (share * f64::from(self.taken + self.put)).ceil().max(1.0) as u32;
        let mut sum = 0;
        let bin = self.off.iter().position(|&n| {
            sum += n;
            sum >= wanted
        });
        bin.map_or(0.0, |bin| (bin + 1) as f32 * BIN_M)
    }
}

/// Motion of a tag by which a body of a troop takes things and puts them down: (takes or puts, motion).
pub(super) type Grasps = Vec<(bool, Grasp)>;

/// What one body can do, by troop and tag of motion.
pub(super) type BodyGrasps = Vec<Vec<Grasps>>;

/// Of each activity that says when a hand holds a thing: the moment and place of the grasp, and of letting go, on a body.
pub(super) fn grasps(set: &ActivitySet, activities: &[ActivityId], body: &Skeleton) -> Grasps {
    let mut out = Vec::new();
    for &id in activities {
        let Some(activity) = set.get(id) else { continue };
        for (side, held) in activity.held_s.iter().enumerate() {
            let Some([from, to]) = *held else { continue };
            let grasp = |moment_s: f32| {
                let arm = set.arm(activity, side, moment_s, body);
                let lengths = ARMS[side].map(|j| body.offsets[j.index()].length());
                Grasp {
                    activity: Some(id),
                    side: side as u8,
                    moment_s,
                    after_s: activity.fades_s() - moment_s,
                    palm: arm.palm,
                    around: arm.shoulder + arm.palm - arm.wrist,
                    reach_m: STRETCHED * (lengths[0] + lengths[1]),
                }
            };
            out.extend((from > 0.0).then(|| (false, grasp(from))));
            out.extend(to.is_finite().then(|| (true, grasp(to))));
        }
    }
    out
}

/// All things of a scene, and what bodies can do with them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Things {
    pub all: Vec<Thing>,
    pub handled: Handled,
    carried: Vec<Carried>,
    /// How high each is (m).
    heights: Vec<f32>,
    /// Of each group with bodies: its agents, and of each of its bodies, troops and tags of motion, the grasps.
    bodies: Vec<(Range<usize>, Vec<BodyGrasps>)>,
    /// Hands were told last to reach for something.
    pub reaches: bool,
}

impl Things {
    pub fn new(things: &[ThingConfig]) -> Self {
        let thing = |config: &ThingConfig| {
            let at = Vec3::from_array(config.at);
            let (turn, grip) = (Quat::IDENTITY.to_array(), Quat::IDENTITY.to_array());
            let (off, ease, raised) = (Vec3::ZERO, 0.0, 0.0);
            Thing {
                at,
                turn,
                keeper: None,
                side: 1,
                grip,
                is_new: false,
                is_missed: false,
                off,
                ease,
                rest: at,
                handling: None,
                is_over: false,
                raised,
            }
        };
        Self {
            all: things.iter().map(thing).collect(),
            carried: things.iter().map(|t| t.carried).collect(),
            heights: things.iter().map(|t| t.size_m[1]).collect(),
            ..Self::default()
        }
    }

    /// Takes note of what bodies of a group can do.
    pub(super) fn know(&mut self, followers: &Followers) {
        if !self.all.is_empty() {
            self.bodies.push((followers.agents(), followers.grasps()));
        }
    }

    fn grasps_of(&self, who: Who, motion: Option<u16>) -> &[(bool, Grasp)] {
        let agent = who.agent as usize;
        let found = self.bodies.iter().find(|(agents, _)| agents.contains(&agent));
        let of_tag = found.zip(motion).and_then(|((_, bodies), motion)| {
            let troops = &bodies[who.number % bodies.len()];
            let tags = &troops[agent % troops.len()];
            tags.get(usize::from(motion))
        });
        of_tag.map_or(&[], |grasps| grasps)
    }

    /// True where no thing is in a hand of an agent.
    fn is_free(&self, agent: u32, side: u8) -> bool {
        !self.all.iter().any(|t| t.keeper == Some(agent) && t.side == side)
    }

    /// The motion by which an agent takes a thing, or puts it down, and how far from it the agent stands (m): of those by which
    /// it comes there the one whose palm is nearest in height.
    fn grasp(&self, who: Who, motion: Option<u16>, handling: &Handling) -> Result<(Grasp, f32), NoStance> {
        let thing = &self.all[usize::from(handling.thing)];
        let has_hand = |side: u8| if handling.puts { thing.side == side } else { self.is_free(who.agent, side) };
        let all = self.grasps_of(who, motion);
        let fits = all.iter().filter(|(puts, g)| *puts == handling.puts && has_hand(g.side)).map(|(_, g)| g);
        let reaching = fits.clone().filter_map(|g| Some((*g, g.stand_m(handling.at.y)?)));
        let height = |g: &Grasp| (g.palm.y - handling.at.y).abs();
        if let Some(best) = reaching.min_by(|a, b| height(&a.0).total_cmp(&height(&b.0))) {
            return Ok(best);
        }
        if fits.count() > 0 {
            return Err(NoStance::OutOfReach);
        }
        let none = Vec3::ZERO;
        let (moment_s, after_s, reach_m) = (0.0, 0.0, 0.0);
        let bare = |side| Grasp { activity: None, side, moment_s, after_s, palm: none, around: none, reach_m };
        let side = [1, 0].into_iter().find(|side| has_hand(*side)).ok_or(NoStance::NoHand)?;
        Ok((bare(side), 0.9 * BODILESS_REACH_M))
    }

    /// See [`crate::scenario::Stage::stance`].
    pub fn stance(
        &self,
        who: Who,
        motion: Option<u16>,
        handling: Handling,
        (from, side): (Vec3, u32),
    ) -> Result<(Vec3, f32), NoStance> {
        let (grasp, stand_m) = self.grasp(who, motion, &handling)?;
        let at = Vec3::new(handling.at.x, 0.0, handling.at.z);
        let (side, stand_m) = (side % SIDES, stand_m + if side < SIDES { 0.0 } else { FARTHER_M });
        let turns = if side % 2 == 1 { side.div_ceil(2) as f32 } else { -((side / 2) as f32) };
        let heading = heading(at - from) + turns * std::f32::consts::FRAC_PI_4;
        if grasp.activity.is_none() {
            let way = maths::at_angle(std::f32::consts::FRAC_PI_2 - heading);
            return Ok((at - stand_m * Vec3::new(way.x, 0.0, way.y), STAND_M));
        }
        let ahead = grasp.palm.with_y(0.0).normalize_or_zero() * stand_m;
        let palm = Planar::new(0.0, 0.0, heading).transform_point(Vec2::new(ahead.x, ahead.z));
        Ok((at - Vec3::new(palm.x, 0.0, palm.y), STAND_M))
    }

    /// An agent that stands in reach begins to take a thing, or to put it down.
    ///
    /// - returns the activity that shows it, what the body faces, and where it stands (m).
    pub fn begin(
        &mut self,
        who: Who,
        motion: Option<u16>,
        handling: Handling,
        from: Vec3,
    ) -> Option<(ActivityId, Vec3, Vec3)> {
        let (grasp, stand_m) = self.grasp(who, motion, &handling).ok()?;
        let to = (handling.at - from).with_y(0.0);
        let heading = heading(to) - heading(grasp.palm);
        let ahead = Planar::new(0.0, 0.0, heading).transform_point(Vec2::new(0.0, 2.0));
        let faces = from + Vec3::new(ahead.x, 0.0, ahead.y);
        let thing = &mut self.all[usize::from(handling.thing)];
        (thing.handling, thing.is_over, thing.is_missed) = (Some((who.agent, handling, grasp)), false, false);
        let aside = to - to.normalize_or_zero() * stand_m;
        Some((grasp.activity?, faces, from + aside.clamp_length_max(ASIDE_M)))
    }

    /// See [`crate::scenario::Stage::settle`].
    pub fn settle(&mut self, agent: u32, thing: u16, is_done: bool) -> bool {
        let thing = &mut self.all[usize::from(thing)];
        if let Some((by, handling, grasp)) = thing.handling
            && by == agent
        {
            thing.handling = None;
            if is_done && grasp.activity.is_none() && thing.waits_for(agent, &handling) {
                let off_m = thing.at.distance(handling.at);
                thing.change_hands(agent, &handling, (grasp.side, off_m), &mut self.handled);
            }
        }
        thing.keeper == Some(agent)
    }

    /// True where an agent has taken a thing, or put it down, and its hand is back.
    pub fn is_over(&self, agent: u32, thing: u16) -> bool {
        let thing = &self.all[usize::from(thing)];
        thing.is_over && thing.handling.is_some_and(|h| h.0 == agent)
    }

    /// True where a hand of an agent has yet to close or to open.
    pub fn is_awaited(&self, agent: u32) -> bool {
        let awaits = |t: &Thing| t.handling.is_some_and(|h| h.0 == agent && t.waits_for(agent, &h.1));
        self.all.iter().any(|t| !t.is_missed && awaits(t))
    }

    /// Who had a claim on a thing has none any more: out of a hand it drops to the ground, else it stays where it is.
    pub fn let_go(&mut self, thing: u16) {
        let (height, thing) = (self.heights[usize::from(thing)], &mut self.all[usize::from(thing)]);
        thing.handling = None;
        if thing.keeper.is_some() {
            thing.put(thing.at.with_y(0.5 * height));
        }
    }

    /// Tells the hands of all bodies what to reach for.
    pub(super) fn direct(&mut self, followers: &mut [Followers], dt_s: f32) {
        if self.all.is_empty() {
            return;
        }
        if self.reaches {
            followers.iter_mut().for_each(Followers::free_hands);
        }
        self.reaches = false;
        for (thing, &carried) in self.all.iter_mut().zip(&self.carried) {
            let by = thing.handling.map(|h| h.0).or(thing.keeper);
            let Some((agent, body)) = by.and_then(|agent| {
                let body = followers.iter_mut().find(|f| f.holds(agent as usize));
                body.filter(|f| f.is_there(agent as usize)).map(|body| (agent as usize, body))
            }) else {
                thing.raised = 0.0;
                continue;
            };
            let at_it = thing.handling.and_then(|(_, handling, grasp)| {
                // At the end of the step, and whole in the one in which the moment comes.
                let before = grasp.moment_s - begun(body.performing(agent), grasp)?;
                let left = if before > 0.0 { (before - dt_s).max(0.0) } else { before - dt_s };
                Some((handling, grasp.near(handling.at.y, left)))
            });
            let lifts = carried == Carried::Level && thing.keeper.is_some();
            let change = if dt_s > 0.0 { dt_s / CARRY_S } else { 0.0 };
            thing.raised = (thing.raised + if lifts { change } else { -change }).clamp(0.0, 1.0);
            let near = at_it.map_or(0.0, |a| a.1);
            let raised = smooth(thing.raised) * (1.0 - near);
            if near + raised <= 0.0 {
                continue;
            }
            let side = usize::from(thing.handling.map_or(thing.side, |h| h.2.side));
            let hips = body.pose(agent)[Joint::Hips.index()].translation();
            let [beside, above, before] = LEVEL_M;
            let level = Vec3::new(if side == 0 { beside } else { -beside }, hips.y + above, before);
            let place = at_it.map_or(level, |(handling, _)| handling.at);
            let reach = Reach { place: (place, near), level: (level, raised) };
            body.reach(agent, side, reach);
            self.reaches = true;
        }
    }

    /// Hands close and open, things follow them.
    ///
    /// - `bodiless`: where an agent without a body is, and where it looks.
    pub(super) fn follow(&mut self, followers: &[Followers], bodiless: impl Fn(u32) -> Option<Planar>, dt_s: f32) {
        let Self { all, handled, carried, .. } = self;
        for (thing, &carried) in all.iter_mut().zip(carried.iter()) {
            let hand_of = |agent: u32, side: u8| hand(followers, &bodiless, agent, side);
            if let Some((agent, handling, grasp)) = thing.handling {
                let performing =
                    followers.iter().find(|f| f.holds(agent as usize)).and_then(|f| f.performing(agent as usize));
                let seconds = begun(performing, grasp);
                let is_due = grasp.activity.is_none() || seconds.is_some_and(|s| s >= grasp.moment_s);
                if is_due && thing.waits_for(agent, &handling) {
                    let off_m = hand_of(agent, grasp.side).map_or(0.0, |hand| hand.palm.distance(handling.at));
                    match grasp.activity.is_none() || off_m <= MEETS_M {
                        true => thing.change_hands(agent, &handling, (grasp.side, off_m), handled),
                        false => thing.is_missed = true,
                    }
                }
            }
            if let Some((agent, handling, _)) = thing.handling {
                thing.is_over = (thing.is_missed || !thing.waits_for(agent, &handling))
                    && followers.iter().all(|f| !f.holds(agent as usize) || f.performing(agent as usize).is_none());
            }
            thing.ease = (thing.ease - dt_s / EASE_S).max(0.0);
            match thing.keeper.and_then(|agent| hand_of(agent, thing.side)) {
                Some(hand) => {
                    let holds = match carried {
                        Carried::Hanging => hand.turn,
                        Carried::Level => hand.root.rotation(),
                    };
                    if std::mem::take(&mut thing.is_new) {
                        thing.grip =
                            maths::unit(maths::compose(holds.conjugate(), Quat::from_array(thing.turn))).to_array();
                        (thing.off, thing.ease) = (maths::rotate(hand.turn.conjugate(), thing.at - hand.palm), 1.0);
                    }
                    thing.turn = maths::unit(maths::compose(holds, Quat::from_array(thing.grip))).to_array();
                    thing.at = hand.palm + maths::rotate(hand.turn, thing.off * smooth(thing.ease));
                }
                None if thing.keeper.is_none() && thing.ease > 0.0 => {
                    thing.at = thing.rest + thing.off * smooth(thing.ease);
                    let was = Quat::from_array(thing.grip);
                    let upright = maths::rotation_y(throng_core::planar::twist_about_y(was));
                    thing.turn = maths::between(upright, was, smooth(thing.ease)).to_array();
                }
                None if thing.keeper.is_none() => thing.at = thing.rest,
                None => {}
            }
        }
    }

    /// Why things cannot be those of a scene with so many agents.
    pub fn check(&self, all: &[Thing], handled: &Handled, num_agents: usize) -> Result<(), &'static str> {
        let is_short = |value: &f32| value.abs() <= MOST_S;
        let counts = [handled.taken, handled.put, handled.missed];
        if !counts.iter().chain(&handled.off).all(|n| *n < u32::MAX / 128) {
            return Err("hands have done more than can be");
        }
        let is_unit = |q: &[f32; 4]| (Quat::from_array(*q).length() - 1.0).abs() < 1e-3;
        let is_good = |(n, t): (usize, &Thing)| {
            let agents = [t.keeper, t.handling.map(|h| h.0)];
            let of_it = |h: &(u32, Handling, Grasp)| {
                usize::from(h.1.thing) == n
                    && h.2.side < 2
                    && [h.1.at, h.2.palm, h.2.around].iter().all(is_near)
                    && [h.2.moment_s, h.2.after_s, h.2.reach_m].iter().all(is_short)
            };
            [t.at, t.rest, t.off].iter().all(is_near)
                && is_unit(&t.turn)
                && is_unit(&t.grip)
                && t.side < 2
                && agents.iter().flatten().all(|&a| (a as usize) < num_agents)
                && t.handling.is_none_or(|h| of_it(&h))
                && [t.ease, t.raised].iter().all(|s| (0.0..=1.0).contains(s))
        };
        match all.len() == self.all.len() && all.iter().enumerate().all(is_good) {
            true => Ok(()),
            false => Err("a thing is where none can be"),
        }
    }
}

impl Thing {
    /// The hand has not closed or opened yet.
    fn waits_for(&self, agent: u32, handling: &Handling) -> bool {
        handling.puts == (self.keeper == Some(agent))
    }

    /// A hand closes around it, or opens.
    ///
    /// - `off_m`: how far the palm is from where it lies or goes (m).
    fn change_hands(&mut self, agent: u32, handling: &Handling, (side, off_m): (u8, f32), handled: &mut Handled) {
        handled.count(handling.puts, off_m);
        if handling.puts {
            // The hand is wholly at the place.
            self.raised = 0.0;
            return self.put(handling.at);
        }
        (self.keeper, self.side, self.is_new) = (Some(agent), side, true);
    }

    fn put(&mut self, at: Vec3) {
        (self.keeper, self.rest, self.off, self.ease) = (None, at, self.at - at, 1.0);
        (self.grip, self.is_new) = (self.turn, false);
    }
}

/// A hand in the world.
struct Hand {
    palm: Vec3,
    turn: Quat,
    root: Planar,
}

fn hand(followers: &[Followers], bodiless: &impl Fn(u32) -> Option<Planar>, agent: u32, side: u8) -> Option<Hand> {
    let Some(body) = followers.iter().find(|f| f.holds(agent as usize)) else {
        let root = bodiless(agent)?;
        return Some(Hand { palm: root.translation() + Vec3::Y * HELD_M, turn: root.rotation(), root });
    };
    let (root, pose) = (body.root(agent as usize), body.pose(agent as usize));
    let (palm, turn) = palm(pose, root, side);
    Some(Hand { palm, turn, root })
}

/// Where a palm is in the world, and how the hand is turned: beyond the wrist, along the forearm.
fn palm(pose: &[Mat3x4; NUM_JOINTS], root: Planar, side: u8) -> (Vec3, Quat) {
    let [forearm, hand] = ARMS[usize::from(side)].map(|j| &pose[j.index()]);
    let along = maths::rotate(forearm.rotation().conjugate(), hand.translation() - forearm.translation());
    let palm = hand.translation() + maths::rotate(hand.rotation(), along * FIST_PER_FOREARM);
    (maths::rotate(root.rotation(), palm) + root.translation(), maths::compose(root.rotation(), hand.rotation()))
}

/// Time within the motion of a grasp, once it has begun (s).
fn begun(performing: Option<Performing>, grasp: Grasp) -> Option<f32> {
    let now = performing.filter(|p| Some(p.activity) == grasp.activity)?;
    (now.part != throng_core::walkers::Part::Turn).then_some(now.seconds)
}

fn smooth(share: f32) -> f32 {
    let s = share.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// The heading of a way over the ground (rad).
fn heading(way: Vec3) -> f32 {
    maths::atan2(way.x, way.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_drop_out_of_hands_alone() {
        let (at, size_m) = ([1.0, 0.9, 2.0], [0.1, 0.2, 0.1]);
        let cup = ThingConfig { name: "cup".into(), at, size_m, carried: Carried::Level };
        let mut things = Things::new(&[cup]);
        let handling = Handling { thing: 0, puts: false, at: at.into() };
        let seven = Who { agent: 7, number: 7 };
        let here = |_| Some(Planar::new(1.0, 1.5, 0.0));
        // Somebody without a body is about to take it, and leaves.
        assert!(things.begin(seven, None, handling, Vec3::new(1.0, 0.0, 1.5)).is_none());
        things.let_go(0);
        things.follow(&[], here, 1.0);
        assert_eq!((things.all[0].at, things.all[0].keeper), (at.into(), None));
        // Somebody has it in hand, and leaves: it lies where it was, on the ground.
        things.begin(seven, None, handling, Vec3::new(1.0, 0.0, 1.5));
        things.follow(&[], here, 1.0);
        assert_eq!((things.all[0].keeper, things.handled.taken), (Some(7), 1));
        let held = things.all[0].at;
        things.let_go(0);
        (0..3).for_each(|_| things.follow(&[], here, 1.0));
        assert_eq!((things.all[0].at, things.all[0].keeper), (held.with_y(0.1), None));
    }
}
