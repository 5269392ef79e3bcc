//! Time-varying bounds: the region that an agent can reach by any motion (Kim, Kim and Shin 2003a, eq. 3 and 4, Kim,
//! Kim and Shin (2003b), eq. 3 and 4).

use crate::{Space, space::plan::MotionPlan, space::solid::ConvexSolid};
use throng_base::simd::Lanes;

/// Rounds of refinement of a first contact; each comes nearer to it from before.
const ROUNDS: usize = 3;
/// A gap that counts as a contact (m).
const TOUCH: f32 = 1e-3;

/// Share of the side of a cell that a bound in lists may be wide: a little less than all, so that it is never in three
/// cells of a row.
pub(crate) const WIDEST: f32 = 0.998;

/// Side of the smallest cells in which a bound may grow for some time without being wider than one.
pub(crate) fn narrowest_cell(radius: f32, limit: f32, seconds: f32) -> f32 {
    2.002 * (radius + 0.5 * limit * seconds * seconds) / WIDEST
}

/// Disc or ball that moves with the velocity of its agent at the last event, and grows so that it holds the agent for
/// any motion within its largest acceleration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound<V> {
    /// Time at which it was made (s).
    pub start: f64,
    /// Centre then (m).
    pub position: V,
    /// (m/s)
    pub velocity: V,
    /// Radius then (m).
    pub radius: f32,
    /// Largest acceleration (m/s2).
    pub limit: f32,
}

impl<V: Space> From<&MotionPlan<V>> for Bound<V> {
    #[inline]
    fn from(p: &MotionPlan<V>) -> Self {
        Self { start: p.start, position: p.position, velocity: p.velocity, radius: p.radius, limit: p.limit }
    }
}

impl<V: Space> Bound<V> {
    /// The bound of an agent that follows a plan, made at a time of it.
    #[inline]
    pub fn new(plan: &MotionPlan<V>, time: f64) -> Self {
        let (position, velocity) = plan.motion_at(time);
        Self { start: time, position, velocity, ..Self::from(plan) }
    }

    /// Centre and radius (time >= start).
    #[inline]
    pub fn disc_at(&self, time: f64) -> (V, f32) {
        let dt = (time - self.start) as f32;
        (self.position + self.velocity * dt, self.radius + 0.5 * self.limit * dt * dt)
    }

    /// Time of the first contact of two bounds, never late; `time` itself where they touch already. At most `within`
    /// seconds are looked ahead: later contacts give a time from then on.
    ///
    /// The distance of two centres that move straight is a convex function of time, so that its tangent is never above
    /// it; less the radii, whose growth is known exactly, that leaves a quadratic whose root cannot be late. From there
    /// the next tangent is taken.
    #[inline]
    pub fn first_contact(&self, other: &Self, time: f64, within: f32) -> f32 {
        let (age, other_age) = ((time - self.start) as f32, (time - other.start) as f32);
        let velocity = self.velocity - other.velocity;
        let apart = (self.position + self.velocity * age) - (other.position + other.velocity * other_age);
        let growth = self.limit + other.limit;
        let rate = self.limit * age + other.limit * other_age;
        let radii = self.radius + other.radius + 0.5 * (self.limit * age * age + other.limit * other_age * other_age);
        first_approach(apart, velocity, radii, rate, growth, within)
    }

    /// First contact of two bounds that are both made now, see [`Bound::first_contact`]: the other one is `offset`
    /// away, has a velocity and, together with this one, radii and growth.
    #[inline]
    pub fn first_meeting(&self, offset: V, velocity: V, radii: f32, growth: f32, within: f32) -> f32 {
        first_approach(offset, velocity - self.velocity, radii, 0.0, growth, within)
    }

    /// Time at which a bound touches a static solid, see [`Bound::first_contact`].
    pub fn first_contact_with(&self, solid: &ConvexSolid<V>, time: f64, within: f32) -> f32 {
        let age = (time - self.start) as f32;
        let centre = self.position + self.velocity * age;
        first_zero(within, self.limit, |dt| {
            let (away, distance) = solid.direction_and_distance(centre + self.velocity * dt);
            let grown = age + dt;
            let radius = self.radius + 0.5 * self.limit * grown * grown;
            (distance - radius, away.dot(self.velocity) - self.limit * grown)
        })
    }

    /// Time at which a bound made at `start` leaves a box along the axes: exact, from [`Bound::start`] on.
    #[inline]
    pub fn first_exit(&self, min: V, max: V) -> f32 {
        let (x, v) = (self.position.coordinates(), self.velocity.coordinates());
        let (min, max) = (min.coordinates(), max.coordinates());
        let mut first = f32::INFINITY;
        for axis in 0..V::DIMENSIONS {
            let low = x[axis] - self.radius - min[axis];
            let high = max[axis] - x[axis] - self.radius;
            first =
                first.min(time_until_gone(low, v[axis], self.limit)).min(time_until_gone(high, -v[axis], self.limit));
        }
        first
    }
}

/// First contact of two bounds that are apart, and move straight relative to each other; the sum of their radii grows at
/// a rate, and that by `growth`.
#[inline]
fn first_approach<V: Space>(apart: V, velocity: V, radii: f32, rate: f32, growth: f32, within: f32) -> f32 {
    first_zero(within, growth, |dt| {
        let (toward, distance) = (apart + velocity * dt).unit_and_length();
        let radius = radii + (rate + 0.5 * growth * dt) * dt;
        (distance - radius, toward.dot(velocity) - rate - growth * dt)
    })
}

