//! The force field at one instant (001 section 2.2).

use super::sight::{Seen, Sight};
use super::solid::Solid;
use super::{Field, Forces, Space};

/// The one whose forces are asked for.
#[derive(Clone, Copy, Debug)]
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
    /// From the centre of its bound to where it is, x - x^ in eq. 23.
    pub off_centre: V,
}

/// Sums up what moves a walker.
pub(crate) fn forces<V: Space>(
    me: &Walker<V>,
    field: &Field,
    seen: &[Seen<V>],
    solids: &[Solid<V>],
    near: &[u32],
) -> Forces<V> {
    let mut sight = Sight::along(me.desired);
    let behind = -me.radius;
    for other in seen {
        if other.offset.dot(me.desired) > behind {
            sight.see(other, me.speed, field.comfort_m);
        }
    }
    for &s in near {
        sight.see_solid(&solids[s as usize], me.position, me.radius, me.speed, field.horizon_s);
    }
    let (heading, free) = sight.choose(field, me.velocity);
    // Slower where the way is not free for long.
    let speed = me.speed * (free / (2.0 * field.relaxation_s)).min(1.0);
    let rate = field.relaxation_s.recip();
    let driving = (me.desired * me.speed - me.velocity) * rate;
    let mut f = Forces { driving, turning: (heading * speed - me.desired * me.speed) * rate, ..Forces::default() };
    for other in seen {
        feel(&mut f, me, field, other);
    }
    for &s in near {
        let (away, distance) = solids[s as usize].away(me.position);
        let other = Seen { offset: -away * distance, velocity: V::default(), distance, radii: me.radius };
        feel(&mut f, me, field, &other);
    }
    f.safety = me.off_centre * -field.safety;
    f
}

/// Adds what one neighbour does.
#[inline]
fn feel<V: Space>(f: &mut Forces<V>, me: &Walker<V>, field: &Field, other: &Seen<V>) {
    let gap = other.distance - other.radii;
    let far = field.turning_m.max(field.decelerating_m).max(field.repulsion_m);
    if gap >= far || other.distance <= 0.0 {
        return;
    }
    let toward = other.offset * other.distance.recip();
    if gap < field.repulsion_m {
        f.interaction += toward * (-field.repulsion * (1.0 - gap / field.repulsion_m));
    }
    let speed = me.velocity.dot(toward);
    if speed <= 0.0 {
        return;
    }
    let braking = (field.braking * speed).min(1.0);
    if gap < field.decelerating_m {
        let push = f.driving.dot(toward).max(0.0);
        f.decelerating += toward * (-braking * (1.0 - gap / field.decelerating_m) * push);
    }
    let relative = other.velocity - me.velocity;
    let approach = relative.dot(toward).min(0.0);
    if gap < field.turning_m {
        f.damping += toward * (braking * field.damping * approach * (1.0 - gap / field.turning_m));
        if approach < 0.0 {
            // To the side that the relative motion leaves free; to the right where it leaves none.
            let across = relative - toward * approach;
            let side = across.length_squared();
            let away = if side > 1e-4 { across * (-1.0 / side.sqrt()) } else { toward.right() };
            f.turning += away * (field.avoiding * speed * field.turning * (1.0 - gap / field.turning_m));
        }
    }
}
