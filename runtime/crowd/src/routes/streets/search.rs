//! The shortest paths over the graph.

use super::{CLOSED_M, Doors, GoalCosts, MOST_CORNERS, NoPath, PointCost, RouteCorner, Streets, TAUT};
use crate::NONE;
use glam::Vec2;
use std::{cmp::Ordering, collections::BinaryHeap};

/// Point that waits to be expanded; the one with the smallest estimate comes first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpenPoint {
    /// Estimated length of the whole path (m).
    estimate: f32,
    /// Straight distance to the goal (m).
    left: f32,
    /// Length from the start (m).
    length: f32,
    n: usize,
}

impl Ord for OpenPoint {
    fn cmp(&self, other: &Self) -> Ordering {
        let order = other.estimate.total_cmp(&self.estimate).then(other.left.total_cmp(&self.left));
        order.then(other.length.total_cmp(&self.length))
    }
}

impl PartialOrd for OpenPoint {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for OpenPoint {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for OpenPoint {}

/// A search for the corners past which an agent may go to a goal.
#[derive(Clone, Copy)]
pub(crate) struct CornerQuery<'a> {
    /// Where the agent is (m).
    pub from: Vec2,
    /// Its radius (m).
    pub radius: f32,
    /// (m)
    pub goal: Vec2,
    /// Costs of the ways to the goal.
    pub costs: &'a GoalCosts,
    /// Detour compared with the best corner up to which one is taken (m).
    pub longer: f32,
    /// Closed doors are passed, as none leads round them; otherwise they are walls.
    pub through: bool,
}

impl Streets {
    /// Corners of the shortest path, found by A*. Equal lengths are resolved by the order in which points were joined.
    pub(super) fn flat_corners(&self, from: Vec2, to: Vec2) -> std::result::Result<Vec<Vec2>, NoPath> {
        let [at_start, at_goal] = self.check_ends(from, to)?;
        if self.is_clear(from, to, at_start.min(at_goal)) {
            return Ok(vec![from, to]);
        }
        let straight = self.doors_between(from, to, at_start.min(at_goal));
        // The points that both ends see, the distances, and the doors in between.
        let sees = |p, clearance| (0..self.points.len()).map(|n| self.sees_point(p, n, clearance)).collect();
        let [seen_from_start, seen_from_goal]: [Vec<_>; 2] = [sees(from, at_start), sees(to, at_goal)];
        let (goal, start) = (self.points.len(), self.points.len() + 1);
        let place = |n: usize| match n {
            _ if n == goal => to,
            _ if n == start => from,
            _ => self.points[n],
        };
        let mut best = vec![f32::INFINITY; start + 1];
        let mut previous = vec![usize::MAX; start + 1];
        let mut open = BinaryHeap::new();
        best[start] = 0.0;
        open.push(OpenPoint { estimate: from.distance(to), left: from.distance(to), length: 0.0, n: start });
        while let Some(OpenPoint { length, n, .. }) = open.pop() {
            if n == goal {
                let on_path = |at: &usize| Some(previous[*at]).filter(|&before| before != usize::MAX);
                let mut path: Vec<Vec2> = std::iter::successors(Some(goal), on_path).map(place).collect();
                path.reverse();
                return Ok(path);
            }
            if best[n] < length {
                continue;
            }
            let here = self.at_doors.get(n).map_or(0, |d| d[0]);
            let mut reach = |next: usize, far: f32, doors: Doors| {
                let then = length + far + CLOSED_M * self.num_closed(doors, here) as f32;
                if then < best[next] && (next >= goal || !self.is_idle(next)) {
                    (best[next], previous[next]) = (then, n);
                    let left = place(next).distance(to);
                    open.push(OpenPoint { estimate: then + left, left, length: then, n: next });
                }
            };
            if n == start {
                let seen = seen_from_start.iter().enumerate().rev();
                seen.filter_map(|(next, s)| Some((next, (*s)?))).for_each(|(next, (far, d))| reach(next, far, d));
                if let Some(doors) = straight {
                    reach(goal, from.distance(to), doors);
                }
                continue;
            }
            let (smaller, larger): (Vec<_>, Vec<_>) = self.seen[n].iter().partition(|s| (s.0 as usize) < n);
            smaller.into_iter().for_each(|(next, far, doors)| reach(next as usize, far, doors));
            if let Some((far, doors)) = seen_from_goal[n] {
                reach(goal, far, doors);
            }
            larger.into_iter().rev().for_each(|(next, far, doors)| reach(next as usize, far, doors));
        }
        Err(NoPath::Separated)
    }

