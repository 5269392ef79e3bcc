//! Foot slip: how fast heels and toes move that should stand.

mod soles;

use glam::Vec3;
use throng_runtime::characters::Characters;
use throng_runtime::{Contacts, Joint};

pub use soles::{SoleMeter, Soles};

/// Parts of the feet and the joints that show them.
pub(crate) const PARTS: [(Joint, Contacts); 4] = [
    (Joint::LeftFoot, Contacts::LEFT_HEEL),
    (Joint::LeftToe, Contacts::LEFT_TOE),
    (Joint::RightFoot, Contacts::RIGHT_HEEL),
    (Joint::RightToe, Contacts::RIGHT_TOE),
];

/// Bins of the histogram: 1 mm/s each.
const BINS: usize = 4000;

/// Speeds that were seen, to the nearest mm/s.
#[derive(Clone, Debug)]
pub(crate) struct Speeds {
    bins: Vec<u64>,
    sum: f64,
}

impl Default for Speeds {
    fn default() -> Self {
        Self { bins: vec![0; BINS], sum: 0.0 }
    }
}

impl Speeds {
    /// Adds one (m/s).
    pub fn add(&mut self, speed: f32) {
        self.bins[((speed * 1000.0) as usize).min(BINS - 1)] += 1;
        self.sum += f64::from(speed);
    }

    fn samples(&self) -> u64 {
        self.bins.iter().sum()
    }

    pub fn mean(&self) -> f64 {
        self.sum / self.samples().max(1) as f64
    }

    pub fn p95(&self) -> f64 {
        percentile(&self.bins, 0.95)
    }
}

/// Measures from step to step how fast planted parts of feet move; `P` is what it sees of a character.
#[derive(Clone, Debug)]
pub struct Meter<P> {
    /// What was seen of each character at the last step, and which parts were planted.
    before: Vec<(P, Contacts)>,
    speeds: Speeds,
}

/// Measures the speed of heels and toes, each on its own.
pub type SlipMeter = Meter<[Vec3; 4]>;

impl<P: Copy + Default> Meter<P> {
    /// For so many characters; nothing has been seen.
    pub fn new(num_characters: usize) -> Self {
        Self { before: vec![(P::default(), Contacts::NONE); num_characters], speeds: Speeds::default() }
    }

    /// Forgets the last step: the next one is not its neighbour.
    pub fn forget_step(&mut self) {
        self.before.fill((P::default(), Contacts::NONE));
    }

    /// Forgets what was measured, not the last step.
    pub fn clear(&mut self) {
        self.speeds = Speeds::default();
    }

    /// Planted parts that were measured.
    pub fn samples(&self) -> u64 {
        self.speeds.samples()
    }

    /// (m/s)
    pub fn mean_mps(&self) -> f64 {
        self.speeds.mean()
    }

    /// 95th percentile (m/s).
    pub fn p95_mps(&self) -> f64 {
        percentile(&self.speeds.bins, 0.95)
    }
}

impl SlipMeter {
    /// Looks at all characters after a step of `dt_s`; parts that were planted before and are now count.
    pub fn observe(&mut self, characters: &Characters, dt_s: f32) {
        for (c, before) in self.before.iter_mut().enumerate() {
            let (root, pose, contacts) = (characters.root(c), characters.pose(c), characters.contacts(c));
            let (turn, move_by) = (root.rotation(), root.translation());
            let now = PARTS.map(|(j, _)| turn * pose[j.index()].translation() + move_by);
            let (was, were) = std::mem::replace(before, (now, contacts));
            for (k, (_, part)) in PARTS.into_iter().enumerate() {
                if dt_s > 0.0 && contacts.any(part) && were.any(part) {
                    self.speeds.add((now[k] - was[k]).length() / dt_s);
                }
            }
        }
    }
}

/// The value below which a share of a histogram of mm/s lies (m/s).
fn percentile(bins: &[u64], share: f64) -> f64 {
    let wanted = share * bins.iter().sum::<u64>() as f64;
    let mut seen = 0.0;
    for (i, &count) in bins.iter().enumerate() {
        seen += count as f64;
        if count > 0 && seen >= wanted {
            return (i as f64 + 0.5) / 1000.0;
        }
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
        assert_eq!(percentile(&bins, 0.95), 0.0105);
        assert_eq!(percentile(&bins, 0.96), 0.0505);
        assert_eq!(percentile(&[0; 4], 0.5), 0.0);
    }
}
