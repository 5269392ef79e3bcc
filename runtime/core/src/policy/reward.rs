//! The reward of an action, computed from four samples of its motion; offline and online use the same function.

use super::maths::{exp_neg, greatest};
use super::table::SegmentRecord;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::f32::consts::LOG2_E;
use throng_base::Result;
use throng_base::error::{check_index, check_value};
use throng_base::simd::{Functions, Lanes};

/// [`RewardRecord::combine`]: the weighted samples are added.
pub const COMBINE_SUM: u32 = 0;
/// [`RewardRecord::combine`]: the largest weighted sample counts (Lee and Lee 2004, equations 2 and 5).
pub const COMBINE_MAX: u32 = 1;
/// [`RewardRecord::kernel`]: exp(-distance / scale), as in Lee and Lee (2004), equation 5.
pub const KERNEL_EXPONENTIAL: u32 = 0;
/// [`RewardRecord::kernel`]: 1 up to `scale`, 0 beyond: the impulsive signal of Lee and Lee (2004), equation 2 and 6.
pub const KERNEL_WITHIN: u32 = 1;
/// [`RewardRecord::kernel`]: 1 - distance / scale, 0 from `scale` on.
pub const KERNEL_LINEAR: u32 = 2;

/// A reward as it is stored: how distances to samples become a number.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct RewardRecord {
    /// [`COMBINE_SUM`] or [`COMBINE_MAX`].
    pub combine: u32,
    /// [`KERNEL_EXPONENTIAL`], [`KERNEL_WITHIN`] or [`KERNEL_LINEAR`].
    pub kernel: u32,
    /// See the kernels (m, > 0).
    pub scale: f32,
    /// Distance at which a kernel is largest; kernels take the difference from it (m, >= 0).
    pub offset: f32,
    /// Factor on the whole reward: 1, or negative to reward distance instead of nearness.
    pub gain: f32,
    /// Height of the target on a space-time grid, where a target's Y is the time left (m).
    pub height: f32,
    /// Cost of a transition: the value of an action is multiplied by `exp(-transition_cost * distance^2)`, for the
    /// distance between the frame it leaves and the frame it goes on from (1/rad^2, >= 0; 0 where gain is negative).
    /// Acceleration grows with the distance, and one far transition is worse than two near ones.
    pub transition_cost: f32,
    /// 1 if actions have distances of their own ([`super::PolicySlices::errors`]), 0 if those of the motion graph count.
    pub own_errors: u32,
}
const _: () = assert!(size_of::<RewardRecord>() == 32);

impl RewardRecord {
    /// A reward with offset 0 and gain 1, where transitions cost nothing.
    pub fn new(combine: u32, kernel: u32, scale: f32) -> Self {
        Self { combine, kernel, scale, offset: 0.0, gain: 1.0, height: 0.0, transition_cost: 0.0, own_errors: 0 }
    }
}

/// A checked reward.
///
/// An action's reward for a target is the gain times the sum, or the largest, of `weight * kernel(distance)` over four
/// samples of its motion: at its start, two within, and at its end (see [`super::SegmentRecord`]). Weights contain
/// everything that does not depend on the target: the discount, the time that a sample stands for, the force of a blow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reward {
    record: RewardRecord,
    inverse_scale: f32,
    /// Exponent of 2 in the exponential kernel (1/m).
    exponent_per_metre: f32,
}

impl Reward {
    /// Checks a stored reward.
    ///
    /// # Errors
    /// [`throng_base::Error`] for an unknown `combine` or `kernel`, a scale that is not positive, or numbers out of range.
    pub fn new(record: RewardRecord) -> Result<Self> {
        for (what, got, kinds) in [("reward combine", record.combine, 2), ("reward kernel", record.kernel, 3)] {
            check_index(what, None, got as usize, kinds)?;
        }
        check_index("reward own errors", None, record.own_errors as usize, 2)?;
        let scale = record.scale;
        check_value("reward scale", None, scale, scale > 1e-6 && scale < 1e6, "between 1e-6 and 1e6")?;
        for (what, got, low) in [
            ("reward offset", record.offset, 0.0),
            ("reward gain", record.gain, -1e3),
            ("reward height", record.height, -1e3),
        ] {
            check_value(what, None, got, (low..=1e3).contains(&got), "at most 1000, offsets from 0")?;
        }
        let cost = record.transition_cost;
        let good = (0.0..=1e3).contains(&cost) && (cost == 0.0 || record.gain > 0.0);
        check_value("reward transition cost", None, cost, good, "0 to 1000, and 0 where the gain is not positive")?;
        let inverse_scale = record.scale.recip();
        Ok(Self { record, inverse_scale, exponent_per_metre: -LOG2_E * inverse_scale })
    }

