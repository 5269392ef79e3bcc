//! Order in which swivel angles are tried.

use std::{f64::consts::PI, sync::LazyLock};
use throng_base::maths;

/// First step to either side (rad), and the factor by which steps grow.
const FIRST: f64 = 0.06;
const GROWTH: f64 = 1.2;
/// Number of swivels of the fine search.
const FINE: usize = 240;

/// Offsets from the present swivel: none, then to both sides in growing steps up to half a turn (rad).
pub fn offsets() -> impl Iterator<Item = f64> {
    let mut step = FIRST;
    let mut at = 0.0;
    let sides = std::iter::from_fn(move || {
        at += step;
        step *= GROWTH;
        (at < PI).then_some([at, -at])
    });
    std::iter::once(0.0).chain(sides.flatten())
}

/// Step of the fine search (rad).
const STEP: f64 = 2.0 * PI / FINE as f64;

/// Cosine and sine of half of an offset.
pub fn half_angle(offset: f64) -> [f64; 2] {
    let (sin, cos) = maths::sin_cos(0.5 * offset);
    [cos, sin]
}

/// Cosines and sines of the fine search: from the present swivel outwards, to both sides in turn.
static FINE_HALVES: LazyLock<[[f64; 2]; FINE]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let side = if i % 2 == 0 { -0.5 } else { 0.5 };
        half_angle(side * (i + i % 2) as f64 * STEP)
    })
});

/// Searches the whole circle finely, and between neighbours for the narrow windows that limits leave.
///
/// - `try_at`: excess of a swivel over limits (rad), and its pose if that is good; the swivel is given by cosine and sine of
///   half of its offset from the present one.
pub fn search_finely<P>(mut try_at: impl FnMut([f64; 2]) -> (f64, Option<P>)) -> Option<P> {
    let mut outside = [0.0; FINE];
    for (half, out) in FINE_HALVES.iter().zip(&mut outside) {
        let (excess, pose) = try_at(*half);
        if pose.is_some() {
            return pose;
        }
        *out = excess;
    }
    let at = |k: usize| {
        // Neighbours on the circle: 0, 1, 2 ... to one side are tries 0, 1, 3, 5 ..., to the other 2, 4, 6 ...
        match k % FINE {
            0 => 0,
            k if k <= FINE / 2 => 2 * k - 1,
            k => 2 * (FINE - k),
        }
    };
    for k in 0..FINE {
        let [before, here, after] = [outside[at(k + FINE - 1)], outside[at(k)], outside[at(k + 1)]];
        if here > 0.0 && here <= before && here <= after {
            let found = golden_section_search(k as f64 * STEP, |offset| try_at(half_angle(offset)));
            if found.is_some() {
                return found;
            }
        }
    }
    None
}

/// Golden-section search for the swivel with the least excess within a step of a middle (rad), until one is good.
fn golden_section_search<P>(middle: f64, mut try_at: impl FnMut(f64) -> (f64, Option<P>)) -> Option<P> {
    const SHARE: f64 = 0.618_033_988_749_894_9;
    let inner = |low: f64, high: f64| [high - SHARE * (high - low), low + SHARE * (high - low)];
    let (mut low, mut high) = (middle - STEP, middle + STEP);
    let [mut a, mut b] = inner(low, high);
    let ((mut fa, pose_a), (mut fb, pose_b)) = (try_at(a), try_at(b));
    let mut found = pose_a.or(pose_b);
    while found.is_none() && high - low > 1e-7 {
        if fa < fb {
            (high, b, fb) = (b, a, fa);
            a = inner(low, high)[0];
            (fa, found) = try_at(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = inner(low, high)[1];
            (fb, found) = try_at(b);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_to_both_sides() {
        let all: Vec<f64> = offsets().collect();
        assert_eq!((all[0], all[1], all[2]), (0.0, 0.06, -0.06));
        assert!(all.len() < 40 && all.last().is_some_and(|o| *o < -2.0));
        assert!(all.windows(5).skip(1).step_by(2).all(|w| w[4] - w[2] > w[2] - w[0]));
    }

    #[test]
    fn a_window_between_two_tries_is_found() {
        // Good only within 1e-4 of a swivel that no try hits.
        let good = 1.2345;
        let found = search_finely(|[cos, sin]: [f64; 2]| {
            let s = 2.0 * maths::atan2(sin, cos);
            let away = (s - good + PI).rem_euclid(2.0 * PI) - PI;
            (away.abs() - 1e-4, (away.abs() < 1e-4).then_some(s))
        });
        assert!(found.is_some());
    }
}
