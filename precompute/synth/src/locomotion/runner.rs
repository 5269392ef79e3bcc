//! Jogging and running: the body bounces from foot to foot, leans into its path, and swings its bent arms.

use super::swing::{LegKey, RunnerFoot, RunnerSwing};
use super::{ActTimes, AlternatingFootfalls, LocomotionAct, Manner, Stride, apply_manner};
use crate::attitude::{Attitude, Trunk, trunk_between};
use crate::frame::{ArmPose, BodyPose};
use crate::side::{LateralSide, ground_position, over_ground};
use crate::walk::assemble::{drift, knees};
use crate::walk::roll::{Footfall, standing};
use crate::{foot::FootShape, leg::LegShape, walk::arms::ArmAngles, walk::trunk::Drift};
use glam::DVec3;
use rand::Rng;
use std::f64::consts::{PI, TAU};

/// Height of the hips over the ankles of a leaning runner (m).
const LEANING_HEIGHT: f64 = 0.72;
/// Least knee flexion of a leg on the ground (rad).
const FLEXION: f64 = 0.3;
/// Share of a manner's crouch for runners, as their hips are low already.
const CROUCH: f64 = 0.4;
/// Share of the wandering of gaze and arms for runners.
const CALM: f64 = 0.3;
/// Phases of the cycle, where 0 is the left foot's landing: the left leg is furthest forward, and the body rests on the
/// left leg.
const LEFT_LEG_AHEAD: f64 = 0.93;
const ON_LEFT_LEG: f64 = 0.17;

/// Poses of running.
pub fn poses_of_running(act: &LocomotionAct, scene: &ActTimes, rng: &mut impl Rng) -> Vec<BodyPose> {
    let stride = Stride::for_act(act);
    let outward = -act.drive.centripetal_acceleration() / GRAVITY * LEANING_HEIGHT;
    let falls = AlternatingFootfalls::generate(act, outward, scene.time(), scene.variation, rng);
    let bounce = Bounce { period: stride.period, contact: stride.stance };
    let mut body = RunnerBody { act, falls, bounce, level: 0.0 };
    let shape = FootShape::from_skeleton(&scene.skeleton);
    body.level = body.highest(scene, &shape) - CROUCH * act.manner.crouch;
    let manner = Manner { crouch: 0.0, ..*act.manner };
    let leg = LegShape::from_skeleton(&scene.skeleton);
    let hip = |side, t| body.hip(scene, side, t);
    let keys = leg_keys(act.drive.ahead, act.manner.knee_lift);
    let swing = RunnerSwing { drive: act.drive, keys, hip: &hip, bank: body.bank(), leg };
    let feet = LateralSide::BOTH.map(|s| RunnerFoot::new(s, shape, body.falls.feet[s.index()].clone(), &swing));
    let speed = vec![act.drive.ahead; scene.samples.times.len()];
    let drift = drift(scene.time().end, &scene.samples, &speed, CALM * scene.variation, rng);
    let pose = |(i, &t): (usize, &f64)| {
        let (attitude, root) = (body.hips(t), body.position(t));
        let (hips, feet) = (attitude.rotation(), LateralSide::BOTH.map(|s| feet[s.index()].pose(t, hip(s, t))));
        let trunk = body.trunk(t, attitude, &drift, i);
        let arms = LateralSide::BOTH.map(|s| body.arm(t, s, trunk[2].pitch, &drift, i));
        let knees = knees(root, hips, &feet);
        let mut pose = BodyPose { root, hips, trunk: trunk.map(Attitude::rotation), arms, feet, knees };
        apply_manner(&mut pose, &manner);
        pose
    };
    scene.samples.times.iter().enumerate().map(pose).collect()
}

