//! Aim of an agent: its goal where it sees it, otherwise the place across the path at the next corner by which it
//! expects to arrive first.
//!
//! The path round a corner crosses a line from the corner to the other side. An agent compares places along this line,
//! and along those of other corners with paths that are not much longer: the length of the path by each, and the delay
//! by agents that are there or come toward it, as the density grid shows. So the shortest path is taken where there are
//! no others, the whole width of a bend or a row of doors where there are many, and oncoming agents are left room.
//! (Least expected time: Hoogendoorn and Bovy 2004, with the agent's view in place of an equilibrium.)
//!
//! An agent that sees its goal compares too, if many come: else all would leave the outer half of a bend as soon as
//! they see along it, and walk across oncoming agents. The straight path then is one of the paths, by the place where
//! it crosses the line at a corner.

use crate::routes::path::{RouteCursor, RoutePath};
use crate::routes::streets::{CornerQuery, MOST_CORNERS, RouteCorner, Streets};
use crate::steering::density_grid::DensityGrid;
use crate::{Space, routes::goals::GoalTable, steering::config::SteeringConfig, steering::far_field::oncoming};
use glam::{Vec2, Vec3, Vec3Swizzles};

/// Inputs of an agent's path search.
pub(crate) struct Guide<'a, V> {
    pub streets: Option<&'a Streets>,
    pub goals: &'a GoalTable,
    pub grid: &'a DensityGrid<V>,
    pub steering: &'a SteeringConfig,
    /// Distance within which a place at a corner is reached: the next one is taken where it is seen (m).
    pub reached_m: f32,
}

/// Most places that are compared at a corner.
const PLACES: usize = 8;
/// Number of squares beyond a place within which oncoming agents count.
const BEYOND: u32 = 4;
/// Nearer than this to the ends of the line at a corner counts as on it (m).
const EDGE_M: f32 = 1.0;

