//! Lists of the bounds that occupy each cell, and when that changes (Kim, Kim and Shin 2003a, section 2.2).

mod contacts;
mod crossing;
pub(crate) mod events;

use self::contacts::ContactGraph;
use self::crossing::{Crossing, next_crossing, range};
use crate::events::decide::{Cause, Decider};
use crate::safety::bound::{Bound, WIDEST, time_until_gone};
use crate::{NONE, Space, space::cells::CellGrid, space::plan::MotionPlan};
use serde::{Deserialize, Serialize};

/// The cells that each agent occupies, and contacts between agents.
///
/// A bound occupies a cell where the smallest box around it does: it enters one when it touches the face before it. As it is never wider
/// than a cell, these are at most two along each axis. Two bounds that touch have a cell in common.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Occupancy {
    /// First entry of each cell.
    #[serde(skip)]
    first: Vec<u32>,
    /// Entries, one for each cell that an agent can occupy: `agent * SLOTS + slot`.
    #[serde(skip)]
    links: Vec<Link>,
    pub occupants: Vec<Occupant>,
    pub contacts: ContactGraph,
    /// The agent whose bound is renewed in the same event as that of the deciding one.
    #[serde(skip)]
    pub renewed: Option<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Link {
    next: u32,
    previous: u32,
}

/// Cells of one agent.
const SLOTS: usize = 8;

/// What is known of one agent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Occupant {
    pub is_listed: bool,
    /// Cells that its bound occupies, before they are folded.
    pub low: [i32; 3],
    pub high: [i32; 3],
    /// When that changes.
    pub crossing: Crossing,
    /// First contact that was found since its last event, and with what; this event does not wait for the end of its plan.
    pub meeting: (f64, Cause),
    /// When it was asked last to take a new plan (s).
    pub asked: f64,
}

impl Default for Occupant {
    fn default() -> Self {
        Self {
            is_listed: false,
            low: [0; 3],
            high: [0; 3],
            crossing: Crossing::NEVER,
            meeting: (f64::INFINITY, Cause::Region),
            asked: 0.0,
        }
    }
}

impl Occupancy {
    /// Nobody in any cell.
    pub fn new(num_cells: usize, capacity: usize) -> Self {
        let (occupants, contacts) = (vec![Occupant::default(); capacity], ContactGraph::new(capacity));
        let mut empty = Self { first: Vec::new(), links: Vec::new(), occupants, contacts, renewed: None };
        empty.clear(num_cells);
        empty
    }

    fn clear(&mut self, num_cells: usize) {
        self.first = vec![NONE; num_cells];
        self.links = vec![Link { next: NONE, previous: NONE }; self.occupants.len() * SLOTS];
    }

    /// Makes the lists of what was read.
    pub fn relink<V: Space>(&mut self, cells: &CellGrid<V>) {
        self.clear(cells.num_cells);
        for agent in 0..self.occupants.len() as u32 {
            let o = self.occupants[agent as usize];
            if o.is_listed {
                each_cell(o.low, o.high, |at| self.link(cells, agent, at));
            }
        }
        self.contacts.reserve();
    }

