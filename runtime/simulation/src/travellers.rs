//! Characters with policies on the way to goals: navigation puts a point before them, and their policy goes there.

use crate::agents::{CrowdLayout, Disc};
use crate::boxing::{characters_config, in_own_manner, resting_states, weighted_order};
use crate::motion_kind::{GroupStep, MotionKind, check_snapshot, saved_bytes};
use crate::scene::{AtEndConfig, Scene};
use crate::{CharacterEvent, Order, SimulationEvent, compile::CompiledScene};
use glam::{Vec2, Vec3, Vec3Swizzles};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, f32::consts::PI, sync::Arc};
use throng_base::thresholds::{WAITS_BELOW_MPS, WALK_SPEED_MPS};
use throng_base::{Bytes, Error, Id, Result, SnapshotKind, error::ensure, ground::ReservedRegion, maths};
use throng_core::characters::{PolicyCharacters, PolicyOrder, Spawn};
use throng_core::{CharacterGroup, Contacts, Mat3x4, NUM_JOINTS, Planar};
use throng_core::{body::HeightField, graph::MotionGraph, reserve::FloorWall, stops::BODY_RADIUS_M};
use throng_crowd::{AtEnd, NavigatedBody, Navigation, NavigationAim, NavigationState, Route, Streets};
use throng_geometry::Capsule2d;
use throng_level::Level;

/// Distance of the target from a character that is on its way: so far that its policy does not slow down at a corner (m).
const TARGET_AHEAD_M: f32 = 2.0;
/// Time at the speed that it is ordered for which its target is ahead, likewise (s).
const TARGET_AHEAD_S: f32 = 2.5;
/// Poses in which a character is tried to be placed at its start.
const POSES_TRIED: usize = 16;
/// Distance from the goal at which a character goes straight there (m).
const GOAL_NEAR_M: f32 = 1.0;

/// Distance of a start from its place that is tried first, and at most (m), and the factor by which it grows.
const LEAST_REACH_M: f32 = 0.5;
const MOST_REACH_M: f32 = 12.0;
const REACH_GROWS: f32 = 1.01;
/// Distance of a goal from its place (m).
const GOAL_REACH_M: f32 = 2.0;
/// Distance from a point within which the ground is below it (m).
const NEAR_M: f32 = 0.5;
/// Distance around a goal within which ground is level, and the difference of heights that it may have (m).
const ROOM_M: f32 = 0.8;
const LEVEL_M: f32 = 0.1;
/// Most draws of a goal.
const MOST_DRAWN: usize = 400;
/// Spacing of the heights that feet are put on (m).
const GROUND_SPACING_M: f32 = 0.06;
/// Most heights of the ground of a level; on a larger one they lie farther apart.
const MOST_KNOTS: f32 = 8e6;

/// Group of characters with policies on the way to goals.
#[derive(Clone, Debug)]
pub struct Travellers {
    scene: Arc<Scene>,
    /// Numbers of their groups in the scene.
    groups: Vec<usize>,
    people: PolicyCharacters,
    navigation: Navigation,
    travels: Vec<TravelState>,
    /// What each does on its way, and its first route (num_characters).
    begins: Vec<(PolicyOrder, Route<Vec3>)>,
    /// True for each door that is open.
    open_doors: Vec<bool>,
    layout: CrowdLayout<Vec2>,
    /// Targets of the present characters, in the order of their rows (m).
    targets: Vec<Vec3>,
}

/// State of one character on its way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct TravelState {
    is_stuck: bool,
    /// True once it has been at its goal.
    has_arrived: bool,
    /// Order that it follows in place of its first route.
    order: Option<TravelOrder>,
}

/// Order of one character.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct TravelOrder {
    /// Goal, and the place where it was given (m).
    to: Vec3,
    at: Vec3,
    arrival_m: f32,
}

/// Snapshot of travels, around one of the characters.
const TRAVELS: SnapshotKind = SnapshotKind { what: "travellers", tag: *b"TRAV", version: 6, setup: 0 };

