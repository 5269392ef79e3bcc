//! Detects a crowd in which time does not pass.

use crate::NONE;
use throng_base::prefetch;

/// Time after which the count begins anew (s).
const COUNTED_S: f64 = 1.0;

/// Counts the events of every agent, and reports an agent with more of them than the smallest interval allows: time
/// would hardly pass any more.
#[derive(Clone, Debug)]
pub(crate) struct Watchdog {
    most: u32,
    counts: Vec<Count>,
}

#[derive(Clone, Copy, Debug)]
struct Count {
    since: f64,
    events: u32,
    /// Partner in the last event.
    partner: u32,
}

/// An agent with too many events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Storm {
    /// The partner of its last event; [`NONE`] without one.
    pub partner: u32,
    pub events: u32,
    pub most: u32,
    /// Time in which they happened (s).
    pub seconds: f64,
}

impl Watchdog {
    /// For agents with numbers below `capacity`, with at most so many events in each smallest interval.
    pub fn new(capacity: usize, interval: f32, per_interval: u32) -> Self {
        // One more interval than fits, as the first counted event comes at the start of one.
        let most = per_interval * ((COUNTED_S / f64::from(interval)).ceil() as u32 + 1);
        Self { most, counts: vec![Count { since: f64::NEG_INFINITY, events: 0, partner: NONE }; capacity] }
    }

    /// Forgets the events of an agent: another one has its place now, or time goes on from elsewhere.
    pub fn forget(&mut self, agent: u32) {
        self.counts[agent as usize].since = f64::NEG_INFINITY;
    }

    /// Prefetches the count of an agent.
    #[inline]
    pub fn prefetch(&self, agent: u32) {
        prefetch(&self.counts[agent as usize]);
    }

    /// Counts an event of an agent, with the other agent if there is one.
    ///
    /// # Errors
    /// [`Storm`] if that is one too many.
    #[inline]
    pub fn note_event(&mut self, agent: u32, partner: u32, time: f64) -> Result<(), Storm> {
        let count = &mut self.counts[agent as usize];
        if time - count.since > COUNTED_S {
            *count = Count { since: time, events: 0, partner: NONE };
        }
        count.events += 1;
        if partner != NONE {
            count.partner = partner;
        }
        if count.events <= self.most {
            return Ok(());
        }
        Err(Storm { partner: count.partner, events: count.events, most: self.most, seconds: time - count.since })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn allowed_rate_of_events_passes() {
        let mut dog = Watchdog::new(3, 0.1, 1);
        for i in 0..500 {
            let time = f64::from(i) * f64::from(0.1f32);
            assert_eq!(dog.note_event(0, 1, time), Ok(()));
            // Agents that act seldom, and events of others, do not matter.
            assert_eq!(dog.note_event(1, 0, time + 0.05), Ok(()));
            if i % 7 == 0 {
                assert_eq!(dog.note_event(2, NONE, time), Ok(()));
            }
        }
    }

    #[test]
    fn names_pair_with_endless_events() {
        let mut dog = Watchdog::new(3, 0.1, 1);
        assert_eq!(dog.note_event(2, 1, 3.0), Ok(()));
        let storm = (0..100).find_map(|i| {
            // The wall between two events with the partner does not hide it.
            let partner = if i % 3 == 2 { NONE } else { 0 };
            dog.note_event(1, partner, 4.0 + f64::from(i) * 1e-3).err()
        });
        let storm = storm.expect("100 events in 0.1 s");
        assert_eq!((storm.partner, storm.events, storm.most), (0, 12, 11));
        assert!((storm.seconds - 0.011).abs() < 1e-9);
        // Time that stands still, too.
        let again = (0..100).find_map(|_| dog.note_event(0, 1, 9.0).err()).expect("100 events at once");
        assert_eq!((again.partner, again.seconds), (1, 0.0));
        dog.forget(0);
        assert_eq!(dog.note_event(0, 1, 9.0), Ok(()));
    }
}
