//! Standing feet: frames in which their lowest part hardly moves, and its distance from the ground.

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use throng_base::thresholds::LOWEST_FOOT_MPS;
use throng_core::{Joint, Skeleton};

/// The joints of the feet.
pub const FEET: [Joint; 4] = [Joint::LeftFoot, Joint::LeftToe, Joint::RightFoot, Joint::RightToe];

/// Least time of standing; a jumping body hardly moves at the top, for a shorter time (s).
const SHORTEST: f64 = 0.12;

/// The lowest part of the feet at one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootSample {
    /// Index of the frame.
    pub frame: usize,
    /// Position; y is the height above that of the joint when the foot stands flat (m).
    pub position: Vec3,
    /// True where it hardly moves.
    pub is_still: bool,
}

/// The lowest part of the feet at every frame.
///
/// - `feet`: positions of [`FEET`], frame by frame.
pub fn lowest_feet(feet: impl Iterator<Item = [Vec3; 4]>, skeleton: &Skeleton, rate_hz: f64) -> Vec<FootSample> {
    let rest = skeleton.rest_positions();
    let mut before: Option<[Vec3; 4]> = None;
    let stand = |(frame, at): (usize, [Vec3; 4])| {
        let clearance = |i: usize| at[i].y - rest[FEET[i].index()].y;
        let lowest = (0..4).min_by(|&a, &b| clearance(a).total_cmp(&clearance(b))).unwrap_or(0);
        let slow = |b: [Vec3; 4]| (at[lowest] - b[lowest]).length() * (rate_hz as f32) < LOWEST_FOOT_MPS;
        let stands = before.replace(at).is_some_and(slow);
        FootSample { frame, position: at[lowest].with_y(clearance(lowest)), is_still: stands }
    };
    feet.enumerate().map(stand).collect()
}

/// Distance of standing feet from the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StanceReport {
    /// 95th percentile (cm).
    pub p95_cm: f32,
    /// Largest distance (cm).
    pub worst_cm: f32,
    /// Grade of the 95th percentile.
    pub grade: Grade,
}

/// Grade of the stance of feet on the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// Residual error, too small to be visible.
    #[default]
    Good,
    /// Visible from near by.
    Fair,
    /// Characters float or are sunk, or step onto things.
    Poor,
}

/// Limits of good and of fair (cm).
pub const FAR_CM: [f32; 2] = [3.0, 6.0];

impl StanceReport {
    /// The stance of a list of distances (m).
    pub fn from_distances(mut far: Vec<f32>) -> Self {
        far.sort_by(f32::total_cmp);
        let cm = |i: usize| far.get(i).copied().unwrap_or(0.0) * 100.0;
        let last = far.len().saturating_sub(1);
        let p95_cm = cm((far.len() * 95 / 100).min(last));
        let grade = match p95_cm {
            far if far <= FAR_CM[0] => Grade::Good,
            far if far <= FAR_CM[1] => Grade::Fair,
            _ => Grade::Poor,
        };
        Self { p95_cm, worst_cm: cm(last), grade }
    }

    /// The larger value of each.
    pub fn worse_of(self, other: Self) -> Self {
        Self {
            p95_cm: self.p95_cm.max(other.p95_cm),
            worst_cm: self.worst_cm.max(other.worst_cm),
            grade: self.grade.max(other.grade),
        }
    }

    /// Advice where the grade is not good.
    pub fn advice(&self) -> Option<String> {
        (self.grade != Grade::Good).then(|| {
            format!(
                "standing feet are up to {:.0} cm from the ground, {:.0} cm at worst: as it should be where people step onto \
                 things; otherwise the floor is not level, or the body drifts up or down. Level the floor where it was \
                 captured, or cut the file where its height changes",
                self.p95_cm, self.worst_cm
            )
        })
    }
}

impl fmt::Display for StanceReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { p95_cm, worst_cm, grade } = *self;
        let grade = ["good", "fair", "poor"][grade as usize];
        write!(f, "{p95_cm:.1} cm from the ground at the 95th percentile, {worst_cm:.1} cm at worst: {grade}")
    }
}

/// Distances of the feet from the ground, frame by frame, where they stand for a moment (m).
pub fn standing_distances(stands: &[FootSample], rate_hz: f64) -> Vec<f32> {
    let long = (SHORTEST * rate_hz).ceil() as usize;
    let all = stands.chunk_by(|a, b| a.is_still && b.is_still).filter(|run| run[0].is_still && run.len() >= long);
    all.flatten().map(|s| s.position.y.abs()).collect()
}
