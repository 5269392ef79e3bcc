//! Layout of a scene's agents for the crowd: their starts, paths and goals.

use super::{message::NO_PATH_HELP, places::start_positions, route_map::RouteMap};
use crate::scenario::{Scenario, hashed_chance};
use crate::scene::{AtEndConfig, GoalConfig, GroupConfig, HappeningConfig, PlaceConfig, Scene, SiteConfig, to_point};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::Arc;
use throng_base::Result;
use throng_crowd::{Agent, AtEnd, CrowdConfig, CrowdSetup, Obstacle, Route, Space, Zone};

/// Starts, paths and goals of all agents of a scene.
#[derive(Clone, Debug)]
pub struct CrowdLayout<V> {
    /// Setup of the crowd engine.
    pub setup: CrowdSetup<V>,
    /// Group of each agent in the scene.
    pub groups: Vec<usize>,
    /// Corners of each agent's path from its start to its goal, both included (m).
    pub paths: Vec<Vec<V>>,
    /// Distance from its goal at which each agent has arrived (m).
    pub arrivals: Vec<f32>,
    /// Keys of obstacles in the file, for messages (obstacles).
    pub(super) obstacle_keys: Vec<String>,
    /// Lowest and highest coordinates of the agents' starts, for each group of the scene (m).
    boxes: Vec<(V, V)>,
    /// Number of the first agent of each small group of companions, and at the end the number of agents.
    companion_starts: Vec<usize>,
    /// Number of the first door among the obstacles.
    pub(crate) first_door: usize,
    /// Whether agents sense places (zones) and cells.
    pub(super) senses_zones: bool,
    pub(super) senses_cells: bool,
    pub(super) scene: Arc<Scene>,
    pub(super) map: RouteMap,
}

impl<V: Space> CrowdLayout<V> {
    /// Places the agents of a scene and plans their paths.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] where a goal is in an obstacle, or obstacles leave no path to it; it names the group
    /// and the obstacle by their keys.
    pub fn new(scene: &Arc<Scene>) -> Result<Self> {
        Self::of_groups(scene, |group| scene.groups[group].is_of_agents())
    }

