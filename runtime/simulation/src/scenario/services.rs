//! Services: agents join a line, are called to a till, and are served; what tills and lines did is counted exactly.

use super::agent_brain::{ActionPhase, EventContext, NO_NUMBER, Occasion};
use super::agent_brains::{AgentBrains, place_context};
use super::tables::{ActionClaim, CompiledAction, NONE, Scenario, trigger};
use super::{language::Program, stage::ScenarioStage};
use crate::scene::{LineChoice, TimeDistribution};
use serde::{Deserialize, Serialize};
use throng_base::Result;

/// Width of the classes in which waits are counted (s), and their number; longer waits are in the last one.
const CLASS_S: f64 = 0.5;
const CLASSES: usize = 3601;

/// A compiled service.
#[derive(Clone, Debug)]
pub(super) struct ServiceTable {
    pub tills: u16,
    pub lines: Vec<u16>,
    pub join: LineChoice,
    pub apart: bool,
    pub priority: Option<Program>,
    pub time: TimeDistribution,
    pub balk: Option<Program>,
    pub patience: Option<TimeDistribution>,
}

/// Record of a service so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ServiceRecord {
    pub tills: Vec<TillRecord>,
    pub balked: u32,
    pub gave_up: u32,
    /// Number of waits in each class.
    pub waits: Vec<u32>,
    pub wait_sum_s: f64,
    pub longest_s: f64,
    /// Time for which anybody stood in line, and the sum of the times of all who did (s).
    pub time_with_line_s: f64,
    pub agent_seconds_in_line: f64,
    pub most_in_line: u32,
}

/// Record of a till so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TillRecord {
    pub served: u32,
    /// Time of serving, and of waiting for an agent on the way to the till (s).
    pub busy_s: f64,
    pub approached_s: f64,
    /// Time without an agent (s), and the share of it in which others stood in line for this till.
    pub idle_s: f64,
    pub idle_lined_s: f64,
    /// Times of serving and of an agent on the way while others stood in line for this till (s).
    pub busy_lined_s: f64,
    pub approached_lined_s: f64,
}

/// Agent that a free till could serve next.
#[derive(Clone, Copy, Debug)]
struct NextClient {
    rank: f64,
    joined: f64,
    agent: u32,
    /// Slot of the till.
    till: u32,
}

/// Figures of a service.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ServiceStatistics {
    /// Name of the service.
    pub name: String,
    /// Agents that were served, or are now.
    pub served: u32,
    /// Agents that went away at the end of a line, as it was full or too long for them.
    pub balked: u32,
    /// Agents that left a line before they were served.
    pub gave_up: u32,
    /// Time from joining a line until service begins: mean (s).
    pub wait_mean_s: f64,
    /// 90th percentile of these times, rounded up to 0.5 s.
    pub wait_p90_s: f64,
    /// Longest of these times (s).
    pub wait_max_s: f64,
    /// Agents in line: mean over time.
    pub line_mean: f64,
    /// Most agents in line at a time.
    pub line_max: u32,
    /// Agents in line now.
    pub line_now: u32,
    /// Share of the time of tills for which others stand in line, in which an agent is served.
    pub busy_while_waiting: f64,
    /// Share of that time in which an agent is served or on the way to the till.
    pub taken_while_waiting: f64,
    /// Figures of each till.
    pub tills: Vec<TillStatistics>,
}

/// Figures of a till.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TillStatistics {
    /// Agents that were served, or are now.
    pub served: u32,
    /// Time of serving (s).
    pub busy_s: f64,
    /// Time in which an agent was on the way to it (s).
    pub approached_s: f64,
    /// Time without an agent (s).
    pub idle_s: f64,
    /// Time without an agent while others stood in line for it (s).
    pub idle_while_waiting_s: f64,
}

/// Figures of a group's source.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SourceStatistics {
    /// Name of the group.
    pub name: String,
    /// Entries of agents after the start.
    pub entered: u32,
    /// Agents that are there now.
    pub present: u32,
    /// Entries put off as there was no room, or all agents of the group were present; tried again twice a second.
    pub refused: u32,
}

impl ServiceRecord {
    pub fn new(num_tills: usize) -> Self {
        Self { tills: vec![TillRecord::default(); num_tills], waits: vec![0; CLASSES], ..Self::default() }
    }

