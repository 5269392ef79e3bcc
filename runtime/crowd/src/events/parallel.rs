//! Independent events on several threads.
//!
//! No event causes another one within the smallest interval, so that all events of a shorter window of time are known
//! at its start. Each of them reads and changes agents in cells next to its own; events that share no such cell
//! commute. They are sorted into levels: an event comes after all earlier ones that share a cell with it, and those of
//! one level are decided at the same time. Their results are applied in the order of levels, and reported in the order
//! of time. So the result is that of one event after the other.

use crate::events::decide::{Decision, DecisionScratch};
use crate::events::schemes::REGISTRATION;
use crate::{NONE, Space, error::Result, events::engine::Engine, events::event::CrowdEvent};
use std::sync::{Mutex, PoisonError};
use throng_base::{Executor, Inline};

/// Length of a window in smallest intervals.
pub(crate) const WINDOW: f64 = 0.5;
/// Fewest events of a window or level that are worth a second thread.
const FEWEST: usize = 32;
/// Most parts that a level is split into.
const PARTS: usize = 32;
/// Agents for which each part has memory from the start.
const NEIGHBOURS: usize = 512;

/// An event of the window.
#[derive(Clone, Copy, Debug)]
struct WindowEvent {
    time: f64,
    agent: u32,
    /// Acts together with the agent, if nothing comes between.
    partner: u32,
    level: u32,
    order: u32,
}

/// Memory of windows; taken when the first one is.
#[derive(Debug, Default)]
pub(crate) struct EventWindows<V> {
    items: Vec<WindowEvent>,
    /// Deciding agent of each event of a level.
    who: Vec<u32>,
    /// Partner that acts after each of them.
    partners: Vec<u32>,
    /// Each is used by one thread at a time: no lock is waited for.
    parts: Vec<Mutex<LevelPart<V>>>,
    /// Last level that used each cell, counted over all windows.
    levels: Vec<u32>,
    base: u32,
    /// Events, with their order in the window.
    events: Vec<(u32, CrowdEvent)>,
    left: Vec<(u32, u32)>,
}

impl<V: Space> Clone for EventWindows<V> {
    /// Windows keep nothing from one to the next: a copy takes memory of its own when it needs it.
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// A part of a level, decided by one thread.
#[derive(Debug)]
struct LevelPart<V> {
    decisions: Vec<Option<Decision<V>>>,
    scratch: DecisionScratch<V>,
}

impl<V: Space> Engine<V> {
    /// Runs the engine in parts that `run` runs; the result equals that of [`Engine::run`] bit by bit.
    ///
    /// # Errors
    /// As [`Engine::run`]. Some agents that act a little after those of a [`crate::CrowdError::Stalled`] may have acted
    /// before it was detected.
    pub fn run_parallel(&mut self, until_s: f64, run: &dyn Executor) -> Result<bool> {
        if !self.is_of_registration() || self.sensors.is_on() {
            return self.run(until_s);
        }
        self.check_time(until_s)?;
        self.events.clear();
        let mut windows = std::mem::take(&mut self.windows);
        windows.levels.resize(self.cells.num_cells, 0);
        let capacity = self.states.len().min(NEIGHBOURS);
        windows.parts.resize_with(PARTS, || {
            Mutex::new(LevelPart {
                decisions: Vec::new(),
                scratch: DecisionScratch::new(capacity, self.scenery.movers.len()),
            })
        });
        let mut done = Ok(true);
        while let Ok(true) = done
            && let Some((time, _)) = self.queue.first(until_s)
        {
            done = match self.is_full() {
                true => Ok(false),
                false => self.run_window(time, until_s, &mut windows, run).map(|()| true),
            };
        }
        self.windows = windows;
        if matches!(done, Ok(true)) {
            self.now = until_s;
        }
        done
    }

