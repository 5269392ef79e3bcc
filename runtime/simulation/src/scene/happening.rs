//! News for agents (Kim, Kim and Shin 2003, section 3.2.2): some hear of them, and tell others.

use super::check::{Fault, check_numbers, check_point, fault};
use super::goal::{AtEndConfig, GoalConfig, scale};
use serde::{Deserialize, Serialize};

/// News that gives agents another goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HappeningConfig {
    /// When (s, 0 to 100000).
    pub time_s: f64,
    /// Who hears of it then; everybody where absent.
    #[serde(default)]
    pub near: Option<NearConfig>,
    /// Where those who know go.
    pub goal: GoalConfig,
    /// Their desired speed from then on; as before where absent (m/s, 0 to 100).
    #[serde(default)]
    pub speed_mps: Option<f32>,
    /// How near to the goal is there (m, 0.01 to 1000).
    #[serde(default = "arrival")]
    pub arrival_m: f32,
    /// What is done there.
    #[serde(default)]
    pub at_end: AtEndConfig,
    /// Who knows tells those that come near, see `agents.telling_m`.
    #[serde(default)]
    pub told_on: bool,
}

fn arrival() -> f32 {
    0.5
}

/// Those near a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NearConfig {
    /// The point (m).
    pub at: Vec<f32>,
    /// How near (m, 0.01 to 100000).
    pub radius_m: f32,
}

impl HappeningConfig {
    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), Fault> {
        check_numbers(&[(&format!("{key}.time_s"), self.time_s, 0.0, 1e5)])?;
        check_numbers(&[
            (&format!("{key}.arrival_m"), self.arrival_m, 0.01, 1000.0),
            (&format!("{key}.speed_mps"), self.speed_mps.unwrap_or(0.0), 0.0, 100.0),
        ])?;
        if let Some(near) = &self.near {
            check_point(&format!("{key}.near.at"), &near.at, dimensions)?;
            check_numbers(&[(&format!("{key}.near.radius_m"), near.radius_m, 0.01, 1e5)])?;
        }
        if matches!(self.goal, GoalConfig::Wander { .. }) {
            return fault(&format!("{key}.goal"), "expected a goal that can be reached, found wander");
        }
        self.goal.find_fault(&format!("{key}.goal"), dimensions)
    }

    pub(super) fn stretch(&mut self, by: f32) {
        if let Some(near) = &mut self.near {
            scale(&mut [&mut near.at], by);
            near.radius_m *= by;
        }
        self.goal.stretch(by);
    }
}
