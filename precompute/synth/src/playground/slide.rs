//! Sitting down at the top of a slide, sliding, and getting up at its lower end.

use super::LegMoments;
use super::body::{Carriage, HandTrack, HoldPoint, SynthHandGrip, hold_on};
use super::course::{SIDE_ASIDE, SIDE_HEIGHT, SlideCourse};
use super::moment::{self, BodyMoment, ease_in_out};
use crate::foot::{FootPose, FootShape};
use crate::frame::{BodyPose, Samples};
use crate::side::{LateralSide, forward, forward_direction, ground_position, left_direction, leftward};
use crate::signal::{PieceEnd, bump, quintic, smooth};
use crate::{track::KeyTrack, walk::footsteps::FeetStance};
use glam::DVec3;
use rand::{Rng, RngExt};
use throng_core::{Contacts, Skeleton};

/// Position before sitting down, relative to the upper edge (m).
pub const BEFORE: f64 = -0.24;
/// Position after getting up, beyond the lower end (m).
const BEYOND: f64 = 0.25;
/// Position at which the hips come down on the deck, relative to the upper edge (m).
const SEATED: f64 = -0.6;
/// Height of the hips joint over the bed (m).
const SEAT: f64 = 0.13;
/// Distance of the hips at rest from the lower end (m).
const REST: f64 = 0.17;
/// Straight distance of the sliding heels ahead of the hips (m).
const LEGS: f64 = 0.78;
/// Height of a sliding ankle over the bed (m).
const HEEL: f64 = 0.08;
/// Coefficient of friction of trousers on steel.
const FRICTION: f64 = 0.47;
/// Drag of the air and the sides, by the square of the speed (1/m).
const DRAG: f64 = 0.17;
/// Deceleration by the feet at the end (m/s^2).
const BRAKING: f64 = 3.2;
/// Time step of the sliding motion (s).
const STEP: f64 = 1.0 / 480.0;

/// Stance after a slide.
pub fn stance_beyond(course: &SlideCourse) -> FeetStance {
    course.ground_stance(course.length() + BEYOND)
}

/// Times of the events on a slide (s).
struct SlideTimes {
    /// Seat touches the deck.
    seat: f64,
    /// Hips begin to move to the edge.
    scoot: f64,
    /// Hips pass the edge.
    go: f64,
    /// Feet stand at the lower end, left and right.
    plant: [f64; 2],
    /// Hips are at rest.
    stop: f64,
    /// Seat leaves the bed.
    rise: f64,
    /// Body is upright.
    up: f64,
}

/// Data of a descent, without its poses.
struct SlideRide<'a> {
    course: &'a SlideCourse,
    times: SlideTimes,
    /// Distances of the hips by time from the start of the scoot (m).
    hips: Vec<f64>,
    hands: [HandTrack; 2],
    body: KeyTrack<Carriage>,
    first: LateralSide,
}

/// Sits down, slides and gets up.
///
/// - `ends`: poses before and after.
/// - returns moments `dt` seconds apart.
pub fn descend(course: &SlideCourse, ends: [&BodyPose; 2], body: &Skeleton, dt: f64, rng: &mut impl Rng) -> LegMoments {
    let ride = plan_ride(course, ends, rng);
    let samples = Samples::spaced(dt, ride.times.up + 0.6);
    let keyed = ride.body.sample(&samples, &[], 0.05);
    let moments = samples.times.iter().zip(keyed).map(|(&t, keyed)| ride.moment_at(t, keyed, ends, body));
    let t = &ride.times;
    (moments.collect(), vec![("sit", 0.5, t.up), ("slide", t.scoot + 0.35, t.stop)])
}

