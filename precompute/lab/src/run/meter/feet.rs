//! Slip of feet of characters of any kind.

use crate::slip::{PARTS, Speeds};
use glam::{Vec2, Vec3};
use throng_runtime::Contacts;
use throng_runtime::simulation::Simulation;

/// Measures from step to step how fast planted feet move: heels and toes each by itself, or, where bodies are blended and
/// feet roll, over the ground, by the slower end of each foot. See [`crate::slip::SlipMeter`] and [`crate::slip::SoleMeter`].
#[derive(Clone, Debug)]
pub struct FeetMeter {
    before: Vec<([Vec3; 4], Contacts)>,
    speeds: Speeds,
    has_seen_bodies: bool,
}

impl FeetMeter {
    /// Nothing has been seen.
    pub fn new(num_characters: usize) -> Self {
        let before = vec![([Vec3::ZERO; 4], Contacts::NONE); num_characters];
        Self { before, speeds: Speeds::default(), has_seen_bodies: false }
    }

    /// Looks at characters after a step of `dt_s`.
    pub fn observe(&mut self, dt_s: f32, sim: &Simulation, characters: impl Iterator<Item = usize>) {
        for who in characters {
            let (Some(root), Some(pose)) = (sim.root(who), sim.pose(who)) else { continue };
            self.has_seen_bodies = true;
            let (contacts, soles) = (sim.contacts(who), sim.soles(who));
            let (turn, by) = (root.rotation(), root.translation());
            let now = match soles {
                Some([left, right]) => [left[0], left[1], right[0], right[1]],
                None => PARTS.map(|(j, _)| turn * pose[j.index()].translation() + by),
            };
            let (was, were) = std::mem::replace(&mut self.before[who], (now, contacts));
            let is_planted = |part: Contacts| dt_s > 0.0 && contacts.any(part) && were.any(part);
            if soles.is_some() {
                for (side, foot) in [Contacts::LEFT, Contacts::RIGHT].into_iter().enumerate() {
                    let moved = |end: usize| {
                        let by = now[2 * side + end] - was[2 * side + end];
                        Vec2::new(by.x, by.z).length()
                    };
                    if is_planted(foot) {
                        self.speeds.add(moved(0).min(moved(1)) / dt_s);
                    }
                }
            } else {
                for (k, (_, part)) in PARTS.into_iter().enumerate() {
                    if is_planted(part) {
                        self.speeds.add((now[k] - was[k]).length() / dt_s);
                    }
                }
            }
        }
    }

    /// Forgets what was measured, not the last step.
    pub fn clear(&mut self) {
        self.speeds = Speeds::default();
    }

    /// True where anybody had a body.
    pub fn has_seen_bodies(&self) -> bool {
        self.has_seen_bodies
    }

    /// (m/s)
    pub fn mean_mps(&self) -> f64 {
        self.speeds.mean()
    }

    /// 95th percentile (m/s).
    pub fn p95_mps(&self) -> f64 {
        self.speeds.p95()
    }
}
