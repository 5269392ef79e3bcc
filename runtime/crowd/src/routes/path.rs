//! Prepared routes: lines across the path at each subgoal, and the goals of agents that find their own paths.

use crate::space::solid::{ConvexSolid, is_inside};
use crate::{AtEnd, NONE, Obstacle, Route, RouteBegin, Space, error::check};
use serde::{Deserialize, Serialize};
use throng_base::{Result, prefetch};
use throng_geometry::distance_to_segment;

/// Largest extent of a line across the path to either side (m).
const WIDEST_M: f32 = 20.0;
/// Distance to the side at which subgoals in the open are passed: between walls, all that is free there (m).
pub(crate) const OPEN_M: f32 = 1.5;
/// Distance before the line at a subgoal from which on it counts as passed (m).
const ON_LINE_M: f32 = 0.02;
/// Most subgoals between an agent and its goal if it is to go there straight.
const MOST_PASSED: usize = 64;
/// Distance from its place within which an agent without an order stays (m).
const STAY_M: f32 = 0.5;

/// Position of an agent on its route.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RouteCursor<V> {
    /// The subgoal that it goes to.
    pub leg: u32,
    /// Remaining distance from its aim on (m).
    pub rest: f32,
    /// Aim (m).
    pub aim: V,
    /// Time at which it plans its path again (s).
    pub look_at: f64,
}

/// Prepared route. Agents steer to the line across the path at each subgoal and not to the subgoal: they keep their
/// distance from the line through the subgoals, and pass anywhere between the walls; in the open, near the subgoal.
#[derive(Clone, Debug)]
pub(crate) struct RoutePath<V> {
    pub route: Route<V>,
    legs: Vec<RouteLeg<V>>,
    /// Number of each subgoal among the goals of the crowd; none where there are no streets.
    pub goals: Vec<u32>,
    /// True for an agent that stays where it is, which does not plan paths.
    pub stays: bool,
    /// Number of the only agent that may be on it; [`NONE`] where all may be.
    pub owner: u32,
}

/// A subgoal and what leads to it.
#[derive(Clone, Copy, Debug)]
struct RouteLeg<V> {
    to: V,
    /// Unit vector from the subgoal before.
    along: V,
    /// Across the line that is to be passed: half-way between this leg and the next.
    normal: V,
    /// Distances to the left and to the right of the subgoal within which agents aim, and within which it is passed (m).
    aims: [f32; 2],
    passes: [f32; 2],
    /// Distance behind the line within which it is passed (m).
    behind_m: f32,
    /// Distance from the subgoal to the end of the route, along its legs (m).
    rest: f32,
}

impl<V: Space> RouteLeg<V> {
    /// A leg that is the only one: nothing is passed on it.
    fn single_leg(at: V) -> Self {
        Self {
            to: at,
            along: V::default(),
            normal: V::default(),
            aims: [0.0; 2],
            passes: [0.0; 2],
            behind_m: 0.0,
            rest: 0.0,
        }
    }

    /// Offset of a place to the right of the subgoal, in the direction of the line across the path.
    fn side(&self, off: V) -> f32 {
        if V::DIMENSIONS == 2 {
            off.dot(self.normal.right())
        } else {
            (off - self.normal * off.dot(self.normal)).length()
        }
    }

    fn is_passed(&self, x: V, arrival: f32) -> bool {
        let off = x - self.to;
        let side = self.side(off);
        let is_behind = (-ON_LINE_M..=self.behind_m).contains(&off.dot(self.normal));
        is_behind && -self.passes[0] <= side && side <= self.passes[1] || off.length_squared() < arrival * arrival
    }
}

impl<V: Space> RoutePath<V> {
    /// The route of an agent that stays at a place.
    pub fn stay_path(at: V) -> Self {
        let route = Route { subgoals: vec![at], arrival_radius: STAY_M, at_end: AtEnd::Stay };
        Self { route, legs: vec![RouteLeg::single_leg(at)], goals: Vec::new(), stays: true, owner: NONE }
    }

