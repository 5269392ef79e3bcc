//! Grids of a resolution of their own for every state: fine where its values change fast, coarse where they do not.
//!
//! All of them cover the same places as the policy's grid, which is the finest one. A look-ahead finds the place after
//! an action in numbers of the finest grid's rings, angles and heights, once for eight actions, and scales them to the
//! counts of the state where each action ends.

use super::error::PolicyError;
use super::grid::{Spot, TargetGrid, interval};
use super::maths::{angle_of, least, nearest_index};
use super::table::{PolicyTable, SegmentRecord};
use crate::lanes::{LANES, Lanes};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Most cells of one state of an adaptive policy: they are counted in floats.
pub const MAX_STATE_CELLS: usize = 1 << 24;

/// Resolution of one state's values, and where they are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct StateGridRecord {
    /// Rings, angles, heights, and 0. [Limit: at least 2, 2 and 1; not above those of the policy's grid]
    pub counts: [i16; 4],
    /// First of the state's cells in the values and best actions of the policy.
    pub first: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<StateGridRecord>() == 16);

impl StateGridRecord {
    /// - `counts`: rings, angles, heights. [Limit: 4096 each]
    pub fn new(counts: [u32; 3], first: u32) -> Self {
        let [rings, angles, heights] = counts.map(|n| n as i16);
        Self { counts: [rings, angles, heights, 0], first, reserved: 0 }
    }

    /// Rings, angles, heights.
    #[inline]
    pub fn counts(&self) -> [u32; 3] {
        [0, 1, 2].map(|k| self.counts[k].max(0) as u32)
    }

    /// Number of cells.
    #[inline]
    pub fn num_cells(&self) -> usize {
        self.counts().iter().fold(1usize, |all, &n| all.saturating_mul(n as usize))
    }
}

/// Checks that counts are in range and that the states' cells follow each other without gaps.
///
/// - returns the number of cells of all states.
pub(super) fn check_state_grids(grids: &[StateGridRecord], finest: &TargetGrid) -> Result<usize, PolicyError> {
    let mut next = 0usize;
    for (at, g) in grids.iter().enumerate() {
        for ((got, most), least) in g.counts().into_iter().zip(finest.counts()).zip([2, 2, 1]) {
            if got < least || got > most {
                let (got, limit) = (got as usize, most as usize + 1);
                return Err(PolicyError::Index { what: "state grid counts (rings, angles, heights)", at, got, limit });
            }
        }
        if g.counts[3] != 0 || g.reserved != 0 {
            return Err(PolicyError::Index { what: "state grid reserved fields", at, got: 1, limit: 1 });
        }
        if g.first as usize != next {
            let (got, limit) = (g.first as usize, next + 1);
            return Err(PolicyError::Index {
                what: "state grid first cells, which follow each other,",
                at,
                got,
                limit,
            });
        }
        if g.num_cells() > MAX_STATE_CELLS {
            let (got, limit) = (g.num_cells(), MAX_STATE_CELLS + 1);
            return Err(PolicyError::Index { what: "state grid cells", at, got, limit });
        }
        next += g.num_cells();
    }
    Ok(next)
}

