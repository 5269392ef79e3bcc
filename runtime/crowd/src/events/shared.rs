//! One crowd in several processes, each of which moves the agents of a region of its own.
//!
//! A region is a stripe of cells. As in `parallel.rs`, all events of a window are known at its start, and two of them
//! affect each other only where they share a cell around their agents. Each rank knows its own events and those of
//! others that touch its region or a margin of [`MARGIN`] cells around it, and keeps the agents of the margin, ghosts,
//! as their rank has them. It processes its events in the order of time, except those that have to wait for one of
//! another rank. Then all ranks exchange the changes in each other's margins, and go on with the events that waited. So
//! the motion is that of one process, bit by bit, and the safety rule compares the same plans.

use crate::events::decide::AgentState;
use crate::events::engine::{Engine, SeenAgent};
use crate::{EventCounts, NONE, Space, error::Result, events::parallel::WINDOW, space::plan::MotionPlan};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use throng_base::{Comm, Error, unexpected_message};

/// Number of cells around its own that a rank knows: its agents decide up to a cell away from where they are
/// registered, the agents they meet up to two cells away, and either looks a cell farther.
const MARGIN: usize = 3;
/// Overlaps below this are those of rounding (m).
const TOUCH_M: f32 = 1e-4;

/// A part of a crowd, as one rank has it.
#[derive(Debug)]
pub(crate) struct SharedEngine<V: Space> {
    engine: Engine<V>,
    /// Axis along which stripes follow each other.
    axis: usize,
    /// Rank of each coordinate of cells along the axis.
    owner: Vec<usize>,
    /// Coordinates that each rank knows, and coordinates next to those.
    known: Vec<Vec<bool>>,
    reached: Vec<Vec<bool>>,
    rank: usize,
    pub handed_over: u64,
    /// Places that were free at the start.
    num_free: usize,
    /// Agents that left the crowd by an event of this rank.
    departed: Vec<DepartedAgent<V>>,
    /// Last pass in which a waiting event was found in each cell.
    waits: Vec<u32>,
    pass: u32,
}

/// An event of a window.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct RankEvent {
    time: f64,
    agent: u32,
    /// Cells of the agent and of the partner that it may make act too, at that time; [`NONE`] without one.
    cells: [u32; 2],
    rank: usize,
    is_done: bool,
}

/// Changed state of an agent.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct ChangedAgent<V> {
    plan: MotionPlan<V>,
    /// State of the agent; its cell is [`NONE`] where it left.
    state: AgentState<V>,
}

/// An agent that left, in the order in which one process frees their places.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct DepartedAgent<V> {
    time: f64,
    /// Agent of the event, and whether its partner is the one that left.
    by: (u32, bool),
    agent: u32,
    state: AgentState<V>,
}

/// Message of a rank to another one after a pass.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct PassMessage<V> {
    /// Number of its events that still wait.
    waiting: usize,
    /// Agents whose events are done.
    done: Vec<u32>,
    changed: Vec<ChangedAgent<V>>,
}

/// State of a rank at the end, for the rank that joins all of them.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct GatheredRank<V> {
    counts: EventCounts,
    left: Vec<DepartedAgent<V>>,
    /// Agents in the order of cells, and of their place in them.
    agents: Vec<ChangedAgent<V>>,
}

fn encode(value: &impl Serialize) -> Vec<u8> {
    // Writing to memory what can be written cannot fail.
    bincode::serde::encode_to_vec(value, bincode::config::standard().with_fixed_int_encoding()).unwrap_or_default()
}

fn decode<T: DeserializeOwned>(rank: usize, bytes: &[u8]) -> Result<T, Error> {
    let config = bincode::config::standard().with_fixed_int_encoding();
    bincode::serde::decode_from_slice(bytes, config).map(|(value, _)| value).map_err(|_| unexpected_message(rank))
}

