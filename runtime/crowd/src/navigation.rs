//! Navigation for bodies that something else moves: captured motion, or the characters of an engine.

mod level;

use crate::events::decide::{BEFORE_DOOR_M, SAME_GOAL_M};
use crate::routes::passages::{GATHER_M, PassageAdvice, PassageTurn, PassageTurns, PassageUse, Passages};
use crate::routes::path::{RouteCursor, RoutePath, is_in_solid};
use crate::space::solid::{ConvexSolid, solids};
use crate::steering::forces::{ForceSurroundings, SteeredAgent, desired_velocity};
use crate::{AtEnd, CrowdError, ForceField, Obstacle, Route, Space, steering::density_grid::DensityGrid};
use crate::{error::check, routes::goals::GoalTable, routes::guide::Guide, routes::streets::Streets};
use crate::{steering::config::SteeringConfig, steering::retreat::BlockedAgent, steering::sight::SeenNeighbour};
use glam::{Vec2, Vec3, Vec3Swizzles};
use level::LevelRoutes;
use throng_base::{Error, Id, Result, ground::FLOOR_M};
use throng_level::Level;

/// Extent of the ground that the squares of the density grid cover before they repeat (m).
const GROUND_M: f32 = 500.0;

/// Height of a storey, whose bodies share a density grid (m), and most storeys.
const STOREY_M: f32 = 4.0;
const MOST_STOREYS: f32 = 100.0;

/// Side of the cells in which neighbours are looked for (m).
const CELL_M: f32 = 5.0;
/// Most neighbours, and most solids, that a body sees.
const MOST_SEEN: usize = 24;
/// Time after which a body looks for a new velocity (s).
const STEER_S: f64 = 0.1;
/// Distance from a place at a corner within which a body goes on to the next one (m).
const REACHED_M: f32 = 0.3;
/// Distance from its aim at which a body may stop (m).
const STOPS_M: f32 = 0.6;
/// Room that is kept from walls, beside the radius: a step that turns aside needs it; not in passages and before them (m).
const WALL_ROOM_M: f32 = 0.2;
/// Room that captured people need beside them in a passage, beyond the radius (m).
const PASSAGE_ROOM_M: f32 = 0.15;
/// Distance that is kept to whoever enters a passage before, and width that each needs of those who enter side by side (m).
const FILE_M: f32 = 0.7;
const ABREAST_M: f32 = 0.9;
/// Widths below which two captured people, and streams of them, block each other, in radii, and duration of their turns (s).
const NARROW_RADII: [f32; 2] = [4.4, 6.5];
const TURN_S: f64 = 35.0;
/// Time without progress after which a body steps back where that helps (s).
const PATIENCE_S: f64 = 3.0;
/// Progress without which a body is stuck after a time (m, s).
const PROGRESS_M: f32 = 0.5;
const STUCK_AFTER_S: f64 = 10.0;
/// Time without progress after which a body arrives behind others who stand at its goal (s), and room between it and them (m).
const SETTLES_S: f64 = 2.0;
const SETTLES_WITHIN_M: f32 = 0.7;
/// No neighbour.
const UNSEEN: SeenNeighbour<Vec2> =
    SeenNeighbour { offset: Vec2::ZERO, velocity: Vec2::ZERO, distance: f32::INFINITY, radii: 0.0, yields: true };
/// Force field of captured people, who turn and stop within a step: they look farther ahead, and keep more room.
const CAPTURED: ForceField =
    ForceField { horizon_s: 3.0, comfort_m: 0.08, headway_s: 0.8, headway_m: 0.6, ..ForceField::COMMUTER };

/// A body that moves over the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigatedBody {
    /// Position (m).
    pub position: Vec2,
    /// Velocity (m/s).
    pub velocity: Vec2,
    /// Height of the ground below it, which tells floors of a level apart (m).
    pub height_m: f32,
}

/// Next part of a body's route: the point that it goes to, and the velocity to go there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigationAim {
    /// Point on the path that it goes to: its goal, or a place at the next corner (m).
    pub position: Vec2,
    /// Distance from there to the end of the route (m).
    pub rest_m: f32,
    /// Velocity at which it should go on among others (m/s).
    pub velocity: Vec2,
    /// True for a body at the end of its route.
    pub has_arrived: bool,
    /// True for a body that has made no progress for 10 s.
    pub is_stuck: bool,
}

/// State of all bodies on their routes, for snapshots.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct NavigationState {
    /// (bodies)
    progress: Vec<RouteProgress>,
    /// Turns of passages.
    turns: Vec<PassageTurn>,
}

