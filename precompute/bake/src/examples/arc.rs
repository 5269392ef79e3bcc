//! Circular arc of least squares through a path on the ground (Kim, Kim and Shin 2003a, section 4.1).

use super::dense::Lu;
use glam::DVec2;

/// Most steps of the least-squares search; fewer than ten suffice for points near an arc.
const MOST_STEPS: usize = 100;

/// A circular arc or straight line, traversed at constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Reciprocal of the radius, positive if the path turns left (its heading grows); 0 for a straight line (1/m).
    pub curvature: f64,
    /// Length between the feet of the first and the last point (m).
    pub length: f64,
    /// Heading of the tangent at the foot of the first point (rad).
    pub heading: f64,
    /// Root mean square distance of the points from it (m).
    pub rms: f64,
}

impl Arc {
    /// Subtended angle, positive to the left (rad).
    pub fn angle(&self) -> f64 {
        self.curvature * self.length
    }

    /// Arc with the smallest sum of squared distances from the points of a path (Kim, Kim and Shin 2003a, section 4.1).
    ///
    /// - `path`: points (x, z) in order, no two neighbours more than half a turn of the arc apart (m).
    /// - returns `None` for fewer than three points, or if all lie within a millimetre.
    pub fn fit(path: &[DVec2]) -> Option<Self> {
        let n = path.len() as f64;
        let mean = path.iter().sum::<DVec2>() / n;
        let size = (path.iter().map(|p| (*p - mean).length_squared()).sum::<f64>() / n).sqrt();
        if path.len() < 3 || size < 1e-3 {
            return None;
        }
        let points: Vec<DVec2> = path.iter().map(|p| (*p - mean) / size).collect();
        let starts = [Some(Circle::line(&points)), Circle::algebraic(&points)];
        let fits = starts.into_iter().flatten().map(|c| c.minimise(&points));
        let (circle, sum) = fits.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(circle.arc(&points, size, (sum / n).sqrt() * size))
    }
}

/// A circle or line: the points of `a (x^2 + z^2) + e cos(angle) x + e sin(angle) z + d = 0`, `e^2 = 1 + 4 a d`, so
/// that a line has a = 0 and no parameter grows without bound (Chernov and Lesort 2005, *Least Squares Fitting of
/// Circles*).
#[derive(Clone, Copy, Debug)]
struct Circle {
    a: f64,
    d: f64,
    angle: f64,
}

impl Circle {
    /// Line through the points' mean, which is the origin, with the smallest sum of squared distances.
    fn line(points: &[DVec2]) -> Self {
        let sum = |f: fn(&DVec2) -> f64| points.iter().map(f).sum::<f64>();
        let (xx, xz, zz) = (sum(|p| p.x * p.x), sum(|p| p.x * p.y), sum(|p| p.y * p.y));
        let along = 0.5 * (2.0 * xz).atan2(xx - zz);
        Self { a: 0.0, d: 0.0, angle: along + std::f64::consts::FRAC_PI_2 }
    }

    /// Circle with the smallest sum of squares of `x^2 + z^2 - 2 c p - k`, a linear system; `None` for a line.
    fn algebraic(points: &[DVec2]) -> Option<Self> {
        let (mut m, mut b) = ([0.0; 9], [0.0; 3]);
        for p in points {
            let row = [p.x, p.y, 1.0];
            for r in 0..3 {
                (0..3).for_each(|c| m[r * 3 + c] += row[r] * row[c]);
                b[r] += row[r] * p.length_squared();
            }
        }
        let x = Lu::new(3, &m, 1e-9)?.solve(&b);
        let (centre, k) = (DVec2::new(0.5 * x[0], 0.5 * x[1]), x[2]);
        let radius = (centre.length_squared() + k).max(0.0).sqrt();
        let a = 0.5 / radius;
        let d = (radius < 1e6 && radius > 1e-6).then_some(a * (centre.length_squared() - radius * radius))?;
        Some(Self { a, d, angle: (-centre.y).atan2(-centre.x) })
    }