impl<V: Space> SharedEngine<V> {
    /// The part of a rank of a crowd that all ranks have made alike. Stripes hold as many agents each as cells allow.
    ///
    /// # Errors
    /// [`crate::CrowdError::Other`] for a crowd in which agents sense or care for others, or with another engine.
    pub fn new(mut engine: Engine<V>, comm: &dyn Comm) -> Result<Self> {
        let is_plain = !engine.sensors.is_on() && engine.relationships.saved().is_empty();
        let is_plain = is_plain && engine.is_of_registration();
        let expected =
            "0: without senses, timers, interests and companions of single agents, and with the engine of events";
        let got = f64::from(u8::from(!is_plain));
        throng_base::error::check_value("number of ties between agents", None, got, is_plain, expected)?;
        let (rank, num_ranks) = (comm.rank(), comm.num_ranks());
        let folds = engine.cells.folds();
        let axis = (0..V::DIMENSIONS).max_by_key(|&axis| folds[axis]).unwrap_or(0);
        let width = folds[axis] as usize;
        let mut num_at = vec![0; width];
        let mut all = 0;
        for state in engine.states.iter().filter(|s| s.cell != NONE) {
            num_at[engine.cells.folded(state.cell, axis)] += 1;
            all += 1;
        }
        let mut before = 0;
        let owner: Vec<usize> = num_at
            .iter()
            .map(|num| {
                // A coordinate that two ranks could have goes to the one with the larger part of it.
                let middle = before + num / 2;
                before += num;
                (middle * num_ranks / all.max(1)).min(num_ranks - 1)
            })
            .collect();
        let within = |margin: usize| {
            let near = |rank: usize, at: usize| {
                (0..=2 * margin).any(|k| owner[(at + k + margin * (width - 1)) % width] == rank)
            };
            (0..num_ranks).map(|rank| (0..width).map(|at| near(rank, at)).collect()).collect()
        };
        let (known, reached) = (within(MARGIN), within(MARGIN + 1));
        if rank > 0 {
            engine.counts = EventCounts::default();
        }
        let mut shared = Self {
            num_free: engine.free.len(),
            waits: vec![0; engine.cells.num_cells],
            engine,
            axis,
            owner,
            known,
            reached,
            rank,
            handed_over: 0,
            departed: Vec::new(),
            pass: 0,
        };
        for agent in 0..shared.engine.states.len() as u32 {
            shared.keep_known(agent);
        }
        Ok(shared)
    }

    /// Forgets an agent that is far away, and the event of one that is another rank's.
    fn keep_known(&mut self, agent: u32) {
        let cell = self.engine.states[agent as usize].cell;
        if cell == NONE || self.owner_of(cell) == self.rank {
            return;
        }
        self.engine.queue.remove(agent);
        if !self.is_known(self.rank, cell) {
            self.engine.cells.remove(cell, agent);
            self.engine.states[agent as usize].cell = NONE;
        }
    }

    fn owner_of(&self, cell: u32) -> usize {
        self.owner[self.engine.cells.folded(cell, self.axis)]
    }

    fn is_known(&self, rank: usize, cell: u32) -> bool {
        self.known[rank][self.engine.cells.folded(cell, self.axis)]
    }

    /// True for an agent that is in the crowd and belongs to this rank.
    fn is_own(&self, agent: u32) -> bool {
        let cell = self.engine.states[agent as usize].cell;
        cell != NONE && self.owner_of(cell) == self.rank
    }

    /// Agents of this rank.
    pub fn num_own(&self) -> usize {
        (0..self.engine.states.len() as u32).filter(|&m| self.is_own(m)).count()
    }

    /// Advances time to `until_s`.
    ///
    /// # Errors
    /// As [`Engine::run`], and [`Error::Rank`].
    pub fn advance(&mut self, until_s: f64, comm: &dyn Comm) -> Result<()> {
        self.engine.check_time(until_s)?;
        loop {
            let first = self.engine.queue.first(until_s).map_or(f64::INFINITY, |first| first.0);
            let first = comm.min(first)?;
            if first > until_s {
                break;
            }
            self.refresh_grid_until(first, comm)?;
            self.run_window(first, until_s, comm)?;
        }
        self.engine.now = until_s;
        Ok(())
    }

    /// Refreshes the grid, see [`Engine::refresh_grid_until`], with the agents of all ranks, which are added in the
    /// order of their numbers.
    fn refresh_grid_until(&mut self, time: f64, comm: &dyn Comm) -> Result<()> {
        let Some(now) = self.engine.begin_refresh(time) else { return Ok(()) };
        let own = (0..self.engine.states.len() as u32).filter(|&m| self.is_own(m));
        let own: Vec<(u32, SeenAgent<V>)> = own.filter_map(|m| Some((m, self.engine.seen_agent(m, now)?))).collect();
        let mut all = Vec::new();
        for (rank, bytes) in comm.all_gather(&encode(&own))?.iter().enumerate() {
            all.extend(decode::<Vec<(u32, SeenAgent<V>)>>(rank, bytes)?);
        }
        all.sort_by_key(|(m, _)| *m);
        all.iter().for_each(|(_, agent)| self.engine.add_seen(agent));
        let Engine { turns, scenery, .. } = &mut self.engine;
        turns.update(&scenery.passages, now);
        Ok(())
    }

