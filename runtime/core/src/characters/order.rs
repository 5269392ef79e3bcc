//! What one character is to do: behaviours, what each counts, and the target they are about.

use super::control::MAX_GOALS;
use super::motion_set::MotionSet;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::error::{check, check_index};
use throng_base::{Id, Result};

/// Weighted behaviours around one target; stays until it is changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Order {
    policies: [u32; MAX_GOALS],
    weights: [f32; MAX_GOALS],
    num_goals: u32,
    target: Vec3,
}

impl Order {
    /// Nothing to do: the first action of each state is taken.
    pub const IDLE: Self =
        Self { policies: [0; MAX_GOALS], weights: [0.0; MAX_GOALS], num_goals: 0, target: Vec3::ZERO };

    /// One behaviour.
    ///
    /// - `policy`: its number, see [`crate::Bundle::find_policy`].
    /// - `target`: in the world; for a space-time grid with the time left as y (m, s).
    pub fn aim(policy: usize, target: Vec3) -> Self {
        Self { target, ..Self::IDLE }.and(policy, 1.0)
    }

    /// Adds a behaviour around the same target. Where there are more than [`super::MAX_GOALS`], the order is refused.
    ///
    /// - `weight`: what its values count in the sum; it is switched off where the target is outside its region.
    pub fn and(mut self, policy: usize, weight: f32) -> Self {
        if let Some(slot) = self.policies.get_mut(self.num_goals as usize) {
            *slot = u32::try_from(policy).unwrap_or(u32::MAX);
            self.weights[self.num_goals as usize] = weight;
        }
        self.num_goals = self.num_goals.saturating_add(1);
        self
    }

    /// The same behaviours around another target (m).
    pub fn around(self, target: Vec3) -> Self {
        Self { target, ..self }
    }

    /// The target (m).
    pub fn target(&self) -> Vec3 {
        self.target
    }

    /// Numbers of the policies.
    pub fn policies(&self) -> &[u32] {
        &self.policies[..(self.num_goals as usize).min(MAX_GOALS)]
    }

    /// What each counts (policies().len()).
    pub fn weights(&self) -> &[f32] {
        &self.weights[..self.policies().len()]
    }

    /// The same with other numbers of policies.
    pub(crate) fn renumbered(mut self, number: impl Fn(u32) -> Result<u32>) -> Result<Self> {
        for policy in self.policies.iter_mut().take(self.num_goals as usize) {
            *policy = number(*policy)?;
        }
        Ok(self)
    }

    pub(crate) fn check(&self, who: Option<Id>, motion_set: &MotionSet) -> Result<()> {
        let n = self.num_goals as usize;
        check("the number of behaviours", who, n as f64, n <= MAX_GOALS, "0 to 4")?;
        for (&policy, &weight) in self.policies().iter().zip(self.weights()) {
            check_index("policy", who, policy as usize, motion_set.num_policies())?;
            check("weight", who, weight, weight.abs() < 1e6, "a finite number below 1e6")?;
        }
        let Vec3 { x, y, z } = self.target;
        for (what, got) in [("target x", x), ("target y", y), ("target z", z)] {
            check(what, who, got, got.abs() < 1e6, "a finite number below 1e6 (m)")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_done_is_told_with_the_character_and_the_coordinate() {
        let motion_set = MotionSet::new(&super::super::made_up::tables());
        let who = Some(Id { index: 3, generation: 1 });
        let say = |order: Order| order.check(who, &motion_set).unwrap_err().to_string();
        let message = say(Order::aim(0, Vec3::new(1.0, 2.0, f32::NAN)));
        assert!(message.contains('3') && message.contains("target z") && message.contains("NaN"), "{message}");
        assert!(say(Order::aim(1, Vec3::ONE)).contains("policy 1"));
        assert!(say(Order::aim(0, Vec3::ONE).and(0, f32::INFINITY)).contains("weight"));
        let five = (0..4).fold(Order::aim(0, Vec3::ONE), |o, _| o.and(0, 1.0));
        assert!(say(five).contains("number of behaviours"));
        assert!(Order::aim(0, Vec3::ONE).and(0, 0.5).check(who, &motion_set).is_ok());
    }
}
