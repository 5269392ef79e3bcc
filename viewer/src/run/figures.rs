//! What is measured of every step.

use throng_precompute::slip::SlipMeter;
use throng_runtime::troupe::StepTimes;

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

impl From<&SlipMeter> for Slip {
    fn from(m: &SlipMeter) -> Self {
        Self { mean_mps: m.mean_mps() as f32, p95_mps: m.p95_mps() as f32, samples: m.samples() as u32 }
    }
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
