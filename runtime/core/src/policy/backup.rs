//! Backups of eight (segment, target) pairs at once: the reward, and where the value after the segment is read.
//!
//! Shared by the look-ahead (eight actions, one target) and the offline sweep (one action, eight targets).

use super::grid::{GridCoordinates, StencilLanes, TargetGrid};
use super::reward::Reward;
use super::table::{PolicyTable, STRAIGHT, SegmentRecord};
use throng_base::simd::{LANES, LaneWork, Lanes, dispatch};

/// The segments of eight lanes. Fields are loaded where they are used: together they exceed the registers.
pub(super) trait SegmentLanes<F>: Copy {
    /// Four fields in the order of [`SegmentRecord`]: the displacement, the inner samples, the weights, or the heights
    /// of the inner samples with the discount and the bits of the state at the end.
    fn quarter(self, k: usize) -> [F; 4];
}

/// A segment for each lane.
impl<F: Lanes> SegmentLanes<F> for &[&SegmentRecord; LANES] {
    #[inline(always)]
    fn quarter(self, k: usize) -> [F; 4] {
        F::columns(self.map(|segment| &segment.quarters()[k]))
    }
}

/// One segment for all lanes.
impl<F: Lanes> SegmentLanes<F> for &SegmentRecord {
    #[inline(always)]
    fn quarter(self, k: usize) -> [F; 4] {
        let [a, b, c, d] = self.quarters()[k];
        [F::splat(a), F::splat(b), F::splat(c), F::splat(d)]
    }
}

/// Targets of eight lanes in the frame of the start.
#[derive(Clone, Copy)]
pub(super) struct TargetLanes<F> {
    pub x: F,
    pub y: F,
    pub z: F,
    /// Kernel of the distance at the start.
    pub start_kernel: F,
}

/// Rewards, and where the targets lie after the segments. A backup is reward + discount * interpolated value.
///
/// - `is_bent`: true where segments may be bent ([`SegmentRecord::half_bend`]).
#[inline(always)]
pub(super) fn back_up<F: Lanes, const POLAR: bool>(
    grid: &TargetGrid,
    reward: &Reward,
    motions: impl SegmentLanes<F>,
    target: &TargetLanes<F>,
    is_bent: bool,
) -> (F, GridCoordinates<F>) {
    let [c, s, x, z] = motions.quarter(0);
    let (mut dx, mut dz) = (target.x - x, target.z - z);
    let mut end_distance = squared(dx, dz).sqrt();
    let (mut to_x, mut to_z) = turned_back([c, s], dx, dz);
    let mut target = *target;
    if POLAR && is_bent {
        // [`SegmentRecord::half_bend`]: the target is seen turned back by half of the bend at the start, and again at the end.
        let [most, per_m, ..] = motions.quarter(3);
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let most = most * (end_distance * per_m - one).min(one).max(zero);
        let (aside, straight) = (to_x / to_z.max(to_x.abs()).max(F::splat(f32::MIN_POSITIVE)), F::splat(STRAIGHT));
        let aside = aside - aside.min(straight).max(-straight);
        let tangent = aside.min(most).max(-most);
        let half = tangent / (one + (one + tangent * tangent).sqrt());
        let cos = one / (one + half * half).sqrt();
        let half = [cos, half * cos];
        (target.x, target.z) = turned_back(half, target.x, target.z);
        (dx, dz) = (target.x - x, target.z - z);
        end_distance = squared(dx, dz).sqrt();
        (to_x, to_z) = turned_back([c, s], dx, dz);
        (to_x, to_z) = turned_back(half, to_x, to_z);
    }
    let spot = grid.spot::<F, POLAR>(to_x, to_z, end_distance);
    // The reward, see [`Reward`].
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
    let gain = F::splat(reward.record().gain);
    if !POLAR {
        return (gain * inner, spot);
    }
    let end = end_weight * reward.kernels(end_distance);
    (gain * reward.combined(inner, reward.combined(start_weight * target.start_kernel, end)), spot)
}

