//! Surroundings of the agents: obstacles by cell, routes, fields and limits.

use crate::error::{CrowdError, Result, check};
use crate::routes::path::{RoutePath, is_in_solid};
use crate::space::solid::{ConvexSolid, is_inside, solids};
use crate::{Agent, CrowdSetup, ForceField, Id, Interest, Obstacle, Route, Scheme, Space};
use crate::{routes::goals::GoalTable, routes::streets::Streets, space::cells::CellGrid, space::plan::MotionPlan};
use crate::{routes::passages::Passages, safety::bound::narrowest_cell, steering::config::SteeringConfig};
use crate::{steering::density_grid::DensityGrid, steering::keep_right::is_wall_within};
use serde::{Deserialize, Serialize};
use throng_base::{error::check_index, prefetch};

/// Side of cells so large that all agents are in neighbouring ones (m).
#[cfg(feature = "fixed-steps")]
const ALL_M: f32 = 9e4;

/// Data that does not change with time.
#[derive(Clone, Debug)]
pub(crate) struct CrowdScenery<V> {
    pub fields: Vec<ForceField>,
    pub paths: Vec<RoutePath<V>>,
    /// Routes of the setup, the first ones.
    pub num_routes: usize,
    /// Finds paths round obstacles.
    pub streets: Option<Streets>,
    /// Subgoals of all routes, where there are streets.
    pub goals: GoalTable,
    /// Narrow places of the streets, as if doors of the setup were open.
    pub passages: Passages,
    /// Number here of each obstacle of the streets, if it is one of these.
    of_streets: Vec<Option<usize>>,
    /// Obstacles as they were given.
    pub obstacles: Vec<Obstacle<V>>,
    /// Range of each obstacle's solids (obstacles.len()).
    ranges: Vec<std::ops::Range<usize>>,
    pub solids: Vec<ConvexSolid<V>>,
    /// State of each obstacle as a door; open doors count as absent (obstacles.len()).
    pub doors: Vec<Door>,
    /// Obstacle that each solid is a part of.
    pub owners: Vec<u32>,
    pub movers: Vec<MovingObstacle<V>>,
    pub interests: Vec<Interest<V>>,
    /// Start of the lists of each cell in `near` and `walls`: those of cell c end where those of c + 1 begin. Empty
    /// where there are no solids.
    first: Vec<[u32; 2]>,
    /// Solids that reach into the region of each cell.
    near: Vec<u32>,
    /// Walls within the region of each cell, see [`is_wall_within`].
    walls: Vec<u32>,
    /// Smallest time between two events of an agent (s).
    pub interval: f32,
    /// Largest radius (m).
    pub radius: f32,
    /// Largest desired speed (m/s).
    pub speed: f32,
    /// Largest speed that an agent may have: more than the largest desired one, to give way (m/s).
    pub fastest: f32,
    /// Longest distance to stop from the largest speed (m).
    pub stopping: f32,
    pub steering: SteeringConfig,
}

/// State of an obstacle as a door.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Door {
    /// The obstacle was never opened.
    #[default]
    Never,
    Closed,
    Open,
}

/// A ball on its way.
#[derive(Clone, Debug)]
pub(crate) struct MovingObstacle<V> {
    pub obstacle: u32,
    pub radius: f32,
    path: Vec<(f64, V)>,
}

impl<V: Space> MovingObstacle<V> {
    /// Motion from a time on: straight until `end`, which is not after the next point of its path.
    pub fn plan(&self, time: f64, within: f32) -> MotionPlan<V> {
        let next = self.path.partition_point(|(t, _)| *t <= time);
        let end = time + f64::from(within);
        let (position, velocity, end) = match (next.checked_sub(1).map(|i| self.path[i]), self.path.get(next)) {
            (Some((t0, x0)), Some(&(t1, x1))) => {
                let velocity = (x1 - x0) * ((t1 - t0) as f32).recip();
                (x0 + velocity * (time - t0) as f32, velocity, end.min(t1))
            }
            (Some((_, x)), None) => (x, V::default(), end),
            (None, first) => {
                let (t, x) = first.copied().unwrap_or_default();
                (x, V::default(), end.min(t))
            }
        };
        MotionPlan {
            start: time,
            end,
            position,
            velocity,
            moving: f32::INFINITY,
            radius: self.radius,
            // It never brakes: its stop region is where it is.
            limit: f32::INFINITY,
            index: crate::NONE,
            ..MotionPlan::default()
        }
    }
}