impl Travellers {
    /// Creates groups with one bundle, with all characters in place.
    ///
    /// # Errors
    /// As [`CrowdLayout::new`], and [`Error::Text`] for starts in each other, or goals to which nobody can walk.
    pub(crate) fn new(compiled: &CompiledScene, groups: &[usize]) -> Result<Self> {
        let (scene, group) = (&compiled.scene, groups[0]);
        let (bundle, key) = (compiled.bundle(group)?, format!("groups[{group}]"));
        let layout = CrowdLayout::<Vec2>::of_groups(scene, |g| groups.contains(&g))?;
        let orders = groups.iter().map(|&g| weighted_order(compiled, g).map(|(order, _)| order));
        let orders: Vec<PolicyOrder> = orders.collect::<Result<_>>()?;
        let num = groups.iter().map(|&g| scene.groups[g].count).sum();
        let fault = |e: Error| match e {
            Error::Occupied { who, .. } => {
                let why = format!(
                    "character {who} starts where another one or an obstacle is; enlarge `place`, or take a smaller `count`"
                );
                scene.fault(&key, why)
            }
            e => scene.fault(&key, e),
        };
        let config = characters_config(compiled, group);
        let mut made = Self {
            scene: Arc::clone(scene),
            groups: groups.to_vec(),
            people: PolicyCharacters::with_capacity(bundle, num, config).map_err(fault)?,
            navigation: Navigation::new(&Streets::new(&[], BODY_RADIUS_M)?, BODY_RADIUS_M, WALK_SPEED_MPS, num)?,
            travels: vec![TravelState::default(); num],
            begins: Vec::with_capacity(num),
            open_doors: scene.environment.doors.iter().map(|door| door.open).collect(),
            layout,
            targets: Vec::with_capacity(num),
        };
        let states = states_at_ease(bundle.graph());
        made.people.hold_entrants();
        let added = match scene.level.as_ref().filter(|level| level.all_floors) {
            Some(level) => made.add_on_all_floors(&Level::open(&level.file)?, &orders, &states),
            None => made.add_in_streets(&orders, &states),
        };
        added.map_err(fault)?;
        made.people.release_entrants();
        Ok(made)
    }

    /// Adds all people at their starts in streets.
    fn add_in_streets(&mut self, orders: &[PolicyOrder], states: &[u32]) -> Result<()> {
        let Self { scene, groups, people, layout, open_doors, begins, .. } = self;
        let mut streets = layout.setup.streets.clone().map_or_else(|| Streets::new(&[], BODY_RADIUS_M), Ok)?;
        let is_known = layout.setup.streets.is_some();
        for (d, &open) in open_doors.iter().enumerate().filter(|_| is_known) {
            streets.set_open(layout.first_door + d, open)?;
        }
        self.navigation = Navigation::new(&streets, BODY_RADIUS_M, WALK_SPEED_MPS, self.travels.len())?;
        let mut rng = Pcg64Mcg::seed_from_u64(scene.seed ^ groups[0] as u64);
        people.set_walls(&scene.environment.walls_and_closed_doors(open_doors));
        for ((agent, path), of) in layout.setup.agents.iter().zip(&layout.paths).zip(&layout.groups) {
            let order = orders[groups.iter().position(|g| g == of).unwrap_or_default()];
            let ahead = path.get(1).map_or(Vec2::Y, |next| *next - agent.position);
            let mut spawn = || spawn_at(people, agent.position.extend(0.0).xzy(), ahead, states, &mut rng);
            // Not every pose has room everywhere.
            let first = spawn();
            let id = (1..POSES_TRIED).fold(first, |made, _| made.or_else(|_| spawn()))?;
            let order = in_own_manner(order, &scene.groups[*of], id.index());
            people.order(id, order.with_target(agent.position.extend(0.0).xzy()))?;
            if let Some(route) = agent.route {
                let route = &layout.setup.routes[route];
                self.navigation.add_body(route, agent.position)?;
                begins.push((order, route.clone().map(|p| p.extend(0.0).xzy())));
            }
        }
        Ok(())
    }

