//! Ways on the ground round what stands: the shortest ones that keep a clearance.
//!
//! A visibility graph: around every corner stand points at a little more than the clearance; points that see each other
//! are joined, and A* (Hart, Nilsson and Raphael 1968) finds the shortest way. Scenes have tens of corners: for these the
//! graph is small and, unlike a mesh of triangles, gives the shortest ways themselves.
//!
//! Doors are what was opened once. The graph leads through them too, and knows of each line between two points which doors it
//! goes through: a door that closes makes no new graph. A closed one is as good as a very long way: none leads there where
//! there is another.

use crate::routes::outline::Outline;
use crate::{AtEnd, NONE, Obstacle, Route};
use glam::{Vec2, Vec3, Vec3Swizzles};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use throng_base::error::check;
use throng_base::{Error, Result};

/// Ways round obstacles that keep a clearance.
#[derive(Clone, Debug)]
pub struct Streets {
    obstacles: Vec<Obstacle>,
    outlines: Vec<Outline>,
    /// Obstacle that each outline is of.
    owners: Vec<usize>,
    bounds: Vec<(Vec2, Vec2)>,
    clearance: f32,
    /// How near to an obstacle a goal may be (m).
    nearest: f32,
    /// Which of the doors each outline is; 0 where it is none.
    doors: Vec<Doors>,
    /// Those that are closed.
    closed: Doors,
    /// Points to go round corners by.
    points: Vec<Vec2>,
    /// Of each point: where it lies from its corner (unit vector), how far it is free that way (m), and the number of its
    /// corner.
    around: Vec<(Vec2, f32, u32)>,
    /// Of each point: the doors that it is in, and the one whose corner it is at.
    at_doors: Vec<[Doors; 2]>,
    /// Of each point: those that it sees and ways may lead to, how far they are (m), and the doors in between.
    seen: Vec<Vec<(u32, f32, Doors)>>,
}

/// A set of doors.
type Doors = u64;

/// How far a goal is from all points of some streets: where it is seen from, or by which point to go on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Costs {
    goal: Vec2,
    /// Points that see the goal, how far they are (m), and the doors in between.
    seen: Vec<(u32, f32, Doors)>,
    /// (points)
    of: Vec<Cost>,
    /// How far the goal is from what stands, if that is less than the clearance (m).
    pub near: f32,
}

impl Costs {
    /// Memory for so many points.
    pub(crate) fn with_capacity(num_points: usize) -> Self {
        Self { seen: Vec::with_capacity(num_points), of: Vec::with_capacity(num_points), ..Self::default() }
    }
}

/// How far a goal is from a point.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// (m)
    way: f32,
    /// Point to go on by; [`NONE`] where the goal is seen.
    next: u32,
    /// Closed doors on the way.
    closed: u32,
}

impl Cost {
    const NO_WAY: Self = Self { way: f32::INFINITY, next: NONE, closed: 0 };

    /// Way that is as bad as this one (m).
    fn key(&self) -> f32 {
        self.way + CLOSED_M * self.closed as f32
    }
}

/// A corner on the way to a goal, as seen from somewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// A point beside the corner (m).
    pub at: Vec2,
    /// Unit vector away from the corner, across the way.
    pub out: Vec2,
    /// How far it is free that way (m).
    pub free: f32,
    /// Number of the corner.
    pub number: u32,
    /// Where the way leads after this corner, and how far it is from there on (m).
    pub next: Vec2,
    pub rest: f32,
    /// Way to the goal by this corner (m).
    pub way: f32,
}

/// Farthest that a corner is taken to be free across the way (m).
const WIDEST_M: f32 = 12.0;
/// Largest part of a straight way at a corner that may lead away from the corner or to it: others are no shortest ways.
const TAUT: f32 = 0.5;
/// Way that is as bad as a closed door (m).
const CLOSED_M: f32 = 1e4;
/// Most corners between which an agent chooses.
pub(crate) const MOST_CORNERS: usize = 6;

/// Why there is no way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoWay {
    /// The start is in that obstacle.
    Start(usize),
    /// The goal is in that obstacle, or too near to it.
    Goal(usize),
    /// What stands separates the two, or leaves no gap that is wide enough.
    Separated,
}

