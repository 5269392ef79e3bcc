//! Segments, the cores of capsules, in `f64`.

use glam::DVec3;

/// A line segment; a point where both ends are the same (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// (m)
    pub a: DVec3,
    /// (m)
    pub b: DVec3,
}

impl Segment {
    /// From `a` to `b` (m).
    pub const fn new(a: DVec3, b: DVec3) -> Self {
        Self { a, b }
    }

    /// Midpoint (m).
    #[inline]
    pub fn middle(&self) -> DVec3 {
        0.5 * (self.a + self.b)
    }

    /// Half length (m).
    #[inline]
    pub fn half_length(&self) -> f64 {
        0.5 * (self.b - self.a).length()
    }

    /// The segment with both ends mapped.
    #[inline]
    pub fn map(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        Self { a: f(self.a), b: f(self.b) }
    }

    /// Interpolates both ends.
    #[inline]
    pub fn lerp(&self, to: &Self, share: f64) -> Self {
        Self { a: self.a + (to.a - self.a) * share, b: self.b + (to.b - self.b) * share }
    }

    /// Distance to another segment (m).
    ///
    /// # Source
    /// Ericson 2005, *Real-Time Collision Detection*, section 5.1.9.
    #[inline]
    pub fn distance(&self, other: &Self) -> f64 {
        self.square_distance(other).sqrt()
    }

    /// The square of [`Segment::distance`] (m^2).
    #[inline]
    pub fn square_distance(&self, other: &Self) -> f64 {
        const POINT: f64 = 1e-18;
        let (d1, d2, r) = (self.b - self.a, other.b - other.a, self.a - other.a);
        let (a, e, f) = (d1.length_squared(), d2.length_squared(), d2.dot(r));
        let c = d1.dot(r);
        let (s, t) = if a <= POINT && e <= POINT {
            (0.0, 0.0)
        } else if a <= POINT {
            (0.0, (f / e).clamp(0.0, 1.0))
        } else if e <= POINT {
            ((-c / a).clamp(0.0, 1.0), 0.0)
        } else {
            let b = d1.dot(d2);
            let across = a * e - b * b;
            // Of parallel segments, any point of one will do.
            let s = if across > 1e-12 * a * e { ((b * f - c * e) / across).clamp(0.0, 1.0) } else { 0.0 };
            let t = (b * s + f) / e;
            if t < 0.0 {
                ((-c / a).clamp(0.0, 1.0), 0.0)
            } else if t > 1.0 {
                (((b - c) / a).clamp(0.0, 1.0), 1.0)
            } else {
                (s, t)
            }
        };
        (self.a + d1 * s - other.a - d2 * t).length_squared()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    pub fn points() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(DVec3::from)
    }

    /// The least of a convex function over [0, 1].
    pub fn least(f: impl Fn(f64) -> f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..36 {
            let third = (high - low) / 3.0;
            if f(low + third) < f(high - third) { high -= third } else { low += third }
        }
        f(0.5 * (low + high))
    }

    proptest! {
        #[test]
        fn distances_are_those_of_a_search(a in points(), b in points(), c in points(), d in points(), flat in 0..4) {
            // Some of them points, some parallel.
            let b = if flat == 1 { a } else { b };
            let d = match flat { 2 => c, 3 => c + (b - a) * 0.7, _ => d };
            let (s, t) = (Segment::new(a, b), Segment::new(c, d));
            let searched = least(|u| least(|v| (a.lerp(b, u) - c.lerp(d, v)).length()));
            prop_assert!((s.distance(&t) - searched).abs() < 1e-5, "{} {searched}", s.distance(&t));
            prop_assert!((s.distance(&t) - t.distance(&s)).abs() < 1e-9);
        }
    }
}