    /// Places the characters of some groups that have goals, and plans their paths.
    ///
    /// # Errors
    /// As [`CrowdLayout::new`].
    pub fn of_groups(scene: &Arc<Scene>, is_placed: impl Fn(usize) -> bool) -> Result<Self> {
        let (mut obstacles, mut obstacle_keys) = obstacles_of(scene);
        let first_door = obstacles.len();
        for (i, door) in scene.environment.doors.iter().enumerate() {
            let (from, to) = (to_point(&door.from), to_point(&door.to));
            obstacles.push(Obstacle::Wall { from, to, radius: door.radius_m });
            obstacle_keys.push(format!("environment.doors[{i}]"));
        }
        let mut layout = Self {
            setup: CrowdSetup {
                fields: vec![scene.agents.field],
                obstacles,
                config: CrowdConfig { scheme: scene.agents.engine, ..CrowdConfig::default() },
                ..CrowdSetup::default()
            },
            groups: Vec::new(),
            paths: Vec::new(),
            arrivals: Vec::new(),
            obstacle_keys,
            boxes: Vec::new(),
            companion_starts: Vec::new(),
            first_door,
            senses_zones: false,
            senses_cells: false,
            scene: scene.clone(),
            map: RouteMap::default(),
        };
        let mut rng = Pcg64Mcg::seed_from_u64(scene.seed);
        for (g, group) in scene.groups.iter().enumerate() {
            let place = group.place.as_ref().filter(|_| is_placed(g));
            let radius = group.largest_radius_m();
            let num = group.source.as_ref().map_or(group.count, |s| s.start);
            let mut starts: Vec<V> = place.map_or(Vec::new(), |place| start_positions(place, num, radius, &mut rng));
            let wide = |(low, high): (V, V), &s: &V| (low.min(s), high.max(s));
            let first = starts.first().copied().unwrap_or_default();
            layout.boxes.push(starts.iter().fold((first, first), wide));
            if let Some(source) = group.source.as_ref().filter(|_| place.is_some()) {
                // Agents that enter later get their start when they enter.
                let from = source.place.as_ref().or(group.place.as_ref());
                let later = from.map_or(Vec::new(), |from| start_positions(from, 1, radius, &mut rng));
                starts.resize(group.count, later.first().copied().unwrap_or(first));
            }
            let (mut at, end) = (layout.groups.len(), layout.groups.len() + starts.len());
            let [least, most] = group.companions;
            // The size of each small group is drawn from the number of its first agent.
            while at < end {
                layout.companion_starts.push(at);
                let chance = hashed_chance(scene.seed ^ 0xC04A, g as u32, at as u32);
                at += (least + (chance * (most - least + 1) as f64) as usize).max(1);
            }
            layout.groups.extend(std::iter::repeat_n(g, starts.len()));
            layout.setup.agents.extend(starts.iter().map(|&s| draw_agent(group, s, &mut rng)));
        }
        layout.companion_starts.push(layout.groups.len());
        layout.setup.doors = (first_door..layout.setup.obstacles.len()).collect();
        let speeds = scene.happenings.iter().filter_map(|h| h.speed_mps);
        let speeds = layout.setup.agents.iter().map(|m| m.speed).chain(speeds);
        layout.setup.config.largest_speed_mps = speeds.fold(0.0, f32::max);
        if scene.agents.routes {
            let placed = scene.groups.iter().enumerate().filter(|(g, _)| is_placed(*g)).map(|(_, group)| group);
            let radius = placed.map(GroupConfig::largest_radius_m).fold(0.01, f32::max);
            let map = RouteMap::new(&layout.setup.obstacles, first_door, layout.heights(), radius);
            layout.map = map.map_err(|e| layout.explain_crowd_error(&e.into()))?;
            layout.setup.streets = layout.map.with_doors.clone();
        }
        for m in 0..layout.setup.agents.len() {
            layout.plan_first_path(m, &mut rng)?;
        }
        Ok(layout)
    }

    /// Sets what agents sense, as far as a scenario needs it.
    pub(super) fn set_senses(&mut self, scenario: &Scenario) {
        let (agents, places) = (&self.scene.agents, &self.scene.places);
        self.setup.senses.meet_m = if scenario.senses_meetings() { agents.meeting_m } else { 0.0 };
        (self.senses_zones, self.senses_cells) = (scenario.senses_zones, scenario.senses_cells);
        let zone = |site: &SiteConfig| Zone { centre: to_point(&site.at), radius: site.radius_m };
        self.setup.senses.zones = if self.senses_zones { places.iter().map(zone).collect() } else { Vec::new() };
        self.setup.senses.cell_m = if self.senses_cells { agents.cell_m } else { 0.0 };
        let most = self.setup.config.largest_speed_mps.max(scenario.largest_speed_mps());
        self.setup.config.largest_speed_mps = most;
    }

    /// Obstacles that always stand, and doors, in the order of the file.
    pub fn walls_and_doors(&self) -> (&[Obstacle<V>], &[Obstacle<V>]) {
        self.setup.obstacles.split_at(self.first_door)
    }

    /// True for an agent that does not enter later.
    pub(super) fn is_there_at_start(&self, m: usize) -> bool {
        let g = self.groups[m];
        let first = self.groups.partition_point(|&other| other < g);
        self.scene.groups[g].source.as_ref().is_none_or(|s| m - first < s.start)
    }

    /// Agents that walk together with one, itself included: consecutive numbers.
    pub(super) fn companions_of(&self, m: usize) -> std::ops::Range<usize> {
        let next = self.companion_starts.partition_point(|&first| first <= m);
        self.companion_starts[next - 1]..self.companion_starts[next]
    }

