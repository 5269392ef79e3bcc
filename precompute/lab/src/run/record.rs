//! Records of a run, for pictures.

use super::groups::{agent_path, agents_crowd, policy_characters};
use super::report::SceneRunConfig;
use super::watch::{SAMPLE_PERIOD_S, SceneWatch};
use glam::{Vec2, Vec3, Vec3Swizzles};
use throng_core::NUM_JOINTS;
use throng_crowd::{Obstacle, Space};
use throng_geometry::Capsule2d;
use throng_simulation::agents::{CrowdLayout, Disc, world_vector};
use throng_simulation::{AnyCharacterGroup, SceneGroup, Simulation, SimulationEvent, scene::SiteConfig};

/// Number of recorded moments of agents, the first and the last included.
const MOMENTS: usize = 4;
/// Time between points of a trail (s).
pub const TRAIL_S: f64 = 0.4;
/// Number of agents whose trails and paths are recorded, spread over the crowd.
const NUM_TRAILED: usize = 2000;
/// Number of characters on paths, and in worlds, whose poses are recorded ten times a second; one of each is shown.
const NUM_FOLLOWED: [usize; 2] = [24, 48];

/// World positions of all joints of a character (m).
pub type JointPositions = [Vec3; NUM_JOINTS];

/// Record of a run, for pictures; unless recording is on, it only holds poses at the end and faults.
#[derive(Clone, Debug, Default)]
pub struct SceneRecord {
    /// Poses of all characters at the end; `None` for a character that has left or has no body.
    pub poses: Vec<Option<JointPositions>>,
    /// Records of groups with policies.
    pub fights: Vec<FightRecord>,
    /// Records of groups on random paths.
    pub paths: Vec<PathsRecord>,
    /// Records of worlds.
    pub worlds: Vec<WorldRecord>,
    /// Record of all agents, if there are any.
    pub agents: Option<AgentsRecord>,
    /// Records of groups with policies that have goals.
    pub travels: Vec<AgentsRecord>,
    /// Trajectories of everybody, if they were requested.
    pub trajectories: Vec<TrajectoryPoint>,
    /// Faults that were observed: time (s), character, description.
    pub faults: Vec<(f32, usize, String)>,
}

/// Position and velocity of a character or agent at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryPoint {
    /// (s)
    pub time_s: f64,
    /// Its number in the simulation.
    pub agent: usize,
    /// Position on the ground: x and z (m).
    pub at: Vec2,
    /// Velocity over the ground: x and z; of a character that no navigation moves, the mean since the point before (m/s).
    pub velocity: Vec2,
}

/// The first characters of a group with policies: two of pairs, one of others.
#[derive(Clone, Debug, Default)]
pub struct FightRecord {
    /// Number of the group in the simulation.
    pub group: usize,
    /// Poses of these characters at every step.
    pub frames: Vec<FightFrame>,
    /// Outcomes of their blows; characters are numbered from the first of the group.
    pub events: Vec<SimulationEvent>,
    /// Opponents' heads or targets of the whole group at the end (m).
    pub targets: Vec<Vec3>,
    /// Walls.
    pub walls: Vec<Capsule2d>,
}

/// The recorded characters of a group with policies at one step.
#[derive(Clone, Debug)]
pub struct FightFrame {
    /// (s)
    pub time_s: f32,
    /// Poses of one or two characters.
    pub poses: Vec<JointPositions>,
    /// Position of the target, if there is one (m).
    pub target: Option<Vec3>,
}

/// The first characters of a group on random paths.
#[derive(Clone, Debug, Default)]
pub struct PathsRecord {
    /// Number of the group in the simulation.
    pub group: usize,
    /// Samples, ten a second: time, speeds, poses (s, m/s, m).
    pub samples: Vec<(f32, Vec<f32>, Vec<JointPositions>)>,
}