/// The ground point (x, z) seen by who has turned by an angle, of its cosine and sine.
#[inline(always)]
fn turned_back<F: Lanes>([c, s]: [F; 2], x: F, z: F) -> (F, F) {
    (c * x - s * z, s * x + c * z)
}

#[inline(always)]
fn squared<F: Lanes>(x: F, z: F) -> F {
    x * x + z * z
}

impl PolicyTable {
    /// Values of one height at a place, interpolated between angles and rings and scaled by `place.scale`.
    ///
    /// - `ends`: states, as the bits of the floats.
    /// - `height_offset`: first cell of the height.
    #[inline(always)]
    pub(super) fn values_at<F: Lanes>(&self, ends: F, place: &StencilLanes<F>, height_offset: usize) -> F {
        let angles = self.grid.record().num_angles;
        let low = place.ring * F::splat(self.grid.angles);
        let row_len = self.grid.num_cells() as u32;
        let values = &self.rows.values[height_offset..];
        let [near_a, far_a] = F::gather(values, angles as usize, ends, row_len, low + place.angle);
        let [near_b, far_b] = F::gather(values, angles as usize, ends, row_len, low + place.next_angle);
        let near = near_a + (near_b - near_a) * place.angle_ratio;
        let far = far_a + (far_b - far_a) * place.angle_ratio;
        place.scale * (near + (far - near) * place.ring_ratio)
    }
}

/// Eight targets on the ground, in the frame of a segment's start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroundTargets {
    /// Coordinate to the left (m).
    pub x: [f32; LANES],
    /// Ahead (m).
    pub z: [f32; LANES],
    /// [`Reward::kernel`] of the distance.
    pub start_kernel: [f32; LANES],
}

/// Coefficients of eight backups over one segment:
/// `reward + near * (value at ring) + far * (value at ring + 1)`, each interpolated between `angle` and the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Backups {
    /// Lower ring, an integer.
    pub ring: [f32; LANES],
    /// Lower angle, an integer.
    pub angle: [f32; LANES],
    /// Ratio between the angles (0 to 1).
    pub angle_ratio: [f32; LANES],
    /// Weight of the nearer ring, with the discount.
    pub near: [f32; LANES],
    /// Weight of the farther ring, with the discount.
    pub far: [f32; LANES],
    /// Reward.
    pub reward: [f32; LANES],
}

impl PolicyTable {
    /// Computes the backups of one segment for many targets, with the arithmetic of the look-ahead.
    ///
    /// - `height`: of all targets above the ground; ignored in a polar grid (m).
    /// - `targets`: within the grid. Targets beyond the length of `out` are ignored.
    pub fn back_up_all(&self, segment: &SegmentRecord, height: f32, targets: &[GroundTargets], out: &mut [Backups]) {
        dispatch(BackUpJob { table: self, segment, height, targets, out });
    }
}

struct BackUpJob<'a> {
    table: &'a PolicyTable,
    segment: &'a SegmentRecord,
    height: f32,
    targets: &'a [GroundTargets],
    out: &'a mut [Backups],
}

impl LaneWork for BackUpJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        if self.table.grid.is_polar() { self.run_of::<F, true>() } else { self.run_of::<F, false>() }
    }
}

