//! Capsules around shapes, of which held objects are made.

use glam::DVec3;
use throng_geometry::{Segment, SolidShape};

/// Most capsules across the middle side of a box.
const MAX_COLUMNS: usize = 8;

/// Capsules that hold all of a shape: core and radius (m).
pub(super) fn capsules_around(shape: &SolidShape) -> Vec<(Segment, f64)> {
    match shape {
        SolidShape::Round { core, radius } => vec![(*core, *radius)],
        SolidShape::Cuboid { half } => around_box(DVec3::ZERO, *half),
        SolidShape::Mesh(mesh) => {
            let corners = || mesh.corners().iter().flatten().map(|c| c.as_dvec3());
            let low = corners().fold(DVec3::INFINITY, DVec3::min);
            let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
            around_box(0.5 * (low + high), (0.5 * (high - low)).max(DVec3::splat(1e-3)))
        }
    }
}

/// Columns along the longest side, side by side along the middle one, each thick enough for its corners.
fn around_box(middle: DVec3, half: DVec3) -> Vec<(Segment, f64)> {
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| half[*b].total_cmp(&half[*a]));
    let [long, wide, _] = axes.map(|i| DVec3::AXES[i]);
    let [a, b, c] = axes.map(|i| half[i]);
    let columns = ((b / c).ceil() as usize).clamp(1, MAX_COLUMNS);
    let across = b / columns as f64;
    // A shorter core and a larger radius stick out less at the ends.
    let short = 0.5 * c.min(across);
    let radius = (short * short + across * across + c * c).sqrt();
    let column = |k: usize| {
        let at = middle + wide * (across * (2 * k + 1) as f64 - b);
        (Segment::new(at - long * (a - short), at + long * (a - short)), radius)
    };
    (0..columns).map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn capsules_hold_all_of_a_box(
            size in prop::array::uniform3(0.01f64..0.6), at in prop::array::uniform3(-1.0f64..=1.0)
        ) {
            let half = 0.5 * DVec3::from(size);
            let all = capsules_around(&SolidShape::cuboid(DVec3::from(size)));
            let p = Segment::new(half * DVec3::from(at), half * DVec3::from(at));
            prop_assert!(all.iter().any(|(core, radius)| core.distance(&p) <= radius + 1e-9));
            let least = half.min_element();
            prop_assert!(all.iter().all(|(_, r)| *r < least * 1.5 + 1e-9 || all.len() == MAX_COLUMNS));
        }
    }
}
