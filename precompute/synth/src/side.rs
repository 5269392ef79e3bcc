//! Left and right, and the directions of a heading on the ground.

use glam::{DVec2, DVec3};
pub use throng_motion::side::LateralSide;

/// The ground direction (x, z) of a heading.
pub fn forward(heading: f64) -> DVec2 {
    DVec2::new(heading.sin(), heading.cos())
}

/// The ground direction (x, z) to the left of a heading.
pub fn leftward(heading: f64) -> DVec2 {
    DVec2::new(heading.cos(), -heading.sin())
}

/// A point or direction on the ground (x, z), at a height.
pub fn over_ground(p: DVec2, height: f64) -> DVec3 {
    DVec3::new(p.x, height, p.y)
}

/// Ground position (x, z) of a point.
pub fn ground_position(p: DVec3) -> DVec2 {
    DVec2::new(p.x, p.z)
}

/// Horizontal direction of a heading.
pub fn forward_direction(heading: f64) -> DVec3 {
    over_ground(forward(heading), 0.0)
}

/// Horizontal direction to the left of a heading.
pub fn left_direction(heading: f64) -> DVec3 {
    over_ground(leftward(heading), 0.0)
}