impl Streets {
    /// For agents on the ground: x and z of the world.
    ///
    /// - `clearance_m`: that centres keep from everything that stands: the largest radius and some room (m, > 0). Goals may
    ///   be as near as half of it.
    ///
    /// # Errors
    /// [`Error::Value`] for a clearance out of range, or an obstacle that is not finite.
    pub fn new(obstacles: &[Obstacle], clearance_m: f32) -> Result<Self> {
        Self::with(obstacles, None, clearance_m, 0.5 * clearance_m)
    }

    /// As [`Streets::new`], with all that there is to choose.
    ///
    /// - `heights`: lowest and highest that agents in the air are: what they pass above or below is not gone round (m);
    ///   `None` on the ground.
    /// - `nearest_m`: how near to an obstacle a goal may be (m, 0 to `clearance_m`).
    ///
    /// # Errors
    /// As [`Streets::new`].
    pub fn with(obstacles: &[Obstacle], heights: Option<[f32; 2]>, clearance_m: f32, nearest_m: f32) -> Result<Self> {
        let good = clearance_m > 0.0 && clearance_m < 1e6;
        check("clearance_m", None, clearance_m, good, "above 0 and below 1e6")?;
        let good = (0.0..=clearance_m).contains(&nearest_m);
        check("nearest_m", None, nearest_m, good, "between 0 and the clearance")?;
        let all = obstacles.iter().enumerate().filter_map(|(n, o)| Some((n, Outline::of(o, heights)?)));
        let (owners, outlines): (Vec<_>, Vec<_>) = all.unzip();
        let bounds: Vec<_> = outlines.iter().map(Outline::bounds).collect();
        let odd = bounds.iter().position(|(low, high)| !low.is_finite() || !high.is_finite());
        let expected = "one with coordinates that are finite";
        check("number of an obstacle", None, odd.unwrap_or(0) as f64, odd.is_none(), expected)?;
        let mut streets = Self {
            obstacles: obstacles.to_vec(),
            doors: vec![0; outlines.len()],
            outlines,
            owners,
            bounds,
            clearance: clearance_m,
            nearest: nearest_m,
            closed: 0,
            points: Vec::new(),
            around: Vec::new(),
            at_doors: Vec::new(),
            seen: Vec::new(),
        };
        streets.make_graph();
        Ok(streets)
    }

    /// Joins all points that see each other, through doors too.
    fn make_graph(&mut self) {
        self.points.clear();
        self.around.clear();
        self.at_doors.clear();
        self.seen.clear();
        let outlines = self.outlines.iter().zip(&self.doors);
        let of = |(s, &own): (&Outline, &Doors)| s.points_around(self.clearance).into_iter().map(move |p| (p, own));
        let around: Vec<_> = outlines.flat_map(of).collect();
        let mut number = 0;
        for (i, &((p, corner), own)) in around.iter().enumerate() {
            number += u32::from(i > 0 && around[i - 1].0.1 != corner);
            if let Some(doors) = self.doors_between(p, p, self.clearance) {
                self.join(p, (p - corner).normalize_or_zero(), number, [doors, own]);
            }
        }
    }

    /// Opens an obstacle, or closes it: ways lead through open ones, and round closed ones where there is a way round. The
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

