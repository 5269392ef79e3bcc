//! The force field at one instant (001 section 2.2).

use super::beside::{between_walls, keeps_right};
use super::flow::Flow;
use super::outlook::{Lean, OPEN_S, coming, evades};
use super::sight::{Seen, Sight};
use super::solid::Solid;
use super::{Field, Forces, Interest, Space};
use crate::simd::vectorize;

/// Time for which the way has to be free to be gone with the desired speed: 1000 members in the `corridor` of the bench get on
/// with 0.95 m/s over 15 s with 0.55 s, with 0.98 m/s with 0.45 s and with 1.0 m/s with 0.4 s; with less, some block each
/// other for longer. [Unit: s]
const CLEAR_S: f32 = 0.4;
/// Share of the radii of two within which the one is in front of the other and not beside it.
const WIDE: f32 = 0.88;

/// Way to the goal from which on one leaves less and less room before those who stand. [Unit: m]
const PRESSING_M: f32 = 4.0;

/// The one whose forces are asked for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Walker<V> {
    pub position: V,
    pub velocity: V,
    pub radius: f32,
    /// Largest acceleration.
    pub limit: f32,
    /// Unit vector along the route.
    pub desired: V,
    /// Desired speed.
    pub speed: f32,
    /// Way to the goal.
    pub left: f32,
    /// It steps back, and needs no room before it to do so.
    pub retreats: bool,
    /// From the centre of its bound to where it is, x - x^ in eq. 23.
    pub off_centre: V,
}

/// What it feels.
pub(crate) struct Surroundings<'a, V> {
    pub seen: &'a [Seen<V>],
    /// All solids that stand.
    pub solids: &'a [Solid<V>],
    /// Which of them are near.
    pub near: &'a [u32],
    /// Which of them it sees beside it, as [`between_walls`] wants them.
    pub walls: &'a [u32],
    pub flow: &'a Flow<V>,
    pub interests: &'a [Interest<V>],
}

/// Sums up what moves a walker.
///
/// Differs from 001: the turning force has a part that looks ahead, toward the direction that leads on fastest (see
/// [`Sight`]), beside eq. 22, which only knows who is near; the weights of eq. 16 take the desired velocity where that
/// is larger, so that those who were stopped try on. New are the room and the time that are kept behind those who go ahead
/// (see [`pace`]), the preference for directions in which others want the same, which makes lanes (see
/// [`super::outlook`]), that everybody keeps to the right between walls (see [`super::beside`]), and that the few step back
/// before the many where nobody gets on (see [`super::retreat`]).
pub(crate) fn forces<V: Space>(me: &Walker<V>, field: &Field, around: &Surroundings<'_, V>) -> Forces<V> {
    let &Surroundings { seen, solids, near, walls, flow, interests } = around;
    let mut sight = Sight::along(me.desired, me.speed, field.horizon_s);
    vectorize(|| sight.see_all(seen, -me.radius, field.comfort_m, minded_within(field)));
    for &s in near {
        sight.see_solid(&solids[s as usize], me.position, me.radius);
    }
    let [coming, farther] = coming(flow, me.position, me.desired, me.left);
    let looks_out = coming + farther > 0.0 && !walls.is_empty();
    let between = looks_out.then(|| between_walls(solids, walls, me.position, me.desired.right())).flatten();
    let to_the_right = if me.retreats { 0.0 } else { keeps_right(coming, between) };
    let evades = if between.is_some() { 0.0 } else { evades(field, coming + farther) };
    let lean = Lean { coming, to_the_right, evades };
    let (heading, free) = sight.choose(field, me, flow, &lean);
    // Slower where the way is not free for long.
    let mut speed = me.speed * (free / CLEAR_S).min(1.0);
    let rate = field.relaxation_s.recip();
    let driving = (me.desired * me.speed - me.velocity) * rate;
    // Room before those it goes behind; none to step aside, or to get in between those who stand at their goals.
    let room_kept = if me.retreats { 0.0 } else { (me.left / PRESSING_M).min(1.0) };
    let headway = field.headway_m * room_kept * heading.dot(me.desired).max(0.0).powi(2);
    let mut f = Forces { driving, safety: me.off_centre * -field.safety, ..Forces::default() };
    for interest in interests {
        let (toward, distance) = (interest.position - me.position).unit_and_length();
        f.interaction += toward * (interest.strength * (1.0 - distance / interest.reach).max(0.0));
    }
    let mut escape = V::default();
    let far = felt_within(me, field);
    for other in seen {
        if other.distance - other.radii < far && other.distance > 0.0 {
            feel(&mut f, me, field, other);
            speed = speed.min(pace(heading, headway, field.headway_s, other));
        }
        if !other.yields {
            escape += dodge(me, field, other);
        }
    }
    for &s in near {
        let (away, distance) = solids[s as usize].away(me.position);
        if distance - me.radius < far && distance > 0.0 {
            let offset = -away * distance;
            feel(&mut f, me, field, &Seen { offset, velocity: V::default(), distance, radii: me.radius, yields: true });
        }
    }
    f.turning += (heading * speed - me.desired * me.speed) * rate;
    // Who is to be run over thinks of nothing else.
    let rest = 1.0 - (escape.length() / me.limit).min(1.0);
    f.driving = f.driving * rest;
    f.turning = f.turning * rest + escape;
    f
}