    /// Opens and closes doors, as many as the scene has; none on the floors of a level.
    fn set_doors(&mut self, open: &[bool]) -> Result<()> {
        if self.open_doors == open || self.scene.level.as_ref().is_some_and(|level| level.all_floors) {
            return Ok(());
        }
        for d in (0..open.len()).filter(|&d| self.open_doors[d] != open[d]) {
            self.navigation.set_open(self.layout.first_door + d, open[d])?;
        }
        self.open_doors.copy_from_slice(open);
        self.people.set_walls(&self.scene.environment.walls_and_closed_doors(open));
        Ok(())
    }

    /// Adds all people at places of a level, on all its floors.
    fn add_on_all_floors(&mut self, level: &Level, orders: &[PolicyOrder], states: &[u32]) -> Result<()> {
        let Self { scene, groups, people, layout, begins, .. } = self;
        self.navigation = Navigation::in_level(level, BODY_RADIUS_M, WALK_SPEED_MPS, self.travels.len())?;
        people.set_ground(ground_of_level(level)?);
        people.set_walls(walls_of_level(level));
        layout.show_walls(walls_of_level(level).map(|w| [w.wall.from, w.wall.to]));
        let mut rng = Pcg64Mcg::seed_from_u64(scene.seed ^ groups[0] as u64);
        let ground = LevelGround::new(level);
        for (&g, order) in groups.iter().zip(orders) {
            let group = &scene.groups[g];
            let [starts, goals] = group.level_places().map(|names| places_of_level(level, names.unwrap_or_default()));
            for n in 0..group.count {
                let (mut made, mut reach_m) = (None, LEAST_REACH_M);
                while made.is_none() && reach_m < MOST_REACH_M {
                    let at = ground.draw_point(starts.get(n % starts.len().max(1)), reach_m, &mut rng);
                    let ahead = maths::direction_at_angle(rng.random_range(-PI..PI));
                    made = at.and_then(|at| Some((at, spawn_at(people, at, ahead, states, &mut rng).ok()?)));
                    reach_m *= REACH_GROWS;
                }
                let by = "another character or a wall";
                let (at, id) = made.ok_or_else(|| Error::Occupied { who: Id::first(n), by: by.into() })?;
                let goal = ground.draw_goal(&goals, at, &mut rng);
                let back = (group.at_end == AtEndConfig::Again).then_some(at);
                let subgoals = std::iter::once(goal).chain(back).collect();
                let route = Route { subgoals, arrival_radius: group.arrival_m, at_end: group.at_end.into() };
                let order = in_own_manner(*order, group, id.index());
                people.order(id, order.with_target(at))?;
                self.navigation.add_body_in_level(&route, at)?;
                begins.push((order, route));
                layout.add_person(g, [at.xz(), goal.xz()]);
            }
        }
        Ok(())
    }

    /// The characters.
    pub fn people(&self) -> &PolicyCharacters {
        &self.people
    }

    /// Starts, paths and goals.
    pub fn layout(&self) -> &CrowdLayout<Vec2> {
        &self.layout
    }

    /// A character's disc on the ground; `None` where it has left (number < num_characters).
    pub fn disc(&self, number: usize) -> Option<Disc> {
        let row = self.row(number)?;
        let (root, book) = (self.people.bodies().roots[row], self.people.characters().reservations());
        let velocity = book.map_or(Vec2::ZERO, |book| book.velocity(row));
        let centre = Vec3::new(root.x, self.people.characters().floor_m(row), root.z);
        let velocity = Vec3::new(velocity.x, 0.0, velocity.y);
        Some(Disc { root, centre, velocity, radius: BODY_RADIUS_M, knows: false })
    }