    /// Makes it the route of an agent that stays at a place. Allocates nothing.
    pub fn set_stay(&mut self, at: V) {
        self.lead_to(at, STAY_M, AtEnd::Stay);
        self.stays = true;
    }

    /// Makes it a route with a single goal, which was checked, and whose number is still to be set. Allocates nothing.
    pub fn lead_to(&mut self, goal: V, arrival_radius: f32, at_end: AtEnd) {
        self.route.subgoals.clear();
        self.route.subgoals.push(goal);
        (self.route.arrival_radius, self.route.at_end) = (arrival_radius, at_end);
        self.legs.clear();
        self.legs.push(RouteLeg::single_leg(goal));
        self.stays = false;
    }

    /// Checks a goal and its arrival radius.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`].
    pub fn check_goal(n: usize, goal: V, arrival_radius: f32) -> Result<()> {
        let good = goal.is_finite() && goal.length() < 1e6;
        check("route.subgoals", n, goal.length(), good, "finite and within 1e6 m")?;
        let good = arrival_radius > 0.0 && arrival_radius < 1e6;
        check("route.arrival_radius", n, arrival_radius, good, "above 0 and below 1e6")
    }

    /// Prepares a route.
    ///
    /// - `solids`: static obstacles, between which the path is as wide as it can be.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for a route without subgoals or with numbers that are out of range.
    pub fn new(n: usize, route: &Route<V>, solids: &[ConvexSolid<V>]) -> Result<Self> {
        let goals = &route.subgoals;
        check("route.subgoals", n, goals.len() as f32, !goals.is_empty(), "at least 1")?;
        goals.iter().try_for_each(|&g| Self::check_goal(n, g, route.arrival_radius))?;
        let mut points = goals.clone();
        points.dedup_by(|a, b| (*a - *b).length() < 1e-3);
        let is_round = route.at_end == AtEnd::Again && points.len() > 1;
        if is_round && (points[0] - points[points.len() - 1]).length() < 1e-3 {
            points.pop();
        }
        let num = points.len();
        let ahead = |i: usize| (points[(i + 1) % num] - points[i]).unit_and_length().0;
        let mut legs: Vec<RouteLeg<V>> = (0..num)
            .map(|i| {
                let out = if i + 1 < num || is_round { ahead(i) } else { V::default() };
                let along = if i > 0 || is_round { ahead((i + num - 1) % num) } else { out };
                let (normal, bend) = (along + out).unit_and_length();
                // Where the path turns back there is no line half-way.
                let normal = if bend > 0.3 { normal } else { along };
                let free = [-1.0, 1.0].map(|side| free_distance(points[i], normal.right() * side, solids));
                let is_between = free.iter().all(|&free| free < WIDEST_M);
                let aims = free.map(|free| if is_between { free } else { free.min(OPEN_M) });
                // Agents may come to the first one from anywhere: along the line across what follows, and from behind it.
                let is_first = i == 0 && !is_round && !is_between;
                let passes = if is_first { aims } else { [0, 1].map(|side| free[side].min(2.0 * aims[side])) };
                let behind_m = if is_first { OPEN_M } else { f32::INFINITY };
                RouteLeg { to: points[i], along, normal, aims, passes, behind_m, rest: 0.0 }
            })
            .collect();
        for i in (0..num - 1).rev() {
            legs[i].rest = legs[i + 1].rest + (points[i + 1] - points[i]).length();
        }
        Ok(Self { route: route.clone(), legs, goals: Vec::new(), stays: false, owner: NONE })
    }

