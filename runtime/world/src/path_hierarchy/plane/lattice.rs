//! Lattices: where copies of a tile stand, counted along two of its steps.

use glam::Vec3;

/// Steps as whole multiples of two of them; none where they all lie on a line, or are no such multiples.
pub(super) fn lattice(steps: &[Vec3]) -> Option<Vec<[i32; 2]>> {
    let u = *steps.first()?;
    let v = *steps.iter().find(|s| s.cross(u).length() > 1e-3 * u.length_squared())?;
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let area = uu * vv - uv * uv;
    let multiple = |s: &Vec3| {
        let (su, sv) = (s.dot(u), s.dot(v));
        let at = [(su * vv - sv * uv) / area, (sv * uu - su * uv) / area].map(f32::round);
        let there = u * at[0] + v * at[1];
        (there.distance(*s) <= 1e-2 * u.length() && at.iter().all(|a| a.abs() <= 2.0)).then_some(at.map(|a| a as i32))
    };
    steps.iter().map(multiple).collect()
}
