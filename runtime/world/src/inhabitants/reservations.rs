//! Reservations of units. A unit has one holder, except in passages and climbs, where others may follow it.

use crate::{WorldGraph, WorldStep};
use throng_core::patch::NONE;

/// Holder of units on a region that an external obstacle reserves.
pub(super) const EXTERNAL_HOLDER: u32 = NONE - 1;
/// Most characters that reserve a unit: its holder and those that follow.
const MOST_HOLDERS: usize = 4;

/// Use of an instance's ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum InstanceGround {
    /// Free for inhabitants.
    Free,
    /// Reserved by an external obstacle.
    Barred,
    /// Reserved by an external obstacle, but needed by a character that holds its units and may go on there.
    Shared,
}

/// True for no other character: units that others reserve are kept out of.
pub(super) fn follow_nobody(_other: u32, _unit: u32) -> bool {
    false
}

/// Reservations of all units.
#[derive(Clone, Debug)]
pub(super) struct UnitReservations {
    /// Holder of each unit and those that follow, in the order in which they reserved it; then [`NONE`].
    queues: Vec<[u32; MOST_HOLDERS]>,
    /// Use of each instance's ground.
    ground: Vec<InstanceGround>,
}

impl UnitReservations {
    pub fn new(graph: &WorldGraph) -> Self {
        Self::with_sizes(graph.world().units.len(), graph.num_instances())
    }

    fn with_sizes(num_units: usize, num_instances: usize) -> Self {
        Self { queues: vec![[NONE; MOST_HOLDERS]; num_units], ground: vec![InstanceGround::Free; num_instances] }
    }

    /// Holder of a unit.
    pub fn holder_of(&self, unit: u32) -> Option<u32> {
        self.queues[unit as usize].first().copied().filter(|&c| c != NONE)
    }

    /// Another character that keeps one out of a unit: one that reserves it, and that it may not follow.
    ///
    /// - `follows`: true where the character may follow another one that reserves the unit.
    fn other_in_unit(&self, unit: u32, character: u32, follows: impl Fn(u32, u32) -> bool) -> Option<u32> {
        let queue = &self.queues[unit as usize];
        let has_room = queue.contains(&character) || queue[MOST_HOLDERS - 1] == NONE;
        queue.iter().copied().find(|&c| c != NONE && c != character && !(has_room && follows(c, unit)))
    }

    /// Another holder in an instance: a character with one of its units, which is not followed (see
    /// `other_in_unit`), or [`EXTERNAL_HOLDER`] on its ground.
    pub fn other_holder(
        &self,
        graph: &WorldGraph,
        instance: u32,
        character: u32,
        follows: impl Fn(u32, u32) -> bool,
    ) -> Option<u32> {
        let units = graph.resources(instance);
        units.iter().find_map(|&u| self.other_in_unit(u, character, &follows)).or_else(|| {
            let is_there = || units.iter().all(|&u| self.queues[u as usize].contains(&character));
            let may_enter = match self.ground[instance as usize] {
                InstanceGround::Free => true,
                InstanceGround::Barred => false,
                InstanceGround::Shared => is_there(),
            };
            (!may_enter).then_some(EXTERNAL_HOLDER)
        })
    }

    /// Use of each instance's ground.
    pub fn ground_mut(&mut self) -> &mut [InstanceGround] {
        &mut self.ground
    }

    /// Another character that holds a unit which a step needs, and is not followed.
    pub fn holder_for_step(
        &self,
        graph: &WorldGraph,
        step: &WorldStep,
        character: u32,
        follows: impl Fn(u32, u32) -> bool,
    ) -> Option<u32> {
        let other = |instance| self.other_holder(graph, instance, character, &follows);
        let played = graph.link(step).is_some() && step.instance != step.to.instance;
        other(step.to.instance).or_else(|| if played { other(step.instance) } else { None })
    }

    /// True where a character may be in an instance.
    pub fn are_free(&self, graph: &WorldGraph, instance: u32, character: u32) -> bool {
        self.other_holder(graph, instance, character, follow_nobody).is_none()
    }

    /// Assigns units to a character, after those that reserve them (there is room).
    pub fn take_units(&mut self, units: &[u32], character: u32) {
        for &u in units {
            self.release_unit(u, character);
            let queue = &mut self.queues[u as usize];
            queue.iter_mut().find(|c| **c == NONE).into_iter().for_each(|slot| *slot = character);
        }
    }

    /// Releases a unit for the one that follows its holder, or removes a character from those that follow.
    pub fn release_unit(&mut self, unit: u32, character: u32) {
        let queue = &mut self.queues[unit as usize];
        if let Some(at) = queue.iter().position(|&c| c == character) {
            queue.copy_within(at + 1.., at);
            queue[MOST_HOLDERS - 1] = NONE;
        }
    }

    /// Removes all reservations of a character.
    pub fn release_all(&mut self, character: u32) {
        (0..self.queues.len() as u32).for_each(|unit| self.release_unit(unit, character));
    }

    /// Transfers the reservations of a character to another one, which has none.
    pub fn hand_over(&mut self, from: u32, to: u32) {
        self.queues.as_flattened_mut().iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
    }

    /// Units that a character holds.
    pub fn units_of(&self, character: u32) -> impl Iterator<Item = u32> + '_ {
        (0..self.queues.len() as u32).filter(move |&u| self.holder_of(u) == Some(character))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_one_holder_until_it_lets_them_go() {
        let mut h = UnitReservations::with_sizes(6, 6);
        h.take_units(&[0, 2, 4], 0);
        h.take_units(&[1, 5], 1);
        assert_eq!([0, 1].map(|c| h.other_in_unit(0, c, |_, _| false)), [None, Some(0)]);
        h.take_units(&[0, 3], 0);
        [0, 4].into_iter().for_each(|u| h.release_unit(u, 0));
        assert_eq!(h.units_of(0).collect::<Vec<_>>(), [2, 3]);
        assert_eq!(
            (0..6).map(|u| h.holder_of(u)).collect::<Vec<_>>(),
            [None, Some(1), Some(0), Some(0), None, Some(1)]
        );
        h.release_all(0);
        h.hand_over(1, 0);
        assert_eq!((0..6).map(|u| h.holder_of(u)).collect::<Vec<_>>(), [None, Some(0), None, None, None, Some(0)]);
        assert!(h.units_of(1).next().is_none() && h.units_of(0).count() == 2);
    }

    #[test]
    fn who_follows_holds_a_unit_once_those_before_have_left() {
        let mut h = UnitReservations::with_sizes(1, 1);
        h.take_units(&[0], 0);
        assert_eq!([true, false].map(|follows| h.other_in_unit(0, 1, |_, _| follows)), [None, Some(0)]);
        h.take_units(&[0], 1);
        // All others are asked, those that follow too.
        assert_eq!(h.other_in_unit(0, 2, |c, _| c == 0), Some(1));
        assert_eq!(h.other_in_unit(0, 0, |_, _| false), Some(1));
        (2..MOST_HOLDERS as u32).for_each(|c| h.take_units(&[0], c));
        assert_eq!([0, 9].map(|c| h.other_in_unit(0, c, |_, _| true)), [None, Some(0)], "there is no room for more");
        h.release_all(1);
        h.release_unit(0, 0);
        assert_eq!(h.holder_of(0), Some(2));
    }
}