impl<V: Space> CrowdScenery<V> {
    /// Checks and prepares all that surrounds the agents, and makes empty cells.
    pub fn new(setup: &CrowdSetup<V>) -> Result<(Self, CellGrid<V>, DensityGrid<V>)> {
        check_settings(setup)?;
        let config = &setup.config;
        let most = |least: f32, f: &dyn Fn(&Agent<V>) -> f32| setup.agents.iter().map(f).fold(least, f32::max);
        let ratio = config.steering.largest_speed_ratio;
        let radius = most(config.largest_radius_m, &|m| m.radius);
        let speed = most(config.largest_speed_mps, &|m| m.speed.max(m.velocity.length() / ratio)).max(0.1);
        let to_come = Some(setup.config.least_acceleration_mps2).filter(|least| *least > 0.0);
        let weakest = setup.agents.iter().map(|m| m.acceleration).chain(to_come).fold(f32::INFINITY, f32::min);
        let weakest = if weakest.is_finite() { weakest } else { 1.0 };
        let fastest = ratio * speed;
        let mut scenery = Self {
            fields: setup.fields.clone(),
            paths: Vec::with_capacity(setup.routes.len()),
            num_routes: setup.routes.len(),
            of_streets: of_streets(setup),
            streets: setup.streets.clone().filter(|s| !s.is_open()),
            goals: GoalTable::default(),
            passages: Passages::default(),
            obstacles: setup.obstacles.clone(),
            ranges: Vec::new(),
            solids: Vec::new(),
            doors: vec![Door::Never; setup.obstacles.len()],
            owners: Vec::new(),
            movers: Vec::new(),
            interests: setup.interests.clone(),
            first: Vec::new(),
            near: Vec::new(),
            walls: Vec::new(),
            interval: config.smallest_interval_s,
            radius,
            speed,
            fastest,
            steering: config.steering,
            stopping: fastest * fastest / (2.0 * weakest),
        };
        let (low, high) = extents(setup);
        let capacity = config.capacity.max(setup.agents.len());
        let cells = CellGrid::new(scenery.side(setup)?, high - low, capacity);
        let square = config.steering.square_radii * radius.max(1e-3);
        let grid = DensityGrid::new(square, high - low, capacity);
        scenery.add_obstacles()?;
        let mut doors = scenery.doors.clone();
        for &door in &setup.doors {
            check_index("door", None, door, doors.len())?;
            doors[door] = Door::Open;
        }
        scenery.set_doors(&doors, &cells)?;
        if let Some(streets) = scenery.streets.as_ref().filter(|_| V::DIMENSIONS == 2) {
            scenery.passages = Passages::find(streets, radius);
        }
        for (index, route) in setup.routes.iter().enumerate() {
            let path = scenery.prepare_path(index, route)?;
            scenery.paths.push(path);
        }
        setup.agents.iter().enumerate().try_for_each(|(agent, m)| scenery.check_place(Id::first(agent), m.position))?;
        scenery.list_solids(&cells);
        Ok((scenery, cells, grid))
    }

    /// Lists the solids of all obstacles that are not open by cells. Takes memory.
    pub fn list_solids(&mut self, cells: &CellGrid<V>) {
        if self.solids.is_empty() {
            return;
        }
        let (near, walls) = (self.list(cells, |_| Some(0.0)), self.list(cells, |s| is_wall_within(s, &self.steering)));
        self.first = near.0.into_iter().zip(walls.0).map(<[u32; 2]>::from).collect();
        (self.near, self.walls) = (near.1, walls.1);
    }

    /// Solids of an obstacle.
    pub fn solids_of(&self, obstacle: usize) -> &[ConvexSolid<V>] {
        &self.solids[self.ranges[obstacle].clone()]
    }

    /// Side of the cells: within the shortest plan, and half as long again, every agent has to be able to stop within half
    /// of it.
    fn side(&self, setup: &CrowdSetup<V>) -> Result<f32> {
        let config = &setup.config;
        let shortest = 1.5 * self.interval;
        #[cfg(feature = "fixed-steps")]
        if config.scheme == Scheme::Pairs {
            // The whole crowd is in neighbouring cells.
            return Ok(ALL_M);
        }
        #[cfg(feature = "fixed-steps")]
        let shortest = if config.scheme == Scheme::Fixed { config.step_s.max(shortest) } else { shortest };
        let mut need = 2.0 * (self.radius + self.stopping + self.fastest * shortest + 0.01);
        if config.scheme == Scheme::Occupancy {
            let strongest = setup.agents.iter().map(|a| a.acceleration).fold(0.0, f32::max);
            need = need.max(narrowest_cell(self.radius, strongest, config.steering.blocked_intervals * self.interval));
        }
        let got = config.cell_side_m;
        if got == 0.0 {
            return Ok(need.max(6.5 * self.radius));
        }
        let expected = "twice the radius, distance to stop and length of a shortest plan, or more; or 0";
        throng_base::error::check_value("config.cell_side_m", None, got, got >= need && got < 1e5, expected)?;
        Ok(got)
    }

