//! Things that agents take, carry and put down: where they are, in which hand, and what hands reach for meanwhile.

use super::{followers::Followers, stage::BodyActivity};
use crate::scenario::{Handling, SIDES, StanceError};
use crate::scene::{CarryStyle, ThingConfig};
use glam::{Quat, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use throng_base::{error::ensure, maths};
use throng_core::blend::{ActivityId, ActivitySet};
use throng_core::{Joint, Planar, Skeleton, body::ArmLayer, hits::FIST_PER_FOREARM, walkers::PerformanceProgress};

/// Forearm and hand of each arm: both ends of the forearm.
const ARMS: [[Joint; 2]; 2] = [[Joint::LeftForearm, Joint::LeftHand], [Joint::RightForearm, Joint::RightHand]];

/// Times in which a hand approaches a thing before the grasp, and withdraws from it afterwards; less where the motion is shorter (s).
const APPROACH_S: f32 = 0.45;
const RETREAT_S: f32 = 0.5;
/// Time added to both for each metre between the height of the thing and that of the palm in the motion: hips and trunk move about
/// as fast as those of captured people who sit down and crouch, whose hips take 0.7 to 1.6 s and stay below 0.8 m/s (s/m).
const BENDS_S_PER_M: f32 = 1.5;
/// Time before the grasp at which the hand has reached the thing (s).
const EARLY_S: f32 = 0.05;
/// Time in which a thing grasped beside the palm slides into it, or off it when it is put down (s).
const EASE_S: f32 = 0.25;
/// Time in which a forearm rises to carry a thing level, or sinks again (s).
const CARRY_S: f32 = 0.5;
/// Position of a thing that is carried level: beside the middle of the body, above the hips, in front of them (m).
const LEVEL_M: [f32; 3] = [0.14, 0.14, 0.34];
/// Height at which agents without bodies hold things, and the distance from which they reach them (m).
const CARRY_HEIGHT_M: f32 = 1.0;
const BODILESS_REACH_M: f32 = 0.6;
/// Distance from its stand at which an agent has arrived (m).
const STAND_M: f32 = 0.15;
/// Additional distance of a stand where the support of a thing is in the way (m).
const FARTHER_M: f32 = 0.1;
/// Largest distance of a body from the centre of its disc, to bring its hand nearer to the thing (m).
const ASIDE_M: f32 = 0.25;
/// Largest distance between the palm and the place of the thing at which a hand closes or opens (m).
const GRASP_TOLERANCE_M: f32 = 0.03;
/// Share of an arm's length that it stretches to a thing above the shoulder (1), and least distance of a stand from a thing (m).
const STRETCHED: f32 = 0.96;
const CLOSEST_M: f32 = 0.2;
/// Largest distance and longest time of motion in a valid snapshot (m, s).
const MOST_M: f32 = 1e6;
const MOST_S: f32 = 1e6;
/// Width of a bin of [`HandlingCounts::off`], and number of bins (m).
const BIN_M: f32 = 0.01;
const BINS: usize = 32;

/// State of a thing of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ThingState {
    /// Position (m).
    pub at: Vec3,
    /// Orientation (x, y, z, w).
    pub turn: [f32; 4],
    /// Agent that has it in hand.
    pub keeper: Option<u32>,
    /// Hand that holds it, or held it last: 0 left, 1 right.
    side: u8,
    /// Orientation relative to the hand, or to the root where it is carried level; orientation in the hand when it was put down, where
    /// no hand holds it.
    grip: [f32; 4],
    /// Whether the hand has just closed around it.
    is_new: bool,
    /// Offset from its proper place, relative to the palm or to the world, which fades (m).
    off: Vec3,
    /// Share of `off` that is left.
    ease: f32,
    /// Position at which it lies while no hand holds it (m).
    rest: Vec3,
    /// Handling that goes on: the agent, the handling and its grasp.
    handling: Option<(u32, Handling, Grasp)>,
    /// Whether the palm was not there at the moment of the grasp.
    is_missed: bool,
    /// Whether the handling is done or missed, and its motion over.
    is_over: bool,
    /// Share by which the forearm is raised for it (0 to 1).
    raised: f32,
}

/// True for a position that a snapshot may have for things and for targets of gaze (m).
pub(super) fn is_near(at: &Vec3) -> bool {
    at.abs().cmple(Vec3::splat(MOST_M)).all()
}

