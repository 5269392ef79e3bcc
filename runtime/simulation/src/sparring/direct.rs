//! Taking a hand in a bout or a practice: what behaviours count, and segments that are played at once.

use super::bout::Sparring;
use super::config::within;
use super::practice::TargetPractice;
use throng_base::Result;
use throng_base::error::check_length;
use throng_core::characters::MotionSet;

impl Sparring {
    /// Sets what each goal of the config counts from the next step on; 0 switches it off.
    ///
    /// # Errors
    /// [`Error::Length`] where there are not as many weights as goals, [`Error::Value`] for one that is
    /// not finite or too large; nothing has changed then.
    pub fn set_weights(&mut self, weights: &[f32]) -> Result<()> {
        check_weights(weights, self.config.goals.len())?;
        self.config.goals.iter_mut().zip(weights).for_each(|(goal, &weight)| goal.weight = weight);
        Ok(())
    }

    /// Lets a character play a segment at once, see [`throng_core::characters::Characters::play`].
    ///
    /// # Errors
    /// As [`throng_core::characters::Characters::play`].
    pub fn play(&mut self, motion_set: &MotionSet, character: usize, segment: u32) -> Result<()> {
        self.characters.play(motion_set, character, segment)
    }
}

impl TargetPractice {
    /// As [`Sparring::set_weights`].
    ///
    /// # Errors
    /// As [`Sparring::set_weights`].
    pub fn set_weights(&mut self, weights: &[f32]) -> Result<()> {
        check_weights(weights, self.config.goals.len())?;
        self.config.goals.iter_mut().zip(weights).for_each(|(goal, &weight)| goal.weight = weight);
        Ok(())
    }

    /// As [`Sparring::play`].
    ///
    /// # Errors
    /// As [`throng_core::characters::Characters::play`].
    pub fn play(&mut self, motion_set: &MotionSet, character: usize, segment: u32) -> Result<()> {
        self.characters.play(motion_set, character, segment)
    }
}

pub(super) fn check_weights(weights: &[f32], expected: usize) -> Result<()> {
    check_length("weights", weights.len(), expected)?;
    weights.iter().try_for_each(|&w| within("weight", w, -1e6, 1e6, "a finite number below 1e6"))
}
