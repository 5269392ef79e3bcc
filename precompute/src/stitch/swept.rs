//! Where the bodies of a patch's links pass over the ground, as bits: most links pass beside a unit, and none of their
//! frames need be looked at.

use super::bodies::Bodies;
use super::field::Field;
use super::mask::looked_at;
use super::paths::Paths;
use crate::environment::Bounds;
use rayon::prelude::*;
use throng_runtime::patch::Placement;

/// Squares along each side of the grid: one word is a row of them.
const SIDE: usize = 128;

/// Squares of a grid over a patch that each link's bodies touch.
#[derive(Clone, Debug)]
pub(super) struct Swept {
    /// Lowest corner of the grid: x and z. [Unit: m]
    min: [f32; 2],
    /// Edge length of a square. [Unit: m]
    step: f32,
    /// Rows of each link along z, a bit for each square along x. [Size: links * SIDE]
    rows: Vec<u128>,
}

/// The rows of a grid that a unit touches.
pub(super) type Shadow = Vec<(usize, u128)>;

impl Swept {
    /// Follows all links of a patch.
    ///
    /// - `depth_m`: bodies may be that deep in a unit.
    pub fn new(paths: &Paths, bodies: &Bodies, depth_m: f32) -> Self {
        let links = 0..paths.num_links();
        let all = links.clone().fold(Bounds::EMPTY, |b, l| b.union(*paths.bounds(l))).grown(bodies.radius());
        let side = (all.max - all.min).max_element().max(1e-3);
        let mut out = Self { min: [all.min.x, all.min.z], step: side / SIDE as f32, rows: Vec::new() };
        let mut rows = vec![0; SIDE * links.len()];
        rows.par_chunks_mut(SIDE).enumerate().for_each(|(l, rows)| {
            let first = paths.range(l).start;
            for at in looked_at(paths.range(l).len()).map(|k| first + k) {
                let shadow = bodies.shadow(paths.rows()[at] as usize, paths.roots()[at], depth_m);
                shadow.for_each(|disc| out.mark(disc, rows));
            }
        });
        out.rows = rows;
        out
    }

    fn mark(&self, [x, z, radius]: [f32; 3], rows: &mut [u128]) {
        // What lies just on the edge of a square is in both.
        let radius = radius + 0.001 * self.step;
        let square = |v: f32, min: f32| (((v - min) / self.step) as usize).min(SIDE - 1);
        let (low, high) = (square(x - radius, self.min[0]), square(x + radius, self.min[0]));
        let bits = (u128::MAX << low) & (u128::MAX >> (SIDE - 1 - high));
        let (first, last) = (square(z - radius, self.min[1]), square(z + radius, self.min[1]));
        rows[first..=last].iter_mut().for_each(|r| *r |= bits);
    }

    /// Squares that a unit may touch which stands at `unit_at` in the patch's frame.
    pub fn shadow(&self, unit: &Field, unit_at: Placement) -> Shadow {
        let (sin, cos) = unit_at.heading.sin_cos();
        let reach = self.step * std::f32::consts::FRAC_1_SQRT_2 + 1e-4;
        let middle = |k: usize, min: f32| min + (k as f32 + 0.5) * self.step;
        let row = |r: usize| {
            let z = middle(r, self.min[1]) - unit_at.z;
            let touches = |c: &usize| {
                let x = middle(*c, self.min[0]) - unit_at.x;
                unit.beside(cos * x - sin * z, sin * x + cos * z) <= reach
            };
            (0..SIDE).filter(touches).fold(0, |bits, c| bits | 1u128 << c)
        };
        (0..SIDE).map(|r| (r, row(r))).filter(|(_, bits)| *bits != 0).collect()
    }

    /// False where no body of a link can touch what casts a shadow.
    pub fn meets(&self, link: usize, shadow: &Shadow) -> bool {
        let rows = &self.rows[link * SIDE..][..SIDE];
        shadow.iter().any(|&(row, bits)| rows[row] & bits != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISC: [f32; 3] = [1.9, 1.1, 0.3];

    /// A link whose bodies are one disc, on a grid of 6 cm.
    fn swept() -> Swept {
        let mut out = Swept { min: [-2.0, -3.0], step: 0.06, rows: Vec::new() };
        let mut rows = vec![0; SIDE];
        out.mark(DISC, &mut rows);
        out.rows = rows;
        out
    }

    #[test]
    fn every_point_of_a_disc_is_in_a_square_that_is_marked() {
        let swept = swept();
        for k in 0..1000 {
            let (sin, cos) = (k as f32 * 0.1).sin_cos();
            let r = DISC[2] * (k as f32 / 999.0).sqrt();
            let at = [DISC[0] + r * cos + 2.0, DISC[1] + r * sin + 3.0].map(|v| (v / 0.06) as usize);
            assert!(swept.meets(0, &vec![(at[1], 1 << at[0])]));
        }
        assert!(!swept.meets(0, &vec![(0, u128::MAX), (SIDE - 1, u128::MAX)]));
    }

    #[test]
    fn what_is_beyond_the_grid_is_at_its_edge() {
        let mut rows = vec![0; SIDE];
        swept().mark([-9.0, 99.0, 0.1], &mut rows);
        assert_eq!((rows[SIDE - 1], rows[..SIDE - 1].iter().all(|r| *r == 0)), (1, true));
    }

    #[test]
    fn a_unit_shadows_all_squares_that_it_touches_and_few_more() {
        let text = "[[units]]\nname = \"u\"\nshapes = [{ box = { at = [0.0, 0.5, 0.0], size = [0.6, 1.0, 0.2] } }]\n";
        let set = crate::environment::UnitSet::parse(text, std::path::Path::new("u.toml")).unwrap();
        let geometry = crate::environment::UnitGeometry::new(&set.units[0]).unwrap();
        let (unit, at) = (Field::new(&std::sync::Arc::new(geometry)), Placement::new(0.4, 0.0, -0.3, 0.6));
        let (swept, to_unit) = (swept(), at.inverse());
        let shadow = swept.shadow(&unit, at);
        let is_in = |c: usize, r: usize| shadow.iter().any(|&(row, bits)| row == r && bits >> c & 1 == 1);
        for (c, r) in (0..SIDE).flat_map(|c| (0..SIDE).map(move |r| (c, r))) {
            let middle = Placement::new(-2.0 + 0.06 * (c as f32 + 0.5), 0.0, -3.0 + 0.06 * (r as f32 + 0.5), 0.0);
            let p = to_unit.compose(middle);
            let apart = (p.x.abs() - 0.3).max(0.0).hypot((p.z.abs() - 0.1).max(0.0));
            assert!(is_in(c, r) || apart > 0.03, "{c} {r}");
            assert!(!is_in(c, r) || apart < 0.16, "{c} {r}");
        }
    }
}
