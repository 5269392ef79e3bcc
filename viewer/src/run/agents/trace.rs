//! What agents came to: the last edge at each level, which levels began anew with it, and when each message was learnt.

use throng_simulation::Simulation;
use throng_simulation::scenario::{AgentBrains, Turn, TurnKind};

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

/// When agents came to know of every message, ascending (s).
#[derive(Clone, Debug, Default)]
pub struct SpreadLog(Vec<Vec<f64>>);

impl SpreadLog {
    /// Present knowledge of all agents.
    pub fn from_agent_brains(brains: Option<&AgentBrains>) -> Self {
        let Some(brains) = brains else { return Self::default() };
        let times = |event: usize| {
            let known = (0..brains.len()).filter_map(|agent| brains.learnt_event(agent, event));
            let mut times: Vec<f64> = known.map(|l| l.time_s).collect();
            times.sort_by(f64::total_cmp);
            times
        };
        Self((0..brains.event_names().len()).map(times).collect())
    }

    /// Records an event of an agent's brain, later than all others.
    pub fn record_turn(&mut self, turn: &Turn) {
        if let (TurnKind::Learns(_), Some(event)) = (turn.kind, turn.event) {
            self.0[event].push(turn.time_s);
        }
    }

    /// Removes what was learnt after a time (s).
    pub fn forget_after(&mut self, time_s: f64) {
        self.0.iter_mut().for_each(|times| times.truncate(times.partition_point(|t| *t <= time_s)));
    }

    /// Times at which agents learnt a message, ascending; includes recorded times after the one shown (s).
    pub fn times(&self, event: usize) -> &[f64] {
        self.0.get(event).map_or(&[], Vec::as_slice)
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

    #[test]
    fn what_was_not_yet_learnt_is_forgotten() {
        let mut log = SpreadLog(vec![Vec::new(); 2]);
        let learnt = |time_s, event| Turn {
            time_s,
            agent: 0,
            kind: TurnKind::Learns("passed_on"),
            on: 0,
            other: None,
            place: None,
            event: Some(event),
        };
        for (time_s, event) in [(1.0, 0), (2.0, 1), (3.0, 0)] {
            log.record_turn(&learnt(time_s, event));
        }
        log.record_turn(&Turn { kind: TurnKind::Follows(0), ..learnt(3.5, 0) });
        assert_eq!((log.times(0), log.times(1), log.times(7)), (&[1.0, 3.0][..], &[2.0][..], &[][..]));
        log.forget_after(2.0);
        assert_eq!((log.times(0), log.times(1)), (&[1.0][..], &[2.0][..]));
    }
}
