//! Climbing the ladder: a foot and the opposite hand at a time, with a rung for every step of a foot.

use super::body::{Carriage, HandTrack, HoldPoint, SynthHandGrip, hold_on};
use super::gym::{LADDER, LADDER_FRONT, LEVEL, RAIL_ASIDE, RAIL_TOP, RUNG, RUNG_RADIUS};
use super::moment::{BodyMoment, ease_in_out, mix_turn};
use crate::foot::{FootPose, FootShape};
use crate::frame::{BodyPose, Samples};
use crate::side::{LateralSide, forward_direction, left_direction};
use crate::{signal::bump, track::KeyTrack, walk::footsteps::FeetStance};
use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};
use throng_core::Skeleton;

/// Position of a climber before climbing, relative to the deck's edge (m).
pub const FOOT: f64 = -0.44;
/// Position of a climber after climbing, relative to the deck's edge (m).
pub const HEAD: f64 = 0.24;
/// Rungs below the deck.
const RUNGS: usize = 6;
/// Distance of the hips from the rungs in climbing (m).
const HIPS_OFF: f64 = 0.36;
/// Time of standing before the hands go up (s).
const LEAD: f64 = 0.4;

/// Stance at the ladder, `along` metres from the deck's edge.
pub fn stance(along: f64) -> FeetStance {
    FeetStance { at: LADDER + DVec2::Y * along, heading: 0.0 }
}

/// Contact of a foot.
#[derive(Clone, Copy)]
struct LadderFootStay {
    land: f64,
    lift: f64,
    foot: FootPose,
}

/// Plan of a climb.
struct Climb {
    feet: [Vec<LadderFootStay>; 2],
    hands: [HandTrack; 2],
    body: KeyTrack<Carriage>,
    duration: f64,
}

/// Climbs from one stand to another.
///
/// - `from`, `to`: poses before and after.
/// - returns the moments, `dt` seconds apart.
pub fn climb(from: &BodyPose, to: &BodyPose, skeleton: &Skeleton, dt: f64, rng: &mut impl Rng) -> Vec<BodyMoment> {
    let plan = plan_climb(from, to, skeleton, rng);
    let samples = Samples::spaced(dt, plan.duration);
    let shape = FootShape::from_skeleton(skeleton);
    let moment = |(&t, carriage): (&f64, Carriage)| {
        let (hips, trunk) = carriage.rotations(0.0);
        let p = carriage.place;
        let hanging = if t > 0.5 * plan.duration { to } else { from };
        let feet = plan.feet.each_ref().map(|stays| foot(stays, t, &shape));
        let root = world_point(p.z, p.y, p.x);
        let out = 0.45 * ease_in_out((t - LEAD) / 0.8) * ease_in_out((plan.duration - t) / 1.4);
        let knees = LateralSide::BOTH.map(|s| forward_direction(0.0) + left_direction(0.0) * (s.sign() * (0.08 + out)));
        let mut body = BodyPose { root, hips, trunk, arms: hanging.arms, feet, knees };
        let hand_contacts = hold_on(&plan.hands, t, &mut body, |p| p, skeleton);
        BodyMoment { body, hand_contacts, seat: None }
    };
    samples.times.iter().zip(plan.body.sample(&samples, &[], 0.06)).map(moment).collect()
}

/// World position of a point at the ladder: to the left, up, and ahead of the deck's edge.
fn world_point(aside: f64, up: f64, along: f64) -> DVec3 {
    DVec3::new(LADDER.x + aside, up, LADDER.y + along)
}

