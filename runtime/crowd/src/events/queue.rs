//! The queue of events: a calendar (Brown 1988) with one entry for each agent.

use crate::NONE;
use std::cmp::Ordering;
use throng_base::prefetch;

/// Time that one turn of the calendar takes. Longer than most intervals between events, so that a page holds few
/// entries of later turns (s).
const TURN_S: f64 = 2.0;
/// Number of pages after the open one that a scout looks at.
const SCOUTED: u64 = 4;

/// Next event of every agent, in the exact order of time and then of number.
///
/// Time is cut into short pages; a page is an unordered list of the agents whose event falls into it. Only the page
/// that is open is sorted. Inserting, removing and taking the first cost the same for any number of agents.
#[derive(Clone, Debug)]
pub(crate) struct Calendar {
    pages_per_s: f64,
    /// First agent of each page; pages of all turns that fall together share one.
    first: Vec<u32>,
    entries: Vec<CalendarEntry>,
    /// Agents of the page that is open, the earliest last, if it is sorted.
    open: Vec<u32>,
    /// True where nothing was added since it was sorted.
    is_sorted: bool,
    /// Number of the page that is open; entries of all pages before it are in it too.
    page: u64,
    len: usize,
}

/// The event of an agent: in one place, as memory is slow.
#[derive(Clone, Copy, Debug)]
struct CalendarEntry {
    time: f64,
    /// Next agent in the list of its page.
    next: u32,
    /// Previous agent in that list; [`NONE`] for the first, [`NOWHERE`] without an event, [`OPEN`] in the page that is
    /// open.
    previous: u32,
}

const NOWHERE: u32 = NONE - 1;
const OPEN: u32 = NONE - 2;

/// Progress of [`Calendar::scout_soon`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CalendarScout {
    page: u64,
    /// The next agent in that page.
    next: u32,
}

impl Calendar {
    /// Bytes of an agent: its event, what it senses, its timer.
    pub const BYTES_EACH: usize = 3 * (size_of::<CalendarEntry>() + size_of::<u32>());

    /// Empty, for agents with numbers below `capacity`.
    pub fn new(capacity: usize) -> Self {
        // A few dozen entries each: fewer pages would take longer to sort, more of them longer to fetch from memory.
        let num_pages = (capacity / 4).next_power_of_two().clamp(512, 1 << 16);
        Self {
            pages_per_s: num_pages as f64 / TURN_S,
            first: vec![NONE; num_pages],
            entries: vec![CalendarEntry { time: 0.0, next: NONE, previous: NOWHERE }; capacity],
            open: Vec::with_capacity(capacity),
            is_sorted: true,
            page: 0,
            len: 0,
        }
    }

    /// Forgets all events; time goes on at `now`.
    pub fn clear(&mut self, now: f64) {
        self.first.fill(NONE);
        self.entries.iter_mut().for_each(|e| e.previous = NOWHERE);
        self.open.clear();
        self.page = self.page_of(now);
        self.len = 0;
    }

    /// Sets the event of an agent, in place of the previous one (0 <= time < 2e9).
    pub fn set(&mut self, agent: u32, time: f64) {
        self.remove(agent);
        let m = agent as usize;
        self.entries[m].time = time;
        self.len += 1;
        let page = self.page_of(time);
        if page <= self.page {
            // Many may come at the same time: they are sorted together.
            self.open.push(agent);
            self.is_sorted = false;
            self.entries[m].previous = OPEN;
            return;
        }
        let slot = page as usize & (self.first.len() - 1);
        let first = std::mem::replace(&mut self.first[slot], agent);
        (self.entries[m].previous, self.entries[m].next) = (NONE, first);
        if first != NONE {
            self.entries[first as usize].previous = agent;
        }
    }

    /// Forgets the event of an agent, if it has one.
    pub fn remove(&mut self, agent: u32) {
        let m = agent as usize;
        match self.entries[m].previous {
            NOWHERE => return,
            OPEN => {
                self.sort_open();
                let entries = &self.entries;
                let at = self.open.partition_point(|&o| order(entries, agent, o).is_lt());
                self.open.remove(at);
            }
            _ => self.unlink(agent),
        }
        self.entries[m].previous = NOWHERE;
        self.len -= 1;
    }

    /// Time and agent of the next event, if that is not after `until`. The entry stays.
    pub fn first(&mut self, until: f64) -> Option<(f64, u32)> {
        let last = self.page_of(until);
        if self.len == 0 {
            self.page = self.page.max(last);
            return None;
        }
        while self.open.is_empty() {
            if self.page >= last {
                return None;
            }
            self.page += 1;
            self.open_page();
        }
        self.sort_open();
        let agent = *self.open.last()?;
        let time = self.entries[agent as usize].time;
        (time <= until).then_some((time, agent))
    }