    /// True for a record that can be one of a service with so many tills.
    pub fn is_sound(&self, num_tills: usize) -> bool {
        let is_time = |t: &f64| (0.0..1e12).contains(t);
        let of_tills = |t: &TillRecord| {
            [t.busy_s, t.approached_s, t.idle_s, t.idle_lined_s, t.busy_lined_s, t.approached_lined_s]
                .iter()
                .all(is_time)
                && t.served < u32::MAX / 2
        };
        let counts = [self.balked, self.gave_up, self.most_in_line];
        self.tills.len() == num_tills
            && self.tills.iter().all(of_tills)
            && self.waits.len() == CLASSES
            && self.waits.iter().chain(&counts).all(|n| *n < u32::MAX / 2)
            && [self.wait_sum_s, self.longest_s, self.time_with_line_s, self.agent_seconds_in_line].iter().all(is_time)
    }

    fn add_wait(&mut self, wait_s: f64) {
        self.waits[((wait_s / CLASS_S).ceil() as usize).min(CLASSES - 1)] += 1;
        self.wait_sum_s += wait_s;
        self.longest_s = self.longest_s.max(wait_s);
    }

    /// Upper limit of the class of a percentile (s).
    fn wait_at(&self, share: f64) -> f64 {
        let num: u32 = self.waits.iter().sum();
        let rank = ((f64::from(num) * share).ceil() as u32).max(1);
        let mut counted = 0;
        let class = self.waits.iter().position(|n| {
            counted += n;
            counted >= rank
        });
        class.map_or(0.0, |class| (class as f64 * CLASS_S).min(self.longest_s))
    }
}

impl Scenario {
    /// Records of all services, before any agent has come.
    pub(super) fn service_records(&self) -> Vec<ServiceRecord> {
        let tills = self.services.iter().map(|service| self.places[usize::from(service.tills)].slots);
        tills.map(|[first, last]| ServiceRecord::new((last - first) as usize)).collect()
    }
}

impl AgentBrains {
    /// Counts what tills and lines have done up to a time (s).
    pub(super) fn account_services(&mut self, now: f64) {
        let past = now - self.now;
        if past <= 0.0 || self.services.is_empty() {
            return;
        }
        let mut services = std::mem::take(&mut self.services);
        for (table, record) in self.scenario.services.iter().zip(&mut services) {
            let line = |place: &u16| self.num_in_line(*place);
            let all: u32 = table.lines.iter().map(line).sum();
            record.time_with_line_s += if all > 0 { past } else { 0.0 };
            record.agent_seconds_in_line += past * f64::from(all);
            record.most_in_line = record.most_in_line.max(all);
            let [first, last] = self.scenario.places[usize::from(table.tills)].slots;
            for (n, (till, slot)) in record.tills.iter_mut().zip(first..last).enumerate() {
                let for_it = if table.apart { table.lines.get(n).map_or(0, line) } else { all };
                let lined = if for_it > 0 { past } else { 0.0 };
                let (time_s, lined_s) = match self.brains.get(self.holders[slot as usize] as usize) {
                    None => (&mut till.idle_s, &mut till.idle_lined_s),
                    Some(brain) if brain.phase == ActionPhase::Standing => (&mut till.busy_s, &mut till.busy_lined_s),
                    Some(_) => (&mut till.approached_s, &mut till.approached_lined_s),
                };
                (*time_s, *lined_s) = (*time_s + past, *lined_s + lined);
            }
        }
        self.services = services;
    }

    /// Number of agents that stand in the line of a place, or move up in it.
    fn num_in_line(&self, place: u16) -> u32 {
        let [first, last] = self.scenario.places[usize::from(place)].slots;
        let held = (first..last).filter_map(|slot| self.brains.get(self.holders[slot as usize] as usize));
        held.filter(|brain| brain.aim == NONE).count() as u32
    }

