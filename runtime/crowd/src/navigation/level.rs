//! Routes of bodies over a level, on all its floors.

use super::{MOST_SEEN, NARROW_RADII, NavigatedBody};
use crate::routes::path::{RouteCursor, RoutePath};
use crate::{AtEnd, Obstacle, Route, Space};
use crate::{routes::passages::Passages, routes::streets::Streets, space::solid::ConvexSolid};
use glam::{Vec2, Vec3, Vec3Swizzles};
use throng_base::ground::{FLOOR_M, is_one_floor};
use throng_base::{Error, Id, Result};
use throng_geometry::{Bounds2d, BoxGrid};
use throng_level::{Level, LevelPath};

/// Distance from a corner within which a body goes to the next one (m).
const CORNER_M: f32 = 0.3;
/// Largest distance from a corner at which people pass it, and room that they leave to the wall beyond (m).
const WIDEST_M: f32 = 3.0;
const WALL_ROOM_M: f32 = 0.5;
/// Width of stairs below which they belong to a narrow passage that they lead to: nobody waits on them (m).
const STAIRS_M: f32 = 3.5;
/// Share of the width by which the place of one body at a corner differs from that of the next: the golden ratio.
const GOLDEN: f32 = 0.618_034;
/// Points of a route that are nearer to each other are one (m).
const SAME_M: f32 = 1e-3;

/// A level, with the routes of bodies over it.
#[derive(Clone, Debug)]
pub(super) struct LevelRoutes {
    level: Level,
    path: LevelPath,
    /// Heights of the subgoals of each body (m).
    heights: Vec<Vec<f32>>,
    /// Ends of the walls, each of one floor (m), and boxes around them.
    walls: Vec<[Vec3; 2]>,
    boxes: BoxGrid,
}

impl LevelRoutes {
    /// Routes over a level, and its walls.
    pub fn new(level: &Level) -> (Self, Vec<ConvexSolid<Vec2>>) {
        let walls: Vec<[Vec3; 2]> = level.walls_of_floors().collect();
        let mut boxes = BoxGrid::with_capacity(walls.len());
        let solid = |(number, wall): (usize, &[Vec3; 2])| {
            let [from, to] = wall.map(|at| at.xz());
            boxes.set(number, Bounds2d { min: from.min(to), max: from.max(to) });
            ConvexSolid::Capsule { from, to, radius: 0.0 }
        };
        let solids = walls.iter().enumerate().map(solid).collect();
        (Self { level: level.clone(), path: LevelPath::default(), heights: Vec::new(), walls, boxes }, solids)
    }

    /// Passages in which two people of a radius (m) would block each other, on all floors, with the stairs that lead to them.
    pub fn find_passages(&self, radius_m: f32) -> Result<Passages> {
        let wall = |[from, to]: &[Vec3; 2]| Obstacle::Wall { from: *from, to: *to, radius: 0.0 };
        let walls: Vec<Obstacle> = self.walls.iter().map(wall).collect();
        let heights = self.walls.iter().map(|[from, to]| [from.y.min(to.y), from.y.max(to.y)]);
        let streets = Streets::of_level(&walls, heights.collect(), radius_m)?;
        Ok(Passages::find_below(&streets, radius_m, &[NARROW_RADII[0] * radius_m], STAIRS_M))
    }

    /// Route of a body without the points that repeat the one before.
    ///
    /// # Errors
    /// [`Error::NoPath`] where nobody can walk from `at` to the first subgoal.
    pub fn prepare_route(&mut self, body: usize, route: &Route<Vec3>, at: Vec3) -> Result<Route<Vec3>> {
        let mut points = route.subgoals.clone();
        points.dedup_by(|a, b| a.xz().distance(b.xz()) < SAME_M);
        if let Some(&first) = points.first() {
            let found = self.level.path_on_foot(at, first, &mut self.path);
            found.map_err(|_| Error::NoPath { who: Some(Id::first(body)), from: at, to: first })?;
            if route.at_end == AtEnd::Again && points.len() > 1 {
                points.pop_if(|last| last.xz().distance(first.xz()) < SAME_M);
            }
        }
        Ok(Route { subgoals: points, ..route.clone() })
    }

    /// Keeps the heights of a body's subgoals.
    pub fn set_heights(&mut self, body: usize, route: &Route<Vec3>) {
        if self.heights.len() <= body {
            self.heights.resize(body + 1, Vec::new());
        }
        self.heights[body] = route.subgoals.iter().map(|p| p.y).collect();
    }