fn plan_climb(from: &BodyPose, to: &BodyPose, skeleton: &Skeleton, rng: &mut impl Rng) -> Climb {
    let shape = FootShape::from_skeleton(skeleton);
    let pace = rng.random_range(0.9..1.1);
    let first = if rng.random_bool(0.5) { LateralSide::Left } else { LateralSide::Right };
    // The half cycle `h` begins at `starts[h]`: a foot goes up a rung beyond the other one.
    let mut starts = vec![LEAD + 0.7];
    for h in 0..RUNGS + 2 {
        let length = if h >= RUNGS { 1.0 } else { 0.82 };
        starts.push(starts[h] + length * pace * (1.0 + rng.random_range(-0.07..0.07)));
    }
    let duration = starts[RUNGS + 2] + 0.6;
    let mover = |h: usize| if h.is_multiple_of(2) { first } else { first.other() };
    let feet = LateralSide::BOTH
        .map(|side| feet_of(side, [from, to].map(|p| p.feet[side.index()]), &starts, mover, &shape, rng));
    let hands = LateralSide::BOTH.map(|side| hands_of(side, &starts, mover));
    let body = carriages(from, to, &starts, mover);
    Climb { feet, hands, body, duration }
}

/// Contacts of a foot: the ground, every other rung, the deck.
fn feet_of(
    side: LateralSide,
    [ground, deck]: [FootPose; 2],
    starts: &[f64],
    mover: impl Fn(usize) -> LateralSide,
    shape: &FootShape,
    rng: &mut impl Rng,
) -> Vec<LadderFootStay> {
    let s = side.sign();
    let mut stays = vec![LadderFootStay { land: f64::NEG_INFINITY, lift: f64::INFINITY, foot: ground }];
    for h in (0..RUNGS + 2).filter(|h| mover(*h) == side) {
        let length = starts[h + 1] - starts[h];
        if let Some(last) = stays.last_mut() {
            last.lift = starts[h] + 0.04 * length;
        }
        let foot = if h < RUNGS {
            let aside = s * (0.115 + rng.random_range(-0.01..0.01));
            let up = RUNG * (h + 1) as f64 + RUNG_RADIUS;
            let ball = world_point(aside, up + shape.ball_height, -LADDER_FRONT);
            FootPose { toe_down: true, ground: up, ..shape.contact_pose(ball, 0.16 * s, 0.0, 0.12, 0.0) }
        } else {
            deck
        };
        stays.push(LadderFootStay { land: starts[h] + 0.62 * length, lift: f64::INFINITY, foot });
    }
    stays
}

/// Pose of a foot at an instant.
fn foot(stays: &[LadderFootStay], t: f64, shape: &FootShape) -> FootPose {
    let i = stays.partition_point(|s| s.land <= t).saturating_sub(1);
    let (a, Some(b)) = (&stays[i], stays.get(i + 1)) else { return stays[i].foot };
    if t <= a.lift {
        return a.foot;
    }
    let u = (t - a.lift) / (b.land - a.lift);
    let (on_deck, w) = (b.foot.heel_down, ease_in_out(u));
    // Up before ahead; toes back off the rungs on the way.
    let (up, across) = (ease_in_out(1.0 - (1.0 - u).powf(1.7)), ease_in_out(u.powf(1.7)));
    let (a, b) = (&a.foot, &b.foot);
    let mix = |x: f64, y: f64| x + (y - x) * w;
    let mut ball = a.ball.lerp(b.ball, across);
    let back = if a.ground == 0.0 { 0.03 } else { 0.14 };
    ball.y = a.ball.y + (b.ball.y - a.ball.y) * up + if on_deck { 0.1 } else { 0.05 } * bump(u);
    ball.z -= back * bump(u.powf(0.8));
    let pitch = mix(a.pitch, b.pitch) + 0.35 * bump(u.powf(0.8));
    let toes = mix(a.toe_pitch, b.toe_pitch) + 0.1 * bump(u);
    FootPose {
        ground: mix(a.ground, b.ground),
        ..shape.contact_pose(ball, mix_turn(a.yaw, b.yaw, w), 0.0, pitch, toes)
    }
}

