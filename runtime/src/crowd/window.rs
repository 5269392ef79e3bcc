//! Independent events on several threads.
//!
//! No event makes another one within the smallest interval, so that all events of a shorter window of time are known at
//! its start. Each of them reads and changes members in cells next to its own; events that share no such cell commute.
//! They are put into levels: an event comes after all earlier ones that share a cell with it, and those of one level
//! are decided at the same time. What comes of them is noted in the order of levels, and told in the order of time. So
//! the result is that of one event after the other.

use super::decide::{Decision, Scratch};
use super::tracing::{Trace, Tracer};
use super::{Crowd, CrowdError, Event, NONE, Space};
use rayon::prelude::*;

/// Length of a window in smallest intervals.
const WINDOW: f64 = 0.5;
/// Fewest events of a window or level that are worth a second thread.
const FEWEST: usize = 32;

/// An event of the window.
#[derive(Clone, Copy, Debug)]
struct Item {
    time: f64,
    member: u32,
    /// Who is made anew together with the member, if nothing comes between.
    partner: u32,
    level: u32,
    order: u32,
}

/// Memory of windows; taken when the first one is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Windows<V> {
    items: Vec<Item>,
    /// Who decides in each event of a level.
    who: Vec<u32>,
    /// Whom each makes act after it.
    partners: Vec<u32>,
    decisions: Vec<Option<Decision<V>>>,
    scratches: Vec<Scratch<V>>,
    /// Last level that used each cell, counted over all windows.
    levels: Vec<u32>,
    base: u32,
    events: Vec<(u32, Event)>,
    left: Vec<(u32, u32)>,
}

impl<V: Space> Crowd<V> {
    /// As [`Crowd::advance`] on the threads of the current rayon pool; the result is the same, bit by bit. Pays from
    /// some thousand members on; schemes other than [`super::Scheme::Registration`] run on one thread. Takes memory for
    /// the threads when it is called first.
    ///
    /// # Errors
    /// As [`Crowd::advance`]. Some who act a little later than those of a [`CrowdError::Storm`] may have acted before it
    /// was seen.
    pub fn par_advance(&mut self, until_s: f64, on_event: &mut impl FnMut(&Event)) -> Result<(), CrowdError> {
        if !matches!(self.trace, Trace::Registration) {
            return self.advance(until_s, on_event);
        }
        self.check_time(until_s)?;
        let mut windows = std::mem::take(&mut self.windows);
        windows.levels.resize(self.cells.num_cells(), 0);
        let num_threads = rayon::current_num_threads();
        while windows.scratches.len() < num_threads {
            windows.scratches.push(Scratch::new(self.minds.len(), self.world.movers.len()));
        }
        let mut done = Ok(());
        while let Some((time, _)) = self.queue.first(until_s) {
            done = self.window(time, until_s, &mut windows, on_event);
            if done.is_err() {
                break;
            }
        }
        self.windows = windows;
        if done.is_ok() {
            self.now = until_s;
        }
        done
    }

    /// All events from `time` to the end of a window.
    fn window(
        &mut self,
        time: f64,
        until_s: f64,
        windows: &mut Windows<V>,
        on_event: &mut impl FnMut(&Event),
    ) -> Result<(), CrowdError> {
        self.look_until(time);
        let end = (time + WINDOW * f64::from(self.world.interval)).min(until_s);
        windows.items.clear();
        while let Some((time, member)) = self.queue.first(end) {
            if time >= self.next_look() {
                break;
            }
            self.queue.remove(member);
            let partner = self.partner(self.minds[member as usize].cause).unwrap_or(NONE);
            let order = windows.items.len() as u32;
            windows.items.push(Item { time, member, partner, level: 0, order });
        }
        let done = if windows.items.len() < FEWEST {
            self.one_by_one(&windows.items, on_event)
        } else {
            self.sort_by_level(windows);
            let items = std::mem::take(&mut windows.items);
            let done = items.chunk_by(|a, b| a.level == b.level).try_for_each(|level| self.level(level, windows));
            windows.items = items;
            self.tell(windows, on_event);
            done
        };
        if done.is_err() {
            self.put_back(&windows.items);
        }
        done
    }

    /// Tells what happened in the order of time, and frees the numbers of those who left.
    fn tell(&mut self, windows: &mut Windows<V>, on_event: &mut impl FnMut(&Event)) {
        windows.events.sort_by_key(|e| e.0);
        for (_, event) in windows.events.drain(..) {
            on_event(&event);
        }
        windows.left.sort_unstable();
        self.free.extend(windows.left.drain(..).map(|(_, member)| member));
    }

    /// Puts those of a window that was not ended back into the queue, with the ends of the plans they have now.
    fn put_back(&mut self, items: &[Item]) {
        for member in items.iter().map(|i| i.member) {
            if self.minds[member as usize].cell != NONE {
                self.queue.set(member, self.cells.plan(member).end);
            }
        }
    }

    /// True for an event that is still to come: its member has not been made anew before.
    fn is_due(&self, item: &Item) -> bool {
        self.minds[item.member as usize].cell != NONE && self.cells.plan(item.member).end == item.time
    }

    fn one_by_one(&mut self, items: &[Item], on_event: &mut impl FnMut(&Event)) -> Result<(), CrowdError> {
        for item in items {
            if self.is_due(item) {
                self.now = item.time;
                self.happen(item.member, on_event)?;
            }
        }
        Ok(())
    }

