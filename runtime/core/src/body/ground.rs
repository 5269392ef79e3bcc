//! The ground that bodies stand on.

use glam::{Vec2, Vec3};
use std::sync::Arc;
use throng_base::error::{check_length, check_range, check_value};
use throng_base::{Hash128, Result};

/// Most knots along a side; a whole grid has at most twice as many (256 MiB).
const MAX_KNOTS: usize = 1 << 25;
/// Distance by which floors continue beyond their edges, and the difference of heights that are of one floor there (m).
const EDGE_M: f32 = 0.4;
const ONE_FLOOR_M: f32 = 0.5;
/// Most knots by which they do.
const MOST_EDGE_KNOTS: f32 = 16.0;

/// Heights at the knots of a square grid, interpolated bilinearly; beyond its edge the ground continues level. It may have
/// several floors above each other. Clones share them.
///
/// ```
/// use throng_core::body::HeightField;
/// use throng_core::glam::Vec2;
///
/// // A ramp of 2 m by 2 m that rises by 1 m along x.
/// let ramp = HeightField::new(Vec2::ZERO, 2.0, [2, 2], vec![0.0, 1.0, 0.0, 1.0])?;
/// assert_eq!(ramp.ground_at(Vec2::new(1.0, 1.0), 0.0).height, 0.5);
/// # Ok::<(), throng_core::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeightField {
    /// Position of the first knot: x and z (m).
    origin: Vec2,
    /// Distance of neighbouring knots (m).
    spacing: f32,
    /// Knots along x and along z.
    size: [usize; 2],
    /// Row by row along x, floors of a knot side by side; empty where the ground is flat.
    heights: Arc<[f32]>,
    /// First height of each knot, and the end of the last one's (knots + 1); empty where there is one floor.
    first_heights: Arc<[u32]>,
}

/// The ground at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundPoint {
    /// (m)
    pub height: f32,
    /// Slope along x and along z.
    pub slope: [f32; 2],
}

impl GroundPoint {
    /// Level, at height 0.
    pub const LEVEL: Self = Self { height: 0.0, slope: [0.0; 2] };

    /// Unit normal of the ground.
    pub fn normal(&self) -> Vec3 {
        Vec3::new(-self.slope[0], 1.0, -self.slope[1]).normalize()
    }
}

impl HeightField {
    /// Flat ground at height 0.
    pub fn flat() -> Self {
        Self::default()
    }

    /// Ground over a grid of knots.
    ///
    /// - `origin`: x and z of the first knot (m).
    /// - `spacing`: of the knots (m, > 0).
    /// - `size`: knots along x and along z (>= 2, 2^26 in all).
    /// - `heights`: rows along x, one after the other along z (m, as many as the product of `size`).
    ///
    /// # Errors
    /// [`Error::Value`](throng_base::Error::Value) for a number out of its range, [`Error::Length`](throng_base::Error::Length) where heights are missing.
    pub fn new(origin: Vec2, spacing: f32, size: [usize; 2], heights: Vec<f32>) -> Result<Self> {
        check_range("spacing of the ground", spacing, 1e-3..1e4, "between 0.001 and 10000 m")?;
        for (what, v) in [("x of the ground's origin", origin.x), ("z of the ground's origin", origin.y)] {
            check_value(what, None, v, v.abs() < 1e6, "finite and below 1e6 m")?;
        }
        for (what, n) in [("knots of the ground along x", size[0]), ("knots of the ground along z", size[1])] {
            check_value(what, None, n as f32, (2..=MAX_KNOTS).contains(&n), "2 to 2^25")?;
        }
        // No overflow: both are below 2^26.
        let knots = size[0] as u64 * size[1] as u64;
        check_value("knots of the ground", None, knots as f32, knots <= 2 * MAX_KNOTS as u64, "at most 2^26 in all")?;
        check_length("heights", heights.len(), size[0] * size[1])?;
        for &h in &heights {
            check_value("height of the ground", None, h, h.abs() < 1e4, "finite and below 10000 m")?;
        }
        Ok(Self { origin, spacing, size, heights: heights.into(), first_heights: Arc::default() })
    }

    /// Ground of several floors. Each continues level for 0.4 m beyond its edges.
    ///
    /// - `origin`, `spacing`, `size`: as in [`HeightField::new`].
    /// - `floors`: heights at each knot, none where there is no ground (m, as many as the product of `size`).
    ///
    /// # Errors
    /// As [`HeightField::new`].
    pub fn with_floors(origin: Vec2, spacing: f32, size: [usize; 2], mut floors: Vec<Vec<f32>>) -> Result<Self> {
        check_length("heights", floors.len(), size[0].saturating_mul(size[1]))?;
        let flat = Self::new(origin, spacing, size, vec![0.0; floors.len()])?;
        let mut fresh: Vec<(usize, f32)> =
            (0..).zip(&floors).flat_map(|(k, own)| own.iter().map(move |h| (k, *h))).collect();
        for _ in 0..(EDGE_M / spacing).ceil().min(MOST_EDGE_KNOTS) as usize {
            for (knot, height) in std::mem::take(&mut fresh) {
                let [x, z] = [knot % size[0], knot / size[0]].map(|n| n.saturating_sub(1)..n + 2);
                for near in z.flat_map(|z| x.clone().filter(|x| *x < size[0]).map(move |x| z * size[0] + x)) {
                    if let Some(own) = floors.get_mut(near)
                        && own.iter().all(|h| (h - height).abs() > ONE_FLOOR_M)
                    {
                        own.push(height);
                        fresh.push((near, height));
                    }
                }
            }
        }
        let heights = floors.concat();
        for &h in &heights {
            check_value("height of the ground", None, h, h.abs() < 1e4, "finite and below 10000 m")?;
        }
        let mut end = 0;
        let ends = floors.iter().map(|own| {
            end += own.len() as u32;
            end
        });
        let first_heights = std::iter::once(0).chain(ends).collect();
        Ok(Self { heights: heights.into(), first_heights, ..flat })
    }