/// Gap within which others are felt, beside being seen. [Unit: m]
#[inline]
pub(crate) fn felt_within<V: Space>(me: &Walker<V>, field: &Field) -> f32 {
    let behind_one = field.headway_m + field.headway_s * me.speed;
    field.turning_m.max(field.decelerating_m).max(field.repulsion_m).max(behind_one)
}

/// Time beyond which it does not matter at all that somebody is met. [Unit: s]
#[inline]
pub(crate) fn minded_within(field: &Field) -> f32 {
    field.horizon_s.max(OPEN_S).max(CLEAR_S)
}

/// Fastest one may go along a heading behind somebody: so that there is time to do as that one does, and room left
/// where both stand. A clump keeps holes then through which others get, and those behind do not press.
#[inline]
fn pace<V: Space>(heading: V, room: f32, time: f32, other: &Seen<V>) -> f32 {
    let along = other.offset.dot(heading);
    let beside = other.distance * other.distance - along * along;
    let wide = other.radii * WIDE;
    if along <= 0.0 || beside > wide * wide {
        return f32::INFINITY;
    }
    let gap = along - (other.radii * other.radii - beside).sqrt();
    other.velocity.dot(heading).max(0.0) + ((gap - room) / time).max(0.0)
}

/// Adds what one neighbour does.
#[inline]
fn feel<V: Space>(f: &mut Forces<V>, me: &Walker<V>, field: &Field, other: &Seen<V>) {
    let gap = other.distance - other.radii;
    let toward = other.offset * other.distance.recip();
    if gap < field.repulsion_m {
        f.interaction += toward * (-field.repulsion * (1.0 - gap / field.repulsion_m));
    }
    let speed = me.velocity.dot(toward);
    if speed <= 0.0 {
        return;
    }
    if gap < field.decelerating_m {
        let push = f.driving.dot(toward).max(0.0);
        let weight = (field.braking * speed).min(1.0);
        f.decelerating += toward * (-weight * (1.0 - gap / field.decelerating_m) * push);
    }
    let relative = other.velocity - me.velocity;
    let approach = relative.dot(toward);
    if gap < field.turning_m && approach < 0.0 {
        let near = 1.0 - gap / field.turning_m;
        f.damping += toward * ((field.braking * speed).min(1.0) * field.damping * approach * near);
        // To the side that the relative motion leaves free; to the right where it leaves none.
        let across = relative - toward * approach;
        let side = across.length_squared();
        let away = if side > 1e-4 { across * -side.sqrt().recip() } else { toward.right() };
        f.turning += away * (field.avoiding * speed * field.turning * near);
    }
}

/// What it takes to get out of the way of what does not give way: the acceleration that makes the nearest approach far
/// enough.
fn dodge<V: Space>(me: &Walker<V>, field: &Field, other: &Seen<V>) -> V {
    let relative = other.velocity - me.velocity;
    let time = -other.offset.dot(relative) / relative.length_squared().max(1e-12);
    if !(0.0..2.0 * field.horizon_s).contains(&time) {
        return V::default();
    }
    let (away, miss) = (-(other.offset + relative * time)).unit_and_length();
    let away = if miss > 1e-3 { away } else { relative.unit_and_length().0.right() };
    let lack = other.radii + field.comfort_m + field.repulsion_m - miss;
    // In half the time that is left.
    away * (8.0 * lack.max(0.0) / (time * time).max(1e-3)).min(me.limit)
}