    /// Point that a character goes to now (m, number < num_characters).
    pub fn aim(&self, number: usize) -> Vec2 {
        self.navigation.aim(number).position
    }

    /// Length of the path that a character has left (m, number < num_characters).
    pub fn remaining_m(&self, number: usize) -> f32 {
        let aim = self.navigation.aim(number);
        let place = self.row(number).map(|row| self.people.bodies().roots[row]);
        place.map_or(0.0, |root| aim.position.distance(Vec2::new(root.x, root.z)) + aim.rest_m)
    }

    /// True for a character that has been at its goal (number < num_characters).
    pub fn has_arrived(&self, number: usize) -> bool {
        self.travels[number].has_arrived
    }

    /// True for a character that makes no progress (number < num_characters).
    pub fn is_stuck(&self, number: usize) -> bool {
        self.travels[number].is_stuck
    }

    /// Sets the route of a character: that of its order, else its first one.
    fn set_route(&mut self, number: usize, order: Option<&TravelOrder>) -> Result<()> {
        let first = &self.begins[number].1;
        let ordered = order.map(|o| Route { subgoals: vec![o.to], arrival_radius: o.arrival_m, at_end: AtEnd::Stay });
        let (route, at) = (ordered.as_ref().unwrap_or(first), order.map_or(first.subgoals[0], |o| o.at));
        match self.scene.level.as_ref().is_some_and(|level| level.all_floors) {
            true => self.navigation.set_route_in_level(number, route, at),
            false => self.navigation.set_route(number, &route.clone().map(|p| p.xz()), at.xz()),
        }
    }

    /// True for a character that waits before a closed door, or for its turn at a passage (number < num_characters).
    pub fn waits(&self, number: usize) -> bool {
        self.navigation.waits(number)
    }

    /// Row of a character; none where it has left. Ids are numbered as characters, since nobody enters later.
    fn row(&self, number: usize) -> Option<usize> {
        self.people.row(Id::first(number)).ok()
    }

    fn fault(&self, e: Error) -> Error {
        self.scene.fault(&format!("groups[{}]", self.groups[0]), e)
    }
}

/// Target of a character on its way: its goal where that is near, else a point ahead along the velocity that navigation gives, so
/// far that its policy does not slow down before it; its own place where it should wait.
///
/// - `wanted_mps`: speed that it is ordered, 0 where it is not (m/s).
fn target_ahead(place: Vec2, aim: &NavigationAim, wanted_mps: f32) -> Vec3 {
    let (left_m, speed) = (place.distance(aim.position) + aim.rest_m, aim.velocity.length());
    let target = if left_m < GOAL_NEAR_M || aim.has_arrived {
        aim.position
    } else if speed < WAITS_BELOW_MPS {
        place
    } else {
        place + aim.velocity * (TARGET_AHEAD_M.max(TARGET_AHEAD_S * wanted_mps).min(left_m) / speed)
    };
    Vec3::new(target.x, 0.0, target.y)
}

/// States in which people stand at ease; all in which they stand where there are none.
fn states_at_ease(graph: &MotionGraph) -> Vec<u32> {
    let resting = resting_states(graph);
    let segments = |s: u32| graph.segments_of(s).iter().map(|&segment| &graph.segments[segment as usize]);
    let idles = |s: &u32| segments(*s).any(|of| of.start == graph.states[*s as usize].frame && of.idle > 0);
    let at_ease: Vec<u32> = resting.iter().copied().filter(idles).collect();
    if at_ease.is_empty() { resting } else { at_ease }
}

/// Adds a person who stands in one of some states.
fn spawn_at(people: &mut PolicyCharacters, at: Vec3, ahead: Vec2, states: &[u32], rng: &mut Pcg64Mcg) -> Result<Id> {
    let root = Planar::new(at.x, at.z, maths::atan2(ahead.x, ahead.y));
    people.spawn(Spawn { root, state: Some(states[rng.random_range(0..states.len())]), floor_m: at.y })
}