    /// Makes some obstacles doors that are open or not, and all others none; true where there are other doors than before.
    ///
    /// # Errors
    /// [`Error::Value`] for more than 64 doors; nothing has changed then.
    pub(crate) fn set_doors(&mut self, open_of: &[Option<bool>]) -> Result<bool> {
        let num = self.owners.iter().filter(|&&o| open_of[o].is_some()).count();
        check("number of doors", None, num as f64, num <= Doors::BITS as usize, "at most 64")?;
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
                self.around[n].1 = self.free_way(self.points[n], self.around[n].0);
            }
        }
        Ok(is_new)
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

    /// What ways lead round.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// A route from one place to another, through the corners of the shortest way: for crowds without streets of their own.
    ///
    /// # Errors
    /// [`Error::NoWay`] where an obstacle holds one of the places, or nothing leads from one to the other.
    pub fn route(&self, from: Vec3, to: Vec3) -> Result<Route> {
        let corners = self.corners(from, to).map_err(|_| Error::NoWay { who: None, from, to })?;
        Ok(Route { subgoals: corners[1..].to_vec(), arrival_radius: 0.5, at_end: AtEnd::Stay })
    }

    /// Corners of the shortest way, with both its ends; heights go evenly from one to the other. The way keeps the
    /// clearance; the legs of an end that is nearer to an obstacle keep as much as that end has.
    ///
    /// # Errors
    /// [`NoWay`].
    pub fn corners(&self, from: Vec3, to: Vec3) -> std::result::Result<Vec<Vec3>, NoWay> {
        let flat = self.flat_corners(from.xz(), to.xz())?;
        let all = length(&flat).max(1e-6);
        let mut gone = 0.0;
        let legs = std::iter::once(0.0).chain(flat.windows(2).map(|w| w[0].distance(w[1])));
        let raise = |(p, leg): (&Vec2, f32)| {
            gone += leg;
            Vec3::new(p.x, from.y + (to.y - from.y) * (gone / all), p.y)
        };
        Ok(flat.iter().zip(legs).map(raise).collect())
    }

    fn flat_corners(&self, from: Vec2, to: Vec2) -> std::result::Result<Vec<Vec2>, NoWay> {
        let [at_start, at_goal] = self.check_ends(from, to)?;
        if self.is_clear(from, to, at_start.min(at_goal)) {
            return Ok(vec![from, to]);
        }
        let straight = self.doors_between(from, to, at_start.min(at_goal));
        let sees = |p, clearance| (0..self.points.len()).map(|n| self.sees(p, n, clearance)).collect();
        let ends = Ends { from, to, start: sees(from, at_start), goal: sees(to, at_goal), straight };
        self.search(&ends).ok_or(NoWay::Separated)
    }

    /// How near the ends of a way are to what stands, and a hair less, so that rounding does not close the way out (m).
    fn check_ends(&self, from: Vec2, to: Vec2) -> std::result::Result<[f32; 2], NoWay> {
        let stands = |i: &usize| self.doors[*i] == 0 || self.doors[*i] & self.closed != 0;
        let all = 0..self.outlines.len();
        if let Some(i) = all.clone().filter(stands).find(|&i| self.outlines[i].distance(from) <= 0.0) {
            return Err(NoWay::Start(self.owners[i]));
        }
        if let Some(i) = all.clone().find(|&i| self.outlines[i].distance(to) < self.nearest) {
            return Err(NoWay::Goal(self.owners[i]));
        }
        let at_start = all.filter(stands).map(|i| self.outlines[i].distance(from)).fold(self.clearance, f32::min);
        Ok([at_start * 0.999, self.near(to)])
    }

    /// How far a goal is from all outlines, if that is less than the clearance, and a hair less (m).
    fn near(&self, goal: Vec2) -> f32 {
        self.outlines.iter().map(|s| s.distance(goal)).fold(self.clearance, f32::min) * 0.999
    }

    /// Checks that a way leads from a place to a goal, be it through closed doors. Allocates nothing.
    pub(crate) fn check_way(&self, from: Vec2, goal: &Costs) -> std::result::Result<(), NoWay> {
        let [at_start, at_goal] = self.check_ends(from, goal.goal)?;
        let leads = |n: usize| goal.of[n].way.is_finite() && self.sees(from, n, at_start).is_some();
        let straight = self.doors_between(from, goal.goal, at_start.min(at_goal)).is_some();
        if straight || (0..self.points.len()).any(leads) { Ok(()) } else { Err(NoWay::Separated) }
    }

    /// Adds a point, joined with all that it sees.
    fn join(&mut self, p: Vec2, out: Vec2, corner: u32, at_doors: [Doors; 2]) {
        let new = self.points.len();
        let is_taut = |n: usize, d: f32| corner == self.around[n].2 || (self.points[n] - p).dot(out).abs() <= TAUT * d;
        let sees = (0..new).filter_map(|n| self.sees(p, n, self.clearance).map(|(d, doors)| (n as u32, d, doors)));
        let sees: Vec<_> = sees.filter(|&(n, d, _)| is_taut(n as usize, d)).collect();
        for &(n, distance, doors) in &sees {
            self.seen[n as usize].push((new as u32, distance, doors));
        }
        self.seen.push(sees.into_iter().rev().collect());
        let free = self.free_way(p, out);
        self.points.push(p);
        self.around.push((out, free, corner));
        self.at_doors.push(at_doors);
    }

    /// How far a point is that can be seen with a clearance, and that ways may lead to, and the doors in between.
    fn sees(&self, p: Vec2, n: usize, clearance: f32) -> Option<(f32, Doors)> {
        let (q, (out, ..)) = (self.points[n], self.around[n]);
        let distance = p.distance(q);
        let is_taut = (p - q).dot(out).abs() <= TAUT * distance || distance < 2.0 * self.clearance;
        let doors = is_taut.then(|| self.doors_between(p, q, clearance)).flatten()?;
        Some((distance, doors))
    }

    /// True for a point round a door that is open: nothing is there to go round.
    fn is_idle(&self, n: usize) -> bool {
        self.at_doors[n][1] & !self.closed != 0
    }

    /// Number of closed doors of a line, but for those at one of its ends.
    fn num_closed(&self, doors: Doors, but: Doors) -> u32 {
        (doors & self.closed & !but).count_ones()
    }

    /// How far it is free from a point along a unit vector, less the clearance (m).
    fn free_way(&self, from: Vec2, along: Vec2) -> f32 {
        let mut way = 0.0;
        while way < WIDEST_M {
            let x = from + along * way;
            let stands = self.outlines.iter().zip(&self.doors).filter(|(_, d)| **d == 0 || **d & self.closed != 0);
            let nearest = stands.map(|(s, _)| s.distance(x)).fold(WIDEST_M, f32::min) - self.clearance;
            if way > 0.0 && nearest < 0.02 {
                break;
            }
            // Where it begins, its own corner is just as near as may be.
            way += nearest.max(0.05);
        }
        way.min(WIDEST_M)
    }

    /// Finds out from where a goal is seen, and how far it is from all points.
    ///
    /// - `open`: memory for [`Streets::find_ways`].
    pub(crate) fn find_costs(&self, goal: Vec2, costs: &mut Costs, open: &mut BinaryHeap<Open>) {
        (costs.goal, costs.near) = (goal, self.near(goal));
        costs.seen.clear();
        let seen = |n: usize| self.sees(goal, n, costs.near).map(|(far, doors)| (n as u32, far, doors));
        costs.seen.extend((0..self.points.len()).filter_map(seen));
        self.find_ways(costs, open);
    }

    /// How far a goal is from all points, as doors are now: Dijkstra (1959), from the goal on. Equal ways are resolved by the
    /// numbers of points.
    pub(crate) fn find_ways(&self, costs: &mut Costs, open: &mut BinaryHeap<Open>) {
        open.clear();
        let Costs { of, seen, .. } = costs;
        of.clear();
        of.resize(self.points.len(), Cost::NO_WAY);
        for &(n, way, doors) in &*seen {
            self.reach(n, Cost { way, next: NONE, closed: self.num_closed(doors, 0) }, of, open);
        }
        while let Some(Open { length, n, .. }) = open.pop() {
            let at = of[n];
            if at.key() < length {
                continue;
            }
            for &(next, far, doors) in &self.seen[n] {
                let closed = at.closed + self.num_closed(doors, self.at_doors[n][0]);
                self.reach(next, Cost { way: at.way + far, next: n as u32, closed }, of, open);
            }
        }
    }

    /// Notes a way to a point if it is the best one so far.
    fn reach(&self, n: u32, then: Cost, of: &mut [Cost], open: &mut BinaryHeap<Open>) {
        let (key, at) = (then.key(), n as usize);
        if key < of[at].key() && !self.is_idle(at) {
            of[at] = then;
            open.push(Open { estimate: key, left: n as f32, length: key, n: at });
        }
    }

    /// Memory that [`Streets::find_costs`] takes at most: points, and points that wait to be looked at.
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

    /// The corners by which shortest ways lead from a place to a goal, the best first, one point of each corner; those that
    /// are more than `longer` longer than the best are left out. Returns their number; none where nothing leads there.
    ///
    /// - `through`: closed doors are passed, as none leads round them; otherwise they are walls.
    pub(crate) fn corners_ahead(
        &self,
        (from, radius, longer): (Vec2, f32, f32),
        (goal, costs, through): (Vec2, &Costs, bool),
        out: &mut [Option<Corner>; MOST_CORNERS],
    ) -> usize {
        let mut num = 0;
        let mut most = f32::INFINITY;
        // Points in the order of their ways, equal ones in that of their numbers.
        let mut last = (f32::NEG_INFINITY, 0);
        while num < MOST_CORNERS {
            let mut best = (most, NONE);
            for (n, ((p, cost), (away, ..))) in (0u32..).zip(self.points.iter().zip(&costs.of).zip(&self.around)) {
                // The straight line is no longer than any way.
                let is_closed = cost.closed > 0 && !through;
                let cost = cost.key();
                if cost >= best.0 || is_closed {
                    continue;
                }
                let off = *p - from;
                let far = off.length();
                let way = cost + far;
                let is_taut = off.dot(*away).abs() <= TAUT * far || far < 2.0 * self.clearance;
                if way < best.0 && is_taut && (way, n) > last {
                    best = (way, n);
                }
            }
            let (way, n) = best;
            if n == NONE {
                break;
            }
            last = best;
            if out[..num].iter().flatten().any(|c| c.number == self.around[n as usize].2) {
                continue;
            }
            let n = n as usize;
            if !self.sees_place(from, self.points[n], radius, through) {
                continue;
            }
            let (away, free, number) = self.around[n];
            // On to where the way leaves this corner.
            let mut on = n;
            while costs.of[on].next != NONE && self.around[on].2 == number {
                on = costs.of[on].next as usize;
            }
            let (next, rest) =
                if self.around[on].2 == number { (goal, 0.0) } else { (self.points[on], costs.of[on].way) };
            out[num] = Some(Corner { at: self.points[n], out: away, free, number, next, rest, way });
            num += 1;
            most = most.min(way + longer);
        }
        num
    }

    /// True if a straight line keeps a clearance from everything that stands.
    fn is_clear(&self, a: Vec2, b: Vec2, clearance: f32) -> bool {
        self.doors_between(a, b, clearance).is_some_and(|doors| doors & self.closed == 0)
    }

    /// Doors that are nearer to a straight line than a clearance; `None` if anything else is.
    fn doors_between(&self, a: Vec2, b: Vec2, clearance: f32) -> Option<Doors> {
        let (low, high) = (a.min(b) - clearance, a.max(b) + clearance);
        let is_near = |(l, h): &(Vec2, Vec2)| l.cmple(high).all() && h.cmpge(low).all();
        let near = self.outlines.iter().zip(&self.doors).zip(&self.bounds).filter(|(_, b)| is_near(b));
        let mut in_the_way = near.map(|(o, _)| o).filter(|(s, _)| s.distance_of_line(a, b) < clearance);
        in_the_way.try_fold(0, |all, (_, &door)| (door != 0).then_some(all | door))
    }

    /// A* from the start to the goal, which do not see each other. Equal lengths are resolved by the order in which points
    /// were joined.
    fn search(&self, ends: &Ends) -> Option<Vec<Vec2>> {
        let (goal, start) = (self.points.len(), self.points.len() + 1);
        let place = |n: usize| match n {
            _ if n == goal => ends.to,
            _ if n == start => ends.from,
            _ => self.points[n],
        };
        let mut best = vec![f32::INFINITY; start + 1];
        let mut previous = vec![usize::MAX; start + 1];
        let mut open = BinaryHeap::new();
        best[start] = 0.0;
        open.push(Open {
            estimate: ends.from.distance(ends.to),
            left: ends.from.distance(ends.to),
            length: 0.0,
            n: start,
        });
        while let Some(Open { length, n, .. }) = open.pop() {
            if n == goal {
                let mut way = vec![ends.to];
                let mut at = previous[goal];
                while at != usize::MAX {
                    way.push(place(at));
                    at = previous[at];
                }
                way.reverse();
                return Some(way);
            }
            if best[n] < length {
                continue;
            }
            let here = self.at_doors.get(n).map_or(0, |d| d[0]);
            let mut reach = |next: usize, far: f32, doors: Doors| {
                let then = length + far + CLOSED_M * self.num_closed(doors, here) as f32;
                if then < best[next] && (next >= goal || !self.is_idle(next)) {
                    (best[next], previous[next]) = (then, n);
                    let left = place(next).distance(ends.to);
                    open.push(Open { estimate: then + left, left, length: then, n: next });
                }
            };
            if n == start {
                let seen = ends.start.iter().enumerate().rev();
                seen.filter_map(|(next, s)| Some((next, (*s)?))).for_each(|(next, (far, d))| reach(next, far, d));
                if let Some(doors) = ends.straight {
                    reach(goal, ends.from.distance(ends.to), doors);
                }
                continue;
            }
            let (smaller, larger): (Vec<_>, Vec<_>) = self.seen[n].iter().partition(|s| (s.0 as usize) < n);
            smaller.into_iter().for_each(|(next, far, doors)| reach(next as usize, far, doors));
            if let Some((far, doors)) = ends.goal[n] {
                reach(goal, far, doors);
            }
            larger.into_iter().rev().for_each(|(next, far, doors)| reach(next as usize, far, doors));
        }
        None
    }
}

