//! Taking things and putting them down: claims of agents on things, and stands from which they reach them.

use super::mind::{Context, Phase};
use super::minds::Minds;
use super::stage::{Handling, NoStance, SIDES, Stage};
use super::tables::{Action, Claims, NONE, trigger};
use super::verbs::Said;
use glam::Vec3;
use throng_base::Result;

/// Most things that an agent has in hand.
const HANDS: usize = 2;
/// Longest time of standing to take a thing or to put it down, unless the action gives one, and interval between checks (s).
const MOST_S: f64 = 8.0;
const LOOK_S: f64 = 0.2;

impl Minds {
    /// True where an agent has a thing in hand, or a claim to take it (thing < number of things).
    pub fn keeps(&self, agent: usize, thing: usize) -> bool {
        self.keepers[thing] == agent as u32
    }

    /// Sends an agent to a stand from which it reaches a thing, or the place for it, and claims the thing. Returns true where
    /// the action is over at once.
    pub(super) fn fetch(&mut self, stage: &mut impl Stage, agent: u32, claims: Claims, said: &Said) -> Result<bool> {
        let (Claims::Take(thing) | Claims::Put(thing)) = claims else { return Ok(false) };
        if self.minds[agent as usize].phase == Phase::Standing {
            return match stage.is_over(agent, thing) {
                true => Ok(true),
                false => {
                    self.minds[agent as usize].again = self.now + LOOK_S;
                    Ok(false)
                }
            };
        }
        let (puts, keeper) = (matches!(claims, Claims::Put(_)), self.keepers[usize::from(thing)]);
        let full = self.keepers.iter().filter(|k| **k == agent).count() == HANDS;
        if puts && keeper != agent || !puts && (keeper != NONE && keeper != agent || keeper == NONE && full) {
            self.push(agent, trigger::FULL, Context::default());
            return Ok(true);
        }
        if !puts && keeper == agent && stage.has_in_hand(agent, thing) {
            return Ok(true);
        }
        self.keepers[usize::from(thing)] = agent;
        if let Some(speed) = said.amounts[1] {
            stage.set_speed(agent, speed.clamp(0.0, 100.0) as f32)?;
        }
        let at = self.where_to(stage, thing, puts, said);
        let Action::Primitive { motion, .. } = self.action(self.minds[agent as usize].action) else { return Ok(false) };
        for side in 0..2 * SIDES {
            let handling = Handling { thing, puts, at };
            let (stand, within_m) = match stage.stance(agent, motion, handling, side) {
                Ok(stance) => stance,
                Err(why) => {
                    self.settle(stage, agent, false);
                    match why {
                        NoStance::NoHand => self.push(agent, trigger::FULL, Context::default()),
                        NoStance::OutOfReach => self.miss(stage, agent),
                    }
                    return Ok(true);
                }
            };
            self.minds[agent as usize].phase = Phase::Walking;
            if stage.position(agent).is_some_and(|p| p.distance(stand) <= within_m) {
                return self.arrived(stage, agent);
            }
            if stage.go(agent, stand, within_m, false)? {
                return Ok(false);
            }
        }
        self.settle(stage, agent, false);
        self.miss(stage, agent);
        Ok(true)
    }

    /// Reports that an agent cannot reach a thing, or the place for it.
    fn miss(&mut self, stage: &mut impl Stage, agent: u32) {
        stage.missed();
        self.push(agent, trigger::STUCK, Context::default());
    }

    /// Begins the motion of the hands of an agent that stands in reach of a thing.
    pub(super) fn use_hands(
        &mut self,
        stage: &mut impl Stage,
        agent: u32,
        (claims, motion): (Claims, Option<u16>),
        said: &Said,
    ) -> Result<bool> {
        let (Claims::Take(thing) | Claims::Put(thing)) = claims else { return Ok(false) };
        let puts = matches!(claims, Claims::Put(_));
        let at = self.where_to(stage, thing, puts, said);
        stage.show(agent, motion, None);
        stage.handle(agent, motion, Handling { thing, puts, at });
        self.minds[agent as usize].again = self.now + LOOK_S;
        self.stand_until(agent, said.amount(2, MOST_S))
    }

    fn where_to(&self, stage: &impl Stage, thing: u16, puts: bool, said: &Said) -> Vec3 {
        match puts {
            true => said.targets[4].unwrap_or(self.scenario.things[usize::from(thing)]),
            false => stage.thing_at(thing),
        }
    }

    /// Goes on with the next action of an agent that cannot get to a thing, or to the place for it.
    pub(super) fn give_up(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        let mind = self.minds[agent as usize];
        let is_on_its_way = mind.action != NONE && mind.phase == Phase::Walking;
        match is_on_its_way.then(|| self.action(mind.action)) {
            Some(Action::Primitive { claims: Claims::Take(_) | Claims::Put(_), .. }) => self.next_action(stage, agent),
            _ => Ok(()),
        }
    }

    /// Ends the handling of a thing, complete or not: afterwards the agent has the thing in hand, or no claim on it.
    ///
    /// - `is_done`: the time or the motion is over; else the handling was interrupted.
    pub(super) fn settle(&mut self, stage: &mut impl Stage, agent: u32, is_done: bool) {
        let mind = self.minds[agent as usize];
        if mind.action == NONE || self.keepers.is_empty() {
            return;
        }
        if let Action::Primitive { claims: Claims::Take(thing) | Claims::Put(thing), .. } = self.action(mind.action)
            && self.keepers[usize::from(thing)] == agent
        {
            let was_at_it = is_done && mind.phase == Phase::Standing;
            let is_kept = stage.settle(agent, thing, was_at_it);
            if !is_kept {
                self.keepers[usize::from(thing)] = NONE;
            }
            let takes = matches!(self.action(mind.action), Action::Primitive { claims: Claims::Take(_), .. });
            if was_at_it && is_kept != takes {
                self.miss(stage, agent);
            }
        }
    }

    /// Drops all things of an agent that leaves, and ends its claims.
    pub(super) fn let_go(&mut self, stage: &mut impl Stage, agent: u32) {
        for thing in 0..self.keepers.len() {
            if self.keepers[thing] == agent {
                stage.let_go(thing as u16);
                self.keepers[thing] = NONE;
            }
        }
    }
}