    /// The reward as it is stored.
    #[inline(always)]
    pub fn record(&self) -> &RewardRecord {
        &self.record
    }

    /// Kernel of the distance of one sample, before its weight.
    #[inline(always)]
    pub fn kernel(&self, distance: f32) -> f32 {
        let ratio = (distance - self.record.offset).abs() * self.inverse_scale;
        match self.record.kernel {
            KERNEL_EXPONENTIAL => exp_neg(ratio),
            KERNEL_LINEAR => greatest(1.0 - ratio, 0.0),
            _ if ratio <= 1.0 => 1.0,
            _ => 0.0,
        }
    }

    /// [`Self::kernel`] of eight lanes.
    #[inline(always)]
    pub(super) fn kernels<F: Lanes>(&self, distance: F) -> F {
        let distance = (distance - F::splat(self.record.offset)).abs();
        if self.record.kernel == KERNEL_EXPONENTIAL {
            return (distance * F::splat(self.exponent_per_metre)).exp2_neg();
        }
        let ratio = distance * F::splat(self.inverse_scale);
        if self.record.kernel == KERNEL_LINEAR {
            return (F::splat(1.0) - ratio).max(F::splat(0.0));
        }
        F::select_lt(F::splat(1.0), ratio, F::splat(0.0), F::splat(1.0))
    }

    /// Factor on an action's score after a transition, see [`RewardRecord::transition_cost`].
    ///
    /// - `distance`: between the frames it joins (rad, >= 0).
    #[inline(always)]
    pub fn after_transition(&self, distance: f32) -> f32 {
        exp_neg(self.record.transition_cost * (distance * distance))
    }

    /// [`Self::after_transition`] of eight lanes.
    #[inline(always)]
    pub(super) fn after_transitions<F: Lanes>(&self, distance: F) -> F {
        (distance * distance * F::splat(-LOG2_E * self.record.transition_cost)).exp2_neg()
    }

    /// [`Self::combine`] of eight lanes.
    #[inline(always)]
    pub(super) fn combined<F: Lanes>(&self, a: F, b: F) -> F {
        if self.record.combine == COMBINE_SUM { a + b } else { a.max(b) }
    }

    /// The reward of a segment for a target in the frame of its start.
    ///
    /// - `POLAR`: false where heights count, as in a cylinder grid; the samples at the start and end are ignored then.
    /// - `start_kernel`: [`Self::kernel`] of the target's distance at the start.
    /// - `end_distance`: of the target from the segment's end (m).
    #[inline(always)]
    pub fn of_segment<const POLAR: bool>(
        &self,
        segment: &SegmentRecord,
        target: Vec3,
        start_kernel: f32,
        end_distance: f32,
    ) -> f32 {
        let sample = |k: usize| {
            let (dx, dz) = (target.x - segment.inner[2 * k], target.z - segment.inner[2 * k + 1]);
            let dy = if POLAR { 0.0 } else { target.y - segment.heights[k] };
            segment.weights[1 + k] * self.kernel((dx * dx + dz * dz + dy * dy).sqrt())
        };
        let inner = self.combine(sample(0), sample(1));
        if !POLAR {
            return self.record.gain * inner;
        }
        let end = segment.weights[3] * self.kernel(end_distance);
        self.record.gain * self.combine(inner, self.combine(segment.weights[0] * start_kernel, end))
    }

    /// Combines two weighted samples.
    #[inline(always)]
    fn combine(&self, a: f32, b: f32) -> f32 {
        if self.record.combine == COMBINE_SUM { a + b } else { greatest(a, b) }
    }
}