/// Both ends of a way, how far the points are that they see, and the doors in between.
struct Ends {
    from: Vec2,
    to: Vec2,
    start: Vec<Option<(f32, Doors)>>,
    goal: Vec<Option<(f32, Doors)>>,
    /// Doors on the straight line, if nothing else is.
    straight: Option<Doors>,
}

/// A point whose neighbours are to be looked at; the one with the smallest estimate comes first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Open {
    /// Of the whole way (m).
    estimate: f32,
    /// In a straight line to the goal (m).
    left: f32,
    /// From the start (m).
    length: f32,
    n: usize,
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        let order = other.estimate.total_cmp(&self.estimate).then(other.left.total_cmp(&self.left));
        order.then(other.length.total_cmp(&self.length))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Open {}

/// Length of a way (m).
fn length(way: &[Vec2]) -> f32 {
    way.windows(2).map(|w| w[0].distance(w[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{FRAC_PI_2, SQRT_2};

    fn ground([x, z]: [f32; 2]) -> Vec3 {
        Vec3::new(x, 0.0, z)
    }

    fn wall(from: [f32; 2], to: [f32; 2]) -> Obstacle {
        Obstacle::Wall { from: ground(from), to: ground(to), radius: 0.0 }
    }

    fn streets(obstacles: Vec<Obstacle>, clearance: f32, nearest: f32) -> Streets {
        Streets::with(&obstacles, None, clearance, nearest).unwrap()
    }

    /// Length of the shortest way over a fine grid whose steps keep the clearance: brute force.
    fn over_grid(map: &Streets, from: Vec2, to: Vec2, half: f32, step: f32) -> Option<f32> {
        let n = (2.0 * half / step) as i32 + 1;
        let at = |i: i32| Vec2::new((i % n) as f32, (i / n) as f32) * step - half;
        let index = |p: Vec2| {
            let c = ((p + half) / step).round();
            c.y as i32 * n + c.x as i32
        };
        // Sixteen directions: ways over a grid are at most 3 % longer than straight ones.
        let mut moves = Vec::new();
        for dx in -2i32..=2 {
            for dz in -2i32..=2 {
                let is_primitive = (dx.abs(), dz.abs()) != (2, 2) && (dx, dz) != (0, 0) && dx.abs() + dz.abs() != 2
                    || (dx.abs(), dz.abs()) == (1, 1);
                if is_primitive {
                    moves.push((dx, dz));
                }
            }
        }
        let mut best = vec![f32::INFINITY; (n * n) as usize];
        let mut open = BinaryHeap::from([(std::cmp::Reverse(0u64), index(from))]);
        best[index(from) as usize] = 0.0;
        while let Some((_, i)) = open.pop() {
            if i == index(to) {
                return Some(best[i as usize]);
            }
            for (dx, dz) in &moves {
                let (x, z) = (i % n + dx, i / n + dz);
                if x < 0 || z < 0 || x >= n || z >= n {
                    continue;
                }
                let j = z * n + x;
                let then = best[i as usize] + at(i).distance(at(j));
                if then < best[j as usize] - 1e-5 && map.is_clear(at(i), at(j), map.clearance) {
                    best[j as usize] = then;
                    open.push((std::cmp::Reverse((then * 1e4) as u64), j));
                }
            }
        }
        None
    }

    #[test]
    fn ways_are_as_short_as_over_a_grid_and_keep_the_clearance() {
        let scenes = [
            vec![wall([0.0, -3.0], [0.0, 2.0])],
            vec![wall([-1.0, -9.0], [-1.0, 2.0]), wall([1.5, -2.0], [1.5, 9.0])],
            vec![
                Obstacle::Polygon {
                    corners: [[-1.0, -2.0], [1.0, -2.5], [2.0, 2.0], [0.0, 0.5], [-2.0, 3.0]].map(ground).to_vec(),
                },
                Obstacle::Ball { centre: ground([0.0, 4.5]), radius: 0.8 },
            ],
        ];
        for (s, solids) in scenes.into_iter().enumerate() {
            let map = streets(solids, 0.4, 0.3);
            for (from, to) in [([-4.0, 0.0], [4.0, 0.0]), ([-4.0, -4.0], [4.0, 3.0]), ([-4.0, 2.0], [3.0, -1.0])] {
                let (from, to) = (Vec2::from(from), Vec2::from(to));
                let way = map.flat_corners(from, to).unwrap();
                assert_eq!((way[0], way[way.len() - 1]), (from, to));
                for leg in way.windows(2) {
                    assert!(map.is_clear(leg[0], leg[1], 0.399), "scene {s}: {leg:?}");
                }
                let brute = over_grid(&map, from, to, 6.0, 0.1).expect("a way over the grid");
                assert!(length(&way) <= 1.01 * brute, "scene {s}: {} against {brute}", length(&way));
                assert!(length(&way) >= 0.95 * brute, "scene {s}: {} against {brute}", length(&way));
            }
        }
    }

    /// Around the end of a wall: a tangent, an arc, a tangent.
    #[test]
    fn way_round_a_wall_end_is_nearly_shortest() {
        let map = streets(vec![wall([0.0, -50.0], [0.0, 0.0])], 1.0, 1.0);
        let reach = SQRT_2;
        let way = map.flat_corners(Vec2::new(-reach, 0.0), Vec2::new(reach, 0.0)).unwrap();
        let exact = 2.0 * 1.0 + FRAC_PI_2;
        assert!(length(&way) >= exact && length(&way) < 1.05 * exact, "{} against {exact}", length(&way));
    }

    #[test]
    fn way_to_a_visible_goal_is_straight() {
        let map = streets(vec![wall([0.0, -3.0], [0.0, -1.0])], 0.4, 0.4);
        let ends = [Vec2::new(-2.0, 0.0), Vec2::new(2.0, 0.0)];
        assert_eq!(map.flat_corners(ends[0], ends[1]), Ok(ends.to_vec()));
    }

    #[test]
    fn narrow_gaps_and_goals_in_walls_are_refused() {
        let gap = |half: f32| vec![wall([0.0, -9.0], [0.0, -half]), wall([0.0, half], [0.0, 9.0])];
        let room = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0], [-9.0, -9.0]];
        let around = || room.windows(2).map(|w| wall(w[0], w[1]));
        let (from, to) = (Vec2::new(-3.0, 4.0), Vec2::new(3.0, 1.0));
        let wide = streets(gap(0.6).into_iter().chain(around()).collect(), 0.5, 0.4).flat_corners(from, to);
        assert!(wide.unwrap().len() > 2);
        let narrow = streets(gap(0.4).into_iter().chain(around()).collect(), 0.5, 0.4).flat_corners(from, to);
        assert_eq!(narrow, Err(NoWay::Separated));
        let block =
            Obstacle::Polygon { corners: [[2.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 2.0]].map(ground).to_vec() };
        let map = streets(vec![block], 0.5, 0.3);
        assert_eq!(map.flat_corners(from, to), Err(NoWay::Goal(0)));
        assert_eq!(map.flat_corners(to, from), Err(NoWay::Start(0)));
        assert_eq!(map.flat_corners(from, Vec2::new(4.2, 1.0)), Err(NoWay::Goal(0)), "too near");
        assert!(map.flat_corners(from, Vec2::new(4.4, 1.0)).is_ok(), "nearer than the clearance, but not too near");
        assert!(map.flat_corners(Vec2::new(4.2, 1.0), from).is_ok(), "an agent at the wall gets away from it");
    }

    #[test]
    fn routes_turn_at_corners_and_are_refused_through_blocks() {
        let block = Obstacle::Box { min: ground([-1.0, -4.0]), max: ground([1.0, 4.0]) };
        let streets = Streets::new(&[block], 0.4).unwrap();
        let (from, to) = (ground([-5.0, 0.0]), ground([5.0, 0.0]));
        let route = streets.route(from, to).unwrap();
        assert!(route.subgoals.len() > 2 && route.subgoals.iter().any(|p| p.z.abs() > 4.3), "{route:?}");
        assert_eq!(streets.route(from, from + Vec3::Z).unwrap().subgoals, [from + Vec3::Z], "nothing is in the way");
        let inside = streets.route(from, Vec3::ZERO).unwrap_err();
        assert!(matches!(inside, Error::NoWay { to: Vec3::ZERO, .. }), "{inside}");
        assert!(matches!(Streets::new(&[], 0.0), Err(Error::Value { what: "clearance_m", .. })));
    }

    /// Two rooms with a door between them, and a way round the wall or none.
    fn rooms(far: f32) -> Vec<Obstacle> {
        vec![wall([0.0, -far], [0.0, -0.6]), wall([0.0, 0.6], [0.0, far + 1.0]), wall([0.0, -0.6], [0.0, 0.6])]
    }

    #[test]
    fn ways_lead_through_open_doors_and_round_closed_ones() {
        let mut map = streets(rooms(8.0), 0.4, 0.3);
        let (from, to) = (Vec2::new(-3.0, 4.0), Vec2::new(3.0, 1.0));
        let closed = map.flat_corners(from, to).unwrap();
        map.set_open(2, true).unwrap();
        let open = map.flat_corners(from, to).unwrap();
        // As if the door were not there.
        let without = streets(rooms(8.0)[..2].to_vec(), 0.4, 0.3).flat_corners(from, to).unwrap();
        assert!((length(&open) - length(&without)).abs() < 1e-3, "{open:?} {without:?}");
        assert!(length(&open) < 0.7 * length(&closed));
        map.set_open(2, false).unwrap();
        let again = map.flat_corners(from, to).unwrap();
        assert!((length(&again) - length(&closed)).abs() < 1e-3, "{again:?} {closed:?}");
        assert!(map.set_open(3, true).is_err());
    }

    #[test]
    fn ways_lead_to_a_closed_door_where_no_other_leads_on() {
        let room = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0], [-9.0, -9.0]];
        let around = room.windows(2).map(|w| wall(w[0], w[1]));
        let mut map = streets(rooms(9.0).into_iter().chain(around).collect(), 0.4, 0.3);
        let (from, to) = (Vec2::new(-3.0, 4.0), Vec2::new(3.0, 1.0));
        assert_eq!(map.flat_corners(from, to), Err(NoWay::Separated));
        map.set_open(2, true).unwrap();
        let open = map.flat_corners(from, to).unwrap();
        map.set_open(2, false).unwrap();
        assert_eq!(map.flat_corners(from, to), Ok(open), "it was a door once");
        // Two doors beside each other, one closed.
        let doors = [wall([0.0, -5.0], [0.0, -3.8])];
        let mut walls = vec![wall([0.0, -9.0], [0.0, -5.0]), wall([0.0, -3.8], [0.0, -0.6])];
        walls.extend(rooms(9.0)[1..].iter().cloned().chain(doors));
        walls.extend(room.windows(2).map(|w| wall(w[0], w[1])));
        let mut map = streets(walls, 0.4, 0.3);
        for (first, second) in [(3, 4), (4, 3)] {
            map.set_open(second, false).unwrap();
            map.set_open(first, true).unwrap();
            let way = map.flat_corners(from, to).unwrap();
            let (z, half) = if first == 3 { (0.0, 0.6) } else { (-4.4, 0.6) };
            let at = |w: &[Vec2]| w[0].lerp(w[1], w[0].x / (w[0].x - w[1].x)).y;
            let crosses = way.windows(2).find(|w| w[0].x <= 0.0 && w[1].x > 0.0).map(at).unwrap();
            assert!((crosses - z).abs() < half, "door {first}: {way:?}");
        }
    }

    #[test]
    fn ways_in_the_air_pass_above_what_is_low_and_rise_evenly() {
        let column = |x: f32, high: f32| Obstacle::Wall { from: Vec3::X * x, to: Vec3::new(x, high, 0.0), radius: 1.0 };
        let streets = Streets::with(&[column(5.0, 3.0), column(0.0, 30.0)], Some([5.0, 20.0]), 1.5, 1.0).unwrap();
        let (from, to) = (Vec3::new(-9.0, 6.0, 0.0), Vec3::new(9.0, 16.0, 0.0));
        let way = streets.corners(from, to).unwrap();
        assert!(way.len() > 2 && way[0] == from && way[way.len() - 1] == to, "{way:?}");
        assert!(way.windows(2).all(|w| w[0].y < w[1].y), "{way:?}");
        assert_eq!(streets.corners(from, Vec3::new(0.0, 9.0, 0.5)), Err(NoWay::Goal(1)));
    }
}