    /// Position at which an agent may enter; another one for each try.
    pub(super) fn entrance(&self, m: usize, tries: u32) -> V {
        let group = &self.scene.groups[self.groups[m]];
        let place = group.source.as_ref().and_then(|s| s.place.as_ref()).or(group.place.as_ref());
        let Some(PlaceConfig::Block { from, to, .. }) = place else { return self.setup.agents[m].position };
        let chance = |axis: u32| hashed_chance(self.scene.seed ^ 0xE47E, m as u32, 4 * tries + axis) as f32;
        let [low, high] = [to_point::<V>(from), to_point::<V>(to)].map(Space::coordinates);
        V::from_coordinates(std::array::from_fn(|i| low[i] + (high[i] - low[i]) * chance(i as u32)))
    }

    /// Checks that obstacles leave room where sources let agents enter.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] with the key of the source.
    pub(super) fn check_sources(&self) -> Result<()> {
        const TRIES: u32 = 64;
        let Some(streets) = &self.map.streets else { return Ok(()) };
        for (g, group) in self.scene.groups.iter().enumerate() {
            let radius = group.radius_m[0];
            let last = self.groups.iter().rposition(|&of| of == g).filter(|_| group.source.is_some());
            if let Some(m) = last.filter(|m| !self.is_there_at_start(*m))
                && !(0..TRIES).map(|k| self.entrance(m, k).to_world()).any(|at| streets.sees(at, at, radius, true))
            {
                let why = "obstacles leave no room for an agent to enter; move the `place`, or make it larger";
                return Err(self.scene.fault(&format!("groups[{g}].source"), why));
            }
        }
        Ok(())
    }

    /// Checks that some agent can go to each slot of a place, and to each goal of an action.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] with the key of the place or of the action.
    pub(super) fn check_goals(&self, scenario: &Scenario) -> Result<()> {
        for (key, at) in scenario.goals.iter().filter(|_| self.map.streets.is_some()) {
            let firsts = (0..self.num_agents()).filter(|&m| m == 0 || self.groups[m - 1] != self.groups[m]);
            let mut whys = firsts.map(|m| {
                let (from, to) = (self.setup.agents[m].position, V::from_world(*at));
                self.map.shortest_path(from, to).err().map(|why| self.no_path_message(m, why, from, to))
            });
            if let Some(Some(why)) = whys.next().map(|first| whys.try_fold(first?, |_, other| other)) {
                return Err(self.scene.fault(key, format!("{why}; {NO_PATH_HELP}")));
            }
        }
        Ok(())
    }

    /// Takes the walls of a level for pictures, from above.
    pub(crate) fn show_walls(&mut self, walls: impl Iterator<Item = [V; 2]>) {
        self.setup.obstacles = walls.map(|[from, to]| Obstacle::Wall { from, to, radius: 0.0 }).collect();
        self.first_door = self.setup.obstacles.len();
    }

    /// Adds a person of a group who walks from one place to another (m).
    pub(crate) fn add_person(&mut self, group: usize, path: [V; 2]) {
        let config = &self.scene.groups[group];
        self.setup.agents.push(Agent { radius: config.largest_radius_m(), ..Agent::standing_at(path[0]) });
        self.groups.push(group);
        self.arrivals.push(self.scene.groups[group].arrival_m);
        self.paths.push(path.to_vec());
    }

    /// Number of agents.
    pub fn num_agents(&self) -> usize {
        self.groups.len()
    }

    /// Behaviour of an agent at the end of its first route.
    pub fn at_end(&self, m: usize) -> Option<AtEnd> {
        Some(self.setup.routes[self.setup.agents[m].route?].at_end)
    }

