//! Event rates of every kind.

use super::AgentEventKind;
use crate::run::STEP_HZ;
use std::collections::VecDeque;

/// Time that rates are shown for (s).
pub const WINDOW_S: f64 = 10.0;
/// Time that one rate is a mean over (s).
const BIN_S: f64 = 0.25;
/// Marks that are kept: one minute, and the window before it.
const KEPT: usize = 70 * STEP_HZ as usize;

/// Numbers of events until a time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct EventTotals {
    time_s: f64,
    present: usize,
    totals: [u64; AgentEventKind::COUNT],
}

/// Numbers of events of every kind over time.
#[derive(Clone, Debug, Default)]
pub struct EventRates(VecDeque<EventTotals>);

impl EventRates {
    /// Records how many events of every kind there were until a time, later than all others (s).
    pub fn record_totals(&mut self, time_s: f64, present: usize, totals: [u64; AgentEventKind::COUNT]) {
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back(EventTotals { time_s, present, totals });
    }

    /// Removes the marks after a time, and returns how many events of every kind there had been by then.
    pub fn forget_after(&mut self, time_s: f64) -> [u64; AgentEventKind::COUNT] {
        self.0.truncate(self.0.partition_point(|m| m.time_s <= time_s + 1e-9));
        self.totals(time_s)
    }

    /// The last mark that is not after a time.
    fn totals_before(&self, time_s: f64) -> Option<&EventTotals> {
        let after = self.0.partition_point(|m| m.time_s <= time_s + 1e-9);
        self.0.get(after.checked_sub(1)?)
    }

    /// Events of every kind until a time, since the run began.
    pub fn totals(&self, until_s: f64) -> [u64; AgentEventKind::COUNT] {
        self.totals_before(until_s).map_or([0; AgentEventKind::COUNT], |m| m.totals)
    }

    /// Events of every kind of one agent in a second, in the order of time: (middle of a time span, rates), for the last
    /// [`WINDOW_S`] before a time (s, 1/s).
    pub fn rates_until(&self, until_s: f64) -> Vec<(f64, [f64; AgentEventKind::COUNT])> {
        let first = ((until_s - WINDOW_S).max(0.0) / BIN_S).ceil() as u64;
        let last = (until_s / BIN_S).floor() as u64;
        let bin = |i: u64| {
            let (from, to) = (self.totals_before(i as f64 * BIN_S)?, self.totals_before((i + 1) as f64 * BIN_S)?);
            let seconds = to.time_s - from.time_s;
            let agent_seconds = 0.5 * (from.present + to.present) as f64 * seconds;
            // Events before the first mark are unknown.
            let rate = |k: usize| (to.totals[k] - from.totals[k]) as f64 / agent_seconds;
            (agent_seconds > 0.0 && seconds > 0.5 * BIN_S)
                .then(|| (0.5 * (from.time_s + to.time_s), std::array::from_fn(rate)))
        };
        (first..last).filter_map(bin).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_per_agent_and_second() {
        let mut rates = EventRates::default();
        for step in 0..=20 * 60 {
            let mut totals = [0; AgentEventKind::COUNT];
            // Ten agents, each with three events a second; from 15 s on, twice as many collide.
            totals[0] = step / 2;
            totals[1] = u64::max(step, 900) - 900;
            rates.record_totals(step as f64 / 60.0, 10, totals);
        }
        let before = rates.rates_until(20.0);
        assert_eq!(before.len(), 40);
        assert!(before.iter().all(|(t, r)| (10.0..20.0).contains(t) && (r[0] - 3.0).abs() < 0.3), "{before:?}");
        assert!(before.iter().all(|(t, r)| (r[1] - if *t < 15.0 { 0.0 } else { 6.0 }).abs() < 1e-6), "{before:?}");
        assert_eq!((rates.totals(10.0)[0], rates.totals(-1.0)[0]), (300, 0));
        assert_eq!(rates.rates_until(2.0).len(), 8);
    }
}
