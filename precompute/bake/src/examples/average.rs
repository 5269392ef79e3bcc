//! Reference orientation of a set (Kim, Kim and Shin 2003a, section 4.2.3, equations 6 to 11), and displacements from
//! it.

use glam::{DQuat, DVec3, DVec4};

/// A 4 x 4 matrix, row by row.
type Matrix = [[f64; 4]; 4];

/// Sweeps of Jacobi rotations; each squares the off-diagonal rest, so that a few suffice.
const SWEEPS: usize = 32;

/// Orientation nearest to all of a set: it minimises the sum of squared sines of the angles (as unit quaternions)
/// between it and each of them, regardless of the sign of q (equations 8 and 9).
///
/// The solution is the eigenvector of equation 11 with the smallest objective. On a tie the first is taken, so that
/// equal sets give equal answers. An empty set has the identity.
pub fn reference(set: &[DQuat]) -> DQuat {
    let mut a = [[0.0; 4]; 4];
    for q in set.iter().map(|q| q.to_array()) {
        for (r, row) in a.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(c, v)| *v += q[r] * q[c]);
        }
    }
    let candidates = eigenvectors(a).into_iter().filter(|_| !set.is_empty()).map(DQuat::from_vec4);
    candidates.min_by(|p, q| objective(*p, set).total_cmp(&objective(*q, set))).unwrap_or(DQuat::IDENTITY).normalize()
}

/// Objective that [`reference()`] minimises (equation 9).
pub fn objective(reference: DQuat, set: &[DQuat]) -> f64 {
    set.iter().map(|q| 1.0 - reference.dot(*q) * reference.dot(*q)).sum()
}

/// Log-displacement of an orientation from a reference by the shorter way: `reference * exp(v)` is the orientation,
/// where `exp(v)` turns by 2 |v| about v (at most a quarter turn, pi / 2, long).
pub fn displacement(reference: DQuat, q: DQuat) -> DVec3 {
    let d = reference.conjugate() * q;
    let d = if d.w < 0.0 { -d } else { d };
    let sine = d.xyz().length();
    // For small angles, the ratio of angle and sine is 1 to rounding.
    let ratio = if sine < 1e-9 { 1.0 } else { sine.atan2(d.w) / sine };
    d.xyz() * ratio
}

/// Orientation that turns by 2 |v| about v: the inverse of [`displacement`].
pub fn exponential(v: DVec3) -> DQuat {
    DQuat::from_scaled_axis(2.0 * v)
}

/// The four eigenvectors of a symmetric matrix, by cyclic Jacobi rotations.
fn eigenvectors(mut a: Matrix) -> [DVec4; 4] {
    let mut v: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| f64::from(u8::from(r == c))));
    for _ in 0..SWEEPS {
        let mut left = 0.0;
        for p in 0..3 {
            for q in p + 1..4 {
                left += a[p][q] * a[p][q];
                rotate(&mut a, &mut v, p, q);
            }
        }
        if left < 1e-28 {
            break;
        }
    }
    std::array::from_fn(|k| DVec4::from_array(std::array::from_fn(|r| v[r][k])))
}

/// Makes `a[p][q]` zero by a rotation of rows and columns p and q.
fn rotate(a: &mut Matrix, v: &mut Matrix, p: usize, q: usize) {
    if a[p][q].abs() < 1e-300 {
        a[p][q] = 0.0;
        a[q][p] = 0.0;
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let (c, s) = (1.0 / (t * t + 1.0).sqrt(), t / (t * t + 1.0).sqrt());
    for k in 0..4 {
        let (x, y) = (a[k][p], a[k][q]);
        (a[k][p], a[k][q]) = (c * x - s * y, s * x + c * y);
    }
    for k in 0..4 {
        let (x, y) = (a[p][k], a[q][k]);
        (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
        let (x, y) = (v[k][p], v[k][q]);
        (v[k][p], v[k][q]) = (c * x - s * y, s * x + c * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit() -> impl Strategy<Value = DQuat> {
        prop::array::uniform4(-1.0f64..1.0)
            .prop_filter("not zero", |q| DVec4::from_array(*q).length() > 0.1)
            .prop_map(|q| DQuat::from_vec4(DVec4::from_array(q).normalize()))
    }

    /// Smallest objective by descent from many starts, by ever smaller steps in all directions.
    fn by_search(set: &[DQuat]) -> f64 {
        let starts = set.iter().copied().chain([DQuat::IDENTITY, DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5)]);
        let descend = |start: DQuat| {
            let (mut best, mut at, mut step) = (objective(start, set), DVec4::from(start), 0.5);
            while step > 1e-8 {
                let moves = (0..8).map(|k| at + DVec4::AXES[k % 4] * if k < 4 { step } else { -step });
                let next = moves.map(|m| (objective(DQuat::from_vec4(m.normalize()), set), m.normalize()));
                match next.min_by(|a, b| a.0.total_cmp(&b.0)) {
                    Some((value, place)) if value < best => (best, at) = (value, place),
                    _ => step *= 0.5,
                }
            }
            best
        };
        starts.map(descend).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn no_orientation_is_nearer(set in prop::collection::vec(unit(), 1..8)) {
            let q = reference(&set);
            prop_assert!((q.length() - 1.0).abs() < 1e-12);
            prop_assert!(objective(q, &set) < by_search(&set) + 1e-9);
        }

        #[test]
        fn signs_do_not_matter(set in prop::collection::vec(unit(), 1..8), flip in any::<u8>()) {
            let other: Vec<_> = set.iter().enumerate().map(|(i, q)| if flip >> i & 1 == 1 { -*q } else { *q }).collect();
            prop_assert!((objective(reference(&set), &set) - objective(reference(&other), &set)).abs() < 1e-12);
        }

        #[test]
        fn displacements_lead_back(a in unit(), b in unit()) {
            let v = displacement(a, b);
            prop_assert!(v.length() < std::f64::consts::FRAC_PI_2 + 1e-12);
            prop_assert!((a * exponential(v)).dot(b).abs() > 1.0 - 1e-12);
        }
    }

    #[test]
    fn antipodal_and_nearly_degenerate_sets() {
        let turn = |angle: f64| DQuat::from_rotation_y(angle);
        let set = [turn(0.3), -turn(0.3), turn(0.3)];
        assert!(reference(&set).dot(turn(0.3)).abs() > 1.0 - 1e-12, "one orientation in both signs");
        let half = std::f64::consts::PI;
        // Two half turns apart: every orientation between them is as good, and one a little nearer decides.
        let set = [turn(0.0), turn(half - 1e-6)];
        assert!(objective(reference(&set), &set) < by_search(&set) + 1e-9);
        // Four orientations at right angles to one another: all are as good.
        let set = [DQuat::IDENTITY, DQuat::from_rotation_x(half), turn(half), DQuat::from_rotation_z(half)];
        assert!((objective(reference(&set), &set) - 3.0).abs() < 1e-9);
        assert_eq!(reference(&set), reference(&set));
        assert_eq!(reference(&[]), DQuat::IDENTITY);
    }

    #[test]
    fn the_middle_of_two_is_half_way() {
        let set = [DQuat::from_rotation_x(0.2), -DQuat::from_rotation_x(1.0)];
        assert!(reference(&set).dot(DQuat::from_rotation_x(0.6)).abs() > 1.0 - 1e-12);
    }
}
