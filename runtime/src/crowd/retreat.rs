//! Who steps back where two crowds press against each other and nobody gets on.

use super::Space;
use super::flow::Flow;

// Other numbers were tried in the tests of jams, in corridors 2.4 m and 4 m wide in which 8 or 20 members meet 30, and in
// corridors 1.6 m to 5 m wide in which 50 to 300 meet as many, some seeds each. If nobody steps back, a third of the small
// groups never get through, and none of the large ones in corridors up to 3.5 m. What is said in shares of time was tried
// before directions were judged by the speed that they allow (see `sight.rs`); what is said in metres a second, after that.

/// Time without getting on after which a member may step back: about what it takes to go round somebody. 0.3 s and 2 s
/// make no difference beyond that of seeds. [Unit: s]
const PATIENT_S: f64 = 0.7;
/// The same in the left half of the way between walls. With 0.7 s narrow corridors take a tenth longer, with 0.2 s those
/// of 3 m and more do. [Unit: s]
pub(crate) const LEAST_PATIENT_S: f64 = 0.4;
/// How far it looks for those who press it and for those who back it, in squares of the flow's grid. With 1 it knows too
/// little, and hardly anything is gained; with 6 two members of a dense packing of two crowds stay behind, and where
/// streams cross many step back that need not.
const FAR: usize = 3;
/// The same between walls, where whole columns have to back out. With 12, of 300 members in a corridor of 2 m 118 get
/// through within 300 s in place of 196, and with 1 corridors of 3 m jam as well; with 32 those of 3 m take longer.
const FAR_BETWEEN_WALLS: usize = 18;
/// How many times as many as those who go its way, and how many more, have to be against it: so many that the two sides
/// hardly ever both find themselves the weaker one. With 8 more, the few more often stand where they should step back;
/// with none more, wide corridors with 8 take a fifth longer.
const STRONGER: f32 = 1.3;
const MORE: f32 = 3.0;
/// As many times more (less) in the right (left) half of the way between walls, so that those on the right hardly ever
/// step back and those on the left nearly always do. With 3 times 100 members in a corridor of 3 m get on with 0.54 m/s in
/// place of 0.64 m/s, with 1.5 times with 0.44 m/s; 12 times make no difference beyond that of seeds.
const OWN_HALF: f32 = 6.0;
/// Backward and rightward parts of the way of who steps back: more to the right, where the others keep to their own right
/// too and leave room. Straight back, wide corridors with 8 take a third longer.
const BACK: f32 = 0.57;
const RIGHT: f32 = 0.8;
/// Share of its desired speed with which it does so. Half of it, or all, make no difference beyond that of seeds.
pub(crate) const SLOWLY: f32 = 0.84;

/// A half of the way between walls, as who goes along it sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Half {
    /// That of those who come toward it.
    Left,
    /// Its own.
    Right,
}

/// A member that does not get on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held<V> {
    pub position: V,
    /// Unit vector along which it wants to go.
    pub ahead: V,
    /// Time without getting on, [`LEAST_PATIENT_S`] or more. [Unit: s]
    pub waited: f64,
    /// Where it is between walls, if there are some at hand.
    pub half: Option<Half>,
}

impl<V: Space> Held<V> {
    /// Way on which it gives way, if more of those before it want to come than of those behind it want to go on. So the few
    /// retreat before the many, whole groups of them at once as all of them see the same, and those who press each other
    /// with equal force stay and slide past to the right.
    ///
    /// Between walls there is no room for that: there, those in the left half give way to those in the right half, who come
    /// on as they go back, even if they are as many; each side has a half of its own. See [`super::beside`].
    pub fn retreat(&self, flow: &Flow<V>) -> Option<V> {
        let Self { position, ahead, waited, half } = *self;
        if waited < PATIENT_S && half != Some(Half::Left) {
            return None;
        }
        let far = if half.is_some() { FAR_BETWEEN_WALLS } else { FAR };
        let at = position * flow.per_m();
        let here = flow.square(at);
        let (mut against, mut along) = (here.opposed(ahead), here.agreed(ahead));
        for k in 1..=far {
            let step = ahead * k as f32;
            against += flow.square(at + step).opposed(ahead);
            along += flow.square(at - step).agreed(ahead);
        }
        let (stronger, more) = match half {
            None => (STRONGER, MORE),
            Some(Half::Left) => (STRONGER / OWN_HALF, 0.0),
            Some(Half::Right) => (STRONGER * OWN_HALF, 2.0 * MORE),
        };
        let is_weaker = against > stronger * along + more;
        is_weaker.then(|| (ahead * -BACK + ahead.right() * RIGHT).unit_and_length().0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn held(position: Vec2, ahead: Vec2) -> Held<Vec2> {
        Held { position, ahead, waited: 1.0, half: None }
    }

    #[test]
    fn the_few_step_back_before_the_many() {
        let mut flow = Flow::new(0.3, Vec2::splat(60.0), 100);
        let side = flow.side();
        // Twelve who want to go along X stand before two who want to go the other way.
        for i in 0..12 {
            flow.add(Vec2::X * side * (0.5 - (i % 3) as f32), Vec2::ZERO, Vec2::X);
        }
        let ahead = Vec2::X * side * 1.5;
        flow.add(ahead, Vec2::ZERO, Vec2::NEG_X);
        flow.add(ahead, Vec2::ZERO, Vec2::NEG_X);
        let way = held(ahead, Vec2::NEG_X).retreat(&flow).expect("the two give way");
        assert!(way.x > 0.3 && way.dot(Vec2::NEG_X.right()) > 0.3, "{way}");
        assert_eq!(held(Vec2::X * side * 0.5, Vec2::X).retreat(&flow), None, "the twelve do not");
        assert_eq!(held(Vec2::Y * 20.0, Vec2::X).retreat(&flow), None, "nobody is there");
    }

    #[test]
    fn between_walls_those_in_the_left_half_step_back_before_as_many() {
        let mut flow = Flow::new(0.3, Vec2::splat(60.0), 100);
        for k in 1..=8 {
            for side in [-1.0f32, 1.0] {
                (0..2).for_each(|_| flow.add(Vec2::X * (side * 0.6 * k as f32), Vec2::ZERO, Vec2::X * -side));
            }
        }
        for side in [-1.0f32, 1.0] {
            let held = held(Vec2::X * (side * 0.6), Vec2::X * -side);
            let yields = |half, waited| Held { half, waited, ..held }.retreat(&flow).is_some();
            assert!(yields(Some(Half::Left), 1.0) && yields(Some(Half::Left), 0.5));
            assert!(!yields(Some(Half::Right), 1.0) && !yields(None, 1.0));
        }
    }
}