/// Some characters of a world.
#[derive(Clone, Debug, Default)]
pub struct WorldRecord {
    /// Number of the world's character group in the simulation.
    pub character_group: usize,
    /// Number of its first group in the scene.
    pub group: usize,
    /// Numbers of the characters in the simulation.
    pub followed: Vec<usize>,
    /// Samples, ten a second.
    pub samples: Vec<PeopleSample>,
}

/// The followed characters of a world at one time.
#[derive(Clone, Debug, Default)]
pub struct PeopleSample {
    /// (s)
    pub time_s: f32,
    /// One pose each.
    pub poses: Vec<JointPositions>,
    /// Partner with whom each character acts: its number in the simulation, and its pose.
    pub partners: Vec<Option<(usize, JointPositions)>>,
}

/// Partner of a character of a world, once both are at their places of the capture.
fn partner(sim: &Simulation, who: usize) -> Option<(usize, JointPositions)> {
    let (AnyCharacterGroup::Patches(people), member) = sim.locate(who) else { return None };
    let (inhabitants, first) = (people.inhabitants(), who - member);
    let meeting = inhabitants.meeting_state(*inhabitants.ids().get(member)?).ok()??;
    meeting.partner?;
    let other = first + inhabitants.ids().iter().position(|id| *id == meeting.with)?;
    Some((other, sim.joint_positions(other)?))
}

/// State of an agent, for pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedAgent {
    /// Centre in the world; y is 0 on the ground (m).
    pub at: Vec3,
    /// Velocity (m/s).
    pub velocity: Vec3,
    /// True if it knows of a happening.
    pub is_informed: bool,
}

/// All agents at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrowdMoment {
    /// Time (s).
    pub time_s: f64,
    /// State of each agent; `None` for an agent that has left (agents).
    pub agents: Vec<Option<RecordedAgent>>,
    /// Flags of open doors (doors).
    pub is_open: Vec<bool>,
}

/// All agents of a scene, or a group of characters with policies that have goals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AgentsRecord {
    /// True for agents in the air.
    pub in_the_air: bool,
    /// Number of the first of them among the characters of the simulation.
    pub first: usize,
    /// Names of groups.
    pub names: Vec<String>,
    /// Group of each agent, as a number among the groups of agents (agents).
    pub groups: Vec<usize>,
    /// Radius of each agent (agents) (m).
    pub radii: Vec<f32>,
    /// Moments, in order of time.
    pub moments: Vec<CrowdMoment>,
    /// Trails of some agents: number, and positions every 0.4 s (m).
    pub trails: Vec<(usize, Vec<Vec3>)>,
    /// Paths of the same agents, as corners (m).
    pub paths: Vec<Vec<Vec3>>,
    /// Static and moving obstacles.
    pub obstacles: Vec<Obstacle>,
    /// Walls that open and close.
    pub doors: Vec<Obstacle>,
    /// Places that people visit.
    pub places: Vec<RecordedPlace>,
}

/// Fills a record.
pub(super) struct SceneRecorder {
    is_on: bool,
    trajectory_hz: Option<f64>,
    /// Time and places of the last points of trajectories (s, m).
    last_points: (f64, Vec<Option<Vec2>>),
    seconds: f64,
    record: SceneRecord,
}