impl PolicyTable<'_> {
    /// True where every state has a grid of its own.
    #[inline]
    pub fn is_adaptive(&self) -> bool {
        !self.state_grids.is_empty()
    }

    /// The grid of a state's values and best actions: the policy's own, or a coarser one over the same places.
    /// [Limit: state < num_states]
    #[inline]
    pub fn grid_of(&self, state: u32) -> TargetGrid {
        match self.state_grids.get(state as usize) {
            Some(own) if own.counts() != self.grid.counts() => self.grid.with_counts(own.counts()),
            _ => self.grid,
        }
    }

    /// Values where eight segments end, interpolated in the grids of the states there, with the place's scale.
    ///
    /// - `height`: number of the height in the finest grid, the same for all.
    #[inline(always)]
    pub(super) fn adaptive_values<F: Lanes, const POLAR: bool>(
        &self,
        records: &[&SegmentRecord; LANES],
        spot: &Spot<F>,
        height: f32,
    ) -> F {
        let of = |lane: usize| &self.state_grids[records[lane].end as usize];
        let grids = [of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)];
        let [rings, angles, heights, _] = F::decode(grids.map(|g| &g.counts));
        let firsts = F::from_array(grids.map(|g| f32::from_bits(g.first)));
        let (one, two) = (F::splat(1.0), F::splat(2.0));
        let [finest_rings, finest_angles, finest_heights] = self.grid.counts().map(|n| n as f32);
        let ring_step = (rings - one) / F::splat(finest_rings - 1.0);
        let (ring, ring_ratio) = interval(spot.ring * ring_step, rings - two);
        let corners = Corners { low: ring * angles, angles, ring_ratio, spot, finest_angles };
        if POLAR || finest_heights == 1.0 {
            return self.corner_values::<F, POLAR>(firsts, &corners);
        }
        let height_step = (heights - one) / F::splat(finest_heights - 1.0);
        let (height, height_ratio) = interval(F::splat(height) * height_step, (heights - two).max(F::splat(0.0)));
        let plane = rings * angles;
        let next = (height + one).min(heights - one);
        let low = self.corner_values::<F, POLAR>(firsts, &Corners { low: corners.low + height * plane, ..corners });
        let high = self.corner_values::<F, POLAR>(firsts, &Corners { low: corners.low + next * plane, ..corners });
        low + (high - low) * height_ratio
    }

    /// Values of one height, interpolated between angles and rings.
    #[inline(always)]
    fn corner_values<F: Lanes, const POLAR: bool>(&self, firsts: F, corners: &Corners<'_, F>) -> F {
        let &Corners { low, angles, ring_ratio, spot, finest_angles } = corners;
        let one = F::splat(1.0);
        let high = low + angles;
        let (values, ratio);
        if POLAR {
            let step = angles / F::splat(finest_angles);
            let (angle, angle_ratio) = interval(spot.angle * step, angles - one);
            let next = F::select_lt(angle + one, angles, angle + one, F::splat(0.0));
            let of = |cell: F| F::gather(self.values, 0, firsts, 1, cell)[0];
            (values, ratio) = ([[of(low + angle), of(low + next)], [of(high + angle), of(high + next)]], angle_ratio);
        } else {
            let step = (angles - one) / F::splat(finest_angles - 1.0);
            let (angle, angle_ratio) = interval(spot.angle * step, angles - F::splat(2.0));
            // The next angle stands beside it.
            let of = |cell: F| F::gather(self.values, 1, firsts, 1, cell);
            (values, ratio) = ([of(low + angle), of(high + angle)], angle_ratio);
        }
        let [near, far] = values.map(|[a, b]| a + (b - a) * ratio);
        spot.scale * (near + (far - near) * ring_ratio)
    }
}

/// Where eight lanes read one height.
#[derive(Clone, Copy)]
struct Corners<'a, F> {
    /// First cell of the lower ring.
    low: F,
    /// Angles of each lane's grid.
    angles: F,
    ring_ratio: F,
    spot: &'a Spot<F>,
    finest_angles: f32,
}

impl TargetGrid {
    /// [`Self::nearest_cell`] of the grid with other counts of (rings, angles, heights), without making it.
    pub(super) fn nearest_cell_of(&self, counts: [u32; 3], target: Vec3) -> usize {
        let [rings, angles, heights] = counts;
        let finest = self.counts();
        let step = |n: u32, of: u32| n as f32 / of.max(1) as f32;
        let distance = (target.x * target.x + target.z * target.z).sqrt();
        let ring = least(self.ring_number(distance), (finest[0] - 1) as f32) * step(rings - 1, finest[0] - 1);
        let ring = nearest_index(ring, rings - 1);
        let number = self.angle_number(angle_of(target.x, target.z));
        let angle = if self.is_polar() {
            nearest_index(number * step(angles, finest[1]), angles) % angles
        } else {
            let clamped = number.clamp(0.0, (finest[1] - 1) as f32);
            nearest_index(clamped * step(angles - 1, finest[1] - 1), angles - 1)
        };
        let (height, ratio) = self.height_interval(target.y);
        let height = (height as f32 + ratio) * step(heights - 1, finest[2] - 1);
        ((nearest_index(height, heights - 1) * rings + ring) * angles + angle) as usize
    }
}