    /// An agent that acts soon, in no order: from the pages after the open one, as far as
    /// the scout may look ahead. Some agents may be missed, and some act later.
    #[inline]
    pub fn scout_soon(&self, scout: &mut CalendarScout) -> Option<u32> {
        if !(self.page + 1..=self.page + SCOUTED).contains(&scout.page) {
            *scout = CalendarScout { page: self.page + 1, next: self.first_of(self.page + 1) };
        }
        while scout.next == NONE {
            if scout.page >= self.page + SCOUTED {
                return None;
            }
            *scout = CalendarScout { page: scout.page + 1, next: self.first_of(scout.page + 1) };
        }
        let agent = scout.next;
        scout.next = self.entries[agent as usize].next;
        if let Some(next) = self.entries.get(scout.next as usize) {
            prefetch(next);
        }
        Some(agent)
    }

    /// First agent of a page.
    fn first_of(&self, page: u64) -> u32 {
        self.first[page as usize & (self.first.len() - 1)]
    }

    fn page_of(&self, time: f64) -> u64 {
        (time * self.pages_per_s) as u64
    }

    fn sort_open(&mut self) {
        if !self.is_sorted {
            let entries = &self.entries;
            self.open.sort_unstable_by(|&a, &b| order(entries, b, a));
            self.is_sorted = true;
        }
    }

    fn unlink(&mut self, agent: u32) {
        let CalendarEntry { time, next, previous } = self.entries[agent as usize];
        if next != NONE {
            self.entries[next as usize].previous = previous;
        }
        if previous != NONE {
            self.entries[previous as usize].next = next;
        } else {
            let page = self.page_of(time) as usize & (self.first.len() - 1);
            self.first[page] = next;
        }
    }

    fn open_page(&mut self) {
        let mut agent = self.first_of(self.page);
        while agent != NONE {
            let CalendarEntry { time, next, .. } = self.entries[agent as usize];
            if self.page_of(time) == self.page {
                self.unlink(agent);
                self.entries[agent as usize].previous = OPEN;
                self.open.push(agent);
            }
            agent = next;
        }
        self.is_sorted = false;
    }
}

/// Order of two agents by the time of their events, and then by number.
fn order(entries: &[CalendarEntry], one: u32, other: u32) -> Ordering {
    let time = |agent: u32| entries[agent as usize].time;
    time(one).total_cmp(&time(other)).then(one.cmp(&other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn order_equals_sorted_list(work in proptest::collection::vec((0u32..40, 0u32..600, 0..6), 1..400)) {
            let mut calendar = Calendar::new(40);
            let mut list: Vec<(f64, u32)> = Vec::new();
            let mut now = 0.0;
            for (agent, after, kind) in work {
                // Coarse times, so that many are equal; some are several turns away.
                let time = now + f64::from(after) * 0.01;
                match kind {
                    0 => {
                        calendar.remove(agent);
                        list.retain(|e| e.1 != agent);
                    }
                    1..=3 => {
                        calendar.set(agent, time);
                        list.retain(|e| e.1 != agent);
                        list.push((time, agent));
                    }
                    _ => {
                        list.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                        let until = now + f64::from(after) * 0.005;
                        let want = list.first().copied().filter(|e| e.0 <= until);
                        prop_assert_eq!(calendar.first(until), want);
                        if let Some((t, m)) = want {
                            now = t;
                            calendar.remove(m);
                            list.remove(0);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn scout_finds_all_soon_events_once() {
        let mut calendar = Calendar::new(2000);
        let mut scout = CalendarScout::default();
        // Time may be set back, as a snapshot does.
        for now in [0.02, 0.05, 0.001] {
            calendar.clear(0.0);
            // A page is 3.9 ms long.
            (0..2000u32).for_each(|m| calendar.set(m, f64::from(m * 7919 % 2000) * 1e-4));
            while let Some((_, agent)) = calendar.first(now) {
                calendar.remove(agent);
            }
            let mut found: Vec<u32> = std::iter::from_fn(|| calendar.scout_soon(&mut scout)).collect();
            found.sort_unstable();
            let pages = calendar.page + 1..=calendar.page + SCOUTED;
            let soon = |m: &u32| pages.contains(&calendar.page_of(calendar.entries[*m as usize].time));
            let want: Vec<u32> = (0..2000).filter(soon).collect();
            assert!(want.len() > 100, "{}", want.len());
            assert_eq!(found, want, "at {now} s");
            assert_eq!(calendar.scout_soon(&mut scout), None, "until time goes on");
        }
    }

    #[test]
    fn entry_before_open_page_comes_first() {
        let mut calendar = Calendar::new(4);
        calendar.set(0, 5.0);
        assert_eq!(calendar.first(9.0), Some((5.0, 0)));
        calendar.set(1, 1.0);
        calendar.set(2, 5.0);
        assert_eq!(calendar.first(9.0), Some((1.0, 1)));
        calendar.remove(1);
        calendar.remove(0);
        assert_eq!(calendar.first(9.0), Some((5.0, 2)));
    }
}
