//! Measurements and pictures of a scene.

use super::check::{KeyFault, check_numbers, check_point, key_fault};
use serde::{Deserialize, Serialize};

/// Measurements of a scene beside the standard ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct SceneMeasureConfig {
    /// Whether another number of agents scales the whole layout, so that their density stays the same.
    pub grows: bool,
    /// Line across which the flow of agents is counted.
    pub gate: Option<GateConfig>,
    /// Measurement of how agents sort themselves by direction.
    pub lanes: Option<LanesConfig>,
}

/// Line that agents cross, such as a door.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GateConfig {
    /// One end (m).
    pub from: [f32; 2],
    /// The other end (m).
    pub to: [f32; 2],
}

/// Measurement of lanes: an agent's lane is the band before and behind it along the corridor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LanesConfig {
    /// Direction along the corridor.
    pub along: [f32; 2],
    /// Width of the band (m, 0.1 to 100).
    #[serde(default = "lane_width")]
    pub width_m: f32,
    /// Length of the band before and behind the agent (m, 0.1 to 1000).
    #[serde(default = "lane_reach")]
    pub reach_m: f32,
}

throng_base::key_defaults! {
    lane_width: f32 = 1.0;
    lane_reach: f32 = 5.0;
}

impl SceneMeasureConfig {
    pub(super) fn find_fault(&self) -> Result<(), KeyFault> {
        if let Some(gate) = &self.gate {
            check_point("measure.gate.from", &gate.from, 2)?;
            check_point("measure.gate.to", &gate.to, 2)?;
            if gate.from == gate.to {
                return key_fault("measure.gate", "expected two ends that differ");
            }
        }
        if let Some(lanes) = &self.lanes {
            check_numbers(&[
                ("measure.lanes.width_m", lanes.width_m, 0.1, 100.0),
                ("measure.lanes.reach_m", lanes.reach_m, 0.1, 1000.0),
            ])?;
            if !lanes.along.iter().all(|v| v.is_finite()) || lanes.along == [0.0; 2] {
                return key_fault("measure.lanes.along", format!("expected a direction, found {:?}", lanes.along));
            }
        }
        Ok(())
    }
}

/// Contents of a scene's picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct PictureConfig {
    /// Number of the character in a world whose motion is shown; the one with the most different actions where absent.
    pub follow: Option<usize>,
    /// Point at the centre of the overview of a world: x, y, z; the middle of the world where absent (m).
    pub focus: Option<[f32; 3]>,
    /// Width of the overview of a world; that of the whole world where absent (m).
    pub width_m: Option<f32>,
    /// Styles of the scene's blend spaces that are shown on one path.
    pub shown: Vec<PictureStyle>,
}

/// Style that the picture shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PictureStyle {
    /// Name in the picture.
    pub name: String,
    /// Its blend space.
    pub space: String,
    /// Value of the first style axis (-1000 to 1000).
    #[serde(default)]
    pub style: f32,
    /// Speed on the path (m/s, 0.1 to 20).
    pub speed: f32,
}

impl PictureConfig {
    pub(super) fn find_fault(&self) -> Result<(), KeyFault> {
        for (i, s) in self.shown.iter().enumerate() {
            check_numbers(&[
                (&format!("picture.shown[{i}].speed"), s.speed, 0.1, 20.0),
                (&format!("picture.shown[{i}].style"), s.style, -1e3, 1e3),
            ])?;
        }
        Ok(())
    }
}
