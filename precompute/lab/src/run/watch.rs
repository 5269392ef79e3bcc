//! Looks at some groups of a simulation after every step.

use super::figures::{AgentFigures, BlowFigures, Figures, InhabitedFigures, PathFigures};
use super::meter::{FeetMeter, GateMeter, LaneMeter, OverlapMeter, ProgressMeter, Sight, TrunkMeter};
use super::report::{LOOK_HZ, geometry};
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;
use throng_bake::environment::{Body, PlacedGeometry};
use throng_motion::error::BuildError;
use throng_runtime::crowd::{AtEnd, Counts, Space};
use throng_runtime::simulation::agents::{Agents, plan};
use throng_runtime::simulation::scene::{MeasureConfig, engine};
use throng_runtime::simulation::{GroupCast, Motion, Simulation};
use throng_runtime::sparring::Tally;
use throng_runtime::world::inhabitants::Doing;
use throng_runtime::{Joint, NUM_JOINTS};

/// Time between looks at who is in whom or in what (s).
pub(super) const LOOK_S: f64 = 0.1;
/// Time that characters have to come together before their greatest distance counts (s).
const COMING_S: f64 = 5.0;
/// Deeper than this in a unit is a penetration (m).
const PENETRATION_M: f32 = 0.08;
/// Who wishes to go somewhere and stays within `STUCK_M` for this long is stuck (s).
const STUCK_S: f64 = 30.0;
/// See [`STUCK_S`] (m).
const STUCK_M: f32 = 0.5;
/// Legs and the joints of their knees.
const KNEES: [[Joint; 3]; 2] =
    [[Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot], [Joint::RightThigh, Joint::RightShin, Joint::RightFoot]];

/// All that is measured of some groups.
pub(super) struct Watch {
    /// Their numbers in the simulation.
    groups: Vec<usize>,
    feet: FeetMeter,
    fights: FightWatch,
    paths: PathWatch,
    worlds: Vec<WorldWatch>,
    agents: AgentsWatch,
}

/// Agents on the ground or in the air, if there are any.
#[derive(Clone, Debug)]
enum AgentsWatch {
    None,
    Ground(AgentWatch<Vec2>),
    Air(AgentWatch<Vec3>),
}

impl Watch {
    /// Nothing seen yet.
    pub fn new(sim: &Simulation, groups: &[usize]) -> Result<Self, BuildError> {
        let of = |cast: usize| groups.iter().copied().filter(|&g| sim.groups()[g].cast == cast).collect::<Vec<_>>();
        let mut watch = Self {
            groups: groups.to_vec(),
            feet: FeetMeter::new(sim.num_characters()),
            fights: FightWatch::default(),
            paths: PathWatch::default(),
            worlds: Vec::new(),
            agents: AgentsWatch::None,
        };
        let config = &sim.scene().measure;
        for (c, cast) in sim.casts().iter().enumerate().filter(|(c, _)| !of(*c).is_empty()) {
            let first = sim.groups().iter().find(|g| g.cast == c).map_or(0, |g| g.characters.start);
            let members = of(c).into_iter().flat_map(|g| sim.groups()[g].characters.clone());
            match cast {
                GroupCast::Patches(_) => watch.worlds.push(WorldWatch::new(sim, c, members.collect())?),
                GroupCast::Ground(a) => {
                    watch.agents =
                        AgentsWatch::Ground(AgentWatch::new(a, config, members.map(|m| m - first).collect()));
                }
                GroupCast::Air(a) => {
                    watch.agents = AgentsWatch::Air(AgentWatch::new(a, config, members.map(|m| m - first).collect()));
                }
                _ => {}
            }
        }
        Ok(watch)
    }

