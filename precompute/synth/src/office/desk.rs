//! The desk and its chair, as `data/units/office.toml` has them, and how to get around them.

use glam::{DVec2, DVec3};

/// Where the seat carries: the middle of what touches it (m).
pub const SEAT: DVec3 = DVec3::new(0.0, 0.46, 0.05);
/// Upper side of the desk (m).
pub const TOP: f64 = 0.74;
/// The ankles' distance in front of the middle of the seat before sitting down: between chair and desk (m).
pub const BEFORE_SEAT: f64 = 0.285;

/// What must not be walked through: lowest and highest corner on the ground (x, z) (m).
const BLOCKED: [[DVec2; 2]; 2] =
    [[DVec2::new(-0.21, -0.24), DVec2::new(0.21, 0.21)], [DVec2::new(-0.7, 0.48), DVec2::new(0.7, 1.18)]];
/// Room that a walker needs around the chair and around the desk (m).
const ROOM: [f64; 2] = [0.4, 0.32];

/// How deep a point of a path is within what a walker must keep out of; 0 where there is room (m).
pub fn blocked(at: DVec2) -> f64 {
    let depth = |[low, high]: [DVec2; 2], room: f64| {
        let inside = (at - low + room).min(high + room - at);
        inside.min_element().max(0.0)
    };
    BLOCKED.iter().zip(ROOM).map(|(b, room)| depth(*b, room)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_chair_and_desk_is_blocked_and_the_room_around_is_free() {
        assert!(blocked(DVec2::ZERO) > 0.5 && blocked(DVec2::new(0.3, 0.8)) > 0.5);
        for free in [(0.66, 0.1), (-0.66, 0.1), (0.0, -0.7), (1.1, 0.8)] {
            assert_eq!(blocked(free.into()), 0.0, "{free:?}");
        }
    }
}
