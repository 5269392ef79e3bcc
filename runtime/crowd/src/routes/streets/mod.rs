//! Shortest paths on the ground round obstacles, with a clearance.
//!
//! A visibility graph: around every corner stand points at a little more than the clearance; points that see each other
//! are joined, and A* (Hart, Nilsson and Raphael 1968) finds the shortest path. Unlike a mesh of triangles, the graph
//! gives the shortest paths themselves. It is small for tens of corners, and takes seconds to make for thousands.
//!
//! Doors are obstacles that were opened once. The graph leads through them too, and stores for each line between two
//! points which doors it goes through: a door that closes makes no new graph. A closed one counts as a very long path:
//! none leads there where there is another.

mod near;
mod search;
#[cfg(test)]
mod tests;

use crate::{AtEnd, NONE, Obstacle, Route, Space, routes::outline::ObstacleOutline, routes::passages::ClosedDoor};
use glam::{Vec2, Vec3, Vec3Swizzles};
use near::EdgeGrid;
pub(crate) use search::CornerQuery;
pub(crate) use search::OpenPoint;
use search::path_length;
use serde::Serialize;
use throng_base::{Error, Result, error::check_value, ground::is_one_floor};

/// Paths round obstacles that keep a clearance.
///
/// ```
/// use throng_base::glam::Vec3;
/// use throng_crowd::{Obstacle, Streets};
///
/// let house = Obstacle::Box { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 3.0, 3.0) };
/// let streets = Streets::new(&[house], 0.4)?;
/// assert!(streets.corners(Vec3::new(-5.0, 0.0, 0.0), Vec3::new(5.0, 0.0, 0.0)).is_ok_and(|path| path.len() > 1));
/// # Ok::<(), throng_base::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Streets {
    obstacles: Vec<Obstacle>,
    outlines: Vec<ObstacleOutline>,
    /// Obstacle that each outline is of.
    owners: Vec<usize>,
    bounds: Vec<(Vec2, Vec2)>,
    edges: EdgeGrid,
    /// Lowest and highest ground at each outline, in a level; empty where the ground has one floor (m).
    floors: Vec<[f32; 2]>,
    /// Lowest and highest that agents are (m).
    heights: Option<[f32; 2]>,
    clearance: f32,
    /// Smallest distance of a goal from an obstacle (m).
    nearest: f32,
    /// Door that each outline is; 0 where it is none.
    doors: Vec<Doors>,
    /// Closed doors.
    closed: Doors,
    /// Points to go round corners by.
    points: Vec<Vec2>,
    /// Offset of each point from its corner (unit vector), the free distance in that direction (m), and the number of
    /// its corner.
    around: Vec<(Vec2, f32, u32)>,
    /// Doors that each point is in, and the door whose corner it is at.
    at_doors: Vec<[Doors; 2]>,
    /// Points that each point sees and that paths may lead to, with their distances (m) and the doors in between.
    seen: Vec<Vec<(u32, f32, Doors)>>,
}

/// A set of doors.
type Doors = u64;

/// Distances of a goal from all points of some streets: the points that see it, and the next point of the others.
#[derive(Clone, Debug, Default)]
pub(crate) struct GoalCosts {
    goal: Vec2,
    /// Points that see the goal, how far they are (m), and the doors in between.
    seen: Vec<(u32, f32, Doors)>,
    /// (points)
    points: Vec<PointCost>,
    /// Distance of the goal from obstacles, if that is less than the clearance (m).
    pub near: f32,
}

impl GoalCosts {
    /// Memory for so many points.
    pub(crate) fn with_capacity(num_points: usize) -> Self {
        Self { seen: Vec::with_capacity(num_points), points: Vec::with_capacity(num_points), ..Self::default() }
    }
}

/// Distance of a goal from a point.
#[derive(Clone, Copy, Debug)]
struct PointCost {
    /// (m)
    length: f32,
    /// Point to go on by; [`NONE`] where the goal is seen.
    next: u32,
    /// Closed doors on the way.
    closed: u32,
}

impl PointCost {
    const NO_PATH: Self = Self { length: f32::INFINITY, next: NONE, closed: 0 };

    /// Length of a path that is equally costly (m).
    fn key(&self) -> f32 {
        self.length + CLOSED_M * self.closed as f32
    }
}

