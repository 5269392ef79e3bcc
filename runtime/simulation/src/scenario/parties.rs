//! Parties: companions in the same state decide once, and go on together.

use super::agent_brain::{EventContext, Occasion};
use super::agent_brains::{AgentBrains, Stimulus};
use super::stage::ScenarioStage;
use super::tables::{EdgeTable, trigger};
use super::turns::TurnKind;
use throng_base::Result;

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
