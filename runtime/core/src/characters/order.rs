//! Orders of one character: behaviours, their weights, and the target they are about.

use super::{control::MAX_GOALS, manner::MannerName, motion_set::MotionSet};
use crate::{body::BodyLayers, bundle::Bundle, planar::wrap_angle, policy::PolicyTable};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::error::{check_index, check_value, ensure};
use throng_base::{Error, Id, Result};

/// Time ahead of a moving target for which characters make, and longest time from one order to the next within which a target
/// moves (s).
const AHEAD_S: f32 = 0.5;
const MOVES_S: f32 = 0.5;
/// Speed from which a target is elsewhere (m/s).
const FASTEST_MPS: f32 = 12.0;

/// A policy of a bundle, to make orders of.
#[derive(Clone, Debug)]
pub struct BundlePolicy {
    number: usize,
    table: PolicyTable,
}

impl Bundle {
    /// The policy of a behaviour.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the names there are.
    pub fn policy(&self, behaviour: &str) -> Result<BundlePolicy> {
        let number = self.find_policy(behaviour)?;
        Ok(BundlePolicy { number, table: self.policies()[number].clone() })
    }
}

impl BundlePolicy {
    /// An order to follow it.
    ///
    /// - `target`: in the world; for a space-time grid with the time left as y (m, s).
    pub fn order_towards(&self, target: Vec3) -> PolicyOrder {
        PolicyOrder::towards(self.number, target)
    }

    /// Number of the policy in the bundle.
    pub fn number(&self) -> usize {
        self.number
    }

    /// Values and actions of the policy, for queries without characters.
    pub fn table(&self) -> &PolicyTable {
        &self.table
    }
}

/// What a character does that follows no behaviour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) enum StandOrder {
    /// The first action of each state.
    #[default]
    Follow,
    /// Comes to a stand, and idles there.
    Stop,
    /// Comes to a stand, and turns to a heading (rad).
    Turn(f32),
}

/// Weighted behaviours around one target, or a stand; stays until it is changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PolicyOrder {
    policies: [u32; MAX_GOALS],
    weights: [f32; MAX_GOALS],
    num_goals: u32,
    target: Vec3,
    /// Target of policies on space-time grids.
    threat: Vec3,
    /// Velocity of the target (m/s).
    velocity: Vec3,
    /// Time since it was ordered (s).
    pub(super) age_s: f32,
    pub(super) layers: BodyLayers,
    /// Counts where there are no behaviours.
    pub(super) stands: StandOrder,
    pub(super) manner: MannerName,
    /// Speed on the way (m/s), 0 for that of the policies; none stays as it was.
    pub(super) speed_mps: Option<f32>,
}

impl PolicyOrder {
    /// Nothing to do: the first action of each state is taken.
    pub const IDLE: Self = Self {
        policies: [0; MAX_GOALS],
        weights: [0.0; MAX_GOALS],
        num_goals: 0,
        target: Vec3::ZERO,
        threat: Vec3::ZERO,
        velocity: Vec3::ZERO,
        age_s: 0.0,
        layers: BodyLayers::NONE,
        stands: StandOrder::Follow,
        manner: MannerName::NONE,
        speed_mps: None,
    };

    /// An order to stop as soon as the motion allows, and to stand at ease there.
    pub const STOP: Self = Self { stands: StandOrder::Stop, ..Self::IDLE };

    /// An order to stop, and to turn to a heading on the spot.
    ///
    /// - `heading`: about +Y from +Z (rad).
    pub fn turn_to(heading: f32) -> Self {
        Self { stands: StandOrder::Turn(heading), ..Self::IDLE }
    }

    /// Order of one behaviour.
    ///
    /// - `policy`: its number, see [`crate::Bundle::find_policy`].
    /// - `target`: in the world; for a space-time grid with the time left as y (m, s).
    pub fn towards(policy: usize, target: Vec3) -> Self {
        Self::IDLE.with_target(target).with_policy(policy, 1.0)
    }

    /// Adds a behaviour around the same target. Where there are more than [`super::MAX_GOALS`], the order is refused.
    ///
    /// - `weight`: what its values count in the sum; it is switched off where the target is outside its region.
    pub fn with_policy(mut self, policy: usize, weight: f32) -> Self {
        if let Some(slot) = self.policies.get_mut(self.num_goals as usize) {
            *slot = u32::try_from(policy).unwrap_or(u32::MAX);
            self.weights[self.num_goals as usize] = weight;
        }
        self.num_goals = self.num_goals.saturating_add(1);
        self
    }

