//! Path of each fist: on guard with the body, out and back on every blow.
//!
//! A blow is a displacement from the guard that passes its target at full speed in the direction of the blow, so a
//! straight one leaves straight and a bent one swings around, while the guard moves on underneath.

use super::technique::{self, Technique};
use super::{BoxerBody, BoxingHandPose, BoxingScript, Punch, ScriptedBlow};
use crate::side::{LateralSide, forward, over_ground};
use crate::signal::{PieceEnd, quintic};
use crate::{arm::ArmShape, frame::Samples};
use glam::{DQuat, DVec3};
use throng_core::Skeleton;

/// An arm at one sample: the clavicle's rotation against the upper chest, shoulder, wrist and pole in the world.
#[derive(Clone, Copy, Debug)]
pub struct ArmGoal {
    /// Rotation of the clavicle relative to the upper chest.
    pub clavicle: DQuat,
    /// Shoulder joint (m).
    pub shoulder: DVec3,
    /// Wrist (m).
    pub wrist: DVec3,
    /// Direction of the elbow.
    pub pole: DVec3,
    /// Twist of the forearm (rad).
    pub twist: f64,
}

/// The arm of a side at every sample of a script.
pub fn follow_script(
    side: LateralSide,
    script: &BoxingScript,
    bodies: &[BoxerBody],
    samples: &Samples,
    skeleton: &Skeleton,
) -> Vec<ArmGoal> {
    let dt = samples.dt;
    let [clavicle, upper, fore, hand] = side.arm().map(|j| skeleton.offsets[j.index()].as_dvec3());
    let arm = ArmShape { upper_arm: fore.length(), forearm: hand.length() };
    let hands = script.hands[side.index()].sample(samples, &BoxingHandPose::AHEAD, 0.02);
    let on_guard = |(body, hand): (&BoxerBody, &BoxingHandPose)| on_guard(side, body, hand, [clavicle, upper]);
    let guard: Vec<ArmGoal> = bodies.iter().zip(&hands).map(on_guard).collect();
    let mut goals = guard.clone();
    for strike in script.strikes.iter().filter(|s| s.blow.side() == side) {
        let path = BlowPath::from_strike(strike, &guard, bodies, &arm, dt);
        let (first, last) = (sample(strike.start, dt), sample(strike.back, dt) + 1);
        for (i, goal) in goals.iter_mut().enumerate().take(last).skip(first) {
            goal.wrist = guard[i].wrist + path.displacement_at(i as f64 * dt);
        }
    }
    goals
}

fn sample(t: f64, dt: f64) -> usize {
    (t / dt).round().max(0.0) as usize
}

/// Arm without blows; `offsets` are those of clavicle and shoulder.
fn on_guard(side: LateralSide, body: &BoxerBody, hand: &BoxingHandPose, offsets: [DVec3; 2]) -> ArmGoal {
    let s = side.sign();
    let clavicle = DQuat::from_rotation_y(-s * hand.reach) * DQuat::from_rotation_z(s * hand.shrug);
    ArmGoal {
        clavicle,
        shoulder: body.chest + body.trunk[2] * (offsets[0] + clavicle * offsets[1]),
        wrist: body.neck + body.guard * hand.guard,
        pole: DQuat::from_rotation_y(body.facing) * hand.pole,
        twist: hand.twist,
    }
}

/// A blow, as displacements from the guard.
struct BlowPath {
    strike: ScriptedBlow,
    hit: DVec3,
    velocity: DVec3,
    longest: DVec3,
}

impl BlowPath {
    /// - `guard`: the arm without blows.
    fn from_strike(strike: &ScriptedBlow, guard: &[ArmGoal], bodies: &[BoxerBody], arm: &ArmShape, dt: f64) -> Self {
        let technique = technique::technique_of(strike.blow);
        let last = guard.len() - 1;
        let [hit, longest] = [strike.hit, strike.longest].map(|t| sample(t, dt).min(last));
        let aim = BlowAim::from_strike(strike, &technique, guard[hit].shoulder, bodies[hit].facing, arm);
        let guard_velocity = (guard[(hit + 1).min(last)].wrist - guard[hit.saturating_sub(1)].wrist) / (2.0 * dt);
        let target = guard[hit].shoulder + aim.to_target;
        let end = guard[longest].shoulder + aim.wrist_at_end(strike.blow.punch, technique.follow, arm);
        let velocity = aim.velocity - guard_velocity;
        Self { strike: *strike, hit: target - guard[hit].wrist, velocity, longest: end - guard[longest].wrist }
    }

    /// Displacement from the guard at `t` seconds (m).
    fn displacement_at(&self, t: f64) -> DVec3 {
        let s = &self.strike;
        let piece = |from: [DVec3; 2], to: [DVec3; 2], begin: f64, end: f64| {
            let axis = |i: usize| {
                let ends = [from, to].map(|[value, rate]| PieceEnd::moving(value[i], rate[i]));
                quintic(ends[0], ends[1], end - begin, t.clamp(begin, end) - begin)
            };
            DVec3::new(axis(0), axis(1), axis(2))
        };
        let (rest, hit, longest) = ([DVec3::ZERO; 2], [self.hit, self.velocity], [self.longest, DVec3::ZERO]);
        if t < s.hit {
            piece(rest, hit, s.start, s.hit)
        } else if t < s.longest {
            piece(hit, longest, s.hit, s.longest)
        } else {
            piece(longest, rest, s.longest, s.back)
        }
    }
}

/// Target of a blow, relative to the shoulder.
struct BlowAim {
    to_target: DVec3,
    velocity: DVec3,
}

/// Steepest direction from the shoulder to a target (sine).
const STEEPEST: f64 = 0.6;

impl BlowAim {
    fn from_strike(strike: &ScriptedBlow, technique: &Technique, shoulder: DVec3, facing: f64, arm: &ArmShape) -> Self {
        let length = strike.stretch * arm.length();
        let rise = ((strike.height - shoulder.y) / length).clamp(-STEEPEST, STEEPEST);
        let ahead = over_ground(forward(facing + strike.azimuth), 0.0);
        let inward = DVec3::Y.cross(ahead) * -strike.blow.side().sign();
        let away = ahead * (1.0 - rise * rise).sqrt() + DVec3::Y * rise;
        // Straights go out along the arm; bent blows keep their own directions at any height.
        let out = if strike.blow.punch == Punch::Straight { away } else { ahead };
        let along = inward * technique.along.x + DVec3::Y * technique.along.y + out * technique.along.z;
        Self { to_target: away * length, velocity: along.normalize_or(away) * strike.speed }
    }

    /// Position of the wrist at the end of a blow, relative to the shoulder: straights stretch the arm, bent blows
    /// continue around the shoulder.
    fn wrist_at_end(&self, punch: Punch, follow: f64, arm: &ArmShape) -> DVec3 {
        let away = self.to_target.normalize_or(DVec3::Z);
        if punch == Punch::Straight {
            return away * (0.975 * arm.length());
        }
        let across = (self.velocity - away * self.velocity.dot(away)).normalize_or(DVec3::Y);
        let angle = follow / self.to_target.length();
        (away * angle.cos() + across * angle.sin()) * (self.to_target.length() + 0.12 * follow)
    }
}
