//! Services: tills that serve those who stand in lines.

use crate::scene::check::{KeyFault, check_numbers, key_fault};
use serde::{Deserialize, Serialize};

/// Service: agents stand in line until a till is free, are served there, and go.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ServiceConfig {
    /// Name, unique in the scene, for the action `be_served`.
    pub name: String,
    /// Place whose slots are the tills.
    pub tills: String,
    /// Places with a queue, in which agents stand.
    pub lines: Vec<String>,
    /// Line that agents join.
    #[serde(default)]
    pub join: LineChoice,
    /// Whether each till serves a line of its own, the first till the first line; else all serve all, who came first in any line first.
    #[serde(default)]
    pub apart: bool,
    /// Expression about `me`: of those in line, the agent with the greatest value is served first, wherever it stands.
    pub priority: Option<String>,
    /// Time at a till (s).
    pub time_s: TimeDistribution,
    /// Predicate at the end of a line, which is `place`: agents for whom it is true go away.
    pub balk: Option<String>,
    /// Time in line after which agents leave it (s).
    pub patience_s: Option<TimeDistribution>,
}

/// Choice among the lines of a service.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LineChoice {
    /// The line with the fewest agents; of equal ones, the nearest.
    #[default]
    Shortest,
    /// The line whose end is nearest.
    Nearest,
}

/// Distribution of a time that is drawn for each agent (s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum TimeDistribution {
    /// Always the same.
    Fixed(f64),
    /// Even between a least and a greatest time.
    Even([f64; 2]),
    /// Exponential, with this mean.
    Exponential(f64),
    /// Normal, with mean and standard deviation; at least a tenth of the mean.
    Normal([f64; 2]),
}

impl ServiceConfig {
    pub(in crate::scene) fn find_fault(&self, key: &str) -> Result<(), KeyFault> {
        if self.lines.is_empty() {
            return key_fault(&format!("{key}.lines"), "expected the name of a place with a `queue`, found none");
        }
        self.time_s.find_fault(&format!("{key}.time_s"))?;
        self.patience_s.map_or(Ok(()), |time| time.find_fault(&format!("{key}.patience_s")))
    }
}

impl TimeDistribution {
    fn find_fault(&self, key: &str) -> Result<(), KeyFault> {
        let (name, numbers) = match *self {
            Self::Fixed(time) => ("fixed", [time, time]),
            Self::Even(range) => ("even", range),
            Self::Exponential(mean) => ("exponential", [mean, mean]),
            Self::Normal(numbers) => ("normal", numbers),
        };
        if matches!(self, Self::Even([least, most]) if least > most) {
            return key_fault(&format!("{key}.{name}"), format!("expected two times that ascend, found {numbers:?}"));
        }
        numbers.iter().try_for_each(|time| check_numbers(&[(&format!("{key}.{name}"), *time, 0.0, 1e6)]))
    }

    /// Time for two random numbers from 0 up to 1 (s).
    pub(crate) fn time_at(&self, [a, b]: [f64; 2]) -> f64 {
        use throng_base::maths::{cos, ln};
        match *self {
            Self::Fixed(time) => time,
            Self::Even([least, most]) => least + (most - least) * a,
            Self::Exponential(mean) => -mean * ln(1.0 - a),
            // Box and Muller (1958).
            Self::Normal([mean, spread]) => {
                let normal = (-2.0 * ln(1.0 - a)).sqrt() * cos(std::f64::consts::TAU * b);
                (mean + spread * normal).max(0.1 * mean)
            }
        }
    }
}