/// Distances of the hips from the scoot until they rest, every [`STEP`] (m).
///
/// Pulled to the edge, then driven by gravity against friction, and braked by the feet so as to rest before the lower
/// end.
fn hips_along_slide(course: &SlideCourse, scoot: f64) -> Vec<f64> {
    const PUSHED: f64 = 0.7;
    let start = -0.03;
    let num = (scoot / STEP) as usize;
    let pushed = PieceEnd { value: start, rate: PUSHED, acceleration: 1.2 };
    let piece = |k: usize| quintic(PieceEnd::at_rest(SEATED), pushed, num as f64 * STEP, k as f64 * STEP);
    let mut out: Vec<f64> = (0..num).map(piece).collect();
    let end = course.length() - REST;
    let (mut s, mut v) = (start, PUSHED);
    while end - s > 1e-4 && out.len() < 60_000 {
        let (sin, cos) = course.point(s).pitch.sin_cos();
        v += (9.81 * (sin - FRICTION * cos) - DRAG * v * v) * STEP;
        v = v.max(0.35).min((2.0 * BRAKING * (end - s)).sqrt());
        s += v * cos * STEP;
        out.push(s.min(end));
    }
    let rest = (0.5 / STEP) as usize;
    out.extend(std::iter::repeat_n(end, rest));
    smooth(&out, (0.045 / STEP) as usize)
}

fn plan_ride<'a>(course: &'a SlideCourse, ends: [&BodyPose; 2], rng: &mut impl Rng) -> SlideRide<'a> {
    let mut vary = |amount: f64| 1.0 + rng.random_range(-amount..amount);
    let seat = 1.95 * vary(0.08);
    let scoot = seat + 0.95 * vary(0.1);
    let pull = 0.95 * vary(0.1);
    let hips = hips_along_slide(course, pull);
    let end = course.length() - REST;
    let when = |s: f64| scoot + hips.partition_point(|h| *h < s) as f64 * STEP;
    let stop = when(end - 2e-3);
    let planted = when(end - 0.2);
    let first = if rng.random_bool(0.5) { LateralSide::Left } else { LateralSide::Right };
    let late = |side: LateralSide| if side == first { 0.0 } else { 0.07 };
    let rise = stop + 0.45 * rng.random_range(0.9..1.3);
    let plant = LateralSide::BOTH.map(|side| planted + late(side));
    let times = SlideTimes { seat, scoot, go: scoot + pull, plant, stop, rise, up: rise + rng.random_range(1.0..1.2) };
    let body = carriages(course, ends, &times, rng);
    let hands = LateralSide::BOTH.map(|side| hand_track(side, course, &times));
    SlideRide { course, times, hips, hands, body, first }
}

/// Coordinates of a world point relative to a course: along it, above the deck or the lower end, and to the left (m).
fn to_course_frame(course: &SlideCourse, origin: f64, p: DVec3) -> DVec3 {
    let plan = course.ground_stance(origin);
    let d = ground_position(p) - plan.at;
    DVec3::new(origin + forward(plan.heading).dot(d), p.y - course.height(origin), leftward(plan.heading).dot(d))
}

/// Keys of hips and trunk: down onto the deck, back during the slide, forward and up at the end. The first channel
/// counts only before the scoot and after the stop.
fn carriages(course: &SlideCourse, ends: [&BodyPose; 2], t: &SlideTimes, rng: &mut impl Rng) -> KeyTrack<Carriage> {
    let a = to_course_frame(course, BEFORE, ends[0].root);
    let b = to_course_frame(course, course.length(), ends[1].root);
    let end = course.length() - REST;
    let key = |s: f64, up: f64, aside: f64, hips: f64, chest: f64, head: f64| Carriage {
        place: DVec3::new(s, up, aside),
        hips: [hips, 0.0],
        chest: [0.0, chest, 0.0],
        head: [0.0, head, 0.0],
    };
    let mut body = KeyTrack::new(Carriage::standing(a));
    let mut push = |t: f64, c: Carriage| body.push(t, c);
    let down = t.seat - 0.4;
    push(0.4, Carriage::standing(a));
    push(0.4 + 0.4 * (down - 0.4), key(BEFORE - 0.16, 0.66, 0.5 * a.z, 0.3, 0.55, 0.35));
    push(0.4 + 0.75 * (down - 0.4), key(BEFORE - 0.25, 0.38, 0.0, 0.12, 0.72, 0.35));
    push(down + 0.1, key(SEATED + 0.05, 0.2, 0.0, -0.12, 0.5, 0.25));
    push(t.seat, key(SEATED, SEAT, 0.0, -0.3, 0.12, 0.2));
    push(t.scoot, key(SEATED, SEAT, 0.0, -0.28, -0.02, 0.22));
    push(t.go - 0.3, key(SEATED, SEAT, 0.0, -0.36, 0.06, 0.22));
    let back = rng.random_range(-0.52..-0.38);
    let leaning = |lean: f64| {
        let c = key(end, SEAT, 0.0, back - 0.22, back + lean, 0.1 + 0.4 * (back + lean));
        if course.bends_left(2.0) {
            Carriage { hips: [back - 0.22, -0.08], chest: [0.08, back + lean, -0.14], head: [0.3, 0.02, -0.08], ..c }
        } else {
            c
        }
    };
    push(t.go + 0.3, leaning(0.0));
    push(t.go + 0.55 * (t.stop - t.go), leaning(0.03));
    push(t.plant[0] - 0.15, Carriage { chest: [0.0, back + 0.1, 0.0], ..leaning(0.1) });
    push(t.stop - 0.1, key(end, SEAT, 0.0, -0.22, 0.12, 0.1));
    push(t.rise - 0.12, key(end + 0.01, SEAT, 0.0, 0.12, 0.6, 0.15));
    push(t.rise + 0.1, key(end + 0.08, SEAT + 0.03, 0.0, 0.3, 0.78, 0.25));
    push(t.rise + 0.45, key(end + 0.26, 0.32, 0.0, 0.3, 0.62, 0.3));
    push(t.up, Carriage::standing(b));
    body
}

