//! Direct lookup: the stored best action of the cell nearest to the target.

use super::look_ahead::{check_states, check_targets};
use super::table::{NO_ACTION, PolicyTable};
use glam::Vec3;
use throng_base::{Result, error::check_length};

/// Looks up the next action of every character in one pass.
///
/// Slices are `[num_characters]`. Allocates nothing; split by range to run on several threads.
///
/// ```no_run
/// use throng_core::{Bundle, glam::Vec3, policy::BestActionJob};
///
/// let bundle = Bundle::open("people.throng")?;
/// let (policy, targets, mut actions) = (&bundle.policies()[0], [Vec3::Z, Vec3::X], [0; 2]);
/// BestActionJob { policy, states: &[0, 1], targets: &targets, choice: 0, actions: &mut actions }.run()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct BestActionJob<'a> {
    /// The policy.
    pub policy: &'a PolicyTable,
    /// State of each character (< num_states).
    pub states: &'a [u32],
    /// Target of each character in its own frame: +Z ahead, +X left (m).
    pub targets: &'a [Vec3],
    /// Rank of the choice to take, 0 for the best; the best one if there is no such choice.
    pub choice: u8,
    /// Output: action as an index within the state's actions.
    pub actions: &'a mut [u8],
}

impl BestActionJob<'_> {
    /// Checks the inputs.
    ///
    /// # Errors
    /// [`Error`](throng_base::Error) if the slices differ in length, a state does not exist or a target is not finite.
    pub fn validate(&self) -> Result<()> {
        let n = self.states.len();
        check_length("targets", self.targets.len(), n)?;
        check_length("actions", self.actions.len(), n)?;
        check_states(self.states, self.policy.actions().num_states())?;
        check_targets(self.targets)
    }

    /// Checks the inputs and writes the actions.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn run(self) -> Result<()> {
        self.validate()?;
        let choice = usize::from(self.choice).min(self.policy.num_choices() - 1);
        for ((action, &state), &target) in self.actions.iter_mut().zip(self.states).zip(self.targets) {
            let best = self.policy.best_of(state, self.policy.nearest_cell(state, target));
            *action = if best[choice] == NO_ACTION { best[0] } else { best[choice] };
        }
        Ok(())
    }
}
