//! Landing of blows: which ones land, and where.

use super::body::{NUM_CAPSULES, SparringBody, StruckPart, WorldPose};
use super::config::SparringConfig;
use throng_base::{Id, thresholds::FIST_REACH_M};
use throng_core::{characters::Blow, skeleton::Joint};
use throng_geometry::nearest_points;

/// Blow that met the opponent's body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlowLanding {
    /// The blow.
    pub blow: Blow,
    /// Struck opponent.
    pub opponent: Id,
    /// Struck part of the opponent.
    pub part: StruckPart,
    /// Joint that is pushed.
    pub joint: Joint,
    /// Depth of the striking point within reach of that part (m, >= 0).
    pub depth_m: f32,
}

impl BlowLanding {
    /// True where an arm caught the blow.
    pub fn is_blocked(&self) -> bool {
        self.part == StruckPart::Arm
    }
}

/// Capsule that a blow meets on the last part of its path, and the depth (m): an arm, else the capsule that is reached
/// deepest. An opponent that stands nearer than the end of the blow is struck on its path.
pub(crate) fn find_struck_capsule(
    config: &SparringConfig,
    body: &SparringBody,
    pose: &WorldPose<'_>,
    blow: &Blow,
) -> Option<(usize, f32)> {
    let way = [blow.point - blow.direction * config.strike_path_m, blow.point];
    let capsules = body.capsules(pose);
    let deepest = |found: Option<(usize, f32)>, (i, depth): (usize, f32)| match found {
        Some((_, deep)) if deep >= depth => found,
        _ if depth >= 0.0 => Some((i, depth)),
        _ => found,
    };
    let on_way = |reach_m: f32| {
        let capsules = &capsules;
        move |i: usize| {
            let [p, q] = nearest_points(way, capsules[i].ends);
            (i, capsules[i].radius + reach_m - p.distance(q))
        }
    };
    let arms = (0..NUM_CAPSULES).filter(|&i| body.part_of(i) == StruckPart::Arm).map(on_way(FIST_REACH_M));
    if let Some(arm) = arms.fold(None, deepest) {
        return Some(arm);
    }
    let reached = (0..NUM_CAPSULES).filter(|&i| body.part_of(i) != StruckPart::Arm).map(on_way(config.reach_m));
    reached.fold(None, deepest)
}
