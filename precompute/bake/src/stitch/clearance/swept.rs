//! Ground swept by the bodies of a patch's links, as bits: most links pass beside a unit, and need no sampling of
//! frames.

use super::{bodies::FrameBodies, collision_span::nearest_sampled, field::DistanceField};
use crate::{stitch::place::paths::LinkRoots, stitch::sets::rows::set_bits};
use rayon::prelude::*;
use throng_core::patch::Placement;
use throng_geometry::BoundingBox;

/// Squares along each side of the grid.
const SIDE: usize = 128;
/// Links whose bits are in one word.
const LINKS: usize = u64::BITS as usize;

/// Squares of a grid over a patch that each link's bodies touch.
#[derive(Clone, Debug)]
pub(in crate::stitch) struct SweptSquares {
    /// Lowest corner of the grid: x and z (m).
    min: [f32; 2],
    /// Edge length of a square (m).
    step: f32,
    /// A bit for each link, in the order of [`LinkRoots::play_order`]: all squares for the first 64 links, then for the next
    /// ones. Squares along x are adjacent (words of links * SIDE * SIDE).
    squares: Vec<u64>,
    /// Largest distance of a body of each link from its root over the ground (m, links).
    pub radii: Vec<f32>,
}

/// Rows of squares that a unit touches.
pub(in crate::stitch) type Shadow = Vec<std::ops::Range<usize>>;

impl SweptSquares {
    /// Computes the swept squares of all links of a patch.
    pub fn new(paths: &LinkRoots, bodies: &FrameBodies) -> Self {
        let all =
            (0..paths.num_links()).fold(BoundingBox::EMPTY, |b, l| b.union(paths.bounds[l])).expanded(bodies.radius);
        let side = (all.max - all.min).max_element().max(1e-3);
        let radius =
            |l: usize| paths.rows_of(l).iter().map(|&row| bodies.reaches[row as usize].radius).fold(0.0, f32::max);
        let radii = (0..paths.num_links()).into_par_iter().map(radius).collect();
        let mut out = Self { min: [all.min.x, all.min.z], step: side / SIDE as f32, squares: Vec::new(), radii };
        let mut squares = vec![0; paths.num_links().div_ceil(LINKS) * SIDE * SIDE];
        let words = squares.par_chunks_mut(SIDE * SIDE).zip(paths.play_order.par_chunks(LINKS));
        words.for_each(|(words, links)| {
            let rows: Vec<_> = links.iter().map(|&l| out.rows(paths, bodies, l as usize)).collect();
            turn(&rows, words);
        });
        out.squares = squares;
        out
    }

    /// Squares that a link's bodies touch: a row for each along z, with a bit for each along x.
    fn rows(&self, paths: &LinkRoots, bodies: &FrameBodies, link: usize) -> [u128; SIDE] {
        let mut rows = [0; SIDE];
        let range = paths.root_range(link);
        for at in nearest_sampled(range.len()).map(|k| range.start + k) {
            let shadow = bodies.shadow(paths.rows[at] as usize, paths.roots[at]);
            shadow.for_each(|disc| self.mark_disc(disc, &mut rows));
        }
        rows
    }

    fn mark_disc(&self, [x, z, radius]: [f32; 3], rows: &mut [u128; SIDE]) {
        // A point on the edge of a square is in both.
        let radius = radius + 0.001 * self.step;
        let square = |v: f32, min: f32| (((v - min) / self.step) as usize).min(SIDE - 1);
        let (low, high) = (square(x - radius, self.min[0]), square(x + radius, self.min[0]));
        let bits = (u128::MAX << low) & (u128::MAX >> (SIDE - 1 - high));
        let (first, last) = (square(z - radius, self.min[1]), square(z + radius, self.min[1]));
        rows[first..=last].iter_mut().for_each(|r| *r |= bits);
    }

    /// Squares that a unit at `unit_at` in the patch's frame may touch.
    pub fn shadow(&self, unit: &DistanceField, unit_at: Placement) -> Shadow {
        let (sin, cos) = unit_at.heading.sin_cos();
        let reach = self.step * std::f32::consts::FRAC_1_SQRT_2 + 1e-4;
        let middle = |k: usize, min: f32| min + (k as f32 + 0.5) * self.step;
        let touches = |square: usize| {
            let x = middle(square % SIDE, self.min[0]) - unit_at.x;
            let z = middle(square / SIDE, self.min[1]) - unit_at.z;
            unit.least_distance_to_line(cos * x - sin * z, sin * x + cos * z) <= reach
        };
        let touched: Vec<usize> = (0..SIDE * SIDE).filter(|&square| touches(square)).collect();
        touched.chunk_by(|a, b| a + 1 == *b).map(|run| run[0]..run[run.len() - 1] + 1).collect()
    }

    /// Positions in [`LinkRoots::play_order`] of the links with a body that may touch the owner of a shadow; ascending.
    pub fn links_meeting(&self, shadow: &Shadow) -> Vec<u32> {
        let word = |squares: &[u64]| {
            let mut all = 0;
            for run in shadow {
                all = squares[run.clone()].iter().fold(all, |all, word| all | word);
                if all == u64::MAX {
                    break;
                }
            }
            all
        };
        let words: Vec<u64> = self.squares.par_chunks(SIDE * SIDE).with_min_len(16).map(word).collect();
        let numbers = |(k, word): (usize, u64)| set_bits(word).map(move |bit| (k * LINKS) as u32 + bit);
        words.into_iter().enumerate().flat_map(numbers).collect()
    }
}

