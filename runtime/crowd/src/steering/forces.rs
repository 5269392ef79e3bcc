//! The force field at one instant (Kim, Kim and Shin 2003b, section 2.2).

use crate::steering::far_field::{FarFieldBias, evasion_bias, oncoming};
use crate::steering::keep_right::{between_walls, right_bias};
use crate::steering::sight::{DirectionalSight, SeenNeighbour};
use crate::{ForceField, Forces, Interest, Space};
use crate::{space::solid::ConvexSolid, steering::config::SteeringConfig, steering::density_grid::DensityGrid};
use throng_base::simd::vectorize;

/// The agent that the forces act on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SteeredAgent<V> {
    pub position: V,
    pub velocity: V,
    pub radius: f32,
    /// Largest acceleration.
    pub limit: f32,
    /// Unit vector along the route.
    pub desired: V,
    /// Desired speed.
    pub speed: f32,
    /// Distance to the goal.
    pub distance_left: f32,
    /// True where it steps back, and keeps no room in front.
    pub retreats: bool,
    /// Offset from the centre of its bound to its position, x - x^ in eq. 23.
    pub off_centre: V,
}

/// Surroundings that act on an agent.
pub(crate) struct ForceSurroundings<'a, V> {
    pub seen: &'a [SeenNeighbour<V>],
    /// Static solids.
    pub solids: &'a [ConvexSolid<V>],
    /// Numbers of the near ones.
    pub near: &'a [u32],
    /// Numbers of the walls that it sees beside it, for [`between_walls`].
    pub walls: &'a [u32],
    pub grid: &'a DensityGrid<V>,
    pub interests: &'a [Interest<V>],
    pub steering: &'a SteeringConfig,
}

/// Forces on a walker.
///
/// Differs from Kim, Kim and Shin (2003b): the turning force has a part that looks ahead, toward the direction that
/// leads on fastest (see [`DirectionalSight`]), beside eq. 22, which includes near agents only; the weights of eq. 16 take the
/// desired velocity where that is larger, so that agents that were stopped try to go on. New are the distance and the
/// time that are kept behind agents in front (see [`following_speed`]), the preference for directions in which others want to go
/// too, which makes lanes (see [`crate::steering::far_field`]), that agents keep to the right between walls (see
/// [`crate::steering::keep_right`]), and that few agents step back before many in a jam (see
/// [`crate::steering::retreat`]).
pub fn sum_forces<V: Space>(me: &SteeredAgent<V>, field: &ForceField, around: &ForceSurroundings<'_, V>) -> Forces<V> {
    let &ForceSurroundings { seen, solids, near, interests, steering, .. } = around;
    let (heading, mut speed) = look_ahead(me, field, around);
    let rate = field.relaxation_s.recip();
    let driving = (me.desired * me.speed - me.velocity) * rate;
    // Room behind agents in front; none to step aside, or to get in between agents that stand at their goals.
    let room_kept = if me.retreats { 0.0 } else { (me.distance_left / steering.pressing_m).min(1.0) };
    let ahead = heading.dot(me.desired).max(0.0);
    let headway = field.headway_m * room_kept * ahead * ahead;
    let mut f = Forces { driving, safety: me.off_centre * -field.safety, ..Forces::default() };
    for interest in interests {
        let (toward, distance) = (interest.position - me.position).unit_and_length();
        f.interaction += toward * (interest.strength * (1.0 - distance / interest.reach).max(0.0));
    }
    let mut escape = V::default();
    let far = felt_within(me, field);
    for other in seen {
        if other.distance - other.radii < far && other.distance > 0.0 {
            add_neighbour_forces(&mut f, me, field, other);
            speed = speed.min(following_speed(heading, headway, field.headway_s, steering.front_width, other));
        }
        if !other.yields {
            escape += dodge_mover(me, field, other);
        }
    }
    for &s in near {
        let (away, distance) = solids[s as usize].direction_and_distance(me.position);
        if distance - me.radius < far && distance > 0.0 {
            let offset = -away * distance;
            let wall = SeenNeighbour { offset, velocity: V::default(), distance, radii: me.radius, yields: true };
            add_neighbour_forces(&mut f, me, field, &wall);
        }
    }
    f.turning += (heading * speed - me.desired * me.speed) * rate;
    // An agent about to be run over does nothing but escape.
    let rest = 1.0 - (escape.length() / me.limit).min(1.0);
    f.driving = f.driving * rest;
    f.turning = f.turning * rest + escape;
    f
}

