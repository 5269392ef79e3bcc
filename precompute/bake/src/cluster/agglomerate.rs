//! Complete linkage of any number of frames, in bounded memory.

use super::neighbours::{BoundedDistance, FrameSpace};
use super::{linkage, tree::ClusterItem};
use crate::features::projection::{DIMS, ProjectedPoint};

/// Near pairs a frame that may be held in memory, about 36 bytes each, within the limits below.
const PAIRS_A_FRAME: usize = 128;
const FEW_PAIRS: usize = 100_000;
const MANY_PAIRS: usize = 6_000_000;
/// Most near pairs of a number of frames that may be held in memory.
pub(super) fn max_pairs(num_frames: usize) -> usize {
    (PAIRS_A_FRAME * num_frames).clamp(FEW_PAIRS, MANY_PAIRS)
}

/// Most halvings of the height before items are split.
const MAX_HALVINGS: u32 = 6;
/// Iterations of two-means.
const ROUNDS: usize = 10;

/// Merges frames of one class while the distance of any two frames of a group stays below `limit`.
///
/// - `frames`: ascending.
/// - `max_pairs`: most near pairs in memory.
///
/// If there are few enough near pairs, all are merged at once. Otherwise near pairs of half the limit are merged first:
/// complete linkage merges by rising distance anyway, and fewer items remain. If even a small part of the limit has too
/// many pairs, items are split in two by k-means, each half is merged, and then the remainders of both; only this can
/// give other groups than complete linkage as a whole.
pub(super) fn agglomerate(space: &FrameSpace, frames: &[u32], limit: f32, max_pairs: usize) -> Vec<ClusterItem> {
    let items = frames.iter().map(|&f| ClusterItem::single(f)).collect();
    Agglomeration { space, max_pairs }.run(items, limit, MAX_HALVINGS)
}

struct Agglomeration<'a> {
    space: &'a FrameSpace<'a>,
    max_pairs: usize,
}

impl Agglomeration<'_> {
    fn run(&self, items: Vec<ClusterItem>, limit: f32, halvings: u32) -> Vec<ClusterItem> {
        let by_halves = |items| match halvings {
            0 => Err(items),
            _ => self.merge(self.run(items, limit / 2.0, halvings - 1), limit),
        };
        self.merge(items, limit).or_else(by_halves).unwrap_or_else(|items| {
            let [mut items, right] = self.split(items).map(|half| self.run(half, limit, 0));
            items.extend(right);
            // Items that still have too many near pairs stay unmerged.
            self.merge(items, limit).unwrap_or_else(|items| items)
        })
    }

    /// Complete linkage up to `limit`; returns the items unchanged if there are too many near pairs.
    fn merge(&self, items: Vec<ClusterItem>, limit: f32) -> Result<Vec<ClusterItem>, Vec<ClusterItem>> {
        match self.space.near_pairs(&items, limit, self.max_pairs) {
            Some(near) => Ok(linkage::merge_items(items, near, &BoundedDistance { space: self.space, limit })),
            None => Err(items),
        }
    }

    /// Splits items by two-means, started at the ends of the widest dimension. Neither half is empty.
    fn split(&self, items: Vec<ClusterItem>) -> [Vec<ClusterItem>; 2] {
        let point = |i: &ClusterItem| self.space.points[i.frames[0] as usize];
        let mut points: Vec<(ProjectedPoint, ClusterItem)> = items.into_iter().map(|i| (point(&i), i)).collect();
        points.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]).then(a.1.frames[0].cmp(&b.1.frames[0])));
        let mut means = [points[0].0, points[points.len() - 1].0];
        for _ in 0..ROUNDS {
            let mut sums = [([0.0; DIMS], 0.0); 2];
            for (p, _) in &points {
                let (sum, n) = &mut sums[usize::from(is_second(p, &means))];
                sum.iter_mut().zip(p).for_each(|(s, p)| *s += f64::from(*p));
                *n += 1.0;
            }
            for (mean, (sum, n)) in means.iter_mut().zip(sums).filter(|(_, (_, n))| *n > 0.0) {
                *mean = sum.map(|s| (s / n) as f32);
            }
        }
        let num_items = points.len();
        let (right, left): (Vec<_>, Vec<_>) = points.into_iter().partition(|(p, _)| is_second(p, &means));
        let mut halves = [left, right].map(|half| half.into_iter().map(|(_, i)| i).collect::<Vec<_>>());
        if halves.iter().any(Vec::is_empty) {
            let mut all = halves.concat();
            let right = all.split_off(num_items / 2);
            halves = [all, right];
        }
        halves
    }
}

fn is_second(p: &ProjectedPoint, means: &[ProjectedPoint; 2]) -> bool {
    let squared = means.map(|m| m.iter().zip(p).map(|(m, p)| (m - p) * (m - p)).sum::<f32>());
    squared[1] < squared[0]
}
