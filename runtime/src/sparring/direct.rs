//! Taking a hand in a bout or a practice: what behaviours count, and segments that are played at once.

use super::bout::Sparring;
use super::config::within;
use super::practice::TargetPractice;
use crate::troupe::{Repertoire, TroupeError};

impl Sparring {
    /// Sets what each goal of the config counts from the next step on; 0 switches it off.
    ///
    /// # Errors
    /// [`TroupeError::Length`] where there are not as many weights as goals, [`TroupeError::Value`] for one that is
    /// not finite or too large; nothing has changed then.
    pub fn set_weights(&mut self, weights: &[f32]) -> Result<(), TroupeError> {
        check(weights, self.config.goals.len())?;
        self.config.goals.iter_mut().zip(weights).for_each(|(goal, &weight)| goal.weight = weight);
        Ok(())
    }

    /// Lets a character play a segment at once, see [`crate::troupe::Troupe::play`].
    ///
    /// # Errors
    /// As [`crate::troupe::Troupe::play`].
    pub fn play(&mut self, repertoire: &Repertoire<'_>, character: usize, segment: u32) -> Result<(), TroupeError> {
        self.troupe.play(repertoire, character, segment)
    }
}

impl TargetPractice {
    /// As [`Sparring::set_weights`].
    ///
    /// # Errors
    /// As [`Sparring::set_weights`].
    pub fn set_weights(&mut self, weights: &[f32]) -> Result<(), TroupeError> {
        check(weights, self.config.goals.len())?;
        self.config.goals.iter_mut().zip(weights).for_each(|(goal, &weight)| goal.weight = weight);
        Ok(())
    }

    /// As [`Sparring::play`].
    ///
    /// # Errors
    /// As [`crate::troupe::Troupe::play`].
    pub fn play(&mut self, repertoire: &Repertoire<'_>, character: usize, segment: u32) -> Result<(), TroupeError> {
        self.troupe.play(repertoire, character, segment)
    }
}

fn check(weights: &[f32], expected: usize) -> Result<(), TroupeError> {
    if weights.len() != expected {
        return Err(TroupeError::Length { what: "weights", got: weights.len(), expected });
    }
    weights.iter().try_for_each(|&w| within("weight", w, -1e6, 1e6, "a finite number below 1e6"))
}
