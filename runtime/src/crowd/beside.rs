//! Between walls everybody keeps to the right when a crowd comes.

use super::Space;
use super::solid::Solid;

// Tried in corridors 2 m to 14 m wide with 100 to 2000 members, one on a square metre in each of two groups, some seeds each.
// If nobody keeps to the right before they meet, the narrow ones get free only where those in the left half step back
// (see `retreat.rs`), and in the wide ones knots form.

/// Cosine of the angle to its right, or left, within which a wall is beside a member.
const BESIDE: f32 = 0.7;
/// How much better, as scores go, it then likes to go to the right. With 0.2, 500 members in a corridor of 7 m get on with
/// 0.58 m/s over 80 s, with 0.6 with 0.76 m/s, with 1.2 to 2.0 with 0.85 m/s; with 2.0 narrow ones take a little longer.
const TO_THE_RIGHT: f32 = 1.2;
/// How strongly it does so where no wall is at hand: the more, the nearer it is to the left one, and never more than at
/// hand. With 0, the middle of corridors of 7 m and more knows no sides: 500 members get on with 0.57 m/s over 80 s, and of
/// 2000 in 14 m 600 are stuck for a while; with 1, with 0.80 m/s, with 2 to 4 with 0.85 m/s.
const FROM_AFAR: f32 = 2.0;

/// Farthest from its centre that walls beside it tell a member in which half of the way it is. With 5 m, two crowds of 5000 that meet in
/// a street of 33 m block each other: 1300 have waited for 10 s and more after 200 s, with 10 m 25, with 20 m nobody.
/// [Unit: m]
const SEEN_M: f32 = 20.0;
/// Farthest that one is at hand. With 1 m, corridors of 3 m jam; with 3 m, those of 7 m take a tenth longer. [Unit: m]
const AT_HAND_M: f32 = 2.0;

/// Where a member is between the walls beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Between {
    /// -1 at the one on its left, 1 at the one on its right, 0 in the middle; where there is one alone, that says in which
    /// half it is.
    pub place: f32,
    /// Whether the nearer one is within [`AT_HAND_M`].
    pub at_hand: bool,
}

/// How far from a solid those it is beside take it for a wall: as far as it is long, as a lamp post is none and a long
/// wall is one across a street; none in the air, where there is room above and below. [Unit: m]
pub(crate) fn is_wall_within<V: Space>(solid: &Solid<V>) -> Option<f32> {
    let (min, max) = solid.extents();
    (V::DIMENSIONS == 2).then(|| (max - min).length().min(SEEN_M))
}

/// Where a member is between walls; None where there is none beside it, see [`is_wall_within`].
///
/// - `walls`: numbers of all solids that are so near, and maybe of others.
/// - `right`: unit vector to its right.
pub(crate) fn between_walls<V: Space>(solids: &[Solid<V>], walls: &[u32], position: V, right: V) -> Option<Between> {
    let (mut on_left, mut on_right) = (f32::INFINITY, f32::INFINITY);
    for &wall in walls {
        let solid = &solids[wall as usize];
        let (away, distance) = solid.away(position);
        let side = away.dot(right);
        if is_wall_within(solid).is_none_or(|within| distance > within) {
            continue;
        }
        if side > BESIDE {
            on_left = on_left.min(distance.max(0.0));
        } else if side < -BESIDE {
            on_right = on_right.min(distance.max(0.0));
        }
    }
    let place = match (on_left < f32::INFINITY, on_right < f32::INFINITY) {
        (true, true) => (on_left - on_right) / (on_left + on_right).max(1e-6),
        (true, false) => -1.0,
        (false, true) => 1.0,
        (false, false) => return None,
    };
    Some(Between { place, at_hand: on_left.min(on_right) < AT_HAND_M })
}

/// How much better a member likes to go to the right, as scores of directions go, if so many come toward it from afar.
///
/// In the left half of the way between walls, the place of those who come, it wants to get to the right half before they
/// are there. So two columns form that pass each other; else both groups fill the whole width, and press.
pub(crate) fn keeps_right(coming: f32, between: Option<Between>) -> f32 {
    let Some(Between { place, at_hand }) = between.filter(|b| b.place < 0.0) else { return 0.0 };
    let share = if at_hand { 1.0 } else { (FROM_AFAR * -place).min(1.0) };
    TO_THE_RIGHT * coming.min(1.0) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn knows_in_which_half_of_a_corridor_it_is() {
        let wall = |y: f32| Solid::Rod { from: Vec2::new(-9.0, y), to: Vec2::new(9.0, y), radius: 0.0 };
        let right = Vec2::X.right();
        let both = [wall(2.0 * right.y), wall(-2.0 * right.y)];
        let at = |to_the_right: f32, ahead: Vec2, walls: &[u32]| {
            between_walls(&both, walls, right * to_the_right + Vec2::X, ahead.right())
        };
        let place = |p, at_hand| Some(Between { place: p, at_hand });
        assert_eq!(at(0.0, Vec2::X, &[0, 1]), place(0.0, false));
        assert_eq!(at(1.0, Vec2::X, &[0, 1]), place(0.5, true));
        assert_eq!(at(1.0, Vec2::NEG_X, &[0, 1]), place(-0.5, true), "its left for who comes back");
        assert_eq!((at(-1.7, Vec2::X, &[1]), at(1.7, Vec2::X, &[0])), (place(-1.0, true), place(1.0, true)));
        assert_eq!((at(1.0, Vec2::Y, &[0, 1]), at(1.0, Vec2::X, &[])), (None, None), "no wall is beside it");
        assert_eq!(at(30.0, Vec2::X, &[0, 1]), None, "they are far away");
        let post = Solid::Ball { centre: right * 3.0, radius: 0.1 };
        assert_eq!(between_walls(&[post], &[0], Vec2::ZERO, right), None, "a post is no wall");
        let below = Solid::Ball { centre: Vec3::Y * -2.0, radius: 1.0 };
        assert_eq!(between_walls(&[below], &[0], Vec3::ZERO, Vec3::Y), None, "birds go above or below");
    }

    #[test]
    fn keeps_right_in_the_left_half_when_somebody_comes() {
        let keeps = |coming, place, at_hand| keeps_right(coming, Some(Between { place, at_hand }));
        assert_eq!((keeps(3.0, -0.1, true), keeps(0.5, -0.1, true)), (TO_THE_RIGHT, 0.5 * TO_THE_RIGHT));
        assert!(keeps(3.0, -0.2, false) > 0.0 && keeps(3.0, -0.2, false) < TO_THE_RIGHT, "no wall is at hand");
        let calm = [keeps(0.0, -1.0, true), keeps(3.0, 0.1, true), keeps(3.0, 0.1, false), keeps_right(3.0, None)];
        assert_eq!(calm, [0.0; 4]);
    }
}
