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

/// Stretches in which the external motion's own poses of the linkage collide, sampled 120 times a second.
pub fn find_collisions(problem: &Problem) -> Vec<CollisionStretch> {
    let mut checker = Checker::default();
    let mut spans: Vec<CollisionStretch> = Vec::new();
    let mut inside = false;
    let [from, to] = [problem.init.time_s, problem.goal.time_s];
    for step in 0..problem.external_poses.len() {
        let time_s = (from + step as f64 * EXTERNAL_STEP_S).min(to);
        let state = LimbState { pose: problem.external_pose_at(time_s), time_s };
        let hit = checker.deepest_hit(problem, &state).filter(|h| h.depth_m > NEGLIGIBLE_M);
        match (&hit, inside) {
            (Some(hit), true) => {
                if let Some(span) = spans.last_mut() {
                    span.to_s = time_s;
                    if hit.depth_m > span.depth_m {
                        let [part, with] = problem.hit_names(hit);
                        (span.part, span.with, span.depth_m) = (part, with, hit.depth_m);
                    }
                }
            }
            (Some(hit), false) => {
                let [part, with] = problem.hit_names(hit);
                spans.push(CollisionStretch { from_s: time_s, to_s: time_s, part, with, depth_m: hit.depth_m });
            }
            (None, _) => {}
        }
        inside = hit.is_some();
    }
    spans
}
