//! Looking far: which directions the crowd at large makes better or worse.

use super::flow::Flow;
use super::sight::DIRECTIONS;
use super::{Field, Space};

/// Places along each direction where the flow is asked, in squares of its grid: so far away that nobody finds there
/// what it added to the flow itself.
const BESIDE: [f32; 3] = [1.7, 3.2, 4.7];
/// How many of these tell how fast those who are there go; farther away only where they want to go counts.
const NEAREST: usize = 2;
/// Places straight on where those who come toward a member are looked for, in squares.
const AHEAD: [f32; 5] = [3.0, 5.0, 7.0, 9.0, 11.0];
/// The same still farther away, where there are no walls that tell it where to go. 1000 members on a disc that go to the
/// opposite points then turn aside before they are dense, and get on with 0.7 m/s in place of 0.5 m/s.
const FAR_AHEAD: [f32; 4] = [13.5, 16.0, 19.0, 22.0];
/// Places straight on, from its own on, where those count who are in its way already, in squares.
const AT_HAND: [f32; 3] = [0.0, 1.0, 2.0];
/// Those of a square who want its way beyond which more of them make it no better. Without a limit all draw together, the
/// more so the more they are: 2000 members in the `corridor` of the bench get on with 0.66 m/s over 60 s in place of 0.73
/// m/s, with a limit of 4 as well. With 0 (it only keeps off those who go against it) 39 of them are stuck in place of 3.
const MANY_AGREED: f32 = 1.0;
/// Those who come toward it that make it turn aside with all its will. Less of them do less with the third power, as it
/// passes a few one by one: with the first one, sparse rings and flocks lose a twentieth of their speed.
const MANY: f32 = 4.0;
/// Members of a square to the right at which it turns aside less, and with which it does not: the right side is full.
const FULL: [f32; 2] = [3.0, 5.0];
/// Time for which a direction is free to be wholly worth turning to. [Unit: s]
pub(crate) const OPEN_S: f32 = 0.5;

/// What a member makes of those who come toward it from afar.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lean {
    /// How many there are, but for those who are farther still.
    pub coming: f32,
    /// How much better it likes to go to the right, as scores of directions go.
    pub to_the_right: f32,
    /// The same where there is room.
    pub evades: f32,
}

/// How many come toward one who goes along a unit vector, or want to: from afar, and from farther still. None from
/// beyond what is left of its way, as if that led straight on.
///
/// - `left`: way to its goal. [Unit: m]
#[inline]
pub(crate) fn coming<V: Space>(flow: &Flow<V>, position: V, ahead: V, left: f32) -> [f32; 2] {
    let (at, near) = (position * flow.per_m(), left * flow.per_m());
    let opposed = |k: &f32| if *k <= near { flow.square(at + ahead * *k).opposed(ahead) } else { 0.0 };
    [AHEAD.iter().map(opposed).sum(), FAR_AHEAD.iter().map(opposed).sum()]
}

/// Has the squares fetched from memory that [`coming`] looks at.
#[inline]
pub(crate) fn prefetch_outlook<V: Space>(flow: &Flow<V>, position: V, ahead: V) {
    let at = position * flow.per_m();
    flow.prefetch(AHEAD.iter().chain(&FAR_AHEAD).map(|&k| at + ahead * k));
}

/// How much better one likes to go to the right in the open, where so many come toward it: two crowds that meet head-on
/// slide past each other instead of pressing, and those who all cross in one place go round it. Between walls, see
/// [`super::beside`].
#[inline]
pub(crate) fn evades(field: &Field, coming: f32) -> f32 {
    let share = (coming / MANY).min(1.0);
    field.evading * share * share * share
}

/// How many come toward one who goes along a unit vector, or want to, and are near.
#[inline]
pub(crate) fn facing<V: Space>(flow: &Flow<V>, position: V, ahead: V) -> f32 {
    let at = position * flow.per_m();
    AT_HAND.map(|k| flow.square(at + ahead * k).opposed(ahead)).iter().sum()
}

/// A member that looks far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Far<'a, V> {
    pub position: V,
    /// Where it could go; the first one is the one it desires.
    pub directions: &'a [V; DIRECTIONS],
    /// Desired speed. [Unit: m/s]
    pub speed: f32,
    /// Way to its goal: what is beyond does not matter. [Unit: m]
    pub left: f32,
}

