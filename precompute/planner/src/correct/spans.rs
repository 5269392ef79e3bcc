//! Stretches of a motion that collide.

use crate::collide::Checker;
use crate::problem::{EXTERNAL_STEP_S, LimbState, Problem};
use schemars::JsonSchema;
use serde::Serialize;

/// A stretch of time in which a limb collides by the motion itself. The names of the fields are keys of JSON reports.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CollisionStretch {
    /// Begin (s).
    pub from_s: f64,
    /// End (s).
    pub to_s: f64,
    /// Part of the limb, or held capsule, that is deepest.
    pub part: String,
    /// Obstacle that it is in.
    #[serde(rename = "obstacle")]
    pub with: String,
    /// Largest depth (m).
    pub depth_m: f64,
}

/// Penetration below which rounding alone may explain it (m).
const NEGLIGIBLE_M: f64 = 1e-4;

/// Stretches in which the external motion's own poses of the limb collide, sampled 120 times a second.
pub fn find_collisions(problem: &Problem) -> Vec<CollisionStretch> {
    let mut checker = Checker::default();
    let mut spans: Vec<CollisionStretch> = Vec::new();
    let mut inside = false;
    let [from, to] = [problem.init.time_s, problem.goal.time_s];
    for step in 0..problem.external_poses.len() {
        let time_s = (from + step as f64 * EXTERNAL_STEP_S).min(to);
        let state = LimbState { pose: problem.external_pose_at(time_s), time_s };
        let hit = checker.deepest_hit(problem, &state).filter(|h| h.depth_m > NEGLIGIBLE_M);
        let goes_on = std::mem::replace(&mut inside, hit.is_some());
        let Some(hit) = hit else { continue };
        let ([part, with], depth_m) = (problem.hit_names(&hit), hit.depth_m);
        match spans.last_mut().filter(|_| goes_on) {
            Some(span) if depth_m > span.depth_m => {
                (span.to_s, span.part, span.with, span.depth_m) = (time_s, part, with, depth_m);
            }
            Some(span) => span.to_s = time_s,
            None => spans.push(CollisionStretch { from_s: time_s, to_s: time_s, part, with, depth_m }),
        }
    }
    spans
}