impl SceneRecorder {
    pub fn new(config: &SceneRunConfig, sim: &Simulation, seconds: f64) -> Self {
        let is_on = config.recorded;
        let mut record = SceneRecord::default();
        for (g, group) in sim.groups().iter().enumerate().filter(|_| is_on) {
            match &sim.character_groups()[group.character_group] {
                AnyCharacterGroup::Policy(_) | AnyCharacterGroup::Sparring(_) => {
                    record.fights.push(FightRecord { group: g, ..FightRecord::default() });
                }
                AnyCharacterGroup::Paths(_) => record.paths.push(PathsRecord { group: g, ..PathsRecord::default() }),
                AnyCharacterGroup::Patches(_)
                    if record.worlds.iter().all(|w| w.character_group != group.character_group) =>
                {
                    let all = sim.groups().iter().filter(|g| g.character_group == group.character_group);
                    let all = all.flat_map(|g| g.characters.clone());
                    let one = sim.scene().picture.follow.map(|one| one.min(sim.num_characters() - 1));
                    // Characters of other worlds are left out.
                    let followed = match one.filter(|one| all.clone().any(|who| who == *one)) {
                        Some(one) => vec![one],
                        None => all.take(NUM_FOLLOWED[1]).collect(),
                    };
                    let (character_group, group, samples) = (group.character_group, group.number, Vec::new());
                    record.worlds.push(WorldRecord { character_group, group, followed, samples });
                }
                AnyCharacterGroup::Ground(a) if record.agents.is_none() => {
                    record.agents = Some(begin_agents_record(a.layout(), sim, group));
                }
                AnyCharacterGroup::Air(a) if record.agents.is_none() => {
                    record.agents = Some(begin_agents_record(a.layout(), sim, group));
                }
                AnyCharacterGroup::Travel(t) if t.layout().groups[0] == group.number => {
                    record.travels.push(begin_agents_record(t.layout(), sim, group));
                }
                _ => {}
            }
        }
        let last_points = (0.0, vec![None; sim.num_characters()]);
        Self { is_on, trajectory_hz: config.trajectory_hz, last_points, seconds, record }
    }

    pub fn observe(&mut self, sim: &Simulation, step: usize, hz: f64) {
        let time_s = sim.time_s();
        let record = &mut self.record;
        let is_sampled = step.is_multiple_of(((SAMPLE_PERIOD_S * hz).round() as usize).max(1));
        let every = |rate_hz: f64| ((hz / rate_hz).round() as usize).max(1);
        if self.trajectory_hz.is_some_and(|rate_hz| step.is_multiple_of(every(rate_hz))) {
            let (before_s, places) = &mut self.last_points;
            let since_s = (time_s - *before_s) as f32;
            for (agent, before) in places.iter_mut().enumerate() {
                let place = sim.root(agent).map(|root| Vec2::new(root.x, root.z));
                let moved =
                    place.zip(*before).filter(|_| since_s > 0.0).map_or(Vec2::ZERO, |(at, was)| (at - was) / since_s);
                let point = match sim.disc(agent) {
                    Some(disc) => Some((disc.centre.xz(), disc.velocity.xz())),
                    None => place.map(|at| (at, moved)),
                };
                record.trajectories.extend(point.map(|(at, velocity)| TrajectoryPoint { time_s, agent, at, velocity }));
                *before = place;
            }
            *before_s = time_s;
        }
        if !self.is_on {
            return;
        }
        record.fights.iter_mut().for_each(|f| f.observe(sim));
        if is_sampled {
            for p in &mut record.paths {
                let characters = sim.groups()[p.group].characters.clone().take(NUM_FOLLOWED[0]);
                let speed = |who| if let (AnyCharacterGroup::Paths(w), m) = sim.locate(who) { w.speed(m) } else { 0.0 };
                let poses = characters.clone().filter_map(|who| sim.joint_positions(who)).collect();
                p.samples.push((time_s as f32, characters.map(speed).collect(), poses));
            }
            for w in &mut record.worlds {
                let poses = w.followed.iter().filter_map(|&who| sim.joint_positions(who)).collect();
                let partners = w.followed.iter().map(|&who| partner(sim, who)).collect();
                w.samples.push(PeopleSample { time_s: time_s as f32, poses, partners });
            }
        }
        if let Some(agents) = &mut record.agents {
            for character_group in sim.character_groups() {
                let is_open = |door| match character_group {
                    AnyCharacterGroup::Ground(a) => a.is_open(door),
                    AnyCharacterGroup::Air(a) => a.is_open(door),
                    _ => false,
                };
                if agents_crowd(character_group).is_some() {
                    agents.observe(sim, is_open, self.seconds);
                }
            }
        }
        for travel in &mut record.travels {
            let is_open = |door: usize| sim.scene().environment.doors[door].open;
            travel.observe(sim, is_open, self.seconds);
        }
    }