impl<V: Space> Far<'_, V> {
    /// How much better each direction is, with its component to the right and the time for which it is free.
    ///
    /// Worse where others stand or come toward the member, and where they want to go against it, even if they stand;
    /// better where they want to go its way. Those who want the same thus follow each other, and lanes form.
    ///
    /// - `evades`: how much better the right is where there is room, see [`evades`].
    #[inline]
    pub fn prefer(
        &self,
        field: &Field,
        flow: &Flow<V>,
        evades: f32,
        side: &[f32; DIRECTIONS],
        free: &[f32; DIRECTIONS],
    ) -> [f32; DIRECTIONS] {
        let mut better = [0.0; DIRECTIONS];
        let near = self.left * flow.per_m();
        if self.speed <= 0.0 || near < BESIDE[0] {
            return better;
        }
        let (at, ahead) = (self.position * flow.per_m(), self.directions[0]);
        let per_speed = self.speed.recip();
        if field.crowding > 0.0 || field.lanes > 0.0 {
            for (better, &direction) in better.iter_mut().zip(self.directions) {
                for (place, &k) in BESIDE.iter().enumerate().take_while(|(_, k)| **k <= near) {
                    let square = flow.square(at + direction * k);
                    *better += field.lanes * (square.agreed(ahead).min(MANY_AGREED) - square.opposed(ahead));
                    if place < NEAREST {
                        *better -= field.crowding * square.against(direction * per_speed);
                    }
                }
            }
        }
        if evades > 0.0 {
            let aside = evades * self.room(flow, at);
            for i in 0..DIRECTIONS {
                let open = if side[i] > 0.0 { (free[i] / OPEN_S).min(1.0) } else { 1.0 };
                better[i] += aside * side[i] * open;
            }
        }
        better
    }

    /// How much room there is to its right for those who turn aside. [Limit: 0 to 1]
    #[inline]
    fn room(&self, flow: &Flow<V>, at: V) -> f32 {
        let ahead = self.directions[0];
        let right = at + ahead.right();
        let there = flow.square(right).num().max(flow.square(right + ahead).num());
        ((FULL[1] - there) / (FULL[1] - FULL[0])).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    /// A place in squares from the middle of a square where somebody is.
    fn place(flow: &Flow<Vec2>, at: Vec2) -> Vec2 {
        (at + 0.5) * flow.side()
    }

    /// What somebody there who goes along X prefers.
    fn prefer(flow: &Flow<Vec2>, left: f32) -> [f32; DIRECTIONS] {
        let directions = Vec2::X.fan();
        let far = Far { position: place(flow, Vec2::ZERO), directions: &directions, speed: 1.3, left };
        let side = directions.map(|d| d.dot(Vec2::X.right()));
        let field = Field::default();
        let coming = coming(flow, far.position, Vec2::X, left).iter().sum();
        far.prefer(&field, flow, evades(&field, coming), &side, &[9.0; DIRECTIONS])
    }

    #[test]
    fn follows_those_who_want_its_way_and_keeps_off_those_who_do_not() {
        let mut flow = Flow::new(0.3, Vec2::splat(60.0), 100);
        // Two columns that stand: at 37 degrees to the right they want its way, to the left the other one.
        for (direction, intent) in [(Vec2::X.fan()[3], Vec2::X), (Vec2::X.fan()[4], Vec2::NEG_X)] {
            for k in BESIDE {
                flow.add(place(&flow, direction * k), Vec2::ZERO, intent);
            }
        }
        let better = prefer(&flow, 50.0);
        assert!(better[3] > 0.1 && better[4] < -0.1, "{better:?}");
        assert_eq!(prefer(&flow, 1.0), [0.0; DIRECTIONS], "all of it is beyond the goal");
    }

    #[test]
    fn evades_many_who_are_far_away_and_few_hardly() {
        let field = Field::default();
        let mut flow = Flow::new(0.3, Vec2::splat(60.0), 100);
        for k in FAR_AHEAD {
            flow.add(place(&flow, Vec2::X * k), Vec2::NEG_X * 1.3, Vec2::NEG_X);
        }
        let at = place(&flow, Vec2::ZERO);
        assert_eq!(coming(&flow, at, Vec2::X, 50.0), [0.0, 4.0]);
        assert_eq!(coming(&flow, at, Vec2::X, 10.0), [0.0, 0.0], "its way ends before they come");
        assert_eq!((evades(&field, 4.0), evades(&field, 9.0)), (field.evading, field.evading));
        assert!(evades(&field, 1.0) < 0.02 * field.evading);
    }

    #[test]
    fn turns_right_for_a_crowd_that_comes_while_there_is_room() {
        let mut flow = Flow::new(0.3, Vec2::splat(60.0), 100);
        for k in AHEAD {
            flow.add(place(&flow, Vec2::X * k), Vec2::NEG_X * 1.3, Vec2::NEG_X);
        }
        let better = prefer(&flow, 50.0);
        assert!(better[3] > better[0] + 0.05 && better[3] > better[4] + 0.1, "{better:?}");
        for _ in 0..5 {
            flow.add(place(&flow, Vec2::X.right()), Vec2::X, Vec2::X);
        }
        let better = prefer(&flow, 50.0);
        assert!((better[3] - better[4]).abs() < 0.02, "the right side is full: {better:?}");
    }
}