    /// Looks after a step.
    pub fn observe(&mut self, sim: &Simulation, dt_s: f32, step: usize, hz: f64) {
        let due = |every_s: f64| step.is_multiple_of(((every_s * hz).round() as usize).max(1));
        self.feet.observe(dt_s, sim, self.groups.iter().flat_map(|&g| sim.groups()[g].characters.clone()));
        self.fights.time_s += f64::from(dt_s);
        for &g in &self.groups {
            let group = &sim.groups()[g];
            for who in group.characters.clone() {
                match sim.locate(who) {
                    (GroupCast::Policy(_) | GroupCast::Sparring(_), _) => self.fights.observe(sim, who),
                    (GroupCast::Paths(p), member) => self.paths.observe(sim, who, p.speed(member), p.ground(), dt_s),
                    _ => {}
                }
            }
        }
        if due(LOOK_S) {
            self.worlds.iter_mut().for_each(|w| w.look(sim));
        }
        if due(1.0 / LOOK_HZ) {
            match (&mut self.agents, sim.casts().iter().find(|c| matches!(c, GroupCast::Ground(_) | GroupCast::Air(_))))
            {
                (AgentsWatch::Ground(w), Some(GroupCast::Ground(a))) => w.observe(a),
                (AgentsWatch::Air(w), Some(GroupCast::Air(a))) => w.observe(a),
                _ => {}
            }
        }
        if let (AgentsWatch::Ground(w), Some(GroupCast::Ground(a))) =
            (&mut self.agents, sim.casts().iter().find(|c| matches!(c, GroupCast::Ground(_))))
        {
            w.observe_bodies(sim, a);
        }
    }

    /// Where things were seen that should not be: time, character, what (s).
    pub fn faults(&self) -> impl Iterator<Item = &(f32, usize, String)> {
        self.worlds.iter().flat_map(|w| &w.faults)
    }

    /// What was measured.
    ///
    /// - `rate`: steps of everybody a second, for the total alone.
    pub fn figures(&self, sim: &Simulation, seconds: f64, rate: Option<f64>) -> Figures {
        let number = |of: &dyn Fn(Motion, &GroupCast) -> bool| {
            let groups = self.groups.iter().map(|&g| &sim.groups()[g]);
            let num: usize = groups.filter(|g| of(g.motion, &sim.casts()[g.cast])).map(|g| g.characters.len()).sum();
            (num > 0).then_some(num)
        };
        let is_agent = |_: Motion, cast: &GroupCast| matches!(cast, GroupCast::Ground(_) | GroupCast::Air(_));
        let characters = number(&|m, c| !is_agent(m, c));
        let has_feet = self.feet.has_seen_bodies();
        let mut figures = Figures {
            characters,
            agents: number(&is_agent),
            simulated_s: seconds,
            steps_per_second: rate.filter(|_| characters.is_some()),
            blows: number(&|m, _| matches!(m, Motion::Policy | Motion::Sparring))
                .map(|n| self.fights.figures(sim, &self.groups, n, seconds)),
            world: (!self.worlds.is_empty()).then(|| WorldWatch::figures(&self.worlds, sim, seconds)),
            paths: number(&|_, c| matches!(c, GroupCast::Paths(_))).map(|_| self.paths.figures()),
            foot_slip_mean_mps: has_feet.then(|| self.feet.mean_mps()),
            foot_slip_p95_mps: has_feet.then(|| self.feet.p95_mps()),
            ..Figures::default()
        };
        let mut stuck = (!self.worlds.is_empty()).then(|| self.worlds.iter().map(|w| w.stuck.len()).sum());
        let cast = sim.casts().iter().position(|c| matches!(c, GroupCast::Ground(_) | GroupCast::Air(_)));
        let wall = |c: usize| rate.and_then(|_| sim.busy_s().get(c)).map(|&s| (s, s));
        let of_agents = match (&self.agents, cast.map(|c| (c, &sim.casts()[c]))) {
            (AgentsWatch::Ground(w), Some((c, GroupCast::Ground(a)))) => {
                Some((w.stuck(), w.figures(a, seconds, wall(c))))
            }
            (AgentsWatch::Air(w), Some((c, GroupCast::Air(a)))) => Some((w.stuck(), w.figures(a, seconds, wall(c)))),
            _ => None,
        };
        if let Some((num, crowd)) = of_agents {
            stuck = Some(stuck.unwrap_or(0) + num);
            figures.engine = Some(engine::name(sim.scene().agents.engine).into());
            figures.crowd = Some(crowd);
        }
        figures.stuck = stuck;
        figures
    }
}

/// How far characters are from what they strike at.
#[derive(Default)]
struct FightWatch {
    /// As the characters' own clocks count (s).
    time_s: f64,
    distance_sum: f64,
    distances: u64,
    distance_max: Option<f32>,
}