/// A corner on the way to a goal, as seen from somewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RouteCorner {
    /// A point beside the corner (m).
    pub at: Vec2,
    /// Unit vector away from the corner, across the path.
    pub out: Vec2,
    /// Free distance in that direction (m).
    pub free: f32,
    /// Number of the corner.
    pub number: u32,
    /// Next point of the path after this corner, and the remaining distance from there (m).
    pub next: Vec2,
    pub rest: f32,
    /// Length of the path to the goal by this corner (m).
    pub distance_left: f32,
    /// Number of the first closed door on that path, or 0.
    pub door: u8,
}

impl RouteCorner {
    /// Unit vector along the path by this corner for an agent that comes from a place.
    pub fn direction_from(&self, from: Vec2) -> Vec2 {
        let across = self.out.perp();
        if (self.next - from).dot(across) >= 0.0 { across } else { -across }
    }
}

/// Largest free distance across the path that a corner is given (m).
const WIDEST_M: f32 = 12.0;
/// Largest part of a straight path at a corner that may lead away from the corner or to it: others are no shortest paths.
const TAUT: f32 = 0.5;
/// Length of a path that is as costly as a closed door (m).
const CLOSED_M: f32 = 1e4;
/// Distance of a door from the middle of its gap, and distance from there at which a cabin behind it is measured (m).
const DOOR_NEAR_M: f32 = 0.3;
const IN_CABIN_M: f32 = 0.7;
/// Most corners that ways lead round: memory and time to make a graph grow with their square.
const MOST_AROUND: usize = 4000;
/// Heights of a floor that holds all (m).
pub(crate) const ALL_HEIGHTS: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];
/// Most corners between which an agent chooses.
pub(crate) const MOST_CORNERS: usize = 6;

/// Reason why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPath {
    /// The start is in that obstacle.
    Start(usize),
    /// The goal is in that obstacle, or too near to it.
    Goal(usize),
    /// Obstacles separate the two, or leave no gap that is wide enough.
    Separated,
}

impl Streets {
    /// For agents on the ground: x and z of the world.
    ///
    /// - `clearance_m`: that centres keep from everything that stands: the largest radius and some room (m, > 0). Goals may
    ///   be as near as half of it.
    ///
    /// # Errors
    /// [`Error::Value`] for a clearance out of range, an obstacle that is not finite, and more than 4000 corners (a box has
    /// four, a wall two, a ball one).
    pub fn new(obstacles: &[Obstacle], clearance_m: f32) -> Result<Self> {
        Self::with_limits(obstacles, None, clearance_m, 0.5 * clearance_m)
    }

    /// Streets with all settings, see [`Streets::new`].
    ///
    /// - `heights`: lowest and highest position of agents in the air; obstacles that they pass above or below are
    ///   ignored (m); `None` on the ground.
    /// - `nearest_m`: smallest distance of a goal from an obstacle (m, 0 to `clearance_m`).
    ///
    /// # Errors
    /// As [`Streets::new`].
    pub fn with_limits(
        obstacles: &[Obstacle],
        heights: Option<[f32; 2]>,
        clearance_m: f32,
        nearest_m: f32,
    ) -> Result<Self> {
        let mut streets = Self::without_paths(obstacles, heights, clearance_m, nearest_m)?;
        let num = streets.outlines.iter().map(|o| o.corners().len()).sum::<usize>();
        check_value("number of corners of obstacles", None, num as f64, num <= MOST_AROUND, "at most 4000")?;
        streets.make_graph();
        Ok(streets)
    }

    /// Walls of a level, on all its floors: no paths lead between them.
    ///
    /// - `floors`: lowest and highest ground at each wall (m).
    pub(crate) fn of_level(walls: &[Obstacle], floors: Vec<[f32; 2]>, clearance_m: f32) -> Result<Self> {
        let streets = Self::without_paths(walls, None, clearance_m, 0.5 * clearance_m)?;
        Ok(Self { floors, ..streets })
    }

