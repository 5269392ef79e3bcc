//! Taking things and putting them down: who has a claim on a thing, and where one stands to reach it.

use super::mind::{Context, Phase};
use super::minds::Minds;
use super::stage::{Handling, NoStance, SIDES, Stage};
use super::tables::{Action, Claims, NONE, trigger};
use super::verbs::Said;
use glam::Vec3;
use throng_base::Result;

/// Most things that one has in hand.
const HANDS: usize = 2;
/// Longest that one stands to take a thing or to put it down, unless it is said, and how often one looks whether it is done (s).
const MOST_S: f64 = 8.0;
const LOOK_S: f64 = 0.2;

impl Minds {
    /// True where an agent has a thing in hand, or is about to take it (thing < number of things).
    pub fn keeps(&self, agent: usize, thing: usize) -> bool {
        self.keepers[thing] == agent as u32
    }

    /// Goes to where a thing is in reach, or to where it is put down. Nobody else takes it meanwhile. True
    /// where it is over at once.
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

    /// One does not reach a thing, or where it is to be put.
    fn miss(&mut self, stage: &mut impl Stage, agent: u32) {
        stage.missed();
        self.push(agent, trigger::STUCK, Context::default());
    }

    /// One stands where a thing is in reach: hands do the rest.
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

    /// Who does not get to a thing, or to where it is put down, does what comes next.
    pub(super) fn give_up(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        let mind = self.minds[agent as usize];
        let is_on_its_way = mind.action != NONE && mind.phase == Phase::Walking;
        match is_on_its_way.then(|| self.action(mind.action)) {
            Some(Action::Primitive { claims: Claims::Take(_) | Claims::Put(_), .. }) => self.next_action(stage, agent),
            _ => Ok(()),
        }
    }

    /// What an agent does with a thing is over, done or not: it has it in hand, or no claim on it.
    ///
    /// - `is_done`: its time or its motion is over; else something came between.
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

    /// Who leaves lets go of all things.
    pub(super) fn let_go(&mut self, stage: &mut impl Stage, agent: u32) {
        for thing in 0..self.keepers.len() {
            if self.keepers[thing] == agent {
                stage.let_go(thing as u16);
                self.keepers[thing] = NONE;
            }
        }
    }
}
