//! Backup of every (segment, cell) pair, computed once and laid out for sweeps; only for segments backed up in this
//! process.

use glam::{Mat4, Vec4};
use rayon::prelude::*;
use throng_core::policy::{Backups, GroundTargets, PolicyTable, SegmentRecord, TargetGrid, nearest_index};
use throng_core::simd::vectorize;

/// Cells processed side by side.
pub(super) const LANES: usize = 8;
/// Most cells of one height, including a spare column, as cells have 16-bit numbers here.
pub(super) const MAX_PLANE: usize = 1 << 16;

/// Dimensions of the rows of values and pairs.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowShape {
    /// Heights of the grid.
    pub heights: usize,
    /// Rings of the grid.
    pub rings: usize,
    /// Angles of the grid.
    pub angles: usize,
}

impl RowShape {
    pub fn new(grid: &TargetGrid) -> Self {
        let r = grid.record();
        Self { heights: r.num_heights as usize, rings: r.num_rings as usize, angles: r.num_angles as usize }
    }

    /// Cells of one height.
    pub fn plane(&self) -> usize {
        self.rings * self.angles
    }

    /// Cells of one height, rounded up to whole lanes.
    pub fn row(&self) -> usize {
        self.plane().next_multiple_of(LANES)
    }

    /// Stride between rings in a row of values: one more than the angles, so that the next angle of any angle is
    /// adjacent; the spare column repeats the first one.
    pub fn stride(&self) -> usize {
        self.angles + 1
    }

    /// Values of one height, spare columns included.
    pub fn value_plane(&self) -> usize {
        self.rings * self.stride()
    }

    /// Values of one state, spare columns included.
    pub fn value_row(&self) -> usize {
        self.heights * self.value_plane()
    }

    /// Copies the cells of one height to a row of values, including the spare column.
    pub fn store(&self, cells: &[f32], values: &mut [f32]) {
        for (from, to) in cells.chunks_exact(self.angles).zip(values.chunks_exact_mut(self.stride())) {
            to[..self.angles].copy_from_slice(from);
            to[self.angles] = from[0];
        }
    }
}

/// Backups of all (segment, cell) pairs: `reward + near * (values at base) + far * (values a ring further)`, each
/// interpolated between two angles. Rows are one segment and height; the geometry is the same at every height.
///
/// 16 bytes a pair: 2 + 2 + 4 + 4 for the geometry, 4 for the reward.
pub(super) struct BackupPairs {
    pub shape: RowShape,
    /// Row of each segment; [`UNUSED`] for segments that are not backed up.
    rows: Vec<u32>,
    /// Index of the lower corner among the values of one height (num_rows * row).
    pub base: Vec<u16>,
    /// Ratio between the angles, in units of 1 / 65535.
    pub angle_ratio: Vec<u16>,
    /// Weight of the nearer ring, including the discount.
    pub near: Vec<f32>,
    /// Weight of the farther ring, including the discount.
    pub far: Vec<f32>,
    /// Rewards (num_rows * heights * row).
    pub reward: Vec<f32>,
    /// State at the end of each segment.
    pub end: Vec<u32>,
}

/// A single pair, extracted.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BackupPair {
    /// Index of the lower corner among the values of all states.
    pub base: u32,
    pub angle_ratio: f32,
    pub near: f32,
    pub far: f32,
    pub reward: f32,
}

/// Row of a segment that is not backed up.
const UNUSED: u32 = u32::MAX;

/// Unit of [`BackupPairs::angle_ratio`].
const RATIO_UNIT: f32 = 1.0 / 65535.0;

impl BackupPairs {
    /// Computes the pairs of some segments, in parallel.
    ///
    /// - `table`: gives grid and reward; its values are not read.
    /// - `backed_up`: segments to back up, possibly repeated.
    pub fn new(table: &PolicyTable, segments: &[SegmentRecord], backed_up: &[u32]) -> Self {
        let shape = RowShape::new(table.grid());
        let mut rows = vec![UNUSED; segments.len()];
        backed_up.iter().for_each(|&s| rows[s as usize] = 0);
        let used: Vec<&SegmentRecord> = rows.iter().zip(segments).filter(|(r, _)| **r == 0).map(|(_, s)| s).collect();
        rows.iter_mut().filter(|r| **r == 0).zip(0..).for_each(|(r, row)| *r = row);
        let (row, num_pairs) = (shape.row(), used.len() * shape.row());
        let mut pairs = Self {
            shape,
            rows,
            base: vec![0; num_pairs],
            angle_ratio: vec![0; num_pairs],
            near: vec![0.0; num_pairs],
            far: vec![0.0; num_pairs],
            reward: vec![0.0; num_pairs * shape.heights],
            end: segments.iter().map(|s| s.end).collect(),
        };
        let centres = CellCentres::new(table, &shape);
        let geometry = pairs.base.par_chunks_mut(row).zip(pairs.angle_ratio.par_chunks_mut(row));
        let weights = pairs.near.par_chunks_mut(row).zip(pairs.far.par_chunks_mut(row));
        let rewards = pairs.reward.par_chunks_mut(row * shape.heights);
        geometry.zip(weights).zip(rewards).zip(used).for_each_init(
            || vec![Backups::default(); row / LANES],
            |backups, ((((base, ratio), (near, far)), reward), segment)| {
                vectorize(
                    #[inline(always)]
                    || {
                        for (&height, rewards) in centres.heights.iter().zip(reward.chunks_exact_mut(row)) {
                            table.back_up_all(segment, height, &centres.ground, backups);
                            let rewards = rewards.as_chunks_mut().0.iter_mut();
                            rewards.zip(&*backups).for_each(|(rewards, b)| *rewards = b.reward);
                        }
                        let stride = (shape.angles + 1) as f32;
                        let base = base.as_chunks_mut::<LANES>().0.iter_mut();
                        let ratio = ratio.as_chunks_mut::<LANES>().0.iter_mut();
                        let weights = near.as_chunks_mut().0.iter_mut().zip(far.as_chunks_mut().0);
                        for (((base, ratio), (near, far)), b) in base.zip(ratio).zip(weights).zip(&*backups) {
                            (*near, *far) = (b.near, b.far);
                            let index = |l: usize| nearest_index(b.ring[l] * stride + b.angle[l], 65535) as u16;
                            *base = std::array::from_fn(index);
                            *ratio = b.angle_ratio.map(|r| nearest_index(r * 65535.0, 65535) as u16);
                        }
                    },
                );
            },
        );
        pairs
    }

