//! A visit to the desk: walking up, getting between chair and desk, sitting down, working, standing up, walking away.

use super::route::{GroundGoal, walk_route};
use super::work::{self, Worker};
use super::{BEFORE_SEAT, ChairStay, KeyedHandPose, KeyedPosture, MotionScript, ScriptStep, is_blocked};
use crate::{attitude::Attitude, deck::CardDeck, side::LateralSide, walk::footsteps::FeetStance};
use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};
use std::f64::consts::PI;
use throng_core::planar::wrap_angle;

/// Distances from the chair at which clips begin, and at which people stop after walking away (m).
const AWAY: [f64; 2] = [1.6, 2.5];
/// Directions to and from the chair, in degrees from straight behind it, positive to the left: all except that of the
/// desk.
const DIRECTIONS: [f64; 14] =
    [0.0, 18.0, -18.0, 36.0, -36.0, 54.0, -54.0, 72.0, -72.0, 90.0, -90.0, 108.0, -108.0, 8.0];
/// Speeds (m/s).
const SPEEDS: [f64; 4] = [0.8, 0.95, 1.1, 1.2];
/// Distance of the ankles in front of the centre of the seat in sitting (m).
const UNDER_KNEES: f64 = 0.47;
/// Distance of the ankles in front of the centre of the seat before rising (m).
const DRAWN_BACK: f64 = 0.29;

/// Posture of the trunk in sitting: a little slumped.
pub const SITTING: KeyedPosture = KeyedPosture {
    hips: Attitude { yaw: 0.0, pitch: -0.14, list: 0.0 },
    chest: Attitude { yaw: 0.0, pitch: 0.07, list: 0.0 },
    shift: [0.0; 2],
    dip: 0.0,
};

/// Attitude without turn or lean.
const UPRIGHT: Attitude = Attitude { yaw: 0.0, pitch: 0.0, list: 0.0 };
/// Posture between chair and desk: the hips held back, so that the thighs pass the desk's edge.
const SQUEEZED: KeyedPosture = KeyedPosture { hips: UPRIGHT, chest: UPRIGHT, shift: [0.0, -0.025], dip: 0.0 };

/// Hand on the thigh, left; [`KeyedHandPose::mirrored`] for the right one.
pub const LAP: KeyedHandPose = KeyedHandPose {
    held: 1.0,
    room: DVec3::new(0.14, 0.655, 0.31),
    placed: 1.0,
    pole: DVec3::new(0.9, -0.5, -0.6),
    twist: 1.1,
    ..KeyedHandPose::HANGING
};

/// Dealer of visits. One serves all clips of a set, so that directions and work are spread evenly.
pub struct DeskVisitor {
    directions: [CardDeck<f64>; 2],
    sides: [CardDeck<LateralSide>; 2],
    speeds: CardDeck<f64>,
    worker: Worker,
}

impl DeskVisitor {
    /// No visit yet.
    pub fn new() -> Self {
        Self {
            directions: [CardDeck::new(&DIRECTIONS), CardDeck::new(&DIRECTIONS)],
            sides: [CardDeck::new(&LateralSide::BOTH), CardDeck::new(&LateralSide::BOTH)],
            speeds: CardDeck::new(&SPEEDS),
            worker: Worker::new(),
        }
    }

    /// Timeline of visits for about `seconds`, from standing to standing.
    pub fn visits(&mut self, seconds: f64, variation: f64, rng: &mut impl Rng) -> MotionScript {
        let at = self.deal_place(0, rng);
        let mut script = MotionScript::new(FeetStance { at, heading: rng.random_range(-PI..PI) }, variation);
        loop {
            let before = script.now;
            script.wait_until(before + rng.random_range(0.5..1.3));
            script.tag("stand", before);
            // Coming and going take about 17 s.
            let left = seconds - script.now - 17.0;
            self.walk_to_chair(&mut script, rng);
            let work = if left < 32.0 { left } else { rng.random_range(10.0..left.min(34.0)) };
            let [begin, end] = take_seat(&mut script, true, rng);
            script.tags.push(("sit_down", begin, end));
            self.worker.work(&mut script, end, end + work.clamp(6.0, 40.0), rng);
            self.walk_away(&mut script, rng);
            if seconds - script.now < 16.0 {
                let end = script.now;
                script.wait_until(end + 1.0);
                script.tag("stand", end);
                return script;
            }
        }
    }