/// Progress of a body on its route.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
struct RouteProgress {
    cursor: RouteCursor<Vec2>,
    /// Velocity at which the body should go on (m/s), and when that is found anew (s).
    velocity: Vec2,
    steers_at_s: f64,
    /// Least distance from the end of the route so far (m), and the time at which it was less by [`PROGRESS_M`] (s).
    least_left_m: f32,
    progressed_at_s: f64,
    has_arrived: bool,
    /// True where others at its goal keep it from going on.
    is_kept: bool,
    /// True where it waits before a closed door, or for its turn at a passage.
    waits: bool,
    /// Number of the closed door on its way, or 0.
    door: u8,
}

/// Paths of bodies that something else moves.
///
/// Every body has a route, and gets the next point to go to: its goal where it sees it, otherwise the place at the next
/// corner by which it expects to arrive first, as agents of a [`crate::Crowd`] do. Navigation does not keep bodies apart:
/// reserved paths do.
///
/// ```
/// use glam::{Vec2, Vec3};
/// use throng_crowd::{AtEnd, NavigatedBody, Navigation, Obstacle, Route, Streets};
///
/// let wall = Obstacle::Wall { from: Vec3::new(-5.0, 0.0, 0.0), to: Vec3::new(5.0, 0.0, 0.0), radius: 0.1 };
/// let mut navigation = Navigation::new(&Streets::new(&[wall], 0.5)?, 0.3, 1.3, 1)?;
/// let at = Vec2::new(0.0, -3.0);
/// let route = Route { subgoals: vec![Vec2::new(0.0, 3.0)], arrival_radius: 0.5, at_end: AtEnd::Stay };
/// let body = navigation.add_body(&route, at)?;
/// navigation.update(0.0, |_| Some(NavigatedBody { position: at, velocity: Vec2::ZERO, height_m: 0.0 }));
/// assert!(navigation.aim(body).position.x.abs() > 5.0); // round one of the ends
/// # Ok::<(), throng_base::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Navigation {
    streets: Option<Streets>,
    level: Option<LevelRoutes>,
    obstacles: Vec<Obstacle<Vec2>>,
    /// Solids of each obstacle, and those of all that are not open.
    solids: Vec<Vec<ConvexSolid<Vec2>>>,
    all_solids: Vec<ConvexSolid<Vec2>>,
    goals: GoalTable,
    passages: Passages,
    turns: PassageTurns,
    /// Density grid of each storey, from the lowest ground up.
    grids: Vec<DensityGrid<Vec2>>,
    /// Height of the lowest ground (m).
    lowest_m: f32,
    steering: SteeringConfig,
    field: ForceField,
    radius_m: f32,
    /// Desired speed (m/s).
    speed_mps: f32,
    paths: Vec<RoutePath<Vec2>>,
    progress: Vec<RouteProgress>,
    /// Bodies by the cell that they are in, in the order of cells.
    by_cell: Vec<(u64, u32)>,
    bodies: Vec<Option<NavigatedBody>>,
    /// Passage on the way of each body.
    uses: Vec<Option<PassageUse>>,
    /// Time of the last update (s).
    time_s: f64,
}

impl Navigation {
    /// Navigation in streets, with room for so many bodies.
    ///
    /// - `radius_m`: radius of the bodies (m, above 0).
    /// - `speed_mps`: their desired speed (m/s).
    ///
    /// # Errors
    /// [`Error::Value`] for a radius or speed out of range.
    pub fn new(streets: &Streets, radius_m: f32, speed_mps: f32, capacity: usize) -> Result<Self> {
        check("radius_m", 0, radius_m, radius_m > 0.0 && radius_m < 1e3, "above 0 and below 1000")?;
        check("speed_mps", 0, speed_mps, (0.0..100.0).contains(&speed_mps), "between 0 and 100")?;
        let steering = SteeringConfig::default();
        let obstacles: Vec<Obstacle<Vec2>> =
            streets.obstacles().iter().map(|o| o.clone().map(Vec2::from_world)).collect();
        let solids: Vec<Vec<ConvexSolid<Vec2>>> =
            obstacles.iter().enumerate().map(|(n, o)| solids(n, o)).collect::<Result<_>>()?;
        let room_m = radius_m + PASSAGE_ROOM_M;
        let passages = Passages::find_below(streets, room_m, &NARROW_RADII.map(|radii| radii * room_m), 0.0);
        Ok(Self {
            turns: PassageTurns::new(&passages, TURN_S),
            passages,
            streets: Some(streets.clone()).filter(|s| !s.is_open()),
            level: None,
            all_solids: solids_that_stand(streets, &solids),
            solids,
            obstacles,
            goals: GoalTable::default(),
            grids: vec![DensityGrid::new(steering.square_radii * radius_m, Vec2::splat(GROUND_M), capacity)],
            lowest_m: 0.0,
            steering,
            field: CAPTURED,
            radius_m,
            speed_mps,
            paths: Vec::with_capacity(capacity),
            progress: Vec::with_capacity(capacity),
            by_cell: Vec::with_capacity(capacity),
            bodies: Vec::with_capacity(capacity),
            uses: Vec::with_capacity(capacity),
            time_s: 0.0,
        })
    }

