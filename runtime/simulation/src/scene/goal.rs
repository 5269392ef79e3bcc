//! Goals of groups of agents.

use super::check::{KeyFault, check_corners, check_numbers, check_point, key_fault};
use serde::{Deserialize, Serialize};
use throng_crowd::AtEnd;

/// Goal of a group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum GoalConfig {
    /// The same point for all agents.
    Point {
        /// The point (m).
        at: Vec<f32>,
    },
    /// A place of the scene, or of its level.
    Place {
        /// Name of the place.
        name: String,
    },
    /// Ground of the scene's level, on all its floors: each person goes to a point of it by chance.
    Level {
        /// Names of places, to one of which each goes; anywhere where there are none.
        #[serde(default)]
        names: Vec<String>,
    },
    /// The same displacement for all agents.
    Shift {
        /// Displacement (m).
        by: Vec<f32>,
    },
    /// The other side of a point, as far from it as the start of each agent.
    Opposite {
        /// The point (m).
        centre: Vec<f32>,
    },
    /// A place of its own for each agent between two corners, arranged as at the start.
    Area {
        /// Lowest corner (m).
        from: Vec<f32>,
        /// Highest corner (m).
        to: Vec<f32>,
    },
    /// Random points between two corners for each agent, then from the first again.
    Wander {
        /// Lowest corner (m).
        from: Vec<f32>,
        /// Highest corner (m).
        to: Vec<f32>,
        /// Number of points (2 to 1000).
        #[serde(default = "points")]
        points: usize,
    },
    /// The start of each agent.
    Stay {},
}

fn points() -> usize {
    12
}

/// Behaviour of agents at their goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum AtEndConfig {
    /// Stays.
    #[default]
    Stay,
    /// Leaves the crowd.
    Leave,
    /// Begins the route again.
    Again,
}

impl From<AtEndConfig> for AtEnd {
    fn from(c: AtEndConfig) -> Self {
        match c {
            AtEndConfig::Stay => Self::Stay,
            AtEndConfig::Leave => Self::Leave,
            AtEndConfig::Again => Self::Again,
        }
    }
}

impl GoalConfig {
    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), KeyFault> {
        match self {
            Self::Point { at } => check_point(&format!("{key}.point.at"), at, dimensions),
            // Known ones were replaced by their points.
            Self::Place { name } => key_fault(
                &format!("{key}.place.name"),
                format!(
                    "there is no place \"{name}\" in the scene or its level; `throng inspect` lists those of a level"
                ),
            ),
            Self::Shift { by } => check_point(&format!("{key}.shift.by"), by, dimensions),
            Self::Opposite { centre } => check_point(&format!("{key}.opposite.centre"), centre, dimensions),
            Self::Area { from, to } => check_corners(&format!("{key}.area"), from, to, dimensions),
            Self::Wander { from, to, points } => {
                check_corners(&format!("{key}.wander"), from, to, dimensions)?;
                check_numbers(&[(&format!("{key}.wander.points"), *points, 2, 1000)])
            }
            Self::Level { .. } | Self::Stay {} => Ok(()),
        }
    }

    pub(super) fn stretch(&mut self, by: f32) {
        match self {
            Self::Point { at } => scale_points(&mut [at], by),
            Self::Shift { by: far } => scale_points(&mut [far], by),
            Self::Opposite { centre } => scale_points(&mut [centre], by),
            Self::Area { from, to } | Self::Wander { from, to, .. } => scale_points(&mut [from, to], by),
            Self::Place { .. } | Self::Level { .. } | Self::Stay {} => {}
        }
    }
}

/// Multiplies the coordinates of points.
pub(super) fn scale_points(points: &mut [&mut Vec<f32>], by: f32) {
    points.iter_mut().flat_map(|p| p.iter_mut()).for_each(|v| *v *= by);
}