impl FightWatch {
    fn observe(&mut self, sim: &Simulation, who: usize) {
        let (Some(root), Some(target)) = (sim.root(who), sim.target(who)) else { return };
        let distance = (root.x - target.x).hypot(root.z - target.z);
        self.distance_sum += f64::from(distance);
        self.distances += 1;
        if self.time_s > COMING_S {
            self.distance_max = Some(self.distance_max.map_or(distance, |most| most.max(distance)));
        }
    }

    fn figures(&self, sim: &Simulation, groups: &[usize], n: usize, seconds: f64) -> BlowFigures {
        let (mut blows, mut penetration, mut deep_s, mut num_pairs) = (Tally::default(), 0.0f32, 0.0, 0);
        for &g in groups {
            match &sim.casts()[sim.groups()[g].cast] {
                GroupCast::Sparring(s) => {
                    let f = s.sparring().figures();
                    blows += f.blows;
                    penetration = penetration.max(f.max_penetration_m);
                    deep_s += f64::from(f.deep_s);
                    num_pairs += s.sparring().num_pairs();
                }
                GroupCast::Policy(p) => blows += p.practice().figures().blows,
                _ => {}
            }
        }
        let share = |count: u32| f64::from(count) / f64::from(blows.thrown.max(1));
        BlowFigures {
            hits_per_minute: f64::from(blows.landed) * 60.0 / seconds / n as f64,
            landed_fraction: share(blows.landed),
            blocked_fraction: share(blows.blocked),
            thrown: blows.thrown,
            max_penetration_m: f64::from(penetration),
            deep_fraction: deep_s / (seconds * num_pairs.max(1) as f64),
            distance_mean_m: self.distance_sum / self.distances.max(1) as f64,
            distance_max_m: self.distance_max.map(f64::from),
        }
    }
}

/// Speeds, knees and feet of characters on random paths.
#[derive(Default)]
struct PathWatch {
    speed_sum: f64,
    looks: u64,
    figures: PathFigures,
    /// Angles at the knees at the last step, by the character's number.
    knees: Vec<[f32; 2]>,
}

impl PathWatch {
    fn observe(
        &mut self,
        sim: &Simulation,
        who: usize,
        speed: f32,
        ground: &throng_runtime::blend::HeightField,
        dt_s: f32,
    ) {
        let Some(pose) = sim.joint_positions(who) else { return };
        self.knees.resize(self.knees.len().max(who + 1), [0.0; 2]);
        let f = &mut self.figures;
        let now = knee_angles(&pose);
        let before = std::mem::replace(&mut self.knees[who], now);
        if dt_s > 0.0 {
            let rate = (0..2).map(|k| (now[k] - before[k]).abs() / dt_s).fold(0.0, f32::max);
            f.knee_rate_max_radps = f.knee_rate_max_radps.max(f64::from(rate));
        }
        let feet = [Joint::LeftFoot, Joint::LeftToe, Joint::RightFoot, Joint::RightToe].map(|j| pose[j.index()]);
        let below = feet.map(|p| ground.at(Vec2::new(p.x, p.z)).height - p.y).into_iter().fold(0.0, f32::max);
        f.below_ground_max_m = f.below_ground_max_m.max(f64::from(below));
        f.speed_max_mps = f.speed_max_mps.max(f64::from(speed));
        self.speed_sum += f64::from(speed);
        self.looks += 1;
    }

    fn figures(&self) -> PathFigures {
        PathFigures { speed_mean_mps: self.speed_sum / self.looks.max(1) as f64, ..self.figures.clone() }
    }
}

/// Angles at the knees; pi where a leg is straight (rad).
fn knee_angles(pose: &[Vec3; NUM_JOINTS]) -> [f32; 2] {
    KNEES.map(|leg| {
        let [hip, knee, ankle] = leg.map(|j| pose[j.index()]);
        (hip - knee).angle_between(ankle - knee)
    })
}

/// Where a character was when it last came forward.
#[derive(Clone, Copy, Debug)]
struct Progress {
    at: Vec3,
    since_s: f64,
}

/// Looks at some characters of one world every tenth of a second.
struct WorldWatch {
    cast: usize,
    /// Their numbers in the simulation.
    members: Vec<usize>,
    body: Body,
    geometry: PlacedGeometry,
    trunks: TrunkMeter,
    faults: Vec<(f32, usize, String)>,
    /// Who is in which unit now.
    inside: BTreeSet<(usize, usize)>,
    penetrations: u64,
    deepest_m: f32,
    progress: Vec<Progress>,
    stuck: BTreeSet<usize>,
    last: Vec<Vec3>,
    travelled_m: f64,
    looks: u64,
    waiting: u64,
}

