//! Vectors and quaternions of eight characters.

use super::Lanes;
use glam::{Quat, Vec3};
use std::ops::{Add, Mul, Sub};

/// Vectors of three coordinates, one per lane.
#[derive(Clone, Copy, Debug)]
pub struct V<F> {
    /// First coordinates.
    pub x: F,
    /// Second coordinates.
    pub y: F,
    /// Third coordinates.
    pub z: F,
}

impl<F: Lanes> V<F> {
    /// Vectors with given coordinates.
    #[inline(always)]
    pub fn new(x: F, y: F, z: F) -> Self {
        Self { x, y, z }
    }

    /// Vectors that are equal in all lanes.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self::new(F::splat(v.x), F::splat(v.y), F::splat(v.z))
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> F {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Cross product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self::new(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }

    /// Euclidean length.
    #[inline(always)]
    pub fn length(self) -> F {
        self.dot(self).sqrt()
    }

    /// Linear interpolation from this vector to another.
    #[inline(always)]
    pub fn mix(self, other: Self, share: F) -> Self {
        self * (F::splat(1.0) - share) + other * share
    }

    /// The vector of one lane.
    pub fn lane(self, lane: usize) -> Vec3 {
        Vec3::from_array([self.x, self.y, self.z].map(|axis| axis.to_array()[lane]))
    }

    /// Replaces the vector of one lane.
    pub fn set_lane(&mut self, lane: usize, to: Vec3) {
        for (axis, value) in [&mut self.x, &mut self.y, &mut self.z].into_iter().zip(to.to_array()) {
            *axis = with_lane(*axis, lane, value);
        }
    }

    /// `yes` in the lanes where `a < b`, `no` in the others.
    #[inline(always)]
    pub fn select_lt(a: F, b: F, yes: Self, no: Self) -> Self {
        Self::new(F::select_lt(a, b, yes.x, no.x), F::select_lt(a, b, yes.y, no.y), F::select_lt(a, b, yes.z, no.z))
    }
}

fn with_lane<F: Lanes>(of: F, lane: usize, to: f32) -> F {
    let mut all = of.to_array();
    all[lane] = to;
    F::from_array(all)
}

impl<F: Lanes> Add for V<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl<F: Lanes> Sub for V<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl<F: Lanes> Mul<F> for V<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: F) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}

/// Quaternions (v, w), one per lane.
#[derive(Clone, Copy, Debug)]
pub struct Q<F> {
    /// Vector part.
    pub v: V<F>,
    /// Scalar part.
    pub w: F,
}

impl<F: Lanes> Q<F> {
    /// Quaternions with given vector and scalar parts.
    #[inline(always)]
    pub fn new(v: V<F>, w: F) -> Self {
        Self { v, w }
    }

    /// The quaternion of one lane.
    pub fn lane(self, lane: usize) -> Quat {
        Quat::from_vec4(self.v.lane(lane).extend(self.w.to_array()[lane]))
    }

    /// Replaces the quaternion of one lane.
    pub fn set_lane(&mut self, lane: usize, to: Quat) {
        self.v.set_lane(lane, to.xyz());
        self.w = with_lane(self.w, lane, to.w);
    }

