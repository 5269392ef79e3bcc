//! A scene's crowd as the engine takes it: who stands where, on which way to which goal.

use super::config::{CrowdScene, Engine};
use super::group::{AtEndConfig, GoalConfig, GroupConfig};
use super::obstacle::{plan, point, solid_from_above};
use super::place::places;
use crate::error::BuildError;
use crate::route::{NoWay, RouteMap, smooth};
use glam::Vec2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use throng_runtime::crowd::{CrowdConfig, CrowdError, Member, Obstacle, Route, Scheme, Setup, Space};

/// What ways keep from walls beyond the radius of members. [Unit: m]
const MARGIN_M: f32 = 0.15;
/// Distance from corners of a way at which its spline is tied to it. [Unit: m]
const TIE_M: f32 = 0.6;

/// Where everybody starts and goes.
#[derive(Clone, Debug)]
pub struct Layout<V> {
    /// What the engine is given.
    pub setup: Setup<V>,
    /// Of each member: its group.
    pub groups: Vec<usize>,
    /// Of each member: the corners of its way from its start to its goal, both included. [Unit: m]
    pub ways: Vec<Vec<V>>,
    /// Of each member: how near to its goal is there. [Unit: m]
    pub arrivals: Vec<f32>,
    /// Keys of obstacles in the file, for messages. [Size: obstacles]
    obstacle_keys: Vec<String>,
    /// Of each group: lowest and highest coordinates of its starts. [Unit: m]
    boxes: Vec<(V, V)>,
    scene: CrowdScene,
    maps: Maps,
}

/// Route maps by clearance: groups of the same radius share one.
#[derive(Clone, Debug, Default)]
struct Maps {
    of_group: Vec<usize>,
    maps: Vec<RouteMap>,
    /// Numbers of obstacles behind a map's solids.
    obstacles: Vec<usize>,
}

impl<V: Space> Layout<V> {
    /// Lays a scene out.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where a goal is in an obstacle, or what stands leaves no way to it; it names the group and the
    /// obstacle by their keys.
    pub fn new(scene: &CrowdScene) -> Result<Self, BuildError> {
        let (obstacles, obstacle_keys) = obstacles_of(scene);
        let mut layout = Self {
            setup: Setup {
                fields: vec![scene.field],
                obstacles,
                config: CrowdConfig { scheme: scheme(scene.engine), ..CrowdConfig::default() },
                ..Setup::default()
            },
            groups: Vec::new(),
            ways: Vec::new(),
            arrivals: Vec::new(),
            obstacle_keys,
            boxes: Vec::new(),
            scene: scene.clone(),
            maps: Maps::default(),
        };
        let mut rng = Pcg64Mcg::seed_from_u64(scene.seed);
        for (g, group) in scene.groups.iter().enumerate() {
            let starts: Vec<V> = places(&group.place, group.count, group.radius_m[1], &mut rng);
            let wide = |(low, high): (V, V), &s: &V| (low.min(s), high.max(s));
            layout.boxes.push(starts.iter().fold((starts[0], starts[0]), wide));
            layout.groups.extend(std::iter::repeat_n(g, starts.len()));
            layout.setup.members.extend(starts.iter().map(|&s| member(group, s, &mut rng)));
        }
        layout.setup.config.largest_speed_mps = layout.largest_speed();
        layout.prepare_maps();
        for m in 0..layout.setup.members.len() {
            layout.send(m, &mut rng)?;
        }
        Ok(layout)
    }

    /// Number of members.
    pub fn num_members(&self) -> usize {
        self.groups.len()
    }

    /// Plans the way of a member that starts.
    fn send(&mut self, m: usize, rng: &mut Pcg64Mcg) -> Result<(), BuildError> {
        let (group, around) = (self.scene.groups[self.groups[m]].clone(), self.boxes[self.groups[m]]);
        let start = self.setup.members[m].position;
        let (subgoals, at_end) = match &group.goal {
            GoalConfig::Wander { from, to, points: num } => {
                let mut all: Vec<V> = (0..*num).map(|_| self.free_point(m, from, to, rng)).collect();
                // Back to where the way begins again.
                all.push(start);
                (all, AtEndConfig::Again)
            }
            goal => {
                let via = group.via.iter().map(|p| point(p));
                (via.chain([goal_of(goal, around, start)]).collect(), group.at_end)
            }
        };
        let way = self.way(m, start, &subgoals)?;
        self.setup.members[m].route = self.setup.routes.len();
        let subgoals = self.spline(m, &way);
        self.setup.routes.push(Route { subgoals, arrival_radius: group.arrival_m, at_end: at_end.into() });
        self.ways.push(way);
        self.arrivals.push(group.arrival_m);
        Ok(())
    }

