//! Locates ground positions in a grid: rings, angles and the interpolation weights between them.

use super::super::maths::{angle_of, greatest, least, split_interval};
use super::TargetGrid;
use std::f32::consts::{PI, TAU};
use throng_base::simd::{Functions, Lanes};

/// Bilinear weights of a ground position between cells.
///
/// The corners are (ring, angle), (ring, next angle), (ring + 1, angle), (ring + 1, next angle). All weights are
/// multiplied by `scale`, which is 1 within the grid and falls beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    /// Lower ring (<= num_rings - 2).
    pub ring: u32,
    /// Lower angle.
    pub angle: u32,
    /// Upper angle: the next one, which is 0 after the last one of a polar grid.
    pub next_angle: u32,
    /// Ratio between the rings (0 to 1).
    pub ring_ratio: f32,
    /// Ratio between the angles (0 to 1).
    pub angle_ratio: f32,
    /// Factor on the interpolated value (0 to 1).
    pub scale: f32,
}

impl Stencil {
    /// Interpolates in the plane of one height.
    ///
    /// - `plane`: values of the cells of that height (num_rings * num_angles).
    #[inline(always)]
    pub fn interpolate(&self, plane: &[f32], num_angles: u32) -> f32 {
        let low = (self.ring * num_angles) as usize;
        let high = low + num_angles as usize;
        let (a, b) = (self.angle as usize, self.next_angle as usize);
        let near = plane[low + a] + (plane[low + b] - plane[low + a]) * self.angle_ratio;
        let far = plane[high + a] + (plane[high + b] - plane[high + a]) * self.angle_ratio;
        self.scale * (near + (far - near) * self.ring_ratio)
    }
}

/// Eight positions in grid coordinates (rings and angles, with fractions), clamped to the grid.
#[derive(Clone, Copy)]
pub(in crate::policy) struct GridCoordinates<F> {
    /// Ring coordinate (0 to num_rings - 1).
    pub ring: F,
    /// Angle coordinate (0 to num_angles over the full circle, else to num_angles - 1).
    pub angle: F,
    /// Factor on the interpolated value.
    pub scale: F,
}

/// [`Stencil`]s of eight lanes; rings and angles are integer-valued.
#[derive(Clone, Copy)]
pub(in crate::policy) struct StencilLanes<F> {
    pub ring: F,
    pub angle: F,
    pub next_angle: F,
    pub ring_ratio: F,
    pub angle_ratio: F,
    pub scale: F,
}

impl TargetGrid {
    /// Bilinear weights at a ground position.
    #[inline]
    pub fn stencil(&self, x: f32, z: f32) -> Stencil {
        let distance = (x * x + z * z).sqrt();
        if self.is_polar() { self.stencil_at::<true>(x, z, distance) } else { self.stencil_at::<false>(x, z, distance) }
    }

    /// [`Self::stencil`] without branches, for loops over lanes.
    ///
    /// - `POLAR`: must be [`Self::is_polar`].
    /// - `distance`: length of (x, z).
    #[inline(always)]
    pub fn stencil_at<const POLAR: bool>(&self, x: f32, z: f32, distance: f32) -> Stencil {
        let r = &self.record;
        let ring_number = least(self.ring_number(distance), (r.num_rings - 1) as f32);
        let (ring, ring_ratio) = split_interval(ring_number, r.num_rings - 2);
        let mut beyond = greatest(distance - self.radius, 0.0);
        let number = self.angle_number(angle_of(x, z));
        let (angle, next_angle, angle_ratio);
        if POLAR {
            (angle, angle_ratio) = split_interval(number, r.num_angles - 1);
            next_angle = if angle + 1 == r.num_angles { 0 } else { angle + 1 };
        } else {
            let clamped = least(greatest(number, 0.0), (r.num_angles - 1) as f32);
            beyond += greatest(r.ring_start - distance, 0.0) + (number - clamped).abs() * r.angle_spacing * distance;
            (angle, angle_ratio) = split_interval(clamped, r.num_angles - 2);
            next_angle = angle + 1;
        }
        let u = beyond * self.inverse_falloff;
        let scale = (1.0 + u + 0.5 * u * u).recip();
        Stencil { ring, angle, next_angle, ring_ratio, angle_ratio, scale }
    }

