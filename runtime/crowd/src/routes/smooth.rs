//! Subgoals whose spline keeps close to a way of straight legs.

use crate::Space;

/// Distance from the corners of a way at which its spline is tied to it (m).
const TIE_M: f32 = 0.6;

/// Subgoals of a way through corners, its start the first of them: the goal alone where it is straight ahead, otherwise
/// all corners, with points near them that keep the spline close to the way.
///
/// - `radius`: of the agent (m).
pub fn tie<V: Space>(corners: &[V], radius: f32) -> Vec<V> {
    match corners {
        [_, goal] => vec![*goal],
        corners => smooth(corners, TIE_M.max(2.0 * radius)),
    }
}

/// Adds points to the long legs of a way, `near` from both their ends, so that a spline through all points turns at the
/// corners and is straight between them: it leaves the way by a small part of `near` at most.
fn smooth<V: Space>(way: &[V], near: f32) -> Vec<V> {
    let mut out = Vec::with_capacity(3 * way.len());
    for (i, leg) in way.windows(2).enumerate() {
        let length = (leg[1] - leg[0]).length();
        out.push(leg[0]);
        let is_corner = [i > 0, i + 2 < way.len()];
        if length > 3.0 * near {
            let step = (leg[1] - leg[0]) * (near / length);
            out.extend(is_corner[0].then_some(leg[0] + step));
            out.extend(is_corner[1].then_some(leg[1] - step));
        }
    }
    out.extend(way.last());
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn long_legs_get_points_near_corners() {
        let way = [[0.0, 0.0], [10.0, 0.0], [10.0, 1.0], [10.0, 9.0]].map(Vec2::from);
        let out = smooth(&way, 0.5);
        let expected = [[0.0, 0.0], [9.5, 0.0], [10.0, 0.0], [10.0, 1.0], [10.0, 1.5], [10.0, 9.0]];
        assert_eq!(out, expected.map(Vec2::from));
        assert_eq!(smooth(&way[..2], 0.5), way[..2]);
        assert!(smooth::<Vec2>(&[], 0.5).is_empty());
    }
}
