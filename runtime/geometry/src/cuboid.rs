//! Distance between a segment and a box.

use crate::segment::Segment;
use glam::DVec3;

/// Distance from a segment to a box around the origin; 0 inside (m).
///
/// The square of the distance along the segment is convex, with pieces that are parabolas: its slope is followed from break
/// to break until it turns positive.
pub fn segment_cuboid(s: &Segment, half: DVec3) -> f64 {
    let d = s.b - s.a;
    let mut breaks = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let mut num = 1;
    for axis in 0..3 {
        if d[axis] != 0.0 {
            for face in [-half[axis], half[axis]] {
                let at = (face - s.a[axis]) / d[axis];
                if at > 0.0 && at < 1.0 {
                    breaks[num] = at;
                    num += 1;
                }
            }
        }
    }
    num += 1;
    breaks[1..num].sort_unstable_by(f64::total_cmp);
    let outside = |t: f64| {
        let p = s.a + d * t;
        p - p.clamp(-half, half)
    };
    let slope = |t: f64| outside(t).dot(d);
    let (mut from, mut slope_from) = (0.0, slope(0.0));
    if slope_from >= 0.0 {
        return outside(0.0).length();
    }
    for &to in &breaks[1..num] {
        let slope_to = slope(to);
        if slope_to >= 0.0 {
            let rise = slope_to - slope_from;
            let at = if rise > 0.0 { from - slope_from * (to - from) / rise } else { to };
            return outside(at).length();
        }
        (from, slope_from) = (to, slope_to);
    }
    outside(1.0).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::tests::{least, points};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn distances_are_those_of_a_search(p in points(), q in points(), half in prop::array::uniform3(0.05f64..0.5), point in any::<bool>()) {
            let (q, half) = (if point { p } else { q }, DVec3::from(half));
            let searched = least(|u| { let x = p.lerp(q, u); (x - x.clamp(-half, half)).length() });
            let found = segment_cuboid(&Segment::new(p, q), half);
            prop_assert!((found - searched).abs() < 1e-5, "{found} {searched}");
        }
    }
}
