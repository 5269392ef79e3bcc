//! Limbs of two bones.

use std::ops::{Add, Div, Mul, Sub};

/// Position of the joint between two bones of lengths `l1` and `l2` whose ends are `d` apart: along the line from the first
/// end to the last, and across it (m).
///
/// - `d`: from |`l1` - `l2`| to `l1` + `l2`, not 0 (m).
/// - `root`: square root of a number, 0 for numbers below 0.
#[inline(always)]
pub fn two_bone_offsets<F>([l1, l2]: [F; 2], d: F, root: impl FnOnce(F) -> F) -> [F; 2]
where
    F: Copy + Add<Output = F> + Sub<Output = F> + Mul<Output = F> + Div<Output = F>,
{
    let along = (l1 * l1 - l2 * l2 + d * d) / (d + d);
    [along, root(l1 * l1 - along * along)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn both_bones_keep_their_lengths(l1 in 0.1f64..1.0, l2 in 0.1f64..1.0, share in 0.0f64..=1.0) {
            let (least, most) = ((l1 - l2).abs() + 1e-3, l1 + l2);
            let d = least + (most - least) * share;
            let [along, across] = two_bone_offsets([l1, l2], d, |v| v.max(0.0).sqrt());
            prop_assert!((along.hypot(across) - l1).abs() < 1e-7 && across >= 0.0);
            prop_assert!(((d - along).hypot(across) - l2).abs() < 1e-7);
        }
    }
}