/// Converts a row of squares for each link to a word of links for each square.
fn turn(links: &[[u128; SIDE]], words: &mut [u64]) {
    for (row, words) in words.chunks_exact_mut(SIDE).enumerate() {
        for (half, words) in words.chunks_exact_mut(LINKS).enumerate() {
            let mut block = [0; LINKS];
            for (to, rows) in block.iter_mut().zip(links) {
                *to = (rows[row] >> (half * LINKS)) as u64;
            }
            if block.iter().any(|b| *b != 0) {
                transpose(&mut block);
                words.copy_from_slice(&block);
            }
        }
    }
}

/// Transposes 64 words of 64 bits, halves first (Warren, "Hacker's Delight", section 7-3).
fn transpose(block: &mut [u64; LINKS]) {
    let (mut width, mut mask) = (LINKS / 2, u64::MAX >> (LINKS / 2));
    while width != 0 {
        for k in (0..LINKS).filter(|k| k & width == 0) {
            let differing = (block[k] >> width ^ block[k + width]) & mask;
            block[k] ^= differing << width;
            block[k + width] ^= differing;
        }
        width /= 2;
        mask ^= mask << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DISC: [f32; 3] = [1.9, 1.1, 0.3];

    /// One link of many whose bodies are one disc, on a grid of 6 cm.
    fn swept(link: usize) -> SweptSquares {
        let mut out =
            SweptSquares { min: [-2.0, -3.0], step: 0.06, squares: vec![0; 2 * SIDE * SIDE], radii: Vec::new() };
        let mut links = vec![[0; SIDE]; LINKS];
        out.mark_disc(DISC, &mut links[link % LINKS]);
        turn(&links, &mut out.squares[link / LINKS * SIDE * SIDE..][..SIDE * SIDE]);
        out
    }

    #[test]
    fn every_point_of_a_disc_is_in_a_square_that_is_marked() {
        let swept = swept(70);
        for k in 0..1000 {
            let (sin, cos) = (k as f32 * 0.1).sin_cos();
            let r = DISC[2] * (k as f32 / 999.0).sqrt();
            let [x, z] = [DISC[0] + r * cos + 2.0, DISC[1] + r * sin + 3.0].map(|v| (v / 0.06) as usize);
            let square = z * SIDE + x;
            assert_eq!(swept.links_meeting(&vec![0..1, square..square + 1]), [70]);
        }
        assert!(swept.links_meeting(&vec![0..SIDE, (SIDE - 1) * SIDE..SIDE * SIDE]).is_empty());
    }

    #[test]
    fn what_is_beyond_the_grid_is_at_its_edge() {
        let mut rows = [0; SIDE];
        swept(0).mark_disc([-9.0, 99.0, 0.1], &mut rows);
        assert_eq!((rows[SIDE - 1], rows[..SIDE - 1].iter().all(|r| *r == 0)), (1, true));
    }

    proptest! {
        #[test]
        fn blocks_are_turned(bits in prop::collection::vec((0usize..64, 0usize..64), 0..200)) {
            let (mut block, mut expected) = ([0; LINKS], [0; LINKS]);
            for (row, column) in bits {
                block[row] |= 1 << column;
                expected[column] |= 1 << row;
            }
            transpose(&mut block);
            prop_assert_eq!(block, expected);
        }
    }

    #[test]
    fn a_unit_shadows_all_squares_that_it_touches_and_few_more() {
        let text = "[[units]]\nname = \"u\"\nshapes = [{ box = { at = [0.0, 0.5, 0.0], size = [0.6, 1.0, 0.2] } }]\n";
        let set = crate::environment::UnitSet::parse(text, std::path::Path::new("u.toml")).unwrap();
        let geometry = crate::environment::UnitGeometry::new(&set.units[0]).unwrap();
        let (unit, at) = (DistanceField::new(&std::sync::Arc::new(geometry)), Placement::new(0.4, 0.0, -0.3, 0.6));
        let (swept, to_unit) = (swept(0), at.inverse());
        let shadow = swept.shadow(&unit, at);
        let is_in = |c: usize, r: usize| shadow.iter().any(|run| run.contains(&(r * SIDE + c)));
        for (c, r) in (0..SIDE).flat_map(|c| (0..SIDE).map(move |r| (c, r))) {
            let middle = Placement::new(-2.0 + 0.06 * (c as f32 + 0.5), 0.0, -3.0 + 0.06 * (r as f32 + 0.5), 0.0);
            let p = to_unit.compose(middle);
            let apart = (p.x.abs() - 0.3).max(0.0).hypot((p.z.abs() - 0.1).max(0.0));
            assert!(is_in(c, r) || apart > 0.03, "{c} {r}");
            assert!(!is_in(c, r) || apart < 0.16, "{c} {r}");
        }
    }
}
