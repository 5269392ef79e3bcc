//! Features in the distance between frames, and their weights.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_base::text;
use throng_core::{Joint, NUM_JOINTS};
use throng_motion::error::{BuildError, Result, check_ranges};

/// Weights of the six features of Lee, Choi and Lee (2006), section 3.
///
/// The distance is an angle. Joint weights are scaled to a sum of 1, so the angle term is the mean square joint angle.
/// The weight of every other feature turns it into an angle: a velocity counts as the displacement in `horizon_s`, a
/// length as the joint angle that would cause it. A distance of 0.1 therefore means "poses and where they are heading
/// differ by about 0.1 rad a joint".
///
/// The defaults were chosen on captured walks and runs: of the settings tried, these bring the feet of frames joined by
/// transitions nearest at equal branching. There, frames up to about 0.3 apart look alike except for the arms; at 0.45
/// arms are clearly elsewhere, and a foot up to 0.2 m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FeaturesConfig {
    /// Relative weights of joints by snake_case name, in place of the default ones. Only the proportions among
    /// all joints matter. The hips are weighted by `orientation_weight` (0 to 1e6).
    pub joint_weights: BTreeMap<String, f64>,
    /// Weight of the root's orientation without the rotation about the vertical, per square radian (0 to 1e6).
    pub orientation_weight: f64,
    /// Joint angle that a metre counts for: root height, and root travel within `horizon_s`.
    /// (rad/m, 0 to 1e6)
    pub angle_per_metre: f64,
    /// Time within which a difference in velocity counts (s, 0 to 1e6).
    pub horizon_s: f64,
}

impl Default for FeaturesConfig {
    fn default() -> Self {
        Self { joint_weights: BTreeMap::new(), orientation_weight: 1.0, angle_per_metre: 2.5, horizon_s: 0.12 }
    }
}

/// Weights in use. Velocity weights include the horizon.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PreparedWeights {
    /// Weight per squared joint angle; the hips' is 0 (NUM_JOINTS).
    pub joints: [f64; NUM_JOINTS],
    pub height: f64,
    pub orientation: f64,
    /// Factor on the joint's weight, per squared angular velocity.
    pub joint_velocity: f64,
    pub linear_velocity: f64,
    pub angular_velocity: f64,
}

impl FeaturesConfig {
    /// # Errors
    /// [`BuildError::Key`] for a joint that does not exist or a number out of range.
    pub(crate) fn weights(&self) -> Result<PreparedWeights> {
        let mut joints = Joint::ALL.map(default_weight);
        for (name, &w) in &self.joint_weights {
            let joint = Joint::from_name(name).filter(|&j| j != Joint::Hips).ok_or_else(|| unknown_joint(name))?;
            joints[joint.index()] = check(&format!("joint_weights.{name}"), w)?;
        }
        let sum: f64 = joints.iter().sum();
        if sum <= 0.0 {
            let why = "every joint has weight 0. Give at least one a weight above 0.";
            return Err(BuildError::key("features.joint_weights", why));
        }
        let orientation = check("orientation_weight", self.orientation_weight)?;
        let metre = check("angle_per_metre", self.angle_per_metre)?.powi(2);
        let horizon = check("horizon_s", self.horizon_s)?.powi(2);
        Ok(PreparedWeights {
            joints: joints.map(|w| w / sum),
            height: metre,
            orientation,
            joint_velocity: horizon,
            linear_velocity: metre * horizon,
            angular_velocity: orientation * horizon,
        })
    }
}

/// Joints count roughly by the length and mass that they move, legs more than arms, because a leg that blends badly
/// slides on the ground. The head counts little: captured heads jump where markers swap.
fn default_weight(joint: Joint) -> f64 {
    use Joint::*;
    match joint {
        Hips => 0.0,
        Spine | Chest | UpperChest => 0.8,
        Neck => 0.2,
        Head => 0.05,
        LeftClavicle | RightClavicle => 0.3,
        LeftUpperArm | RightUpperArm => 1.0,
        LeftForearm | RightForearm => 0.6,
        LeftHand | RightHand => 0.1,
        LeftThigh | RightThigh => 3.0,
        LeftShin | RightShin => 2.0,
        LeftFoot | RightFoot => 0.6,
        LeftToe | RightToe => 0.1,
    }
}

fn check(key: &str, value: f64) -> Result<f64> {
    check_ranges([(key, value, 0.0, 1e6)]).map_err(|e| e.within_key("features")).map(|()| value)
}

fn unknown_joint(name: &str) -> BuildError {
    let meant = text::did_you_mean(name, Joint::ALL[1..].iter().map(|j| j.name()));
    let why = match name == Joint::Hips.name() {
        true => "the hips are weighted by orientation_weight. Remove the entry.".to_owned(),
        false => format!("no such joint.{meant}"),
    };
    BuildError::key(format!("features.joint_weights.{name}"), why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joint_weights_sum_to_one() {
        let mut config = FeaturesConfig::default();
        config.joint_weights.insert("left_hand".into(), 7.0);
        let w = config.weights().unwrap();
        assert!((w.joints.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(w.joints[Joint::LeftHand.index()] > 10.0 * w.joints[Joint::RightHand.index()]);
    }

    #[test]
    fn refuses_unknown_joints_with_the_nearest_name() {
        let mut config = FeaturesConfig::default();
        config.joint_weights.insert("left_tigh".into(), 1.0);
        assert!(config.weights().unwrap_err().to_string().contains("left_thigh"));
    }

    #[test]
    fn refuses_negative_infinite_and_all_zero_weights() {
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(FeaturesConfig { horizon_s: bad, ..Default::default() }.weights().is_err());
        }
        let joint_weights = Joint::ALL[1..].iter().map(|j| (j.name().to_owned(), 0.0)).collect();
        assert!(FeaturesConfig { joint_weights, ..Default::default() }.weights().is_err());
    }
}
