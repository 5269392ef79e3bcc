//! What is measured and drawn.

use super::check::{Fault, check_numbers, check_point, fault};
use serde::{Deserialize, Serialize};

/// What is measured of a scene, beside what always is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct MeasureConfig {
    /// Another number of agents stretches the whole layout, so that their density stays what it is.
    pub grows: bool,
    /// A line whose flow is counted.
    pub gate: Option<GateConfig>,
    /// How far agents sort themselves by direction.
    pub lanes: Option<LanesConfig>,
}

/// A line that agents cross: through a door, for instance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GateConfig {
    /// One end (m).
    pub from: [f32; 2],
    /// The other end (m).
    pub to: [f32; 2],
}

/// How lanes are measured: an agent's lane is what lies before and behind it in a band along the corridor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LanesConfig {
    /// Along the corridor.
    pub along: [f32; 2],
    /// Width of the band (m, 0.1 to 100).
    #[serde(default = "lane_width")]
    pub width_m: f32,
    /// How far it reaches before and behind (m, 0.1 to 1000).
    #[serde(default = "lane_reach")]
    pub reach_m: f32,
}

fn lane_width() -> f32 {
    1.0
}

fn lane_reach() -> f32 {
    5.0
}

impl MeasureConfig {
    pub(super) fn find_fault(&self) -> Result<(), Fault> {
        if let Some(gate) = &self.gate {
            check_point("measure.gate.from", &gate.from, 2)?;
            check_point("measure.gate.to", &gate.to, 2)?;
            if gate.from == gate.to {
                return fault("measure.gate", "expected two ends that differ");
            }
        }
        if let Some(lanes) = &self.lanes {
            check_numbers(&[
                ("measure.lanes.width_m", lanes.width_m, 0.1, 100.0),
                ("measure.lanes.reach_m", lanes.reach_m, 0.1, 1000.0),
            ])?;
            if !lanes.along.iter().all(|v| v.is_finite()) || lanes.along == [0.0; 2] {
                return fault("measure.lanes.along", format!("expected a direction, found {:?}", lanes.along));
            }
        }
        Ok(())
    }
}

/// What a scene's picture shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct PictureConfig {
    /// Number of the character in a world whose motion is shown; the one that did the most different things where absent.
    pub follow: Option<usize>,
    /// What the overview of a world looks at: x, y, z; its middle where absent (m).
    pub focus: Option<[f32; 3]>,
    /// Width of what the overview of a world shows; all of it where absent (m).
    pub width_m: Option<f32>,
    /// Styles of the scene's blend spaces that are shown on one path.
    pub shown: Vec<ShownStyle>,
}

/// A style that the picture shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ShownStyle {
    /// What it is called.
    pub name: String,
    /// Its blend space.
    pub space: String,
    /// Value of the first style axis (-1000 to 1000).
    #[serde(default)]
    pub style: f32,
    /// How fast the path is walked (m/s, 0.1 to 20).
    pub speed: f32,
}

impl PictureConfig {
    pub(super) fn find_fault(&self) -> Result<(), Fault> {
        for (i, s) in self.shown.iter().enumerate() {
            check_numbers(&[
                (&format!("picture.shown[{i}].speed"), s.speed, 0.1, 20.0),
                (&format!("picture.shown[{i}].style"), s.style, -1e3, 1e3),
            ])?;
        }
        Ok(())
    }
}