    /// Locates eight positions.
    ///
    /// - `POLAR`: must be [`Self::is_polar`].
    /// - `distance`: length of (x, z).
    #[inline(always)]
    pub(in crate::policy) fn spot<F: Lanes, const POLAR: bool>(&self, x: F, z: F, distance: F) -> GridCoordinates<F> {
        let r = &self.record;
        let zero = F::splat(0.0);
        let ring = self.ring_numbers(distance).min(F::splat(self.last_ring));
        let mut beyond = (distance - F::splat(self.radius)).max(zero);
        let from_ahead = F::angle_from_ahead(x, z);
        let angle;
        if POLAR {
            let count = F::splat(self.angles);
            let number = from_ahead * F::splat(self.angles_per_radian);
            angle = F::select_lt(x, zero, count - number, number).min(count);
        } else {
            let half = 0.5 * (self.angles - 1.0);
            let (pi, turn) = (F::splat(PI), F::splat(TAU));
            let middle = F::splat(r.angle_start + half * r.angle_spacing);
            let from_middle = F::select_lt(x, zero, -from_ahead, from_ahead) - middle;
            let wrapped = F::select_lt(pi, from_middle, from_middle - turn, from_middle);
            let wrapped = F::select_lt(wrapped, -pi, wrapped + turn, wrapped);
            let number = wrapped * F::splat(self.angles_per_radian) + F::splat(half);
            angle = number.max(zero).min(F::splat(self.angles - 1.0));
            let aside = (number - angle).abs() * F::splat(r.angle_spacing) * distance;
            beyond = beyond + ((F::splat(r.ring_start) - distance).max(zero) + aside);
        }
        let u = beyond * F::splat(self.inverse_falloff);
        let scale = F::splat(1.0) / (F::splat(1.0) + u + F::splat(0.5) * u * u);
        GridCoordinates { ring, angle, scale }
    }

    /// [`Self::stencil`] for eight lanes.
    ///
    /// - `POLAR`: must be [`Self::is_polar`].
    #[inline(always)]
    pub(in crate::policy) fn place<F: Lanes, const POLAR: bool>(&self, spot: &GridCoordinates<F>) -> StencilLanes<F> {
        let [last_ring, last_angle] = self.last_intervals;
        let (ring, ring_ratio) = interval(spot.ring, F::splat(last_ring));
        let (angle, angle_ratio) = interval(spot.angle, F::splat(last_angle));
        let next = angle + F::splat(1.0);
        let next_angle = if POLAR { F::select_lt(next, F::splat(self.angles), next, F::splat(0.0)) } else { next };
        StencilLanes { ring, angle, next_angle, ring_ratio, angle_ratio, scale: spot.scale }
    }

    /// [`Self::ring_number`] for eight lanes.
    #[inline(always)]
    fn ring_numbers<F: Lanes>(&self, distance: F) -> F {
        let r = &self.record;
        let d = (distance - F::splat(r.ring_start)).max(F::splat(0.0));
        let under_root = F::splat(self.ring_root[0]) + F::splat(self.ring_root[1]) * d;
        (d + d) / (F::splat(r.ring_spacing) + under_root.sqrt())
    }

    /// Ring coordinate at a distance, with fraction; 0 within the first ring, not clamped outwards.
    #[inline(always)]
    pub(in crate::policy) fn ring_number(&self, distance: f32) -> f32 {
        let r = &self.record;
        let d = greatest(distance - r.ring_start, 0.0);
        2.0 * d / (r.ring_spacing + (r.ring_spacing * r.ring_spacing + 4.0 * r.ring_growth * d).sqrt())
    }

    /// Angle coordinate of an angle in -pi..=pi, with fraction: 0..=num_angles in a polar grid, unbounded elsewhere.
    #[inline(always)]
    pub(in crate::policy) fn angle_number(&self, angle: f32) -> f32 {
        let r = &self.record;
        if self.is_polar() {
            let t = angle * self.angles_per_radian;
            let t = if t < 0.0 { t + r.num_angles as f32 } else { t };
            least(t, r.num_angles as f32)
        } else {
            // Measured from the middle of the sector, so that the seam is opposite to it.
            let half = 0.5 * (r.num_angles - 1) as f32;
            let from_middle = angle - (r.angle_start + half * r.angle_spacing);
            let wrapped = if from_middle > PI { from_middle - TAU } else { from_middle };
            let wrapped = if wrapped < -PI { wrapped + TAU } else { wrapped };
            wrapped * self.angles_per_radian + half
        }
    }
}

/// [`split_interval`] for eight lanes.
#[inline(always)]
pub(in crate::policy) fn interval<F: Lanes>(t: F, last: F) -> (F, F) {
    let i = (t - F::splat(0.5)).max(F::splat(0.0)).round().min(last);
    (i, t - i)
}