    /// Plans the first path of an agent.
    fn plan_first_path(&mut self, m: usize, rng: &mut Pcg64Mcg) -> Result<()> {
        let scene = Arc::clone(&self.scene);
        let (group, around) = (&scene.groups[self.groups[m]], self.boxes[self.groups[m]]);
        let start = self.setup.agents[m].position;
        let goal = group.goal.as_ref().unwrap_or(&GoalConfig::Stay {});
        let (subgoals, at_end): (Vec<V>, _) = match goal {
            GoalConfig::Wander { from, to, points: num } => {
                let points = self.map.random_points(start, [from, to], *num, rng);
                (points.into_iter().chain([start]).collect(), AtEndConfig::Again)
            }
            goal => {
                let via = group.via.iter().map(|p| to_point(p));
                let to = scatter_goal(goal_position(goal, around, start), goal, group, rng);
                // The route leads back to its start, where it begins again.
                let back = (group.at_end == AtEndConfig::Again).then_some(start);
                (via.chain([to]).chain(back).collect(), group.at_end)
            }
        };
        let path = self.path_through(m, start, &subgoals)?;
        // A route through several points begins at the start.
        let first = (subgoals.len() > 1).then_some(start);
        let subgoals = first.into_iter().chain(subgoals).collect();
        self.setup.agents[m].route = Some(self.setup.routes.len());
        self.setup.routes.push(Route { subgoals, arrival_radius: group.arrival_m, at_end: at_end.into() });
        self.paths.push(path);
        self.arrivals.push(group.arrival_m);
        Ok(())
    }

    /// Plans the path of an agent to a goal that is ordered later, and returns its route.
    ///
    /// # Errors
    /// As [`CrowdLayout::new`].
    pub(super) fn new_path(&mut self, m: usize, from: V, ordered: &HappeningConfig) -> Result<Route<V>> {
        let to = goal_position(&ordered.goal, self.boxes[self.groups[m]], self.setup.agents[m].position);
        (self.paths[m], self.arrivals[m]) = (self.path_through(m, from, &[to])?, ordered.arrival_m);
        Ok(Route { subgoals: vec![to], arrival_radius: ordered.arrival_m, at_end: ordered.at_end.into() })
    }

    /// Corners of the path from a start through subgoals, both ends included.
    fn path_through(&mut self, m: usize, start: V, subgoals: &[V]) -> Result<Vec<V>> {
        let mut path = vec![start];
        for &to in subgoals {
            let from = path[path.len() - 1];
            let leg = self.map.shortest_path(from, to).map_err(|why| self.no_path_error(m, why, from, to))?;
            path.extend(&leg[1..]);
        }
        Ok(path)
    }

    /// Lowest and highest starts of agents (m).
    pub(super) fn heights(&self) -> [f32; 2] {
        let high = self.setup.agents.iter().map(|m| m.position.coordinates()[1]);
        high.fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], y| [l.min(y), h.max(y)])
    }
}

/// Obstacles of a scene, and the key of each in the file.
fn obstacles_of<V: Space>(scene: &Scene) -> (Vec<Obstacle<V>>, Vec<String>) {
    let of = |(i, o): (usize, &crate::scene::ObstacleConfig)| {
        o.obstacles().into_iter().map(move |o| (o, format!("environment.obstacles[{i}]")))
    };
    scene.environment.obstacles.iter().enumerate().flat_map(of).unzip()
}

fn draw_agent<V: Space>(group: &GroupConfig, position: V, rng: &mut Pcg64Mcg) -> Agent<V> {
    let draw = |[low, high]: [f32; 2]| low + (high - low) * rng.random_range(0.0..1.0f32);
    let [radius, acceleration, speed] = [group.radius_m, group.acceleration_mps2, group.speed_mps].map(draw);
    Agent { position, velocity: V::default(), radius, acceleration, speed, route: None, field: 0 }
}