/// Time until a gap that changes at `rate`, less and less by `growth`, is gone.
#[inline]
pub(crate) fn time_until_gone(gap: f32, rate: f32, growth: f32) -> f32 {
    if gap <= 0.0 {
        return 0.0;
    }
    let root = (rate * rate + 2.0 * growth * gap).sqrt();
    // Either form is exact; each loses digits where the other does not.
    if rate <= 0.0 {
        if root > rate { 2.0 * gap / (root - rate) } else { f32::INFINITY }
    } else if growth > 0.0 {
        (rate + root) / growth
    } else {
        f32::INFINITY
    }
}

/// Result of [`time_until_gone`] for eight, up to rounding (growth > 0).
#[inline(always)]
pub(crate) fn time_until_gone_lanes<F: Lanes>(gap: F, rate: F, growth: F) -> F {
    let zero = F::splat(0.0);
    let gap = gap.max(zero);
    let root = (rate * rate + F::splat(2.0) * growth * gap).sqrt();
    let above = F::select_lt(zero, rate, rate + root, F::splat(2.0) * gap);
    above / F::select_lt(zero, rate, growth, (root - rate).max(F::splat(f32::MIN_POSITIVE)))
}

/// Follows tangents of a gap to its first zero. `gap` gives the gap and the rate at which its tangent changes now.
#[inline]
fn first_zero(within: f32, growth: f32, gap: impl Fn(f32) -> (f32, f32)) -> f32 {
    let mut dt = 0.0;
    for _ in 0..ROUNDS {
        let (left, rate) = gap(dt);
        // A little short, for what rounding may have added.
        dt += 0.999 * time_until_gone(left, rate, growth);
        if left < TOUCH || dt >= within {
            break;
        }
    }
    dt
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    fn bound<V: Space>() -> impl Strategy<Value = Bound<V>> {
        let coordinate = || prop_oneof![Just(0.0f32), Just(1.0), -4.0f32..4.0];
        let vector = move || [coordinate(), coordinate(), coordinate()];
        let scaled = |range: std::ops::Range<f32>| prop_oneof![Just(range.start), range];
        (0.0f64..0.3, vector(), vector(), scaled(0.1..1.0), scaled(0.5..8.0)).prop_map(
            |(start, x, v, radius, limit)| {
                let (position, velocity) = (V::from_coordinates(x), V::from_coordinates(v) * 0.5);
                Bound { start: 1000.0 - start, position, velocity, radius, limit }
            },
        )
    }

    /// Samples every millisecond: there is a gap before the contact that was found.
    fn is_never_late<V: Space>(a: &Bound<V>, b: &Bound<V>) -> Result<(), TestCaseError> {
        let dt = a.first_contact(b, 1000.0, 5.0);
        prop_assert!(dt >= 0.0);
        for i in 0..(dt.min(5.0) * 1000.0) as usize {
            let t = 1000.0 + i as f64 * 1e-3;
            let ((p, r), (q, s)) = (a.disc_at(t), b.disc_at(t));
            let gap = (p - q).length() - r - s;
            prop_assert!(gap > -1e-4, "gap {gap} m at {t}, contact found after {dt} s");
        }
        let (p, r) = a.disc_at(1000.0);
        let (q, s) = b.disc_at(1000.0);
        if (p - q).length() > r + s + 0.01 {
            prop_assert!(dt > 0.0, "no contact yet, but one was found at once");
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn contact_of_discs_is_never_late(a in bound::<Vec2>(), b in bound::<Vec2>()) {
            is_never_late(&a, &b)?;
        }

        #[test]
        fn contact_of_balls_is_never_late(a in bound::<Vec3>(), b in bound::<Vec3>()) {
            is_never_late(&a, &b)?;
        }

        #[test]
        fn contact_with_solids_is_never_late(
            a in bound::<Vec2>(), from in [-5.0f32..5.0, -5.0f32..5.0], to in [-5.0f32..5.0, -5.0f32..5.0], kind in 0..3,
        ) {
            let (from, to) = (Vec2::from_array(from), Vec2::from_array(to));
            let solid = match kind {
                0 => ConvexSolid::Ball { centre: from, radius: 0.4 },
                1 => ConvexSolid::Capsule { from, to, radius: 0.1 },
                _ => ConvexSolid::Box { min: from.min(to), max: from.max(to) },
            };
            let dt = a.first_contact_with(&solid, 1000.0, 5.0);
            for i in 0..(dt.min(5.0) * 1000.0) as usize {
                let t = 1000.0 + i as f64 * 1e-3;
                let (p, r) = a.disc_at(t);
                prop_assert!(solid.direction_and_distance(p).1 - r > -1e-4, "inside at {t}, contact found after {dt} s");
            }
        }

        #[test]
        fn exit_is_when_a_side_is_touched(a in bound::<Vec2>()) {
            let (min, max) = (Vec2::splat(-6.0), Vec2::splat(6.0));
            let dt = a.first_exit(min, max);
            let (p, r) = a.disc_at(a.start + f64::from(dt));
            let gap = (p - min).min(max - p).min_element() - r;
            prop_assert!(gap.abs() < 1e-3, "gap {gap}");
        }
    }

    #[test]
    fn contact_is_found_nearly_exactly_where_two_meet_head_on() {
        let a = Bound { start: 0.0, position: Vec2::ZERO, velocity: Vec2::X, radius: 0.3, limit: 5.0 };
        let b = Bound { position: Vec2::X * 3.0, velocity: -Vec2::X, ..a };
        // 2.4 = 2 t + 5 t^2
        let exact = (-2.0 + (4.0f32 + 48.0).sqrt()) / 10.0;
        let got = a.first_contact(&b, 0.0, 9.0);
        assert!(got <= exact && got > exact - 2e-3, "{got} {exact}");
    }
}