    /// Processes all events from a time to the end of a window, which is not after another time.
    fn run_window(&mut self, time: f64, until_s: f64, windows: &mut EventWindows<V>, run: &dyn Executor) -> Result<()> {
        self.refresh_grid_until(time);
        let end = (time + WINDOW * f64::from(self.scenery.interval)).min(until_s);
        windows.items.clear();
        while let Some((time, agent)) = self.queue.first(end) {
            if time >= self.next_refresh() {
                break;
            }
            self.queue.remove(agent);
            let partner = self.partner(self.cause(agent)).unwrap_or(NONE);
            let order = windows.items.len() as u32;
            windows.items.push(WindowEvent { time, agent, partner, level: 0, order });
        }
        let done = if windows.items.len() < FEWEST {
            windows.items.iter().try_for_each(|item| {
                if self.is_due(item.agent, item.time) {
                    self.now = item.time;
                    self.process_event(item.agent)?;
                }
                Ok(())
            })
        } else {
            self.sort_by_level(windows);
            let items = std::mem::take(&mut windows.items);
            let mut levels = items.chunk_by(|a, b| a.level == b.level);
            let done = levels.try_for_each(|level| self.run_level(level, windows, run));
            windows.items = items;
            self.report_in_order(windows);
            done
        };
        if done.is_err() {
            self.requeue_events(&windows.items);
        }
        done
    }

    /// Notes events in the order of time, and frees the places of agents that left.
    fn report_in_order(&mut self, windows: &mut EventWindows<V>) {
        windows.events.sort_by_key(|e| e.0);
        self.events.extend(windows.events.drain(..).map(|(_, event)| event));
        windows.left.sort_unstable();
        self.free.extend(windows.left.drain(..).map(|(_, agent)| agent));
    }

    /// Puts the events of a window that was not completed back into the queue: at their times if the agents have not
    /// acted, otherwise at the ends of their plans.
    fn requeue_events(&mut self, items: &[WindowEvent]) {
        for &WindowEvent { agent, time, .. } in items {
            if self.states[agent as usize].cell != NONE {
                let time = if self.is_due(agent, time) { time } else { self.cells.plan(agent).end };
                self.queue.set(agent, time);
            }
        }
    }

    /// Assigns every event its level, and sorts the events by it.
    fn sort_by_level(&self, windows: &mut EventWindows<V>) {
        if windows.base > u32::MAX / 2 {
            windows.levels.fill(0);
            windows.base = 0;
        }
        let (levels, base) = (&mut windows.levels, windows.base);
        let mut last = base;
        for item in &mut windows.items {
            let mut level = base;
            let agents = [item.agent, item.partner];
            let here = agents.iter().copied().filter(|&m| m != NONE);
            // Some agents look at others that are far away.
            let afar = here
                .clone()
                .filter_map(|m| self.relationships.relationships_of(m))
                .flat_map(|relationship| relationship.agents());
            let afar = afar.filter(|&m| self.states[m as usize].cell != NONE);
            let cells = here.chain(afar).map(|m| self.cells.coordinates(self.cells.plan(m).motion_at(item.time).0));
            for at in cells.clone() {
                self.cells.for_each_cell_around(at, |c| level = level.max(levels[c as usize]));
            }
            item.level = level + 1;
            for at in cells {
                self.cells.for_each_cell_around(at, |c| levels[c as usize] = level + 1);
            }
            last = last.max(item.level);
        }
        windows.base = last;
        windows.items.sort_unstable_by_key(|i| (i.level, i.order));
    }

    /// Decides all events of a level: first the agents', then their partners'.
    fn run_level(&mut self, items: &[WindowEvent], windows: &mut EventWindows<V>, run: &dyn Executor) -> Result<()> {
        windows.who.clear();
        windows.partners.clear();
        for item in items {
            let is_due = self.is_due(item.agent, item.time);
            let is_pair = is_due && item.partner != NONE && self.is_renewed_with(item.partner, item.agent, item.time);
            windows.who.push(if is_due { item.agent } else { NONE });
            windows.partners.push(if is_pair { item.partner } else { NONE });
            if is_due {
                self.now = item.time;
                self.note_for_watchdog(item.agent, Some(item.partner).filter(|&p| p != NONE))?;
                let from = self.events.len();
                self.report_event(item.agent, self.kind(self.cause(item.agent)));
                windows.events.extend(self.events.drain(from..).map(|e| (item.order, e)));
            }
        }
        self.decide_all(items, windows, run);
        std::mem::swap(&mut windows.who, &mut windows.partners);
        self.decide_all(items, windows, run);
        Ok(())
    }