/// Direction that leads on fastest, and the speed that it allows without regard to who is in front (m/s).
#[inline]
fn look_ahead<V: Space>(me: &SteeredAgent<V>, field: &ForceField, around: &ForceSurroundings<'_, V>) -> (V, f32) {
    let &ForceSurroundings { seen, solids, near, walls, grid, steering, .. } = around;
    let mut sight = DirectionalSight::looking_along(me.desired, me.speed, field.horizon_s, steering);
    vectorize(|| sight.see_all(seen, -me.radius, field.comfort_m, contact_horizon(field, steering)));
    for &s in near {
        sight.see_solid(&solids[s as usize], me.position, me.radius);
    }
    let [coming, farther] = oncoming(grid, me.position, me.desired, me.distance_left, steering);
    let looks_out = coming + farther > 0.0 && !walls.is_empty();
    let between = looks_out.then(|| between_walls(solids, walls, me, steering)).flatten();
    let to_the_right = if me.retreats { 0.0 } else { right_bias(coming, between, steering) };
    let evades = if between.is_some() { 0.0 } else { evasion_bias(field, coming + farther, steering) };
    let lean = FarFieldBias { coming, to_the_right, evades };
    let (heading, free) = sight.choose_direction(field, me, grid, &lean);
    // Slower where the way is not free for long.
    let mut speed = me.speed * (free / steering.clear_s).min(1.0);
    if field.crowd_speed > 0.0 {
        let density = grid.density(me.position, heading, &steering.density_places);
        speed = speed.min(me.speed * field.crowd_speed * share_of_speed(density));
    }
    (heading, speed)
}

/// Velocity at which somebody should go on: along the direction that leads on fastest, as fast as those in front allow.
pub fn desired_velocity<V: Space>(me: &SteeredAgent<V>, field: &ForceField, around: &ForceSurroundings<'_, V>) -> V {
    let (heading, mut speed) = look_ahead(me, field, around);
    let ahead = heading.dot(me.desired).max(0.0);
    let (room_m, width) = (field.headway_m * ahead * ahead, around.steering.front_width);
    for other in around.seen {
        speed = speed.min(following_speed(heading, room_m, field.headway_s, width, other));
    }
    heading * speed
}

/// Gap within which others exert forces, beside being seen (m).
#[inline]
pub(crate) fn felt_within<V: Space>(me: &SteeredAgent<V>, field: &ForceField) -> f32 {
    let behind_one = field.headway_m + field.headway_s * me.speed;
    field.turning_m.max(field.decelerating_m).max(field.repulsion_m).max(behind_one)
}

/// Time beyond which a contact does not matter (s).
#[inline]
pub(crate) fn contact_horizon(field: &ForceField, steering: &SteeringConfig) -> f32 {
    field.horizon_s.max(steering.open_s).max(steering.clear_s)
}

/// Share of their free speed that people keep at a density (1/m2): Weidmann (1993), Transporttechnik der Fussgaenger, eq. 6, by
/// lines between values at each half person.
fn share_of_speed(density: f32) -> f32 {
    const SHARES: [f32; 12] = [1.0, 0.97, 0.79, 0.60, 0.45, 0.337, 0.246, 0.176, 0.116, 0.069, 0.031, 0.02];
    let at = (2.0 * density).min(10.999);
    let (low, share) = (at as usize, at.fract());
    SHARES[low] + (SHARES[low + 1] - SHARES[low]) * share
}

/// Largest speed along a heading behind another agent: with time to brake when that one does, and a distance left when both
/// stand. So a dense group keeps gaps for others to pass, and those behind do not press.
#[inline]
fn following_speed<V: Space>(heading: V, room: f32, time: f32, front_width: f32, other: &SeenNeighbour<V>) -> f32 {
    let along = other.offset.dot(heading);
    let beside = other.distance * other.distance - along * along;
    let wide = other.radii * front_width;
    if along <= 0.0 || beside > wide * wide {
        return f32::INFINITY;
    }
    let gap = along - (other.radii * other.radii - beside).sqrt();
    other.velocity.dot(heading).max(0.0) + ((gap - room) / time).max(0.0)
}