    /// Backs up one segment at one height, for every cell.
    ///
    /// - `values`: of the state at the segment's end, at that height (value_plane).
    /// - `out`: receives the backups (row).
    #[inline(always)]
    pub fn back_up(&self, segment: usize, height: usize, values: &[f32], out: &mut [f32]) {
        let (row, segment) = (self.shape.row(), self.rows[segment] as usize);
        let at = segment * row..(segment + 1) * row;
        let (base, _) = self.base[at.clone()].as_chunks::<4>();
        let (ratio, _) = self.angle_ratio[at.clone()].as_chunks::<4>();
        let (near, _) = self.near[at.clone()].as_chunks::<4>();
        let (far, _) = self.far[at].as_chunks::<4>();
        let (reward, _) = self.reward[(segment * self.shape.heights + height) * row..][..row].as_chunks::<4>();
        let (out, _) = out.as_chunks_mut::<4>();
        let stride = self.shape.stride();
        let corners = |base: u16| {
            let v = &values[usize::from(base)..][..stride + 2];
            Vec4::new(v[0], v[1], v[stride], v[stride + 1])
        };
        let geometry = base.iter().zip(ratio).zip(near.iter().zip(far));
        for ((((base, ratio), (near, far)), reward), out) in geometry.zip(reward).zip(out) {
            let lanes = Mat4::from_cols(corners(base[0]), corners(base[1]), corners(base[2]), corners(base[3]));
            let c = lanes.transpose();
            let t = Vec4::from_array(ratio.map(f32::from)) * RATIO_UNIT;
            let low = c.x_axis + (c.y_axis - c.x_axis) * t;
            let high = c.z_axis + (c.w_axis - c.z_axis) * t;
            let value = Vec4::from_array(*near) * low + Vec4::from_array(*far) * high;
            *out = (Vec4::from_array(*reward) + value).to_array();
        }
    }

    /// Extracts one pair.
    pub fn pair(&self, segment: usize, height: usize, cell: usize) -> BackupPair {
        let row = self.shape.row();
        let values = self.end[segment] as usize * self.shape.value_row() + height * self.shape.value_plane();
        let segment = self.rows[segment] as usize;
        let i = segment * row + cell;
        BackupPair {
            base: values as u32 + u32::from(self.base[i]),
            angle_ratio: f32::from(self.angle_ratio[i]) * RATIO_UNIT,
            near: self.near[i],
            far: self.far[i],
            reward: self.reward[(segment * self.shape.heights + height) * row + cell],
        }
    }
}

impl BackupPair {
    /// The pair with its backup scaled by a factor.
    pub fn scaled(self, factor: f32) -> Self {
        Self { near: factor * self.near, far: factor * self.far, reward: factor * self.reward, ..self }
    }

    /// Computes the backup from the values of all states.
    #[inline(always)]
    pub fn back_up(&self, values: &[f32], stride: usize) -> f32 {
        let v = &values[self.base as usize..][..stride + 2];
        let low = v[0] + (v[1] - v[0]) * self.angle_ratio;
        let high = v[stride] + (v[stride + 1] - v[stride]) * self.angle_ratio;
        self.reward + (self.near * low + self.far * high)
    }
}

/// Centres of the cells, in whole lanes; spare ones repeat the first.
struct CellCentres {
    /// Ground targets of one height (row / LANES).
    ground: Vec<GroundTargets>,
    /// Heights (heights).
    heights: Vec<f32>,
}

impl CellCentres {
    fn new(table: &PolicyTable, shape: &RowShape) -> Self {
        let grid = table.grid();
        let mut ground = vec![GroundTargets::default(); shape.row() / LANES];
        for cell in 0..shape.row() {
            let p = grid.cell_centre(if cell < shape.plane() { cell } else { 0 });
            let (lanes, l) = (&mut ground[cell / LANES], cell % LANES);
            (lanes.x[l], lanes.z[l]) = (p.x, p.z);
            lanes.start_kernel[l] = table.reward().kernel((p.x * p.x + p.z * p.z).sqrt());
        }
        let heights = (0..shape.heights).map(|h| grid.cell_centre(h * shape.plane()).y).collect();
        Self { ground, heights }
    }
}