    /// True where the character is to stand, whatever its policies say.
    pub(super) fn is_to_stand(&self) -> bool {
        self.num_goals == 0 && self.stands != StandOrder::Follow
    }

    /// Turn that is left to a heading that it orders (rad).
    pub(super) fn turn_left(&self, from: f32) -> f32 {
        if let StandOrder::Turn(heading) = self.stands { wrap_angle(heading - from) } else { 0.0 }
    }

    /// Replaces the target of all behaviours (m).
    pub fn with_target(self, target: Vec3) -> Self {
        Self { target, threat: target, ..self }
    }

    /// Gives behaviours on space-time grids a target of their own.
    ///
    /// - `threat`: x and z of the place, y the seconds left (m, s, m).
    pub fn with_threat(self, threat: Vec3) -> Self {
        Self { threat, ..self }
    }

    /// Orders a manner of motion, such as `sad`; `normal` is that which nothing sets apart. It stays with later orders that name
    /// none; who was never ordered to one keeps that of the motion it is in.
    pub fn in_manner(self, name: &str) -> Self {
        Self { manner: MannerName::new(name), ..self }
    }

    /// Orders a speed on the way (m/s), 0 for that which the policies prefer: of walking and running, people take that whose usual
    /// speed in the motion is nearest to it, and slow down before they arrive. It stays with later orders that name none, and counts where one
    /// behaviour leads to a place.
    pub fn at_speed(self, speed_mps: f32) -> Self {
        Self { speed_mps: Some(speed_mps), ..self }
    }

    /// The speed that is ordered (m/s), see [`PolicyOrder::at_speed`].
    pub fn speed_mps(&self) -> Option<f32> {
        self.speed_mps
    }

    /// Replaces what the body does beside its motion.
    pub fn with_layers(self, layers: BodyLayers) -> Self {
        Self { layers, ..self }
    }

    /// Layers of the body over its motion.
    pub fn layers(&self) -> BodyLayers {
        self.layers
    }

    /// Replaces the weights of the behaviours (policies().len()).
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn with_weights(mut self, weights: &[f32]) -> Result<Self> {
        let (got, n) = (weights.len(), self.policies().len());
        let expected = || format!("{n}, one for each behaviour");
        ensure(got == n, || Error::Length { what: "weights", got, expected: expected() })?;
        self.weights[..n].copy_from_slice(weights);
        Ok(self)
    }

    /// Target of one of its policies (m).
    pub(super) fn target_of(&self, policy: &PolicyTable) -> Vec3 {
        if policy.grid().is_space_time() { self.threat } else { self.target }
    }

    /// Place for which one of its policies makes: ahead of a target that moves (m).
    pub(super) fn aim_of(&self, policy: &PolicyTable) -> Vec3 {
        match self.num_goals == 1 && policy.grid().is_polar() && self.age_s <= MOVES_S {
            true => self.target + self.velocity * AHEAD_S,
            false => self.target_of(policy),
        }
    }

    /// Takes the velocity of a target from where it was before, and the manner where it names none.
    pub(super) fn follow(&mut self, old: &Self) {
        if self.manner == MannerName::NONE {
            self.manner = old.manner;
        }
        self.speed_mps = self.speed_mps.or(old.speed_mps);
        let since = old.age_s;
        (self.velocity, self.age_s) = (Vec3::ZERO, 0.0);
        if self.policies() != old.policies() || since > MOVES_S {
            return;
        }
        // Two orders within a step are one.
        let velocity = if since > 0.0 { (self.target - old.target).with_y(0.0) / since } else { old.velocity };
        if velocity.length_squared() < FASTEST_MPS * FASTEST_MPS {
            self.velocity = old.velocity + (velocity - old.velocity) * (since / MOVES_S);
        }
    }

    /// Lets time pass.
    pub(super) fn age(&mut self, dt_s: f32) {
        self.age_s = (self.age_s + dt_s).min(2.0 * MOVES_S);
    }

    /// The target (m).
    pub fn target(&self) -> Vec3 {
        self.target
    }

    /// Numbers of the policies.
    pub fn policies(&self) -> &[u32] {
        &self.policies[..(self.num_goals as usize).min(MAX_GOALS)]
    }

    /// Weight of each policy (policies().len()).
    pub fn weights(&self) -> &[f32] {
        &self.weights[..self.policies().len()]
    }

    /// Replaces the numbers of the policies.
    pub(crate) fn with_policy_numbers(mut self, number: impl Fn(u32) -> Result<u32>) -> Result<Self> {
        for policy in self.policies.iter_mut().take(self.num_goals as usize) {
            *policy = number(*policy)?;
        }
        Ok(self)
    }