    fn without_paths(
        obstacles: &[Obstacle],
        heights: Option<[f32; 2]>,
        clearance_m: f32,
        nearest_m: f32,
    ) -> Result<Self> {
        let good = clearance_m > 0.0 && clearance_m < 1e6;
        check_value("clearance_m", None, clearance_m, good, "above 0 and below 1e6")?;
        let good = (0.0..=clearance_m).contains(&nearest_m);
        check_value("nearest_m", None, nearest_m, good, "between 0 and the clearance")?;
        let all =
            obstacles.iter().enumerate().filter_map(|(n, o)| Some((n, ObstacleOutline::from_obstacle(o, heights)?)));
        let (owners, outlines): (Vec<_>, Vec<_>) = all.unzip();
        let bounds: Vec<_> = outlines.iter().map(ObstacleOutline::bounds).collect();
        let odd = bounds.iter().position(|(low, high)| !low.is_finite() || !high.is_finite());
        let expected = "one with coordinates that are finite";
        check_value("number of an obstacle", None, odd.unwrap_or(0) as f64, odd.is_none(), expected)?;
        Ok(Self {
            obstacles: obstacles.to_vec(),
            doors: vec![0; outlines.len()],
            edges: EdgeGrid::new(&outlines, &bounds),
            outlines,
            owners,
            bounds,
            floors: Vec::new(),
            heights,
            clearance: clearance_m,
            nearest: nearest_m,
            closed: 0,
            points: Vec::new(),
            around: Vec::new(),
            at_doors: Vec::new(),
            seen: Vec::new(),
        })
    }

    /// Joins all points that see each other, through doors too.
    fn make_graph(&mut self) {
        self.points.clear();
        self.around.clear();
        self.at_doors.clear();
        self.seen.clear();
        let outlines = self.outlines.iter().zip(&self.doors);
        let of =
            |(s, &own): (&ObstacleOutline, &Doors)| s.points_around(self.clearance).into_iter().map(move |p| (p, own));
        let around: Vec<_> = outlines.flat_map(of).collect();
        let mut number = 0;
        for (i, &((p, corner), own)) in around.iter().enumerate() {
            number += u32::from(i > 0 && around[i - 1].0.1 != corner);
            if let Some(doors) = self.doors_between(p, p, self.clearance) {
                self.join_points(p, (p - corner).normalize_or_zero(), number, [doors, own]);
            }
        }
    }

    /// Opens an obstacle, or closes it: paths lead through open ones, and round closed ones where there is a path round. The
    /// first time that one is opened or closed costs as much as [`Streets::new`].
    ///
    /// - `obstacle`: number in [`Streets::obstacles`].
    ///
    /// # Errors
    /// [`Error::Value`] for a number out of range, and more than 64 obstacles that were ever opened or closed.
    pub fn set_open(&mut self, obstacle: usize, open: bool) -> Result<()> {
        throng_base::error::check_index("obstacle", None, obstacle, self.obstacles.len())?;
        let mut open_of = vec![None; self.obstacles.len()];
        for (&owner, door) in self.owners.iter().zip(&self.doors).filter(|(_, door)| **door != 0) {
            open_of[owner] = Some(door & self.closed == 0);
        }
        open_of[obstacle] = Some(open);
        self.set_doors(&open_of).map(|_| ())
    }

    /// Makes some obstacles doors that are open or not, and all others none; true where the set of doors changed.
    ///
    /// # Errors
    /// [`Error::Value`] for more than 64 doors; nothing has changed then.
    pub(crate) fn set_doors(&mut self, open_of: &[Option<bool>]) -> Result<bool> {
        let num = self.owners.iter().filter(|&&o| open_of[o].is_some()).count();
        check_value("number of doors", None, num as f64, num <= Doors::BITS as usize, "at most 64")?;
        let mut is_new = false;
        let mut next: Doors = 1;
        self.closed = 0;
        for (&owner, door) in self.owners.iter().zip(&mut self.doors) {
            let open = open_of[owner];
            is_new |= open.is_some() != (*door != 0);
            *door = if open.is_some() { next } else { 0 };
            self.closed |= if open == Some(false) { next } else { 0 };
            next = if open.is_some() { next.wrapping_shl(1) } else { next };
        }
        if is_new {
            self.make_graph();
        } else {
            for n in 0..self.points.len() {
                self.around[n].1 = self.free_distance(self.points[n], self.around[n].0);
            }
        }
        Ok(is_new)
    }

