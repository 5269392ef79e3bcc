//! What is measured of every step.

use glam::Vec3;
use throng_runtime::troupe::{StepTimes, Troupe};
use throng_runtime::{Contacts, Joint};

/// Parts of the feet and the joints that show them.
const PARTS: [(Joint, Contacts); 4] = [
    (Joint::LeftFoot, Contacts::LEFT_HEEL),
    (Joint::LeftToe, Contacts::LEFT_TOE),
    (Joint::RightFoot, Contacts::RIGHT_HEEL),
    (Joint::RightToe, Contacts::RIGHT_TOE),
];

/// Bins of the histogram of slip: 2 mm/s each.
const BINS: usize = 1000;
const BIN_MPS: f32 = 0.002;

/// Speed of planted heels and toes over all characters at one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slip {
    /// [Unit: m/s]
    pub mean_mps: f32,
    /// 95th percentile. [Unit: m/s]
    pub p95_mps: f32,
    /// Planted heels and toes that were measured.
    pub samples: u32,
}

/// What is measured of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepFigures {
    /// Time of each phase, summed over threads.
    pub times: StepTimes,
    /// Wall time of the troupe's step. [Unit: s]
    pub wall_s: f64,
    /// How planted feet move.
    pub slip: Slip,
    /// Characters within reach of their targets.
    pub at_target: usize,
}

/// Where heels and toes were at the last step, and which were planted.
#[derive(Clone, Debug)]
pub(super) struct Feet {
    before: Vec<([Vec3; 4], Contacts)>,
    bins: Vec<u32>,
}

impl Feet {
    pub fn new(num_characters: usize) -> Self {
        Self { before: vec![([Vec3::ZERO; 4], Contacts::NONE); num_characters], bins: vec![0; BINS] }
    }

    /// Forgets the last step: the next one is not its neighbour.
    pub fn forget(&mut self) {
        self.before.fill(([Vec3::ZERO; 4], Contacts::NONE));
    }

    /// Compares the feet with where they were.
    pub fn measure(&mut self, troupe: &Troupe, dt: f32) -> Slip {
        self.bins.fill(0);
        let (mut sum, mut samples) = (0.0, 0);
        for (c, before) in self.before.iter_mut().enumerate() {
            let (root, pose, contacts) = (troupe.root(c), troupe.pose(c), troupe.contacts(c));
            let (turn, move_by) = (root.rotation(), root.translation());
            let now = PARTS.map(|(j, _)| turn * pose[j.index()].translation() + move_by);
            let (was, were) = std::mem::replace(before, (now, contacts));
            for (k, (_, part)) in PARTS.into_iter().enumerate() {
                if dt > 0.0 && contacts.any(part) && were.any(part) {
                    let speed = (now[k] - was[k]).length() / dt;
                    self.bins[((speed / BIN_MPS) as usize).min(BINS - 1)] += 1;
                    sum += speed;
                    samples += 1;
                }
            }
        }
        Slip { mean_mps: sum / (samples.max(1)) as f32, p95_mps: percentile(&self.bins, samples, 0.95), samples }
    }
}

/// The value below which a share of a histogram lies. [Unit: m/s]
fn percentile(bins: &[u32], samples: u32, share: f32) -> f32 {
    let mut left = (share * samples as f32).ceil() as u32;
    for (i, &count) in bins.iter().enumerate() {
        if count > 0 && left <= count {
            return (i as f32 + 0.5) * BIN_MPS;
        }
        left -= count.min(left);
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_histogram() {
        let mut bins = vec![0; 100];
        bins[10] = 95;
        bins[50] = 5;
        assert_eq!(percentile(&bins, 100, 0.95), 10.5 * BIN_MPS);
        assert_eq!(percentile(&bins, 100, 0.96), 50.5 * BIN_MPS);
        assert_eq!(percentile(&[0; 4], 0, 0.95), 0.0);
    }
}
