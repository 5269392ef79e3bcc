//! Groups of frames as trees of balls: decides whether two groups stay below a distance, and how wide one is, mostly
//! without comparing pairs of frames.

use super::neighbours::FrameSpace;
use crate::features::projection::{DIMS, squared_gap};
use serde::{Deserialize, Serialize};

/// A group of frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ClusterItem {
    /// Frames, at least one; those of every ball are contiguous.
    pub frames: Vec<u32>,
    /// Balls of merged groups, each before the balls of its first part, which come before those of its second; a single
    /// frame is a ball too (2 frames.len() - 1).
    balls: Vec<FrameBall>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct FrameBall {
    num_frames: u32,
    /// Frame at the centre.
    centre: u32,
    /// Largest distance of a frame from the centre (rad).
    radius: f32,
}

/// Relative amount by which rounding may break the triangle inequality.
const SLACK: f32 = 1e-4;
/// Ratio of both parts to the smaller one above which only the larger one's centre is considered.
const LOPSIDED: usize = 4;

impl ClusterItem {
    pub fn single(frame: u32) -> Self {
        Self { frames: vec![frame], balls: vec![FrameBall { num_frames: 1, centre: frame, radius: 0.0 }] }
    }

    /// Merges two groups.
    pub fn joined(space: &FrameSpace, a: Self, b: Self) -> Self {
        let mut frames = a.frames;
        let first = frames.len();
        frames.extend(b.frames);
        let (larger, smaller) =
            if first * 2 >= frames.len() { (a.balls[0], first..frames.len()) } else { (b.balls[0], 0..first) };
        let ball = if smaller.len() * LOPSIDED < frames.len() {
            let added = farthest(space, larger.centre, &frames[smaller]);
            FrameBall { num_frames: frames.len() as u32, radius: larger.radius.max(added), ..larger }
        } else {
            let centre = mean_point(space, &frames);
            FrameBall { num_frames: frames.len() as u32, centre, radius: farthest(space, centre, &frames) }
        };
        let balls = [vec![ball], a.balls, b.balls].concat();
        Self { frames, balls }
    }

    /// Child balls of a ball; `None` for a single frame.
    fn parts(&self, ball: usize) -> Option<[usize; 2]> {
        let first = ball + 1;
        let second = || first + 2 * self.balls[first].num_frames as usize - 1;
        (self.balls[ball].num_frames > 1).then(|| [first, second()])
    }

    /// Whether every distance between a frame of `self` and one of `other` is below `limit`.
    ///
    /// A distance between frames of two balls is at most the distance of the centres plus both radii: the distance of
    /// frames is a metric, being the root of a weighted sum of squares of metrics.
    pub fn is_below(&self, space: &FrameSpace, other: &Self, limit: f32) -> bool {
        let mut pairs = vec![(0, 0)];
        while let Some((i, j)) = pairs.pop() {
            let (a, b) = (&self.balls[i], &other.balls[j]);
            let Some(distance) = space.distance_below(a.centre, b.centre, limit) else { return false };
            if (distance + a.radius + b.radius) * (1.0 + SLACK) < limit {
                continue;
            }
            self.refine_pair(other, i, j, &mut pairs);
        }
        true
    }

    /// Largest distance between two of the frames where it is above `least`, else `least` (rad).
    pub fn diameter(&self, space: &FrameSpace, least: f32) -> f32 {
        let mut largest = least;
        let mut pairs = vec![(0, 0)];
        while let Some((i, j)) = pairs.pop() {
            let (a, b) = (&self.balls[i], &self.balls[j]);
            let distance = space.distance(a.centre, b.centre);
            largest = largest.max(distance);
            if (distance + a.radius + b.radius) * (1.0 + SLACK) <= largest {
                continue;
            }
            if i == j {
                if let Some([first, second]) = self.parts(i) {
                    pairs.extend([(first, first), (second, second), (first, second)]);
                }
                continue;
            }
            self.refine_pair(self, i, j, &mut pairs);
        }
        largest
    }

