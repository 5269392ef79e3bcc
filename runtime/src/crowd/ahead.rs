//! Fetching what the next events look at from memory, while this one is decided.
//!
//! Of many thousand members hardly anything is in the processor's caches when it is needed, and an event has to follow
//! links: from the queue to a member, from there to the cells around it, and to those who are in them. So this goes
//! ahead of the events, a link at each.

use super::decide::{Cause, Mind};
use super::outlook::prefetch_outlook;
use super::queue::Scout;
use super::{Crowd, NONE, Space};
use crate::prefetch::prefetch;

/// Those whose events come soon, as far as they are made ready.
#[derive(Clone, Debug)]
pub(crate) struct Ahead {
    scout: Scout,
    /// Those who were found at the last events, the latest first; [`NONE`] for nobody.
    found: [u32; 2],
}

impl Default for Ahead {
    fn default() -> Self {
        Self { scout: Scout::default(), found: [NONE; 2] }
    }
}

impl<V: Space> Crowd<V> {
    /// Goes on with what the next events look at. Changes nothing but the time that they take.
    pub(super) fn look_ahead(&mut self) {
        let found = self.queue.scout(&mut self.ahead.scout).unwrap_or(NONE);
        let [last, before] = self.ahead.found;
        self.ahead.found = [found, last];
        if let Some(mind) = self.minds.get(found as usize) {
            prefetch(mind);
            self.cells.prefetch(found);
            self.watchdog.prefetch(found);
        }
        if let Some(mind) = self.mind(last) {
            self.cells.prefetch_cells(self.cells.coordinates(self.cells.plan(last).at(self.now).0));
            self.world.prefetch(mind.cell);
            prefetch(&self.world.splines[mind.route as usize]);
            if let Cause::Member(partner) = mind.cause {
                prefetch(&self.minds[partner as usize]);
            }
        }
        if let Some(mind) = self.mind(before) {
            let position = self.cells.plan(before).at(self.now).0;
            self.cells.prefetch_plans(self.cells.coordinates(position));
            self.world.splines[mind.route as usize].prefetch(mind.cursor);
            prefetch_outlook(&self.flow, position, mind.intent);
        }
    }

    /// What a member who is there remembers.
    fn mind(&self, member: u32) -> Option<&Mind<V>> {
        self.minds.get(member as usize).filter(|m| m.cell != NONE)
    }
}