    /// Decides for one agent of each event of a level, all at the same time, and applies the decisions in order.
    fn decide_all(&mut self, items: &[WindowEvent], windows: &mut EventWindows<V>, run: &dyn Executor) {
        let share = items.len().div_ceil(PARTS).max(FEWEST / 4);
        let num_parts = items.len().div_ceil(share);
        let (this, who, parts) = (&*self, &windows.who, &windows.parts);
        let decide = |n: usize| {
            let mut part = parts[n].lock().unwrap_or_else(PoisonError::into_inner);
            let LevelPart { decisions, scratch } = &mut *part;
            decisions.clear();
            decisions.extend(who.iter().zip(items).skip(n * share).take(share).map(|(&who, item)| match who {
                NONE => None,
                who => this.decider(item.time).decide(who, REGISTRATION, scratch),
            }));
        };
        if num_parts < 2 || items.len() < FEWEST {
            Inline.run(num_parts, &decide)
        } else {
            run.run(num_parts, &decide)
        }
        let EventWindows { who, parts, events, left, .. } = windows;
        for (n, part) in parts.iter_mut().enumerate().take(num_parts) {
            let part = part.get_mut().unwrap_or_else(PoisonError::into_inner);
            let deciders = who.iter().zip(items).skip(n * share);
            for (decision, (&who, item)) in part.decisions.iter().zip(deciders) {
                let Some(decision) = decision else {
                    if who != NONE {
                        self.resume_plan(who);
                    }
                    continue;
                };
                self.now = item.time;
                self.queue.set(who, decision.plan.end);
                let from = self.events.len();
                if self.apply(who, decision) {
                    left.push((item.order, who));
                }
                events.extend(self.events.drain(from..).map(|e| (item.order, e)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CrowdEventKind;
    use crate::tests::drive::{Drive, crossing};
    use glam::Vec2;

    #[test]
    fn stalled_crowd_keeps_everybody_in_the_queue() {
        // Few agents act one by one, many in levels.
        for num in [20, 900] {
            let mut crowd = Engine::new(crossing::<Vec2>(num, 1.1)).unwrap();
            crowd.advance(1.0, &mut |_| {}).unwrap();
            let (kept, before) = (crowd.bytes(), crowd.counts);
            crowd.advance(2.0, &mut |_| {}).unwrap();
            let hash = crowd.hash();
            crowd.load(&kept).unwrap();
            // As if the last one of the next window had acted too often.
            let (time, _) = crowd.queue.first(2.0).unwrap();
            let end = |m: &u32| crowd.cells.plan(*m).end;
            let soon = crowd.ids().map(|id| id.index).filter(|m| end(m) < time + 0.04);
            let tired = soon.max_by(|a, b| end(a).total_cmp(&end(b))).unwrap();
            while crowd.watchdog.note_event(tired, NONE, crowd.now).is_ok() {}
            let mut num_reported = 0;
            let is_own = |k| {
                matches!(
                    k,
                    CrowdEventKind::Resetting | CrowdEventKind::Colliding { .. } | CrowdEventKind::Meeting { .. }
                )
            };
            let error = crowd.par_advance(2.0, &mut |e| num_reported += u64::from(is_own(e.kind))).unwrap_err();
            assert!(matches!(error, crate::CrowdError::Stalled { first, .. } if first.index == tired), "{error}");
            let own = |c: crate::EventCounts| c.resetting + c.colliding + c.meeting;
            assert_eq!(num_reported, own(crowd.counts) - own(before), "what was counted is told");
            let mut waiting = Vec::new();
            while let Some((time, agent)) = crowd.queue.first(9.0) {
                assert_eq!(time, crowd.cells.plan(agent).end);
                crowd.queue.remove(agent);
                waiting.push(agent);
            }
            waiting.sort_unstable();
            assert_eq!(waiting, (0..num as u32).collect::<Vec<_>>());
            crowd.load(&kept).unwrap();
            crowd.par_advance(2.0, &mut |_| {}).unwrap();
            assert_eq!(crowd.hash(), hash, "a snapshot goes on as if there had been no storm");
        }
    }
}