    /// Scaled to length 1; not finite where it is 0.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        let s = F::splat(1.0) / (self.v.dot(self.v) + self.w * self.w).sqrt();
        Self::new(self.v * s, self.w * s)
    }

    /// Inverse rotation of a unit quaternion.
    #[inline(always)]
    pub fn conjugate(self) -> Self {
        Self::new(V::new(-self.v.x, -self.v.y, -self.v.z), self.w)
    }

    /// Vector rotated by this unit quaternion.
    #[inline(always)]
    pub fn rotate(self, p: V<F>) -> V<F> {
        let t = self.v.cross(p);
        let t = t + t;
        p + t * self.w + self.v.cross(t)
    }

    /// The shortest rotation that takes the direction of `a` to that of `b`; none where one is 0 long or they are opposite.
    #[inline(always)]
    pub fn shortest_arc(a: V<F>, b: V<F>) -> Self {
        let k = (a.dot(a) * b.dot(b)).sqrt();
        // The square of what is put in place of 0 is a normal number.
        Self::new(a.cross(b), (k + a.dot(b)).max(F::splat(1e-18))).normalize()
    }

    /// Modified Rodrigues parameters: axis * tan(angle / 4), the shorter way round.
    #[inline(always)]
    pub fn to_mrp(self) -> V<F> {
        let zero = F::splat(0.0);
        let sign = F::select_lt(self.w, zero, F::splat(-1.0), F::splat(1.0));
        self.v * (sign / (F::splat(1.0) + self.w.abs()))
    }

    /// The unit quaternion of modified Rodrigues parameters.
    #[inline(always)]
    pub fn from_mrp(m: V<F>) -> Self {
        let m2 = m.dot(m);
        let one = F::splat(1.0);
        let s = one / (one + m2);
        Self::new(m * (s + s), (one - m2) * s)
    }

    /// The first three columns of its matrix, as rows: `[[xx, xy, xz], ...]` with row i the i-th output coordinate.
    #[inline(always)]
    pub fn matrix(self) -> [[F; 3]; 3] {
        let (x, y, z, w) = (self.v.x, self.v.y, self.v.z, self.w);
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        let one = F::splat(1.0);
        [[one - yy - zz, xy - wz, xz + wy], [xy + wz, one - xx - zz, yz - wx], [xz - wy, yz + wx, one - xx - yy]]
    }
}

impl<F: Lanes> Mul for Q<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self::new(self.v.cross(o.v) + self.v * o.w + o.v * self.w, self.w * o.w - self.v.dot(o.v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::ArrayLanes;
    use glam::Quat;
    use proptest::prelude::*;

    fn lanes(q: Quat) -> Q<ArrayLanes> {
        Q::new(V::splat(q.xyz()), ArrayLanes::splat(q.w))
    }

    fn first(q: Q<ArrayLanes>) -> Quat {
        Quat::from_xyzw(q.v.x.to_array()[0], q.v.y.to_array()[0], q.v.z.to_array()[0], q.w.to_array()[0])
    }

    fn unit() -> impl Strategy<Value = Quat> {
        prop::array::uniform4(-1.0f32..1.0).prop_filter_map("too short", |a| {
            let q = Quat::from_array(a);
            (q.length() > 0.1).then(|| q.normalize())
        })
    }

    proptest! {
        #[test]
        fn agrees_with_glam(a in unit(), b in unit(), p in prop::array::uniform3(-2.0f32..2.0)) {
            let p = Vec3::from_array(p);
            prop_assert!(first(lanes(a) * lanes(b)).abs_diff_eq(a * b, 1e-5));
            let r = lanes(a).rotate(V::splat(p));
            prop_assert!(Vec3::new(r.x.to_array()[0], r.y.to_array()[1], r.z.to_array()[2]).abs_diff_eq(a * p, 1e-5));
            let m = lanes(a).matrix();
            let want = glam::Mat3::from_quat(a);
            for i in 0..3 { for j in 0..3 { prop_assert!((m[i][j].to_array()[3] - want.col(j)[i]).abs() < 1e-5); } }
        }

        #[test]
        fn rodrigues_parameters_round_trip(a in unit()) {
            let back = first(Q::from_mrp(lanes(a).to_mrp()));
            prop_assert!(back.dot(a).abs() > 1.0 - 1e-5);
            let m = lanes(a).to_mrp();
            prop_assert!(m.length().to_array()[0] <= 1.0 + 1e-5);
        }

        #[test]
        fn between_takes_one_direction_to_the_other(a in unit(), b in unit()) {
            let (u, v) = (a * Vec3::X * 2.0, b * Vec3::Y * 0.5);
            prop_assume!(u.dot(v) > -0.98);
            let q = first(Q::shortest_arc(V::splat(u), V::splat(v)));
            prop_assert!((q * u.normalize()).abs_diff_eq(v.normalize(), 1e-4));
        }
    }

    #[test]
    fn nothing_turns_between_directions_of_which_one_is_none() {
        for (a, b) in [(Vec3::ZERO, Vec3::X), (Vec3::X, Vec3::ZERO), (Vec3::ZERO, Vec3::ZERO), (Vec3::X, Vec3::NEG_X)] {
            assert_eq!(first(Q::shortest_arc(V::splat(a), V::splat(b))), Quat::IDENTITY, "{a} {b}");
        }
    }
}