    /// Finds out from where a goal is seen, and how far it is from all points.
    ///
    /// - `open`: memory for [`Streets::find_paths`].
    pub(crate) fn find_costs(&self, goal: Vec2, costs: &mut GoalCosts, open: &mut BinaryHeap<OpenPoint>) {
        (costs.goal, costs.near) = (goal, self.outlines_near(goal));
        costs.seen.clear();
        let seen = |n: usize| self.sees_point(goal, n, costs.near).map(|(far, doors)| (n as u32, far, doors));
        costs.seen.extend((0..self.points.len()).filter_map(seen));
        self.find_paths(costs, open);
    }

    /// Computes the distances of a goal from all points, with the present doors: Dijkstra (1959), from the goal on.
    /// Equal paths are resolved by the numbers of points.
    pub(crate) fn find_paths(&self, costs: &mut GoalCosts, open: &mut BinaryHeap<OpenPoint>) {
        open.clear();
        let GoalCosts { points: of, seen, .. } = costs;
        of.clear();
        of.resize(self.points.len(), PointCost::NO_PATH);
        for &(n, length, doors) in &*seen {
            self.reach_point(n, PointCost { length, next: NONE, closed: self.num_closed(doors, 0) }, of, open);
        }
        while let Some(OpenPoint { length, n, .. }) = open.pop() {
            let at = of[n];
            if at.key() < length {
                continue;
            }
            for &(next, far, doors) in &self.seen[n] {
                let closed = at.closed + self.num_closed(doors, self.at_doors[n][0]);
                self.reach_point(next, PointCost { length: at.length + far, next: n as u32, closed }, of, open);
            }
        }
    }

    /// Notes a path to a point if it is the best one so far.
    fn reach_point(&self, n: u32, then: PointCost, of: &mut [PointCost], open: &mut BinaryHeap<OpenPoint>) {
        let (key, at) = (then.key(), n as usize);
        if key < of[at].key() && !self.is_idle(at) {
            of[at] = then;
            open.push(OpenPoint { estimate: key, left: n as f32, length: key, n: at });
        }
    }

    /// The corners by which shortest paths lead from a place to a goal, the best first, one point of each corner; those that
    /// are much longer than the best are left out. Returns their number; none where nothing leads there.
    pub(crate) fn corners_ahead(
        &self,
        query: &CornerQuery<'_>,
        out: &mut [Option<RouteCorner>; MOST_CORNERS],
    ) -> usize {
        let CornerQuery { from, radius, goal, costs, longer, through } = *query;
        let mut num = 0;
        let mut most = f32::INFINITY;
        // Points in the order of their paths, equal ones in that of their numbers.
        let mut last = (f32::NEG_INFINITY, 0);
        while num < MOST_CORNERS {
            let mut best = (most, NONE);
            for (n, ((p, cost), (away, ..))) in (0u32..).zip(self.points.iter().zip(&costs.points).zip(&self.around)) {
                // The straight line is no longer than any path.
                let is_closed = cost.closed > 0 && !through;
                let cost = cost.key();
                if cost >= best.0 || is_closed {
                    continue;
                }
                let off = *p - from;
                let far = off.length();
                let length = cost + far;
                let is_taut = off.dot(*away).abs() <= TAUT * far || far < 2.0 * self.clearance;
                if length < best.0 && is_taut && (length, n) > last {
                    best = (length, n);
                }
            }
            let (length, n) = best;
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
            // Follows the path to where it leaves this corner.
            let mut on = n;
            while costs.points[on].next != NONE && self.around[on].2 == number {
                on = costs.points[on].next as usize;
            }
            let (next, rest) =
                if self.around[on].2 == number { (goal, 0.0) } else { (self.points[on], costs.points[on].length) };
            let clearance = radius.min(costs.near);
            let (mut last_at, mut ahead, mut door) = (from, Some(n), 0);
            while through && door == 0 && last_at != goal {
                let to = ahead.map_or(goal, |n| self.points[n]);
                door = self.closed_door_between(last_at, to, clearance);
                ahead = ahead.map(|n| costs.points[n].next).filter(|&next| next != NONE).map(|next| next as usize);
                last_at = to;
            }
            let at = self.points[n];
            out[num] = Some(RouteCorner { at, out: away, free, number, next, rest, distance_left: length, door });
            num += 1;
            most = most.min(length + longer);
        }
        num
    }
}

/// Length of a path (m).
pub(super) fn path_length(path: &[Vec2]) -> f32 {
    path.windows(2).map(|w| w[0].distance(w[1])).sum()
}