impl BackUpJob<'_> {
    #[inline(always)]
    fn run_of<F: Lanes, const POLAR: bool>(self) {
        let (grid, reward) = (&self.table.grid, &self.table.reward);
        let discount = F::splat(self.segment.discount);
        for (t, out) in self.targets.iter().zip(self.out) {
            let start_kernel = F::load(&t.start_kernel);
            let targets = TargetLanes { x: F::load(&t.x), y: F::splat(self.height), z: F::load(&t.z), start_kernel };
            let (rewards, spot) =
                back_up::<F, POLAR>(grid, reward, self.segment, &targets, self.segment.heights[0] > 0.0);
            let place = grid.place::<F, POLAR>(&spot);
            let weight = place.scale * discount;
            place.ring.store(&mut out.ring);
            place.angle.store(&mut out.angle);
            place.angle_ratio.store(&mut out.angle_ratio);
            (weight * (F::splat(1.0) - place.ring_ratio)).store(&mut out.near);
            (weight * place.ring_ratio).store(&mut out.far);
            rewards.store(&mut out.reward);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::tests::{polar, sector};
    use super::super::reward::{
        COMBINE_MAX, COMBINE_SUM, KERNEL_EXPONENTIAL, KERNEL_LINEAR, KERNEL_WITHIN, RewardRecord,
    };
    use super::super::table::{ActionTable, PolicyRecord, PolicySlices};
    use super::*;
    use glam::Vec3;
    use proptest::prelude::*;

    fn grids() -> [TargetGrid; 2] {
        [polar([16, 32], 8.0, 0.25), sector([10, 9, 4], 0.5)]
    }

    proptest! {
        #[test]
        fn lanes_agree_with_the_scalar_definition(
            turn in -3.0f32..3.0, inner in prop::array::uniform4(-1.0f32..1.0), step in prop::array::uniform2(-1.0f32..1.0),
            places in prop::array::uniform8((-2.0f32..2.0, -2.0f32..2.0)), bend in 0.0f32..1.0, sum in any::<bool>(), y in 1.0f32..1.8,
            kernel in prop::sample::select(vec![KERNEL_EXPONENTIAL, KERNEL_WITHIN, KERNEL_LINEAR]),
        ) {
            for grid in grids() {
                let polar = grid.is_polar();
                let outer = if polar { 0.3 } else { 0.0 };
                let segment = SegmentRecord {
                    displacement: [turn.cos(), turn.sin(), step[0], step[1]],
                    inner,
                    weights: [outer, 0.4, 0.5, outer],
                    heights: [bend, 1.5],
                    discount: 0.9,
                    end: 0,
                };
                let combine = if sum { COMBINE_SUM } else { COMBINE_MAX };
                let reward = RewardRecord { offset: 0.2, gain: -1.5, ..RewardRecord::new(combine, kernel, 0.7) };
                let record = PolicyRecord {
                    grid: *grid.record(), reward, num_states: 1, num_segments: 1, num_choices: 1, discount: 0.99,
                    epsilon: 1e-4, ..PolicyRecord::default()
                };
                let values = vec![0.0; grid.num_cells()];
                let best = vec![0; grid.num_cells()];
                let slices = PolicySlices { segments: (&[segment]).into(), values: (&values).into(), best: (&best).into(), ..PolicySlices::default() };
                let actions = ActionTable::new(&[0, 1], &[0], &[0.0], 1).expect("one action");
                let table = PolicyTable::new(&record, actions, slices).expect("sound");
                let kernel = |(x, z): (f32, f32)| table.reward().kernel((x * x + z * z).sqrt());
                let targets =
                    GroundTargets { x: places.map(|p| p.0), z: places.map(|p| p.1), start_kernel: places.map(kernel) };
                let mut out = [Backups::default()];
                table.back_up_all(&segment, y, &[targets], &mut out);
                for (l, &place) in places.iter().enumerate() {
                    let target = Vec3::new(place.0, y, place.1);
                    let (seen, [x, z, distance]) = table.target_along(0, target);
                    let s = grid.stencil(x, z);
                    prop_assert_eq!((out[0].ring[l] as u32, out[0].angle[l] as u32), (s.ring, s.angle));
                    let weight = s.scale * segment.discount;
                    let of = if polar { Reward::of_segment::<true> } else { Reward::of_segment::<false> };
                    let expected = of(table.reward(), &segment, seen, kernel(place), distance);
                    for (got, want) in [
                        (out[0].angle_ratio[l], s.angle_ratio),
                        (out[0].near[l], weight * (1.0 - s.ring_ratio)),
                        (out[0].far[l], weight * s.ring_ratio),
                        (out[0].reward[l], expected),
                    ] {
                        prop_assert!((got - want).abs() < 2e-6, "lane {}: {} {}", l, got, want);
                    }
                }
            }
        }
    }
}