    /// Subgoals that agents go to.
    pub fn subgoals(&self) -> impl Iterator<Item = V> + '_ {
        self.legs.iter().map(|l| l.to)
    }

    /// Cursor of an agent at `x`: on the way to a subgoal, or on the leg of a round that it is nearest to.
    pub fn begin_at(&self, x: V, begin: RouteBegin) -> RouteCursor<V> {
        let first = if let RouteBegin::Leg(leg) = begin { leg as usize } else { 0 };
        let mut best = (f32::INFINITY, first.min(self.legs.len() - 1));
        let seeks = self.is_round() && begin == RouteBegin::Nearest;
        for (i, leg) in self.legs.iter().enumerate().filter(|_| seeks) {
            let from = self.legs[(i + self.legs.len() - 1) % self.legs.len()].to;
            let distance = distance_to_segment(x, [from, leg.to]);
            if distance < best.0 - 1e-4 {
                best = (distance, i);
            }
        }
        let leg = best.1 as u32;
        RouteCursor { leg, aim: self.legs[best.1].to, rest: self.legs[best.1].rest, look_at: 0.0 }
    }

    fn is_round(&self) -> bool {
        self.route.at_end == AtEnd::Again && self.legs.len() > 1
    }

    /// Number of subgoals that agents go to.
    pub fn num_legs(&self) -> usize {
        self.legs.len()
    }

    /// Advances to the next subgoals where the line at one is passed; true where it began again.
    pub fn pass_subgoals(&self, cursor: &mut RouteCursor<V>, x: V) -> bool {
        self.advance_cursor(cursor, |leg| self.legs[leg as usize].is_passed(x, self.route.arrival_radius))
    }

    /// As [`RoutePath::pass_subgoals`], for a body that may stop within a distance of its aim beside the end of a round (m).
    pub fn pass_subgoals_within(&self, cursor: &mut RouteCursor<V>, x: V, near_m: f32) -> bool {
        let is_at_end = cursor.rest == 0.0 && (cursor.aim - x).length() <= near_m;
        let end = (is_at_end && cursor.leg as usize + 1 == self.legs.len()).then_some(cursor.leg);
        let arrival = self.route.arrival_radius;
        self.advance_cursor(cursor, |leg| self.legs[leg as usize].is_passed(x, arrival) || end == Some(leg))
    }

    /// Advances to the next subgoals as long as one is passed; true where it began again.
    pub fn advance_cursor(&self, cursor: &mut RouteCursor<V>, is_passed: impl Fn(u32) -> bool) -> bool {
        let mut again = false;
        for _ in 0..self.legs.len() {
            let at = cursor.leg as usize;
            let is_last = at + 1 == self.legs.len();
            if is_last && !self.is_round() || !is_passed(cursor.leg) {
                break;
            }
            again |= is_last;
            cursor.leg = if is_last { 0 } else { cursor.leg + 1 };
        }
        again
    }

    /// Aim of an agent on its leg without obstacles in between: the goal where it can go there straight, otherwise a
    /// point on the line at the subgoal, as far beside the subgoal as the agent is beside the leg. Also the remaining
    /// distance from there.
    pub fn target(&self, leg: u32, x: V, radius: f32) -> (V, f32) {
        let at = leg as usize;
        let last = self.legs.len() - 1;
        let own = &self.legs[at];
        if at == last && !self.is_round() {
            return (own.to, 0.0);
        }
        let goal = self.legs[last].to;
        let crosses = |l: &RouteLeg<V>| {
            let (before, after) = ((x - l.to).dot(l.normal), (goal - l.to).dot(l.normal));
            if before >= 0.0 || after <= 0.0 {
                // Not from before the line to behind it: who is behind already has passed it on the side of a wall.
                return false;
            }
            let side = l.side(x + (goal - x) * (before / (before - after)) - l.to);
            -l.aims[0] + radius <= side && side <= l.aims[1] - radius
        };
        if !self.is_round() && last - at <= MOST_PASSED && self.legs[at..last].iter().all(crosses) {
            return (goal, 0.0);
        }
        if V::DIMENSIONS == 3 {
            return (own.to, own.rest);
        }
        let side = (x - own.to).dot(own.along.right());
        let least = (radius - own.aims[0]).min(0.0);
        let side = side.clamp(least, (own.aims[1] - radius).max(least));
        (own.to + own.normal.right() * side, own.rest)
    }

    /// Number of a subgoal among the goals of the crowd; none where agents do not plan paths.
    pub fn goal_of(&self, leg: u32) -> Option<u32> {
        self.goals.get(leg as usize).copied()
    }

    /// Subgoal, and the distance from it to the end (m).
    pub fn subgoal(&self, leg: u32) -> (V, f32) {
        let leg = &self.legs[leg as usize];
        (leg.to, leg.rest)
    }

    /// Prefetches what leads to a subgoal.
    #[inline]
    pub fn prefetch(&self, leg: u32) {
        if let Some(leg) = self.legs.get(leg as usize) {
            prefetch(leg);
        }
    }

    /// Remaining distance (m).
    pub fn distance_left(&self, cursor: &RouteCursor<V>, x: V) -> f32 {
        (cursor.aim - x).length() + cursor.rest
    }

    /// True where an agent at `x` is at the end.
    pub fn has_arrived(&self, cursor: &RouteCursor<V>, x: V) -> bool {
        let last = cursor.leg as usize + 1 >= self.legs.len();
        let near = self.route.arrival_radius;
        last && !self.is_round() && (self.goal() - x).length_squared() <= near * near
    }

    /// The last subgoal.
    pub fn goal(&self) -> V {
        self.legs[self.legs.len() - 1].to
    }
}

