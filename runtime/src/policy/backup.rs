//! Eight (segment, target) pairs side by side: reward, and where the value after the segment is read.
//!
//! A look-ahead weighs eight actions for one target, an offline sweep one action for eight targets: both are this.

use super::grid::{Place, TargetGrid};
use super::reward::Reward;
use super::table::{PolicyTable, SegmentRecord};
use crate::lanes::{LANES, Lanes};

/// The segments of eight lanes. Fields are loaded where they are used, as they are more than fit the registers.
pub(super) trait Motions<F>: Copy {
    /// Four fields in the order of [`SegmentRecord`]: the displacement, the inner samples, the weights, or the heights
    /// of the inner samples with the discount and the bits of the state at the end.
    fn quarter(self, k: usize) -> [F; 4];
}

/// A segment for each lane.
impl<F: Lanes> Motions<F> for &[&SegmentRecord; LANES] {
    #[inline(always)]
    fn quarter(self, k: usize) -> [F; 4] {
        F::columns([
            &self[0].quarters()[k],
            &self[1].quarters()[k],
            &self[2].quarters()[k],
            &self[3].quarters()[k],
            &self[4].quarters()[k],
            &self[5].quarters()[k],
            &self[6].quarters()[k],
            &self[7].quarters()[k],
        ])
    }
}

/// One segment for all lanes.
impl<F: Lanes> Motions<F> for &SegmentRecord {
    #[inline(always)]
    fn quarter(self, k: usize) -> [F; 4] {
        let [a, b, c, d] = self.quarters()[k];
        [F::splat(a), F::splat(b), F::splat(c), F::splat(d)]
    }
}

/// Targets of eight lanes in the frame of the start.
#[derive(Clone, Copy)]
pub(super) struct Targets<F> {
    pub x: F,
    pub y: F,
    pub z: F,
    /// Kernel of the distance at the start.
    pub start_kernel: F,
}

/// Rewards, and places after the segments. A backup is reward + discount * interpolated value, which has the scale.
#[inline(always)]
pub(super) fn back_up<F: Lanes, const POLAR: bool>(
    grid: &TargetGrid,
    reward: &Reward,
    motions: impl Motions<F>,
    target: &Targets<F>,
) -> (F, Place<F>) {
    let [c, s, x, z] = motions.quarter(0);
    let (dx, dz) = (target.x - x, target.z - z);
    let distance = (dx * dx + dz * dz).sqrt();
    let place = grid.place::<F, POLAR>(c * dx - s * dz, s * dx + c * dz, distance);
    (rewards::<F, POLAR>(reward, motions, target, distance), place)
}

/// See [`Reward`].
#[inline(always)]
fn rewards<F: Lanes, const POLAR: bool>(
    reward: &Reward,
    motions: impl Motions<F>,
    target: &Targets<F>,
    end_distance: F,
) -> F {
    let [x0, z0, x1, z1] = motions.quarter(1);
    let mut first = squared(target.x - x0, target.z - z0);
    let mut second = squared(target.x - x1, target.z - z1);
    if !POLAR {
        let [y0, y1, ..] = motions.quarter(3);
        first = first + (target.y - y0) * (target.y - y0);
        second = second + (target.y - y1) * (target.y - y1);
    }
    let [start_weight, first_weight, second_weight, end_weight] = motions.quarter(2);
    let first = first_weight * reward.kernels(first.sqrt());
    let inner = reward.combined(first, second_weight * reward.kernels(second.sqrt()));
    if !POLAR {
        return inner;
    }
    let end = end_weight * reward.kernels(end_distance);
    reward.combined(inner, reward.combined(start_weight * target.start_kernel, end))
}

#[inline(always)]
fn squared<F: Lanes>(x: F, z: F) -> F {
    x * x + z * z
}

impl PolicyTable<'_> {
    /// Values of one height at a place, interpolated between angles and rings, with the place's scale.
    ///
    /// - `ends`: bits of the states.
    /// - `height_offset`: first cell of the height.
    #[inline(always)]
    pub(super) fn values_at<F: Lanes>(&self, ends: F, place: &Place<F>, height_offset: usize) -> F {
        let angles = self.grid.record().num_angles;
        let low = place.ring * F::splat(self.grid.angles_per_ring());
        let row_len = self.grid.num_cells() as u32;
        let values = &self.values[height_offset..];
        let [near_a, far_a] = F::gather(values, angles as usize, ends, row_len, low + place.angle);
        let [near_b, far_b] = F::gather(values, angles as usize, ends, row_len, low + place.next_angle);
        let near = near_a + (near_b - near_a) * place.angle_ratio;
        let far = far_a + (far_b - far_a) * place.angle_ratio;
        place.scale * (near + (far - near) * place.ring_ratio)
    }
}
