//! Taking things and putting them down: claims of agents on things, and stands from which they reach them.

use super::agent_brain::{ActionPhase, EventContext};
use super::stage::{Handling, SIDES, ScenarioStage, StanceError};
use super::tables::{ActionClaim, CompiledAction, NONE, trigger};
use super::{action_registry::ActionArguments, agent_brains::AgentBrains};
use glam::Vec3;
use throng_base::Result;

/// Most things that an agent has in hand.
const HANDS: usize = 2;
/// Longest time of standing to take a thing or to put it down, unless the action gives one, and interval between checks (s).
const MOST_S: f64 = 8.0;
const POLL_S: f64 = 0.2;

impl AgentBrains {
    /// True where an agent has a thing in hand, or a claim to take it (thing < number of things).
    #[cfg(test)]
    pub fn has_claimed(&self, agent: usize, thing: usize) -> bool {
        self.keepers[thing] == agent as u32
    }

    /// Sends an agent to a stand from which it reaches a thing, or the place for it, and claims the thing. Returns true where
    /// the action is over at once.
    pub(super) fn fetch_thing(
        &mut self,
        stage: &mut impl ScenarioStage,
        agent: u32,
        claims: ActionClaim,
        said: &ActionArguments,
    ) -> Result<bool> {
        let (ActionClaim::Take(thing) | ActionClaim::Put(thing)) = claims else { return Ok(false) };
        if self.brains[agent as usize].phase == ActionPhase::Standing {
            let is_over = stage.is_handling_over(agent, thing);
            if !is_over {
                self.brains[agent as usize].acts_again_at_s = self.now + POLL_S;
            }
            return Ok(is_over);
        }
        let (puts, keeper) = (matches!(claims, ActionClaim::Put(_)), self.keepers[usize::from(thing)]);
        let full = self.keepers.iter().filter(|k| **k == agent).count() == HANDS;
        if puts && keeper != agent || !puts && (keeper != NONE && keeper != agent || keeper == NONE && full) {
            self.push_stimulus(agent, trigger::FULL, EventContext::default());
            return Ok(true);
        }
        if !puts && keeper == agent && stage.has_in_hand(agent, thing) {
            return Ok(true);
        }
        self.keepers[usize::from(thing)] = agent;
        if let Some(speed) = said.amounts[1] {
            stage.set_speed(agent, speed.clamp(0.0, 100.0) as f32)?;
        }
        let at = self.handling_position(stage, thing, puts, said);
        let CompiledAction::Primitive { motion, .. } = self.action(self.brains[agent as usize].action) else {
            return Ok(false);
        };
        for side in 0..2 * SIDES {
            let handling = Handling { thing, puts, at };
            let (stand, within_m) = match stage.stance(agent, motion, handling, side) {
                Ok(stance) => stance,
                Err(why) => {
                    self.end_handling(stage, agent, false);
                    match why {
                        StanceError::NoHand => self.push_stimulus(agent, trigger::FULL, EventContext::default()),
                        StanceError::OutOfReach => self.report_miss(stage, agent),
                    }
                    return Ok(true);
                }
            };
            self.brains[agent as usize].phase = ActionPhase::Walking;
            if stage.position(agent).is_some_and(|p| p.distance(stand) <= within_m) {
                return self.handle_arrival(stage, agent);
            }
            if stage.order_walk(agent, stand, within_m, false)? {
                return Ok(false);
            }
        }
        self.end_handling(stage, agent, false);
        self.report_miss(stage, agent);
        Ok(true)
    }

    /// Reports that an agent cannot reach a thing, or the place for it.
    fn report_miss(&mut self, stage: &mut impl ScenarioStage, agent: u32) {
        stage.count_miss();
        self.push_stimulus(agent, trigger::STUCK, EventContext::default());
    }

    /// Begins the motion of the hands of an agent that stands in reach of a thing.
    pub(super) fn use_hands(
        &mut self,
        stage: &mut impl ScenarioStage,
        agent: u32,
        claims: ActionClaim,
        motion: Option<u16>,
        said: &ActionArguments,
    ) -> Result<bool> {
        let (ActionClaim::Take(thing) | ActionClaim::Put(thing)) = claims else { return Ok(false) };
        let puts = matches!(claims, ActionClaim::Put(_));
        let at = self.handling_position(stage, thing, puts, said);
        stage.show_activity(agent, motion, None);
        stage.begin_handling(agent, motion, Handling { thing, puts, at });
        self.brains[agent as usize].acts_again_at_s = self.now + POLL_S;
        self.stand_until(agent, said.amount(2, MOST_S))
    }

    fn handling_position(&self, stage: &impl ScenarioStage, thing: u16, puts: bool, said: &ActionArguments) -> Vec3 {
        match puts {
            true => said.targets[4].unwrap_or(self.scenario.things[usize::from(thing)]),
            false => stage.thing_position(thing),
        }
    }

    /// Goes on with the next action of an agent that cannot get to a thing, or to the place for it.
    pub(super) fn give_up_fetching(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        let brain = self.brains[agent as usize];
        let is_on_its_way = brain.action != NONE && brain.phase == ActionPhase::Walking;
        match is_on_its_way.then(|| self.action(brain.action)) {
            Some(CompiledAction::Primitive { claims: ActionClaim::Take(_) | ActionClaim::Put(_), .. }) => {
                self.next_action(stage, agent)
            }
            _ => Ok(()),
        }
    }

    /// Ends the handling of a thing, complete or not: afterwards the agent has the thing in hand, or no claim on it.
    ///
    /// - `is_done`: the time or the motion is over; else the handling was interrupted.
    pub(super) fn end_handling(&mut self, stage: &mut impl ScenarioStage, agent: u32, is_done: bool) {
        let brain = self.brains[agent as usize];
        if brain.action == NONE || self.keepers.is_empty() {
            return;
        }
        if let CompiledAction::Primitive { claims, .. } = self.action(brain.action)
            && let ActionClaim::Take(thing) | ActionClaim::Put(thing) = claims
            && self.keepers[usize::from(thing)] == agent
        {
            let was_at_it = is_done && brain.phase == ActionPhase::Standing;
            let is_kept = stage.end_handling(agent, thing, was_at_it);
            if !is_kept {
                self.keepers[usize::from(thing)] = NONE;
            }
            if was_at_it && is_kept != matches!(claims, ActionClaim::Take(_)) {
                self.report_miss(stage, agent);
            }
        }
    }

    /// Drops all things of an agent that leaves, and ends its claims.
    pub(super) fn drop_all_things(&mut self, stage: &mut impl ScenarioStage, agent: u32) {
        for thing in 0..self.keepers.len() {
            if self.keepers[thing] == agent {
                stage.drop_thing(thing as u16);
                self.keepers[thing] = NONE;
            }
        }
    }
}
