//! Who steps back where two crowds press against each other and nobody gets on.

use super::Space;
use super::flow::Flow;

// Other numbers were tried in corridors 2.4 m and 4 m wide in which 8 or 20 members meet 30, some seeds each, and in the
// tests of jams. Of those in the narrow corridor with 8, more than a third are there after a minute if nobody steps back,
// and a few in a hundred or fewer with these numbers. With 20 against 30 nobody gets through that corridor either way.

/// Time without getting on after which a member may step back: about what it takes to go round somebody. 0.3 s and 2 s
/// make no difference beyond that of seeds. [Unit: s]
pub(crate) const PATIENT_S: f64 = 0.7;
/// How far it looks for those who press it and for those who back it, in squares of the flow's grid. With 1 it knows too
/// little, and hardly anything is gained; with 6 corridors get free sooner, but a dense packing of two crowds does not.
const FAR: usize = 3;
/// How many times as many as those who go its way, and how many more, have to be against it: so many that the two sides
/// hardly ever both find themselves the weaker one. With 8 more, the few more often stand where they should step back;
/// with none more, wide corridors with 8 take a fifth longer.
const STRONGER: f32 = 1.3;
const MORE: f32 = 3.0;
/// Backward and rightward parts of the way of who steps back: more to the right, where the others keep to their own right
/// too and leave room. Straight back, wide corridors with 8 take a third longer.
const BACK: f32 = 0.57;
const RIGHT: f32 = 0.8;
/// Share of its desired speed with which it does so. Half of it, or all, make no difference beyond that of seeds.
pub(crate) const SLOWLY: f32 = 0.84;

/// Way of a member that goes along a unit vector, does not get on, and is to give way, as more of those before it want
/// to come than of those behind it want to go on. So the few retreat before the many, whole groups of them at once as
/// all of them see the same, and those who press each other with equal force stay and slide past to the right.
pub(crate) fn retreat<V: Space>(flow: &Flow<V>, position: V, ahead: V) -> Option<V> {
    let at = position * flow.per_m();
    let here = flow.square(at);
    let (mut against, mut along) = (here.opposed(ahead), here.agreed(ahead));
    for k in 1..=FAR {
        let step = ahead * k as f32;
        against += flow.square(at + step).opposed(ahead);
        along += flow.square(at - step).agreed(ahead);
    }
    let is_weaker = against > STRONGER * along + MORE;
    is_weaker.then(|| (ahead * -BACK + ahead.right() * RIGHT).unit_and_length().0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

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
        let way = retreat(&flow, ahead, Vec2::NEG_X).expect("the two give way");
        assert!(way.x > 0.3 && way.dot(Vec2::NEG_X.right()) > 0.3, "{way}");
        assert_eq!(retreat(&flow, Vec2::X * side * 0.5, Vec2::X), None, "the twelve do not");
        assert_eq!(retreat(&flow, Vec2::Y * 20.0, Vec2::X), None, "nobody is there");
    }
}