impl WorldWatch {
    fn new(sim: &Simulation, cast: usize, members: Vec<usize>) -> Result<Self, BuildError> {
        let group = sim.groups().iter().find(|g| g.cast == cast).map_or(0, |g| g.number);
        let bundle = sim.compiled().bundle(group).map_err(super::report::fault)?;
        Ok(Self {
            cast,
            body: Body::new(bundle.skeleton()),
            geometry: geometry(sim.compiled(), group)?,
            trunks: TrunkMeter::default(),
            faults: Vec::new(),
            inside: BTreeSet::new(),
            penetrations: 0,
            deepest_m: 0.0,
            progress: vec![Progress { at: Vec3::splat(f32::MAX), since_s: 0.0 }; members.len()],
            stuck: BTreeSet::new(),
            last: Vec::new(),
            travelled_m: 0.0,
            looks: 0,
            waiting: 0,
            members,
        })
    }

    fn look(&mut self, sim: &Simulation) {
        let GroupCast::Patches(people) = &sim.casts()[self.cast] else { return };
        let trunk = |p: [Vec3; NUM_JOINTS]| [p[Joint::Hips.index()], p[Joint::Neck.index()]];
        let trunks: Vec<[Vec3; 2]> =
            self.members.iter().filter_map(|&who| sim.joint_positions(who)).map(trunk).collect();
        self.trunks.observe(&trunks);
        self.look_around(sim);
        for (k, trunk) in trunks.iter().enumerate() {
            let (_, member) = sim.locate(self.members[k]);
            let (doing, progress) = (people.state(member).doing, &mut self.progress[k]);
            self.looks += 1;
            self.waiting += u64::from(doing == Doing::Waiting);
            let at_will = matches!(doing, Doing::Performing | Doing::Arrived);
            if at_will || (trunk[0] - progress.at).length() > STUCK_M {
                *progress = Progress { at: trunk[0], since_s: sim.time_s() };
            } else if sim.time_s() - progress.since_s > STUCK_S {
                self.stuck.insert(k);
            }
        }
        if !self.last.is_empty() {
            let way = trunks.iter().zip(&self.last).map(|(t, l)| f64::from((t[0] - *l).length()));
            self.travelled_m += way.sum::<f64>();
        }
        self.last = trunks.iter().map(|t| t[0]).collect();
    }

    /// Who is in which unit?
    fn look_around(&mut self, sim: &Simulation) {
        let mut inside = BTreeSet::new();
        for &who in &self.members {
            let (Some(root), Some(pose)) = (sim.root(who), sim.pose(who)) else { continue };
            let (turn, by) = (root.rotation(), root.translation());
            let transforms = std::array::from_fn(|j| (turn * pose[j].translation() + by, turn * pose[j].rotation()));
            let body = self.body.pose(&transforms, sim.contacts(who));
            let Some((unit, p)) = body.penetration_in(&self.geometry, PENETRATION_M) else { continue };
            self.deepest_m = self.deepest_m.max(p.depth);
            inside.insert((who, unit));
            if !self.inside.contains(&(who, unit)) {
                self.penetrations += 1;
                let what = format!("{} {:.2} m in unit {unit}", p.joint.name(), p.depth);
                self.faults.push((sim.time_s() as f32, who, what));
            }
        }
        self.inside = inside;
    }

    fn figures(all: &[Self], sim: &Simulation, seconds: f64) -> InhabitedFigures {
        let n: usize = all.iter().map(|w| w.members.len()).sum();
        let character_minutes = f64::from(seconds as f32) / 60.0 * n as f64;
        let mut f = InhabitedFigures::default();
        let (mut fulfilled, mut travelled_m, mut waiting, mut looks) = (0u32, 0.0, 0u64, 0u64);
        for w in all {
            let GroupCast::Patches(people) = &sim.casts()[w.cast] else { continue };
            let of = |who: &usize| people.state(sim.locate(*who).1).num_fulfilled;
            fulfilled += w.members.iter().map(of).sum::<u32>();
            (travelled_m, waiting, looks) = (travelled_m + w.travelled_m, waiting + w.waiting, looks + w.looks);
            f.character_overlaps += w.trunks.count();
            f.deepest_overlap_m = f.deepest_overlap_m.max(f64::from(w.trunks.deepest_m()));
            f.environment_penetrations += w.penetrations;
            f.deepest_penetration_m = f.deepest_penetration_m.max(f64::from(w.deepest_m));
        }
        f.fulfilled_per_minute = f64::from(fulfilled) / character_minutes;
        f.travelled_m_per_minute = travelled_m / character_minutes;
        f.waiting_fraction = waiting as f64 / looks.max(1) as f64;
        f
    }
}

