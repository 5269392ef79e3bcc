//! A shadow-boxer: orthodox, on guard, always about to move.
//!
//! From intention to pose, in this order: `plan` deals footwork, combinations and defences (`moves`), which become
//! keys, steps and blows (`script`) by the postures of `technique` and `posture`, adapted to a target by `attack`;
//! `foot` stands and steps, `body` is balanced over the feet and turns as planned, `fist` strikes from the shoulder of
//! that body.

mod attack;
mod body;
mod fist;
mod foot;
mod moves;
mod plan;
mod posture;
mod script;
mod technique;

use super::frame::{self, ArmPose, BodyPose, Samples};
use super::side::{LateralSide, forward_direction};
use super::signal::{interpolate, smooth};
use super::{SynthConfig, arm::ArmShape};
use body::BoxerBody;
use fist::ArmGoal;
use foot::{BoxerFoot, DesiredFoot};
use glam::DQuat;
use moves::{Defence, HandPunch, Punch, Shuffle};
use plan::BoxingDealer;
use posture::{BoxingHandPose, BoxingPosture};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use script::{BoxingScript, ScriptedBlow};
use technique::Technique;
use throng_core::planar::{twist_about_y, wrap_angle};
use throng_core::{Contacts, Joint, Skeleton};
use throng_motion::clip::ClipSet;

/// Makes the `boxing` set: shadow-boxing with footwork in all directions, straights, hooks and uppercuts of both hands
/// in combinations of two to four, slips, ducks, rolls, blocks and parries, on the default skeleton, with the true
/// foot contacts and a tag on everything that happens.
///
/// - returns clips `boxing_00`, `boxing_01`, ... that begin and end on guard.
pub fn boxing(cfg: &SynthConfig) -> ClipSet {
    let skeleton = Skeleton::default();
    let mut rng = Pcg64Mcg::seed_from_u64(cfg.seed);
    let mut boxer = BoxingDealer::new(cfg.variation);
    let (mut clips, mut seconds) = (Vec::new(), 0.0);
    while seconds < cfg.minutes * 60.0 {
        let wanted = (cfg.minutes * 60.0 - seconds).min(cfg.clip_seconds * rng.random_range(0.7..1.4));
        let script = boxer.shadow_box(wanted, &skeleton, &mut rng);
        seconds += script.duration;
        let samples = Samples::for_clip(script.duration, cfg.rate_hz);
        let rhythm = bounce_rhythm(script.duration, &samples, cfg.variation, &mut rng);
        let bodies = body::follow_script(&script, &skeleton, &samples, &rhythm);
        let arms = LateralSide::BOTH.map(|side| fist::follow_script(side, &script, &bodies, &samples, &skeleton));
        let mut clip = frame::empty_clip(format!("boxing_{:02}", clips.len()), "boxing", cfg);
        for i in samples.frames() {
            let pose = pose(&bodies[i], [&arms[0][i], &arms[1][i]], &skeleton);
            frame::push_pose(&mut clip, &pose, Contacts::NONE, &skeleton);
        }
        frame::add_tags(&mut clip, script.tags);
        clips.push(clip);
    }
    ClipSet { skeleton, clips }
}

/// Strength of the bouncing at every sample, which varies slowly.
fn bounce_rhythm(duration: f64, samples: &Samples, variation: f64, rng: &mut impl Rng) -> Vec<f64> {
    let (mut t, mut knots) = (0.0, Vec::new());
    while t < duration + 2.0 {
        knots.push((t, 0.8 + variation * rng.random_range(-0.7..0.7)));
        t += rng.random_range(0.8..2.0);
    }
    let raw: Vec<f64> = samples.times.iter().map(|&t| interpolate(&knots, t).max(0.0)).collect();
    smooth(&raw, samples.count_within(0.1))
}

fn pose(body: &BoxerBody, arms: [&ArmGoal; 2], skeleton: &Skeleton) -> BodyPose {
    let knees = body.feet.map(|foot| {
        let turned = DQuat::from_rotation_y(-body.facing) * body.hips;
        let hips = body.facing + f64::from(twist_about_y(turned.as_quat()));
        forward_direction(hips + 0.7 * f64::from(wrap_angle((foot.yaw - hips) as f32)))
    });
    let arms = [0, 1].map(|i: usize| arm(LateralSide::BOTH[i], body, arms[i], skeleton));
    BodyPose { root: body.root, hips: body.hips, trunk: body.trunk, arms, feet: body.feet, knees }
}

fn arm(side: LateralSide, body: &BoxerBody, goal: &ArmGoal, skeleton: &Skeleton) -> ArmPose {
    let [_, _, fore, hand] = side.arm();
    let length = |j: Joint| f64::from(skeleton.offsets[j.index()].length());
    let shape = ArmShape { upper_arm: length(fore), forearm: length(hand) };
    let reach = shape.solve(side, goal.shoulder, goal.wrist, goal.pole);
    ArmPose {
        clavicle: goal.clavicle,
        upper_arm: (body.trunk[2] * goal.clavicle).inverse() * reach.upper_arm,
        forearm: ArmShape::forearm(side, reach.elbow, goal.twist),
        hand: DQuat::IDENTITY,
    }
}

#[cfg(test)]
mod tests;