/// Places of a level with some names (m).
fn places_of_level(level: &Level, names: &[String]) -> Vec<Vec3> {
    level.places().filter(|p| names.iter().any(|n| n == p.name)).map(|p| p.at).collect()
}

/// The largest part of a level's ground that no walk leaves, from which points are drawn.
struct LevelGround<'a> {
    level: &'a Level,
    component: u32,
    /// Lowest and highest x and z of the level (m).
    corners: [Vec2; 2],
}

impl<'a> LevelGround<'a> {
    fn new(level: &'a Level) -> Self {
        let of = |polygon: usize| level.component(polygon as u32);
        let mut sizes = BTreeMap::new();
        (0..level.num_polygons()).for_each(|p| *sizes.entry(of(p)).or_insert(0) += 1);
        let component = sizes.into_iter().max_by_key(|(_, size)| *size).map_or(0, |(component, _)| component);
        let all = || level.vertices().map(|at| at.xz());
        Self { level, component, corners: [all().fold(Vec2::MAX, Vec2::min), all().fold(Vec2::MIN, Vec2::max)] }
    }

    /// Point on the floor of a place and within a distance of it (m), or anywhere; none where the draw misses the ground.
    fn draw_point(&self, place: Option<&Vec3>, reach_m: f32, rng: &mut Pcg64Mcg) -> Option<Vec3> {
        let Some(place) = place else {
            let [low, high] = self.corners;
            let at = Vec2::new(rng.random_range(low.x..high.x), rng.random_range(low.y..high.y));
            let mut floors = Vec::new();
            self.level.add_heights(at, &mut floors);
            let height = *floors.get(rng.random_range(0..floors.len().max(1)))?;
            let found = self.level.nearest(Vec3::new(at.x, height, at.y), NEAR_M)?;
            return (self.level.component(found.polygon) == self.component).then_some(found.at);
        };
        let off =
            maths::direction_at_angle(rng.random_range(-PI..PI)) * (reach_m * rng.random_range(0.0..1.0f32).sqrt());
        let found = self.level.nearest(*place + Vec3::new(off.x, 0.0, off.y), NEAR_M)?.at;
        (found.xz().distance(place.xz()) <= reach_m).then_some(found)
    }

    /// True for level ground in all directions: nobody chooses to stand on stairs or in a door.
    fn is_room(&self, at: Vec3) -> bool {
        let off = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|off| at + off * ROOM_M);
        off.into_iter().all(|p| self.level.height_at(p).is_some_and(|height| (height - at.y).abs() < LEVEL_M))
    }

    /// Goal near one of some places, or anywhere; if it can be, with room and not near to where somebody starts.
    fn draw_goal(&self, places: &[Vec3], start: Vec3, rng: &mut Pcg64Mcg) -> Vec3 {
        let mut goal = start;
        for _ in 0..MOST_DRAWN {
            let place = (!places.is_empty()).then(|| &places[rng.random_range(0..places.len())]);
            goal = self.draw_point(place, GOAL_REACH_M, rng).unwrap_or(goal);
            if goal.distance(start) > MOST_REACH_M && self.is_room(goal) {
                break;
            }
        }
        goal
    }
}

/// Ground of all floors of a level.
///
/// # Errors
/// As [`HeightField::with_floors`].
fn ground_of_level(level: &Level) -> Result<HeightField> {
    let all = || level.vertices().map(|at| at.xz());
    let low = all().fold(Vec2::MAX, Vec2::min) - 1.0;
    let extent = all().fold(Vec2::MIN, Vec2::max) + 1.0 - low;
    let spacing = GROUND_SPACING_M.max((extent.x * extent.y / MOST_KNOTS).sqrt());
    let size = extent.to_array().map(|length| (length / spacing) as usize + 2);
    let floors = (0..size[0] * size[1]).map(|k| {
        let (mut out, knot) = (Vec::new(), Vec2::new((k % size[0]) as f32, (k / size[0]) as f32));
        level.add_heights(low + knot * spacing, &mut out);
        out
    });
    HeightField::with_floors(low, spacing, size, floors.collect())
}