    /// A position away from the chair.
    fn deal_place(&mut self, deck: usize, rng: &mut impl Rng) -> DVec2 {
        let direction = (self.directions[deck].deal(rng) + rng.random_range(-9.0..9.0)).to_radians();
        let distance = rng.random_range(AWAY[0]..AWAY[1]);
        DVec2::new(direction.sin(), -direction.cos()) * distance
    }

    /// Walks up to a side of the chair and steps in front of it.
    fn walk_to_chair(&mut self, script: &mut MotionScript, rng: &mut impl Rng) {
        let from = script.stance.at;
        // Around the chair only if that is not far.
        let dealt = self.sides[0].deal(rng);
        let side = if from.x.abs() > 0.8 { LateralSide::inside(from.x) } else { dealt };
        let s = side.sign();
        let across = from.y > 0.3;
        let at = DVec2::new(s * rng.random_range(0.62..0.72), if across { 0.02 } else { rng.random_range(0.04..0.14) });
        let arrive = if across { -(s * 2.0 + 0.35)..-(s * 2.0 - 0.35) } else { -0.75..0.75 };
        let cruise = self.speeds.deal(rng);
        let began = walk_route(script, &GroundGoal { at, arrive, cruise }, is_blocked, rng);
        let turned = f64::from(wrap_angle(script.stance.heading as f32));
        if rng.random_bool(0.45) {
            script.wait_until(script.now + rng.random_range(0.3..0.9));
        }
        if turned.abs() > 0.75 {
            script.turn_in_place(-turned + turned.signum() * rng.random_range(0.1..0.4));
        }
        let at = DVec2::new(script.random_offset(0.02, rng), BEFORE_SEAT);
        let to = FeetStance { at, heading: script.random_offset(0.06, rng) };
        let from = script.stance.at;
        let path = |u: f64| {
            let forward = (1.7 * u).min(1.0);
            DVec2::new(from.x + (to.at.x - from.x) * u, from.y + (to.at.y - from.y) * forward)
        };
        script.pose(script.now + 0.6, 0.6, SQUEEZED);
        script.side_step(to, path, rng);
        script.tag("walk", began);
        script.wait_until(script.now + rng.random_range(0.05..0.4));
    }

    /// Stands up, gets out from between chair and desk, and walks away.
    fn walk_away(&mut self, script: &mut MotionScript, rng: &mut impl Rng) {
        let [ready, end] = rise(script, true, rng);
        script.tags.push(("stand_up", ready, end));
        script.wait_until(end + rng.random_range(0.0..0.3));
        let goal = self.deal_place(1, rng);
        let dealt = self.sides[1].deal(rng);
        let side = if goal.x.abs() > 0.6 { LateralSide::inside(goal.x) } else { dealt };
        let began = script.next_lift();
        step_out(script, side, rng);
        let direct = goal - script.stance.at;
        let ahead = direct.x.atan2(direct.y);
        let cruise = self.speeds.deal(rng);
        walk_route(script, &GroundGoal { at: goal, arrive: ahead - 0.9..ahead + 0.9, cruise }, is_blocked, rng);
        script.tag("walk", began);
    }
}

/// Sits down and puts the feet under the knees.
///
/// - `at_desk`: allows a hand to take hold of the desk's edge.
/// - returns begin and end of sitting down (s).
pub fn take_seat(script: &mut MotionScript, at_desk: bool, rng: &mut impl Rng) -> [f64; 2] {
    let begin = script.now;
    let end = begin + 2.0 + script.random_offset(0.25, rng);
    script.sittings.push(ChairStay { down: [begin, end], up: [f64::INFINITY; 2] });
    sit_down(script, begin, end, at_desk, rng);
    let heading = script.stance.heading;
    place_feet(script, UNDER_KNEES, heading, rng);
    [begin, end]
}

/// Draws the feet back and stands up.
///
/// - `at_desk`: allows a hand to push off the desk's edge.
/// - returns begin and end of rising (s).
pub fn rise(script: &mut MotionScript, at_desk: bool, rng: &mut impl Rng) -> [f64; 2] {
    let ready = script.now;
    let heading = script.random_offset(0.04, rng);
    place_feet(script, DRAWN_BACK, heading, rng);
    let begin = script.now;
    let end = begin + 2.0 + script.random_offset(0.2, rng);
    if let Some(sitting) = script.sittings.last_mut() {
        sitting.up = [begin, end];
    }
    stand_up(script, begin, end, at_desk, rng);
    [ready, end]
}

