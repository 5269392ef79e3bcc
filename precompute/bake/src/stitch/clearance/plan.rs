//! A unit seen from above: its distance from points on the ground.

/// Distances over the ground from a unit.
#[derive(Clone, Debug)]
pub(in crate::stitch) struct GroundDistances {
    /// Lowest corner of the grid: x and z (m).
    min: [f32; 2],
    /// Squares along x and z.
    size: [usize; 2],
    /// Lower bound of the distance of any point of a square (m, size[0] * size[1]).
    distances: Vec<f32>,
}

impl GroundDistances {
    /// Edge length of a square (m).
    const STEP_M: f32 = 0.08;
    /// Extent of the grid beyond the columns that it is computed from (m).
    const MARGIN_M: f32 = 0.6;

    /// Measures the distance of every square from the columns that a unit touches.
    ///
    /// - `min`, `step`, `size`: lowest corner, edge length and number of the columns along x and z (m).
    /// - `is_touched`: of a column; columns along x are adjacent.
    pub fn new(min: [f32; 2], step: f32, size: [usize; 2], is_touched: impl Fn(usize) -> bool) -> Self {
        let touched: Vec<bool> = (0..size[0] * size[1]).map(is_touched).collect();
        // For a point beside them all, the nearest one is on the rim.
        let is_within = |c: usize| {
            let (x, z) = (c % size[0], c / size[0]);
            let is_inner = x > 0 && z > 0 && x + 1 < size[0] && z + 1 < size[1];
            is_inner && [c - 1, c + 1, c - size[0], c + size[0]].iter().all(|&n| touched[n])
        };
        let middle =
            |c: usize| [min[0] + step * ((c % size[0]) as f32 + 0.5), min[1] + step * ((c / size[0]) as f32 + 0.5)];
        let rim: Vec<_> = (0..touched.len()).filter(|&c| touched[c] && !is_within(c)).map(middle).collect();
        let rows: Vec<&[[f32; 2]]> = rim.chunk_by(|a, b| a[1] == b[1]).collect();
        let low = min.map(|v| v - Self::MARGIN_M);
        let squares = match rim.is_empty() {
            true => [0; 2],
            false => size.map(|n| ((n as f32 * step + 2.0 * Self::MARGIN_M) / Self::STEP_M).ceil() as usize),
        };
        // From the centres to the corners of both.
        let off = std::f32::consts::FRAC_1_SQRT_2 * (Self::STEP_M + step) + 1e-4;
        let distance = |k: usize| {
            let p: [f32; 2] = [
                low[0] + Self::STEP_M * ((k % squares[0]) as f32 + 0.5),
                low[1] + Self::STEP_M * ((k / squares[0]) as f32 + 0.5),
            ];
            let column = [(p[0] - min[0]) / step, (p[1] - min[1]) / step];
            let is_over = (0..2).all(|a| column[a] >= 0.0 && column[a] < size[a] as f32);
            if is_over && touched[column[1] as usize * size[0] + column[0] as usize] {
                return 0.0;
            }
            (least_square(&rows, p).sqrt() - off).max(0.0)
        };
        Self { min: low, size: squares, distances: (0..squares[0] * squares[1]).map(distance).collect() }
    }

    /// Lower bound of the distance of the unit from a place over the ground (m).
    pub fn least_distance(&self, x: f32, z: f32) -> f32 {
        let at = [(x - self.min[0]) / Self::STEP_M, (z - self.min[1]) / Self::STEP_M];
        let out = [(-at[0]).max(at[0] - self.size[0] as f32), (-at[1]).max(at[1] - self.size[1] as f32)];
        if out[0] >= 0.0 || out[1] >= 0.0 {
            // The columns begin at the margin within the grid, which ends less than a square beyond.
            return Self::MARGIN_M + Self::STEP_M * (out[0].max(out[1]) - 1e-3);
        }
        self.distances[at[1] as usize * self.size[0] + at[0] as usize]
    }
}

/// Squared distance of the nearest point; infinite without points (m^2).
///
/// - `rows`: points of one z each; both x and z ascending.
fn least_square(rows: &[&[[f32; 2]]], p: [f32; 2]) -> f32 {
    let mut least = f32::INFINITY;
    // False if no row beyond has a nearer point.
    let mut sample = |row: &&[[f32; 2]]| {
        let k = row.partition_point(|r| r[0] < p[0]);
        let beside = row[k.saturating_sub(1)..row.len().min(k + 1)].iter();
        least = beside.map(|r| (r[0] - p[0]).powi(2) + (r[1] - p[1]).powi(2)).fold(least, f32::min);
        (row[0][1] - p[1]).powi(2) < least
    };
    let (before, after) = rows.split_at(rows.partition_point(|row| row[0][1] < p[1]));
    let _ = before.iter().rev().all(&mut sample);
    let _ = after.iter().all(&mut sample);
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nothing_is_nearer_and_not_much_is_farther(
            touched in prop::collection::vec(any::<bool>(), 35), p in prop::array::uniform2(-2.0f32..2.5)
        ) {
            let (min, step) = ([-0.4f32, 0.2], 0.1);
            let plan = GroundDistances::new(min, step, [7, 5], |c| touched[c]);
            let gap = |c: usize| {
                let low = [min[0] + (c % 7) as f32 * step, min[1] + (c / 7) as f32 * step];
                let apart = |a: usize| (low[a] - p[a]).max(p[a] - low[a] - step).max(0.0);
                apart(0).hypot(apart(1))
            };
            let exact = (0..35).filter(|&c| touched[c]).map(gap).fold(f32::INFINITY, f32::min);
            let found = plan.least_distance(p[0], p[1]);
            prop_assert!(found <= exact + 1e-4, "{} {}", found, exact);
            prop_assert!(exact > 0.4 || found > exact - 0.3, "{} {}", found, exact);
        }

        #[test]
        fn no_point_is_nearer_than_the_nearest_one(
            cells in prop::collection::btree_set((0u8..20, 0u8..20), 0..30), p in prop::array::uniform2(-3.0f32..4.0)
        ) {
            let points: Vec<[f32; 2]> = cells.iter().map(|&(z, x)| [x, z].map(|v| 0.1 * f32::from(v))).collect();
            let rows: Vec<&[[f32; 2]]> = points.chunk_by(|a, b| a[1] == b[1]).collect();
            let apart = |r: &[f32; 2]| (r[0] - p[0]).powi(2) + (r[1] - p[1]).powi(2);
            prop_assert_eq!(least_square(&rows, p), points.iter().map(apart).fold(f32::INFINITY, f32::min));
        }
    }
}