    /// The way of a member to a goal that it is told of later: corners and route.
    ///
    /// # Errors
    /// As [`Layout::new`].
    pub(super) fn new_way(
        &mut self,
        m: usize,
        from: V,
        goal: &GoalConfig,
        (arrival_radius, at_end): (f32, AtEndConfig),
    ) -> Result<Route<V>, BuildError> {
        let to = goal_of(goal, self.boxes[self.groups[m]], self.setup.members[m].position);
        let way = self.way(m, from, &[to])?;
        let route = Route { subgoals: self.spline(m, &way), arrival_radius, at_end: at_end.into() };
        (self.ways[m], self.arrivals[m]) = (way, arrival_radius);
        Ok(route)
    }

    /// Corners of the way from a start through subgoals, both ends included.
    fn way(&mut self, m: usize, start: V, subgoals: &[V]) -> Result<Vec<V>, BuildError> {
        let mut way = vec![start];
        let Some(map) = self.maps.of(self.groups[m]) else {
            way.extend(subgoals);
            return Ok(way);
        };
        let mut from = start;
        for &to in subgoals {
            let leg = match map.way(plan(from), plan(to)) {
                Ok(leg) => leg,
                Err(why) => return Err(self.no_way(m, why, from, to)),
            };
            way.extend(&lift(&leg, from, to)[1..]);
            from = to;
        }
        Ok(way)
    }

    /// Subgoals of a way for the engine: the goal alone where it is straight ahead.
    fn spline(&self, m: usize, way: &[V]) -> Vec<V> {
        match way {
            [_, goal] => vec![*goal],
            way if self.maps.maps.is_empty() => way.to_vec(),
            way => {
                let flat: Vec<Vec2> = way.iter().map(|&p| plan(p)).collect();
                let near = TIE_M.max(2.0 * self.setup.members[m].radius);
                lift(&smooth(&flat, near), way[0], way[way.len() - 1])
            }
        }
    }

    /// A point by chance that no obstacle is near.
    fn free_point(&mut self, m: usize, from: &[f32], to: &[f32], rng: &mut Pcg64Mcg) -> V {
        /// Tries before a point is taken as it is, and its way refused.
        const TRIES: usize = 200;
        let mut at = V::default();
        for _ in 0..TRIES {
            let c: [f32; 3] = std::array::from_fn(|i| from.get(i).map_or(0.0, |&f| rng.random_range(f..to[i])));
            at = V::from_coordinates(c);
            let Some(map) = self.maps.of(self.groups[m]) else { break };
            if map.is_clear(plan(at), plan(at), map.clearance()) {
                break;
            }
        }
        at
    }

    /// One map for every radius, where the scene has obstacles and wants routes.
    fn prepare_maps(&mut self) {
        let heights = self.heights();
        let all = self.setup.obstacles.iter().enumerate();
        let standing: Vec<_> = all.filter_map(|(i, o)| Some((i, solid_from_above(o, heights)?))).collect();
        if !self.scene.routes || standing.is_empty() {
            return;
        }
        let mut maps = Maps { obstacles: standing.iter().map(|s| s.0).collect(), ..Maps::default() };
        for group in &self.scene.groups {
            let clearance = group.radius_m[1] + MARGIN_M;
            let known = maps.maps.iter().position(|m| m.clearance() == clearance);
            maps.of_group.push(known.unwrap_or_else(|| {
                maps.maps.push(RouteMap::new(standing.iter().map(|s| s.1.clone()).collect(), clearance));
                maps.maps.len() - 1
            }));
        }
        self.maps = maps;
    }

    /// Of everybody, and of what happenings ask for. [Unit: m/s]
    fn largest_speed(&self) -> f32 {
        let told = self.scene.happenings.iter().filter_map(|h| h.speed_mps);
        self.setup.members.iter().map(|m| m.speed).chain(told).fold(0.0, f32::max)
    }