    /// Signed distance of a point and its derivatives by a, d and angle; `None` if the parameters are no circle.
    fn distance(&self, p: DVec2) -> Option<(f64, [f64; 3])> {
        let e2 = 1.0 + 4.0 * self.a * self.d;
        if e2.is_nan() || e2 <= 1e-12 {
            return None;
        }
        let (e, (sin, cos)) = (e2.sqrt(), self.angle.sin_cos());
        let (across, r2) = (cos * p.x + sin * p.y, p.length_squared());
        let f = self.a * r2 + e * across + self.d;
        let root = (1.0 + 4.0 * self.a * f).max(0.0).sqrt();
        let q = 1.0 + root;
        let of_f = [r2 + 2.0 * self.d / e * across, 1.0 + 2.0 * self.a / e * across, e * (cos * p.y - sin * p.x)];
        let of_a = [f, 0.0, 0.0];
        let slope = |k: usize| {
            let of_root = 2.0 * (of_a[k] + self.a * of_f[k]) / root.max(1e-9);
            2.0 * of_f[k] / q - 2.0 * f * of_root / (q * q)
        };
        Some((2.0 * f / q, [slope(0), slope(1), slope(2)]))
    }

    /// Sum of squared distances.
    fn sum(&self, points: &[DVec2]) -> f64 {
        points.iter().map(|p| self.distance(*p).map_or(f64::INFINITY, |(d, _)| d * d)).sum()
    }