/// Walls of a level.
fn walls_of_level(level: &Level) -> impl Iterator<Item = FloorWall> {
    level.walls_of_floors().map(|[from, to]| {
        let heights_m = [from.y.min(to.y), from.y.max(to.y)];
        FloorWall { wall: Capsule2d { from: from.xz(), to: to.xz(), radius_m: 0.0 }, heights_m }
    })
}

impl MotionKind for Travellers {
    fn num_characters(&self) -> usize {
        self.travels.len()
    }

    fn step(&mut self, tick: &GroupStep<'_>, events: &mut Vec<SimulationEvent>) -> Result<()> {
        let time_s = tick.until_s - f64::from(tick.dt_s);
        self.set_doors(tick.open_doors)?;
        let people = &self.people;
        self.navigation.update(time_s, |number| {
            let row = people.row(Id::first(number)).ok()?;
            let root = people.bodies().roots[row];
            let velocity = people.characters().reservations().map_or(Vec2::ZERO, |book| book.velocity(row));
            let height_m = people.characters().floor_m(row);
            Some(NavigatedBody { position: Vec2::new(root.x, root.z), velocity, height_m })
        });
        self.targets.clear();
        for (id, root) in self.people.ids().iter().zip(self.people.bodies().roots) {
            let (aim, place) = (self.navigation.aim(id.index()), Vec2::new(root.x, root.z));
            let wanted_mps = self.people.order_of(*id)?.speed_mps().unwrap_or(0.0);
            self.targets.push(target_ahead(place, &aim, wanted_mps));
            let travel = &mut self.travels[id.index()];
            if aim.has_arrived && !travel.has_arrived {
                events.push(tick.event(id.index(), CharacterEvent::Arrived));
            }
            // Who has arrived by an order, and stops there, is not stuck where that is a step beyond.
            let is_stuck = aim.is_stuck && !(travel.order.is_some() && travel.has_arrived);
            if is_stuck && !travel.is_stuck {
                events.push(tick.event(id.index(), CharacterEvent::Stuck));
            }
            (travel.has_arrived, travel.is_stuck) = (travel.has_arrived || aim.has_arrived, is_stuck);
        }
        self.people.aim_all(&self.targets, &self.targets).map_err(|e| self.fault(e))?;
        self.people.step(tick.dt_s, tick.run).map_err(|e| self.fault(e))?;
        for number in 0..self.travels.len() {
            let leaves = self.scene.groups[self.layout.groups[number]].at_end == AtEndConfig::Leave;
            let travel = &self.travels[number];
            if leaves && travel.order.is_none() && travel.has_arrived && self.row(number).is_some() {
                self.people.despawn(Id::first(number))?;
                events.push(tick.event(number, CharacterEvent::Left));
            }
        }
        Ok(())
    }

    fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
        self.people.add_reserved_regions(out);
    }

    fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        self.people.set_external_obstacles(others);
    }

    fn restart_on_free_ground(&mut self) {
        self.people.release_entrants();
    }

    fn save(&self, out: &mut Vec<u8>) {
        let people = saved_bytes(|out| self.people.save(out));
        TRAVELS.write(&(&self.open_doors, self.navigation.state(), &self.travels, people), out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        let (doors, state, travels, people): (Vec<bool>, NavigationState, Vec<TravelState>, Bytes) =
            TRAVELS.read_all(bytes)?;
        check_snapshot(doors.len() == self.open_doors.len(), TRAVELS.what, "its doors are others")?;
        self.set_doors(&doors)?;
        check_snapshot(travels.len() == self.travels.len(), TRAVELS.what, "its travels are others")?;
        for number in 0..travels.len() {
            let order = travels[number].order;
            let is_sound = order.is_none_or(|o| [o.to, o.at].iter().flat_map(Vec3::to_array).all(|x| x.abs() < 1e6));
            check_snapshot(is_sound, TRAVELS.what, "an order of its leads nowhere")?;
            let set = if order == self.travels[number].order { Ok(()) } else { self.set_route(number, order.as_ref()) };
            check_snapshot(set.is_ok(), TRAVELS.what, "an order of its leads nowhere")?;
        }
        check_snapshot(self.navigation.restore(&state), TRAVELS.what, "its travels are on no route")?;
        self.people.load(&people.0)?;
        let is_own = |id: &Id| id.index() < travels.len() && *id == Id::first(id.index());
        check_snapshot(self.people.ids().iter().all(is_own), TRAVELS.what, "its characters are others")?;
        self.travels = travels;
        Ok(())
    }

    fn order(&mut self, number: usize, goal: Option<(Vec3, f32)>, order: &Order) -> Result<()> {
        let id = Id::first(number);
        let row = self.row(number).ok_or(Error::Gone(id))?;
        let root = self.people.bodies().roots[row];
        let at = Vec3::new(root.x, self.people.characters().floor_m(row), root.z);
        let (to, arrival_m) = goal.unwrap_or((at, GOAL_NEAR_M));
        let travel = TravelOrder { to, at, arrival_m };
        let way = Capsule2d { from: at.xz(), to: to.xz(), radius_m: BODY_RADIUS_M };
        let walls = || self.scene.environment.walls_and_closed_doors(&self.open_doors);
        let is_open = !order.is_steered() || !walls().iter().any(|wall| wall.intersects(&way));
        ensure(is_open, || Error::NoPath { who: Some(id), from: at, to })?;
        let set = self.set_route(number, Some(&travel));
        let order_now = if set.is_ok() { Some(travel) } else { self.travels[number].order };
        if goal.is_some() {
            set?;
        }
        self.travels[number] = TravelState { order: order_now, has_arrived: goal.is_none(), is_stuck: false };
        let stand = order.heading.map_or(PolicyOrder::STOP, PolicyOrder::turn_to);
        let before = self.people.order_of(id)?.target();
        let new = if goal.is_some() { self.begins[number].0.with_target(before) } else { stand };
        self.people.order(id, new.at_speed(order.speed_mps().unwrap_or(0.0)))
    }

    fn turn_to(&mut self, number: usize, heading: f32) -> Result<()> {
        self.people.order(Id::first(number), PolicyOrder::turn_to(heading))
    }

    fn root(&self, number: usize) -> Option<Planar> {
        Some(self.people.bodies().roots[self.row(number)?])
    }

    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        Some(&self.people.bodies().model[self.row(number)?])
    }

    fn contacts(&self, number: usize) -> Contacts {
        self.row(number).map_or(Contacts::default(), |row| self.people.characters().contacts(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::graph::{MotionSegment, StateRecord};

    #[test]
    fn people_begin_at_ease_where_their_motion_has_that() {
        let state = |frame, standing| StateRecord { frame, standing };
        let segment = |start, end, idle| {
            let displacement = [0.0; 3];
            MotionSegment { start, num_frames: 10, end, clip: 0, displacement, idle }
        };
        let graph = |idle, standing| MotionGraph {
            states: vec![state(10, standing), state(20, 0), state(30, standing)].into(),
            segments: vec![segment(0, 2, 0), segment(10, 1, 0), segment(30, 0, idle)].into(),
            action_offsets: vec![0, 1, 2, 3].into(),
            action_segments: vec![1, 0, 2].into(),
            action_errors: vec![0.0; 3].into(),
        };
        assert_eq!(states_at_ease(&graph(10, 1)), [2]);
        assert_eq!(states_at_ease(&graph(0, 1)), [0, 2], "all that stand, where nobody is at ease");
        assert_eq!(states_at_ease(&graph(0, 0)), [0, 1, 2]);
    }
}