/// Motion of a hand: on the deck beside the seat, on the sides to pull, along the sides while sliding, pushing off at
/// the end.
fn hand_track(side: LateralSide, course: &SlideCourse, t: &SlideTimes) -> HandTrack {
    let s = side.sign();
    let late = if side == LateralSide::Left { 0.06 } else { 0.0 };
    let top = SIDE_HEIGHT + 0.04;
    let deck = course.point(SEATED - 0.08).offset_point(s * 0.3, 0.035);
    let edge = course.point(0.07).offset_point(s * SIDE_ASIDE, top);
    let along = DVec3::new(0.1, top - SEAT, s * SIDE_ASIDE);
    let last = course.point(course.length() - REST + 0.1).offset_point(s * SIDE_ASIDE, top);
    let back = forward_direction(course.start.heading) * -0.6;
    let out = left_direction(course.start.heading) * s;
    let pole = back + out * 0.7 - DVec3::Y * 0.2;
    let end_heading = course.ground_stance(course.length()).heading;
    let end_pole = forward_direction(end_heading) * -0.8 + left_direction(end_heading) * (0.5 * s) + DVec3::Y * 0.3;
    let grips = [
        (t.seat - 0.14 + late, t.seat + 0.42 + late, HoldPoint::Still(deck), pole, 0.9),
        (t.scoot - 0.12 + late, t.go - 0.16, HoldPoint::Still(edge), pole, 0.7),
        (t.go + 0.22, t.stop - 0.3, HoldPoint::Along(along), pole, 0.7),
        (t.stop + 0.02, t.rise + 0.2, HoldPoint::Still(last), end_pole, 0.7),
    ];
    let grips = grips.map(|(land, lift, hold, pole, twist)| SynthHandGrip { land, lift, hold, pole, twist }).to_vec();
    HandTrack { side, grips, reach: 0.7, detour: DVec3::Y * 0.06 }
}

