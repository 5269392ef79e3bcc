//! Separation of two bodies that come too near.

use super::body::{SparringBody, WorldPose};
use super::config::SeparationConfig;
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};
use throng_base::maths;
use throng_core::{BodyVolume, contacts::Contacts};

/// Time constant of the speed of separation (s).
const ADAPT_S: f32 = 0.15;
/// Share that a character takes that stands on both feet, as its legs can only lean (1).
const STANDING_SHARE: f32 = 0.25;
/// Time in which an overlap would be gone at the desired speed (s).
const PART_S: f32 = 0.25;

/// State of the separation of two opponents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct OpponentPair {
    /// Deepest overlap of their core capsules; 0 where they are apart (m).
    pub overlap_m: f32,
    /// Time spent deeper than the settings allow (s).
    pub deep_s: f32,
    /// Deepest overlap so far (m).
    pub max_overlap_m: f32,
    /// Current speed of separation (m/s).
    speed_mps: f32,
    /// Unit direction along the ground from the first to the second.
    apart: Vec2,
    /// Share that each takes of its half of the distance.
    shares: [f32; 2],
}

impl OpponentPair {
    /// False for a state that no pair can have.
    pub fn is_valid(&self) -> bool {
        let [a, b] = self.shares;
        let lengths = [self.overlap_m, self.max_overlap_m, self.speed_mps, self.apart.x, self.apart.y, a, b];
        lengths.iter().all(|v| v.abs() <= 100.0) && (0.0..1e9).contains(&self.deep_s)
    }

    /// Measures the overlap of two poses.
    pub fn measure_overlap(
        &mut self,
        body: &SparringBody,
        poses: [&WorldPose<'_>; 2],
        contacts: [Contacts; 2],
        config: &SeparationConfig,
        dt_s: f32,
    ) {
        let overlap = core_overlap(body, poses, config.margin_m);
        self.overlap_m = overlap.max(0.0);
        self.max_overlap_m = self.max_overlap_m.max(self.overlap_m);
        if self.overlap_m > config.deep_m {
            self.deep_s += dt_s;
        }
        let offset = poses[1].root() - poses[0].root();
        self.apart = offset.try_normalize().unwrap_or(Vec2::Y);
        let [a, b] = poses.map(|p| body.head_position(p));
        let nearer_m = (overlap + config.margin_m).max(config.heads_m - a.distance(b));
        let wanted = if config.enabled { (nearer_m / PART_S).min(config.max_speed_mps) } else { 0.0 };
        let adapt = 1.0 - maths::exp(-dt_s / ADAPT_S);
        self.speed_mps += (wanted - self.speed_mps) * adapt;
        for (share, c) in self.shares.iter_mut().zip(contacts) {
            let stands = c.any(Contacts::LEFT) && c.any(Contacts::RIGHT);
            *share += (if stands { STANDING_SHARE } else { 1.0 } - *share) * adapt;
        }
    }

    /// Displacements of the two in a step; `None` where they stay (m).
    pub fn parting_displacements(&self, dt_s: f32) -> Option<[Vec2; 2]> {
        const SLOWEST_MPS: f32 = 1e-3;
        let by = self.apart * (0.5 * self.speed_mps * dt_s);
        (self.speed_mps > SLOWEST_MPS).then(|| [-by * self.shares[0], by * self.shares[1]])
    }
}

impl SeparationConfig {
    /// Displacement in a step of the second of two heads that are too near each other; the first one moves in the opposite
    /// direction (m).
    pub(super) fn lean_displacement(&self, heads: [Vec3; 2], dt_s: f32) -> Option<Vec3> {
        let nearer_m = self.heads_m - heads[0].distance(heads[1]);
        let away = (heads[1] - heads[0]).with_y(0.0).normalize_or_zero();
        (self.enabled && nearer_m > 0.0 && dt_s > 0.0).then(|| away * (nearer_m * self.lean_per_s * dt_s))
    }
}

/// Deepest overlap of the core capsules of two bodies, negative where there is a gap; gaps of the margin and more are
/// returned as the margin (m).
fn core_overlap(body: &SparringBody, [a, b]: [&WorldPose<'_>; 2], margin_m: f32) -> f32 {
    /// Largest distance of a core capsule from its pelvis (m).
    const REACH: f32 = 1.1;
    let hips = |p: &WorldPose<'_>| p.point_in_world(throng_core::Joint::Hips, Vec3::ZERO);
    if hips(a).distance_squared(hips(b)) > 4.0 * REACH * REACH {
        return -margin_m;
    }
    BodyVolume::overlap_depth(&body.core_capsules(a), &body.core_capsules(b), -margin_m)
}
