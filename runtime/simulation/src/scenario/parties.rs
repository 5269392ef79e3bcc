//! Parties: companions in the same state decide once, and go on together.

use super::agent_brain::{EventContext, Occasion};
use super::agent_brains::{AgentBrains, Stimulus};
use super::stage::ScenarioStage;
use super::tables::{EdgeTable, trigger};
use super::turns::TurnKind;
use glam::Vec3;
use throng_base::Result;

/// Distance from a place for one within which an agent is in the way of others (m).
const AT_SLOT_M: f32 = 1.0;
/// Steps away from it, x and z (m), of which that with the most room is taken; and their clearance from walls (m).
const ASIDE: [[f32; 2]; 8] =
    [[2.5, 0.0], [1.8, 1.8], [0.0, 2.5], [-1.8, 1.8], [-2.5, 0.0], [-1.8, -1.8], [0.0, -2.5], [1.8, -1.8]];
const CLEARANCE_M: f32 = 0.4;

impl AgentBrains {
    /// True where companions of an agent are in the same state of a level, and have not come to its end.
    pub(super) fn waits_for_party(
        &self,
        stage: &impl ScenarioStage,
        agent: u32,
        level: usize,
        edges: [u32; 2],
    ) -> bool {
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

    /// Lets all companions in the state that an agent has left take the same edge.
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
            let brain = &mut self.brains[other as usize];
            if other == agent || !brain.is_there || brain.states[level] != left {
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