    /// Content by which streets differ, without the states of doors.
    pub(crate) fn hashed(&self) -> impl Serialize + use<'_> {
        (&self.obstacles, self.heights, self.clearance, self.nearest)
    }

    /// Clearance that ways keep (m).
    pub fn clearance(&self) -> f32 {
        self.clearance
    }

    /// True if nothing stands in any way.
    pub fn is_open(&self) -> bool {
        self.outlines.is_empty()
    }

    /// True if a place keeps the clearance from everything.
    pub fn is_free(&self, at: Vec3) -> bool {
        self.is_clear(at.xz(), at.xz(), self.clearance)
    }

    /// True if a straight line keeps a clearance from all obstacles, and from closed doors or from all doors (m).
    pub fn sees(&self, from: Vec3, to: Vec3, clearance: f32, through_doors: bool) -> bool {
        let shut = if through_doors { self.closed } else { Doors::MAX };
        self.doors_between(from.xz(), to.xz(), clearance).is_some_and(|doors| doors & shut == 0)
    }

    /// True for an obstacle that is open.
    pub(crate) fn is_open_door(&self, obstacle: usize) -> bool {
        self.owners.iter().zip(&self.doors).any(|(o, door)| *o == obstacle && *door != 0 && door & self.closed == 0)
    }

    /// Obstacles that paths lead round.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// A route from one place to another, through the corners of the shortest path: for crowds without streets of their own.
    ///
    /// # Errors
    /// [`Error::NoPath`] where an obstacle holds one of the places, or nothing leads from one to the other.
    pub fn route(&self, from: Vec3, to: Vec3) -> Result<Route> {
        let corners = self.corners(from, to).map_err(|_| Error::NoPath { who: None, from, to })?;
        Ok(Route { subgoals: corners[1..].to_vec(), arrival_radius: 0.5, at_end: AtEnd::Stay })
    }

    /// Corners of the shortest path, with both its ends; heights go evenly from one to the other. The path keeps the
    /// clearance; the legs of an end that is nearer to an obstacle keep as much as that end has.
    ///
    /// # Errors
    /// [`NoPath`].
    pub fn corners(&self, from: Vec3, to: Vec3) -> std::result::Result<Vec<Vec3>, NoPath> {
        let flat = self.flat_corners(from.xz(), to.xz())?;
        let all = path_length(&flat).max(1e-6);
        let mut gone = 0.0;
        let legs = std::iter::once(0.0).chain(flat.windows(2).map(|w| w[0].distance(w[1])));
        let raise = |(p, leg): (&Vec2, f32)| {
            gone += leg;
            Vec3::new(p.x, from.y + (to.y - from.y) * (gone / all), p.y)
        };
        Ok(flat.iter().zip(legs).map(raise).collect())
    }

    /// Distances of both ends of a path from obstacles, less a small margin, so that rounding does not close the path
    /// out (m).
    fn check_ends(&self, from: Vec2, to: Vec2) -> std::result::Result<[f32; 2], NoPath> {
        let stands = |i: &usize| self.doors[*i] == 0 || self.doors[*i] & self.closed != 0;
        let all = 0..self.outlines.len();
        if let Some(i) = all.clone().filter(stands).find(|&i| self.outlines[i].distance(from) <= 0.0) {
            return Err(NoPath::Start(self.owners[i]));
        }
        if let Some(i) = all.clone().find(|&i| self.outlines[i].distance(to) < self.nearest) {
            return Err(NoPath::Goal(self.owners[i]));
        }
        let at_start = all.filter(stands).map(|i| self.outlines[i].distance(from)).fold(self.clearance, f32::min);
        Ok([at_start * 0.999, self.outlines_near(to)])
    }

    /// Distance of a goal from all outlines, if that is less than the clearance, less a small margin (m).
    fn outlines_near(&self, goal: Vec2) -> f32 {
        self.outlines.iter().map(|s| s.distance(goal)).fold(self.clearance, f32::min) * 0.999
    }

    /// Checks that a path leads from a place to a goal, be it through closed doors. Allocates nothing.
    pub(crate) fn check_path(&self, from: Vec2, goal: &GoalCosts) -> std::result::Result<(), NoPath> {
        let [at_start, at_goal] = self.check_ends(from, goal.goal)?;
        let leads = |n: usize| goal.points[n].length.is_finite() && self.sees_point(from, n, at_start).is_some();
        let straight = self.doors_between(from, goal.goal, at_start.min(at_goal)).is_some();
        if straight || (0..self.points.len()).any(leads) { Ok(()) } else { Err(NoPath::Separated) }
    }

    /// Adds a point, joined with all that it sees.
    fn join_points(&mut self, p: Vec2, out: Vec2, corner: u32, at_doors: [Doors; 2]) {
        let new = self.points.len();
        let is_taut = |n: usize, d: f32| corner == self.around[n].2 || (self.points[n] - p).dot(out).abs() <= TAUT * d;
        let taut = (0..new).filter(|&n| is_taut(n, p.distance(self.points[n])));
        let sees: Vec<_> =
            taut.filter_map(|n| self.sees_point(p, n, self.clearance).map(|(d, doors)| (n as u32, d, doors))).collect();
        for &(n, distance, doors) in &sees {
            self.seen[n as usize].push((new as u32, distance, doors));
        }
        self.seen.push(sees.into_iter().rev().collect());
        let free = self.free_distance(p, out);
        self.points.push(p);
        self.around.push((out, free, corner));
        self.at_doors.push(at_doors);
    }

    /// Distance of a point that is seen with a clearance and that paths may lead to, and the doors in between.
    fn sees_point(&self, p: Vec2, n: usize, clearance: f32) -> Option<(f32, Doors)> {
        let (q, (out, ..)) = (self.points[n], self.around[n]);
        let distance = p.distance(q);
        let is_taut = (p - q).dot(out).abs() <= TAUT * distance || distance < 2.0 * self.clearance;
        let doors = is_taut.then(|| self.doors_between(p, q, clearance)).flatten()?;
        Some((distance, doors))
    }

    /// True for a point round an open door, which leaves nothing to go round.
    fn is_idle(&self, n: usize) -> bool {
        self.at_doors[n][1] & !self.closed != 0
    }

    /// Number of closed doors of a line, but for those at one of its ends.
    fn num_closed(&self, doors: Doors, but: Doors) -> u32 {
        (doors & self.closed & !but).count_ones()
    }

    /// Free distance from a point along a unit vector, less the clearance (m).
    fn free_distance(&self, from: Vec2, along: Vec2) -> f32 {
        let mut distance = 0.0;
        while distance < WIDEST_M {
            let x = from + along * distance;
            let mut nearest = WIDEST_M;
            for ((outline, &door), &(low, high)) in self.outlines.iter().zip(&self.doors).zip(&self.bounds) {
                // A hair less, for rounding.
                let is_near = || 0.999 * (low - x).max(x - high).max(Vec2::ZERO).length() < nearest;
                if (door == 0 || door & self.closed != 0) && is_near() {
                    nearest = nearest.min(outline.distance(x));
                }
            }
            nearest -= self.clearance;
            if distance > 0.0 && nearest < 0.02 {
                break;
            }
            // Where it begins, its own corner is just as near as may be.
            distance += nearest.max(0.05);
        }
        distance.min(WIDEST_M)
    }

    /// True where a door leads to ground that is closed off within a distance on all other sides (m).
    ///
    /// - `middle`: of the door, or of any other gap.
    /// - `away`: unit vector to that side.
    pub(crate) fn is_cabin(&self, middle: Vec2, away: Vec2, within: f32) -> bool {
        let has_door = self.doors_between(middle, middle, DOOR_NEAR_M).is_some_and(|doors| doors != 0);
        let aside = [away.perp(), -away.perp()];
        let all = [away, aside[0], aside[1], away + aside[0], away + aside[1]];
        let is_near = |d: &Vec2| self.free_distance(middle + away * IN_CABIN_M, d.normalize_or_zero()) < within;
        has_door && all.iter().all(is_near)
    }

    /// Largest memory of [`Streets::find_costs`]: points, and points that wait to be expanded.
    pub(crate) fn sizes(&self) -> [usize; 2] {
        [self.points.len(), self.points.len() + self.seen.iter().map(Vec::len).sum::<usize>()]
    }

    /// True if an agent sees a place: nothing is nearer to the straight line than its radius.
    ///
    /// - `through`: closed doors do not count.
    pub(crate) fn sees_place(&self, from: Vec2, to: Vec2, radius: f32, through: bool) -> bool {
        let doors = self.doors_between(from, to, 0.98 * radius);
        doors.is_some_and(|d| through || d & self.closed == 0)
    }

    /// Number of the closed door that is nearest along a straight line between two places that walls do not part; 0 for none.
    pub(crate) fn closed_door_between(&self, from: Vec2, to: Vec2, clearance: f32) -> u8 {
        let doors = self.doors_between(from, to, 0.5 * clearance).unwrap_or(0) & self.closed;
        let own = self.outlines.iter().zip(&self.doors).filter(|(_, door)| *door & doors != 0);
        let nearest = own.min_by(|(a, _), (b, _)| a.distance(from).total_cmp(&b.distance(from)));
        nearest.map_or(0, |(_, door)| door.trailing_zeros() as u8 + 1)
    }

    /// The door of a number; none where it is open.
    pub(crate) fn closed_door(&self, number: u8) -> Option<ClosedDoor> {
        let door = 1u64.checked_shl(u32::from(number.checked_sub(1)?))? & self.closed;
        let (outline, _) = self.outlines.iter().zip(&self.doors).find(|(_, own)| *own & door != 0)?;
        let length = |[from, to]: &[Vec2; 2]| from.distance(*to);
        outline.edges().map(|(ends, _)| ends).max_by(|a, b| length(a).total_cmp(&length(b))).map(ClosedDoor)
    }

    /// Calls `visit` for the edges of all that stands near a place, doors left out, with their radii, and the lowest and highest
    /// ground there (m).
    ///
    /// - `floor`: lowest and highest ground of the floor that they stand on (m).
    pub(crate) fn visit_walls_near(
        &self,
        at: Vec2,
        within: f32,
        floor: [f32; 2],
        mut visit: impl FnMut([Vec2; 2], f32, [f32; 2]),
    ) {
        self.edges.visit_near(at, within, |ends, radius, outline| {
            if self.doors[outline] == 0 && self.is_on_floor(outline, floor) {
                visit(ends, radius, self.floors.get(outline).copied().unwrap_or(ALL_HEIGHTS));
            }
        });
    }

    /// Calls `visit` for narrow gaps between corners and what stands beside them: their middle, and the unit vector from wall to
    /// wall; and the lowest and highest ground there.
    ///
    /// - `widths`: narrowest and widest gap on ground between two heights (m).
    pub(crate) fn visit_narrow_gaps(
        &self,
        widths: impl Fn([f32; 2]) -> [f32; 2],
        mut visit: impl FnMut(Vec2, Vec2, [f32; 2]),
    ) {
        for (number, outline) in self.outlines.iter().enumerate().filter(|(n, _)| self.doors[*n] == 0) {
            let floor = self.floors.get(number).copied().unwrap_or(ALL_HEIGHTS);
            let [narrowest, widest] = widths(floor);
            let own = if let ObstacleOutline::Wall { radius, .. } = outline { *radius } else { 0.0 };
            for corner in outline.corners() {
                let mut gaps = Vec::new();
                self.visit_walls_near(corner, own + widest, floor, |ends, radius, _| {
                    let (across, distance) =
                        Space::unit_and_length(throng_geometry::nearest_on_segment(corner, ends) - corner);
                    let width = distance - own - radius;
                    if (narrowest..widest).contains(&width) {
                        gaps.push((corner + across * (own + 0.5 * width), across, width));
                    }
                });
                for (middle, across, width) in gaps {
                    // Nothing else is nearer.
                    if self.is_clear_of_walls(middle, 0.49 * width, floor) {
                        visit(middle, across, floor);
                    }
                }
            }
        }
    }

    /// True if a place keeps a clearance from everything that stands on a floor, doors left out.
    fn is_clear_of_walls(&self, at: Vec2, clearance: f32, floor: [f32; 2]) -> bool {
        let is_passed = |n| self.doors[n] != 0 || !self.is_on_floor(n, floor);
        self.edges.find_near(&self.outlines, [at, at], clearance, is_passed)
    }

    fn is_on_floor(&self, outline: usize, floor: [f32; 2]) -> bool {
        self.floors.get(outline).is_none_or(|own| is_one_floor(*own, floor))
    }

    /// True if a straight line keeps a clearance from everything that stands.
    fn is_clear(&self, a: Vec2, b: Vec2, clearance: f32) -> bool {
        self.doors_between(a, b, clearance).is_some_and(|doors| doors & self.closed == 0)
    }

    /// Doors that are nearer to a straight line than a clearance; `None` if anything else is.
    fn doors_between(&self, a: Vec2, b: Vec2, clearance: f32) -> Option<Doors> {
        let mut all = 0;
        let is_free = self.edges.find_near(&self.outlines, [a, b], clearance, |n| {
            all |= self.doors[n];
            self.doors[n] != 0
        });
        is_free.then_some(all)
    }
}