/// Keys of the leg: folds after toe-off, passes under the body bent, lifts the knee and reaches out.
///
/// # Source
/// Sizes of the angles as in Novacheck 1998, *The biomechanics of running*. Differs: the thigh's are relative to the
/// vertical here, not to the pelvis.
fn leg_keys(speed: f64, lift: f64) -> [LegKey; 3] {
    let faster = speed - 2.0;
    let fold = (1.45 + 0.18 * faster) * lift;
    let knee_up = (0.54 + 0.06 * faster) * lift;
    [
        LegKey { at: 0.26, thigh: -0.16, knee: 0.8 * fold, ankle: 0.2 },
        LegKey { at: 0.48, thigh: 0.5 * knee_up, knee: fold, ankle: 0.05 },
        LegKey { at: 0.74, thigh: knee_up, knee: 0.76 * fold, ankle: -0.05 },
    ]
}

/// The body of a runner over time.
struct RunnerBody<'a> {
    act: &'a LocomotionAct,
    falls: AlternatingFootfalls,
    bounce: Bounce,
    /// Height of the hips at landing (m).
    level: f64,
}

impl RunnerBody<'_> {
    /// Cosine wave over the cycle with its crest at `peak`.
    fn cosine_wave(&self, t: f64, peak: f64) -> f64 {
        (TAU * (self.falls.phase_at(t) - peak)).cos()
    }

    /// Lean from the vertical on the arc, to the left (rad).
    fn bank(&self) -> f64 {
        (self.act.drive.centripetal_acceleration().x / GRAVITY).atan()
    }

    /// Height of the hips joint (m).
    fn height(&self, t: f64) -> f64 {
        self.level + self.bounce.height(self.falls.step_at(t).fract() * self.bounce.period)
    }

    /// Position of the hips joint (m).
    fn position(&self, t: f64) -> DVec3 {
        let p = self.act.drive.point_at(t, 0.011 * self.cosine_wave(t, ON_LEFT_LEG), 0.0);
        over_ground(p, self.height(t))
    }

    /// Hip joint of a side (m).
    fn hip(&self, scene: &ActTimes, side: LateralSide, t: f64) -> DVec3 {
        self.position(t) + self.hips(t).rotation() * scene.skeleton.offsets[side.leg()[0].index()].as_dvec3()
    }

    fn hips(&self, t: f64) -> Attitude {
        let sway = self.act.manner.sway;
        Attitude {
            yaw: self.act.drive.heading_at(t) - 0.1 * sway * self.cosine_wave(t, LEFT_LEG_AHEAD),
            pitch: 0.1 + 0.015 * self.act.drive.ahead,
            list: 0.055 * sway * self.cosine_wave(t, ON_LEFT_LEG) - self.bank(),
        }
    }

    /// Trunk: the chest turns against the pelvis, and the head keeps to the path.
    fn trunk(&self, t: f64, hips: Attitude, drift: &Drift, i: usize) -> Trunk {
        let (drive, speed) = (self.act.drive, self.act.drive.ahead);
        let chest = Attitude {
            yaw: drive.heading_at(t) + 0.15 * self.cosine_wave(t, LEFT_LEG_AHEAD + 0.02) + 0.15 * drift.gaze[i],
            pitch: 0.08 + 0.03 * speed - 0.012 * drift.breath[i],
            list: -0.9 * self.bank() - 0.03 * self.cosine_wave(t, ON_LEFT_LEG),
        };
        let head = Attitude {
            yaw: drive.heading_at(t) + 0.3 * drive.gyration + drift.gaze[i],
            pitch: 0.05 + drift.nod[i] + 0.7 * (self.height(t) - self.level),
            list: -0.45 * self.bank(),
        };
        trunk_between(hips, chest, head)
    }

    /// Bent arm that swings against the legs; the elbow closes in front and opens behind.
    fn arm(&self, t: f64, side: LateralSide, chest_pitch: f64, drift: &Drift, i: usize) -> ArmPose {
        let faster = self.act.drive.ahead - 2.0;
        let ahead = LEFT_LEG_AHEAD + if side == LateralSide::Left { 0.5 } else { 0.0 };
        let wave = self.cosine_wave(t, ahead + 0.03);
        let lively = self.act.manner.arm_swing.sqrt();
        let swing = -0.3 + (0.36 + 0.07 * faster) * lively * wave + drift.arms[side.index()][i];
        ArmAngles {
            swing: swing + 0.45 * chest_pitch,
            abduction: 0.26,
            turn_in: 0.27 + 0.12 * wave,
            flexion: 1.5 + 0.22 * lively * self.cosine_wave(t, ahead + 0.07),
            protraction: 0.1 * wave,
            shrug: -0.03 + 0.015 * drift.breath[i],
            wrist: 0.15 + 0.08 * wave,
        }
        .pose(side)
    }

    /// Largest height at landing at which both legs reach the ground, over all contacts (m).
    fn highest(&self, scene: &ActTimes, shape: &FootShape) -> f64 {
        let reach = LegShape::from_skeleton(&scene.skeleton).reach(FLEXION);
        let limit = |side: LateralSide, fall: &Footfall, t: f64| {
            let (ankle, hip) = (standing(shape, fall, t).ankle, self.hip(scene, side, t));
            let across = ground_position(ankle - hip).length_squared();
            ankle.y + (reach * reach - across).max(0.01).sqrt() - hip.y + self.level
        };
        let limits = LateralSide::BOTH.into_iter().flat_map(|side| {
            let within = self.falls.feet[side.index()].iter().filter(|f| scene.time().contains(&f.land));
            within.map(move |fall| {
                let moments = (0..=24).map(|k| fall.land + (fall.lift - fall.land) * f64::from(k) / 24.0);
                moments.map(|t| limit(side, fall, t)).fold(f64::INFINITY, f64::min)
            })
        });
        limits.fold(f64::INFINITY, f64::min)
    }
}