/// Contacts of a hand: rungs, then the rails. The hand moves with the opposite foot, four and a half rungs above it.
fn hands_of(side: LateralSide, starts: &[f64], mover: impl Fn(usize) -> LateralSide) -> HandTrack {
    let s = side.sign();
    let grip = |land: f64, lift: f64, height: f64| {
        // At the top the body passes between the hands, elbows out.
        let (on_rail, at_top) = (height > LEVEL + 0.1, height > RAIL_TOP - 0.1);
        // The bones of the hand pass behind the surface that the palm touches.
        let behind = RUNG_RADIUS + 0.026;
        let (aside, along) = if on_rail { (RAIL_ASIDE - 0.02, behind + 0.012) } else { (0.19, behind) };
        SynthHandGrip {
            land,
            lift,
            hold: HoldPoint::Still(world_point(s * aside, height.min(RAIL_TOP - 0.06), -LADDER_FRONT - along)),
            pole: if at_top { DVec3::new(0.9 * s, -0.3, -0.4) } else { DVec3::new(0.45 * s, -1.0, -0.3) },
            twist: if on_rail { 0.25 } else { 1.0 },
        }
    };
    let early = usize::from(mover(0) == side);
    let reach = starts[0] - 0.12 * early as f64;
    // Before the climb: one hand on the fourth rung, the one that stays longer on the fifth.
    let mut grips = vec![grip(reach, f64::INFINITY, RUNG * (5 - early) as f64)];
    for h in (1..=RUNGS).filter(|h| mover(*h) != side) {
        let length = starts[h + 1] - starts[h];
        let last = grips.len() - 1;
        grips[last].lift = starts[h] + 0.36 * length;
        grips.push(grip(starts[h] + 0.88 * length, f64::INFINITY, RUNG * (h + 5) as f64));
    }
    let last = grips.len() - 1;
    let over = starts[RUNGS + 1];
    grips[last].lift = over + 0.28 + 0.14 * early as f64;
    HandTrack { side, grips, reach: 0.62, detour: DVec3::new(0.03 * s, 0.03, -0.07) }
}

/// Keys of hips and trunk: to the ladder, up by a rung for every half cycle, over the edge, upright.
fn carriages(
    from: &BodyPose,
    to: &BodyPose,
    starts: &[f64],
    mover: impl Fn(usize) -> LateralSide,
) -> KeyTrack<Carriage> {
    let local = |p: DVec3| DVec3::new(p.z - LADDER.y, p.y, p.x - LADDER.x);
    let (a, b) = (local(from.root), local(to.root));
    let off = -LADDER_FRONT - HIPS_OFF;
    let mut body = KeyTrack::new(Carriage::standing(a));
    body.hold(LEAD);
    let climbing = |h: f64, to_foot: f64| Carriage {
        place: DVec3::new(off, RUNG * h + 0.6, 0.03 * to_foot),
        hips: [0.1, 0.03 * to_foot],
        chest: [-0.05 * to_foot, 0.12, -0.04 * to_foot],
        head: [0.0, -0.18, 0.0],
    };
    // The weight moves to the standing foot, opposite to the moving one.
    let ready = climbing(1.0, mover(0).other().sign());
    body.push(starts[0], Carriage { place: DVec3::new(off + 0.02, a.y - 0.01, ready.place.z), ..ready });
    for h in 1..=RUNGS {
        let to_foot = mover(h).other().sign();
        body.push(starts[h], climbing(h as f64, to_foot));
        let middle = starts[h] + 0.6 * (starts[h + 1] - starts[h]);
        body.push(middle, climbing(h as f64 + 0.5, to_foot));
    }
    let (over, up) = (starts[RUNGS + 1], starts[RUNGS + 2]);
    let lean = |along: f64, height: f64, to_foot: f64, pitch: f64| Carriage {
        place: DVec3::new(along, height, 0.03 * to_foot),
        hips: [0.1 + 0.35 * pitch, 0.0],
        chest: [0.0, pitch, 0.0],
        head: [0.0, 0.1 + 0.2 * pitch, 0.0],
    };
    let foot = mover(RUNGS).sign();
    body.push(over, lean(-0.2, RUNG * 7.0 + 0.62, foot, 0.35));
    body.push(0.5 * (over + up), lean(0.06, RUNG * 7.0 + 0.8, foot, 0.3));
    body.push(up + 0.15, Carriage::standing(b));
    body
}