    /// True where what was read is as large as another one, and right for the plans of its agents.
    pub fn fits<'a, V: Space>(
        &self,
        other: &Self,
        side: f32,
        now: f64,
        plan: impl Fn(u32) -> Option<&'a MotionPlan<V>>,
    ) -> bool {
        let is_good = |(agent, o): (u32, &Occupant)| {
            let Some(plan) = plan(agent) else { return *o == Occupant::default() };
            let (centre, radius) = Bound::from(plan).disc_at(now);
            let (x, c) = (centre.coordinates(), &o.crossing);
            let reaches = |i: usize| {
                let (from, to) = ((x[i] - radius) / side, (x[i] + radius) / side);
                (o.low[i] as f32 - from.floor()).abs() <= 1.0 && (o.high[i] as f32 - to.floor()).abs() <= 1.0
            };
            let spans = |i: usize| o.high[i].checked_sub(o.low[i]).is_some_and(|n| n == 0 || n == 1);
            let axes = (0..V::DIMENSIONS).all(|i| reaches(i) && spans(i));
            let rest = (V::DIMENSIONS..3).all(|i| (o.low[i], o.high[i]) == (0, 0));
            let crossing = (c.axis as usize) < V::DIMENSIONS
                && (c.after == f32::INFINITY || c.after >= 0.0)
                && c.enters == (o.low[c.axis as usize] == o.high[c.axis as usize]);
            let cause = !matches!(o.meeting.1, Cause::Agent(m) if m as usize >= self.occupants.len());
            let times = o.meeting.0 >= 0.0 && (0.0..=now).contains(&o.asked);
            o.is_listed && axes && rest && crossing && cause && times
        };
        self.occupants.len() == other.occupants.len()
            && (0u32..).zip(&self.occupants).all(is_good)
            && self.contacts.fits(&other.contacts)
    }

    /// Lists an agent in the cells that the bound at the start of its plan occupies, and in no others.
    pub fn list<V: Space>(&mut self, cells: &CellGrid<V>, plan: &MotionPlan<V>) {
        let (low, high) = range(cells.side, plan);
        let mut o = self.occupants[plan.index as usize];
        if o.is_listed {
            each_cell(o.low, o.high, |at| {
                if !is_within(at, low, high) {
                    self.unlink(cells, plan.index, at)
                }
            });
        }
        each_cell(low, high, |at| {
            if !o.is_listed || !is_within(at, o.low, o.high) {
                self.link(cells, plan.index, at)
            }
        });
        (o.is_listed, o.low, o.high) = (true, low, high);
        o.crossing = next_crossing(cells.side, plan, o.low, o.high, 0.0);
        o.meeting = (f64::INFINITY, Cause::Region);
        self.occupants[plan.index as usize] = o;
    }

    /// Takes an agent out of all lists (it has no contact).
    pub fn remove<V: Space>(&mut self, cells: &CellGrid<V>, agent: u32) {
        let o = self.occupants[agent as usize];
        if o.is_listed {
            each_cell(o.low, o.high, |at| self.unlink(cells, agent, at));
        }
        self.occupants[agent as usize] = Occupant::default();
    }

    /// Lets an agent cross the face that it comes to. Gives the cells it enters, if it does.
    pub fn cross<V: Space>(&mut self, cells: &CellGrid<V>, plan: &MotionPlan<V>) -> Option<([i32; 3], [i32; 3])> {
        let mut o = self.occupants[plan.index as usize];
        let Crossing { after, axis, is_upper, enters } = o.crossing;
        let axis = axis as usize;
        let (mut low, mut high) = (o.low, o.high);
        let (face, outward) = if is_upper { (&mut o.high[axis], 1) } else { (&mut o.low[axis], -1) };
        let changed = if enters { *face + outward } else { *face };
        *face = if enters { changed } else { changed - outward };
        (low[axis], high[axis]) = (changed, changed);
        if enters {
            each_cell(low, high, |at| self.link(cells, plan.index, at));
        } else {
            each_cell(low, high, |at| self.unlink(cells, plan.index, at));
        }
        o.crossing = next_crossing(cells.side, plan, o.low, o.high, after);
        self.occupants[plan.index as usize] = o;
        enters.then_some((low, high))
    }

    /// Calls `f` once for every agent in one of the cells.
    #[inline]
    pub fn each<V: Space>(&self, cells: &CellGrid<V>, low: [i32; 3], high: [i32; 3], mut f: impl FnMut(u32)) {
        each_cell(low, high, |at| {
            let mut entry = self.first[cells.number(at) as usize];
            while entry != NONE {
                let agent = entry / SLOTS as u32;
                let o = &self.occupants[agent as usize];
                // In the first of the cells that both have; agents that only share one where the grid is folded have none.
                if (0..3).all(|i| at[i] == low[i].max(o.low[i]) && at[i] <= o.high[i]) {
                    f(agent);
                }
                entry = self.links[entry as usize].next;
            }
        });
    }

    /// Lists are in the order of numbers.
    fn link<V: Space>(&mut self, cells: &CellGrid<V>, agent: u32, at: [i32; 3]) {
        let (entry, cell) = (entry(agent, at), cells.number(at) as usize);
        let (mut previous, mut next) = (NONE, self.first[cell]);
        while next != NONE && next < entry {
            (previous, next) = (next, self.links[next as usize].next);
        }
        self.links[entry as usize] = Link { next, previous };
        if next != NONE {
            self.links[next as usize].previous = entry;
        }
        if previous != NONE {
            self.links[previous as usize].next = entry;
        } else {
            self.first[cell] = entry;
        }
    }

    fn unlink<V: Space>(&mut self, cells: &CellGrid<V>, agent: u32, at: [i32; 3]) {
        let Link { next, previous } = self.links[entry(agent, at) as usize];
        if next != NONE {
            self.links[next as usize].previous = previous;
        }
        if previous != NONE {
            self.links[previous as usize].next = next;
        } else {
            self.first[cells.number(at) as usize] = next;
        }
    }

    /// When the bound of a new plan is as wide as a cell, or touches another one in a cell that it occupies.
    #[inline]
    pub fn first_meeting<V: Space>(&self, at: &Decider<'_, V>, fresh: &MotionPlan<V>) -> (Cause, f32) {
        let (bound, side) = (Bound::from(fresh), at.cells.side);
        let mut first = (Cause::Region, time_until_gone(0.5 * WIDEST * side - fresh.radius, 0.0, fresh.limit));
        let (low, high) = range(side, fresh);
        self.each(at.cells, low, high, |other| {
            if other != fresh.index && !self.contacts.are_together(fresh.index, other) {
                let plan = at.cells.plan(other);
                let is_renewed = self.renewed == Some(other);
                let its = if is_renewed { Bound::new(&plan, at.time) } else { Bound::from(&plan) };
                let contact = bound.first_contact(&its, at.time, first.1);
                if contact < first.1 {
                    first = (Cause::Agent(other), contact);
                }
            }
        });
        first
    }
}

/// Entry of an agent for a cell: no two of the cells that it occupies have coordinates that are even and odd alike.
fn entry(agent: u32, at: [i32; 3]) -> u32 {
    let slot = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
    agent * SLOTS as u32 + slot as u32
}

#[inline]
fn each_cell(low: [i32; 3], high: [i32; 3], mut f: impl FnMut([i32; 3])) {
    for z in low[2]..=high[2] {
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                f([x, y, z]);
            }
        }
    }
}

fn is_within(at: [i32; 3], low: [i32; 3], high: [i32; 3]) -> bool {
    (0..3).all(|i| (low[i]..=high[i]).contains(&at[i]))
}