/// Agent that is to handle a thing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Handler {
    pub agent: u32,
    /// Number in the crowd: agents take the bodies of their group in turn, by this number.
    pub number: usize,
    /// Position (m).
    pub from: Vec3,
    /// Number of the tag of its motion.
    pub motion: Option<u16>,
}

/// Motion by which a thing is taken or put down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Grasp {
    /// Activity; `None` for agents without a body or without such motion, which are done at once.
    activity: Option<ActivityId>,
    side: u8,
    /// Time at which the hand closes or opens (s).
    moment_s: f32,
    /// Time for which the motion goes on afterwards, before it fades out (s).
    after_s: f32,
    /// Palm of the body at that time, relative to the root (m).
    palm: Vec3,
    /// Centre about which the palm moves with a stretched arm, relative to the root, and its distance then (m).
    around: Vec3,
    reach_m: f32,
}

impl Grasp {
    /// Share by which a hand is at a place at a time before the grasp, or after it where that is negative (0 to 1). It changes
    /// more slowly where people have to bend down.
    fn approach_share(&self, height: f32, before_s: f32) -> f32 {
        let bends_s = BENDS_S_PER_M * (height - self.palm.y).abs();
        let early_s = EARLY_S.min(0.5 * self.moment_s);
        smoothstep(match before_s > 0.0 {
            true => 1.0 - (before_s - early_s) / APPROACH_S.max(bends_s).min(self.moment_s - early_s),
            false => 1.0 + before_s / RETREAT_S.max(bends_s).min(self.after_s).max(f32::EPSILON),
        })
    }

    /// Distance of the stand from a thing along the ground: that of the motion, or less where the thing is high; `None`
    /// where it is too high (m).
    fn stand_distance_m(&self, height: f32) -> Option<f32> {
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

/// Counts of what hands have done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandlingCounts {
    /// Number of things that were taken.
    pub taken: u32,
    /// Number of things that were put down.
    pub put: u32,
    /// Number of times that an agent could not reach a thing, or the place for it.
    pub missed: u32,
    /// Histogram of the distance of the palm from the thing as it was taken, or from the place as it was put down, in bins of
    /// 10 mm; the last bin has all that was farther.
    off: [u32; BINS],
}

impl HandlingCounts {
    fn count_grasp(&mut self, puts: bool, off_m: f32) {
        (self.taken, self.put) = (self.taken + u32::from(!puts), self.put + u32::from(puts));
        self.off[((off_m / BIN_M) as usize).min(BINS - 1)] += 1;
    }