/// True where a goal is in an obstacle.
pub(crate) fn is_in_solid<V: Space>(goal: V, obstacle: &Obstacle<V>, solids: &[ConvexSolid<V>]) -> bool {
    let polygon = matches!(obstacle, Obstacle::Polygon { corners } if is_inside(corners, goal));
    polygon || solids.iter().any(|s| s.direction_and_distance(goal).1 <= 0.0)
}

/// Free distance from a place along a unit vector (m).
fn free_distance<V: Space>(from: V, along: V, solids: &[ConvexSolid<V>]) -> f32 {
    let mut distance = 0.0;
    // Moves on by the distance of the nearest solid on any side, and repeats.
    while distance < WIDEST_M && V::DIMENSIONS == 2 {
        let x = from + along * distance;
        let nearest = solids.iter().map(|s| s.direction_and_distance(x).1).fold(WIDEST_M, f32::min);
        if nearest < 0.02 {
            return distance;
        }
        distance += nearest;
    }
    WIDEST_M
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use proptest::prelude::*;

    fn path(points: &[[f32; 2]], at_end: AtEnd) -> RoutePath<Vec2> {
        let subgoals = points.iter().map(|&p| Vec2::from_array(p)).collect();
        let wall = |y: f32| ConvexSolid::Capsule { from: Vec2::new(-99.0, y), to: Vec2::new(99.0, y), radius: 0.0 };
        RoutePath::new(0, &Route { subgoals, arrival_radius: 0.5, at_end }, &[wall(-5.0), wall(5.0)]).unwrap()
    }

    proptest! {
        /// In a corridor, a route of one point, of two and of many lead the same way, wherever an agent was pushed.
        #[test]
        fn number_of_points_makes_no_difference(x in -40.0f32..39.0, y in -4.0f32..4.0, num in 2usize..30) {
            let at = Vec2::new(x, y);
            let many: Vec<[f32; 2]> = (0..num).map(|i| [-50.0 + 100.0 * i as f32 / (num - 1) as f32, 1.0]).collect();
            let path = path(&many, AtEnd::Stay);
            let mut cursor = path.begin_at(Vec2::new(-50.0, 1.0), RouteBegin::Leg(0));
            path.pass_subgoals(&mut cursor, at);
            prop_assert_eq!(path.target(cursor.leg, at, 0.3), (Vec2::new(50.0, 1.0), 0.0));
        }
    }

    #[test]
    fn keeps_its_distance_from_the_legs_round_a_bend() {
        let path = path(&[[0.0, 0.0], [10.0, 0.0], [10.0, 40.0]], AtEnd::Stay);
        let (aim, rest) = path.target(1, Vec2::new(4.0, -1.0), 0.3);
        assert!(aim.distance(Vec2::new(11.0f32.min(10.0 + 0.707), -0.707)) < 1e-3 && rest == 40.0, "{aim}");
        let mut cursor = path.begin_at(Vec2::new(4.0, -1.0), RouteBegin::Leg(0));
        assert_eq!(cursor.leg, 0);
        path.pass_subgoals(&mut cursor, Vec2::new(4.0, -1.0));
        assert_eq!(cursor.leg, 1, "the first is behind it");
        path.pass_subgoals(&mut cursor, Vec2::new(11.2, -0.9));
        assert_eq!(cursor.leg, 2);
        assert!(path.has_arrived(&cursor, Vec2::new(10.2, 39.8)) && !path.has_arrived(&cursor, Vec2::new(10.0, 39.0)));
    }

    #[test]
    fn begins_again_at_the_first_point() {
        let path = path(&[[0.0, 0.0], [10.0, 0.0], [10.0, 4.0], [0.0, 4.0]], AtEnd::Again);
        let mut cursor = path.begin_at(Vec2::new(0.2, 2.0), RouteBegin::Nearest);
        assert_eq!(cursor.leg, 0, "on the way back to the first");
        let legs = [RouteBegin::Leg(0), RouteBegin::Leg(2), RouteBegin::Nearest];
        assert_eq!(legs.map(|leg| path.begin_at(Vec2::new(9.0, 4.1), leg).leg), [0, 2, 3], "in order unless told");
        assert!(path.pass_subgoals(&mut RouteCursor { leg: 3, ..cursor }, Vec2::new(-0.1, 4.0)));
        assert!(!path.pass_subgoals(&mut cursor, Vec2::new(0.3, 0.1)) && cursor.leg == 1);
    }

    proptest! {
        /// In the open, who goes where a route leads comes near each of its points in turn, wherever it starts.
        #[test]
        fn comes_near_each_point_in_the_open(
            start in prop::array::uniform2(-30.0f32..30.0),
            points in prop::collection::vec(prop::array::uniform2(-30.0f32..30.0), 2..6),
        ) {
            let points: Vec<Vec2> = points.into_iter().map(Vec2::from_array).collect();
            prop_assume!(points.windows(2).all(|w| w[0].distance(w[1]) > 5.0));
            let route = Route { subgoals: points.clone(), arrival_radius: 0.5, at_end: AtEnd::Stay };
            let path = RoutePath::new(0, &route, &[]).unwrap();
            let mut at = Vec2::from_array(start);
            let mut cursor = path.begin_at(at, RouteBegin::Leg(0));
            let mut left = points.as_slice();
            for _ in 0..10_000 {
                path.pass_subgoals(&mut cursor, at);
                while let Some((&first, rest)) = left.split_first().filter(|(p, _)| p.distance(at) < 2.0 * OPEN_M) {
                    (left, _) = (rest, first);
                }
                at += (path.target(cursor.leg, at, 0.3).0 - at).clamp_length_max(0.05);
            }
            prop_assert!(path.has_arrived(&cursor, at), "leg {} at {at}", cursor.leg);
            prop_assert!(left.is_empty(), "never near {:?}", left);
        }
    }

    #[test]
    fn single_subgoal_is_straight_ahead() {
        let path = path(&[[3.0, 4.0]], AtEnd::Stay);
        let cursor = path.begin_at(Vec2::ZERO, RouteBegin::Leg(0));
        assert_eq!(
            (path.target(0, Vec2::ZERO, 0.3), path.distance_left(&cursor, Vec2::ZERO)),
            ((Vec2::new(3.0, 4.0), 0.0), 5.0)
        );
    }
}
