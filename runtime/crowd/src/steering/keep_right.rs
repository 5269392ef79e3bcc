//! Between walls, agents keep to the right when a crowd comes.

use crate::{Space, space::solid::ConvexSolid, steering::config::SteeringConfig, steering::forces::SteeredAgent};

/// Position of an agent between the walls beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WallGap {
    /// Position of its left side: below 0 as long as a part of it is in the left half, -1 at the wall on its left. With
    /// a single wall, the sign shows the half.
    pub place: f32,
    /// Whether the nearer one is within [`SteeringConfig::wall_at_hand_m`].
    pub at_hand: bool,
}

/// Distance up to which agents take a solid beside them for a wall: its length, as a lamp post is no wall and a long wall is
/// one across a street; `None` in the air, where there is room above and below (m).
pub(crate) fn is_wall_within<V: Space>(solid: &ConvexSolid<V>, steering: &SteeringConfig) -> Option<f32> {
    let (min, max) = solid.extents();
    let length = (max - min).length();
    (V::DIMENSIONS == 2).then(|| {
        let [near, far] = steering.wall_seen_m;
        if length < steering.wall_length_m {
            0.0
        } else {
            length.min(near).max((steering.wall_seen_share * length).min(far))
        }
    })
}

/// Position of an agent between walls; None where there is none beside it, see [`is_wall_within`].
///
/// - `walls`: numbers of all solids that are so near, and maybe of others.
pub(crate) fn between_walls<V: Space>(
    solids: &[ConvexSolid<V>],
    walls: &[u32],
    &SteeredAgent { position, radius, desired, .. }: &SteeredAgent<V>,
    steering: &SteeringConfig,
) -> Option<WallGap> {
    let right = desired.right();
    let (mut on_left, mut on_right) = (f32::INFINITY, f32::INFINITY);
    for &wall in walls {
        let solid = &solids[wall as usize];
        let (away, distance) = solid.direction_and_distance(position);
        let side = away.dot(right);
        if is_wall_within(solid, steering).is_none_or(|within| distance > within) {
            continue;
        }
        if side > steering.wall_cosine {
            on_left = on_left.min(distance.max(0.0));
        } else if side < -steering.wall_cosine {
            on_right = on_right.min(distance.max(0.0));
        }
    }
    let place = match (on_left < f32::INFINITY, on_right < f32::INFINITY) {
        (true, true) => {
            // Two that meet pass only if each is wholly in its half; where that is too narrow, not at all.
            let half = 0.5 * (on_left + on_right).max(1e-6);
            let aside = if half >= 2.0 * radius { radius } else { 0.0 };
            ((0.5 * (on_left - on_right) - aside) / half).max(-1.0)
        }
        (true, false) => -1.0,
        (false, true) => 1.0,
        (false, false) => return None,
    };
    Some(WallGap { place, at_hand: on_left.min(on_right) < steering.wall_at_hand_m })
}

/// Added to the scores of directions to the right, if so many come toward an agent from afar.
///
/// In the left half of the way between walls, the half of oncoming agents, it moves to the right half before they are
/// there. So two columns form that pass each other; else both groups fill the whole width, and press.
pub(crate) fn right_bias(coming: f32, between: Option<WallGap>, steering: &SteeringConfig) -> f32 {
    let Some(WallGap { place, at_hand }) = between.filter(|b| b.place < 0.0) else { return 0.0 };
    let share = if at_hand { 1.0 } else { (steering.keep_right_afar * -place).min(1.0) };
    steering.keep_right * coming.min(1.0) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn finds_half_of_corridor() {
        let steering = SteeringConfig::default();
        let wall = |y: f32| ConvexSolid::Capsule { from: Vec2::new(-9.0, y), to: Vec2::new(9.0, y), radius: 0.0 };
        let right = Vec2::X.right();
        let both = [wall(2.0 * right.y), wall(-2.0 * right.y)];
        let at = |to_the_right: f32, desired: Vec2, walls: &[u32]| {
            let position = right * to_the_right + Vec2::X;
            between_walls(&both, walls, &SteeredAgent { position, desired, ..SteeredAgent::default() }, &steering)
        };
        let place = |p, at_hand| Some(WallGap { place: p, at_hand });
        assert_eq!(at(0.0, Vec2::X, &[0, 1]), place(0.0, false));
        assert_eq!(at(1.0, Vec2::X, &[0, 1]), place(0.5, true));
        assert_eq!(at(1.0, Vec2::NEG_X, &[0, 1]), place(-0.5, true), "its left on the way back");
        assert_eq!((at(-1.7, Vec2::X, &[1]), at(1.7, Vec2::X, &[0])), (place(-1.0, true), place(1.0, true)));
        assert_eq!((at(1.0, Vec2::Y, &[0, 1]), at(1.0, Vec2::X, &[])), (None, None), "no wall is beside it");
        assert_eq!(at(30.0, Vec2::X, &[0, 1]), None, "they are far away");
        let side = |to_the_right: f32, radius: f32| {
            let position = right * to_the_right;
            let me = SteeredAgent { position, radius, desired: Vec2::X, ..SteeredAgent::default() };
            between_walls(&both, &[0, 1], &me, &steering).map_or(f32::NAN, |b| b.place)
        };
        assert!(side(0.2, 0.3) < 0.0 && side(0.4, 0.3) > 0.0, "a part of it is in the left half, or none");
        assert!(side(0.2, 1.1) > 0.0, "two have no room there");
        let post = ConvexSolid::Ball { centre: right * 3.0, radius: 0.1 };
        let me = SteeredAgent { desired: Vec2::X, ..SteeredAgent::default() };
        assert_eq!(between_walls(&[post], &[0], &me, &steering), None, "a post is no wall");
        let below = ConvexSolid::Ball { centre: Vec3::Y * -2.0, radius: 1.0 };
        let bird = SteeredAgent { desired: Vec3::X, ..SteeredAgent::default() };
        assert_eq!(between_walls(&[below], &[0], &bird, &steering), None, "birds go above or below");
    }

    #[test]
    fn keeps_right_in_left_half_when_others_come() {
        let steering = SteeringConfig::default();
        let keeps = |coming, place, at_hand| right_bias(coming, Some(WallGap { place, at_hand }), &steering);
        assert_eq!((keeps(3.0, -0.1, true), keeps(0.5, -0.1, true)), (steering.keep_right, 0.5 * steering.keep_right));
        assert!(keeps(3.0, -0.2, false) > 0.0 && keeps(3.0, -0.2, false) < steering.keep_right, "no wall is at hand");
        let calm =
            [keeps(0.0, -1.0, true), keeps(3.0, 0.1, true), keeps(3.0, 0.1, false), right_bias(3.0, None, &steering)];
        assert_eq!(calm, [0.0; 4]);
    }
}
