//! Config of a run.

use serde::{Deserialize, Serialize};
use throng_core::base::limits;
use throng_core::characters::{ActionChoice, AvoidConfig, CharactersConfig, FootLockConfig};

/// Steps a second of simulated time (Hz).
pub const STEP_HZ: f32 = 60.0;
/// Most characters of a run.
pub const MAX_CHARACTERS: usize = limits::SHOWN_CHARACTERS.most as usize;

/// Largest crowd in which all characters are posed in full; in larger ones, characters far from the eye are drawn from
/// records.
pub const MOST_POSED: usize = 5000;

/// Farthest from the origin that a target may be moved (m).
pub const MAX_TARGET_M: f32 = 1e4;

/// Behaviour of targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TargetMode {
    /// Each character has its own, fixed target.
    #[default]
    Own,
    /// Each character has its own target, which moves on when it is reached.
    Wander,
    /// One target for all.
    Shared,
}

impl TargetMode {
    /// All modes with their names.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Own, "own, fixed"), (Self::Wander, "own, moves on when reached"), (Self::Shared, "one for all")];
}

/// Config of a run. The same config on the same bundle gives the same run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CrowdRunConfig {
    /// Number of characters (1 to MAX_CHARACTERS).
    pub characters: usize,
    /// Seed of places, targets and choices.
    pub seed: u64,
    /// Behaviour of targets.
    pub targets: TargetMode,
    /// Nearest and farthest a target stands (m).
    pub distances: [f32; 2],
    /// Distance between neighbours at the start (m).
    pub spacing_m: f32,
    /// A target counts as reached within this distance (m).
    pub reach_m: f32,
    /// Load the stored best action instead of looking ahead.
    pub single_load: bool,
    /// Randomness of the choice among the best actions; 0 takes the best.
    pub temperature: f32,
    /// Largest bend of a walked action towards the target (rad/m).
    pub bend_rad_per_m: f32,
    /// Hold planted feet.
    pub foot_lock: bool,
    /// Avoid each other.
    pub avoid: bool,
}

impl Default for CrowdRunConfig {
    fn default() -> Self {
        Self {
            characters: 100,
            seed: 1,
            targets: TargetMode::Wander,
            distances: [2.0, 6.0],
            spacing_m: 2.0,
            reach_m: 0.5,
            single_load: false,
            temperature: 0.0,
            bend_rad_per_m: 0.0,
            foot_lock: true,
            avoid: true,
        }
    }
}

impl CrowdRunConfig {
    /// The nearest config that can be run.
    pub fn limited(self) -> Self {
        let finite = |v: f32, low: f32, high: f32, or: f32| if v.is_finite() { v.clamp(low, high) } else { or };
        let d = Self::default();
        let near = finite(self.distances[0], 0.0, 100.0, d.distances[0]);
        Self {
            characters: self.characters.clamp(1, MAX_CHARACTERS),
            distances: [near, finite(self.distances[1], near, 100.0, d.distances[1].max(near))],
            spacing_m: finite(self.spacing_m, 1.0, 20.0, d.spacing_m),
            reach_m: finite(self.reach_m, 0.05, 10.0, d.reach_m),
            temperature: finite(self.temperature, 0.0, 10.0, d.temperature),
            bend_rad_per_m: finite(self.bend_rad_per_m, 0.0, 2.0, d.bend_rad_per_m),
            ..self
        }
    }

    /// Config of the simulated characters.
    pub fn characters(&self) -> CharactersConfig {
        let look_ahead = ActionChoice::LookAhead { temperature: self.temperature };
        let choice = if self.single_load { ActionChoice::BestAction } else { look_ahead };
        CharactersConfig {
            seed: self.seed,
            choice,
            bend_rad_per_m: self.bend_rad_per_m,
            foot_lock: FootLockConfig { enabled: self.foot_lock, ..FootLockConfig::default() },
            avoid: self.avoid.then(AvoidConfig::default),
            instances: self.characters > MOST_POSED,
            timed: true,
            ..CharactersConfig::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_config_can_be_limited_to_one_that_runs() {
        let wild = CrowdRunConfig {
            characters: usize::MAX,
            distances: [f32::NAN, f32::INFINITY],
            spacing_m: -1.0,
            reach_m: f32::NEG_INFINITY,
            temperature: f32::NAN,
            bend_rad_per_m: 1e30,
            ..CrowdRunConfig::default()
        };
        let l = wild.limited();
        assert_eq!(l.characters, MAX_CHARACTERS);
        assert!(l.distances[0] <= l.distances[1] && l.spacing_m >= 1.0 && l.reach_m > 0.0);
        assert!(l.temperature == 0.0 && l.bend_rad_per_m == 2.0);
        assert_eq!(CrowdRunConfig::default().limited(), CrowdRunConfig::default());
    }
}
