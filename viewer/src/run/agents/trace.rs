//! How agents came to their states: the last edge at each level, and which levels began anew with it.

use throng_simulation::Simulation;
use throng_simulation::scenario::{Turn, TurnKind};

/// The last edges of one agent, the highest level first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentTrace([StateEntry; 3]);

/// Entry of an agent into its state at one level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateEntry {
    /// Time since which the agent is in this state (s); none if it was before the restored state.
    pub since_s: Option<f64>,
    /// The last edge taken at this level, and its time (s); it may have led back to the same state.
    pub edge: Option<(usize, f64)>,
    /// Level whose change made this one begin anew.
    pub began_with: Option<usize>,
}

impl AgentTrace {
    /// Trace of an agent that has been in its states since a time (s).
    fn starting_at(since_s: Option<f64>) -> Self {
        Self([StateEntry { since_s, edge: None, began_with: None }; 3])
    }

    /// Traces of all agents of a scene in its present state; empty if they have no brains.
    pub fn for_all_agents(simulation: &Simulation) -> Vec<Self> {
        let since_s = (simulation.time_s() == 0.0).then_some(0.0);
        vec![Self::starting_at(since_s); simulation.brains().map_or(0, |m| m.len())]
    }

    /// Records an event of the agent's brain.
    pub fn record_turn(&mut self, turn: &Turn) {
        let since_s = Some(turn.time_s);
        match turn.kind {
            TurnKind::Starts => *self = Self::starting_at(since_s),
            TurnKind::Takes { level, edge, changes, .. } => {
                let here = &mut self.0[level];
                here.edge = Some((edge, turn.time_s));
                if changes {
                    (here.since_s, here.began_with) = (since_s, None);
                    self.0[level + 1..].fill(StateEntry { since_s, edge: None, began_with: Some(level) });
                }
            }
            _ => {}
        }
    }

    /// Entry into the state at a level (level < 3).
    pub fn entry_at(&self, level: usize) -> StateEntry {
        self.0[level]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(time_s: f64, kind: TurnKind) -> Turn {
        Turn { time_s, agent: 0, kind, on: 0, other: None, place: None, event: None }
    }

    fn edge(level: usize, edge: usize, changes: bool) -> TurnKind {
        TurnKind::Takes { level, graph: 0, edge, changes }
    }

    #[test]
    fn a_change_begins_what_is_below_anew_and_leaves_what_is_above() {
        let mut trace = AgentTrace::starting_at(Some(0.0));
        trace.record_turn(&turn(1.0, edge(1, 4, true)));
        trace.record_turn(&turn(2.0, edge(2, 7, true)));
        assert_eq!(trace.entry_at(0), StateEntry { since_s: Some(0.0), edge: None, began_with: None });
        assert_eq!(trace.entry_at(2), StateEntry { since_s: Some(2.0), edge: Some((7, 2.0)), began_with: None });
        // Back to the same state: nothing begins anew.
        trace.record_turn(&turn(3.0, edge(1, 5, false)));
        assert_eq!(trace.entry_at(1), StateEntry { since_s: Some(1.0), edge: Some((5, 3.0)), began_with: None });
        assert_eq!(trace.entry_at(2).since_s, Some(2.0));
        trace.record_turn(&turn(4.0, edge(0, 1, true)));
        assert_eq!(trace.entry_at(0).edge, Some((1, 4.0)));
        for level in [1, 2] {
            assert_eq!(trace.entry_at(level), StateEntry { since_s: Some(4.0), edge: None, began_with: Some(0) });
        }
        trace.record_turn(&turn(5.0, TurnKind::Starts));
        assert_eq!(trace.entry_at(1), StateEntry { since_s: Some(5.0), edge: None, began_with: None });
        assert_eq!(AgentTrace::starting_at(None).entry_at(0).since_s, None);
    }
}