    /// True for a body within the arrival radius of a subgoal, on its floor.
    pub fn is_at(&self, number: usize, path: &RoutePath<Vec2>, leg: u32, body: &NavigatedBody) -> bool {
        let near = path.subgoal(leg).0.distance(body.position) <= path.route.arrival_radius;
        near && (self.height_of(number, leg, body) - body.height_m).abs() < FLOOR_M
    }

    /// Height of a subgoal; that of the body where its route has none (m).
    fn height_of(&self, number: usize, leg: u32, body: &NavigatedBody) -> f32 {
        let heights = self.heights.get(number);
        heights.and_then(|h| h.get(leg as usize)).copied().unwrap_or(body.height_m)
    }

    /// Aims at the next corner of the shortest path to the subgoal.
    pub fn find_aim(
        &mut self,
        number: usize,
        path: &RoutePath<Vec2>,
        cursor: &mut RouteCursor<Vec2>,
        body: &NavigatedBody,
    ) {
        let (goal, rest) = path.subgoal(cursor.leg);
        let (at, height) = (body.position, self.height_of(number, cursor.leg, body));
        let from = Vec3::new(at.x, body.height_m, at.y);
        if self.level.path_on_foot(from, Vec3::new(goal.x, height, goal.y), &mut self.path).is_err() {
            // Beside the ground, it goes on to the corner that it saw last.
            return;
        }
        let corners = self.path.corners();
        let last = corners.len() - 1;
        let places = (1..last).map(|k| self.place_at_corner(number, [corners[k - 1], corners[k], corners[k + 1]]));
        let (next, aim) = (1..).zip(places).find(|(_, p)| p.distance(at) > CORNER_M).unwrap_or((last, goal));
        let left_m: f32 = corners[next..].windows(2).map(|w| w[0].xz().distance(w[1].xz())).sum();
        (cursor.aim, cursor.rest) = (aim, left_m + rest);
    }

    /// Place of a body at the second of three corners of a path: people keep to the right of what is free there, and not all in
    /// one file.
    fn place_at_corner(&self, number: usize, [before, corner, after]: [Vec3; 3]) -> Vec2 {
        let [before, at, after] = [before, corner, after].map(|c| c.xz());
        let right = Space::right(Space::unit_and_length(after - before).0);
        let out = if (at - before).dot(right) > (after - before).dot(right) * 0.5 { right } else { -right };
        let free_m = self.free_distance(corner, out);
        let share = 0.5 * (number as f32 * GOLDEN).fract();
        at + out * free_m * if out == right { 1.0 - share } else { share }
    }

    /// Free distance from a corner, as far as people spread (m).
    fn free_distance(&self, corner: Vec3, along: Vec2) -> f32 {
        let (at, mut free_m) = (corner.xz(), WIDEST_M + WALL_ROOM_M);
        let end = at + along * free_m;
        self.boxes.visit_intersecting(&Bounds2d { min: at.min(end), max: at.max(end) }, |wall| {
            let [from, to] = self.walls[wall].map(|p| p.xz() - at);
            let across = along.perp_dot(to - from);
            let share = -along.perp_dot(from) / across;
            let distance = (from + (to - from) * share).dot(along);
            if self.is_wall_on_floor(wall, corner.y) && (0.0..=1.0).contains(&share) && distance > 0.0 {
                free_m = free_m.min(distance);
            }
            true
        });
        (free_m - WALL_ROOM_M).max(0.0)
    }

    fn is_wall_on_floor(&self, wall: usize, height_m: f32) -> bool {
        let [from, to] = self.walls[wall].map(|at| at.y);
        is_one_floor([from.min(to), from.max(to)], [height_m; 2])
    }

    /// Walls of a body's floor within a distance of it, the nearest where there are many; returns their number.
    pub fn gather_walls(
        &self,
        solids: &[ConvexSolid<Vec2>],
        body: &NavigatedBody,
        reach_m: f32,
        near: &mut [u32; MOST_SEEN],
    ) -> usize {
        let (mut distances, mut num) = ([0.0; MOST_SEEN], 0);
        self.boxes.visit_intersecting(&Bounds2d::around_disc(body.position, reach_m), |wall| {
            let distance = solids[wall].direction_and_distance(body.position).1;
            let is_here = self.is_wall_on_floor(wall, body.height_m) && distance < reach_m;
            let at = distances[..num].partition_point(|d| *d <= distance);
            if is_here && at < MOST_SEEN {
                num = (num + 1).min(MOST_SEEN);
                distances[at..num].rotate_right(1);
                near[at..num].rotate_right(1);
                (distances[at], near[at]) = (distance, wall as u32);
            }
            true
        });
        num
    }
}