    /// Completes the record with the state at the end.
    pub fn finish(mut self, sim: &Simulation, watch: &SceneWatch) -> SceneRecord {
        self.record.poses = (0..sim.num_characters()).map(|who| sim.joint_positions(who)).collect();
        self.record.faults = watch.faults().cloned().collect();
        for f in &mut self.record.fights {
            let all = sim.groups()[f.group].characters.clone();
            f.targets = all.filter_map(|who| sim.target(who)).collect();
            let boxers = policy_characters(&sim.character_groups()[sim.groups()[f.group].character_group]);
            let reservations = boxers.and_then(|b| b.characters().reservations());
            f.walls = reservations.map_or(Vec::new(), |r| r.walls().copied().collect());
        }
        for agents in self.record.agents.iter_mut().chain(&mut self.record.travels) {
            agents.paths = agents.trails.iter().map(|(m, _)| agent_path(sim, agents.first + m)).collect();
        }
        self.record
    }
}

impl FightRecord {
    fn observe(&mut self, sim: &Simulation) {
        let all = sim.groups()[self.group].characters.clone();
        let is_pair = matches!(sim.locate(all.start).0, AnyCharacterGroup::Sparring(_));
        let shown = all.start..all.end.min(all.start + if is_pair { 2 } else { 1 });
        let target = sim.target(all.start).filter(|_| !is_pair);
        let poses = shown.clone().filter_map(|who| sim.joint_positions(who)).collect();
        self.frames.push(FightFrame { time_s: sim.time_s() as f32, poses, target });
        let own = sim.events().iter().filter(|e| shown.contains(&e.who));
        self.events.extend(own.map(|e| SimulationEvent { who: e.who - all.start, ..*e }));
    }
}

/// Begins the record of agents, or of characters with goals, with everything that does not change.
fn begin_agents_record<V: Space>(layout: &CrowdLayout<V>, sim: &Simulation, one: &SceneGroup) -> AgentsRecord {
    let num = layout.num_agents();
    let every = num.div_ceil(NUM_TRAILED).max(1);
    let together = sim.groups().iter().filter(|g| g.character_group == one.character_group);
    let (numbers, names): (Vec<usize>, Vec<String>) = together.map(|g| (g.number, g.name.clone())).unzip();
    let group = |g: &usize| numbers.iter().position(|n| n == g).unwrap_or(0);
    AgentsRecord {
        in_the_air: V::DIMENSIONS == 3,
        first: one.characters.start,
        names,
        groups: layout.groups.iter().map(group).collect(),
        radii: layout.setup.agents.iter().map(|m| m.radius).collect(),
        moments: Vec::new(),
        trails: (0..num).step_by(every).map(|m| (m, Vec::new())).collect(),
        paths: Vec::new(),
        obstacles: layout.walls_and_doors().0.iter().map(obstacle_in_world).collect(),
        doors: layout.walls_and_doors().1.iter().map(obstacle_in_world).collect(),
        places: sim.scene().places.iter().map(recorded_place).collect(),
    }
}

impl AgentsRecord {
    fn observe(&mut self, sim: &Simulation, is_open: impl Fn(usize) -> bool, seconds: f64) {
        let (time_s, first) = (sim.time_s(), self.first);
        let is_last = time_s >= seconds;
        let due = seconds * self.moments.len() as f64 / (MOMENTS - 1) as f64;
        if is_last || time_s >= due && self.moments.len() < MOMENTS - 1 {
            let is_open = (0..self.doors.len()).map(is_open).collect();
            let recorded = |d: Disc| RecordedAgent { at: d.centre, velocity: d.velocity, is_informed: d.knows };
            let agents = (0..self.groups.len()).map(|m| sim.disc(first + m).map(recorded)).collect();
            self.moments.push(CrowdMoment { time_s, agents, is_open });
        }
        for (m, trail) in &mut self.trails {
            if is_last || time_s >= trail.len() as f64 * TRAIL_S {
                trail.extend(sim.disc(first + *m).map(|d| d.centre));
            }
        }
    }
}