/// Steps sideways to where the path behind is free, turning a little outwards.
fn step_out(script: &mut MotionScript, side: LateralSide, rng: &mut impl Rng) {
    let from = script.stance.at;
    let out = DVec2::new(side.sign() * rng.random_range(0.6..0.7), rng.random_range(0.1..0.2));
    let path = |u: f64| {
        let back = ((u - 0.45) / 0.55).max(0.0);
        DVec2::new(from.x + (out.x - from.x) * u, from.y + (out.y - from.y) * back)
    };
    let heading = side.sign() * rng.random_range(0.0..0.5);
    script.side_step(FeetStance { at: out, heading }, path, rng);
    script.pose(script.now, 0.8, KeyedPosture::default());
}

/// Places one foot after the other at a distance in front of the seat.
fn place_feet(script: &mut MotionScript, ahead: f64, heading: f64, rng: &mut impl Rng) {
    let first = LateralSide::BOTH[usize::from(rng.random_bool(0.5))];
    let ahead = ahead + script.random_offset(0.02, rng);
    let to = FeetStance { at: DVec2::new(script.stance.at.x, ahead), heading };
    let width = 0.22 + script.random_offset(0.03, rng);
    for side in [first, first.other()] {
        script.step(ScriptStep { width, period: 0.56, ..ScriptStep::aside(side, to) });
    }
}

/// Moves trunk and hands while sitting down: the hands to the thighs, or one to the desk.
fn sit_down(script: &mut MotionScript, begin: f64, end: f64, at_desk: bool, rng: &mut impl Rng) {
    let over = end - begin;
    script.pose(end, 0.55 * over, SITTING);
    script.turn_head(begin + 0.45 * over, 0.4 * over, script.random_offset(0.1, rng), 0.12, 0.0);
    script.turn_head(end + 0.2, 0.5 * over, 0.0, 0.1, 0.0);
    let support = if at_desk { LateralSide::BOTH.get(rng.random_range(0..3usize)).copied() } else { None };
    for side in LateralSide::BOTH {
        let lap = mirrored_for_side(side, LAP);
        if support == Some(side) {
            let touch = begin + 0.4 * over;
            let until = begin + 0.72 * over;
            let edge = mirrored_for_side(side, work::over_desk_edge(0.26));
            let above = KeyedHandPose { room: edge.room + DVec3::new(0.0, 0.05, -0.09), ..edge };
            script.hand(side, touch - 0.3, touch - 0.3 - begin, above);
            script.hand(side, touch, 0.3, edge);
            script.hand(side, until, 0.1, edge);
            script.hand(side, until + 0.3, 0.3, above);
            script.hand(side, until + 0.75, 0.45, lap);
            script.rest_hand(side, touch, until);
        } else {
            script.hand(side, begin + 0.85 * over, 0.8 * over, lap);
        }
    }
    script.wait_until(end);
}

/// Moves trunk and hands while standing up: pushes off the thighs, or off the desk with one hand.
fn stand_up(script: &mut MotionScript, begin: f64, end: f64, at_desk: bool, rng: &mut impl Rng) {
    let over = end - begin;
    script.pose(begin + 0.75 * over, 0.75 * over, SQUEEZED);
    script.turn_head(begin + 0.4 * over, 0.35 * over, 0.0, 0.05, 0.0);
    script.turn_head(end, 0.5 * over, 0.0, 0.0, 0.0);
    let support = if at_desk { LateralSide::BOTH.get(rng.random_range(0..3usize)).copied() } else { None };
    for side in LateralSide::BOTH {
        if support == Some(side) {
            let (touch, until) = (begin + 0.15 * over, begin + 0.62 * over);
            let edge = mirrored_for_side(side, work::over_desk_edge(0.26));
            let above = KeyedHandPose { room: edge.room + DVec3::new(0.0, 0.08, -0.05), ..edge };
            script.hand(side, touch - 0.1, 0.45, above);
            script.hand(side, touch, 0.1, edge);
            script.hand(side, until, 0.1, edge);
            script.hand(side, until + 0.25, 0.25, KeyedHandPose { held: 0.8, ..above });
            script.let_hang(side, end + 0.2, end + 0.2 - (until + 0.25));
            script.rest_hand(side, touch, until);
        } else {
            script.let_hang(side, end, 0.6 * over);
        }
    }
    script.wait_until(end);
}

/// Mirrors a pose of the left hand for the right side.
pub fn mirrored_for_side(side: LateralSide, pose: KeyedHandPose) -> KeyedHandPose {
    if side == LateralSide::Left { pose } else { pose.mirrored() }
}
