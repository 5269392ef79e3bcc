//! Measures agents: overlaps, progress, flow, lanes.

use crate::overlap::OverlapMeter;
use crate::run::figures::{AgentFigures, ThingFigures};
use crate::run::groups::agents_crowd;
use crate::run::meter::{AgentSample, GateMeter, LaneMeter, ProgressMeter};
use glam::{Vec2, Vec3};
use throng_core::Joint;
use throng_crowd::{AgentStatus, AtEnd, EventCounts, Space};
use throng_simulation::agents::{SceneAgents, ground_coordinates};
use throng_simulation::scene::SceneMeasureConfig;
use throng_simulation::{AnyCharacterGroup, Simulation};

/// Figures of all agents until now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AgentsSummary {
    /// Agents that have not left.
    pub present: usize,
    /// Pairs that overlap by more than 1 mm now.
    pub overlaps: u64,
    /// Deepest overlap so far; zero or less if no agents have touched (m).
    pub deepest_m: f64,
    /// Mean speed toward the goal so far, along the planned route, of agents that had not arrived (m/s).
    pub progress_mps: f64,
    /// Agents that have reached their goal.
    pub arrived: usize,
    /// Agents that stayed within half a metre for 10 s on their way, or did not come half a metre nearer to their goal in 20 s.
    pub stuck: usize,
}

/// Applies an expression to the agents of a group, on the ground or in the air, and to their watch.
macro_rules! with_agents {
    ($watch:expr, $character_group:expr, |$w:ident, $agents:ident| $work:expr) => {
        match ($watch, $character_group) {
            (AnyAgentWatch::Ground($w), AnyCharacterGroup::Ground($agents)) => Some($work),
            (AnyAgentWatch::Air($w), AnyCharacterGroup::Air($agents)) => Some($work),
            _ => None,
        }
    };
}

/// Measures agents of a simulation, on the ground or in the air.
#[derive(Clone, Debug)]
pub struct AgentsMeter {
    /// Number of their character group.
    character_group: usize,
    /// Number of the first agent among the characters of the simulation.
    first: usize,
    agents: AnyAgentWatch,
}

#[derive(Clone, Debug)]
enum AnyAgentWatch {
    Ground(AgentWatch<Vec2>),
    Air(AgentWatch<Vec3>),
}

impl AgentsMeter {
    /// A meter without observations; none for a simulation without agents.
    pub fn new(sim: &Simulation) -> Option<Self> {
        Self::of_groups(sim, |_| true)
    }

    /// Meter of the agents of some groups, by their number; none without agents.
    pub(super) fn of_groups(sim: &Simulation, is_seen: impl Fn(usize) -> bool) -> Option<Self> {
        let character_group = sim.character_groups().iter().position(|c| agents_crowd(c).is_some())?;
        let groups = || sim.groups().iter().enumerate().filter(|(_, g)| g.character_group == character_group);
        let first = groups().next()?.1.characters.start;
        let seen = groups().filter(|(number, _)| is_seen(*number)).flat_map(|(_, g)| g.characters.clone());
        let agents: Vec<usize> = seen.map(|c| c - first).collect();
        if agents.is_empty() {
            return None;
        }
        let config = &sim.scene().measure;
        let agents = match &sim.character_groups()[character_group] {
            AnyCharacterGroup::Ground(all) => AnyAgentWatch::Ground(AgentWatch::new(all, config, agents)),
            AnyCharacterGroup::Air(all) => AnyAgentWatch::Air(AgentWatch::new(all, config, agents)),
            _ => return None,
        };
        Some(Self { character_group, first, agents })
    }

    /// Observes all agents; to be called at most 30 times a simulated second.
    pub fn observe(&mut self, sim: &Simulation) -> AgentsSummary {
        let group = &sim.character_groups()[self.character_group];
        with_agents!(&mut self.agents, group, |w, all| w.summarize(all)).unwrap_or_default()
    }

    /// Measures the distances of bodies from their discs, after a step.
    pub(super) fn observe_bodies(&mut self, sim: &Simulation) {
        let group = &sim.character_groups()[self.character_group];
        with_agents!(&mut self.agents, group, |w, all| w.observe_bodies(sim, self.first, all));
    }