    /// Quantile of the distance of palms from things at grasps, for a share of all grasps (0 to 1), rounded up to 10 mm; 0 where
    /// nothing was taken (m).
    pub fn palm_error_m(&self, share: f64) -> f32 {
        let wanted = (share * f64::from(self.taken + self.put)).ceil().max(1.0) as u32;
        let mut sum = 0;
        let bin = self.off.iter().position(|&n| {
            sum += n;
            sum >= wanted
        });
        bin.map_or(0.0, |bin| (bin + 1) as f32 * BIN_M)
    }
}

/// Grasps of one body, troop and motion tag, each with true where it puts a thing down and false where it takes it.
pub(super) type Grasps = Vec<(bool, Grasp)>;

/// Grasps of one body, by troop and motion tag.
pub(super) type BodyGrasps = Vec<Vec<Grasps>>;

/// Grasps of all activities that say when a hand holds a thing: time and place of taking and of putting down, on a body.
pub(super) fn grasps(set: &ActivitySet, activities: &[ActivityId], body: &Skeleton) -> Grasps {
    let mut out = Vec::new();
    for &id in activities {
        let Some(activity) = set.get(id) else { continue };
        for (side, held) in activity.held_s.iter().enumerate() {
            let Some([from, to]) = *held else { continue };
            let grasp = |moment_s: f32| {
                let arm = set.arm_places_at(activity, side, moment_s, body);
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

/// All things of a scene, and the grasps of bodies.
#[derive(Clone, Debug, Default)]
pub(crate) struct Things {
    pub all: Vec<ThingState>,
    pub counts: HandlingCounts,
    carried: Vec<CarryStyle>,
    /// Height of each thing (m).
    heights: Vec<f32>,
    /// Grasps of each group with bodies: its agents, and the grasps of each body, troop and motion tag.
    bodies: Vec<(Range<usize>, Vec<BodyGrasps>)>,
    /// Whether hands were last ordered to reach for something.
    pub reaches: bool,
}

impl Things {
    pub fn new(things: &[ThingConfig]) -> Self {
        let thing = |config: &ThingConfig| {
            let (at, upright) = (Vec3::from_array(config.at), Quat::IDENTITY.to_array());
            ThingState { at, rest: at, turn: upright, grip: upright, side: 1, ..ThingState::default() }
        };
        Self {
            all: things.iter().map(thing).collect(),
            carried: things.iter().map(|t| t.carried).collect(),
            heights: things.iter().map(|t| t.size_m[1]).collect(),
            ..Self::default()
        }
    }

    /// Registers the grasps of a group's bodies.
    pub(super) fn register_bodies(&mut self, followers: &Followers) {
        if !self.all.is_empty() {
            self.bodies.push((followers.agents.clone(), followers.grasps()));
        }
    }

    fn grasps_of(&self, who: Handler) -> &[(bool, Grasp)] {
        let agent = who.agent as usize;
        let found = self.bodies.iter().find(|(agents, _)| agents.contains(&agent));
        let of_tag = found.zip(who.motion).and_then(|((_, bodies), motion)| {
            let troops = &bodies[who.number % bodies.len()];
            let tags = &troops[agent % troops.len()];
            tags.get(usize::from(motion))
        });
        of_tag.map_or(&[], |grasps| grasps)
    }

    /// True where a hand of an agent holds nothing.
    fn is_free(&self, agent: u32, side: u8) -> bool {
        !self.all.iter().any(|t| t.keeper == Some(agent) && t.side == side)
    }

    /// Chooses the grasp by which an agent takes a thing or puts it down: of those that reach it, the one whose palm is nearest in
    /// height. Also returns the distance of the stand from the thing (m).
    fn choose_grasp(&self, who: Handler, handling: &Handling) -> Result<(Grasp, f32), StanceError> {
        let thing = &self.all[usize::from(handling.thing)];
        let has_hand = |side: u8| if handling.puts { thing.side == side } else { self.is_free(who.agent, side) };
        let all = self.grasps_of(who);
        let fits = all.iter().filter(|(puts, g)| *puts == handling.puts && has_hand(g.side)).map(|(_, g)| g);
        let reaching = fits.clone().filter_map(|g| Some((*g, g.stand_distance_m(handling.at.y)?)));
        let height = |g: &Grasp| (g.palm.y - handling.at.y).abs();
        if let Some(best) = reaching.min_by(|a, b| height(&a.0).total_cmp(&height(&b.0))) {
            return Ok(best);
        }
        ensure(fits.count() == 0, || StanceError::OutOfReach)?;
        let side = [1, 0].into_iter().find(|side| has_hand(*side)).ok_or(StanceError::NoHand)?;
        Ok((Grasp { side, ..Grasp::default() }, 0.9 * BODILESS_REACH_M))
    }

    /// Finds a stand, see [`crate::scenario::ScenarioStage::stance`].
    pub fn stance(&self, who: Handler, handling: Handling, side: u32) -> Result<(Vec3, f32), StanceError> {
        let (grasp, stand_m) = self.choose_grasp(who, &handling)?;
        let at = Vec3::new(handling.at.x, 0.0, handling.at.z);
        let (side, stand_m) = (side % SIDES, stand_m + if side < SIDES { 0.0 } else { FARTHER_M });
        let turns = if side % 2 == 1 { side.div_ceil(2) as f32 } else { -((side / 2) as f32) };
        let heading = heading_of(at - who.from) + turns * std::f32::consts::FRAC_PI_4;
        if grasp.activity.is_none() {
            let direction = maths::direction_at_angle(std::f32::consts::FRAC_PI_2 - heading);
            return Ok((at - stand_m * Vec3::new(direction.x, 0.0, direction.y), STAND_M));
        }
        let ahead = grasp.palm.with_y(0.0).normalize_or_zero() * stand_m;
        let palm = Planar::new(0.0, 0.0, heading).transform_point(Vec2::new(ahead.x, ahead.z));
        Ok((at - Vec3::new(palm.x, 0.0, palm.y), STAND_M))
    }

    /// Begins to take a thing, or to put it down, by an agent that stands in reach.
    ///
    /// - returns what its body shows meanwhile; `None` where no motion shows it.
    pub fn begin_handling(&mut self, who: Handler, handling: Handling) -> Option<BodyActivity> {
        let (grasp, stand_m) = self.choose_grasp(who, &handling).ok()?;
        let to = (handling.at - who.from).with_y(0.0);
        let heading = heading_of(to) - heading_of(grasp.palm);
        let ahead = Planar::new(0.0, 0.0, heading).transform_point(Vec2::new(0.0, 2.0));
        let faces = who.from + Vec3::new(ahead.x, 0.0, ahead.y);
        let thing = &mut self.all[usize::from(handling.thing)];
        (thing.handling, thing.is_over, thing.is_missed) = (Some((who.agent, handling, grasp)), false, false);
        let aside = to - to.normalize_or_zero() * stand_m;
        let (once, stands) = (Some(grasp.activity?), Some(who.from + aside.clamp_length_max(ASIDE_M)));
        Some(BodyActivity { motion: who.motion, faces: Some(faces), once, stands, other: None })
    }

    /// Ends the handling of a thing.
    pub fn end_handling(&mut self, agent: u32, thing: u16, is_done: bool) -> bool {
        let thing = &mut self.all[usize::from(thing)];
        if let Some((by, handling, grasp)) = thing.handling
            && by == agent
        {
            thing.handling = None;
            if is_done && grasp.activity.is_none() && thing.waits_for(agent, &handling) {
                let off_m = thing.at.distance(handling.at);
                thing.change_hands(agent, &handling, grasp.side, off_m, &mut self.counts);
            }
        }
        thing.keeper == Some(agent)
    }

    /// True where an agent has taken a thing, or put it down, and its hand is back.
    pub fn is_handling_over(&self, agent: u32, thing: u16) -> bool {
        let thing = &self.all[usize::from(thing)];
        thing.is_over && thing.handling.is_some_and(|h| h.0 == agent)
    }

    /// True where a hand of an agent has yet to close or to open.
    pub fn is_awaited(&self, agent: u32) -> bool {
        let awaits = |t: &ThingState| t.handling.is_some_and(|h| h.0 == agent && t.waits_for(agent, &h.1));
        self.all.iter().any(|t| !t.is_missed && awaits(t))
    }

    /// Ends an agent's claim on a thing: a thing in hand drops to the ground, another one stays where it is.
    pub fn drop_thing(&mut self, thing: u16) {
        let (height, thing) = (self.heights[usize::from(thing)], &mut self.all[usize::from(thing)]);
        thing.handling = None;
        if thing.keeper.is_some() {
            thing.put_down(thing.at.with_y(0.5 * height));
        }
    }

    /// Orders the hands of all bodies to reach for things.
    pub(super) fn order_reaches(&mut self, followers: &mut [Followers], dt_s: f32) {
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
                let body = followers.iter_mut().find(|f| f.agents.contains(&(agent as usize)));
                body.filter(|f| f.has_body(agent as usize)).map(|body| (agent as usize, body))
            }) else {
                thing.raised = 0.0;
                continue;
            };
            let at_it = thing.handling.and_then(|(_, handling, grasp)| {
                // Time left at the end of the step; the share is 1 in the step in which the moment comes.
                let before = grasp.moment_s - performed_seconds(body.performing(agent), grasp)?;
                let left = if before > 0.0 { (before - dt_s).max(0.0) } else { before - dt_s };
                Some((handling, grasp.approach_share(handling.at.y, left)))
            });
            let lifts = carried == CarryStyle::Level && thing.keeper.is_some();
            let change = if dt_s > 0.0 { dt_s / CARRY_S } else { 0.0 };
            thing.raised = (thing.raised + if lifts { change } else { -change }).clamp(0.0, 1.0);
            let near = at_it.map_or(0.0, |a| a.1);
            let raised = smoothstep(thing.raised) * (1.0 - near);
            if near + raised <= 0.0 {
                continue;
            }
            let side = usize::from(thing.handling.map_or(thing.side, |h| h.2.side));
            let hips = body.pose(agent)[Joint::Hips.index()].translation();
            let [beside, above, before] = LEVEL_M;
            let level = Vec3::new(if side == 0 { beside } else { -beside }, hips.y + above, before);
            let place = at_it.map_or(level, |(handling, _)| handling.at);
            let reach = ArmLayer::Reach { place: (place, near), level: (level, raised) };
            body.order_reach(agent, side, reach);
            self.reaches = true;
        }
    }

    /// Closes and opens hands, and moves things along with them.
    ///
    /// - `bodiless`: root of an agent without a body.
    pub(super) fn update_things(
        &mut self,
        followers: &[Followers],
        bodiless: impl Fn(u32) -> Option<Planar>,
        dt_s: f32,
    ) {
        let Self { all, counts: handled, carried, .. } = self;
        let body_of = |agent: u32| followers.iter().find(|f| f.agents.contains(&(agent as usize)));
        for (thing, &carried) in all.iter_mut().zip(carried.iter()) {
            let hand_of = |agent: u32, side: u8| {
                let hand = body_of(agent).map(|f| Hand::of_body(f, agent as usize, side));
                hand.or_else(|| bodiless(agent).map(Hand::of_bodiless))
            };
            if let Some((agent, handling, grasp)) = thing.handling {
                let performing = body_of(agent).and_then(|f| f.performing(agent as usize));
                let seconds = performed_seconds(performing, grasp);
                let is_due = grasp.activity.is_none() || seconds.is_some_and(|s| s >= grasp.moment_s);
                if is_due && thing.waits_for(agent, &handling) {
                    let off_m = hand_of(agent, grasp.side).map_or(0.0, |hand| hand.palm.distance(handling.at));
                    match grasp.activity.is_none() || off_m <= GRASP_TOLERANCE_M {
                        true => thing.change_hands(agent, &handling, grasp.side, off_m, handled),
                        false => thing.is_missed = true,
                    }
                }
                let is_done = thing.is_missed || !thing.waits_for(agent, &handling);
                thing.is_over = is_done && performing.is_none();
            }
            thing.ease = (thing.ease - dt_s / EASE_S).max(0.0);
            match thing.keeper.and_then(|agent| hand_of(agent, thing.side)) {
                Some(hand) => {
                    let holds = match carried {
                        CarryStyle::Hanging => hand.turn,
                        CarryStyle::Level => hand.root.rotation(),
                    };
                    if std::mem::take(&mut thing.is_new) {
                        let grip = maths::compose(holds.conjugate(), Quat::from_array(thing.turn));
                        thing.grip = maths::normalize_or_identity(grip).to_array();
                        (thing.off, thing.ease) = (maths::rotate(hand.turn.conjugate(), thing.at - hand.palm), 1.0);
                    }
                    let turn = maths::compose(holds, Quat::from_array(thing.grip));
                    thing.turn = maths::normalize_or_identity(turn).to_array();
                    thing.at = hand.palm + maths::rotate(hand.turn, thing.off * smoothstep(thing.ease));
                }
                None if thing.keeper.is_none() && thing.ease > 0.0 => {
                    thing.at = thing.rest + thing.off * smoothstep(thing.ease);
                    let was = Quat::from_array(thing.grip);
                    let upright = maths::rotation_y(throng_core::planar::twist_about_y(was));
                    thing.turn = maths::nlerp(upright, was, smoothstep(thing.ease)).to_array();
                }
                None if thing.keeper.is_none() => thing.at = thing.rest,
                None => {}
            }
        }
    }

    /// Checks that things can be those of a scene with `num_agents` agents.
    pub fn check(&self, all: &[ThingState], handled: &HandlingCounts, num_agents: usize) -> Result<(), &'static str> {
        let is_short = |value: &f32| value.abs() <= MOST_S;
        let counts = [handled.taken, handled.put, handled.missed];
        ensure(counts.iter().chain(&handled.off).all(|n| *n < u32::MAX / 128), || "hands have done more than can be")?;
        let is_unit = |q: &[f32; 4]| (Quat::from_array(*q).length() - 1.0).abs() < 1e-3;
        let is_good = |(n, t): (usize, &ThingState)| {
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
        let are_good = all.len() == self.all.len() && all.iter().enumerate().all(is_good);
        if are_good { Ok(()) } else { Err("a thing is where none can be") }
    }
}

impl ThingState {
    /// True while the hand has not closed or opened yet.
    fn waits_for(&self, agent: u32, handling: &Handling) -> bool {
        handling.puts == (self.keeper == Some(agent))
    }

    /// Closes a hand around the thing, or opens it.
    ///
    /// - `off_m`: distance of the palm from the place of the thing (m).
    fn change_hands(&mut self, agent: u32, handling: &Handling, side: u8, off_m: f32, handled: &mut HandlingCounts) {
        handled.count_grasp(handling.puts, off_m);
        if handling.puts {
            // The hand is wholly at the place.
            self.raised = 0.0;
            return self.put_down(handling.at);
        }
        (self.keeper, self.side, self.is_new) = (Some(agent), side, true);
    }

    fn put_down(&mut self, at: Vec3) {
        (self.keeper, self.rest, self.off, self.ease) = (None, at, self.at - at, 1.0);
        (self.grip, self.is_new) = (self.turn, false);
    }
}

/// Palm and orientation of a hand in the world, and the root of its body.
struct Hand {
    palm: Vec3,
    turn: Quat,
    root: Planar,
}

impl Hand {
    /// Hand of a body; its palm is beyond the wrist along the forearm.
    fn of_body(body: &Followers, agent: usize, side: u8) -> Self {
        let (walkers, row) = body.walkers_of(agent);
        let (root, pose) = (walkers.root(row), walkers.pose(row));
        let [forearm, hand] = ARMS[usize::from(side)].map(|j| &pose[j.index()]);
        let along = maths::rotate(forearm.rotation().conjugate(), hand.translation() - forearm.translation());
        let palm = hand.translation() + maths::rotate(hand.rotation(), along * FIST_PER_FOREARM);
        let palm = maths::rotate(root.rotation(), palm) + root.translation();
        Self { palm, turn: maths::compose(root.rotation(), hand.rotation()), root }
    }

    fn of_bodiless(root: Planar) -> Self {
        Self { palm: root.translation() + Vec3::Y * CARRY_HEIGHT_M, turn: root.rotation(), root }
    }
}

/// Time since the motion of a grasp began; `None` before (s).
fn performed_seconds(performing: Option<PerformanceProgress>, grasp: Grasp) -> Option<f32> {
    let now = performing.filter(|p| Some(p.activity) == grasp.activity)?;
    (now.part != throng_core::walkers::PerformancePart::Turn).then_some(now.seconds)
}

fn smoothstep(share: f32) -> f32 {
    let s = share.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Heading of a direction along the ground (rad).
fn heading_of(direction: Vec3) -> f32 {
    maths::atan2(direction.x, direction.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hands_neither_begin_nor_end_away_from_the_motion_however_short_it_is() {
        for (moment_s, after_s) in [(0.233, 0.32), (0.04, 0.03), (2.0, 2.0)] {
            let grasp = Grasp { moment_s, after_s, palm: Vec3::Y, ..Grasp::default() };
            for height in [0.2, 1.08] {
                let share = |before_s: f32| grasp.approach_share(height, before_s);
                assert!(share(moment_s) < 1e-3, "{moment_s} s before: {}", share(moment_s));
                assert!(share(-after_s) < 1e-3, "{after_s} s after: {}", share(-after_s));
                assert!([1e-4, 0.0, -1e-4].into_iter().all(|before_s| share(before_s) > 0.95), "{}", share(1e-4));
            }
        }
        assert_eq!(Grasp::default().approach_share(1.0, 0.0), 1.0, "a motion that is over at once");
    }

    #[test]
    fn things_drop_out_of_hands_alone() {
        let (at, size_m) = ([1.0, 0.9, 2.0], [0.1, 0.2, 0.1]);
        let cup = ThingConfig { name: "cup".into(), at, size_m, carried: CarryStyle::Level };
        let mut things = Things::new(&[cup]);
        let handling = Handling { thing: 0, puts: false, at: at.into() };
        let seven = Handler { agent: 7, number: 7, from: Vec3::new(1.0, 0.0, 1.5), motion: None };
        let here = |_| Some(Planar::new(1.0, 1.5, 0.0));
        // Somebody without a body is about to take it, and leaves.
        assert!(things.begin_handling(seven, handling).is_none());
        things.drop_thing(0);
        things.update_things(&[], here, 1.0);
        assert_eq!((things.all[0].at, things.all[0].keeper), (at.into(), None));
        // Somebody has it in hand, and leaves: it lies where it was, on the ground.
        things.begin_handling(seven, handling);
        things.update_things(&[], here, 1.0);
        assert_eq!((things.all[0].keeper, things.counts.taken), (Some(7), 1));
        let held = things.all[0].at;
        things.drop_thing(0);
        (0..3).for_each(|_| things.update_things(&[], here, 1.0));
        assert_eq!((things.all[0].at, things.all[0].keeper), (held.with_y(0.1), None));
    }
}
