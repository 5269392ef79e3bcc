//! What surrounds the members: obstacles by cell, routes, fields and limits.

use super::beside::is_wall_within;
use super::cells::Cells;
use super::flow::Flow;
use super::occupancy::narrowest;
use super::plan::Plan;
use super::solid::{Solid, is_inside, solids};
use super::spline::Spline;
use super::{CrowdError, Field, Interest, Member, Obstacle, Scheme, Setup, Space};
use crate::prefetch::prefetch;

/// How much faster than it wishes a member may be, when it gives way.
pub(crate) const HURRY: f32 = 1.25;

/// All that does not change while time passes.
#[derive(Clone, Debug)]
pub(crate) struct World<V> {
    pub fields: Vec<Field>,
    pub splines: Vec<Spline<V>>,
    /// What stands or moves, as it was given.
    pub obstacles: Vec<Obstacle<V>>,
    /// Which of the solids are whose. [Size: obstacles.len()]
    ranges: Vec<std::ops::Range<usize>>,
    pub solids: Vec<Solid<V>>,
    /// Obstacle that each solid is a part of.
    pub owners: Vec<u32>,
    pub movers: Vec<Mover<V>>,
    pub interests: Vec<Interest<V>>,
    /// Where the lists of each cell begin in `near` and `walls`: those of cell c end where those of c + 1 begin. Empty
    /// where there are no solids.
    first: Vec<[u32; 2]>,
    /// Solids that reach into the region of each cell.
    near: Vec<u32>,
    /// The same for those that are walls to somebody in the region, see [`is_wall_within`].
    walls: Vec<u32>,
    /// Smallest time between two events of a member. [Unit: s]
    pub interval: f32,
    /// Largest radius. [Unit: m]
    pub radius: f32,
    /// Largest speed that anybody wishes. [Unit: m/s]
    pub speed: f32,
    /// Longest way to stop from [`HURRY`] times the largest speed. [Unit: m]
    pub stopping: f32,
}

/// A ball on its way.
#[derive(Clone, Debug)]
pub(crate) struct Mover<V> {
    pub obstacle: u32,
    pub radius: f32,
    way: Vec<(f64, V)>,
}

impl<V: Space> Mover<V> {
    /// Its motion from a time on: straight until `end`, which is not after the next point of its way.
    pub fn plan(&self, time: f64, within: f32) -> Plan<V> {
        let next = self.way.partition_point(|(t, _)| *t <= time);
        let end = time + f64::from(within);
        let (position, velocity, end) = match (next.checked_sub(1).map(|i| self.way[i]), self.way.get(next)) {
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
        Plan {
            start: time,
            end,
            position,
            velocity,
            acceleration: V::default(),
            moving: f32::INFINITY,
            radius: self.radius,
            // It never brakes: its stop region is where it is.
            limit: f32::INFINITY,
            index: super::NONE,
        }
    }
}

impl<V: Space> World<V> {
    /// Checks and prepares all that surrounds the members, and makes empty cells.
    pub fn new(setup: &Setup<V>) -> Result<(Self, Cells<V>, Flow<V>), CrowdError> {
        check_settings(setup)?;
        let config = &setup.config;
        let most = |least: f32, f: fn(&Member<V>) -> f32| setup.members.iter().map(f).fold(least, f32::max);
        let radius = most(config.largest_radius_m, |m| m.radius);
        let speed = most(config.largest_speed_mps, |m| m.speed.max(m.velocity.length() / HURRY)).max(0.1);
        let weakest = setup.members.iter().map(|m| m.acceleration).fold(f32::INFINITY, f32::min);
        let weakest = if weakest.is_finite() { weakest } else { 1.0 };
        let fastest = HURRY * speed;
        let mut world = Self {
            fields: setup.fields.clone(),
            splines: Vec::with_capacity(setup.routes.len()),
            obstacles: setup.obstacles.clone(),
            ranges: Vec::new(),
            solids: Vec::new(),
            owners: Vec::new(),
            movers: Vec::new(),
            interests: setup.interests.clone(),
            first: Vec::new(),
            near: Vec::new(),
            walls: Vec::new(),
            interval: config.smallest_interval_s,
            radius,
            speed,
            stopping: fastest * fastest / (2.0 * weakest),
        };
        let (low, high) = extents(setup);
        let capacity = config.capacity.max(setup.members.len());
        let cells = Cells::new(world.side(setup)?, high - low, capacity);
        let flow = Flow::new(radius, high - low, capacity);
        world.add_obstacles()?;
        for (index, route) in setup.routes.iter().enumerate() {
            let spline = Spline::new(index, route)?;
            world.check_route(index, &spline)?;
            world.splines.push(spline);
        }
        for (member, m) in setup.members.iter().enumerate() {
            world.check_place(member, m.position)?;
        }
        if !world.solids.is_empty() {
            let (near, walls) = (world.list(&cells, |_| Some(0.0)), world.list(&cells, is_wall_within));
            world.first = near.0.into_iter().zip(walls.0).map(<[u32; 2]>::from).collect();
            (world.near, world.walls) = (near.1, walls.1);
        }
        Ok((world, cells, flow))
    }