    /// Makes the solids of obstacles.
    fn add_obstacles(&mut self) -> Result<()> {
        for (index, obstacle) in self.obstacles.iter().enumerate() {
            let bodies = solids(index, obstacle)?;
            let range = self.solids.len()..self.solids.len() + bodies.len();
            self.owners.resize(range.end, index as u32);
            self.solids.extend(bodies);
            self.ranges.push(range);
            if let Obstacle::Mover { path, radius } = obstacle {
                self.movers.push(MovingObstacle { obstacle: index as u32, radius: *radius, path: path.clone() });
            }
        }
        Ok(())
    }

    /// Prepares a route.
    ///
    /// # Errors
    /// [`CrowdError`] for an impossible route.
    pub fn prepare_path(&mut self, number: usize, route: &Route<V>) -> Result<RoutePath<V>> {
        let mut goals = std::mem::take(&mut self.goals);
        let path = self.prepare_path_with(number, route, &mut goals);
        self.goals = goals;
        path
    }

    /// Prepares a route with other goals than those of this crowd.
    pub fn prepare_path_with(&self, number: usize, route: &Route<V>, goals: &mut GoalTable) -> Result<RoutePath<V>> {
        let mut path = RoutePath::new(number, route, &self.solids)?;
        let mut subgoals = route.subgoals.iter().enumerate();
        subgoals.try_for_each(|(subgoal, &g)| self.check_goal(number, subgoal, g))?;
        if let Some(streets) = &self.streets {
            path.goals = path.subgoals().map(|g| goals.take_goal(streets, g.to_world())).collect();
        }
        Ok(path)
    }

    /// A subgoal is in no obstacle, be it an open one.
    pub fn check_goal(&self, route: usize, subgoal: usize, goal: V) -> Result<()> {
        let mut obstacles = self.obstacles.iter().zip(&self.ranges);
        let held = obstacles.position(|(body, range)| is_in_solid(goal, body, &self.solids[range.clone()]));
        held.map_or(Ok(()), |obstacle| Err(CrowdError::Goal { route, subgoal, obstacle }))
    }

    /// True for an obstacle that is open.
    pub fn is_open(&self, obstacle: usize) -> bool {
        self.doors[obstacle] == Door::Open
    }

    /// Opens and closes obstacles; paths lead accordingly. Takes memory.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] where streets know too many doors; nothing has changed then.
    pub fn set_doors(&mut self, doors: &[Door], cells: &CellGrid<V>) -> Result<()> {
        if self.doors == doors {
            return Ok(());
        }
        if let Some(streets) = &mut self.streets {
            let open = |n: &Option<usize>| n.map(|n| doors[n]).filter(|d| *d != Door::Never).map(|d| d == Door::Open);
            let open_of: Vec<Option<bool>> = self.of_streets.iter().map(open).collect();
            let is_new = streets.set_doors(&open_of)?;
            self.goals.find_again(streets, is_new);
        }
        self.doors.copy_from_slice(doors);
        self.list_solids(cells);
        Ok(())
    }

    /// An agent's centre is in no polygon; of these, only the sides are solids.
    pub fn check_place(&self, agent: Id, position: V) -> Result<()> {
        let inside = |(o, door): (&Obstacle<V>, &Door)| matches!(o, Obstacle::Polygon { corners } if *door != Door::Open && is_inside(corners, position));
        let held = self.obstacles.iter().zip(&self.doors).position(inside);
        held.map_or(Ok(()), |obstacle| Err(CrowdError::Inside { agent, obstacle }))
    }

    /// Prefetches where the lists of a cell are.
    #[inline]
    pub fn prefetch(&self, cell: u32) {
        if let Some(first) = self.first.get(cell as usize) {
            prefetch(first);
        }
    }

    /// Solids that reach into the region of a cell.
    #[inline]
    pub fn solids_near(&self, cell: u32) -> &[u32] {
        self.listed(cell, 0, &self.near)
    }

    /// Solids that an agent in a cell sees beside it.
    #[inline]
    pub fn walls_seen(&self, cell: u32) -> &[u32] {
        self.listed(cell, 1, &self.walls)
    }

