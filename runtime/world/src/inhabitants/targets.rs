//! Targets of goals: places that exist and are free.

use super::reservations::{EXTERNAL_HOLDER, follow_nobody};
use super::{InhabitantActivity, InhabitantEvent, InhabitantGoal, Inhabitants};
use crate::{WorldGraph, WorldNode, plan::PlanTarget};
use glam::Vec3;
use throng_base::error::{check_index, check_value};
use throng_base::{Error, Id, Result};

impl Inhabitants {
    /// Target of a goal; none for roaming.
    ///
    /// # Errors
    /// As [`throng_core::CharacterGroup::order`] of inhabitants.
    pub(super) fn target_of(&mut self, id: Id, c: usize, goal: InhabitantGoal) -> Result<Option<PlanTarget>> {
        let (world, who) = (self.world.clone(), Some(id));
        let graph = world.graph();
        let target = match goal {
            InhabitantGoal::Roam => return Ok(None),
            InhabitantGoal::Meet { tag, .. } => {
                check_value("goal", who, tag, false, "not to meet somebody: tell two with `Inhabitants::meet`")?;
                return Ok(None);
            }
            InhabitantGoal::GoTo { instance } => {
                check_index("instance", who, instance as usize, graph.num_instances())?;
                let has_place = graph.rest_cells(instance).next().is_some();
                check_value("instance", who, instance, has_place, "one in which one can stay")?;
                PlanTarget::Rest { instance }
            }
            InhabitantGoal::GoToPlace { place } => {
                check_place(graph, who, place.node)?;
                PlanTarget::Node(place.node)
            }
            InhabitantGoal::GoNear { place, within_m } => {
                let nearest = world.nearest_place(place, within_m).map_err(|e| match e {
                    Error::Value { what, got, expected, .. } => Error::Value { what, who, got, expected },
                    e => e,
                })?;
                let instance = self.free_near(graph, c, place, within_m, None).unwrap_or(nearest.node.instance);
                PlanTarget::Rest { instance }
            }
            InhabitantGoal::Perform { tag, seconds } => {
                check_value("seconds", who, seconds, (0.0..1e9).contains(&seconds), "not negative and below 1e9 (s)")?;
                let offer = self.nearest_offer(graph, c, tag);
                let expected = "one of motion that begins where one can come to and stay";
                check_value("tag", who, tag, offer.is_some(), expected)?;
                // Another instance may offer it where no path leads to this one.
                return Ok(offer.map(|instance| PlanTarget::Tag { instance, tag }));
            }
        };
        let from = self.end_node(c);
        // For a goal that names a place, reachability is checked at once.
        let leads = match goal {
            InhabitantGoal::GoToPlace { .. } | InhabitantGoal::GoNear { .. } => {
                self.planner.plan_soon(graph, from, target, &mut []).is_some()
            }
            _ => self.planner.least_frames(graph, from, target).is_some(),
        };
        if !target.is_at(graph, from) && !leads {
            let [from, to] = [graph.place(from).translation(), self.place_of(target)];
            return Err(Error::NoPath { who, from, to });
        }
        Ok(Some(target))
    }

    /// Replaces the target of a character, whose path is forgotten.
    pub(super) fn set_target(&mut self, graph: &WorldGraph, c: usize, target: Option<PlanTarget>) {
        self.count_bound(graph, c, u32::wrapping_sub);
        self.paths.set_target(c, target);
        self.count_bound(graph, c, u32::wrapping_add);
    }

    /// Counts a character at the units of its target, or no longer.
    pub(super) fn count_bound(&mut self, graph: &WorldGraph, c: usize, count: fn(u32, u32) -> u32) {
        let units = self.paths.target(c).map_or(&[][..], |t| graph.resources(t.instance()));
        units.iter().for_each(|&u| self.num_bound[u as usize] = count(self.num_bound[u as usize], 1));
    }