    /// Processes all events from a time to the end of a window, which is not after another time.
    fn run_window(&mut self, time: f64, until_s: f64, comm: &dyn Comm) -> Result<()> {
        let end = (time + WINDOW * f64::from(self.engine.scenery.interval)).min(until_s);
        let mut items = Vec::new();
        while let Some((time, agent)) = self.engine.queue.first(end) {
            if time >= self.engine.next_refresh() {
                break;
            }
            self.engine.queue.remove(agent);
            items.push(self.rank_event(time, agent));
        }
        let of_rank = |rank: usize| items.iter().filter(|item| self.touches(item, rank)).copied().collect::<Vec<_>>();
        let messages =
            (0..comm.num_ranks()).map(|rank| if rank == self.rank { Vec::new() } else { encode(&of_rank(rank)) });
        for (rank, bytes) in comm.exchange(messages.collect())?.iter().enumerate() {
            if rank != self.rank {
                items.extend(decode::<Vec<RankEvent>>(rank, bytes)?);
            }
        }
        items.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.agent.cmp(&b.agent)));
        let mut place_of: Vec<(u32, usize)> = items.iter().enumerate().map(|(n, item)| (item.agent, n)).collect();
        place_of.sort_unstable();
        while !self.run_pass(&mut items, &place_of, comm)? {}
        Ok(())
    }

    /// An event of this rank that comes in a window.
    fn rank_event(&self, time: f64, agent: u32) -> RankEvent {
        let engine = &self.engine;
        let cell =
            |agent: u32| engine.cells.number(engine.cells.coordinates(engine.cells.plan(agent).motion_at(time).0));
        let partner = engine.partner(engine.cause(agent));
        // A partner that has acted since, or is to act by then, will not act again.
        let partner = partner.filter(|&p| engine.is_renewed_with(p, agent, time));
        RankEvent { time, agent, cells: [cell(agent), partner.map_or(NONE, cell)], rank: self.rank, is_done: false }
    }

    /// Calls `f` with every cell that an event may read or change.
    fn for_each_cell_around(&self, item: &RankEvent, mut f: impl FnMut(u32)) {
        let cells = &self.engine.cells;
        for cell in item.cells.into_iter().filter(|&c| c != NONE) {
            cells.for_each_cell_around(cells.coordinates_of(cell), &mut f);
        }
    }

    /// True where an event may read or change data that a rank knows.
    fn touches(&self, item: &RankEvent, rank: usize) -> bool {
        let at = |&cell: &u32| cell != NONE && self.reached[rank][self.engine.cells.folded(cell, self.axis)];
        item.cells.iter().any(at)
    }

    /// Processes the events of this rank that need not wait, and informs the others; true where no event waits any
    /// more.
    fn run_pass(&mut self, items: &mut [RankEvent], place_of: &[(u32, usize)], comm: &dyn Comm) -> Result<bool> {
        if self.pass == u32::MAX {
            self.waits.fill(0);
            self.pass = 0;
        }
        self.pass += 1;
        let nothing = || PassMessage { waiting: 0, done: Vec::new(), changed: Vec::new() };
        let mut messages: Vec<PassMessage<V>> = (0..comm.num_ranks()).map(|_| nothing()).collect();
        let mut waiting = 0;
        for item in items.iter_mut().filter(|item| !item.is_done) {
            let mut waits = item.rank != self.rank;
            self.for_each_cell_around(item, |cell| waits |= self.waits[cell as usize] == self.pass);
            if waits {
                waiting += usize::from(item.rank == self.rank);
                let mut waits = std::mem::take(&mut self.waits);
                self.for_each_cell_around(item, |cell| waits[cell as usize] = self.pass);
                self.waits = waits;
                continue;
            }
            item.is_done = true;
            let changed = self.process(item)?;
            for rank in (0..messages.len()).filter(|&rank| rank != self.rank && self.touches(item, rank)) {
                messages[rank].done.push(item.agent);
                let changed = changed.iter().filter(|&&m| m != NONE).map(|&m| self.changed_agent(m));
                messages[rank].changed.extend(changed);
            }
        }
        let messages = messages.iter_mut().map(|message| {
            message.waiting = waiting;
            encode(message)
        });
        let mut nobody_waits = true;
        for (rank, bytes) in comm.exchange(messages.collect())?.iter().enumerate() {
            let message: PassMessage<V> = decode(rank, bytes)?;
            nobody_waits &= message.waiting == 0;
            for agent in message.done {
                let place = place_of.binary_search_by_key(&agent, |p| p.0).map_err(|_| unexpected_message(rank))?;
                items[place_of[place].1].is_done = true;
            }
            message.changed.iter().for_each(|changed| self.apply_changes(changed));
        }
        Ok(nobody_waits)
    }

    /// The event of an agent of this rank, if it is still to come; returns the agents that it changed, or [`NONE`].
    fn process(&mut self, item: &RankEvent) -> Result<[u32; 2]> {
        let engine = &mut self.engine;
        if !engine.is_due(item.agent, item.time) {
            return Ok([NONE; 2]);
        }
        engine.now = item.time;
        let partner = engine.partner(engine.cause(item.agent));
        let cells = [Some(item.agent), partner].map(|m| m.map(|m| engine.states[m as usize].cell));
        let renewed = engine.process_event(item.agent)?;
        engine.events.clear();
        let changed = [Some(item.agent), renewed];
        for (n, (agent, from)) in changed.into_iter().zip(cells).enumerate() {
            let (Some(agent), Some(from)) = (agent, from) else { continue };
            let state = self.engine.states[agent as usize];
            if state.cell == NONE {
                self.departed.push(DepartedAgent { time: item.time, by: (item.agent, n == 1), agent, state });
                continue;
            }
            if self.owner_of(state.cell) != self.rank {
                self.engine.queue.remove(agent);
            }
            self.handed_over += u64::from(self.owner_of(from) != self.owner_of(state.cell));
        }
        Ok(changed.map(|m| m.unwrap_or(NONE)))
    }

    fn changed_agent(&self, agent: u32) -> ChangedAgent<V> {
        ChangedAgent { plan: self.engine.cells.plan(agent), state: self.engine.states[agent as usize] }
    }

    /// Applies the change of an agent by another rank.
    fn apply_changes(&mut self, changed: &ChangedAgent<V>) {
        let ChangedAgent { plan, state } = changed;
        let from = self.engine.states[plan.index as usize].cell;
        let to = if state.cell != NONE && self.is_known(self.rank, state.cell) { state.cell } else { NONE };
        let cells = &mut self.engine.cells;
        match (from != NONE, to != NONE) {
            (true, true) => cells.set(from, to, plan),
            (true, false) => cells.remove(from, plan.index),
            (false, true) => cells.insert(to, plan),
            (false, false) => (),
        }
        self.engine.states[plan.index as usize] = AgentState { cell: to, ..*state };
        match self.is_own(plan.index) {
            true => self.engine.queue.set(plan.index, plan.end),
            false => self.engine.queue.remove(plan.index),
        }
    }

    /// Number of agents of this rank that overlap another one now. Tests discs alone, independently of the safety rule.
    pub fn num_overlapping(&self) -> u64 {
        let engine = &self.engine;
        let overlaps = |agent: u32| {
            let (me, mut meets) = (engine.cells.plan(agent), false);
            engine.cells.for_each_cell_around(
                engine.cells.coordinates_of(engine.states[agent as usize].cell),
                |cell| {
                    engine.cells.for_each_in_cell(cell, |other| {
                        let apart = (me.motion_at(engine.now).0 - other.motion_at(engine.now).0).length();
                        meets |= other.index != agent && apart < me.radius + other.radius - TOUCH_M;
                    });
                },
            );
            meets
        };
        (0..engine.states.len() as u32).filter(|&m| self.is_own(m) && overlaps(m)).count() as u64
    }

    /// The whole crowd, as one process would have it now, on rank 0.
    ///
    /// # Errors
    /// [`Error::Rank`].
    pub fn gather_crowd(mut self, comm: &dyn Comm) -> Result<Option<Engine<V>>> {
        let mut agents = Vec::new();
        for cell in (0..self.engine.cells.num_cells as u32).filter(|&cell| self.owner_of(cell) == self.rank) {
            self.engine.cells.for_each_in_cell(cell, |plan| agents.push(self.changed_agent(plan.index)));
        }
        let own = GatheredRank { counts: self.engine.counts, left: std::mem::take(&mut self.departed), agents };
        let mut messages = vec![Vec::new(); comm.num_ranks()];
        messages[0] = encode(&own);
        let got = comm.exchange(messages)?;
        if self.rank > 0 {
            return Ok(None);
        }
        let mut left = Vec::new();
        let mut agents = Vec::new();
        let mut counts = EventCounts::default();
        for (rank, bytes) in got.iter().enumerate() {
            let of_rank: GatheredRank<V> = decode(rank, bytes)?;
            counts = counts.sum_with(&of_rank.counts);
            left.extend(of_rank.left);
            agents.extend(of_rank.agents);
        }
        // Agents of a cell come from one rank, in their order.
        agents.sort_by_key(|a| a.state.cell);
        left.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.by.cmp(&b.by)));
        let mut engine = self.engine;
        engine.counts = counts;
        engine.cells.clear();
        engine.queue.clear(engine.now);
        for ChangedAgent { plan, state } in agents {
            engine.states[plan.index as usize] = state;
            engine.cells.insert(state.cell, &plan);
            engine.queue.set(plan.index, engine.due_time(&plan));
        }
        engine.free.truncate(self.num_free);
        for DepartedAgent { agent, state, .. } in left {
            engine.states[agent as usize] = state;
            engine.free.push(agent);
        }
        Ok(Some(engine))
    }
}
