//! Number of agents that know each message, over time.

use throng_simulation::scenario::{AgentBrains, Turn, TurnKind};

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
        for times in &mut self.0 {
            times.truncate(times.partition_point(|t| *t <= time_s));
        }
    }

    /// Times at which agents learnt a message, ascending; includes recorded times after the one shown (s).
    pub fn times(&self, event: usize) -> &[f64] {
        self.0.get(event).map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