    /// Number of stuck agents, and the figures.
    ///
    /// - `is_timed`: the wall times of the simulation are attributed to these agents.
    pub(super) fn figures(&self, sim: &Simulation, seconds: f64, is_timed: bool) -> Option<(usize, AgentFigures)> {
        let busy_s = sim.busy_s().get(self.character_group).filter(|_| is_timed).map(|&s| (s, s));
        let group = &sim.character_groups()[self.character_group];
        with_agents!(&self.agents, group, |w, all| (w.progress.stuck(), w.figures(all, seconds, busy_s)))
    }
}

/// Measures some agents thirty times a second.
#[derive(Clone, Debug)]
pub(in crate::run) struct AgentWatch<V> {
    /// Numbers of the agents in the crowd.
    agents: Vec<usize>,
    overlaps: OverlapMeter,
    pub progress: ProgressMeter<V>,
    gate: Option<GateMeter>,
    lanes: Option<LaneMeter>,
    /// Flags of the scene's groups that go along the direction of lanes.
    goes_along: Vec<bool>,
    places: Vec<(V, f32)>,
    /// Number of samples.
    num_samples: u64,
    hips_off_max_m: Option<f64>,
}

impl<V: Space> AgentWatch<V> {
    pub fn new(agents: &SceneAgents<V>, config: &SceneMeasureConfig, numbers: Vec<usize>) -> Self {
        Self {
            agents: numbers,
            overlaps: OverlapMeter::default(),
            progress: ProgressMeter::default(),
            gate: config.gate.as_ref().map(GateMeter::new),
            lanes: config.lanes.as_ref().map(LaneMeter::new),
            goes_along: config.lanes.as_ref().map_or(Vec::new(), |l| goes_along(agents, l.along.into())),
            places: Vec::new(),
            num_samples: 0,
            hips_off_max_m: None,
        }
    }

    /// Observes all of them.
    pub fn observe(&mut self, agents: &SceneAgents<V>) {
        let (layout, time_s) = (agents.layout(), agents.crowd().time_s());
        let at = |m: usize| agents.position(m, time_s);
        let all = || self.agents.iter().copied();
        self.places.clear();
        self.places.extend(all().filter_map(|m| Some((at(m)?, layout.setup.agents[m].radius))));
        self.overlaps.observe_discs(&self.places);
        let (walls, doors) = layout.walls_and_doors();
        self.overlaps.observe_solids(&self.places, walls);
        for (_, door) in doors.chunks(1).enumerate().filter(|(d, _)| !agents.is_open(*d)) {
            self.overlaps.observe_solids(&self.places, door);
        }
        self.num_samples += 1;
        let sight = |m: usize| AgentSample {
            at: at(m),
            path: &layout.paths[m],
            path_number: agents.num_orders(m),
            remaining_m: agents.id(m).and_then(|id| agents.crowd().distance_left(id)).unwrap_or(0.0),
            arrival_m: layout.arrivals[m],
            is_loop: agents.num_orders(m) == 0 && layout.at_end(m) == Some(AtEnd::Again),
            has_settled: agents.id(m).is_some_and(|id| agents.crowd().status(id).ok() == Some(AgentStatus::Arrived)),
            waits: agents.id(m).is_some_and(|id| agents.crowd().waits(id)),
        };
        self.progress.observe(time_s, all().map(sight));
        if let Some(gate) = &mut self.gate {
            gate.observe(time_s, all().map(|m| at(m).map(ground_coordinates)));
        }
        if let Some(lanes) = &mut self.lanes {
            let seen = all().filter_map(|m| Some((ground_coordinates(at(m)?), self.goes_along[layout.groups[m]])));
            lanes.observe(time_s, &seen.collect::<Vec<_>>());
        }
    }

    /// Observes all of them, and returns the figures until now.
    fn summarize(&mut self, agents: &SceneAgents<V>) -> AgentsSummary {
        let before = self.overlaps.over_1mm;
        self.observe(agents);
        AgentsSummary {
            present: self.places.len(),
            overlaps: self.overlaps.over_1mm - before,
            deepest_m: self.overlaps.deepest_m,
            progress_mps: self.progress.progress_mps(),
            arrived: self.progress.arrived(),
            stuck: self.progress.stuck(),
        }
    }

