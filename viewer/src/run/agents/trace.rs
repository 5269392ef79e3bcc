//! How agents came to their states: the last edge at each level, and which levels began anew with it.

use throng_simulation::Simulation;
use throng_simulation::scenario::{Turn, TurnKind};

/// No edge.
const NONE: u16 = u16::MAX;

/// Last change at one level.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LevelTrace {
    /// Time at which its state began, or began anew (s); NaN if unknown.
    since_s: f32,
    /// When the edge was taken (s).
    taken_s: f32,
    /// The last edge, as numbered in the scene file; [`NONE`] for none.
    edge: u16,
    /// Level whose change made this one begin anew.
    above: u8,
}

/// The last edges of one agent, the highest level first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentTrace([LevelTrace; 3]);

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
    /// Trace of an agent that has been in its states since a time; NaN if unknown (s).
    fn starting_at(since_s: f32) -> Self {
        Self([LevelTrace { since_s, taken_s: f32::NAN, edge: NONE, above: u8::MAX }; 3])
    }

    /// Traces of all agents of a scene in its present state; empty if they have no brains.
    pub fn for_all_agents(simulation: &Simulation) -> Vec<Self> {
        let since_s = if simulation.time_s() == 0.0 { 0.0 } else { f32::NAN };
        vec![Self::starting_at(since_s); simulation.brains().map_or(0, |m| m.len())]
    }

    /// Records an event of the agent's brain.
    pub fn record_turn(&mut self, turn: &Turn) {
        let time_s = turn.time_s as f32;
        match turn.kind {
            TurnKind::Starts => *self = Self::starting_at(time_s),
            TurnKind::Takes { level, edge, changes, .. } => {
                let here = &mut self.0[level];
                (here.edge, here.taken_s) = (edge as u16, time_s);
                if changes {
                    (here.since_s, here.above) = (time_s, u8::MAX);
                    let anew = LevelTrace { since_s: time_s, taken_s: f32::NAN, edge: NONE, above: level as u8 };
                    self.0[level + 1..].fill(anew);
                }
            }
            _ => {}
        }
    }

    /// Entry into the state at a level (level < 3).
    pub fn entry_at(&self, level: usize) -> StateEntry {
        let l = self.0[level];
        StateEntry {
            since_s: (!l.since_s.is_nan()).then_some(f64::from(l.since_s)),
            edge: (l.edge != NONE).then_some((usize::from(l.edge), f64::from(l.taken_s))),
            began_with: (l.above != u8::MAX).then_some(usize::from(l.above)),
        }
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
        let mut trace = AgentTrace::starting_at(0.0);
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
        assert_eq!(AgentTrace::starting_at(f32::NAN).entry_at(0).since_s, None);
    }
}
