//! Eight (segment, target) pairs side by side: reward, and where the value after the segment is read.
//!
//! A look-ahead weighs eight actions for one target, an offline sweep one action for eight targets: both are this.

use super::grid::{Place, TargetGrid};
use super::reward::Reward;
use super::table::{PolicyTable, SegmentRecord};
use crate::lanes::{LANES, Lanes};

/// The segments of eight lanes, field by field as in [`SegmentRecord`].
#[derive(Clone, Copy)]
pub(super) struct Motion<F> {
    displacement: [F; 4],
    inner: [F; 4],
    weights: [F; 4],
    /// Heights of the two inner samples, the discount, and the bits of the state at the end.
    rest: [F; 4],
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

/// What the backup of eight lanes needs: `reward + discount * place.scale * interpolated value`.
pub(super) struct Backup<F> {
    pub reward: F,
    pub place: Place<F>,
}

impl<F: Lanes> Motion<F> {
    /// A segment for each lane.
    #[inline(always)]
    pub fn of_each(records: &[&SegmentRecord; LANES]) -> Self {
        let quarter = |k: usize| records.map(|r| &bytemuck::cast_ref::<SegmentRecord, [[f32; 4]; 4]>(r)[k]);
        Self {
            displacement: F::columns(quarter(0)),
            inner: F::columns(quarter(1)),
            weights: F::columns(quarter(2)),
            rest: F::columns(quarter(3)),
        }
    }

    /// One segment for all lanes.
    #[inline(always)]
    pub fn of_all(record: &SegmentRecord) -> Self {
        Self::of_each(&[record; LANES])
    }

    /// Discount to the power of the frames.
    #[inline(always)]
    pub fn discount(&self) -> F {
        self.rest[2]
    }

    /// State at the end, as bits.
    #[inline(always)]
    pub fn end(&self) -> F {
        self.rest[3]
    }

    /// Rewards, and places after the segments.
    #[inline(always)]
    pub fn back_up<const POLAR: bool>(&self, grid: &TargetGrid, reward: &Reward, target: &Targets<F>) -> Backup<F> {
        let [c, s, x, z] = self.displacement;
        let (dx, dz) = (target.x - x, target.z - z);
        let distance = (dx * dx + dz * dz).sqrt();
        let place = grid.place::<F, POLAR>(c * dx - s * dz, s * dx + c * dz, distance);
        Backup { reward: self.reward::<POLAR>(reward, target, distance), place }
    }

    /// See [`Reward`].
    #[inline(always)]
    fn reward<const POLAR: bool>(&self, reward: &Reward, target: &Targets<F>, end_distance: F) -> F {
        let first = self.sample::<POLAR>(reward, target, self.inner[0], self.rest[0], self.inner[1]);
        let second = self.sample::<POLAR>(reward, target, self.inner[2], self.rest[1], self.inner[3]);
        let inner = reward.combined(self.weights[1] * first, self.weights[2] * second);
        if !POLAR {
            return inner;
        }
        let end = self.weights[3] * reward.kernels(end_distance);
        reward.combined(inner, reward.combined(self.weights[0] * target.start_kernel, end))
    }

    /// Kernel of the distance to an inner sample.
    #[inline(always)]
    fn sample<const POLAR: bool>(&self, reward: &Reward, target: &Targets<F>, x: F, y: F, z: F) -> F {
        let (dx, dz) = (target.x - x, target.z - z);
        let ground = dx * dx + dz * dz;
        if POLAR {
            return reward.kernels(ground.sqrt());
        }
        let dy = target.y - y;
        reward.kernels((ground + dy * dy).sqrt())
    }
}

impl PolicyTable<'_> {
    /// Values of one height at a place, interpolated between angles and rings, with the place's scale.
    ///
    /// - `ends`: bits of the states.
    /// - `height_offset`: first cell of the height.
    #[inline(always)]
    pub(super) fn values_at<F: Lanes>(&self, ends: F, place: &Place<F>, height_offset: usize) -> F {
        let angles = self.grid.record().num_angles;
        let low = place.ring * F::splat(angles as f32);
        let row_len = self.grid.num_cells() as u32;
        let values = &self.values[height_offset..];
        let [near_a, far_a] = F::gather(values, angles as usize, ends, row_len, low + place.angle);
        let [near_b, far_b] = F::gather(values, angles as usize, ends, row_len, low + place.next_angle);
        let near = near_a + (near_b - near_a) * place.angle_ratio;
        let far = far_a + (far_b - far_a) * place.angle_ratio;
        place.scale * (near + (far - near) * place.ring_ratio)
    }
}
