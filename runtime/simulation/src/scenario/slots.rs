//! Slots of places: agents claim them, move up in queues, and go on where one becomes free.

use super::action_commands::{JOIN_M, SLOT_M};
use super::tables::{ActionClaim, CompiledAction, NONE};
use super::{agent_brain::ActionPhase, agent_brains::AgentBrains, stage::ScenarioStage};
use glam::Vec3;
use throng_base::Result;

/// Distance from its slot in a queue within which an agent stands in line (m).
pub(super) const IN_LINE_M: f32 = 0.6;

impl AgentBrains {
    /// True for an agent that stands in the line of its slot, or moves up in it.
    pub(super) fn is_in_line(&self, agent: u32) -> bool {
        self.brains.get(agent as usize).is_some_and(|brain| brain.is_there && brain.slot != NONE && brain.aim == NONE)
    }

    /// Lets an agent that comes into a line pass those that have slots before it and are not in line yet, and walk to its slot. Nobody
    /// else passes them.
    pub(super) fn join_before_absent(&mut self, stage: &mut impl ScenarioStage, agent: u32, place: u16) -> Result<()> {
        let table = &self.scenario.places[usize::from(place)];
        let (first, own) = (table.slots[0], self.brains[agent as usize].slot);
        let is_absent = |slot: &u32| !self.is_in_line(self.holders[*slot as usize]);
        let passed = (first..own).rev().take_while(is_absent).count() as u32;
        self.holders[(own - passed) as usize..=own as usize].rotate_right(1);
        for slot in own - passed..=own {
            let holder = self.holders[slot as usize];
            let brain = &mut self.brains[holder as usize];
            (brain.slot, brain.aim, brain.phase) = (slot, NONE, ActionPhase::Walking);
            self.mark_touched(holder);
            stage.order_walk(holder, self.scenario.slots[slot as usize].at, SLOT_M, false)?;
        }
        Ok(())
    }

    /// Free end of the queue of a place, where an agent that holds no slot there is still far from it.
    pub(super) fn queue_end(&self, stage: &impl ScenarioStage, agent: u32, place: u16) -> Option<u32> {
        let held = self.scenario.slots.get(self.brains[agent as usize].slot as usize);
        if !self.scenario.places[usize::from(place)].is_queue || held.is_some_and(|slot| slot.place == place) {
            return None;
        }
        let end = self.free_slot(place, None)?;
        let far = stage.position(agent)?.distance(self.scenario.slots[end as usize].at);
        (far > JOIN_M).then_some(end)
    }

    /// Free slot of a place that is nearest to a position; in a queue, the slot behind the last agent that waits.
    pub(super) fn free_slot(&self, place: u16, near: Option<Vec3>) -> Option<u32> {
        let table = &self.scenario.places[usize::from(place)];
        let [first, last] = table.slots;
        let is_free = |slot: &u32| self.holders[*slot as usize] == NONE;
        if table.is_queue {
            let behind = (first..last).rev().find(|s| !is_free(s)).map_or(first, |s| s + 1);
            return (behind < last).then_some(behind);
        }
        let near = near.unwrap_or(table.at);
        let far = |slot: &u32| self.scenario.slots[*slot as usize].at.distance_squared(near);
        (first..last).filter(is_free).min_by(|a, b| far(a).total_cmp(&far(b)))
    }

    /// Claims a slot of a place for an agent, and releases any other; keeps a slot that the agent has there.
    pub(super) fn claim_slot(&mut self, stage: &mut impl ScenarioStage, agent: u32, place: u16) -> Result<Option<u32>> {
        let held = self.brains[agent as usize].slot;
        if held != NONE && self.scenario.slots[held as usize].place == place {
            return Ok(Some(held));
        }
        let Some(slot) = self.free_slot(place, stage.position(agent)) else { return Ok(None) };
        self.take_slot(stage, agent, slot)?;
        Ok(Some(slot))
    }

    /// Lets an agent hold a free slot, and no other.
    pub(super) fn take_slot(&mut self, stage: &mut impl ScenarioStage, agent: u32, slot: u32) -> Result<()> {
        self.holders[slot as usize] = agent;
        self.release_slot(stage, agent)?;
        self.brains[agent as usize].slot = slot;
        Ok(())
    }

    /// Releases the slot of an agent: agents behind it in a queue move up, and one that waits for the slot goes on.
    pub(super) fn release_slot(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        let slot = std::mem::replace(&mut self.brains[agent as usize].slot, NONE);
        if slot == NONE {
            return Ok(());
        }
        self.brains[agent as usize].aim = NONE;
        self.holders[slot as usize] = NONE;
        let place = self.scenario.slots[slot as usize].place;
        let table = &self.scenario.places[usize::from(place)];
        let ([_, last], is_queue) = (table.slots, table.is_queue);
        if is_queue {
            for behind in slot + 1..last {
                let holder = self.holders[behind as usize];
                if holder == NONE {
                    break;
                }
                self.holders[behind as usize - 1] = std::mem::replace(&mut self.holders[behind as usize], NONE);
                self.brains[holder as usize].slot = behind - 1;
                self.mark_touched(holder);
                if matches!(self.brains[holder as usize].phase, ActionPhase::Walking | ActionPhase::Waiting) {
                    self.brains[holder as usize].phase = ActionPhase::Walking;
                    stage.show_activity(holder, None, None);
                    stage.order_walk(holder, self.scenario.slots[behind as usize - 1].at, SLOT_M, false)?;
                }
            }
            return Ok(());
        }
        if let Some(service) = self.scenario.services.iter().position(|service| service.tills == place) {
            self.call_next(stage, service as u16)?;
        }
        // Agents at the heads of queues that lead here.
        for queue in 0..self.scenario.places.len() {
            let table = &self.scenario.places[queue];
            if !table.is_queue || table.slots[0] == table.slots[1] {
                continue;
            }
            let head = self.holders[table.slots[0] as usize];
            if head == NONE || self.brains[head as usize].phase != ActionPhase::Waiting {
                continue;
            }
            if let CompiledAction::Primitive { claims: ActionClaim::Queue(Some(into)), .. } =
                self.action(self.brains[head as usize].action)
                && into == place
            {
                self.mark_touched(head);
                return if self.handle_arrival(stage, head)? { self.next_action(stage, head) } else { Ok(()) };
            }
        }
        Ok(())
    }
}