/// What was measured of all agents until now.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AgentsNow {
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
    /// Agents that stayed within half a metre for 10 s on their way.
    pub stuck: usize,
}

/// Measures all agents of a simulation.
#[derive(Clone, Debug)]
pub struct AgentsMeter {
    watch: AgentsWatch,
    cast: usize,
}

impl AgentsMeter {
    /// Nothing seen yet; none for a simulation without agents.
    pub fn new(sim: &Simulation) -> Option<Self> {
        let (config, mut found) = (&sim.scene().measure, None);
        for (cast, kind) in sim.casts().iter().enumerate() {
            let watch = match kind {
                GroupCast::Ground(a) => AgentsWatch::Ground(AgentWatch::new(a, config, (0..a.num_agents()).collect())),
                GroupCast::Air(a) => AgentsWatch::Air(AgentWatch::new(a, config, (0..a.num_agents()).collect())),
                _ => continue,
            };
            found = Some(Self { watch, cast });
        }
        found
    }

    /// Looks at all agents, at most 30 times a simulated second.
    pub fn observe(&mut self, sim: &Simulation) -> AgentsNow {
        match (&mut self.watch, &sim.casts()[self.cast]) {
            (AgentsWatch::Ground(w), GroupCast::Ground(a)) => w.observe_now(a),
            (AgentsWatch::Air(w), GroupCast::Air(a)) => w.observe_now(a),
            _ => AgentsNow::default(),
        }
    }
}

/// Looks at some agents thirty times a second.
#[derive(Clone, Debug)]
pub(super) struct AgentWatch<V> {
    /// Their numbers in the crowd.
    members: Vec<usize>,
    overlaps: OverlapMeter,
    progress: ProgressMeter<V>,
    gate: Option<GateMeter>,
    lanes: Option<LaneMeter>,
    /// Of each group of the scene: it goes along the direction of lanes.
    goes_along: Vec<bool>,
    places: Vec<(V, f32)>,
    hips_off_max_m: Option<f64>,
}

impl<V: Space> AgentWatch<V> {
    pub fn new(agents: &Agents<V>, config: &MeasureConfig, members: Vec<usize>) -> Self {
        Self {
            members,
            overlaps: OverlapMeter::default(),
            progress: ProgressMeter::default(),
            gate: config.gate.as_ref().map(GateMeter::new),
            lanes: config.lanes.as_ref().map(LaneMeter::new),
            goes_along: config.lanes.as_ref().map_or(Vec::new(), |l| goes_along(agents, l.along.into())),
            places: Vec::new(),
            hips_off_max_m: None,
        }
    }

    /// Looks at all of them now.
    pub fn observe(&mut self, agents: &Agents<V>) {
        let (layout, time_s) = (agents.layout(), agents.crowd().now());
        let at = |m: usize| agents.position(m, time_s);
        let all = || self.members.iter().copied();
        self.places.clear();
        self.places.extend(all().filter_map(|m| Some((at(m)?, layout.setup.agents[m].radius))));
        self.overlaps.observe(&self.places);
        let sight = |m: usize| Sight {
            at: at(m),
            way: &layout.ways[m],
            way_number: agents.times_sent(m),
            arrival_m: layout.arrivals[m],
            again: agents.times_sent(m) == 0 && layout.at_end(m) == Some(AtEnd::Again),
        };
        self.progress.observe(time_s, all().map(sight));
        if let Some(gate) = &mut self.gate {
            gate.observe(time_s, all().map(|m| at(m).map(plan)));
        }
        if let Some(lanes) = &mut self.lanes {
            let seen = all().filter_map(|m| Some((plan(at(m)?), self.goes_along[layout.groups[m]])));
            lanes.observe(time_s, &seen.collect::<Vec<_>>());
        }
    }