    /// Side of the cells: within the shortest plan, and half as long again, everybody has to be able to stop within half
    /// of it.
    fn side(&self, setup: &Setup<V>) -> Result<f32, CrowdError> {
        let (config, interval) = (&setup.config, 1.5 * self.interval);
        let longest = if config.scheme == Scheme::Fixed { config.step_s.max(interval) } else { interval };
        let mut need = 2.0 * (self.radius + self.stopping + HURRY * self.speed * longest + 0.01);
        if config.scheme == Scheme::Occupancy {
            let strongest = setup.members.iter().map(|m| m.acceleration).fold(0.0, f32::max);
            need = need.max(narrowest(self.radius, strongest, self.interval));
        }
        match config.cell_side_m {
            0.0 => Ok(need.max(6.5 * self.radius)),
            side if side >= need && side < 1e5 => Ok(side),
            got => {
                let expected = "twice the radius, way to stop and way of a shortest plan, or more; or 0";
                Err(CrowdError::Value { what: "config", index: 0, field: "cell_side_m", got, expected })
            }
        }
    }

    /// Takes in the bodies of obstacles.
    fn add_obstacles(&mut self) -> Result<(), CrowdError> {
        for (index, obstacle) in self.obstacles.iter().enumerate() {
            let bodies = solids(index, obstacle)?;
            let range = self.solids.len()..self.solids.len() + bodies.len();
            self.owners.resize(range.end, index as u32);
            self.solids.extend(bodies);
            self.ranges.push(range);
            if let Obstacle::Mover { way, radius } = obstacle {
                self.movers.push(Mover { obstacle: index as u32, radius: *radius, way: way.clone() });
            }
        }
        Ok(())
    }

    /// No subgoal of a route is in an obstacle.
    pub fn check_route(&self, route: usize, spline: &Spline<V>) -> Result<(), CrowdError> {
        for ((obstacle, body), range) in self.obstacles.iter().enumerate().zip(&self.ranges) {
            if let Some(subgoal) = spline.blocked_by(body, &self.solids[range.clone()]) {
                return Err(CrowdError::Goal { route, subgoal, obstacle });
            }
        }
        Ok(())
    }

    /// A member's centre is in no polygon; of these, only the sides are solids.
    pub fn check_place(&self, member: usize, position: V) -> Result<(), CrowdError> {
        let inside = |o: &Obstacle<V>| matches!(o, Obstacle::Polygon { corners } if is_inside(corners, position));
        self.obstacles.iter().position(inside).map_or(Ok(()), |obstacle| Err(CrowdError::Inside { member, obstacle }))
    }

    /// Has fetched from memory where the lists of a cell are.
    #[inline]
    pub fn prefetch(&self, cell: u32) {
        if let Some(first) = self.first.get(cell as usize) {
            prefetch(first);
        }
    }

    /// Solids that reach into the region of a cell.
    #[inline]
    pub fn near(&self, cell: u32) -> &[u32] {
        self.listed(cell, 0, &self.near)
    }

