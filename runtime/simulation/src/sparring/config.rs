//! Settings of sparring.

use super::body::BodyShape;
use throng_base::{Hash128, Result, error::check_value};
use throng_core::{body::TouchConfig, characters::CharactersConfig};

/// Time until the next blow where no blow is coming (s).
pub const NO_THREAT_S: f32 = 1e3;

/// Settings of the separation of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationConfig {
    /// False lets bodies pass through each other.
    pub enabled: bool,
    /// Gap below which bodies begin to move apart (m, 0 to 1).
    pub margin_m: f32,
    /// Largest speed at which two characters with a foot in the air move apart; one that stands on both feet takes a quarter of
    /// its share (m/s, 0 to 10).
    pub max_speed_mps: f32,
    /// Overlap above which time counts as deep (m, 0 to 1).
    pub deep_m: f32,
    /// Distance between the centres of heads below which bodies also move apart: no blow is possible from nearer (m, 0 to 1).
    pub heads_m: f32,
    /// Speed at which heads lean away from each other, for each metre below that distance (1/s, 0 to 100).
    pub lean_per_s: f32,
}

impl Default for SeparationConfig {
    fn default() -> Self {
        Self { enabled: true, margin_m: 0.04, max_speed_mps: 0.6, deep_m: 0.05, heads_m: 0.6, lean_per_s: 3.0 }
    }
}

/// Settings of steps away by struck characters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaggerConfig {
    /// Least force of a blow to head or trunk that makes the struck character step away with it, see
    /// [`throng_core::characters::Blow::force`]; above 1 no blow does (0 to 10).
    pub force: f32,
    /// Largest mean distance of joints from the first pose of the step away (m, 0 to 1).
    pub alike_m: f32,
}

impl Default for StaggerConfig {
    fn default() -> Self {
        Self { force: 0.95, alike_m: 0.3 }
    }
}

/// Settings of sparring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SparringConfig {
    /// Settings of the characters' motion.
    pub characters: CharactersConfig,
    /// Radii of bodies.
    pub body: BodyShape,
    /// Distance from a body at which a blow lands (m, 0 to 1).
    pub reach_m: f32,
    /// Length of the last part of a blow's path, on which it strikes all that it meets (m, 0 to 1).
    pub strike_path_m: f32,
    /// Displacement of the struck joint, for each metre per second of the blow (s, 0 to 1).
    pub push_m_per_mps: f32,
    /// Settings of the separation of bodies.
    pub separation: SeparationConfig,
    /// Settings of limbs that stop at the opponent's body and guard.
    pub touch: TouchConfig,
    /// Settings of steps away by struck characters.
    pub stagger: StaggerConfig,
}

impl SparringConfig {
    /// Content hash, without the settings of the characters' motion.
    pub(super) fn hash(&self) -> u128 {
        let Self { characters: _, body, reach_m, strike_path_m, push_m_per_mps, separation, touch, stagger } = self;
        let numbers = (body, reach_m, strike_path_m, push_m_per_mps, separation, touch, stagger);
        Hash128::hash_bytes(format!("{numbers:?}").as_bytes())
    }

    pub(super) fn check(&self) -> Result<()> {
        self.body.check()?;
        self.touch.check()?;
        self.stagger.check()?;
        for (what, got) in [
            ("reach_m", self.reach_m),
            ("strike_path_m", self.strike_path_m),
            ("push_m_per_mps", self.push_m_per_mps),
            ("separation.margin_m", self.separation.margin_m),
            ("separation.deep_m", self.separation.deep_m),
            ("separation.heads_m", self.separation.heads_m),
        ] {
            check_within(what, got, 0.0, 1.0, "between 0 and 1")?;
        }
        check_within("separation.lean_per_s", self.separation.lean_per_s, 0.0, 100.0, "between 0 and 100")?;
        check_within("separation.max_speed_mps", self.separation.max_speed_mps, 0.0, 10.0, "between 0 and 10")
    }
}

impl Default for SparringConfig {
    fn default() -> Self {
        Self {
            characters: CharactersConfig::default().with_boxers_feet(),
            body: BodyShape::default(),
            reach_m: 0.06,
            strike_path_m: 0.15,
            push_m_per_mps: 0.018,
            separation: SeparationConfig::default(),
            touch: TouchConfig::default(),
            stagger: StaggerConfig::default(),
        }
    }
}

/// Fails where a number is out of its range.
pub(super) fn check_within(what: &'static str, got: f32, least: f32, most: f32, expected: &'static str) -> Result<()> {
    check_value(what, None, got, (least..=most).contains(&got), expected)
}
