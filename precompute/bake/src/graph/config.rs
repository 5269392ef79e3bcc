//! Settings of the motion graph.

use super::take::TakenMotion;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::thresholds::STANDING_MPS_F64;
use throng_motion::error::{Result, check_ranges};

/// Motion that a build makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MakeMotion {
    /// What behaviours need and the clips lack.
    #[default]
    Missing,
    /// None: characters move as captured alone.
    None,
}

/// Settings of [`super::connect`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MotionGraphConfig {
    /// False builds no graph: for databases of characters in worlds of patches, without policies.
    pub enabled: bool,
    /// Motion that is made where the clips lack what behaviours need: starts, stops, turns, stands.
    pub make: MakeMotion,
    /// Actions a state should have on average; the threshold is chosen for it (2 to max_actions).
    pub branching: f64,
    /// Distance up to which frames match, in place of one chosen for `branching` (rad, 1e-6 to 1000).
    pub threshold: Option<f64>,
    /// Largest distance of any transition: of the threshold chosen for `branching`, and of the transitions beyond
    /// it that keep rare motion in and offer every kind of outcome (rad, 1e-6 to 1000).
    pub max_error: f64,
    /// Largest distance of the transitions without which all motion of a manner would stay out; `max_error` or less joins
    /// none farther (rad, 1e-6 to 1000).
    pub join_error: f64,
    /// Most actions a state may have (4 to 255).
    pub max_actions: usize,
    /// Longest action: a character chooses at least this often. Motion without a choice for longer is left out
    /// (s, 0.1 to 30).
    pub max_action_s: f64,
    /// Transitions that stay within this time of where they leave in the same clip are left out.
    /// (s, 0 to 10000)
    pub min_jump_s: f64,
    /// Distance below which two matches count as one outcome: if their motion leads within `outcome_horizon_s` to
    /// places nearer than this, and to headings nearer than `outcome_angle`, only the better is an action. 0 keeps both
    /// (m, 0 to 1000).
    pub outcome_distance: f64,
    /// Heading difference for `outcome_distance` (rad, 0 to 10).
    pub outcome_angle: f64,
    /// Time horizon for `outcome_distance` (s, 0.001 to 1000).
    pub outcome_horizon_s: f64,
    /// Largest root speed of a standing character with both feet planted (m/s, 0 to 100).
    pub standing_speed_mps: f64,
    /// Shortest stand (s, 0 to 10000).
    pub standing_min_s: f64,
    /// Time between event frames while standing (s, 0.001 to 10000).
    pub standing_interval_s: f64,
    /// Shortest time for which a foot leaves the ground (s, 0 to 10000).
    pub min_swing_s: f64,
    /// Least motion in the graph; less is an error (s, 0 to 1e6).
    pub min_component_s: f64,
    /// Classes of motion that the graph takes, each of which `throng inspect` shows. Motion of which hardly any that goes
    /// somewhere is of these classes is taken whole.
    pub take: Vec<TakenMotion>,
}

impl Default for MotionGraphConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            make: MakeMotion::Missing,
            branching: 14.0,
            threshold: None,
            max_error: 0.5,
            join_error: 0.75,
            max_actions: 64,
            max_action_s: 4.0,
            min_jump_s: 0.3,
            outcome_distance: 0.1,
            outcome_angle: 0.1,
            outcome_horizon_s: 1.0,
            standing_speed_mps: STANDING_MPS_F64,
            standing_min_s: 0.3,
            standing_interval_s: 0.25,
            min_swing_s: 0.1,
            min_component_s: 10.0,
            take: vec![TakenMotion::Upright],
        }
    }
}

impl MotionGraphConfig {
    /// # Errors
    /// [`throng_motion::error::BuildError::Key`] naming the first key out of its limits.
    pub(crate) fn check(&self) -> Result<()> {
        let ranges = [
            ("threshold", self.threshold.unwrap_or(1.0), 1e-6, 1e3),
            ("max_error", self.max_error, 1e-6, 1e3),
            ("join_error", self.join_error, 1e-6, 1e3),
            ("max_actions", self.max_actions as f64, 4.0, 255.0),
            ("branching", self.branching, 2.0, self.max_actions as f64),
            ("max_action_s", self.max_action_s, 0.1, 30.0),
            ("min_jump_s", self.min_jump_s, 0.0, 1e4),
            ("outcome_distance", self.outcome_distance, 0.0, 1e3),
            ("outcome_angle", self.outcome_angle, 0.0, 10.0),
            ("outcome_horizon_s", self.outcome_horizon_s, 1e-3, 1e3),
            ("standing_speed_mps", self.standing_speed_mps, 0.0, 100.0),
            ("standing_min_s", self.standing_min_s, 0.0, 1e4),
            ("standing_interval_s", self.standing_interval_s, 1e-3, 1e4),
            ("min_swing_s", self.min_swing_s, 0.0, 1e4),
            ("min_component_s", self.min_component_s, 0.0, 1e6),
        ];
        check_ranges(ranges).map_err(|e| e.within_key("graph"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_within_their_limits_and_bad_numbers_are_named() {
        assert!(MotionGraphConfig::default().check().is_ok());
        for (config, key) in [
            (MotionGraphConfig { branching: 65.0, ..Default::default() }, "branching"),
            (MotionGraphConfig { max_action_s: 0.0, ..Default::default() }, "max_action_s"),
            (MotionGraphConfig { max_actions: 256, ..Default::default() }, "max_actions"),
            (MotionGraphConfig { threshold: Some(0.0), ..Default::default() }, "threshold"),
            (MotionGraphConfig { standing_interval_s: f64::NAN, ..Default::default() }, "standing_interval_s"),
        ] {
            assert!(config.check().unwrap_err().to_string().contains(&format!("graph.{key}:")));
        }
    }
}