    /// Lowest and highest that members start.
    fn heights(&self) -> [f32; 2] {
        let high = self.setup.members.iter().map(|m| m.position.coordinates()[1]);
        high.fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], y| [l.min(y), h.max(y)])
    }

    fn no_way(&self, m: usize, why: NoWay, from: V, to: V) -> BuildError {
        let key = |solid: usize| &self.obstacle_keys[self.maps.obstacles[solid]];
        let who = self.who(m);
        let place = |at: V| format!("{:.2?}", &at.coordinates()[..V::DIMENSIONS]);
        let message = match why {
            NoWay::Start(s) => format!("{who} starts in `{}`, at {}", key(s), place(from)),
            NoWay::Goal(s) => {
                let clearance = self.scene.groups[self.groups[m]].radius_m[1] + MARGIN_M;
                format!("the goal {} of {who} is in `{}` or nearer than {clearance:.2} m to it", place(to), key(s))
            }
            NoWay::Separated => format!("no way leads {who} from {} to {}", place(from), place(to)),
        };
        self.fault(message, "Move it, open a gap in the obstacles that is wide enough, or set `routes = false`")
    }

    /// A member, for messages.
    pub(super) fn who(&self, m: usize) -> String {
        let Some(&g) = self.groups.get(m) else { return format!("member {m}") };
        let name = &self.scene.groups[g].name;
        if name.is_empty() { format!("member {m} of `groups[{g}]`") } else { format!("member {m} of \"{name}\"") }
    }

    /// What the engine found wrong, in the scene's words.
    pub(super) fn explain(&self, e: &CrowdError) -> BuildError {
        let obstacle = |o: usize| self.obstacle_keys.get(o).cloned().unwrap_or_else(|| format!("obstacle {o}"));
        let message = match *e {
            CrowdError::Overlap { first, second, overlap_m } => {
                let (a, b) = (self.who(first), self.who(second));
                let help = "Give their groups more room (`place`), or smaller radii";
                return self.fault(format!("{a} and {b} overlap by {overlap_m:.3} m at the start"), help);
            }
            CrowdError::Inside { member, obstacle: o } => {
                format!("{} starts in `{}`", self.who(member), obstacle(o))
            }
            CrowdError::Goal { route, subgoal, obstacle: o } => {
                let who = self.setup.members.iter().position(|m| m.route == route).unwrap_or(usize::MAX);
                format!("subgoal {subgoal} of {} is in `{}`", self.who(who), obstacle(o))
            }
            _ => e.to_string(),
        };
        self.fault(message, "Correct the scene file")
    }

    fn fault(&self, message: String, help: &str) -> BuildError {
        let message = format!("scene \"{}\": {message}", self.scene.name);
        BuildError::Stage { stage: "scene", message, help: help.into() }
    }
}

impl Maps {
    fn of(&mut self, group: usize) -> Option<&mut RouteMap> {
        self.maps.get_mut(*self.of_group.get(group)?)
    }
}

/// The engine's name for it.
fn scheme(engine: Engine) -> Scheme {
    match engine {
        Engine::Events => Scheme::Registration,
        Engine::Occupancy => Scheme::Registration,
        Engine::Fixed => Scheme::Registration,
    }
}

/// Obstacles of a scene, and the key of each in the file.
fn obstacles_of<V: Space>(scene: &CrowdScene) -> (Vec<Obstacle<V>>, Vec<String>) {
    let of = |(i, o): (usize, &super::ObstacleConfig)| {
        o.obstacles().into_iter().map(move |o| (o, format!("obstacles[{i}]")))
    };
    scene.obstacles.iter().enumerate().flat_map(of).unzip()
}

fn member<V: Space>(group: &GroupConfig, position: V, rng: &mut Pcg64Mcg) -> Member<V> {
    let mut draw = |[low, high]: [f32; 2]| low + (high - low) * rng.random_range(0.0..1.0f32);
    Member {
        position,
        velocity: V::default(),
        radius: draw(group.radius_m),
        acceleration: draw(group.acceleration_mps2),
        speed: draw(group.speed_mps),
        route: 0,
        field: 0,
    }
}

/// Where a goal is for one who starts at `start`.
///
/// - `around`: lowest and highest coordinates of its group's starts. [Unit: m]
fn goal_of<V: Space>(goal: &GoalConfig, around: (V, V), start: V) -> V {
    match goal {
        GoalConfig::Point { at } => point(at),
        GoalConfig::Shift { by } => start + point(by),
        GoalConfig::Opposite { centre } => point::<V>(centre) * 2.0 - start,
        GoalConfig::Area { from, to } => {
            let (low, high, at) = (around.0.coordinates(), around.1.coordinates(), start.coordinates());
            let share = |i: usize| (at[i] - low[i]) / (high[i] - low[i]).max(1e-6);
            let along = |i: usize| from.get(i).map_or(0.0, |f| f + (to[i] - f) * share(i));
            V::from_coordinates(std::array::from_fn(along))
        }
        GoalConfig::Wander { .. } | GoalConfig::Stay {} => start,
    }
}

/// A way on the ground at the heights between two ends.
fn lift<V: Space>(flat: &[Vec2], from: V, to: V) -> Vec<V> {
    let legs = || flat.windows(2).map(|w| w[0].distance(w[1]));
    let all = legs().sum::<f32>().max(1e-6);
    let (low, high) = (from.coordinates()[1], to.coordinates()[1]);
    let mut gone = 0.0;
    let along = std::iter::once(0.0).chain(legs()).map(|leg| {
        gone += leg;
        gone / all
    });
    let place = |(p, share): (&Vec2, f32)| {
        V::from_coordinates(if V::DIMENSIONS == 2 { [p.x, p.y, 0.0] } else { [p.x, low + (high - low) * share, p.y] })
    };
    flat.iter().zip(along).map(place).collect()
}