    /// The figures.
    ///
    /// - `busy_s`: wall time and running time of the engine, if they are measured (s).
    pub fn figures(&self, agents: &SceneAgents<V>, seconds: f64, busy_s: Option<(f64, f64)>) -> AgentFigures {
        let n = self.agents.len();
        let of_all = n == agents.num_agents();
        let (counts, handled) = (agents.crowd().counts(), agents.handling_counts());
        let frames = self.overlaps.agent_frames.max(1) as f64;
        // Agents that have left cost nothing any more.
        let present_s = frames * seconds / self.num_samples.max(1) as f64;
        let a_second = |count: u64| of_all.then_some(count as f64 / present_s);
        let speeds = self.agents.iter().map(|&m| f64::from(agents.layout().setup.agents[m].speed));
        let knows = |&&m: &&usize| agents.num_known_events(m) > 0;
        AgentFigures {
            wall_s_per_simulated_s: busy_s.map(|b| b.0 / seconds),
            setup_s: None,
            us_range: None,
            us_per_agent_second: busy_s.map(|b| 1e6 * b.1 / present_s),
            events_per_agent_second: a_second(num_events(&counts)),
            crossings_per_agent_second: a_second(counts.entering + counts.leaving).filter(|c| *c > 0.0),
            decisions_per_agent_second: a_second(counts.decisions),
            overlap_over_1mm_fraction: self.overlaps.over_1mm as f64 / frames,
            overlap_over_1cm_fraction: self.overlaps.over_1cm as f64 / frames,
            max_overlap_m: self.overlaps.deepest_m,
            progress_mps: self.progress.progress_mps(),
            progress_by_10s_mps: self.progress.progress_by_10s_mps(),
            stuck_at_end: self.progress.stuck_at(agents.crowd().time_s()),
            desired_mps: speeds.sum::<f64>() / n as f64,
            arrived: self.progress.arrived(),
            reached: self.progress.reached(),
            stopped_share: self.progress.stopped_share(),
            informed: agents.brains().is_some_and(|m| m.has_events()).then(|| self.agents.iter().filter(knows).count()),
            things: (agents.things().len() > 0).then(|| ThingFigures {
                things_taken: handled.taken,
                things_put: handled.put,
                things_out_of_reach: handled.missed,
                hand_off_p95_m: handled.palm_error_m(0.95),
                hand_off_max_m: handled.palm_error_m(1.0),
            }),
            lane_order: self.lanes.as_ref().and_then(LaneMeter::final_order),
            flow: self.gate.as_ref().map(GateMeter::flow),
            hips_off_max_m: self.hips_off_max_m,
        }
    }

    /// Measures the distances over ground of bodies from their discs.
    fn observe_bodies(&mut self, sim: &Simulation, first: usize, agents: &SceneAgents<V>) {
        for &m in &self.agents {
            let Some(pose) = sim.joint_positions(first + m) else { continue };
            let Some(at) = agents.position(m, agents.crowd().time_s()) else { continue };
            let hips = pose[Joint::Hips.index()];
            let off = f64::from(ground_coordinates(at).distance(Vec2::new(hips.x, hips.z)));
            self.hips_off_max_m = Some(self.hips_off_max_m.map_or(off, |most| most.max(off)));
        }
    }
}

/// Number of events of a crowd; in a stepped engine, the number of decisions.
fn num_events(c: &EventCounts) -> u64 {
    if c.steps > 0 {
        return c.decisions;
    }
    c.resetting + c.colliding + c.meeting + c.entering + c.leaving + c.contacting + c.separating
}

/// Flags of the groups whose agents on the whole go along a direction.
fn goes_along<V: Space>(agents: &SceneAgents<V>, along: Vec2) -> Vec<bool> {
    let layout = agents.layout();
    let mut sums = vec![0.0; layout.groups.iter().max().map_or(0, |g| g + 1)];
    for (path, &group) in layout.paths.iter().zip(&layout.groups) {
        sums[group] += (ground_coordinates(path[path.len() - 1]) - ground_coordinates(path[0])).dot(along);
    }
    sums.iter().map(|s| *s > 0.0).collect()
}
