//! Groups of a crowd: how many, where they start, where they go and what they are like.

use super::config::{check_corners, check_point};
use crate::scene::file::{Fault, check_count, check_numbers, fault};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_runtime::crowd::AtEnd;

/// Agents who start and go alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroupConfig {
    /// What messages and pictures call it; its number where absent.
    #[serde(default)]
    pub name: String,
    /// How many (1 to 1000000).
    pub count: usize,
    /// Where they start.
    pub place: PlaceConfig,
    /// Where they go.
    pub goal: GoalConfig,
    /// Subgoals that all of them pass before, in order (m).
    #[serde(default)]
    pub via: Vec<Vec<f32>>,
    /// How near to the goal is there (m, 0.01 to 1000).
    #[serde(default = "arrival")]
    pub arrival_m: f32,
    /// What is done there.
    #[serde(default)]
    pub at_end: AtEndConfig,
    /// Radii: least, most (m, 0.01 to 100).
    #[serde(default = "radius")]
    pub radius_m: [f32; 2],
    /// Desired speeds: least, most (m/s, 0 to 100).
    #[serde(default = "speed")]
    pub speed_mps: [f32; 2],
    /// Largest accelerations: least, most (m/s^2, 0.01 to 1000).
    #[serde(default = "acceleration")]
    pub acceleration_mps2: [f32; 2],
}

fn arrival() -> f32 {
    0.5
}

fn radius() -> [f32; 2] {
    [0.3; 2]
}

fn speed() -> [f32; 2] {
    [1.3; 2]
}

fn acceleration() -> [f32; 2] {
    [5.0; 2]
}

/// Where a group starts, everybody at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlaceConfig {
    /// Rows and columns (and layers, in the air) between two corners.
    Block {
        /// Lowest corner (m).
        from: Vec<f32>,
        /// Highest corner (m).
        to: Vec<f32>,
        /// How far they stand off their rows: 1 as far as they can without touching (0 to 1).
        #[serde(default = "jitter")]
        jitter: f32,
    },
    /// A filled disc on the ground, or ball in the air, as large as the density asks for.
    Disc {
        /// Its middle (m).
        centre: Vec<f32>,
        /// Agents on a square metre, or in a cubic metre (1/m^2 or 1/m^3, 1e-6 to 100).
        density: f32,
    },
    /// Rings about a middle, on the ground.
    Ring {
        /// The middle (m).
        centre: Vec<f32>,
        /// Between neighbours of a ring, and between rings (m, 0.02 to 1000).
        spacing_m: f32,
        /// Number of rings, one in the other (1 to 100).
        #[serde(default = "one_ring")]
        rings: usize,
    },
}

fn jitter() -> f32 {
    0.5
}

fn one_ring() -> usize {
    1
}

/// Where a group goes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum GoalConfig {
    /// Everybody to the same point.
    Point {
        /// The point (m).
        at: Vec<f32>,
    },
    /// Everybody as far in the same direction.
    Shift {
        /// How far (m).
        by: Vec<f32>,
    },
    /// Everybody to the other side of a point, as far from it as they start.
    Opposite {
        /// The point (m).
        centre: Vec<f32>,
    },
    /// Everybody to a place of their own between two corners, arranged as at the start.
    Area {
        /// Lowest corner (m).
        from: Vec<f32>,
        /// Highest corner (m).
        to: Vec<f32>,
    },
    /// Everybody by chance through points between two corners, then from the first again.
    Wander {
        /// Lowest corner (m).
        from: Vec<f32>,
        /// Highest corner (m).
        to: Vec<f32>,
        /// Number of points (2 to 1000).
        #[serde(default = "points")]
        points: usize,
    },
    /// Everybody stays where they are.
    Stay {},
}

fn points() -> usize {
    12
}

/// What is done at a goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AtEndConfig {
    /// Stays.
    #[default]
    Stay,
    /// Leaves the crowd.
    Leave,
    /// Begins the way again.
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

impl GroupConfig {
    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), Fault> {
        check_count(&format!("{key}.count"), self.count)?;
        self.place.find_fault(&format!("{key}.place"), dimensions)?;
        self.goal.find_fault(&format!("{key}.goal"), dimensions)?;
        for (i, point) in self.via.iter().enumerate() {
            check_point(&format!("{key}.via[{i}]"), point, dimensions)?;
        }
        check_numbers(&[(&format!("{key}.arrival_m"), self.arrival_m, 0.01, 1000.0)])?;
        for (name, [from, to], low, high) in [
            ("radius_m", self.radius_m, 0.01, 100.0),
            ("speed_mps", self.speed_mps, 0.0, 100.0),
            ("acceleration_mps2", self.acceleration_mps2, 0.01, 1000.0),
        ] {
            if !(low <= from && from <= to && to <= high) {
                let why = format!("expected two numbers that ascend from {low} to {high}, found {from}, {to}");
                return fault(&format!("{key}.{name}"), why);
            }
        }
        Ok(())
    }

    pub(super) fn stretch(&mut self, by: f32) {
        match &mut self.place {
            PlaceConfig::Block { from, to, .. } => scale(&mut [from, to], by),
            PlaceConfig::Disc { centre, .. } | PlaceConfig::Ring { centre, .. } => scale(&mut [centre], by),
        }
        self.goal.stretch(by);
        self.via.iter_mut().for_each(|p| scale(&mut [p], by));
    }
}

impl PlaceConfig {
    fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), Fault> {
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
                    return fault(&format!("{key}.ring"), "expected none in the air: use disc or block");
                }
                check_point(&format!("{key}.ring.centre"), centre, dimensions)?;
                check_numbers(&[(&format!("{key}.ring.spacing_m"), *spacing_m, 0.02, 1000.0)])?;
                check_numbers(&[(&format!("{key}.ring.rings"), *rings, 1, 100)])
            }
        }
    }
}

impl GoalConfig {
    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), Fault> {
        match self {
            Self::Point { at } => check_point(&format!("{key}.point.at"), at, dimensions),
            Self::Shift { by } => check_point(&format!("{key}.shift.by"), by, dimensions),
            Self::Opposite { centre } => check_point(&format!("{key}.opposite.centre"), centre, dimensions),
            Self::Area { from, to } => check_corners(&format!("{key}.area"), from, to, dimensions),
            Self::Wander { from, to, points } => {
                check_corners(&format!("{key}.wander"), from, to, dimensions)?;
                check_numbers(&[(&format!("{key}.wander.points"), *points, 2, 1000)])
            }
            Self::Stay {} => Ok(()),
        }
    }

    pub(super) fn stretch(&mut self, by: f32) {
        match self {
            Self::Point { at } => scale(&mut [at], by),
            Self::Shift { by: far } => scale(&mut [far], by),
            Self::Opposite { centre } => scale(&mut [centre], by),
            Self::Area { from, to } | Self::Wander { from, to, .. } => scale(&mut [from, to], by),
            Self::Stay {} => {}
        }
    }
}

/// Multiplies the coordinates of points.
pub(super) fn scale(points: &mut [&mut Vec<f32>], by: f32) {
    points.iter_mut().flat_map(|p| p.iter_mut()).for_each(|v| *v *= by);
}
