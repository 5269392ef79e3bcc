//! Motions of eight agents at a time, bit by bit the same as those of `plan.rs` one by one.

use crate::Space;
use std::marker::PhantomData;
use std::ops::{Add, Mul, Sub};
use throng_base::simd::{LANES, Lanes};

/// Numbers of eight agents.
pub(crate) type Eight = [f32; LANES];

/// Vector of one lane.
#[inline(always)]
pub(crate) fn nth_vector<V: Space>(of: &[Eight; 3], i: usize) -> V {
    let third = if V::DIMENSIONS == 3 { of[2][i] } else { 0.0 };
    V::from_coordinates([of[0][i], of[1][i], third])
}

/// Numbers of the bits that are set.
#[inline(always)]
pub(crate) fn set_bits(mut set: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let first = set.trailing_zeros() as usize;
        set &= set.wrapping_sub(1);
        (first < LANES).then_some(first)
    })
}

/// Eight vectors. Third coordinates are 0 in 2-D, and nothing is computed with them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VectorLanes<V, F> {
    c: [F; 3],
    space: PhantomData<V>,
}

impl<V: Space, F: Lanes> VectorLanes<V, F> {
    /// Vectors of given coordinates.
    #[inline(always)]
    pub fn new(x: F, y: F, z: F) -> Self {
        Self { c: [x, y, if V::DIMENSIONS == 3 { z } else { F::splat(0.0) }], space: PhantomData }
    }

    /// Loads vectors from memory.
    #[inline(always)]
    pub fn load(of: &[Eight; 3]) -> Self {
        Self::load_each([&of[0], &of[1], &of[2]])
    }

    /// Loads each coordinate from elsewhere in memory.
    #[inline(always)]
    pub fn load_each([x, y, z]: [&Eight; 3]) -> Self {
        Self::new(F::load(x), F::load(y), F::load(z))
    }

    /// Stores vectors in memory.
    #[inline(always)]
    pub fn store(self, to: &mut [Eight; 3]) {
        for axis in 0..V::DIMENSIONS {
            self.c[axis].store(&mut to[axis]);
        }
    }

    /// Coordinates as arrays.
    #[inline(always)]
    pub fn to_arrays(self) -> [Eight; 3] {
        let mut to = [[0.0; 8]; 3];
        self.store(&mut to);
        to
    }

    /// One vector in all lanes.
    #[inline(always)]
    pub fn splat(v: V) -> Self {
        let [x, y, z] = v.coordinates();
        Self::new(F::splat(x), F::splat(y), F::splat(z))
    }

    /// Scalar products.
    #[inline(always)]
    pub fn dot(self, o: Self) -> F {
        let flat = self.c[0] * o.c[0] + self.c[1] * o.c[1];
        if V::DIMENSIONS == 3 { flat + self.c[2] * o.c[2] } else { flat }
    }

    /// Squares of the lengths.
    #[inline(always)]
    pub fn length_squared(self) -> F {
        self.dot(self)
    }

    /// Unit vectors and lengths; zero and zero where one is too short to have a direction.
    #[inline(always)]
    pub fn unit_and_length(self) -> (Self, F) {
        let (length, shortest, zero) = (self.length_squared().sqrt(), F::splat(1e-12), F::splat(0.0));
        let unit = self * (F::splat(1.0) / length);
        let none = Self::new(zero, zero, zero);
        (Self::select_lt(shortest, length, unit, none), F::select_lt(shortest, length, length, zero))
    }

    /// Selects vectors by lane, see [`Lanes::select_lt`].
    #[inline(always)]
    pub fn select_lt(a: F, b: F, yes: Self, no: Self) -> Self {
        let ([x, y, z], n) = (yes.c, no.c);
        Self::new(F::select_lt(a, b, x, n[0]), F::select_lt(a, b, y, n[1]), F::select_lt(a, b, z, n[2]))
    }
}

impl<V: Space, F: Lanes> Add for VectorLanes<V, F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.c[0] + o.c[0], self.c[1] + o.c[1], self.c[2] + o.c[2])
    }
}

impl<V: Space, F: Lanes> Sub for VectorLanes<V, F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.c[0] - o.c[0], self.c[1] - o.c[1], self.c[2] - o.c[2])
    }
}

impl<V: Space, F: Lanes> Mul<F> for VectorLanes<V, F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: F) -> Self {
        Self::new(self.c[0] * by, self.c[1] * by, self.c[2] * by)
    }
}

/// Plans of eight agents.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlanLanes<V, F> {
    pub position: VectorLanes<V, F>,
    pub velocity: VectorLanes<V, F>,
    pub acceleration: VectorLanes<V, F>,
    pub moving: F,
    pub limit: F,
}

impl<V: Space, F: Lanes> PlanLanes<V, F> {
    /// Positions and velocities, `after` seconds from the start of each.
    #[inline(always)]
    pub fn motions_after(&self, after: F) -> (VectorLanes<V, F>, VectorLanes<V, F>) {
        let dt = after.min(self.moving);
        let position = self.position + (self.velocity + self.acceleration * (F::splat(0.5) * dt)) * dt;
        let rest = VectorLanes::splat(V::default());
        (position, VectorLanes::select_lt(after, self.moving, self.velocity + self.acceleration * dt, rest))
    }

    /// Ends of the stop regions, `after` seconds from the start of each.
    #[inline(always)]
    pub fn stop_region(&self, after: F) -> Sides<V, F> {
        let (x, v) = self.motions_after(after);
        [x, x + v * (v.length_squared().sqrt() * F::splat(0.5) / self.limit)]
    }
}

/// Ends of eight stop regions.
pub(crate) type Sides<V, F> = [VectorLanes<V, F>; 2];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::plan::MotionPlan;
    use crate::steering::neighbours::tests::{NOW, crowd};
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;
    use throng_base::simd::ArrayLanes;

    fn same_as_one_by_one<V: Space>(plan: &MotionPlan<V>, after: f32) -> Result<(), TestCaseError> {
        let s = ArrayLanes::splat;
        let plans = PlanLanes {
            position: VectorLanes::splat(plan.position),
            velocity: VectorLanes::splat(plan.velocity),
            acceleration: VectorLanes::splat(plan.acceleration),
            moving: s(plan.moving),
            limit: s(plan.limit),
        };
        let first = |v: VectorLanes<V, ArrayLanes>| nth_vector::<V>(&v.to_arrays(), 5);
        let (x, v) = plans.motions_after(s(after));
        prop_assert_eq!((first(x), first(v)), plan.motion_after(after));
        let [x, y] = plans.stop_region(s(after));
        prop_assert_eq!((first(x), first(y)), plan.stop_region(after));
        let (unit, length) = v.unit_and_length();
        prop_assert_eq!((first(unit), length.to_array()[5]), plan.motion_after(after).1.unit_and_length());
        Ok(())
    }

    proptest! {
        #[test]
        fn motions_on_the_ground_are_the_same_as_one_by_one(plans in crowd::<Vec2>(), later in 0.0f64..0.6) {
            plans.iter().try_for_each(|p| same_as_one_by_one(p, (NOW - p.start + later) as f32))?;
        }

        #[test]
        fn motions_in_the_air_are_the_same_as_one_by_one(plans in crowd::<Vec3>(), later in 0.0f64..0.6) {
            plans.iter().try_for_each(|p| same_as_one_by_one(p, (NOW - p.start + later) as f32))?;
        }
    }
}