    /// Navigation in a level, on all its floors; bodies walk, and take no links.
    ///
    /// - `radius_m`, `speed_mps`: as in [`Navigation::new`].
    ///
    /// # Errors
    /// As [`Navigation::new`].
    pub fn in_level(level: &Level, radius_m: f32, speed_mps: f32, capacity: usize) -> Result<Self> {
        let empty = Self::new(&Streets::new(&[], radius_m)?, radius_m, speed_mps, capacity)?;
        let (routes, all_solids) = LevelRoutes::new(level);
        let passages = routes.find_passages(radius_m + PASSAGE_ROOM_M)?;
        let heights =
            level.vertices().fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], at| [l.min(at.y), h.max(at.y)]);
        let lowest_m = if level.num_polygons() > 0 { heights[0] } else { 0.0 };
        let num_storeys = ((heights[1] - lowest_m) / STOREY_M).round().clamp(0.0, MOST_STOREYS) as usize + 1;
        let grids = vec![empty.grids[0].clone(); num_storeys];
        let turns = PassageTurns::new(&passages, TURN_S);
        Ok(Self { level: Some(routes), all_solids, turns, passages, grids, lowest_m, ..empty })
    }

    /// Adds a body in a level, and returns its number: that of the bodies before it.
    ///
    /// # Errors
    /// As [`Navigation::set_route`]; [`Error::NoPath`] where nobody can walk to the first subgoal, or without a level.
    pub fn add_body_in_level(&mut self, route: &Route<Vec3>, at: Vec3) -> Result<usize> {
        let route = self.prepare_route_in_level(self.paths.len(), route, at)?;
        let body = self.add_body(&route.clone().map(|p| p.xz()), at.xz())?;
        self.level.iter_mut().for_each(|level| level.set_heights(body, &route));
        Ok(body)
    }

    fn prepare_route_in_level(&mut self, body: usize, route: &Route<Vec3>, at: Vec3) -> Result<Route<Vec3>> {
        for subgoal in &route.subgoals {
            check("route.subgoals", body, subgoal.y, subgoal.y.abs() < 1e6, "finite and within 1e6 m")?;
        }
        let level = self.level.as_mut().ok_or(Error::NoPath { who: Some(Id::first(body)), from: at, to: at })?;
        level.prepare_route(body, route, at)
    }

    /// Adds a body, and returns its number: that of the bodies before it.
    ///
    /// # Errors
    /// As [`Navigation::set_route`].
    pub fn add_body(&mut self, route: &Route<Vec2>, at: Vec2) -> Result<usize> {
        let body = self.paths.len();
        let path = self.prepare_path(body, route, at)?;
        self.progress.push(RouteProgress::begin(&path, self.time_s));
        self.paths.push(path);
        self.uses.push(None);
        Ok(body)
    }

    /// Gives a body another route, on which it begins at the first subgoal.
    ///
    /// # Errors
    /// [`Error::Value`] for a route without subgoals, or with numbers out of range, [`Error::NoPath`] where a subgoal is
    /// in an obstacle, or no path leads to the first one; nothing has changed then.
    pub fn set_route(&mut self, body: usize, route: &Route<Vec2>, at: Vec2) -> Result<()> {
        throng_base::error::check_index("body", None, body, self.paths.len())?;
        let path = self.prepare_path(body, route, at)?;
        self.paths[body].goals.iter().for_each(|&goal| self.goals.release(goal));
        self.progress[body] = RouteProgress::begin(&path, self.time_s);
        self.paths[body] = path;
        Ok(())
    }

    /// Gives a body in a level another route, see [`Navigation::set_route`].
    ///
    /// # Errors
    /// As [`Navigation::add_body_in_level`]; nothing has changed then.
    pub fn set_route_in_level(&mut self, body: usize, route: &Route<Vec3>, at: Vec3) -> Result<()> {
        let route = self.prepare_route_in_level(body, route, at)?;
        self.set_route(body, &route.clone().map(|p| p.xz()), at.xz())?;
        self.level.iter_mut().for_each(|level| level.set_heights(body, &route));
        Ok(())
    }

    /// Opens an obstacle, or closes it: see [`Streets::set_open`]. In a level there are none.
    ///
    /// # Errors
    /// As [`Streets::set_open`].
    pub fn set_open(&mut self, obstacle: usize, open: bool) -> Result<()> {
        if let Some(streets) = &mut self.streets {
            streets.set_open(obstacle, open)?;
            self.all_solids = solids_that_stand(streets, &self.solids);
            self.goals.find_again(streets, true);
            self.progress.iter_mut().for_each(|p| p.cursor.look_at = 0.0);
        }
        Ok(())
    }

    fn prepare_path(&mut self, body: usize, route: &Route<Vec2>, at: Vec2) -> Result<RoutePath<Vec2>> {
        let mut path = RoutePath::new(body, route, &self.all_solids)?;
        for (subgoal, &goal) in route.subgoals.iter().enumerate() {
            let holds = |(o, solids): (&Obstacle<Vec2>, &Vec<_>)| is_in_solid(goal, o, solids);
            if let Some(obstacle) = self.obstacles.iter().zip(&self.solids).position(holds) {
                return Err(CrowdError::Goal { route: body, subgoal, obstacle }.into());
            }
        }
        if let Some(streets) = &self.streets {
            path.goals = path.subgoals().map(|g| self.goals.take_goal(streets, g.to_world())).collect();
            let costs = path.goal_of(0).map(|number| self.goals.costs(number));
            if costs.is_some_and(|costs| streets.check_path(at, costs).is_err()) {
                path.goals.iter().for_each(|&goal| self.goals.release(goal));
                let to = path.subgoal(0).0;
                return Err(Error::NoPath { who: Some(Id::first(body)), from: at.to_world(), to: to.to_world() });
            }
        }
        Ok(path)
    }

    /// Updates the aims and velocities of all bodies. Allocates nothing.
    ///
    /// - `time_s`: (s)
    /// - `body`: motion of each body by its number; none for one that has left.
    pub fn update(&mut self, time_s: f64, body: impl Fn(usize) -> Option<NavigatedBody>) {
        self.time_s = time_s;
        self.bodies.clear();
        self.bodies.extend((0..self.paths.len()).map(body));
        self.grids.iter_mut().for_each(DensityGrid::clear);
        self.by_cell.clear();
        for (number, (progress, body)) in (0u32..).zip(self.progress.iter().zip(&self.bodies)) {
            let Some(NavigatedBody { position, velocity, height_m }) = *body else { continue };
            let aim = progress.cursor.aim;
            let intent = if progress.has_arrived { Vec2::ZERO } else { Space::unit_and_length(aim - position).0 };
            let storey = self.storey_of(height_m);
            self.grids[storey].add(position, velocity, intent);
            let aim = if progress.has_arrived { position } else { aim };
            self.uses[number as usize] = self.passages.find_use(position, aim, height_m);
            self.uses[number as usize].iter().for_each(|found| self.turns.count(found));
            self.by_cell.push((cell_key(cell_of(position)), number));
        }
        self.by_cell.sort_unstable();
        self.turns.update(&self.passages, time_s);
        let mut level = self.level.take();
        for number in 0..self.paths.len() {
            let Some(body) = self.bodies[number] else { continue };
            let mut progress = self.progress[number];
            self.follow_route(number, &body, time_s, level.as_mut(), &mut progress);
            if time_s >= progress.steers_at_s {
                progress.velocity = self.find_velocity(number, &body, &mut progress, time_s, level.as_ref());
                progress.steers_at_s = time_s + STEER_S;
            }
            self.progress[number] = progress;
        }
        self.level = level;
    }

    /// Number of the storey at a height (m).
    fn storey_of(&self, height_m: f32) -> usize {
        let storey = ((height_m - self.lowest_m) / STOREY_M).round().max(0.0) as usize;
        storey.min(self.grids.len() - 1)
    }

    /// Passes subgoals, and finds the aim anew where that is due.
    fn follow_route(
        &self,
        number: usize,
        body: &NavigatedBody,
        time_s: f64,
        level: Option<&mut LevelRoutes>,
        progress: &mut RouteProgress,
    ) {
        let (streets, goals, steering) = (self.streets.as_ref(), &self.goals, &self.steering);
        let grid = &self.grids[self.storey_of(body.height_m)];
        let guide = Guide { streets, goals, grid, steering, reached_m: REACHED_M };
        let (path, cursor, position) = (&self.paths[number], &mut progress.cursor, body.position);
        let leg = cursor.leg;
        let again = match &level {
            Some(level) => path.advance_cursor(cursor, |leg| level.is_at(number, path, leg, body)),
            None => path.pass_subgoals_within(cursor, position, STOPS_M),
        };
        let is_on_floor = level.as_ref().is_none_or(|level| level.is_at(number, path, cursor.leg, body));
        let has_arrived = path.has_arrived(cursor, position) && is_on_floor;
        let near = cursor.aim.distance_squared(position) < steering.corner_m * steering.corner_m;
        if time_s >= cursor.look_at || cursor.rest > 0.0 && near || leg != cursor.leg {
            match level {
                Some(level) => level.find_aim(number, path, cursor, body),
                None => progress.door = guide.find_aim(path, cursor, position, self.radius_m),
            }
            cursor.look_at = time_s + steering.look_s;
        }
        let left_m = path.distance_left(cursor, position);
        let waits = progress.has_arrived || time_s - progress.progressed_at_s > SETTLES_S;
        let is_kept = !again && !has_arrived && waits && self.is_kept_from_goal(number, body, cursor);
        let goes_on = progress.is_kept && !is_kept;
        progress.is_kept = is_kept;
        if is_kept {
            // It has come as near as it can, and stands there.
            (cursor.aim, cursor.rest) = (position, 0.0);
        }
        if goes_on {
            // Its aim was its own place.
            (cursor.look_at, progress.least_left_m, progress.progressed_at_s) = (time_s, f32::INFINITY, time_s);
        }
        progress.has_arrived = again || has_arrived || is_kept;
        if again || progress.has_arrived || left_m < progress.least_left_m - PROGRESS_M {
            progress.least_left_m = if again { f32::INFINITY } else { left_m };
            progress.progressed_at_s = time_s;
        }
    }

    /// True where a body stays behind others who stand at its goal.
    fn is_kept_from_goal(&self, number: usize, body: &NavigatedBody, cursor: &RouteCursor<Vec2>) -> bool {
        let goal = self.paths[number].goal();
        let may_settle = cursor.rest == 0.0 && self.paths[number].route.at_end == AtEnd::Stay;
        may_settle
            && self.is_behind_one(number, body, goal, |other| {
                self.progress[other].has_arrived && self.paths[other].goal().distance(goal) < SAME_GOAL_M
            })
    }

    /// True where another body in some state is nearer to a place than a body, and next to it.
    fn is_behind_one(&self, number: usize, body: &NavigatedBody, to: Vec2, is_one: impl Fn(usize) -> bool) -> bool {
        let (at, mut is_behind) = (body.position, false);
        self.for_each_near(at, |other| {
            let Some(its) = self.bodies[other].filter(|_| other != number && is_one(other)) else { return };
            let is_before = its.position.distance(to) < at.distance(to);
            let touches = its.position.distance(at) < 2.0 * self.radius_m + SETTLES_WITHIN_M
                && (its.height_m - body.height_m).abs() < FLOOR_M;
            is_behind |= is_before && touches;
        });
        is_behind
    }

    /// Velocity at which a body should go on among others, as an agent of a [`crate::Crowd`] would like to.
    fn find_velocity(
        &self,
        number: usize,
        body: &NavigatedBody,
        progress: &mut RouteProgress,
        time_s: f64,
        level: Option<&LevelRoutes>,
    ) -> Vec2 {
        let NavigatedBody { position, velocity, height_m } = *body;
        let grid = &self.grids[self.storey_of(height_m)];
        let (desired, distance) = Space::unit_and_length(progress.cursor.aim - position);
        let found = self.uses[number].filter(|_| !progress.has_arrived);
        let mut me = SteeredAgent {
            position,
            velocity,
            radius: self.radius_m + if found.is_some() { 0.0 } else { WALL_ROOM_M },
            limit: 1.0,
            desired,
            speed: self.speed_mps,
            distance_left: distance + progress.cursor.rest,
            ..SteeredAgent::default()
        };
        let at_door = self.advise_at_door(number, body, progress);
        let advice = at_door.or_else(|| {
            let found = found?;
            let advice = self.turns.advise(&found, position, self.radius_m + PASSAGE_ROOM_M);
            let waits = advice == PassageAdvice::Enter && !found.is_inside && self.is_behind(number, position, &found);
            Some(if !waits {
                advice
            } else if found.distance < FILE_M {
                found.give_way_from_mouth(position)
            } else {
                PassageAdvice::Stand
            })
        });
        progress.waits = advice.is_some_and(|advice| advice != PassageAdvice::Enter);
        if progress.waits {
            // Who waits for its turn is in no jam.
            progress.progressed_at_s = time_s;
            progress.least_left_m = progress.least_left_m.max(me.distance_left);
        }
        match advice {
            Some(PassageAdvice::Stand) => return Vec2::ZERO,
            Some(PassageAdvice::GiveWay(direction, share)) => {
                (me.desired, me.speed, me.retreats) = (direction, share * self.speed_mps, true);
            }
            _ => {}
        }
        let waited = time_s - progress.progressed_at_s;
        if waited > PATIENCE_S && !progress.has_arrived && !found.is_some_and(|found| found.is_inside) {
            // Who makes no progress steps back: the few before the many, else some by chance.
            let blocked = BlockedAgent { position, ahead: desired, waited, half: None };
            let by_chance = || blocked.random_retreat_direction(number as u32, time_s, grid, &self.steering);
            let outnumbered = blocked.retreat_direction(grid, &self.steering).filter(|_| found.is_none());
            let retreat = outnumbered.or_else(by_chance);
            if let Some(direction) = retreat {
                (me.desired, me.retreats) = (direction, true);
            }
        }
        let (mut seen, num) = ([UNSEEN; MOST_SEEN], &mut 0);
        self.for_each_near(position, |other| {
            let is_seen = |b: &NavigatedBody| other != number && (b.height_m - height_m).abs() < FLOOR_M;
            let Some(its) = self.bodies[other].filter(is_seen) else { return };
            let offset = its.position - position;
            let one = SeenNeighbour {
                offset,
                velocity: its.velocity,
                distance: offset.length(),
                radii: 2.0 * self.radius_m,
                yields: true,
            };
            add_nearest(&mut seen, num, one);
        });
        let (mut near, mut num_near) = ([0; MOST_SEEN], 0);
        let reach = self.speed_mps * self.field.horizon_s + self.radius_m;
        if let Some(level) = level {
            num_near = level.gather_walls(&self.all_solids, body, reach, &mut near);
        }
        for (solid, number) in self.all_solids.iter().zip(0u32..).filter(|_| level.is_none()) {
            if num_near < MOST_SEEN && solid.direction_and_distance(position).1 < reach {
                near[num_near] = number;
                num_near += 1;
            }
        }
        let around = ForceSurroundings {
            seen: &seen[..*num],
            solids: &self.all_solids,
            near: &near[..num_near],
            walls: &near[..num_near],
            grid,
            interests: &[],
            steering: &self.steering,
        };
        desired_velocity(&me, &self.field, &around)
    }

    /// Advice to a body that waits before a closed door; none to all others.
    fn advise_at_door(&self, number: usize, body: &NavigatedBody, progress: &RouteProgress) -> Option<PassageAdvice> {
        let (at, radius) = (body.position, self.radius_m + WALL_ROOM_M);
        let streets = self.streets.as_ref().filter(|_| !progress.has_arrived)?;
        let door = streets.closed_door(progress.door).filter(|door| door.distance(at) < BEFORE_DOOR_M)?;
        let advice = door.advise(number, at, radius, |to| streets.sees_place(at, to, radius, false));
        let is_behind = advice == PassageAdvice::Queue
            && self.is_behind_one(number, body, door.middle(), |other| {
                let its = &self.progress[other];
                its.waits && its.door == progress.door
            });
        Some(if is_behind { PassageAdvice::Stand } else { advice })
    }

    /// True for a body before a passage that as many as have room side by side would enter with or before it.
    fn is_behind(&self, number: usize, place: Vec2, own: &PassageUse) -> bool {
        let mut num_before = 0;
        self.for_each_near(place, |other| {
            let Some(its) = self.uses[other].filter(|its| other != number && its.is_before(own)) else { return };
            let is_first = (its.distance, other) < (own.distance, number);
            num_before += u32::from(is_first && own.distance - its.distance < FILE_M);
        });
        own.distance < GATHER_M && num_before >= ((own.narrowest / ABREAST_M) as u32).max(1)
    }

    /// Calls a function with each body in the cell of a place and in those around it.
    fn for_each_near(&self, place: Vec2, mut visit: impl FnMut(usize)) {
        let [x, z] = cell_of(place);
        for key in (-1..=1).flat_map(|dx| (-1..=1).map(move |dz| cell_key([x + dx, z + dz]))) {
            let first = self.by_cell.partition_point(|(k, _)| *k < key);
            self.by_cell[first..].iter().take_while(|(k, _)| *k == key).for_each(|(_, other)| visit(*other as usize));
        }
    }

    /// Next part of a body's route, as of the last update (body < number of bodies).
    pub fn aim(&self, body: usize) -> NavigationAim {
        let RouteProgress { cursor, velocity, has_arrived, progressed_at_s, .. } = self.progress[body];
        let is_stuck = !has_arrived && self.time_s - progressed_at_s > STUCK_AFTER_S;
        NavigationAim { position: cursor.aim, rest_m: cursor.rest, velocity, has_arrived, is_stuck }
    }

    /// True for a body that waits before a closed door, or for its turn at a passage (body < number of bodies).
    pub fn waits(&self, body: usize) -> bool {
        self.progress[body].waits
    }

    /// State of all bodies, for a snapshot.
    pub fn state(&self) -> NavigationState {
        NavigationState { progress: self.progress.clone(), turns: self.turns.saved().to_vec() }
    }

    /// Restores the state of bodies on the same routes; false where it is that of other routes, and nothing changes.
    pub fn restore(&mut self, state: &NavigationState) -> bool {
        let is_sound = |(path, saved): (&RoutePath<Vec2>, &RouteProgress)| {
            let RouteProgress { cursor, velocity, steers_at_s, least_left_m, progressed_at_s, .. } = saved;
            let is_near = cursor.aim.abs().max_element() < 1e6 && (0.0..1e9).contains(&cursor.rest);
            let is_in_time = [cursor.look_at, *steers_at_s, *progressed_at_s].iter().all(|t| (0.0..1e9).contains(t));
            let is_slow = velocity.abs().max_element() < 1e3 && *least_left_m >= 0.0;
            (cursor.leg as usize) < path.num_legs() && is_near && is_slow && is_in_time
        };
        let NavigationState { progress, turns } = state;
        let is_same = progress.len() == self.paths.len() && self.paths.iter().zip(progress).all(is_sound);
        let is_same = is_same && self.turns.is_possible(turns, 1e9);
        if is_same {
            self.progress.copy_from_slice(progress);
            self.turns.restore(turns);
        }
        is_same
    }
}

