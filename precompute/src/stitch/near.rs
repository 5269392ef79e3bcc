//! Which boxes overlap.

use crate::environment::Bounds;

/// All (i, j) of which `a[i]` and `b[j]` overlap, ascending.
pub(super) fn overlapping(a: &[Bounds], b: &[Bounds]) -> Vec<(u32, u32)> {
    let mut order: Vec<u32> = (0..b.len() as u32).collect();
    order.sort_by(|&i, &j| b[i as usize].min.x.total_cmp(&b[j as usize].min.x));
    let widest = b.iter().map(|o| o.max.x - o.min.x).fold(0.0, f32::max);
    let mut out = Vec::new();
    for (i, one) in a.iter().enumerate() {
        let first = order.partition_point(|&j| b[j as usize].min.x < one.min.x - widest);
        let here = order[first..].iter().take_while(|&&j| b[j as usize].min.x <= one.max.x);
        let from = out.len();
        out.extend(here.filter(|&&j| one.overlaps(&b[j as usize])).map(|&j| (i as u32, j)));
        out[from..].sort_unstable();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use proptest::prelude::*;

    fn boxes() -> impl Strategy<Value = Vec<Bounds>> {
        let one = (prop::array::uniform3(-5.0f32..5.0), prop::array::uniform3(0.0f32..3.0));
        let bounds = one.prop_map(|(p, s)| Bounds { min: p.into(), max: Vec3::from(p) + Vec3::from(s) });
        prop::collection::vec(bounds, 0..20)
    }

    proptest! {
        #[test]
        fn finds_all_that_overlap(a in boxes(), b in boxes()) {
            let mut expected = Vec::new();
            for (i, x) in a.iter().enumerate() {
                expected.extend((0..b.len()).filter(|&j| x.overlaps(&b[j])).map(|j| (i as u32, j as u32)));
            }
            prop_assert_eq!(overlapping(&a, &b), expected);
        }
    }
}
