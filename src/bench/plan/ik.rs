//! Inverse kinematics of an arm on random poses.

use glam::DVec3;
use std::time::Instant;
use throng_core::Skeleton;
use throng_planner::ik::LimbIk;
use throng_planner::limits::{BodyLimits, PoseSampler, Style};
use throng_planner::linkage::{Chain, Limb, LimbPose};
use throng_planner::rotation::{Rigid, exp};

/// Figures of inverse kinematics.
pub struct IkFigures {
    pub ns: f64,
    pub error_max_m: f64,
    pub solved_fraction: f64,
}

/// Solves for hand targets taken from random poses within limits, beginning at other poses.
pub fn measure(poses: u32) -> IkFigures {
    let (skeleton, limb) = (Skeleton::default(), Limb::LeftArm);
    let chain = Chain::new(limb, &skeleton);
    let Some(limits) = BodyLimits::built_in(&skeleton).limb_limits(limb) else {
        return IkFigures { ns: 0.0, error_max_m: 0.0, solved_fraction: 0.0 };
    };
    let ik = LimbIk::new(&chain, &limits);
    let sampler = PoseSampler::new(limits, &LimbPose::REST, Style::default(), 1);
    let mut rng = throng_planner::planner::seeded_rng(1);
    // Prepared before timing begins.
    let cases: Vec<(Rigid, Rigid, LimbPose)> = (0..poses.min(10_000))
        .map(|i| {
            let v = DVec3::new(0.7, 1.3, -0.4) * f64::from(i % 97) * 0.02;
            let base = Rigid { position: v, rotation: exp(v) };
            let wanted = sampler.draw_pose(&mut rng, 1);
            (base, chain.place_joints(&base, &wanted)[2], sampler.draw_pose(&mut rng, 1))
        })
        .collect();
    let (mut solved, mut error_max_m) = (0u32, 0.0f64);
    let began = Instant::now();
    for i in 0..poses as usize {
        let (base, goal, present) = &cases[i % cases.len()];
        if let Ok(pose) = ik.solve_free(base, goal, present) {
            solved += 1;
            error_max_m = error_max_m.max(chain.place_joints(base, &pose)[2].position.distance(goal.position));
        }
    }
    let ns = began.elapsed().as_secs_f64() * 1e9 / f64::from(poses);
    IkFigures { ns, error_max_m, solved_fraction: f64::from(solved) / f64::from(poses) }
}
