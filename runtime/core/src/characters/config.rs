//! Settings of characters.

use super::{AvoidConfig, FootLockConfig, ReactionConfig};
use throng_base::error::{check_range, check_value};
use throng_base::{Result, limits::TEMPERATURE};

/// Method by which a character chooses among the actions of its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActionChoice {
    /// The stored best action of the nearest cell: a single load, whatever the policy's region. Needs exactly one goal;
    /// with more, the character looks ahead.
    BestAction,
    /// One-step look-ahead over values, then a random one of the best few; temperature 0 always takes the best.
    LookAhead {
        /// See [`crate::policy::RankedActions::choose`] (>= 0).
        temperature: f32,
    },
}

/// Settings of characters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharactersConfig {
    /// Seed of random choices.
    pub seed: u64,
    /// Number of the first character. Random choices depend on the seed and on this number, so that characters split
    /// into several groups choose as they would together.
    pub first_number: u64,
    /// Method of choosing actions.
    pub choice: ActionChoice,
    /// Time in which the offset of a transition halves (s, > 0).
    pub half_life_s: f32,
    /// Settings of the foot lock.
    pub foot_lock: FootLockConfig,
    /// Reaction of struck characters, see [`super::Characters::push`].
    pub reaction: ReactionConfig,
    /// How much persons differ in the way they hold trunk, arms and head; 0 leaves all as captured (0 to 1).
    pub carriage: f32,
    /// Avoidance of other characters and walls; without it characters ignore both.
    pub avoid: Option<AvoidConfig>,
    /// Also write local transforms.
    pub local_transforms: bool,
    /// True to also write an [`super::PoseInstance`] of every character.
    pub instances: bool,
}

impl Default for CharactersConfig {
    fn default() -> Self {
        Self {
            seed: 1,
            first_number: 0,
            choice: ActionChoice::LookAhead { temperature: 0.0 },
            half_life_s: 0.15,
            foot_lock: FootLockConfig::default(),
            reaction: ReactionConfig::default(),
            carriage: 0.0,
            avoid: None,
            local_transforms: false,
            instances: false,
        }
    }
}

impl CharactersConfig {
    /// Lets planted feet be as far from their motion while a body stands as while it moves: boxers shift their weight over feet that
    /// stay, where others take a step.
    pub fn with_boxers_feet(mut self) -> Self {
        self.foot_lock.reach_m[0] = self.foot_lock.reach_m[1];
        self
    }

    /// Every setting within its limits.
    pub(super) fn check(&self) -> Result<()> {
        let half_life_s = self.half_life_s;
        let good = half_life_s > 1e-3 && half_life_s < 10.0;
        check_value("half_life_s", None, half_life_s, good, "between 0.001 and 10")?;
        self.foot_lock.check()?;
        self.reaction.check()?;
        self.avoid.map_or(Ok(()), |avoid| avoid.check())?;
        check_range("carriage", self.carriage, 0.0..=1.0, "between 0 and 1")?;
        if let ActionChoice::LookAhead { temperature } = self.choice {
            TEMPERATURE.check("temperature", None, temperature)?;
        }
        Ok(())
    }
}