impl SlideRide<'_> {
    /// Distance of the hips along the course (m).
    fn hips_at(&self, t: f64) -> f64 {
        let k = ((t - self.times.scoot) / STEP).max(0.0);
        let (i, last) = (k as usize, self.hips.len() - 1);
        let (a, b) = (self.hips[i.min(last)], self.hips[(i + 1).min(last)]);
        a + (b - a) * (k - k.floor())
    }

    /// Keyed posture, with the hips at their sliding position.
    fn carriage_on_hips(&self, t: f64, mut keyed: Carriage) -> Carriage {
        let into = ease_in_out((t - self.times.scoot + 0.2) / 0.2);
        let out_of = ease_in_out((t - self.times.rise + 0.3) / 0.25);
        keyed.place.x += (self.hips_at(t) - keyed.place.x) * into * (1.0 - out_of);
        keyed
    }

    fn moment_at(&self, t: f64, keyed: Carriage, ends: [&BodyPose; 2], skeleton: &Skeleton) -> BodyMoment {
        let carriage = self.carriage_on_hips(t, keyed);
        let at = self.course.point(carriage.place.x);
        let root = at.offset_point(carriage.place.z, carriage.place.y);
        let (hips, trunk) = carriage.rotations(at.heading);
        let seated = t >= self.times.seat && t <= self.times.rise;
        let hanging = ends[usize::from(t > 0.5 * (self.times.go + self.times.stop))];
        let feet = LateralSide::BOTH.map(|side| self.foot(side, t, carriage.place.x, ends, skeleton));
        let knees = LateralSide::BOTH.map(|s| {
            let apart = 0.12 + 0.2 * f64::from(u8::from(seated));
            forward_direction(at.heading) + DVec3::Y + left_direction(at.heading) * (s.sign() * apart)
        });
        let mut body = BodyPose { root, hips, trunk, arms: hanging.arms, feet, knees };
        let beside = |p: DVec3| self.course.point(carriage.place.x + p.x).offset_point(p.z, p.y + SEAT);
        let mut hand_contacts = hold_on(&self.hands, t, &mut body, beside, skeleton);
        if seated {
            hand_contacts.insert(Contacts::SEAT);
        }
        let seat = seated.then(|| self.course.height(carriage.place.x));
        BodyMoment { body, hand_contacts, seat }
    }

    /// Pose of a foot: on the deck, over the edge, sliding ahead, down to the ground.
    fn foot(&self, side: LateralSide, t: f64, hips: f64, ends: [&BodyPose; 2], skeleton: &Skeleton) -> FootPose {
        let shape = FootShape::from_skeleton(skeleton);
        let i = side.index();
        let lift = self.times.seat + if side == self.first { 0.06 } else { 0.3 };
        let (out, land) = (0.62, self.times.plant[i]);
        let brake = land - 0.42;
        let (deck, ground) = (&ends[0].feet[i], &ends[1].feet[i]);
        if t <= lift {
            return *deck;
        }
        if t >= land {
            return *ground;
        }
        let sliding = self.sliding_foot(side, hips, &shape);
        let (from, to, u) = if t < lift + out {
            (deck, &sliding, (t - lift) / out)
        } else if t > brake {
            (&sliding, ground, (t - brake) / (land - brake))
        } else {
            return sliding;
        };
        mix_feet(from, to, ease_in_out(u), 0.05 * bump(u), &shape)
    }

    /// Distance along the course of heels a leg's length ahead of the hips (m).
    fn heel_distance(&self, hips: f64) -> f64 {
        let height = |s: f64| self.course.point(s).at.y;
        (0..6).fold(hips + LEGS, |s, _| {
            let drop = height(hips) - height(s);
            hips + (LEGS * LEGS - drop * drop).max(0.0).sqrt()
        })
    }

    /// Pose of a foot that slides on its heel ahead of the hips.
    fn sliding_foot(&self, side: LateralSide, hips: f64, shape: &FootShape) -> FootPose {
        let s = self.heel_distance(hips);
        let at = self.course.point(s.min(self.course.length() + 0.3));
        let ankle = at.offset_point(side.sign() * 0.115, HEEL);
        let (yaw, pitch) = (at.heading + 0.1 * side.sign(), at.pitch - 1.0);
        FootPose { ground: self.course.height(s), ..shape.pose_at_ankle(ankle, yaw, at.heading, pitch, pitch + 0.1) }
    }
}

/// Interpolates between two poses of a foot, raised by `up`; no part carries weight.
fn mix_feet(a: &FootPose, b: &FootPose, w: f64, up: f64, shape: &FootShape) -> FootPose {
    let FootPose { ankle, yaw, heading, pitch, toe_pitch, ground, .. } = moment::mix_feet(a, b, w);
    FootPose { ground, ..shape.pose_at_ankle(ankle + DVec3::Y * up, yaw, heading, pitch, toe_pitch) }
}