    /// Gives every event its level, and sorts by it.
    fn sort_by_level(&self, windows: &mut Windows<V>) {
        if windows.base > u32::MAX / 2 {
            windows.levels.fill(0);
            windows.base = 0;
        }
        let (levels, base) = (&mut windows.levels, windows.base);
        let mut last = base;
        for item in &mut windows.items {
            let mut level = base;
            let members = [item.member, item.partner];
            let here = members.iter().filter(|&&m| m != NONE);
            let cells = here.map(|&m| self.cells.coordinates(self.cells.plan(m).at(item.time).0));
            for at in cells.clone() {
                self.cells.around(at, |c| level = level.max(levels[c as usize]));
            }
            item.level = level + 1;
            for at in cells {
                self.cells.around(at, |c| levels[c as usize] = level + 1);
            }
            last = last.max(item.level);
        }
        windows.base = last;
        windows.items.sort_unstable_by_key(|i| (i.level, i.order));
    }

    /// Decides all events of a level: first the members', then their partners'.
    fn level(&mut self, items: &[Item], windows: &mut Windows<V>) -> Result<(), CrowdError> {
        windows.who.clear();
        windows.partners.clear();
        for item in items {
            let is_due = self.is_due(item);
            let is_pair = is_due && item.partner != NONE && self.is_renewed_with(item.partner, item.member, item.time);
            windows.who.push(if is_due { item.member } else { NONE });
            windows.partners.push(if is_pair { item.partner } else { NONE });
            if is_due {
                self.now = item.time;
                self.watch(item.member, Some(item.partner).filter(|&p| p != NONE))?;
                let event = self.count(item.member, self.kind(self.minds[item.member as usize].cause));
                windows.events.push((item.order, event));
            }
        }
        self.decide_all(items, windows);
        std::mem::swap(&mut windows.who, &mut windows.partners);
        self.decide_all(items, windows);
        Ok(())
    }

    /// Decides for one member of each event of a level, all at the same time, and notes what comes of it.
    fn decide_all(&mut self, items: &[Item], windows: &mut Windows<V>) {
        let Windows { who, decisions, scratches, .. } = windows;
        decisions.clear();
        decisions.resize(items.len(), None);
        let decide = |(decision, (&who, item)): (&mut Option<Decision<V>>, (&u32, &Item)), scratch: &mut Scratch<V>| {
            if who != NONE {
                *decision = V::decide(&self.decider(item.time), who, Tracer::Registration, scratch);
            }
        };
        if items.len() < FEWEST {
            for work in decisions.iter_mut().zip(who.iter().zip(items)) {
                decide(work, &mut scratches[0]);
            }
        } else {
            let share = items.len().div_ceil(scratches.len());
            let parts = decisions.par_chunks_mut(share).zip(who.par_chunks(share)).zip(items.par_chunks(share));
            parts.zip(scratches.par_iter_mut()).for_each(|(((decisions, who), items), scratch)| {
                for work in decisions.iter_mut().zip(who.iter().zip(items)) {
                    decide(work, scratch);
                }
            });
        }
        for (item, place) in items.iter().zip(0..) {
            if let Some(decision) = windows.decisions[place] {
                self.now = item.time;
                let who = windows.who[place];
                self.queue.set(who, decision.plan.end);
                if self.take(who, &decision, &mut |e| windows.events.push((item.order, *e))) {
                    windows.left.push((item.order, who));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::EventKind;
    use crate::crowd::tests::crossing;
    use glam::Vec2;

    #[test]
    fn a_storm_takes_nobody_out_of_the_queue() {
        // Few, who act one by one, and many, who act in levels.
        for num in [20, 900] {
            let mut crowd = Crowd::new(crossing::<Vec2>(num, 1.1)).unwrap();
            crowd.advance(1.0, &mut |_| {}).unwrap();
            let (kept, before) = (crowd.snapshot(), crowd.counts());
            crowd.advance(2.0, &mut |_| {}).unwrap();
            let hash = crowd.state_hash();
            crowd.restore(&kept).unwrap();
            // As if the last one of the next window had acted too often.
            let (time, _) = crowd.queue.first(2.0).unwrap();
            let end = |m: &u32| crowd.cells.plan(*m).end;
            let soon = crowd.ids().map(|id| id.index).filter(|m| end(m) < time + 0.04);
            let tired = soon.max_by(|a, b| end(a).total_cmp(&end(b))).unwrap();
            while crowd.watchdog.note(tired, NONE, crowd.now).is_ok() {}
            let mut told = 0;
            let is_own =
                |k| matches!(k, EventKind::Resetting | EventKind::Colliding { .. } | EventKind::Meeting { .. });
            let error = crowd.par_advance(2.0, &mut |e| told += u64::from(is_own(e.kind))).unwrap_err();
            assert!(matches!(error, CrowdError::Storm { first, .. } if first.index == tired), "{error}");
            let own = |c: crate::crowd::Counts| c.resetting + c.colliding + c.meeting;
            assert_eq!(told, own(crowd.counts()) - own(before), "what was counted is told");
            let mut waiting = Vec::new();
            while let Some((time, member)) = crowd.queue.first(9.0) {
                assert_eq!(time, crowd.cells.plan(member).end);
                crowd.queue.remove(member);
                waiting.push(member);
            }
            waiting.sort_unstable();
            assert_eq!(waiting, (0..num as u32).collect::<Vec<_>>());
            crowd.restore(&kept).unwrap();
            crowd.par_advance(2.0, &mut |_| {}).unwrap();
            assert_eq!(crowd.state_hash(), hash, "a snapshot goes on as if there had been no storm");
        }
    }
}
