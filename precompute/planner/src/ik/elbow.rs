//! The hinge in the middle of a limb: the flexion that brings the wrist to a distance from the shoulder.

use crate::limits::{AngleInterval, JointLimits, SwingLimit};
use glam::DVec3;
use throng_base::maths;

/// Difference below which distances count as the same (m).
const SAME: f64 = 1e-9;

/// Lengths and axes of elbow or knee, on its own side of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elbow {
    /// From shoulder to elbow, in the upper arm's frame (m).
    pub upper: DVec3,
    /// From elbow to wrist, in the forearm's frame (m).
    pub fore: DVec3,
    /// Direction of `fore` (unit).
    pub along: DVec3,
    /// Hinge axis, at right angles to `fore` (unit).
    pub axis: DVec3,
    flexion: AngleInterval,
    twist: AngleInterval,
    mirrored: bool,
    /// The upper arm along the straight forearm and across it, times the forearm's length (m^2).
    cos: f64,
    sin: f64,
    /// The flexion at which the arm is straightest (rad).
    straightest: f64,
    /// Nearest and farthest distances within limits (m).
    pub distances: [f64; 2],
}

impl Elbow {
    /// `None` where the limits are not a hinge's.
    pub fn new(upper: DVec3, fore: DVec3, limits: &JointLimits) -> Option<Self> {
        let SwingLimit::Hinge { flexion, .. } = limits.swing else { return None };
        let [axis, _] = limits.axes;
        // A mirror reverses axes of rotations, except for their part along its normal.
        let axis = if limits.mirrored { DVec3::new(axis.x, -axis.y, -axis.z) } else { axis };
        let along = fore.try_normalize()?;
        let cos = upper.dot(fore);
        let sin = upper.dot(axis.cross(fore));
        let (twist, mirrored) = (limits.twist, limits.mirrored);
        let straightest = maths::atan2(sin, cos);
        let distances = [0.0; 2];
        let mut out = Self { upper, fore, along, axis, flexion, twist, mirrored, cos, sin, straightest, distances };
        let ends = [flexion.least, flexion.most].map(|f| out.squared_distance(f).sqrt());
        let farthest = if flexion.excess(straightest) <= 0.0 { out.squared_distance(straightest).sqrt() } else { 0.0 };
        out.distances = [ends[0].min(ends[1]), ends[0].max(ends[1]).max(farthest)];
        Some(out)
    }

    /// Excess of flexion and twist about the forearm over their limits (rad).
    pub fn excess(&self, flexion: f64, twist: f64) -> f64 {
        self.flexion.excess(flexion).max(self.twist_excess(twist))
    }

    /// Excess of a twist about the forearm over its limits (rad).
    pub fn twist_excess(&self, twist: f64) -> f64 {
        self.twist.excess(if self.mirrored { -twist } else { twist })
    }

    /// Squared distance from shoulder to wrist (m^2).
    fn squared_distance(&self, flexion: f64) -> f64 {
        let (sin, cos) = maths::sin_cos(flexion);
        let straight = self.upper.length_squared() + self.fore.length_squared();
        (straight + 2.0 * (self.cos * cos + self.sin * sin)).max(0.0)
    }

    /// The flexion that brings the wrist to a distance, bent forwards if possible.
    ///
    /// # Errors
    /// Distance by which the target is out of reach (m).
    pub fn flexion(&self, distance: f64) -> Result<f64, f64> {
        let [nearest, farthest] = self.distances;
        let over = (distance - farthest).max(nearest - distance);
        // NaN is out of reach, too.
        if over.is_nan() || over > SAME {
            return Err(if over.is_nan() { f64::INFINITY } else { over });
        }
        let distance = distance.clamp(nearest, farthest);
        let wanted = 0.5 * (distance * distance - self.upper.length_squared() - self.fore.length_squared());
        let most = maths::hypot(self.cos, self.sin);
        let cos = (wanted / most).clamp(-1.0, 1.0);
        let half = maths::atan2((1.0 - cos * cos).sqrt(), cos);
        let candidates = [self.straightest + half, self.straightest - half];
        let better = usize::from(self.flexion.excess(candidates[0]) > self.flexion.excess(candidates[1]).max(1e-12));
        Ok(candidates[better].clamp(self.flexion.least, self.flexion.most))
    }
}
