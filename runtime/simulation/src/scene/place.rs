//! Starts of groups.

use super::check::{KeyFault, check_corners, check_numbers, check_point, key_fault};
use super::goal::scale_points;
use serde::{Deserialize, Serialize};

/// Start of a group, in which all are at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlaceConfig {
    /// Rows and columns (and layers, in the air) between two corners.
    Block {
        /// Lowest corner (m).
        from: Vec<f32>,
        /// Highest corner (m).
        to: Vec<f32>,
        /// Random displacement off the rows: 1 for the largest without touching (0 to 1).
        #[serde(default = "jitter")]
        jitter: f32,
    },
    /// A filled disc on the ground, or ball in the air, as large as the density asks for.
    Disc {
        /// Centre (m).
        centre: Vec<f32>,
        /// Density of agents (1/m^2 or 1/m^3, 1e-6 to 100).
        density: f32,
    },
    /// Rings around a centre, on the ground.
    Ring {
        /// Centre (m).
        centre: Vec<f32>,
        /// Distance between neighbours of a ring, and between rings (m, 0.02 to 1000).
        spacing_m: f32,
        /// Number of concentric rings (1 to 100).
        #[serde(default = "one_ring")]
        rings: usize,
    },
    /// Ground of the scene's level, on all its floors.
    Level {
        /// Names of places, around which people stand in turn; anywhere where there are none.
        #[serde(default)]
        names: Vec<String>,
    },
    /// Square grid on the ground with random headings: pairs face each other, and other characters their targets.
    Grid {
        /// Centre (m).
        #[serde(default)]
        centre: [f32; 2],
        /// Distance between neighbours: pairs, or characters with their targets (m, 0.5 to 1000).
        #[serde(default = "spacing")]
        spacing_m: f64,
        /// Distance between a character and its opponent or target at the start (m, 0.1 to 1000).
        #[serde(default = "distance")]
        distance_m: f64,
    },
}

throng_base::key_defaults! {
    spacing: f64 = 4.0;
    distance: f64 = 1.5;
    jitter: f32 = 0.5;
    one_ring: usize = 1;
}

impl PlaceConfig {
    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), KeyFault> {
        match self {
            Self::Block { from, to, jitter } => {
                check_corners(&format!("{key}.block"), from, to, dimensions)?;
                check_numbers(&[(&format!("{key}.block.jitter"), *jitter, 0.0, 1.0)])
            }
            Self::Disc { centre, density } => {
                check_point(&format!("{key}.disc.centre"), centre, dimensions)?;
                check_numbers(&[(&format!("{key}.disc.density"), *density, 1e-6, 100.0)])
            }
            Self::Ring { centre, spacing_m, rings } => {
                if dimensions != 2 {
                    return key_fault(&format!("{key}.ring"), "expected none in the air: use disc or block");
                }
                check_point(&format!("{key}.ring.centre"), centre, dimensions)?;
                check_numbers(&[(&format!("{key}.ring.spacing_m"), *spacing_m, 0.02, 1000.0)])?;
                check_numbers(&[(&format!("{key}.ring.rings"), *rings, 1, 100)])
            }
            Self::Level { .. } => Ok(()),
            Self::Grid { centre, spacing_m, distance_m } => {
                check_point(&format!("{key}.grid.centre"), centre, 2)?;
                check_numbers(&[
                    (&format!("{key}.grid.spacing_m"), *spacing_m, 0.5, 1e3),
                    (&format!("{key}.grid.distance_m"), *distance_m, 0.1, 1e3),
                ])
            }
        }
    }

    pub(super) fn stretch(&mut self, by: f32) {
        match self {
            Self::Block { from, to, .. } => scale_points(&mut [from, to], by),
            Self::Disc { centre, .. } | Self::Ring { centre, .. } => scale_points(&mut [centre], by),
            Self::Level { .. } | Self::Grid { .. } => {}
        }
    }
}