/// Adds the forces of one neighbour.
#[inline]
fn add_neighbour_forces<V: Space>(
    f: &mut Forces<V>,
    me: &SteeredAgent<V>,
    field: &ForceField,
    other: &SeenNeighbour<V>,
) {
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

/// Acceleration that escapes a moving obstacle: it makes the nearest approach far enough.
fn dodge_mover<V: Space>(me: &SteeredAgent<V>, field: &ForceField, other: &SeenNeighbour<V>) -> V {
    let relative = other.velocity - me.velocity;
    let time = -other.offset.dot(relative) / relative.length_squared().max(1e-12);
    if !(0.0..2.0 * field.horizon_s).contains(&time) {
        return V::default();
    }
    let (away, miss) = (-(other.offset + relative * time)).unit_and_length();
    let away = if miss > 1e-3 { away } else { relative.unit_and_length().0.right() };
    let missing = other.radii + field.comfort_m + field.repulsion_m - miss;
    // In half of the time that is left.
    away * (8.0 * missing.max(0.0) / (time * time).max(1e-3)).min(me.limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn walker() -> SteeredAgent<Vec2> {
        SteeredAgent {
            radius: 0.3,
            limit: 5.0,
            desired: Vec2::X,
            speed: 1.3,
            distance_left: 100.0,
            ..SteeredAgent::default()
        }
    }

    fn surroundings<'a>(grid: &'a DensityGrid<Vec2>, interests: &'a [Interest<Vec2>]) -> ForceSurroundings<'a, Vec2> {
        let steering = &SteeringConfig::DEFAULT;
        ForceSurroundings { seen: &[], solids: &[], near: &[], walls: &[], grid, interests, steering }
    }

    #[test]
    fn the_table_of_speeds_by_density_is_the_diagram_between_its_values_too() {
        for k in 10..=100 {
            let density = 0.05 * k as f32;
            let diagram = 1.0 - (-1.913 * (density.recip() - 5.4f32.recip())).exp();
            let off = share_of_speed(density) - diagram;
            assert!(off.abs() < 0.015, "{density}: off by {off}");
            assert!(share_of_speed(density) < share_of_speed(density - 0.01), "{density}: the more, the slower");
        }
        assert_eq!(share_of_speed(0.0), 1.0);
        assert!((share_of_speed(0.75) - 0.5 * (share_of_speed(0.5) + share_of_speed(1.0))).abs() < 1e-6);
        assert_eq!(share_of_speed(9.0), share_of_speed(100.0));
    }

    #[test]
    fn a_walker_slows_down_where_many_are_and_one_in_a_hurry_does_not() {
        let mut grid = DensityGrid::new(1.0, Vec2::splat(20.0), 100);
        let me = SteeredAgent { position: Vec2::splat(0.5), ..walker() };
        let speed = |grid: &DensityGrid<Vec2>, crowd_speed: f32| {
            let field = ForceField { crowd_speed, ..ForceField::default() };
            desired_velocity(&me, &field, &surroundings(grid, &[])).length()
        };
        assert!((speed(&grid, 1.0) - 1.3).abs() < 1e-5, "nobody is there");
        // Two on each of the squares ahead, which go its way as fast as it does: nothing else slows it.
        for k in 1..=3 {
            (0..2).for_each(|_| grid.add(Vec2::new(k as f32 + 0.5, 0.5), Vec2::X * 1.3, Vec2::X));
        }
        assert!((speed(&grid, 0.0) - 1.3).abs() < 1e-5, "in a hurry");
        assert!((speed(&grid, 1.0) - 1.3 * 0.45).abs() < 1e-4, "{}", speed(&grid, 1.0));
        assert!((speed(&grid, 0.8) - 0.8 * 1.3 * 0.45).abs() < 1e-4, "{}", speed(&grid, 0.8));
    }

    #[test]
    fn the_pull_of_an_interest_fades_to_nothing_at_its_reach() {
        let grid = DensityGrid::new(1.0, Vec2::splat(20.0), 10);
        for (distance, pull) in [(0.5, 1.75), (2.0, 1.0), (3.0, 0.5), (4.0, 0.0), (6.0, 0.0)] {
            let interest = Interest { position: Vec2::new(0.0, distance), strength: 2.0, reach: 4.0 };
            let forces = sum_forces(&walker(), &ForceField::default(), &surroundings(&grid, &[interest]));
            let off = forces.interaction.distance(Vec2::new(0.0, pull));
            assert!(off < 1e-5, "at {distance} m: {}", forces.interaction);
        }
    }
}
