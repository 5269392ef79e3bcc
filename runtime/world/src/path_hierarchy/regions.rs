//! Regions: parts of a floor in which one can walk about as on an endless plane.
//!
//! Costs on a plane are too low around a corner. So a floor with corners is split into rectangles; paths between them lead
//! through portals, each of which is an edge between two tiles.

use std::collections::BTreeSet;

/// Share of the rectangle around it that a floor must fill to be one region: what stands in the way of few is walked
/// around at little cost, while every portal more makes costs less exact.
const FULL: f32 = 0.95;

/// Parts places into regions: all of them into one, or into rectangles, the largest first (copies).
pub(super) fn part_into_regions(mut places: BTreeSet<[i32; 2]>) -> Vec<Vec<[i32; 2]>> {
    if is_full(&places) {
        return vec![places.into_iter().collect()];
    }
    let mut out = Vec::new();
    while let Some(region) = largest(&places) {
        region.iter().for_each(|place| _ = places.remove(place));
        out.push(region);
    }
    out
}

fn is_full(places: &BTreeSet<[i32; 2]>) -> bool {
    let range = |axis: usize| {
        let least = places.iter().map(|p| p[axis]).min().unwrap_or(0);
        places.iter().map(|p| p[axis]).max().unwrap_or(0) - least + 1
    };
    places.len() as f32 >= FULL * range(0) as f32 * range(1) as f32
}

/// The largest rectangle of places; of equal ones, the first.
fn largest(places: &BTreeSet<[i32; 2]>) -> Option<Vec<[i32; 2]>> {
    let (mut best, mut most) = (None, 0);
    for &[u, v] in places {
        // Rectangles with each place as first corner, as far as every row leads.
        let (mut widest, mut length) = (i32::MAX, 0);
        while widest > 0 && places.contains(&[u + length, v]) {
            let width = (0..widest).take_while(|w| places.contains(&[u + length, v + w])).count() as i32;
            widest = widest.min(width);
            length += 1;
            if length * widest > most {
                most = length * widest;
                best = Some(([u, v], [length, widest]));
            }
        }
    }
    let ([u, v], [length, width]) = best?;
    Some((0..length).flat_map(|l| (0..width).map(move |w| [u + l, v + w])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rectangle([u, v]: [i32; 2], [length, width]: [i32; 2]) -> impl Iterator<Item = [i32; 2]> {
        (0..length).flat_map(move |l| (0..width).map(move |w| [u + l, v + w]))
    }

    #[test]
    fn a_rectangle_with_a_hole_is_one_region() {
        let places = rectangle([-3, 2], [6, 5]).filter(|p| *p != [0, 4]).collect();
        assert_eq!(part_into_regions(places).len(), 1);
    }

    #[test]
    fn an_angle_is_parted_at_its_corner() {
        let places: BTreeSet<_> = rectangle([0, 0], [10, 2]).chain(rectangle([0, 2], [2, 6])).collect();
        let mut regions: Vec<_> = part_into_regions(places).iter().map(Vec::len).collect();
        regions.sort_unstable();
        assert_eq!(regions, [12, 20]);
    }

    proptest! {
        #[test]
        fn every_place_is_in_one_region(places in prop::collection::btree_set((0i32..6, 0i32..6), 1..30)) {
            let places: BTreeSet<[i32; 2]> = places.into_iter().map(|(u, v)| [u, v]).collect();
            let mut all: Vec<_> = part_into_regions(places.clone()).concat();
            prop_assert_eq!(all.len(), places.len());
            all.sort_unstable();
            prop_assert_eq!(all, places.into_iter().collect::<Vec<_>>());
        }
    }
}