    /// Checks it against a motion set.
    ///
    /// # Errors
    /// [`Error::Index`] for a policy that does not exist, [`Error::Value`] for a number out of its range, [`Error::Unknown`] for a
    /// manner in which no motion goes on.
    pub fn check(&self, who: Option<Id>, motion_set: &MotionSet) -> Result<()> {
        let n = self.num_goals as usize;
        check_value("the number of behaviours", who, n as f64, n <= MAX_GOALS, "0 to 4")?;
        for (&policy, &weight) in self.policies().iter().zip(self.weights()) {
            check_index("policy", who, policy as usize, motion_set.num_policies())?;
            check_value("weight", who, weight, weight.abs() < 1e6, "a finite number below 1e6")?;
        }
        if let StandOrder::Turn(heading) = self.stands {
            check_value("heading", who, heading, heading.abs() < 1e6, "a finite number below 1e6 (rad)")?;
        }
        let wanted = self.speed_mps.unwrap_or(0.0);
        check_value("speed_mps", who, wanted, (0.0..100.0).contains(&wanted), "0 to 100 (m/s)")?;
        let speed = if self.velocity.is_nan() { f32::NAN } else { self.velocity.abs().max_element() };
        check_value("speed of the target", who, speed, speed <= FASTEST_MPS, "at most 12 (m/s)")?;
        let is_recent = (0.0..=2.0 * MOVES_S).contains(&self.age_s);
        check_value("age of the target", who, self.age_s, is_recent, "0 to 1 (s)")?;
        self.layers.check(who, motion_set.num_frames())?;
        motion_set.manners.check(self.manner)?;
        self.check_target(who)
    }

    /// Checks the targets alone.
    pub(super) fn check_target(&self, who: Option<Id>) -> Result<()> {
        let (Vec3 { x, y, z }, threat) = (self.target, self.threat);
        let largest = if threat.is_nan() { f32::NAN } else { threat.abs().max_element() };
        for (what, got) in [("target x", x), ("target y", y), ("target z", z), ("threat", largest)] {
            check_value(what, who, got, got.abs() < 1e6, "a finite number below 1e6 (m)")?;
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
        let say = |order: PolicyOrder| order.check(who, &motion_set).unwrap_err().to_string();
        let message = say(PolicyOrder::towards(0, Vec3::new(1.0, 2.0, f32::NAN)));
        assert!(message.contains('3') && message.contains("target z") && message.contains("NaN"), "{message}");
        assert!(say(PolicyOrder::towards(1, Vec3::ONE)).contains("policy 1"));
        assert!(say(PolicyOrder::towards(0, Vec3::ONE).with_policy(0, f32::INFINITY)).contains("weight"));
        let five = (0..4).fold(PolicyOrder::towards(0, Vec3::ONE), |o, _| o.with_policy(0, 1.0));
        assert!(say(five).contains("number of behaviours"));
        let good = PolicyOrder::towards(0, Vec3::ONE).with_policy(0, 0.5);
        assert!(good.check(who, &motion_set).is_ok());
        // Only damaged snapshots hold these.
        for velocity in [Vec3::NAN, Vec3::X * 1e30] {
            assert!(say(PolicyOrder { velocity, ..good }).contains("speed of the target"));
        }
        assert!(say(PolicyOrder { age_s: -1.0, ..good }).contains("age of the target"));
    }

    #[test]
    fn characters_make_for_where_a_moving_target_will_be() {
        let motion_set = MotionSet::new(&super::super::made_up::tables());
        let policy = motion_set.policy(0).unwrap();
        let (mut order, dt) = (PolicyOrder::towards(0, Vec3::ZERO), 1.0 / 60.0);
        let mut tell = |x: f32, times: usize| {
            for _ in 0..times {
                order.age(dt);
                let mut new = PolicyOrder::towards(0, Vec3::new(order.target.x + x * dt, 0.0, 0.0));
                new.follow(&order);
                order = new;
            }
            order.aim_of(policy).x - order.target.x
        };
        assert!((tell(0.5, 180) - 0.5 * AHEAD_S).abs() < 0.01, "half a metre a second");
        assert!(tell(100.0, 1).abs() < 0.01, "a target that is elsewhere");
        assert!((tell(0.5, 180) - 0.5 * AHEAD_S).abs() < 0.01 && tell(0.0, 180).abs() < 0.01, "one that stays");
        tell(0.5, 180);
        order.age(1.0);
        assert_eq!(order.aim_of(policy), order.target, "of which nothing is heard");
    }
}