    #[inline]
    fn listed<'a>(&self, cell: u32, kind: usize, all: &'a [u32]) -> &'a [u32] {
        if self.first.is_empty() {
            return &[];
        }
        let (first, next) = (self.first[cell as usize], self.first[cell as usize + 1]);
        &all[first[kind] as usize..next[kind] as usize]
    }

    /// Lists solids by the cells whose regions they touch, or are within a distance of: returns the start of each
    /// cell's list, and all lists.
    fn list(&self, cells: &CellGrid<V>, within: impl Fn(&ConvexSolid<V>) -> Option<f32>) -> (Vec<u32>, Vec<u32>) {
        let mut pairs = Vec::new();
        for (number, solid) in (0u32..).zip(&self.solids) {
            let is_open = self.is_open(self.owners[number as usize] as usize);
            let Some(within) = within(solid).filter(|_| !is_open) else { continue };
            let (min, max) = solid.extents();
            let side = V::from_coordinates([cells.side + within; 3]);
            let (low, high) = (cells.coordinates(min - side), cells.coordinates(max + side));
            let folds = cells.folds();
            let count =
                |axis: usize| (i64::from(high[axis]) - i64::from(low[axis]) + 1).min(i64::from(folds[axis])) as i32;
            let is_folded = (0..V::DIMENSIONS).any(|axis| count(axis) == folds[axis] as i32);
            let axes = [0, 1, 2].map(|axis| if axis < V::DIMENSIONS { count(axis) } else { 1 });
            for z in 0..axes[2] {
                for y in 0..axes[1] {
                    for x in 0..axes[0] {
                        let at = [low[0] + x, low[1] + y, low[2] + z];
                        let centre = cells.centre(at);
                        if is_folded || solid.touches(centre - side, centre + side) {
                            pairs.push((cells.number(at), number));
                        }
                    }
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let first = (0..=cells.num_cells as u32).map(|c| pairs.partition_point(|p| p.0 < c) as u32).collect();
        (first, pairs.into_iter().map(|p| p.1).collect())
    }
}

/// Number in the setup of each obstacle of the streets, if it is one of these.
fn of_streets<V: Space>(setup: &CrowdSetup<V>) -> Vec<Option<usize>> {
    let number = |(n, known): (usize, &Obstacle)| {
        let known = known.clone().map(V::from_world);
        if setup.obstacles.get(n) == Some(&known) { Some(n) } else { setup.obstacles.iter().position(|o| *o == known) }
    };
    setup.streets.iter().flat_map(|s| s.obstacles()).enumerate().map(number).collect()
}

/// Every setting within its limits.
fn check_settings<V: Space>(setup: &CrowdSetup<V>) -> Result<()> {
    setup.config.check()?;
    setup.senses.check()?;
    setup.fields.iter().enumerate().try_for_each(|(n, field)| field.check(n))?;
    for (n, interest) in setup.interests.iter().enumerate() {
        let good = interest.position.is_finite() && interest.strength.is_finite();
        let expected = "above 0 and below 1e6, with a strength and position that are finite";
        let reach = interest.reach;
        check("interest.reach", n, reach, good && reach > 0.0 && reach < 1e6, expected)?;
    }
    for (n, agent) in setup.agents.iter().enumerate() {
        check_agent(n, agent, setup.routes.len(), setup.fields.len())?;
    }
    Ok(())
}

/// An agent's settings within their limits.
pub(crate) fn check_agent<V: Space>(n: usize, agent: &Agent<V>, num_routes: usize, num_fields: usize) -> Result<()> {
    let far = agent.position.length();
    check("agent.position", n, far, agent.position.is_finite() && far <= 1e5, "finite and within 1e5 m")?;
    let radius = agent.radius;
    check("agent.radius", n, radius, radius > 1e-3 && radius < 1e3, "between 0.001 and 1000")?;
    let most = agent.acceleration;
    check("agent.acceleration", n, most, most > 1e-2 && most < 1e4, "between 0.01 and 10000")?;
    check("agent.speed", n, agent.speed, (0.0..1e3).contains(&agent.speed), "between 0 and 1000")?;
    let fast = agent.velocity.length();
    check("agent.velocity", n, fast, agent.velocity.is_finite() && fast < 1e3, "finite and below 1000")?;
    if let Some(route) = agent.route {
        check_index("route", Some(Id::first(n)), route, num_routes)?;
    }
    Ok(check_index("field", Some(Id::first(n)), agent.field, num_fields)?)
}

/// Box along the axes around all places that are named.
fn extents<V: Space>(setup: &CrowdSetup<V>) -> (V, V) {
    let agents = setup.agents.iter().map(|m| m.position);
    let mut places =
        agents.chain(setup.routes.iter().flat_map(|r| r.subgoals.iter().copied())).filter(|p| p.is_finite());
    let first = places.next().unwrap_or_default();
    places.fold((first, first), |(low, high), p| (low.min(p), high.max(p)))
}
