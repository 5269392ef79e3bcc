//! Which blows land, and where.

use super::body::{Body, NUM_CAPSULES, Part, Posed};
use super::config::SparringConfig;
use super::distance::{nearest_points, point_to_segment};
use throng_base::Id;
use throng_core::characters::Blow;
use throng_core::skeleton::Joint;

/// A blow that met the opponent's body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// The blow.
    pub blow: Blow,
    /// Who is struck.
    pub opponent: Id,
    /// What of them.
    pub part: Part,
    /// The joint that is pushed.
    pub joint: Joint,
    /// How far the striking point is within reach of that part (m, >= 0).
    pub depth_m: f32,
}

impl Landing {
    /// True where arms caught the blow.
    pub fn is_blocked(&self) -> bool {
        self.part == Part::Arm
    }
}

/// The capsule that a blow meets, and how deep: an arm that lies in the last part of its way, else the capsule
/// that is reached deepest.
pub(crate) fn meet(config: &SparringConfig, body: &Body, pose: &Posed<'_>, blow: &Blow) -> Option<(usize, f32)> {
    let way = [blow.point - blow.direction * config.block_m, blow.point];
    let capsules = body.capsules(pose);
    let deepest = |found: Option<(usize, f32)>, (i, depth): (usize, f32)| match found {
        Some((_, deep)) if deep >= depth => found,
        _ if depth >= 0.0 => Some((i, depth)),
        _ => found,
    };
    let arms = (0..NUM_CAPSULES).filter(|&i| body.part(i) == Part::Arm);
    let caught = arms.map(|i| {
        let [p, q] = nearest_points(way, capsules[i].ends);
        (i, capsules[i].radius + config.body.hand_m - p.distance(q))
    });
    if let Some(arm) = caught.fold(None, deepest) {
        return Some(arm);
    }
    let others = (0..NUM_CAPSULES).filter(|&i| body.part(i) != Part::Arm);
    let reached = others.map(|i| {
        let c = &capsules[i];
        (i, c.radius + config.reach_m - point_to_segment(blow.point, c.ends))
    });
    reached.fold(None, deepest)
}