/// A place of the scene, for pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedPlace {
    /// Its name.
    pub name: String,
    /// Centre (m).
    pub at: Vec3,
    /// (m)
    pub radius: f32,
    /// Standing places, slots and queue (m).
    pub slots: Vec<Vec3>,
}

fn recorded_place(site: &SiteConfig) -> RecordedPlace {
    let point = |p: &[f32]| if let [x, y, z] = *p { Vec3::new(x, y, z) } else { Vec3::new(p[0], 0.0, p[1]) };
    let slots =
        site.slots.iter().map(|s| point(&s.at)).chain(site.queue.iter().flat_map(|q| &q.points).map(|p| point(p)));
    RecordedPlace { name: site.name.clone(), at: point(&site.at), radius: site.radius_m, slots: slots.collect() }
}

/// Converts an obstacle to world space.
pub fn obstacle_in_world<V: Space>(obstacle: &Obstacle<V>) -> Obstacle {
    obstacle.clone().map(world_vector)
}

/// Position at a time on a path of timed points, in order of time (s, m).
pub fn position_on_timed_path(path: &[(f64, Vec3)], time_s: f64) -> Vec3 {
    let next = path.partition_point(|w| w.0 <= time_s);
    match (next.checked_sub(1).map(|i| path[i]), path.get(next)) {
        (Some(a), Some(b)) => a.1.lerp(b.1, ((time_s - a.0) / (b.0 - a.0)) as f32),
        (Some(end), None) => end.1,
        (None, Some(end)) => end.1,
        (None, None) => Vec3::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn movers_are_where_their_time_says_and_wait_at_both_ends() {
        let path = [(1.0, Vec3::ZERO), (3.0, Vec3::X), (4.0, Vec3::Z)];
        for (time_s, at) in [(0.0, Vec3::ZERO), (2.0, Vec3::X * 0.5), (3.5, (Vec3::X + Vec3::Z) * 0.5), (9.0, Vec3::Z)]
        {
            assert!(position_on_timed_path(&path, time_s).distance(at) < 1e-6, "{time_s}");
        }
    }
    use throng_simulation::Scene;
    use throng_world::{PathCosts, WorldGraph, made_up_floor};

    #[test]
    fn a_world_shows_its_own_where_the_one_to_follow_is_not_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        std::fs::write(file("floor.throng"), made_up_floor::bundle("made up")).unwrap();
        let tables = made_up_floor::tables();
        let world = made_up_floor::world(&tables, &["#####", "#b##b", "###b#", "#####"]);
        let costs = PathCosts::bake(&WorldGraph::new(tables.patches(), &world.tables()).unwrap()).unwrap();
        world.write(&costs, &mut std::fs::File::create(file("floor.world")).unwrap()).unwrap();
        let followed = |who: usize| {
            let text = format!(
                "picture.follow = {who}\n[[groups]]\nmotion = \"none\"\ncount = 3\ngoal = {{ stay = {{}} }}\n\
                 place = {{ block = {{ from = [50.0, 50.0], to = [59.0, 59.0] }} }}\n\
                 [[groups]]\nmotion = \"patches\"\ncount = 4\nbundle = {:?}\nworld = {:?}\n",
                file("floor.throng"),
                file("floor.world")
            );
            let scene = Scene::parse(&text, &folder.path().join("s.toml")).unwrap().open().unwrap();
            let config = SceneRunConfig { recorded: true, ..SceneRunConfig::default() };
            SceneRecorder::new(&config, &Simulation::new(&scene).unwrap(), 1.0).record.worlds[0].followed.clone()
        };
        assert_eq!((followed(5), followed(99)), (vec![5], vec![6]));
        assert_eq!(followed(0), [3, 4, 5, 6]);
    }
}