    /// Line that an agent joins, or in which it stands.
    pub(super) fn choose_line(&self, stage: &impl ScenarioStage, agent: u32, service: u16) -> Option<u16> {
        let table = &self.scenario.services[usize::from(service)];
        let held = self.scenario.slots.get(self.brains[agent as usize].slot as usize).map(|slot| slot.place);
        if let Some(line) = held.filter(|place| table.lines.contains(place)) {
            return Some(line);
        }
        let at = stage.position(agent)?;
        let length = |line: u16| {
            let [first, last] = self.scenario.places[usize::from(line)].slots;
            let in_line = (first..last).filter(|slot| self.holders[*slot as usize] != NONE).count();
            let number = table.lines.iter().position(|other| *other == line).filter(|_| table.apart);
            let till = number.map(|n| self.scenario.places[usize::from(table.tills)].slots[0] as usize + n);
            in_line + usize::from(till.is_some_and(|till| self.holders[till] != NONE))
        };
        let far = |line: u16| {
            let end = self.free_slot(line, None);
            end.map_or(f32::INFINITY, |slot| self.scenario.slots[slot as usize].at.distance(at))
        };
        let count = |line: u16| match table.join {
            LineChoice::Shortest => length(line),
            LineChoice::Nearest => 0,
        };
        let key = |line: &u16| (far(*line) == f32::INFINITY, count(*line), far(*line));
        table.lines.iter().copied().min_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2))
        })
    }

    /// Lets an agent join a line at its end; `None` where it goes away.
    pub(super) fn join_line(
        &mut self,
        stage: &mut impl ScenarioStage,
        on: Occasion,
        line: u16,
        service: u16,
    ) -> Result<Option<u32>> {
        let agent = on.agent;
        let table = &self.scenario.services[usize::from(service)];
        let (balk, patience) = (table.balk, table.patience);
        let is_in_line =
            self.scenario.slots.get(self.brains[agent as usize].slot as usize).is_some_and(|s| s.place == line);
        if is_in_line {
            return Ok(Some(self.brains[agent as usize].slot));
        }
        let here = Occasion { agent, context: EventContext { place: line, ..on.context } };
        let goes_away = balk.is_some_and(|balk| self.evaluate_predicate(stage, here, balk));
        let slot = if goes_away { None } else { self.claim_slot(stage, agent, line)? };
        if slot.is_none() {
            self.services[usize::from(service)].balked += 1;
            self.end_list(agent, trigger::FULL, line);
            return Ok(None);
        }
        self.engagements[agent as usize].joined = self.now;
        if let Some(time) = patience {
            let chances = [self.draw_chance(agent), self.draw_chance(agent)];
            self.brains[agent as usize].gives_up_at_s = self.now + time.time_at(chances);
        }
        Ok(slot)
    }

    /// Lets the list of actions of an agent end, with a stimulus for the reason.
    fn end_list(&mut self, agent: u32, why: u16, place: u16) {
        self.push_stimulus(agent, why, place_context(place));
        let mut action = self.brains[agent as usize].action;
        while !matches!(self.action(action + 1), CompiledAction::End) {
            action += 1;
        }
        self.brains[agent as usize].action = action;
    }

    /// Lets an agent leave its line where its patience is over; true where it has.
    pub(super) fn lose_patience(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<bool> {
        let brain = self.brains[agent as usize];
        if brain.action == NONE || brain.gives_up_at_s > self.now {
            return Ok(false);
        }
        let CompiledAction::Primitive { claims: ActionClaim::Serve(service), .. } = self.action(brain.action) else {
            return Ok(false);
        };
        self.services[usize::from(service)].gave_up += 1;
        let line = self.scenario.slots.get(brain.slot as usize).map_or(NO_NUMBER, |slot| slot.place);
        self.release_slot(stage, agent)?;
        self.engagements[agent as usize].joined = f64::INFINITY;
        stage.show_activity(agent, None, None);
        stage.set_speed(agent, brain.speed)?;
        self.end_list(agent, trigger::GIVES_UP, line);
        self.next_action(stage, agent)?;
        Ok(true)
    }

    /// Calls agents to the free tills of a service.
    pub(super) fn call_next(&mut self, stage: &mut impl ScenarioStage, service: u16) -> Result<()> {
        while let Some(NextClient { agent, till, .. }) = self.find_next(stage, service) {
            self.mark_touched(agent);
            self.take_slot(stage, agent, till)?;
            self.next_action(stage, agent)?;
        }
        Ok(())
    }

    /// Next agent that a free till of a service serves.
    fn find_next(&mut self, stage: &impl ScenarioStage, service: u16) -> Option<NextClient> {
        let scenario = self.scenario.clone();
        let table = &scenario.services[usize::from(service)];
        let [first, last] = scenario.places[usize::from(table.tills)].slots;
        let mut best: Option<NextClient> = None;
        for (n, line) in table.lines.iter().enumerate() {
            let tills = if table.apart { first + n as u32..(first + n as u32 + 1).min(last) } else { first..last };
            if tills.clone().all(|slot| self.holders[slot as usize] != NONE) {
                continue;
            }
            let [head, end] = scenario.places[usize::from(*line)].slots;
            for slot in head..end {
                let agent = self.holders[slot as usize];
                if agent == NONE {
                    break;
                }
                let Some(at) = stage.position(agent).filter(|_| self.is_ready(agent)) else { continue };
                let rank = table.priority.map_or(0.0, |program| {
                    -self.evaluate_program(stage, Occasion { agent, context: EventContext::default() }, program)
                });
                let joined = self.engagements[agent as usize].joined;
                let is_before = |b: NextClient| {
                    rank.total_cmp(&b.rank).then(joined.total_cmp(&b.joined)).then(agent.cmp(&b.agent)).is_lt()
                };
                let is_better = best.is_none_or(is_before);
                if is_better {
                    let far = |slot: &u32| scenario.slots[*slot as usize].at.distance_squared(at);
                    let free = tills.clone().filter(|slot| self.holders[*slot as usize] == NONE);
                    let till = free.min_by(|a, b| far(a).total_cmp(&far(b)))?;
                    best = Some(NextClient { rank, joined, agent, till });
                }
                if table.priority.is_none() {
                    break;
                }
            }
        }
        best
    }

    /// True for an agent in line that can go on to a till now, also while it moves up.
    fn is_ready(&self, agent: u32) -> bool {
        let brain = &self.brains[agent as usize];
        let serves = |a: CompiledAction| matches!(a, CompiledAction::Primitive { claims: ActionClaim::Serve(_), .. });
        brain.aim == NONE && brain.action != NONE && serves(self.action(brain.action))
    }

    /// Records that the service of an agent at its till begins.
    pub(super) fn begin_service(&mut self, agent: u32, service: u16) {
        let (slot, own) = (self.brains[agent as usize].slot, &mut self.engagements[agent as usize]);
        let tills = self.scenario.places[usize::from(self.scenario.services[usize::from(service)].tills)].slots;
        if own.joined == f64::INFINITY || !(tills[0]..tills[1]).contains(&slot) {
            return;
        }
        let wait_s = self.now - std::mem::replace(&mut own.joined, f64::INFINITY);
        (own.waited, own.served_by, own.served) = (wait_s, service, own.served.wrapping_add(1));
        let record = &mut self.services[usize::from(service)];
        record.tills[(slot - tills[0]) as usize].served += 1;
        record.add_wait(wait_s);
    }

    /// Time of a service that is drawn for an agent (s).
    pub(super) fn draw_service_time(&mut self, agent: u32, service: u16) -> f64 {
        let chances = [self.draw_chance(agent), self.draw_chance(agent)];
        self.scenario.services[usize::from(service)].time.time_at(chances)
    }

    /// Figures of all sources.
    pub fn source_statistics(&self) -> Vec<SourceStatistics> {
        let groups = self.scenario.groups.iter().enumerate().filter(|(_, group)| !group.rates.is_empty());
        let present = |[first, last]: [u32; 2]| {
            self.brains[first as usize..last as usize].iter().filter(|brain| brain.is_there).count() as u32
        };
        groups
            .map(|(g, group)| SourceStatistics {
                name: self.scenario.names.groups.0[g].clone(),
                entered: self.entered[g] - group.num_at_start + self.reused[g],
                present: present(group.agents),
                refused: self.refused[g],
            })
            .collect()
    }

    /// Figures of all services up to a time not before the last event (s).
    pub fn service_statistics(&self, time_s: f64) -> Vec<ServiceStatistics> {
        let mut counted = self.clone();
        counted.account_services(time_s);
        let all = counted.scenario.names.services.0.iter().zip(&counted.services).zip(&counted.scenario.services);
        all.map(|((name, record), table)| {
            let sum = |of: fn(&TillRecord) -> f64| record.tills.iter().map(of).sum::<f64>();
            let (busy, approached) = (sum(|t| t.busy_lined_s), sum(|t| t.approached_lined_s));
            let lined = busy + approached + sum(|t| t.idle_lined_s);
            let share = |time: f64| if lined > 0.0 { time / lined } else { 1.0 };
            let num: u32 = record.waits.iter().sum();
            ServiceStatistics {
                name: name.clone(),
                served: record.tills.iter().map(|t| t.served).sum(),
                balked: record.balked,
                gave_up: record.gave_up,
                wait_mean_s: record.wait_sum_s / f64::from(num.max(1)),
                wait_p90_s: record.wait_at(0.9),
                wait_max_s: record.longest_s,
                line_mean: record.agent_seconds_in_line / time_s.max(1e-9),
                line_max: record.most_in_line,
                line_now: table.lines.iter().map(|line| counted.num_in_line(*line)).sum(),
                busy_while_waiting: share(busy),
                taken_while_waiting: share(busy + approached),
                tills: record.tills.iter().map(TillStatistics::from_record).collect(),
            }
        })
        .collect()
    }
}

impl TillStatistics {
    fn from_record(record: &TillRecord) -> Self {
        let TillRecord { served, busy_s, approached_s, idle_s, idle_lined_s, .. } = *record;
        Self { served, busy_s, approached_s, idle_s, idle_while_waiting_s: idle_lined_s }
    }
}
