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
const TO_THE_RIGHT: f32 = 0.8;
/// Share of its speed that it gives up, so that those on its right get before it and it finds a place behind them. With
/// none, corridors of 2 m take a third longer; with 0.6 and more the wide ones take longer.
const GIVES_UP: f32 = 0.4;

/// How strongly it does so where no wall is at hand: the more, the nearer it is to the left one, and never more than at
/// hand. With 0, the middle of corridors of 7 m and more knows no sides: of 4000 members 630 are stuck for a while in
/// place of 45. With more, wide corridors sort themselves at once, and lose in the first seconds what they gain later.
const FROM_AFAR: f32 = 1.5;

/// Where a member is between walls: -1 at the one on its left, 1 at the one on its right, 0 in the middle. None where
/// there is no wall beside it that is near; one alone says which half it is in.
///
/// - `right`: unit vector to its right.
pub(crate) fn between_walls<V: Space>(solids: &[Solid<V>], near: &[u32], position: V, right: V) -> Option<f32> {
    let (mut on_left, mut on_right) = (f32::INFINITY, f32::INFINITY);
    for &s in near {
        let (away, distance) = solids[s as usize].away(position);
        let side = away.dot(right);
        if side > BESIDE {
            on_left = on_left.min(distance.max(0.0));
        } else if side < -BESIDE {
            on_right = on_right.min(distance.max(0.0));
        }
    }
    match (on_left < f32::INFINITY, on_right < f32::INFINITY) {
        (true, true) => Some((on_left - on_right) / (on_left + on_right).max(1e-6)),
        (true, false) => Some(-1.0),
        (false, true) => Some(1.0),
        (false, false) => None,
    }
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
    /// - `between`: see [`between_walls`]; of the walls at hand, and of those farther away too.
    pub fn new(coming: f32, [at_hand, afar]: [Option<f32>; 2]) -> Self {
        let caution = coming.min(1.0);
        match (at_hand, afar) {
            (Some(between), _) if between < 0.0 => {
                Self { to_the_right: TO_THE_RIGHT * caution, gives_up: GIVES_UP * caution }
            }
            (None, Some(between)) if between < 0.0 => {
                Self { to_the_right: TO_THE_RIGHT * caution * (FROM_AFAR * -between).min(1.0), gives_up: 0.0 }
            }
            _ => Self::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn knows_in_which_half_of_a_corridor_it_is() {
        let wall = |y: f32| Solid::Rod { from: Vec2::new(-9.0, y), to: Vec2::new(9.0, y), radius: 0.0 };
        let right = Vec2::X.right();
        let both = [wall(2.0 * right.y), wall(-2.0 * right.y)];
        let at = |to_the_right: f32, ahead: Vec2, near: &[u32]| {
            between_walls(&both, near, right * to_the_right + Vec2::X, ahead.right())
        };
        assert_eq!(at(0.0, Vec2::X, &[0, 1]), Some(0.0));
        assert_eq!(at(1.0, Vec2::X, &[0, 1]), Some(0.5));
        assert_eq!(at(1.0, Vec2::NEG_X, &[0, 1]), Some(-0.5), "its left for who comes back");
        assert_eq!((at(-1.7, Vec2::X, &[1]), at(1.7, Vec2::X, &[0])), (Some(-1.0), Some(1.0)));
        assert_eq!((at(1.0, Vec2::Y, &[0, 1]), at(1.0, Vec2::X, &[])), (None, None), "no wall is beside it");
    }

    #[test]
    fn is_cautious_in_the_left_half_when_somebody_comes() {
        let left = Caution::new(3.0, [Some(-0.1); 2]);
        assert_eq!((left.to_the_right, left.gives_up), (TO_THE_RIGHT, GIVES_UP));
        let afar = Caution::new(3.0, [None, Some(-0.2)]);
        assert!(afar.to_the_right > 0.0 && afar.to_the_right < TO_THE_RIGHT && afar.gives_up == 0.0);
        for (coming, at_hand, afar) in
            [(0.0, Some(-1.0), Some(-0.9)), (3.0, Some(0.1), Some(0.1)), (3.0, None, Some(0.1)), (3.0, None, None)]
        {
            let caution = Caution::new(coming, [at_hand, afar]);
            assert_eq!((caution.to_the_right, caution.gives_up), (0.0, 0.0));
        }
    }
}