impl RouteProgress {
    /// Beginning of a route, on the way to its first subgoal.
    fn begin(path: &RoutePath<Vec2>, time_s: f64) -> Self {
        let (aim, rest) = path.subgoal(0);
        let cursor = RouteCursor { leg: 0, aim, rest, look_at: 0.0 };
        Self {
            cursor,
            velocity: Vec2::ZERO,
            steers_at_s: 0.0,
            least_left_m: f32::INFINITY,
            progressed_at_s: time_s,
            has_arrived: false,
            is_kept: false,
            waits: false,
            door: 0,
        }
    }
}

/// Solids of all obstacles that are not open.
fn solids_that_stand(streets: &Streets, solids: &[Vec<ConvexSolid<Vec2>>]) -> Vec<ConvexSolid<Vec2>> {
    let stand = solids.iter().enumerate().filter(|(obstacle, _)| !streets.is_open_door(*obstacle));
    stand.flat_map(|(_, solids)| solids.iter().cloned()).collect()
}

/// Cell of a place.
fn cell_of(place: Vec2) -> [i32; 2] {
    (place / CELL_M).floor().to_array().map(|c| c as i32)
}

/// Number by which the bodies of a cell lie side by side.
fn cell_key([x, z]: [i32; 2]) -> u64 {
    u64::from(x as u32) << 32 | u64::from(z as u32)
}

