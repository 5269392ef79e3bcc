//! The desk and its chair, as in `data/units/office.toml`, and the space around them.

use glam::{DVec2, DVec3};

/// Centre of the carrying area of the seat (m).
pub const SEAT: DVec3 = DVec3::new(0.0, 0.46, 0.05);
/// Height of the upper side of the desk (m).
pub const TOP: f64 = 0.74;
/// Distance of the ankles in front of the centre of the seat before sitting down, between chair and desk (m).
pub const BEFORE_SEAT: f64 = 0.285;

/// Blocked areas: lowest and highest corner on the ground (x, z) (m).
const BLOCKED: [[DVec2; 2]; 2] =
    [[DVec2::new(-0.21, -0.24), DVec2::new(0.21, 0.21)], [DVec2::new(-0.7, 0.48), DVec2::new(0.7, 1.18)]];
/// Clearance of a walker around the chair and around the desk (m).
const ROOM: [f64; 2] = [0.4, 0.32];

/// Depth of a point of a path in a blocked area; 0 if free (m).
pub fn is_blocked(at: DVec2) -> f64 {
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
        assert!(is_blocked(DVec2::ZERO) > 0.5 && is_blocked(DVec2::new(0.3, 0.8)) > 0.5);
        for free in [(0.66, 0.1), (-0.66, 0.1), (0.0, -0.7), (1.1, 0.8)] {
            assert_eq!(is_blocked(free.into()), 0.0, "{free:?}");
        }
    }
}
