//! Prefetches the memory that the next events need, while this one is decided.
//!
//! With many thousand agents, hardly anything is in the processor's caches when it is needed, and an event follows
//! links: from the queue to an agent, from there to the cells around it, and to the agents in them. So this goes
//! ahead of the events, one link at each.

use crate::events::decide::{AgentState, Cause};
use crate::steering::far_field::prefetch_oncoming;
use crate::{NONE, Space, events::engine::Engine, events::queue::CalendarScout};
use throng_base::prefetch;

/// Progress in preparing the next events.
#[derive(Clone, Debug, Default)]
pub(crate) struct Prefetcher {
    scout: CalendarScout,
    /// Agents found at the last events, the latest first; [`NONE`] where there was none; 0 before the first events.
    found: [u32; 2],
}

impl<V: Space> Engine<V> {
    /// Prefetches one step further. Changes nothing but the time that the next events take.
    pub(crate) fn prefetch(&mut self) {
        let found = self.queue.scout_soon(&mut self.prefetcher.scout).unwrap_or(NONE);
        let [last, before] = self.prefetcher.found;
        self.prefetcher.found = [found, last];
        if let Some(state) = self.states.get(found as usize) {
            prefetch(state);
            self.cells.prefetch(found);
            self.watchdog.prefetch(found);
        }
        if let Some(state) = self.agent_state(last) {
            self.cells.prefetch_cells(self.cells.coordinates(self.cells.plan(last).motion_at(self.now).0));
            self.scenery.prefetch(state.cell);
            prefetch(&self.scenery.paths[state.route as usize]);
            if let Cause::Agent(partner) = state.cause {
                prefetch(&self.states[partner as usize]);
            }
        }
        if let Some(state) = self.agent_state(before) {
            let position = self.cells.plan(before).motion_at(self.now).0;
            self.cells.prefetch_plans(self.cells.coordinates(position));
            self.scenery.paths[state.route as usize].prefetch(state.cursor.leg);
            prefetch_oncoming(&self.grid, position, state.intent, &self.scenery.steering);
        }
    }

    /// The state of an agent that is in the crowd.
    fn agent_state(&self, agent: u32) -> Option<&AgentState<V>> {
        self.states.get(agent as usize).filter(|m| m.cell != NONE)
    }
}