    /// True for ground of several floors.
    pub fn has_floors(&self) -> bool {
        !self.first_heights.is_empty()
    }

    /// True if it is level at height 0 everywhere.
    pub fn is_flat(&self) -> bool {
        self.heights.is_empty()
    }

    /// Adds its content to a hash.
    pub(crate) fn hash(&self, hash: &mut Hash128) {
        let lengths = [self.origin.x, self.origin.y, self.spacing];
        hash.add_bytes(bytemuck::cast_slice(&lengths));
        hash.add_word(self.size[0] as u64);
        hash.add_bytes(bytemuck::cast_slice(&self.heights));
        hash.add_bytes(bytemuck::cast_slice(&self.first_heights));
    }

    /// The ground at a position.
    ///
    /// - `at`: x and z (m).
    /// - `near_m`: height to which the floor is the nearest one (m).
    pub fn ground_at(&self, at: Vec2, near_m: f32) -> GroundPoint {
        if self.is_flat() {
            return GroundPoint::LEVEL;
        }
        let p = (at - self.origin) / self.spacing;
        let ([i, fx, on_x], [k, fz, on_z]) = (cell(p.x, self.size[0]), cell(p.y, self.size[1]));
        let row = |k: usize| [0, 1].map(|next| self.height_of_knot(k * self.size[0] + i as usize + next, near_m));
        let (a, b) = (row(k as usize), row(k as usize + 1));
        let (near, far) = (a[0] + (a[1] - a[0]) * fx, b[0] + (b[1] - b[0]) * fx);
        let along_x = (a[1] - a[0]) * (1.0 - fz) + (b[1] - b[0]) * fz;
        let slope = [along_x * on_x / self.spacing, (far - near) * on_z / self.spacing];
        GroundPoint { height: near + (far - near) * fz, slope }
    }

    /// Height of a knot, on the floor that is nearest to a height (m).
    fn height_of_knot(&self, knot: usize, near_m: f32) -> f32 {
        let Some(&[first, end]) = self.first_heights.get(knot..knot + 2) else { return self.heights[knot] };
        let floors = self.heights[first as usize..end as usize].iter().copied();
        floors.min_by(|a, b| (a - near_m).abs().total_cmp(&(b - near_m).abs())).unwrap_or(near_m)
    }
}

/// The cell along an axis, the fraction within it, and 1 where the place is within the grid.
fn cell(at: f32, knots: usize) -> [f32; 3] {
    let last = (knots - 1) as f32;
    let within = if at > 0.0 { at.min(last) } else { 0.0 };
    let whole = within.floor().min(last - 1.0);
    [whole, within - whole, f32::from(u8::from(at > 0.0 && at < last))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_base::Error;

    #[test]
    fn planes_are_exact_and_continue_level_beyond_the_edge() {
        let plane = |x: f32, z: f32| 0.3 * x - 0.2 * z + 1.0;
        let heights = (0..12).map(|i| plane(1.0 + 0.5 * (i % 4) as f32, -2.0 + 0.5 * (i / 4) as f32)).collect();
        let field = HeightField::new(Vec2::new(1.0, -2.0), 0.5, [4, 3], heights).expect("a field");
        for (x, z) in [(1.2, -1.9), (2.49, -1.01), (1.7, -1.5)] {
            let g = field.ground_at(Vec2::new(x, z), 0.0);
            assert!((g.height - plane(x, z)).abs() < 1e-5, "{g:?}");
            assert!((g.slope[0] - 0.3).abs() < 1e-5 && (g.slope[1] + 0.2).abs() < 1e-5, "{g:?}");
        }
        let beyond = field.ground_at(Vec2::new(9.0, -1.5), 0.0);
        assert!((beyond.height - plane(2.5, -1.5)).abs() < 1e-5 && beyond.slope[0] == 0.0, "{beyond:?}");
        assert!(field.ground_at(Vec2::splat(f32::NAN), 0.0).height.is_finite());
        assert!(std::ptr::eq(field.clone().heights.as_ptr(), field.heights.as_ptr()), "clones share their heights");
    }

    #[test]
    fn refuses_malformed_grids() {
        let new = |spacing, size, n| HeightField::new(Vec2::ZERO, spacing, size, vec![0.0; n]);
        assert!(new(1.0, [3, 2], 6).is_ok());
        assert!(matches!(new(1.0, [3, 2], 5), Err(Error::Length { .. })));
        assert!(matches!(new(0.0, [3, 2], 6), Err(Error::Value { .. })));
        for (size, along) in [([1, 6], "along x is 1"), ([6, 1], "along z is 1")] {
            let e = new(1.0, size, 6).expect_err("too few").to_string();
            assert!(e.contains(along) && e.contains("2 to 2^25"), "{e}");
        }
        let e = new(1.0, [1 << 20, 1 << 20], 6).expect_err("too many knots").to_string();
        assert!(e.contains("at most 2^26"), "{e}");
        let aside = HeightField::new(Vec2::new(0.0, f32::NAN), 1.0, [2, 2], vec![0.0; 4]);
        assert!(matches!(aside, Err(Error::Value { what: "z of the ground's origin", .. })));
        assert_eq!(HeightField::flat().ground_at(Vec2::new(3.0, 4.0), 0.0), GroundPoint::LEVEL);
    }
}