    /// Number of other characters whose target needs a unit of an instance.
    pub(super) fn num_bound_for(&self, graph: &WorldGraph, c: usize, instance: u32) -> u32 {
        let own = self.paths.target(c).map_or(&[][..], |t| graph.resources(t.instance()));
        let num = |u: &u32| self.num_bound[*u as usize] - u32::from(own.contains(u));
        graph.resources(instance).iter().map(num).max().unwrap_or(0)
    }

    /// Node that all that a character is sure to do leads to.
    pub(super) fn end_node(&self, c: usize) -> WorldNode {
        self.chains.steps_of(c).last().map_or(self.states[c].at, |s| s.to)
    }

    /// About where a target is (m).
    pub(super) fn place_of(&self, target: PlanTarget) -> Vec3 {
        let graph = self.world.graph();
        match target {
            PlanTarget::Node(node) => graph.place(node).translation(),
            PlanTarget::Rest { instance } | PlanTarget::Tag { instance, .. } => graph.centre(instance),
        }
    }

    /// The instance of the free place to stay that is nearest to a point and no other character's target.
    ///
    /// - `but`: not that one.
    fn free_near(&self, graph: &WorldGraph, c: usize, point: Vec3, within_m: f32, but: Option<u32>) -> Option<u32> {
        let has_room = |i| self.num_bound_for(graph, c, i) == 0 && self.reservations.are_free(graph, i, c as u32);
        let node = graph.nearest_rest_of(point, |i| but != Some(i) && has_room(i))?;
        (graph.place(node).translation().distance(point) <= within_m).then_some(node.instance)
    }

    /// Character that stays where another one is to go and stay.
    pub(super) fn occupant_of(&self, graph: &WorldGraph, c: usize) -> Option<usize> {
        let target = self.paths.target(c).filter(|t| !matches!(t, PlanTarget::Tag { .. }))?;
        let other = self.reservations.other_holder(graph, target.instance(), c as u32, follow_nobody)?;
        (other != EXTERNAL_HOLDER && self.has_come_to_stay(other as usize)).then_some(other as usize)
    }

    /// True for a character that has come to stay. One that arrived in this step may get another goal before the next
    /// one.
    pub(super) fn has_come_to_stay(&self, c: usize) -> bool {
        let came = (self.roster.ids()[c], InhabitantEvent::Fulfilled);
        self.states[c].activity == InhabitantActivity::Meeting
            || self.states[c].activity == InhabitantActivity::Arrived && !self.events.contains(&came)
    }

    /// Sends a character to another free place near its target; false where there is none.
    pub(super) fn turn_to_free(&mut self, graph: &WorldGraph, c: usize) -> bool {
        let InhabitantGoal::GoNear { place, within_m } = self.states[c].goal else { return false };
        let now = self.paths.target(c).map(|t| t.instance());
        let Some(instance) = self.free_near(graph, c, place, within_m, now) else { return false };
        self.set_target(graph, c, Some(PlanTarget::Rest { instance }));
        true
    }

    /// Lets a character stay where it is, if that is near enough to its target; false where it is not.
    pub(super) fn set_nearest_target(&mut self, graph: &WorldGraph, c: usize) -> bool {
        let (InhabitantGoal::GoNear { place, within_m }, here) = (self.states[c].goal, self.states[c].at.instance)
        else {
            return false;
        };
        let is_near = |node: WorldNode| graph.place(node).translation().distance(place) <= within_m;
        let is_enough = graph.rest_cells(here).any(is_near);
        if is_enough {
            self.set_target(graph, c, Some(PlanTarget::Rest { instance: here }));
        }
        is_enough
    }
}

/// Checks that a character can stay at a node.
pub(super) fn check_place(graph: &WorldGraph, who: Option<Id>, node: WorldNode) -> Result<()> {
    check_index("instance", who, node.instance as usize, graph.num_instances())?;
    check_index("cell", who, node.cell as usize, graph.num_cells(node.instance) as usize)?;
    check_value("cell", who, node.cell, graph.is_rest(node), "one where one can stay, see `World::near` and `scatter`")
}