    /// Looks at all of them, and says what was measured until now.
    fn observe_now(&mut self, agents: &Agents<V>) -> AgentsNow {
        let before = self.overlaps.over_1mm;
        self.observe(agents);
        AgentsNow {
            present: self.places.len(),
            overlaps: self.overlaps.over_1mm - before,
            deepest_m: self.overlaps.max_m,
            progress_mps: self.progress.progress_mps(),
            arrived: self.progress.arrived(),
            stuck: self.progress.stuck(),
        }
    }

    pub fn stuck(&self) -> usize {
        self.progress.stuck()
    }

    /// What was measured.
    ///
    /// - `busy_s`: wall time of the engine, and time that it was running, where that is told (s).
    pub fn figures(&self, agents: &Agents<V>, seconds: f64, busy_s: Option<(f64, f64)>) -> AgentFigures {
        let n = self.members.len();
        let agent_seconds = n as f64 * seconds;
        let of_all = n == agents.num_agents();
        let counts = agents.crowd().counts();
        let a_second = |count: u64| of_all.then_some(count as f64 / agent_seconds);
        let frames = self.overlaps.agent_frames.max(1) as f64;
        let speeds = self.members.iter().map(|&m| f64::from(agents.layout().setup.agents[m].speed));
        let knows = |&&m: &&usize| agents.knows(m) > 0;
        AgentFigures {
            wall_s_per_simulated_s: busy_s.map(|b| b.0 / seconds),
            us_per_agent_second: busy_s.map(|b| 1e6 * b.1 / agent_seconds),
            events_per_agent_second: a_second(events(&counts)),
            crossings_per_agent_second: a_second(counts.entering + counts.leaving).filter(|c| *c > 0.0),
            decisions_per_agent_second: a_second(counts.decisions),
            overlap_over_1mm_fraction: self.overlaps.over_1mm as f64 / frames,
            overlap_over_1cm_fraction: self.overlaps.over_1cm as f64 / frames,
            max_overlap_m: self.overlaps.max_m,
            progress_mps: self.progress.progress_mps(),
            desired_mps: speeds.sum::<f64>() / n as f64,
            arrived: self.progress.arrived(),
            informed: agents.has_happenings().then(|| self.members.iter().filter(knows).count()),
            lane_order: self.lanes.as_ref().and_then(LaneMeter::last),
            flow: self.gate.as_ref().map(GateMeter::flow),
            hips_off_max_m: self.hips_off_max_m,
            state_hash: of_all.then(|| format!("{:016x}", agents.crowd().hash())),
        }
    }
}

impl AgentWatch<Vec2> {
    /// How far bodies are from their discs.
    fn observe_bodies(&mut self, sim: &Simulation, agents: &Agents<Vec2>) {
        let first = sim.groups().iter().find(|g| matches!(sim.casts()[g.cast], GroupCast::Ground(_)));
        let first = first.map_or(0, |g| g.characters.start);
        for &m in &self.members {
            if let (Some(at), Some(pose)) = (agents.position(m, agents.crowd().now()), sim.joint_positions(first + m)) {
                let hips = pose[Joint::Hips.index()];
                let off = f64::from(at.distance(Vec2::new(hips.x, hips.z)));
                self.hips_off_max_m = Some(self.hips_off_max_m.map_or(off, |most| most.max(off)));
            }
        }
    }
}

/// Events inside of a crowd; where there are steps instead, everybody acts at each.
fn events(c: &Counts) -> u64 {
    if c.steps > 0 {
        return c.decisions;
    }
    c.resetting + c.colliding + c.meeting + c.entering + c.leaving + c.contacting + c.separating
}

/// Of each group: on the whole, its agents go along a direction.
fn goes_along<V: Space>(agents: &Agents<V>, along: Vec2) -> Vec<bool> {
    let layout = agents.layout();
    let mut sums = vec![0.0; layout.groups.iter().max().map_or(0, |g| g + 1)];
    for (way, &group) in layout.ways.iter().zip(&layout.groups) {
        sums[group] += (plan(way[way.len() - 1]) - plan(way[0])).dot(along);
    }
    sums.iter().map(|s| *s > 0.0).collect()
}