/// Adds a neighbour to the nearest ones, in place of the farthest where there is no room.
fn add_nearest(seen: &mut [SeenNeighbour<Vec2>; MOST_SEEN], num: &mut usize, one: SeenNeighbour<Vec2>) {
    if *num < MOST_SEEN {
        seen[*num] = one;
        *num += 1;
        return;
    }
    let farthest = seen.iter_mut().max_by(|a, b| a.distance.total_cmp(&b.distance));
    if let Some(farthest) = farthest.filter(|f| one.distance < f.distance) {
        *farthest = one;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route(points: &[[f32; 2]]) -> Route<Vec2> {
        let subgoals = points.iter().map(|&p| Vec2::from_array(p)).collect();
        Route { subgoals, arrival_radius: 0.5, at_end: AtEnd::Stay }
    }

    fn wall(from: [f32; 2], to: [f32; 2]) -> Obstacle {
        let at = |[x, z]: [f32; 2]| Vec3::new(x, 0.0, z);
        Obstacle::Wall { from: at(from), to: at(to), radius: 0.1 }
    }

    /// Walks straight to each aim, and returns the time of arrival and the path.
    fn walk(obstacles: &[Obstacle], from: Vec2, to: [f32; 2]) -> (f64, Vec<Vec2>) {
        let mut navigation = Navigation::new(&Streets::new(obstacles, 0.45).unwrap(), 0.3, 1.3, 1).unwrap();
        navigation.add_body(&route(&[to]), from).unwrap();
        let (mut at, mut path) = (from, vec![from]);
        for step in 0..6000 {
            let time_s = f64::from(step) / 60.0;
            navigation.update(time_s, |_| Some(NavigatedBody { position: at, velocity: Vec2::ZERO, height_m: 0.0 }));
            let aim = navigation.aim(0);
            if aim.has_arrived {
                return (time_s, path);
            }
            at += Space::unit_and_length(aim.position - at).0 * (1.3 / 60.0);
            path.push(at);
        }
        panic!("it never arrives: {at}");
    }

    #[test]
    fn bodies_find_their_way_round_walls_and_through_doors() {
        let long = [wall([-8.0, 0.0], [8.0, 0.0])];
        let corner = [wall([-5.0, 0.0], [5.0, 0.0]), wall([5.0, 0.0], [5.0, -6.0])];
        let door = [wall([-9.0, 0.0], [2.0, 0.0]), wall([4.0, 0.0], [15.0, 0.0])];
        for (walls, shortest) in [(&long[..], 17.0), (&corner[..], 16.0), (&door[..], 8.0)] {
            let (time_s, path) = walk(walls, Vec2::new(0.0, -3.0), [0.0, 3.0]);
            let nearest = path.iter().flat_map(|p| {
                walls.iter().map(move |w| match w {
                    Obstacle::Wall { from, to, radius } => {
                        let ends = [Vec2::new(from.x, from.z), Vec2::new(to.x, to.z)];
                        throng_geometry::distance_to_segment(*p, ends) - radius
                    }
                    _ => f32::INFINITY,
                })
            });
            let nearest = nearest.fold(f32::INFINITY, f32::min);
            assert!(nearest > 0.28, "{nearest} m from a wall");
            assert!(1.3 * time_s < 1.25 * shortest, "{time_s} s");
        }
    }

    #[test]
    fn who_stands_beside_the_first_before_a_gap_makes_room_for_it() {
        let walls = [wall([-9.0, 0.0], [-0.6, 0.0]), wall([0.6, 0.0], [9.0, 0.0])];
        let mut navigation = Navigation::new(&Streets::new(&walls, 0.45).unwrap(), 0.24, 1.3, 3).unwrap();
        let places = [[-0.25, -1.0], [0.3, -1.1], [0.0, -1.65]].map(Vec2::from_array);
        for place in places {
            navigation.add_body(&route(&[[0.0, 6.0]]), place).unwrap();
        }
        let body = |k: usize| Some(NavigatedBody { position: places[k], velocity: Vec2::ZERO, height_m: 0.0 });
        (0..3).for_each(|step| navigation.update(f64::from(step), body));
        let [first, second, third] = [0, 1, 2].map(|k| navigation.aim(k).velocity);
        assert!(first.y > 0.1, "it goes in: {first}");
        assert!(second.y < -0.1, "it goes back: {second}");
        assert_eq!(third, Vec2::ZERO, "far enough behind, it stands");
    }

    #[test]
    fn subgoals_are_passed_in_order_from_the_first() {
        let mut navigation = Navigation::new(&Streets::new(&[], 0.45).unwrap(), 0.3, 1.3, 1).unwrap();
        // Nearest to the last leg, it begins at the first all the same.
        let start = Vec2::new(0.0, 58.0);
        navigation.add_body(&route(&[[0.0, -60.0], [90.0, -60.0], [90.0, 60.0], [0.0, 60.0]]), start).unwrap();
        navigation.update(0.0, |_| Some(NavigatedBody { position: start, velocity: Vec2::ZERO, height_m: 0.0 }));
        // Nothing stands there: the line across the path ends near the subgoal.
        assert_eq!(navigation.aim(0).position, Vec2::new(0.0, -58.8));
    }

    #[test]
    fn what_leads_nowhere_is_refused_and_changes_nothing() {
        let room = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let walls: Vec<Obstacle> = (0..4).map(|i| wall(room[i], room[(i + 1) % 4])).collect();
        let mut navigation = Navigation::new(&Streets::new(&walls, 0.45).unwrap(), 0.3, 1.3, 1).unwrap();
        let at = Vec2::new(5.0, 0.0);
        let told = navigation.add_body(&route(&[[0.0, 0.0]]), at).unwrap_err();
        assert!(matches!(told, Error::NoPath { .. }), "{told}");
        assert!(navigation.add_body(&route(&[[1.0, 0.0]]), at).is_err(), "in a wall");
        assert!(navigation.add_body(&route(&[]), at).is_err());
        navigation.add_body(&route(&[[9.0, 0.0]]), at).unwrap();
        let state = navigation.state();
        assert!(navigation.set_route(0, &route(&[[0.0, 0.0]]), at).is_err());
        assert_eq!(navigation.state(), state);
        let [mut damaged, mut empty] = [state.clone(), state.clone()];
        damaged.progress[0].cursor.leg = 7;
        empty.progress.clear();
        assert!(!navigation.restore(&damaged) && !navigation.restore(&empty) && navigation.restore(&state));
    }
}