/// Goal in an area, moved off its row and column at random, since people who arrive keep no order; other goals stay as they
/// are. Goals of two agents never touch.
fn scatter_goal<V: Space>(to: V, goal: &GoalConfig, group: &GroupConfig, rng: &mut Pcg64Mcg) -> V {
    let GoalConfig::Area { from, to: end } = goal else { return to };
    let (low, high) = (to_point::<V>(from).coordinates(), to_point::<V>(end).coordinates());
    let size = |i: usize| high[i] - low[i];
    let volume: f32 = (0..V::DIMENSIONS).map(size).product();
    let apart = throng_base::maths::pow(volume / group.count as f32, 1.0 / V::DIMENSIONS as f32);
    let most = (0.4 * apart - group.largest_radius_m()).max(0.0);
    let at = to.coordinates();
    V::from_coordinates(std::array::from_fn(|i| {
        let off = if i < V::DIMENSIONS { most * rng.random_range(-1.0..1.0f32) } else { 0.0 };
        (at[i] + off).clamp(low[i].min(at[i]), high[i].max(at[i]))
    }))
}

/// Goal position of an agent that starts at `start` (m).
///
/// - `around`: lowest and highest coordinates of its group's starts (m).
fn goal_position<V: Space>(goal: &GoalConfig, around: (V, V), start: V) -> V {
    match goal {
        GoalConfig::Point { at } => to_point(at),
        GoalConfig::Shift { by } => start + to_point(by),
        GoalConfig::Opposite { centre } => to_point::<V>(centre) * 2.0 - start,
        GoalConfig::Area { from, to } => {
            let (low, high, at) = (around.0.coordinates(), around.1.coordinates(), start.coordinates());
            // Agents that enter later may start elsewhere.
            let share = |i: usize| ((at[i] - low[i]) / (high[i] - low[i]).max(1e-6)).clamp(0.0, 1.0);
            let along = |i: usize| from.get(i).map_or(0.0, |f| f + (to[i] - f) * share(i));
            V::from_coordinates(std::array::from_fn(along))
        }
        GoalConfig::Place { .. } | GoalConfig::Level { .. } | GoalConfig::Wander { .. } | GoalConfig::Stay {} => start,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use std::path::Path;

    #[test]
    fn who_enters_later_goes_to_a_place_in_the_area() {
        let text = "[[groups]]\nmotion = \"none\"\ncount = 3\ngoal = { area = { from = [20.0, 0.0], to = [30.0, 9.0] } }\n\
                    place = { block = { from = [0.0, 0.0], to = [9.0, 9.0] } }\n\
                    source = { start = 0, rates = [[0.0, 1.0]] }\n";
        for text in [text.into(), text.replace("start = 0", "start = 1")] {
            let layout =
                CrowdLayout::<Vec2>::new(&Arc::new(Scene::parse(&text, Path::new("a.toml")).unwrap())).unwrap();
            let ends = layout.paths.iter().map(|path| path[path.len() - 1]);
            assert!(
                ends.into_iter().all(|at| at.clamp(Vec2::new(20.0, 0.0), Vec2::new(30.0, 9.0)) == at),
                "{:?}",
                layout.paths
            );
        }
    }

    #[test]
    fn small_groups_have_their_sizes_and_hold_everybody_once() {
        let group = |companions: &str| {
            format!(
                "[[groups]]\nmotion = \"none\"\ncount = 101\ncompanions = {companions}\ngoal = {{ stay = {{}} }}\n\
                 place = {{ block = {{ from = [0.0, 0.0], to = [99.0, 99.0] }} }}\n"
            )
        };
        let text = [group("[2, 4]"), group("[1, 1]"), group("[3, 3]")].concat();
        let layout = CrowdLayout::<Vec2>::new(&Arc::new(Scene::parse(&text, Path::new("a.toml")).unwrap())).unwrap();
        let mut sizes = Vec::new();
        while let Some(all) = Some(sizes.iter().sum()).filter(|m| *m < 303) {
            let party = layout.companions_of(all);
            assert!(party.start == all && party.clone().all(|m| layout.companions_of(m) == party));
            sizes.push(party.len());
        }
        let first = sizes.iter().position(|size| *size == 1).unwrap();
        assert_eq!(sizes[..first - 1].iter().filter(|size| (2..=4).contains(*size)).count(), first - 1, "{sizes:?}");
        assert_eq!(sizes[sizes.len() - 34..], [&[3; 33][..], &[2]].concat());
    }
}