    /// Replaces a compared pair, of ball `i` of this tree and ball `j` of `other`, by pairs with the parts of the wider
    /// one; by none if both are single frames.
    fn refine_pair(&self, other: &Self, i: usize, j: usize, pairs: &mut Vec<(usize, usize)>) {
        let parts = if self.balls[i].radius >= other.balls[j].radius { self.parts(i) } else { None };
        match (parts, other.parts(j)) {
            (Some(parts), _) => pairs.extend(parts.map(|i| (i, j))),
            (None, Some(parts)) => pairs.extend(parts.map(|j| (i, j))),
            (None, None) => pairs.extend(self.parts(i).into_iter().flatten().map(|i| (i, j))),
        }
    }
}

/// Largest distance of a frame from `centre` (rad).
fn farthest(space: &FrameSpace, centre: u32, frames: &[u32]) -> f32 {
    frames.iter().map(|&f| space.distance(centre, f)).fold(0.0, f32::max)
}

/// Frame whose point is nearest to the mean of all points.
fn mean_point(space: &FrameSpace, frames: &[u32]) -> u32 {
    let mut sums = [0.0f64; DIMS];
    for &f in frames {
        sums.iter_mut().zip(&space.points[f as usize]).for_each(|(sum, x)| *sum += f64::from(*x));
    }
    let mean = sums.map(|sum| (sum / frames.len() as f64) as f32);
    let gap = |f: u32| squared_gap(&mean, &space.points[f as usize]);
    let gaps = frames.iter().map(|&f| (gap(f), f));
    gaps.min_by(|x, y| x.0.total_cmp(&y.0)).map_or(frames[0], |(_, f)| f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::{self, Features, FeaturesConfig};
    use proptest::prelude::*;
    use std::sync::LazyLock;
    use throng_motion::clip::FrameId;
    use throng_synth::{self as synth, SynthConfig, SynthSet};

    static WALK: LazyLock<Features> = LazyLock::new(|| {
        let clips = synth::make_set(SynthSet::Walk, &SynthConfig { minutes: 0.1, ..SynthConfig::default() }).unwrap();
        features::extract(&clips, &FeaturesConfig::default()).unwrap()
    });

    /// Frames merged in an order that chance gives.
    fn merged(space: &FrameSpace, frames: &[u32], mut order: u64) -> ClusterItem {
        let mut items: Vec<ClusterItem> = frames.iter().map(|&f| ClusterItem::single(f)).collect();
        while items.len() > 1 {
            order = order.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let a = items.remove((order >> 33) as usize % items.len());
            let b = items.remove((order >> 13) as usize % items.len());
            items.push(ClusterItem::joined(space, a, b));
        }
        items.remove(0)
    }

    fn some_frames() -> impl Strategy<Value = Vec<u32>> {
        prop::collection::btree_set(0..WALK.num_frames() as u32, 1..60).prop_map(|f| f.into_iter().collect())
    }

    proptest! {
        #[test]
        fn balls_tell_what_all_pairs_of_frames_tell(
            a in some_frames(),
            b in some_frames(),
            order in any::<u64>(),
            share in 0.5f32..1.5,
        ) {
            let space = FrameSpace::new(&WALK);
            let pairs = |a: &[u32], b: &[u32]| {
                let all = a.iter().flat_map(|&f| b.iter().map(move |&g| (f, g)));
                all.map(|(f, g)| WALK.distance(FrameId(f), FrameId(g))).fold(0.0, f32::max)
            };
            let largest = pairs(&a, &b);
            let width = pairs(&a, &a);
            let items = [(&a, order), (&b, order ^ 7)].map(|(frames, order)| merged(&space, frames, order));
            for item in &items {
                prop_assert_eq!(item.balls.len(), 2 * item.frames.len() - 1);
            }
            for limit in [largest, largest * share, largest * 1.0001 + 1e-6] {
                prop_assert_eq!(items[0].is_below(&space, &items[1], limit), largest < limit);
            }
            prop_assert_eq!(items[0].diameter(&space, 0.0), width);
            prop_assert_eq!(items[0].diameter(&space, width + 0.1), width + 0.1);
        }
    }
}
