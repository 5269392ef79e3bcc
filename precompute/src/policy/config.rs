//! What the configuration says about behaviours and about solving them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One behaviour of the `approach` kind: come to the target and stay there (003 section 6, eq. 5).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BehaviourConfig {
    /// Name of the policy in the bundle; unique.
    pub name: String,
    /// What the behaviour is about.
    pub kind: BehaviourKind,
    /// Cells of the target.
    pub grid: GridConfig,
    /// Discount per frame at 30 Hz, whatever the database rate; the paper's 0.97 at 15 Hz is 0.985 here.
    /// [Limit: 0.5 to 0.9999]
    pub discount: f64,
    /// How nearness during an action becomes its reward.
    pub reward: ApproachReward,
    /// Distance at which nearness has fallen to 1/e. [Unit: m] [Limit: > 0]
    pub scale: f64,
    /// How much more a moment counts in which the character stands, as a share. [Limit: 0 to 1]
    pub stand_bonus: f64,
    /// Speed, over ground or of the feet in a turn on the spot, at which most of that bonus is gone. [Unit: m/s]
    /// [Limit: > 0]
    pub stand_speed: f64,
}

impl Default for BehaviourConfig {
    fn default() -> Self {
        Self {
            name: "approach".into(),
            kind: BehaviourKind::Approach,
            grid: GridConfig::default(),
            discount: 0.985,
            reward: ApproachReward::Integral,
            scale: 1.5,
            stand_bonus: 0.2,
            stand_speed: 0.3,
        }
    }
}

/// What a behaviour is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BehaviourKind {
    /// Coming to a target on the ground and staying there.
    #[default]
    Approach,
}

/// How nearness during an action becomes its reward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ApproachReward {
    /// Discounted sum over the action's frames, so that short and long actions are paid by time.
    #[default]
    Integral,
    /// The largest discounted nearness during the action (003 eq. 5), so that actions are paid by piece.
    Max,
}

/// A polar grid of target cells around the character, rings from the character itself outwards.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GridConfig {
    /// Rings, the first at distance 0. [Limit: 2 to 4096]
    pub rings: u32,
    /// Angles, the first straight ahead. [Limit: 2 to 4096]
    pub angles: u32,
    /// Distance of the last ring; targets farther away are treated as if on it. [Unit: m] [Limit: > 0]
    pub radius: f64,
    /// Distance between the first two rings: an equal share, radius / (rings - 1), or less, which makes the distances
    /// grow outwards. [Unit: m] [Limit: > radius / (rings - 1)^2]
    pub inner_spacing: f64,
    /// Distance beyond the last ring over which values fall to about 1/e. [Unit: m] [Limit: > 0]
    pub falloff: f64,
}

impl Default for GridConfig {
    fn default() -> Self {
        Self { rings: 16, angles: 32, radius: 8.0, inner_spacing: 0.25, falloff: 2.5 }
    }
}

impl GridConfig {
    /// The grid of 003 section 6: 5 distances x 13 angles over 2 m.
    pub fn paper() -> Self {
        Self { rings: 5, angles: 13, radius: 2.0, inner_spacing: 0.5, falloff: 2.5 }
    }
}

/// How policies are solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PolicyConfig {
    /// Values are within this of the optimal ones, on a scale where standing on the target for ever is worth 1.
    /// [Limit: 1e-6 to 1]
    pub epsilon: f64,
    /// Full sweeps after which solving is given up. [Limit: > 0]
    pub max_sweeps: u32,
    /// Best actions stored per (state, cell). [Limit: 1 to 4]
    pub choices: u32,
    /// Random (state, target) pairs on which the single-load answer is compared with the look-ahead.
    pub compare_samples: u32,
}

impl Default for PolicyConfig {
    fn default() -> Self {
        Self { epsilon: 1e-4, max_sweeps: 500, choices: 4, compare_samples: 10_000 }
    }
}
