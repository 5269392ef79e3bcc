//! Happenings, which are news for agents (Kim, Kim and Shin 2003, section 3.2.2): some agents learn of them, and tell others.

use super::check::{KeyFault, check_numbers, check_point, key_fault};
use super::goal::{AtEndConfig, GoalConfig, scale_points};
use serde::{Deserialize, Serialize};

/// Happening that gives agents another goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HappeningConfig {
    /// Time (s, 0 to 100000).
    pub time_s: f64,
    /// Region of agents that learn of it at once; all agents where absent.
    pub near: Option<NearConfig>,
    /// Goal of agents that know of it.
    pub goal: GoalConfig,
    /// Desired speed of these agents from then on; as before where absent (m/s, 0 to 100).
    pub speed_mps: Option<f32>,
    /// Distance from the goal at which agents have arrived (m, 0.01 to 1000).
    #[serde(default = "super::group::arrival")]
    pub arrival_m: f32,
    /// Behaviour of agents at the goal.
    #[serde(default)]
    pub at_end: AtEndConfig,
    /// Whether agents that know of it tell agents near them, see `agents.meeting_m`.
    #[serde(default)]
    pub passed_on: bool,
}

/// Region around a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NearConfig {
    /// The point (m).
    pub at: Vec<f32>,
    /// Radius of the region (m, 0.01 to 100000).
    pub radius_m: f32,
}

impl HappeningConfig {
    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), KeyFault> {
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
            return key_fault(&format!("{key}.goal"), "expected a goal that can be reached, found wander");
        }
        self.goal.find_fault(&format!("{key}.goal"), dimensions)
    }

    pub(super) fn stretch(&mut self, by: f32) {
        if let Some(near) = &mut self.near {
            scale_points(&mut [&mut near.at], by);
            near.radius_m *= by;
        }
        self.goal.stretch(by);
    }
}
