//! Ground that groups of characters share: the obstacles and reserved regions that one group gets from others.

use glam::Vec2;
use throng_geometry::{Bounds2d, BoxGrid, Capsule2d};

/// Difference of heights from which ground is another floor: on one floor, bodies that touch differ by less (m).
pub const FLOOR_M: f32 = 1.0;

/// True for ground between two heights that is on the same floor as that between two others (lowest and highest, m).
pub fn is_one_floor(a: [f32; 2], b: [f32; 2]) -> bool {
    a[0] - b[1] < FLOOR_M && b[0] - a[1] < FLOOR_M
}

/// External obstacle: a body that another group moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExternalObstacle {
    /// Position of its centre (m).
    pub place: Vec2,
    /// Mean velocity (m/s).
    pub velocity: Vec2,
    /// Radius of its disc (m).
    pub radius_m: f32,
}

/// Bodies of one group of characters, and the regions that it reserves.
#[derive(Clone, Debug, Default)]
pub struct ReservedRegion {
    /// Bodies of the group.
    pub bodies: Vec<ExternalObstacle>,
    /// Reserved regions, which no other group may enter.
    pub ground: Vec<Capsule2d>,
}

impl ReservedRegion {
    /// Adds a body that stops for nobody, and reserves the ground that it may reach within a second.
    pub fn reserve_ahead(&mut self, body: ExternalObstacle) {
        self.bodies.push(body);
        self.ground.push(Capsule2d { from: body.place, to: body.place + body.velocity, radius_m: body.radius_m });
    }
}

/// External obstacles of one group: bodies of all other groups, to steer around, and their reserved regions, to keep out of.
///
/// Groups that keep out of the regions of others, and reserve all that they may need for their actions and for the stop after
/// them, never overlap each other.
#[derive(Clone, Debug, Default)]
pub struct ExternalObstacles {
    bodies: Vec<ExternalObstacle>,
    reserved: Vec<Capsule2d>,
    body_grid: BoxGrid,
    reserved_grid: BoxGrid,
}

impl ExternalObstacles {
    /// Replaces all obstacles by the bodies and reserved regions of `others`.
    pub fn replace_all<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        if !self.is_empty() {
            self.bodies.clear();
            self.reserved.clear();
            self.body_grid.clear();
            self.reserved_grid.clear();
        }
        for other in others {
            for body in &other.bodies {
                self.body_grid.set(self.bodies.len(), Bounds2d::around_disc(body.place, body.radius_m));
                self.bodies.push(*body);
            }
            for ground in &other.ground {
                self.reserved_grid.set(self.reserved.len(), ground.bounds());
                self.reserved.push(*ground);
            }
        }
    }

    /// True where there are neither bodies nor reserved regions.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.reserved.is_empty()
    }

    /// Calls `found` for every body whose disc's box intersects `bounds`, in no particular order, until it returns false.
    pub fn visit_bodies_near(&self, bounds: &Bounds2d, mut found: impl FnMut(usize, &ExternalObstacle) -> bool) {
        if !self.bodies.is_empty() {
            self.body_grid.visit_intersecting(bounds, |n| found(n, &self.bodies[n]));
        }
    }

    /// Calls `found` for every reserved region whose box intersects `bounds`, in no particular order, until it returns false.
    pub fn visit_reserved_near(&self, bounds: &Bounds2d, mut found: impl FnMut(&Capsule2d) -> bool) {
        if !self.reserved.is_empty() {
            self.reserved_grid.visit_intersecting(bounds, |n| found(&self.reserved[n]));
        }
    }
}