/// Standard gravity (m/s^2).
pub const GRAVITY: f64 = 9.81;

/// Vertical motion over one step. The ground pushes with half a sine wave during the contact, which comes first.
///
/// # Source
/// Blickhan 1989, *The spring-mass model for running and hopping*: a stiff spring pushes with half a sine wave. Its
/// strength follows from the impulse, which is that of gravity over the whole step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// Time of a step (s).
    pub period: f64,
    /// Time of a contact (s, > 0, < period).
    pub contact: f64,
}

impl Bounce {
    /// Height above that at landing (m).
    ///
    /// - `t`: since landing (s, 0 to period).
    pub fn height(&self, t: f64) -> f64 {
        let (period, contact) = (self.period, self.contact);
        // The landing speed equals the take-off speed: that of half a flight in gravity.
        let landing = -0.5 * GRAVITY * (period - contact);
        let free = landing * t - 0.5 * GRAVITY * t * t;
        // The push, integrated twice.
        let on = t.min(contact);
        let pushed = 0.5 * GRAVITY * period * (on - contact / PI * (PI * on / contact).sin());
        free + pushed + GRAVITY * period * (t - on)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::signal::PieceEnd;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn falls_freely_in_flight_and_comes_back(period in 0.25f64..0.5, share in 0.4f64..0.95) {
            let b = Bounce { period, contact: share * period };
            prop_assert!(b.height(period).abs() < 1e-9 && b.height(0.0).abs() < 1e-12);
            let flight = period - b.contact;
            let air = PieceEnd::from_function(|t| b.height(t), b.contact + 0.5 * flight);
            prop_assert!((air.acceleration + GRAVITY).abs() < 1e-3 && air.rate.abs() < 1e-6);
            let up = PieceEnd::from_function(|t| b.height(t), b.contact);
            let down = PieceEnd::from_function(|t| b.height(t), 2e-4);
            prop_assert!((up.rate - 0.5 * GRAVITY * flight).abs() < 1e-3);
            prop_assert!((down.rate + 0.5 * GRAVITY * flight).abs() < 0.01);
        }
    }

    #[test]
    fn bodies_sink_on_the_ground_by_as_much_as_runners_do() {
        let b = Bounce { period: 0.345, contact: 0.22 };
        let deepest = -b.height(0.11);
        assert!((0.03..0.08).contains(&deepest), "{deepest}");
        assert!((0.01..0.03).contains(&b.height(0.5 * (0.345 + 0.22))));
    }
}
