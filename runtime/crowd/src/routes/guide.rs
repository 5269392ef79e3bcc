//! Where an agent aims: at its goal where it sees it, otherwise at the place across the way at the next corner by which
//! it expects to be there first.
//!
//! The way round a corner is a line from the corner to the other side. An agent compares places along it, and along those
//! of other corners by which it is not much farther: the length of the way by each, and the time that those cost who are
//! there or come toward it, as the density grid tells. So the shortest way is taken where nobody is, the whole width of
//! a bend or a row of doors where many are, and those who come the other way are left room. (Least expected time: Hoogendoorn
//! and Bovy 2004, with what an agent sees in place of an equilibrium.)

use crate::Space;
use crate::routes::path::{Cursor, Path};
use crate::routes::streets::{MOST_CORNERS, Streets};
use crate::steering::config::SteeringConfig;
use crate::steering::density_grid::DensityGrid;
use crate::steering::far_field::coming;
use glam::{Vec2, Vec3, Vec3Swizzles};

/// What an agent that looks for its way knows.
pub(crate) struct Guide<'a, V> {
    pub streets: Option<&'a Streets>,
    pub grid: &'a DensityGrid<V>,
    pub steering: &'a SteeringConfig,
}

/// Most places that are compared at a corner.
const PLACES: usize = 8;

impl<V: Space> Guide<'_, V> {
    /// Looks for the way of an agent at `x`.
    pub fn look(&self, path: &Path<V>, cursor: &mut Cursor<V>, x: V, radius: f32) {
        let (target, rest) = path.target(cursor.leg, x, radius);
        let before = cursor.aim;
        (cursor.aim, cursor.rest) = (target, rest);
        let Some((streets, costs)) = self.streets.zip(path.costs(cursor.leg)) else { return };
        let (from, to) = (x.to_world(), target.to_world());
        if streets.sees_place(from.xz(), to.xz(), radius.min(costs.near)) {
            return;
        }
        let (goal, rest) = path.subgoal(cursor.leg);
        let goal = goal.to_world();
        let mut corners = [None; MOST_CORNERS];
        let longer = self.steering.detour_m;
        let num = streets.corners_ahead((from.xz(), radius, longer), (goal.xz(), costs), &mut corners);
        let ahead = Space::unit_and_length(corners[0].map_or(Vec2::ZERO, |c| c.next - from.xz())).0;
        let direction = V::from_world(Vec3::new(ahead.x, 0.0, ahead.y));
        let coming = coming(self.grid, x, direction, f32::INFINITY, self.steering)[0].min(1.0);
        let mut best = (f32::INFINITY, Vec2::ZERO, 0.0);
        for corner in corners[..num].iter().flatten() {
            let straight = from.xz().distance(corner.at) + corner.at.distance(corner.next);
            // The way past the corner, along which others count that go it or come.
            let across = corner.out.perp();
            let along = if (corner.next - from.xz()).dot(across) >= 0.0 { across } else { -across };
            let step = self.steering.place_m;
            let num = ((corner.free / step) as usize + 1).min(PLACES);
            // Where many come, each keeps to the right: of what it passes, and in what it passes.
            let leads_left = (corner.at - from.xz()).dot(Space::right(ahead)) < 0.0;
            let is_right = corner.out.dot(Space::right(along)) > 0.0;
            let half = 0.5 * corner.free;
            for k in 0..num {
                let at = corner.at + corner.out * (step * k as f32);
                let longer = from.xz().distance(at) + at.distance(corner.next) - straight;
                let in_left_half = if is_right { half - step * k as f32 } else { step * k as f32 - half };
                let left = if leads_left { self.steering.pass_left_m } else { 0.0 };
                let left = left + self.steering.left_half_cost * in_left_half.max(0.0);
                let mut cost = corner.way + longer + coming * left + self.delay(from.xz(), at, along);
                if at.distance(before.to_world().xz()) < step {
                    cost -= self.steering.keep_aim_m;
                }
                if cost < best.0 && (k == 0 || streets.sees_place(from.xz(), at, radius)) {
                    best = (cost, at, at.distance(corner.next) + corner.rest);
                }
            }
        }
        let (_, at, left) = best;
        if num > 0 {
            let all = (from.xz().distance(at) + left).max(1e-3);
            let height = from.y + (goal.y - from.y) * (from.xz().distance(at) / all);
            cursor.aim = V::from_world(Vec3::new(at.x, height, at.y));
            cursor.rest = left + rest;
        }
    }

    /// What those who are on the last metres of the way to a place, or come from there, cost (m).
    fn delay(&self, from: Vec2, at: Vec2, along: Vec2) -> f32 {
        let steering = self.steering;
        let (toward, distance) = Space::unit_and_length(at - from);
        let direction = V::from_world(Vec3::new(along.x, 0.0, along.y));
        let mut cost = 0.0;
        for k in 0..3 {
            let back = k as f32 / self.grid.per_m();
            if back > distance {
                break;
            }
            let p = at - toward * back;
            let square = self.grid.square(V::from_world(Vec3::new(p.x, 0.0, p.y)) * self.grid.per_m());
            let opposed = square.opposed(direction);
            cost += steering.oncoming_cost_m * opposed + steering.crowd_cost_m * (square.num() - opposed);
        }
        cost
    }
}
