//! Values of one state, fitted to a coarser grid.

use super::axis::{Resolution, resolutions};
use throng_core::policy::TargetGrid;

/// Possible grids of a state: every combination of the axes' counts.
pub(super) struct GridShapes {
    /// Resolutions of angles, rings and heights, finest first.
    axes: [Vec<Resolution>; 3],
    finest: [usize; 3],
}

/// Scratch memory for a state's values, from one axis to the next.
#[derive(Default)]
pub(super) struct FitScratch {
    stages: [Vec<f32>; 3],
}

impl GridShapes {
    pub fn new(grid: &TargetGrid) -> Self {
        let [rings, angles, heights] = grid.counts();
        let axes =
            [resolutions(angles, 2, grid.is_polar()), resolutions(rings, 2, false), resolutions(heights, 1, false)];
        Self { axes, finest: [angles, rings, heights].map(|n| n as usize) }
    }

    /// A single shape: (rings, angles, heights), none above those of the grid.
    pub fn single(grid: &TargetGrid, counts: [u32; 3]) -> Self {
        let [rings, angles, heights] = grid.counts();
        let one = |k: usize, finest, around| vec![Resolution::new(counts[k], finest, around)];
        let axes = [one(1, angles, grid.is_polar()), one(0, rings, false), one(2, heights, false)];
        Self { axes, finest: [angles, rings, heights].map(|n| n as usize) }
    }

    /// Number of shapes.
    pub fn len(&self) -> usize {
        self.axes.iter().map(Vec::len).product()
    }

    /// Resolutions of a shape: angles, rings, heights.
    fn resolutions(&self, shape: usize) -> [&Resolution; 3] {
        let [_, rings, heights] = self.axes.each_ref().map(Vec::len);
        [
            &self.axes[0][shape / (rings * heights)],
            &self.axes[1][shape / heights % rings],
            &self.axes[2][shape % heights],
        ]
    }

    /// Counts of a shape: rings, angles, heights.
    pub fn counts(&self, shape: usize) -> [u32; 3] {
        let [angles, rings, heights] = self.resolutions(shape).map(|r| r.count);
        [rings, angles, heights]
    }

    /// Number of cells of a shape.
    pub fn num_cells(&self, shape: usize) -> usize {
        self.counts(shape).iter().map(|&n| n as usize).product()
    }

    /// Sums of the squared errors of all shapes over the finest cells (len()).
    ///
    /// - `values`: of a state on the finest grid.
    pub fn errors(&self, values: &[f32], scratch: &mut FitScratch, out: &mut [f64]) {
        let [_, rings, heights] = self.axes.each_ref().map(Vec::len);
        let [a, b, c] = &mut scratch.stages;
        for (i, by_angle) in self.axes[0].iter().enumerate() {
            by_angle.interpolation.apply(values, 1, a);
            for (j, by_ring) in self.axes[1].iter().enumerate() {
                by_ring.interpolation.apply(a, self.finest[0], b);
                for (k, by_height) in self.axes[2].iter().enumerate() {
                    by_height.interpolation.apply(b, self.finest[0] * self.finest[1], c);
                    let squares = c.iter().zip(values).map(|(s, v)| f64::from((s - v) * (s - v)));
                    out[(i * rings + j) * heights + k] = squares.sum();
                }
            }
        }
        // The finest grid holds the values themselves.
        if self.counts(0) == [self.finest[1], self.finest[0], self.finest[2]].map(|n| n as u32) {
            out[0] = 0.0;
        }
    }

    /// Least-squares values of a shape's cells; unchanged for the finest.
    pub fn fit(&self, shape: usize, values: &[f32]) -> Vec<f32> {
        let [by_angle, by_ring, by_height] = self.resolutions(shape);
        let mut fitted = values.to_vec();
        let mut inner = 1;
        for (resolution, finest) in [by_angle, by_ring, by_height].into_iter().zip(self.finest) {
            if resolution.count as usize != finest {
                let mut out = Vec::new();
                resolution.fit.apply(&fitted, inner, &mut out);
                fitted = out;
            }
            inner *= resolution.count as usize;
        }
        fitted
    }
}
