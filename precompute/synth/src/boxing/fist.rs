//! Path of each fist: on guard with the body, out and back on every blow.
//!
//! A blow is a displacement from the guard that passes its target at full speed in the direction of the blow, so a
//! straight one leaves straight and a bent one swings around, while the guard moves on underneath.

use super::super::arm::ArmShape;
use super::super::side::{LateralSide, forward};
use super::super::signal::{PieceEnd, quintic};
use super::body::BoxerBody;
use super::moves::Punch;
use super::posture::BoxingHandPose;
use super::script::ScriptedBlow;
use super::technique::{self, Technique};
use glam::{DQuat, DVec3};
use throng_core::{Joint, Skeleton};

/// Inputs of an arm's motion.
pub struct ArmTrack<'a> {
    /// Side of the arm.
    pub side: LateralSide,
    /// Pose of the hand without blows, at every sample.
    pub hands: &'a [BoxingHandPose],
    /// The body at every sample.
    pub bodies: &'a [BoxerBody],
    /// Time between samples (s).
    pub dt: f64,
}

/// Lengths and origin of an arm.
struct ArmBuild {
    shape: ArmShape,
    clavicle: DVec3,
    shoulder: DVec3,
}

impl ArmBuild {
    fn from_skeleton(skeleton: &Skeleton, side: LateralSide) -> Self {
        let [clavicle, upper, fore, hand] = side.arm();
        let offset = |j: Joint| skeleton.offsets[j.index()].as_dvec3();
        let shape = ArmShape { upper_arm: offset(fore).length(), forearm: offset(hand).length() };
        Self { shape, clavicle: offset(clavicle), shoulder: offset(upper) }
    }
}

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

/// The arm at every sample.
pub fn follow_track(track: &ArmTrack, strikes: &[ScriptedBlow], skeleton: &Skeleton) -> Vec<ArmGoal> {
    let build = ArmBuild::from_skeleton(skeleton, track.side);
    let mut goals: Vec<ArmGoal> =
        track.bodies.iter().zip(track.hands).map(|(b, h)| on_guard(track.side, b, h, &build)).collect();
    let guard: Vec<DVec3> = goals.iter().map(|g| g.wrist).collect();
    for strike in strikes.iter().filter(|s| s.blow.side() == track.side) {
        let path = BlowPath::from_strike(strike, &goals, &guard, track, &build.shape);
        let (first, last) = (sample(strike.start, track.dt), sample(strike.back, track.dt) + 1);
        let last = last.min(goals.len());
        for (i, goal) in goals.iter_mut().enumerate().take(last).skip(first) {
            goal.wrist = guard[i] + path.displacement_at(i as f64 * track.dt);
        }
    }
    goals
}

fn sample(t: f64, dt: f64) -> usize {
    (t / dt).round().max(0.0) as usize
}

fn on_guard(side: LateralSide, body: &BoxerBody, hand: &BoxingHandPose, build: &ArmBuild) -> ArmGoal {
    let s = side.sign();
    let clavicle = DQuat::from_rotation_y(-s * hand.reach) * DQuat::from_rotation_z(s * hand.shrug);
    let chest = body.trunk[2];
    ArmGoal {
        clavicle,
        shoulder: body.chest + chest * (build.clavicle + clavicle * build.shoulder),
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
    fn from_strike(
        strike: &ScriptedBlow,
        goals: &[ArmGoal],
        guard: &[DVec3],
        track: &ArmTrack,
        arm: &ArmShape,
    ) -> Self {
        let technique = technique::technique_of(strike.blow);
        let last = goals.len() - 1;
        let (hit, longest) = (sample(strike.hit, track.dt).min(last), sample(strike.longest, track.dt).min(last));
        let aim = BlowAim::from_strike(strike, &technique, goals[hit].shoulder, track.bodies[hit].facing, arm);
        let guard_velocity = (guard[(hit + 1).min(last)] - guard[hit.saturating_sub(1)]) / (2.0 * track.dt);
        let target = goals[hit].shoulder + aim.to_target;
        let end = goals[longest].shoulder + aim.wrist_at_end(strike.blow.punch, technique.follow, arm);
        Self {
            strike: *strike,
            hit: target - guard[hit],
            velocity: aim.velocity - guard_velocity,
            longest: end - guard[longest],
        }
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
        let rest = [DVec3::ZERO; 2];
        if t < s.hit {
            piece(rest, [self.hit, self.velocity], s.start, s.hit)
        } else if t < s.longest {
            piece([self.hit, self.velocity], [self.longest, DVec3::ZERO], s.hit, s.longest)
        } else {
            piece([self.longest, DVec3::ZERO], rest, s.longest, s.back)
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
        let ahead = forward(facing + strike.azimuth);
        let ahead = DVec3::new(ahead.x, 0.0, ahead.y);
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
