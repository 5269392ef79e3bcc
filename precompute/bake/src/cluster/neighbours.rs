//! Search for pairs of near items.

use super::linkage::{Distance, Neighbour};
use super::tree::ClusterItem;
use crate::features::Features;
use crate::features::projection::{ProjectedPoint, SLACK, project, squared_gap, squared_reach};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use throng_motion::clip::FrameId;

/// Distances of frames, with projected points that give a lower bound.
pub(super) struct FrameSpace<'a> {
    pub features: &'a Features,
    /// Projected points (features.num_frames()).
    pub points: Vec<ProjectedPoint>,
}

/// Frames of an item whose points are compared to find near items.
const GLANCE: usize = 6;
/// Frames of an item that are compared to estimate the distance of another item.
const SAMPLE: usize = 32;

impl<'a> FrameSpace<'a> {
    pub fn new(features: &'a Features) -> Self {
        Self { features, points: project(features) }
    }

    /// Distance of two frames (rad).
    pub fn distance(&self, a: u32, b: u32) -> f32 {
        self.features.distance(FrameId(a), FrameId(b))
    }

    /// Distance of two frames where it is below `limit` (rad).
    pub fn distance_below(&self, a: u32, b: u32, limit: f32) -> Option<f32> {
        if squared_gap(&self.points[a as usize], &self.points[b as usize]) > squared_reach(limit) {
            return None;
        }
        let squared = self.features.squared_distance_within(FrameId(a), FrameId(b), limit * limit * (1.0 + SLACK))?;
        Some(squared.sqrt()).filter(|&d| d < limit)
    }

    /// Largest distance between the points of sampled frames of `a` and `b`, squared; `None` above `reach`.
    fn squared_gap_within(&self, a: &ClusterItem, b: &ClusterItem, reach: f32) -> Option<f32> {
        let mut largest = 0.0f32;
        for f in spread_sample(&a.frames, GLANCE) {
            for g in spread_sample(&b.frames, GLANCE) {
                largest = largest.max(squared_gap(&self.points[f as usize], &self.points[g as usize]));
                if largest > reach {
                    return None;
                }
            }
        }
        Some(largest)
    }

    /// For every item those whose linkage may be below `limit`, ascending; `None` above `max_pairs` pairs. Linkages are
    /// lower bounds.
    pub fn near_pairs(&self, items: &[ClusterItem], limit: f32, max_pairs: usize) -> Option<Vec<Vec<Neighbour>>> {
        // In the order of the first dimension, near items are near each other in the list.
        let first = |i: u32| self.points[items[i as usize].frames[0] as usize];
        let mut order: Vec<u32> = (0..items.len() as u32).collect();
        order.sort_by(|&a, &b| first(a)[0].total_cmp(&first(b)[0]).then(a.cmp(&b)));
        let points: Vec<ProjectedPoint> = order.iter().map(|&i| first(i)).collect();
        let reach = squared_reach(limit);
        let found = AtomicUsize::new(0);
        let after = |k: usize| {
            let mut near = Vec::new();
            let rest = points.iter().enumerate().skip(k + 1);
            for (other, p) in rest.take_while(|(_, p)| (p[0] - points[k][0]).powi(2) <= reach) {
                if squared_gap(&points[k], p) <= reach {
                    let item = order[other];
                    let gap = self.squared_gap_within(&items[order[k] as usize], &items[item as usize], reach);
                    near.extend(gap.map(|g| Neighbour { item, linkage: least_distance(g), estimated: false }));
                }
            }
            (found.fetch_add(near.len(), Ordering::Relaxed) + near.len() <= max_pairs).then_some(near)
        };
        let half: Vec<Vec<Neighbour>> = (0..order.len()).into_par_iter().map(after).collect::<Option<_>>()?;
        Some(mirror_pairs(&order, half))
    }
}

/// Distances limited to those below a threshold.
pub(super) struct BoundedDistance<'a> {
    pub space: &'a FrameSpace<'a>,
    /// Threshold (rad).
    pub limit: f32,
}

impl Distance for BoundedDistance<'_> {
    type Item = ClusterItem;

    /// Estimate from samples of either item: the distance to the frame of the other item with the farthest point.
    fn estimate(&self, a: &ClusterItem, b: &ClusterItem) -> Option<f32> {
        let mut largest = 0.0f32;
        for (from, to) in [(a, b), (b, a)] {
            for f in spread_sample(&from.frames, SAMPLE) {
                let gap = |g: u32| squared_gap(&self.space.points[f as usize], &self.space.points[g as usize]);
                let gaps = spread_sample(&to.frames, SAMPLE).map(|g| (gap(g), g));
                let farthest = gaps.max_by(|x, y| x.0.total_cmp(&y.0)).map_or(to.frames[0], |(_, g)| g);
                largest = largest.max(self.space.distance_below(f, farthest, self.limit)?);
            }
        }
        Some(largest)
    }

    fn join(&self, a: ClusterItem, b: ClusterItem) -> Result<ClusterItem, [ClusterItem; 2]> {
        if a.is_below(self.space, &b, self.limit) { Ok(ClusterItem::joined(self.space, a, b)) } else { Err([a, b]) }
    }
}

/// Frames of an item, at most `n`, spread evenly.
fn spread_sample(frames: &[u32], n: usize) -> impl Iterator<Item = u32> {
    frames.iter().step_by(frames.len().div_ceil(n)).copied()
}

/// Makes pairs known to the first item of each known to both.
fn mirror_pairs(order: &[u32], half: Vec<Vec<Neighbour>>) -> Vec<Vec<Neighbour>> {
    let mut sizes = vec![0; order.len()];
    for (&i, near) in order.iter().zip(&half) {
        sizes[i as usize] += near.len();
        near.iter().for_each(|n| sizes[n.item as usize] += 1);
    }
    let mut out: Vec<Vec<Neighbour>> = sizes.into_iter().map(Vec::with_capacity).collect();
    for (&i, near) in order.iter().zip(half) {
        for n in near {
            out[i as usize].push(n);
            out[n.item as usize].push(Neighbour { item: i, ..n });
        }
    }
    out.par_iter_mut().for_each(|near| near.sort_unstable_by_key(|n| n.item));
    out
}

/// Lower bound of the distance of frames, from the squared distance of their points.
fn least_distance(squared_gap: f32) -> f32 {
    ((squared_gap - 1e-7).max(0.0) / (1.0 + SLACK)).sqrt()
}