    /// Solids that a member in a cell sees beside it.
    #[inline]
    pub fn walls(&self, cell: u32) -> &[u32] {
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

    /// Lists solids by the cells whose regions they touch, or are within a distance of, if they are to be listed: where
    /// those of each cell begin, and all of them.
    fn list(&self, cells: &Cells<V>, within: impl Fn(&Solid<V>) -> Option<f32>) -> (Vec<u32>, Vec<u32>) {
        let mut pairs = Vec::new();
        for (number, solid) in (0u32..).zip(&self.solids) {
            let Some(within) = within(solid) else { continue };
            let (min, max) = solid.extents();
            let side = V::from_coordinates([cells.side() + within; 3]);
            let (low, high) = (cells.coordinates(min - side), cells.coordinates(max + side));
            let folds = cells.folds();
            let count =
                |axis: usize| (i64::from(high[axis]) - i64::from(low[axis]) + 1).min(i64::from(folds[axis])) as i32;
            let is_folded = (0..V::DIMENSIONS).any(|axis| count(axis) == folds[axis] as i32);
            let axes =
                [count(0), if V::DIMENSIONS > 1 { count(1) } else { 1 }, if V::DIMENSIONS > 2 { count(2) } else { 1 }];
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
        let first = (0..=cells.num_cells() as u32).map(|c| pairs.partition_point(|p| p.0 < c) as u32).collect();
        (first, pairs.into_iter().map(|p| p.1).collect())
    }
}

/// Every setting within its limits.
fn check_settings<V: Space>(setup: &Setup<V>) -> Result<(), CrowdError> {
    let got = setup.config.smallest_interval_s;
    if !(0.001..=1.0).contains(&got) {
        let (field, expected) = ("smallest_interval_s", "between 0.001 and 1");
        return Err(CrowdError::Value { what: "config", index: 0, field, got, expected });
    }
    let got = setup.config.step_s;
    if !(0.001..=1.0).contains(&got) {
        let expected = "between 0.001 and 1";
        return Err(CrowdError::Value { what: "config", index: 0, field: "step_s", got, expected });
    }
    let halvings = setup.config.halvings;
    if halvings > 16 {
        let (field, got) = ("halvings", halvings as f32);
        return Err(CrowdError::Value { what: "config", index: 0, field, got, expected: "at most 16" });
    }
    for (field, got) in
        [("largest_radius_m", setup.config.largest_radius_m), ("largest_speed_mps", setup.config.largest_speed_mps)]
    {
        if !(0.0..1e3).contains(&got) {
            let expected = "between 0 and 1000";
            return Err(CrowdError::Value { what: "config", index: 0, field, got, expected });
        }
    }
    for (index, field) in setup.fields.iter().enumerate() {
        field.check(index)?;
    }
    for (index, interest) in setup.interests.iter().enumerate() {
        let is_good = interest.position.is_finite() && interest.strength.is_finite();
        let got = if is_good { interest.reach } else { f32::NAN };
        if !(got > 0.0 && got < 1e6) {
            let expected = "above 0 and below 1e6, with a strength and position that are finite";
            return Err(CrowdError::Value { what: "interest", index, field: "reach", got, expected });
        }
    }
    for (index, member) in setup.members.iter().enumerate() {
        check_member(index, member, setup.routes.len(), setup.fields.len())?;
    }
    Ok(())
}

/// A member's settings within their limits.
pub(crate) fn check_member<V: Space>(
    index: usize,
    m: &Member<V>,
    num_routes: usize,
    num_fields: usize,
) -> Result<(), CrowdError> {
    let value = |field, got, expected| Err(CrowdError::Value { what: "member", index, field, got, expected });
    if !m.position.is_finite() || m.position.length() > 1e5 {
        return value("position", m.position.length(), "finite and within 1e5 m");
    }
    if !(m.radius > 1e-3 && m.radius < 1e3) {
        return value("radius", m.radius, "between 0.001 and 1000");
    }
    if !(m.acceleration > 1e-2 && m.acceleration < 1e4) {
        return value("acceleration", m.acceleration, "between 0.01 and 10000");
    }
    if !(0.0..1e3).contains(&m.speed) {
        return value("speed", m.speed, "between 0 and 1000");
    }
    if !(m.velocity.is_finite() && m.velocity.length() < 1e3) {
        return value("velocity", m.velocity.length(), "finite and below 1000");
    }
    for (what, got, limit) in [("route", m.route, num_routes), ("field", m.field, num_fields)] {
        if got >= limit {
            return Err(CrowdError::Index { what, got, limit });
        }
    }
    Ok(())
}

/// Box along the axes around all places that are named.
fn extents<V: Space>(setup: &Setup<V>) -> (V, V) {
    let members = setup.members.iter().map(|m| m.position);
    let mut places =
        members.chain(setup.routes.iter().flat_map(|r| r.subgoals.iter().copied())).filter(|p| p.is_finite());
    let first = places.next().unwrap_or_default();
    places.fold((first, first), |(low, high), p| (low.min(p), high.max(p)))
}
