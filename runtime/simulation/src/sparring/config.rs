//! How characters spar.

use super::body::BodyShape;
use throng_base::error::check;
use throng_base::{Hash128, Result};
use throng_core::characters::CharactersConfig;

/// Time until a blow where none is coming (s).
pub const NO_THREAT_S: f32 = 1e3;

/// How far two bodies may come into each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationConfig {
    /// False lets bodies pass through each other.
    pub enabled: bool,
    /// Gap below which bodies already begin to part (m, 0 to 1).
    pub margin_m: f32,
    /// Fastest that two characters with a foot in the air part; one that stands on both feet takes a quarter of its
    /// share (m/s, 0 to 10).
    pub max_speed_mps: f32,
    /// Overlap above which time counts as deep (m, 0 to 1).
    pub deep_m: f32,
    /// Distance between the middles of heads below which bodies part too: nobody can strike from nearer (m, 0 to 1).
    pub heads_m: f32,
    /// How fast heads lean away from each other for each metre that they are nearer than that (1/s, 0 to 100).
    pub lean_per_s: f32,
}

impl Default for SeparationConfig {
    fn default() -> Self {
        Self { enabled: true, margin_m: 0.04, max_speed_mps: 0.6, deep_m: 0.05, heads_m: 0.6, lean_per_s: 3.0 }
    }
}

/// How arms stop at the other's body and guard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchConfig {
    /// False lets arms pass through the other's body.
    pub enabled: bool,
    /// Time in which an arm that is free again has come half of the way back to its motion (s, 0.001 to 10).
    pub half_life_s: f32,
    /// How far flesh gives (m, 0 to 0.1).
    pub give_m: f32,
    /// Fastest that touch turns an elbow, where its motion does not turn it faster (rad/s, 1 to 1000).
    pub elbow_radps: f32,
}

impl Default for TouchConfig {
    fn default() -> Self {
        Self { enabled: true, half_life_s: 0.1, give_m: 0.015, elbow_radps: 33.0 }
    }
}

/// Who steps away when struck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaggerConfig {
    /// Force from which a blow to head or trunk makes who is struck step away with it, see
    /// [`throng_core::characters::Blow::force`]; above 1 nobody does (0 to 10).
    pub force: f32,
    /// How far joints may be, on average, from where the step away begins (m, 0 to 1).
    pub alike_m: f32,
}

impl Default for StaggerConfig {
    fn default() -> Self {
        Self { force: 0.95, alike_m: 0.3 }
    }
}

/// How characters spar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SparringConfig {
    /// How the characters move.
    pub characters: CharactersConfig,
    /// How thick bodies are.
    pub body: BodyShape,
    /// How near to a body a blow must come to land (m, 0 to 1).
    pub reach_m: f32,
    /// Last part of a blow's way on which it strikes what is in it (m, 0 to 1).
    pub way_m: f32,
    /// Displacement of what is struck, for each metre a second of the blow (s, 0 to 1).
    pub push_m_per_mps: f32,
    /// How bodies are kept apart.
    pub separation: SeparationConfig,
    /// How arms stop at the other's body and guard.
    pub touch: TouchConfig,
    /// Who steps away when struck.
    pub stagger: StaggerConfig,
}

impl SparringConfig {
    /// Content hash, but for how the characters move.
    pub(super) fn hash(&self) -> u128 {
        let numbers =
            (self.body, self.reach_m, self.way_m, self.push_m_per_mps, self.separation, self.touch, self.stagger);
        Hash128::of(format!("{numbers:?}").as_bytes())
    }

    pub(super) fn check(&self) -> Result<()> {
        self.body.check()?;
        self.touch.check()?;
        self.stagger.check()?;
        for (what, got) in [
            ("reach_m", self.reach_m),
            ("way_m", self.way_m),
            ("push_m_per_mps", self.push_m_per_mps),
            ("separation.margin_m", self.separation.margin_m),
            ("separation.deep_m", self.separation.deep_m),
            ("separation.heads_m", self.separation.heads_m),
        ] {
            within(what, got, 0.0, 1.0, "between 0 and 1")?;
        }
        within("separation.lean_per_s", self.separation.lean_per_s, 0.0, 100.0, "between 0 and 100")?;
        within("separation.max_speed_mps", self.separation.max_speed_mps, 0.0, 10.0, "between 0 and 10")
    }
}

impl Default for SparringConfig {
    fn default() -> Self {
        Self {
            characters: CharactersConfig::default(),
            body: BodyShape::default(),
            reach_m: 0.06,
            way_m: 0.15,
            push_m_per_mps: 0.012,
            separation: SeparationConfig::default(),
            touch: TouchConfig::default(),
            stagger: StaggerConfig::default(),
        }
    }
}

/// An error where a number is out of its range.
pub(super) fn within(what: &'static str, got: f32, least: f32, most: f32, expected: &'static str) -> Result<()> {
    check(what, None, got, (least..=most).contains(&got), expected)
}
