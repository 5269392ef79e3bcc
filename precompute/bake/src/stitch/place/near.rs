//! Search for overlapping boxes.

use glam::Vec3;
use throng_geometry::BoundingBox;

/// All (i, j) for which `a[i]` and `b[j]` overlap, ascending. Boxes may be inverted by shrinking.
pub(in crate::stitch) fn overlapping_pairs(a: &[BoundingBox], b: &[BoundingBox]) -> Vec<(u32, u32)> {
    let extents = a.iter().chain(b).map(|o| o.max - o.min);
    let widest = extents.fold(Vec3::splat(1e-3), Vec3::max);
    let strip = |x: f32| (x / widest.x).floor() as i64;
    let key = |j: u32| (strip(b[j as usize].min.x), b[j as usize].min.z);
    let mut order: Vec<u32> = (0..b.len() as u32).filter(|&j| b[j as usize].min.is_finite()).collect();
    order.sort_unstable_by(|&i, &j| key(i).0.cmp(&key(j).0).then(key(i).1.total_cmp(&key(j).1)).then(i.cmp(&j)));
    let keys: Vec<(i64, f32)> = order.iter().map(|&j| key(j)).collect();
    let mut out = Vec::new();
    for (i, one) in a.iter().enumerate().filter(|(_, one)| one.min.is_finite()) {
        let from = out.len();
        for here in strip(one.min.x - widest.x)..=strip(one.max.x) {
            let first = keys.partition_point(|&(s, z)| s < here || s == here && z < one.min.z - widest.z);
            let near = keys[first..].iter().take_while(|&&(s, z)| s == here && z <= one.max.z).count();
            let overlaps = |j: &&u32| one.overlaps(&b[**j as usize]);
            out.extend(order[first..first + near].iter().filter(overlaps).map(|&j| (i as u32, j)));
        }
        out[from..].sort_unstable();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxes() -> impl Strategy<Value = Vec<BoundingBox>> {
        let one = (prop::array::uniform3(-5.0f32..5.0), prop::array::uniform3(-0.3f32..3.0));
        let bounds = one.prop_map(|(p, s)| BoundingBox { min: p.into(), max: Vec3::from(p) + Vec3::from(s) });
        prop::collection::vec(bounds, 0..20)
    }

    proptest! {
        #[test]
        fn finds_all_that_overlap(a in boxes(), b in boxes()) {
            let mut expected = Vec::new();
            for (i, x) in a.iter().enumerate() {
                expected.extend((0..b.len()).filter(|&j| x.overlaps(&b[j])).map(|j| (i as u32, j as u32)));
            }
            prop_assert_eq!(overlapping_pairs(&a, &b), expected);
        }
    }
}