impl<V: Space> Guide<'_, V> {
    /// Finds the aim of an agent at `x`; returns the number of the closed door before which it has to wait, or 0.
    pub fn find_aim(&self, path: &RoutePath<V>, cursor: &mut RouteCursor<V>, x: V, radius: f32) -> u8 {
        let (target, rest) = path.target(cursor.leg, x, radius);
        let before = cursor.aim;
        (cursor.aim, cursor.rest) = (target, rest);
        let Some((streets, costs)) = self.streets.zip(path.goal_of(cursor.leg).map(|n| self.goals.costs(n))) else {
            return 0;
        };
        let (from, mut to) = (x.to_world(), target.to_world());
        let sees = |to: Vec3| streets.sees_place(from.xz(), to.xz(), radius.min(costs.near), false);
        let mut sees_it = sees(to);
        // Of the line across the path, a part may be behind a wall: then the subgoal itself counts.
        let subgoal = path.subgoal(cursor.leg).0;
        if !sees_it && sees(subgoal.to_world()) {
            (sees_it, to, cursor.aim) = (true, subgoal.to_world(), subgoal);
        }
        let offset_to_goal = to.xz() - from.xz();
        if sees_it && !self.is_anybody_coming(x, offset_to_goal) {
            return 0;
        }
        let (goal, rest) = path.subgoal(cursor.leg);
        let goal = goal.to_world();
        let mut corners = [None; MOST_CORNERS];
        let longer = self.steering.detour_m;
        let query = CornerQuery { from: from.xz(), radius, goal: goal.xz(), costs, longer, through: false };
        let mut num = streets.corners_ahead(&query, &mut corners);
        // Where all paths lead through closed doors, the agent waits before one.
        let through = num == 0 && !sees_it;
        if through {
            if streets.sees_place(from.xz(), to.xz(), radius.min(costs.near), true) {
                return streets.closed_door_between(from.xz(), to.xz(), radius.min(costs.near));
            }
            num = streets.corners_ahead(&CornerQuery { through: true, ..query }, &mut corners);
        }
        let ahead = Space::unit_and_length(corners[0].map_or(Vec2::ZERO, |c| c.next - from.xz())).0;
        let coming = oncoming(self.grid, x, V::over_ground(ahead), f32::INFINITY, self.steering)[0].min(1.0);
        let mut best = (f32::INFINITY, Vec2::ZERO, 0.0);
        let (mut is_best_reached, mut door) = (true, 0);
        let mut straight_on = f32::INFINITY;
        for corner in corners[..num].iter().flatten() {
            let straight = from.xz().distance(corner.at) + corner.at.distance(corner.next);
            // The path past the corner, along which agents in both directions count.
            let along = corner.direction_from(from.xz());
            let step = self.steering.place_m;
            let num = ((corner.free / step) as usize + 1).min(PLACES);
            // Where many come, each keeps to the right: of what it passes, and in what it passes.
            let leads_left = (corner.at - from.xz()).dot(Space::right(ahead)) < 0.0;
            let is_right = corner.out.dot(Space::right(along)) > 0.0;
            let half = 0.5 * corner.free;
            let on_the_left = |out: f32| {
                let in_left_half = if is_right { half - out } else { out - half };
                let left = if leads_left { self.steering.pass_left_m } else { 0.0 };
                coming * (left + self.steering.left_half_cost * in_left_half.max(0.0))
            };
            if sees_it {
                let Some((at, out)) = crossing_at_corner(from.xz(), offset_to_goal, corner) else { continue };
                let cost = offset_to_goal.length() + on_the_left(out) + self.delay_at(from.xz(), at, along);
                straight_on = straight_on.min(cost);
            }
            let beyond = if sees_it { 0.0 } else { 1.0 };
            for k in 0..num {
                let at = corner.at + corner.out * (step * k as f32);
                let longer = from.xz().distance(at) + at.distance(corner.next) - straight;
                let delay = self.delay_at(from.xz(), at, along) + beyond * self.delay_beyond(at, along);
                let mut cost = corner.distance_left + longer + on_the_left(step * k as f32) + delay;
                if at.distance(before.to_world().xz()) < step {
                    cost -= self.steering.keep_aim_m;
                }
                let is_reached = at.distance(from.xz()) < self.reached_m;
                let is_better = if is_reached == is_best_reached { cost < best.0 } else { is_best_reached };
                if is_better && (k == 0 || streets.sees_place(from.xz(), at, radius, through)) {
                    best = (cost, at, at.distance(corner.next) + corner.rest);
                    (is_best_reached, door) = (is_reached, corner.door);
                }
            }
        }
        let (cost, at, left) = best;
        if cost < straight_on {
            let all = (from.xz().distance(at) + left).max(1e-3);
            let height = from.y + (goal.y - from.y) * (from.xz().distance(at) / all);
            cursor.aim = V::from_world(Vec3::new(at.x, height, at.y));
            cursor.rest = left + rest;
        }
        door
    }

    /// Cost of the agents on the last metres of the path to a place, and of those that come from there (m).
    fn delay_at(&self, from: Vec2, at: Vec2, along: Vec2) -> f32 {
        let steering = self.steering;
        let (toward, distance) = Space::unit_and_length(at - from);
        let direction = V::over_ground(along);
        let mut cost = 0.0;
        for k in 0..3 {
            let back = k as f32 / self.grid.per_m;
            if back > distance {
                break;
            }
            let p = at - toward * back;
            let square = self.grid.square(V::over_ground(p) * self.grid.per_m);
            let opposed = square.num_opposed(direction);
            cost += steering.oncoming_cost_m * opposed + steering.crowd_cost_m * (square.num - opposed);
        }
        cost
    }

    /// Cost of the agents that come toward a place from beyond it: a door that others stream out of is left to them
    /// (m).
    fn delay_beyond(&self, at: Vec2, along: Vec2) -> f32 {
        let (place, direction) = (V::over_ground(at) * self.grid.per_m, V::over_ground(along));
        let opposed = (1..=BEYOND).map(|k| self.grid.square(place + direction * k as f32).num_opposed(direction));
        // One is left out, which may be the agent itself.
        self.steering.beyond_cost_m * (opposed.sum::<f32>() - 1.0).max(0.0)
    }

    /// True where others come along a straight line.
    fn is_anybody_coming(&self, x: V, direction: Vec2) -> bool {
        let (ahead, length) = Space::unit_and_length(direction);
        oncoming(self.grid, x, V::over_ground(ahead), length, self.steering)[0] > 0.0
    }
}

/// Point where a straight line crosses the line at a corner, and its distance from the corner; None where it does not.
fn crossing_at_corner(from: Vec2, direction: Vec2, corner: &RouteCorner) -> Option<(Vec2, f32)> {
    let (off, across) = (corner.at - from, direction.perp_dot(corner.out));
    let (share, out) = (off.perp_dot(corner.out) / across, off.perp_dot(direction) / across);
    let is_ahead = share > 0.0 && share < 1.0;
    // The line begins and ends where a centre may be; some are nearer to what stands.
    (is_ahead && out > -EDGE_M && out < corner.free + EDGE_M).then(|| (from + direction * share, out))
}
