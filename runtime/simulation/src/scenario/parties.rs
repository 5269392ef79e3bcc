//! Parties: companions in the same state decide once, and go on together.

use super::agent_brain::{ActionPhase, EventContext, Occasion};
use super::agent_brains::{AgentBrains, Stimulus};
use super::tables::{EdgeTable, NONE, trigger};
use super::{stage::ScenarioStage, turns::TurnKind};
use glam::Vec3;
use throng_base::Result;

/// Distance from a place for one within which an agent is in the way of others (m).
const AT_SLOT_M: f32 = 1.0;
/// Steps away from it, x and z (m), of which that with the most room is taken; and their clearance from walls (m).
const ASIDE: [[f32; 2]; 8] =
    [[2.5, 0.0], [1.8, 1.8], [0.0, 2.5], [-1.8, 1.8], [-2.5, 0.0], [-1.8, -1.8], [0.0, -2.5], [1.8, -1.8]];
const CLEARANCE_M: f32 = 0.4;
/// Distance from a place at which an agent waits for a slot beside its companions (m), and time between two looks for one (s).
const BESIDE_M: f32 = 2.0;
const BESIDE_S: f64 = 1.0;

impl AgentBrains {
    /// True where companions of an agent are in the same state of a level, and have not come to its end.
    pub fn waits_for_party(&self, stage: &impl ScenarioStage, agent: u32, level: usize, edges: [u32; 2]) -> bool {
        let own = self.brains[agent as usize].states[level];
        let ends = |edge: &EdgeTable| edge.trigger == trigger::DONE && !edge.alone;
        let is_late = |other: u32| {
            let brain = &self.brains[other as usize];
            other != agent && brain.is_there && brain.states[level] == own && !self.engagements[other as usize].is_done
        };
        self.scenario.edges[edges[0] as usize..edges[1] as usize].iter().any(ends)
            && stage.companions(agent).any(is_late)
    }

    /// Lets an agent wait for its companions. Who has been at a till, or at another place for one, steps away from it: others come.
    pub(super) fn wait_for_party(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        self.engagements[agent as usize].is_done = true;
        self.release_slot(stage, agent)?;
        let scenario = self.scenario.clone();
        let room = |at: Vec3| scenario.slots.iter().map(|slot| slot.at.distance(at)).fold(f32::INFINITY, f32::min);
        let Some(at) = stage.position(agent).filter(|at| room(*at) < AT_SLOT_M) else { return Ok(()) };
        let around = ASIDE.map(|[x, z]| at + Vec3::new(x, 0.0, z)).into_iter();
        let seen = around.filter(|to| stage.sees(at, *to, CLEARANCE_M, false));
        if let Some(to) = seen.max_by(|a, b| room(*a).total_cmp(&room(*b))) {
            stage.show_activity(agent, None, None);
            stage.order_walk(agent, to, 1.0, false)?;
        }
        Ok(())
    }

    /// Lets an agent that finds no slot where its companions are, or have been, wait near the place and look again after a while; false
    /// where none are.
    pub(super) fn waits_beside(&mut self, stage: &mut impl ScenarioStage, agent: u32, place: u16) -> Result<bool> {
        let [first, last] = self.scenario.places[usize::from(place)].slots;
        let states = self.brains[agent as usize].states;
        let is_at = |other: u32| {
            let brain = &self.brains[other as usize];
            let had = self.engagements[other as usize].is_done || (first..last).contains(&brain.slot);
            other != agent && brain.is_there && brain.states == states && had
        };
        if !stage.companions(agent).any(is_at) {
            return Ok(false);
        }
        let brain = &mut self.brains[agent as usize];
        let before = std::mem::replace(&mut brain.phase, ActionPhase::Standing);
        (brain.stands_until_s, brain.acts_again_at_s) = (f64::INFINITY, self.now + BESIDE_S);
        if before != ActionPhase::Standing {
            let at = self.scenario.slots[first as usize].at;
            let off = (stage.position(agent).unwrap_or(at) - at).with_y(0.0).try_normalize().unwrap_or(Vec3::X);
            stage.order_walk(agent, at + off * BESIDE_M, 0.5, false)?;
        }
        Ok(true)
    }

    /// Lets all companions in the state that an agent has left take the same edge; who has what another one found taken stays.
    pub(super) fn lead_party(
        &mut self,
        stage: &mut impl ScenarioStage,
        stimulus: Stimulus,
        left: u16,
        kind: TurnKind,
    ) -> Result<()> {
        let agent = stimulus.on.agent;
        let reason = self.brains[agent as usize].reason;
        let to = self.scenario.edges[reason.edge as usize].to;
        let level = usize::from(self.scenario.states[usize::from(left)].level);
        for other in stage.companions(agent) {
            let has_own = self.brains[other as usize].slot != NONE || self.keepers.contains(&other);
            let brain = &mut self.brains[other as usize];
            let is_left_there = has_own && stimulus.trigger == trigger::FULL;
            if other == agent || !brain.is_there || brain.states[level] != left || is_left_there {
                continue;
            }
            brain.reason = reason;
            let own = &mut self.engagements[other as usize];
            (own.led_on, own.led_at) = (stimulus.trigger, self.now);
            let on = Occasion { agent: other, ..stimulus.on };
            self.record_turn(Stimulus { on, ..stimulus }, kind);
            self.mark_touched(other);
            self.enter_state(stage, on, u32::from(to))?;
        }
        Ok(())
    }

    /// Lets companions that wait for an agent decide without it.
    pub(super) fn leave_party(&mut self, stage: &impl ScenarioStage, agent: u32) {
        for other in stage.companions(agent) {
            if other != agent && self.engagements[other as usize].is_done && self.brains[other as usize].is_there {
                self.engagements[other as usize].is_done = false;
                self.push_stimulus(other, trigger::DONE, EventContext::default());
            }
        }
    }
}
