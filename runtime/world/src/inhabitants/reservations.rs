//! Reservations of units. Every unit has at most one holder, so each holder's units are a list through the units.

use crate::{WorldGraph, WorldStep};
use throng_core::patch::NONE;

/// Holder of units on a region that an external obstacle reserves.
pub(super) const EXTERNAL_HOLDER: u32 = NONE - 1;

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

/// Reservations of all units.
#[derive(Clone, Debug)]
pub(super) struct UnitReservations {
    /// Holder of each unit, or [`NONE`].
    holder: Vec<u32>,
    /// Use of each instance's ground.
    ground: Vec<InstanceGround>,
    /// The unit after each one in its holder's list.
    next: Vec<u32>,
    /// First unit of each character.
    first: Vec<u32>,
    /// Units that are marked carry the stamp.
    marks: Vec<u32>,
    stamp: u32,
}

impl UnitReservations {
    pub fn new(graph: &WorldGraph, num_characters: usize) -> Self {
        Self::with_sizes(graph.world().units.len(), graph.num_instances(), num_characters)
    }

    fn with_sizes(num_units: usize, num_instances: usize, num_characters: usize) -> Self {
        Self {
            holder: vec![NONE; num_units],
            ground: vec![InstanceGround::Free; num_instances],
            next: vec![NONE; num_units],
            first: vec![NONE; num_characters],
            marks: vec![0; num_units],
            stamp: 0,
        }
    }

    /// Holder of a unit.
    pub fn holder_of(&self, unit: u32) -> Option<u32> {
        Some(self.holder[unit as usize]).filter(|&c| c != NONE)
    }

    /// Another holder in an instance: a character with one of its units, or [`EXTERNAL_HOLDER`] on its ground.
    pub fn other_holder(&self, graph: &WorldGraph, instance: u32, character: u32) -> Option<u32> {
        let units = graph.resources(instance);
        self.other_holder_of(units, character).or_else(|| {
            let is_there = || units.iter().all(|&u| self.holder_of(u) == Some(character));
            let may_enter = match self.ground[instance as usize] {
                InstanceGround::Free => true,
                InstanceGround::Barred => false,
                InstanceGround::Shared => is_there(),
            };
            (!may_enter).then_some(EXTERNAL_HOLDER)
        })
    }

    /// Another holder of one of these units.
    pub fn other_holder_of(&self, units: &[u32], character: u32) -> Option<u32> {
        units.iter().filter_map(|&u| self.holder_of(u)).find(|&c| c != character)
    }

    /// Use of each instance's ground.
    pub fn ground_mut(&mut self) -> &mut [InstanceGround] {
        &mut self.ground
    }

    /// Another character that holds a unit which a step needs.
    pub fn holder_for_step(&self, graph: &WorldGraph, step: &WorldStep, character: u32) -> Option<u32> {
        let other = |instance| self.other_holder(graph, instance, character);
        let played = graph.link(step).is_some() && step.instance != step.to.instance;
        other(step.to.instance).or_else(|| if played { other(step.instance) } else { None })
    }

    /// True where a character may be in an instance.
    pub fn are_free(&self, graph: &WorldGraph, instance: u32, character: u32) -> bool {
        self.other_holder(graph, instance, character).is_none()
    }

    /// Assigns units to a character; they are free or its own.
    pub fn take_units(&mut self, units: &[u32], character: u32) {
        for &u in units {
            if self.holder[u as usize] == NONE {
                self.holder[u as usize] = character;
                self.next[u as usize] = self.first[character as usize];
                self.first[character as usize] = u;
            }
        }
    }

    /// Removes all marks.
    pub fn clear_marks(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.marks.fill(0);
            self.stamp = 1;
        }
    }

    /// Marks units.
    pub fn mark_units(&mut self, units: &[u32]) {
        for &u in units {
            self.marks[u as usize] = self.stamp;
        }
    }

    /// True where one of these units is marked.
    pub fn is_any_marked(&self, units: &[u32]) -> bool {
        units.iter().any(|&u| self.marks[u as usize] == self.stamp)
    }

    /// Releases units that a character holds and that are not marked.
    pub fn release_unmarked(&mut self, character: u32) {
        let mut unit = std::mem::replace(&mut self.first[character as usize], NONE);
        while unit != NONE {
            let after = self.next[unit as usize];
            if self.marks[unit as usize] == self.stamp {
                self.next[unit as usize] = self.first[character as usize];
                self.first[character as usize] = unit;
            } else {
                self.holder[unit as usize] = NONE;
            }
            unit = after;
        }
    }

    /// Transfers all reservations of a character to another one, which has none.
    pub fn hand_over(&mut self, from: u32, to: u32) {
        let mut unit = std::mem::replace(&mut self.first[from as usize], NONE);
        self.first[to as usize] = unit;
        while unit != NONE {
            self.holder[unit as usize] = to;
            unit = self.next[unit as usize];
        }
    }

    /// Units that a character holds.
    pub fn units_of(&self, character: u32) -> impl Iterator<Item = u32> + '_ {
        let some = |u: u32| Some(u).filter(|&u| u != NONE);
        std::iter::successors(some(self.first[character as usize]), move |&u| some(self.next[u as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_one_holder_and_are_let_go_unless_kept() {
        let mut h = UnitReservations::with_sizes(6, 6, 2);
        h.take_units(&[0, 2, 4], 0);
        h.take_units(&[1, 5], 1);
        assert_eq!([0, 1].map(|c| h.other_holder_of(&[0, 3], c)), [None, Some(0)]);
        h.take_units(&[0, 3], 0);
        h.clear_marks();
        h.mark_units(&[2, 3, 5]);
        h.release_unmarked(0);
        let mut held: Vec<_> = h.units_of(0).collect();
        held.sort_unstable();
        assert_eq!(held, [2, 3]);
        assert_eq!(
            (0..6).map(|u| h.holder_of(u)).collect::<Vec<_>>(),
            [None, Some(1), Some(0), Some(0), None, Some(1)]
        );
        h.clear_marks();
        h.release_unmarked(0);
        h.hand_over(1, 0);
        assert_eq!((0..6).map(|u| h.holder_of(u)).collect::<Vec<_>>(), [None, Some(0), None, None, None, Some(0)]);
        assert!(h.units_of(1).next().is_none() && h.units_of(0).count() == 2);
    }
}