    /// Moves to the nearest local minimum of the sum of squared distances, and returns that sum too (Levenberg and
    /// Marquardt).
    fn minimise(mut self, points: &[DVec2]) -> (Self, f64) {
        let (mut sum, mut damping) = (self.sum(points), 1e-3);
        for _ in 0..MOST_STEPS {
            let (mut m, mut b) = ([0.0; 9], [0.0; 3]);
            for (d, slopes) in points.iter().filter_map(|p| self.distance(*p)) {
                for r in 0..3 {
                    (0..3).for_each(|c| m[r * 3 + c] += slopes[r] * slopes[c]);
                    b[r] -= slopes[r] * d;
                }
            }
            (0..3).for_each(|k| m[k * 4] += damping * (m[k * 4] + 1e-9));
            let Some(step) = Lu::new(3, &m, 1e-15).map(|lu| lu.solve(&b)) else { break };
            let next = Self { a: self.a + step[0], d: self.d + step[1], angle: self.angle + step[2] };
            let next_sum = next.sum(points);
            if next_sum <= sum {
                let done = sum - next_sum <= 1e-14 * sum + 1e-24;
                (self, sum, damping) = (next, next_sum, damping * 0.2);
                if done {
                    break;
                }
            } else {
                damping *= 10.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
        (self, sum)
    }

    /// Part of the curve between the feet of the first and the last point, at the points' own scale.
    fn arc(&self, points: &[DVec2], size: f64, rms: f64) -> Arc {
        // A circle whose radius is over a thousand times the path is a line to rounding.
        if self.a.abs() < 0.5e-3 {
            return self.straight(points, size, rms);
        }
        let e = (1.0 + 4.0 * self.a * self.d).max(0.0).sqrt();
        let centre = DVec2::from_angle(self.angle) * (-0.5 * e / self.a);
        let radius = 0.5 / self.a.abs();
        // Angles count as headings do: from +z towards +x.
        let bearing = |p: DVec2| (p - centre).x.atan2((p - centre).y);
        let turned: f64 = points.windows(2).map(|w| wrap_angle(bearing(w[1]) - bearing(w[0]))).sum();
        let side = if turned < 0.0 { -1.0 } else { 1.0 };
        let heading = wrap_angle(bearing(points[0]) + side * std::f64::consts::FRAC_PI_2);
        Arc { curvature: side / (radius * size), length: turned.abs() * radius * size, heading, rms }
    }

    fn straight(&self, points: &[DVec2], size: f64, rms: f64) -> Arc {
        let (first, last) = (points[0], points[points.len() - 1]);
        let along = DVec2::from_angle(self.angle + std::f64::consts::FRAC_PI_2);
        let length = (last - first).dot(along);
        let along = if length < 0.0 { -along } else { along };
        Arc { curvature: 0.0, length: length.abs() * size, heading: along.x.atan2(along.y), rms }
    }
}

/// The angle in (-pi, pi].
pub fn wrap_angle(angle: f64) -> f64 {
    angle - std::f64::consts::TAU * (angle / std::f64::consts::TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Points of an arc from the origin, heading along +z.
    fn arc(curvature: f64, length: f64, n: usize) -> Vec<DVec2> {
        let at = |i: usize| {
            let s = length * i as f64 / (n - 1) as f64;
            let h = curvature * s;
            match curvature == 0.0 {
                true => DVec2::new(0.0, s),
                false => DVec2::new(1.0 - h.cos(), h.sin()) / curvature,
            }
        };
        (0..n).map(at).collect()
    }

    #[test]
    fn a_straight_line_is_an_arc_without_curvature() {
        let fit = Arc::fit(&arc(0.0, 3.0, 20)).unwrap();
        assert!(fit.curvature.abs() < 1e-6 && (fit.length - 3.0).abs() < 1e-9 && fit.heading.abs() < 1e-9, "{fit:?}");
        assert_eq!(Arc::fit(&[DVec2::ONE; 9]), None);
    }

    /// A quarter circle of radius 2 m to the left (towards +x) from heading 0.
    #[test]
    fn a_quarter_circle_by_hand() {
        let fit = Arc::fit(&arc(0.5, std::f64::consts::PI, 30)).unwrap();
        assert!((fit.curvature - 0.5).abs() < 1e-9 && (fit.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
        assert!(fit.heading.abs() < 1e-9 && fit.rms < 1e-9, "{fit:?}");
    }

    proptest! {
        #[test]
        fn arcs_are_found_however_they_lie(
            curvature in -3.0f64..3.0, turn in -3.0f64..3.0, length in 0.5f64..6.0, x in -50.0f64..50.0,
        ) {
            let place = |p: &DVec2| DVec2::new(turn.cos() * p.x + turn.sin() * p.y + x, turn.cos() * p.y - turn.sin() * p.x);
            let path: Vec<_> = arc(curvature, length, 60).iter().map(place).collect();
            let fit = Arc::fit(&path).unwrap();
            // What is taken for a line has a radius of a thousand times the points' mean distance from their middle.
            let off = if fit.curvature == 0.0 { 3.5e-3 / length } else { 1e-3 };
            prop_assert!((fit.curvature - curvature).abs() < off, "{:?}", fit);
            prop_assert!((fit.length - length).abs() < 1e-3 * length && wrap_angle(fit.heading - turn).abs() < 5e-3, "{:?}", fit);
        }

        /// No circle of a fine grid of centres around the found one, each with its best radius, is nearer.
        #[test]
        fn no_other_circle_is_nearer(
            curvature in -1.5f64..1.5, noise in prop::collection::vec(-0.05f64..0.05, 24), length in 1.0f64..4.0,
        ) {
            prop_assume!(curvature.abs() > 0.3);
            let path: Vec<_> = arc(curvature, length, 12).iter().zip(noise.chunks(2)).map(|(p, n)| *p + DVec2::new(n[0], n[1])).collect();
            let fit = Arc::fit(&path).unwrap();
            let best = |centre: DVec2| {
                let radius = path.iter().map(|p| p.distance(centre)).sum::<f64>() / 12.0;
                path.iter().map(|p| (p.distance(centre) - radius).powi(2)).sum::<f64>()
            };
            let mean = path.iter().sum::<DVec2>() / 12.0;
            let mut least = f64::INFINITY;
            for k in 0..180 {
                for r in 1..400 {
                    let direction = DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 180.0);
                    least = least.min(best(mean + direction * (1.03f64.powi(r) * 0.02)));
                }
            }
            prop_assert!(fit.rms * fit.rms * 12.0 <= least + 1e-9, "{:?}, {}", fit, least);
        }
    }
}
