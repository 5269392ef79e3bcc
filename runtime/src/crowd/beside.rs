//! Between walls everybody keeps to the right when a crowd comes.

use super::Space;
use super::solid::Solid;

// Tried in corridors 1.6 m to 5 m wide with 100 to 600 members, one on a square metre in each of two groups, some seeds each.
// If nobody keeps to the right before they meet, all corridors up to 3.5 m jam, and get free only where those in the
// left half step back (see `retreat.rs`), in twice the time.

/// Cosine of the angle to its right, or left, within which a wall is beside a member.
const BESIDE: f32 = 0.7;
/// How much better, as scores go, it then likes to go to the right. With 0.2, 100 members in the `corridor` of the bench
/// get on with 0.75 m/s, with 0.5 with 0.85 m/s, with 0.8 to 2.0 with 0.9 m/s.
const TO_THE_RIGHT: f32 = 1.2;
/// Share of its speed that it gives up, so that those on its right get before it and it finds a place behind them. With
/// none, corridors of 2 m take a third longer; with 0.6 and more the wide ones take longer.
const GIVES_UP: f32 = 0.2;

/// How strongly it does so where no wall is at hand: the more, the nearer it is to the left one, and never more than at
/// hand. With 0, the middle of corridors of 7 m and more knows no sides: of 4000 members 630 are stuck for a while in
/// place of 45. With more, wide corridors sort themselves at once, and lose in the first seconds what they gain later.
const FROM_AFAR: f32 = 2.0;

/// Gap within which walls beside it tell a member in which half of the way it is. [Unit: m]
pub(crate) const SEEN_M: f32 = 20.0;
/// Gap within which one is at hand. [Unit: m]
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

/// Where a member is between walls; None where there is none beside it within [`SEEN_M`]. Nor in the air, where there is
/// room above and below: birds that keep to the right between walls get on with 4.2 m/s in place of 4.5 m/s.
///
/// - `walls`: numbers of all solids that are so near, and maybe of others.
/// - `right`: unit vector to its right.
pub(crate) fn between_walls<V: Space>(solids: &[Solid<V>], walls: &[u32], position: V, right: V) -> Option<Between> {
    if V::DIMENSIONS > 2 {
        return None;
    }
    let (mut on_left, mut on_right) = (f32::INFINITY, f32::INFINITY);
    for &wall in walls {
        let (away, distance) = solids[wall as usize].away(position);
        let side = away.dot(right);
        if distance > SEEN_M {
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

/// What a member does about those who come toward it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Caution {
    /// How much better it likes to go to the right, as scores of directions go.
    pub to_the_right: f32,
    /// Share of its speed that it gives up. [Limit: 0 to 1]
    pub gives_up: f32,
}

impl Caution {
    /// In the left half of the way between walls, the place of those who come, a member wants to get to the right half
    /// before they are there, and falls back to where there is a place for it. So two columns form that pass each other;
    /// else both groups fill the whole width, and press.
    ///
    /// - `coming`: how many come from afar.
    pub fn new(coming: f32, between: Option<Between>) -> Self {
        let caution = TO_THE_RIGHT * coming.min(1.0);
        match between {
            Some(Between { place, at_hand: true }) if place < 0.0 => {
                Self { to_the_right: caution, gives_up: GIVES_UP * coming.min(1.0) }
            }
            Some(Between { place, at_hand: false }) if place < 0.0 => {
                Self { to_the_right: caution * (FROM_AFAR * -place).min(1.0), gives_up: 0.0 }
            }
            _ => Self::default(),
        }
    }
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
        let below = Solid::Ball { centre: Vec3::Y * -2.0, radius: 1.0 };
        assert_eq!(between_walls(&[below], &[0], Vec3::ZERO, Vec3::Y), None, "birds go above or below");
    }

    #[test]
    fn is_cautious_in_the_left_half_when_somebody_comes() {
        let caution = |coming, place, at_hand| Caution::new(coming, Some(Between { place, at_hand }));
        let left = caution(3.0, -0.1, true);
        assert_eq!((left.to_the_right, left.gives_up), (TO_THE_RIGHT, GIVES_UP));
        let afar = caution(3.0, -0.2, false);
        assert!(afar.to_the_right > 0.0 && afar.to_the_right < TO_THE_RIGHT && afar.gives_up == 0.0);
        let calm =
            [caution(0.0, -1.0, true), caution(3.0, 0.1, true), caution(3.0, 0.1, false), Caution::new(3.0, None)];
        for caution in calm {
            assert_eq!((caution.to_the_right, caution.gives_up), (0.0, 0.0));
        }
    }
}
