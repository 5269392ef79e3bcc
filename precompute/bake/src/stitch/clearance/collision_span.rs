//! First and last collision of a link: it may be left before, and entered after.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Interval of sampled frames: in a walk at 30 Hz a hand moves some centimetres between two samples.
pub(in crate::stitch) const STRIDE: usize = 2;

/// First and last frame of a link in collision with a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::stitch) struct CollisionSpan {
    /// First frame, counted from the link's first one.
    pub first: u16,
    /// Last frame, at or after the first.
    pub last: u16,
}

impl CollisionSpan {
    /// Span of both.
    pub fn union(self, other: Self) -> Self {
        Self { first: self.first.min(other.first), last: self.last.max(other.last) }
    }
}

/// Number of sampled frames of a link (num_frames > 0).
pub(in crate::stitch) fn num_samples(num_frames: usize) -> usize {
    (num_frames - 1).div_ceil(STRIDE) + 1
}

/// Frame of a link at a sample index (num_frames > 0).
pub(in crate::stitch) fn frame_of(sample: usize, num_frames: usize) -> usize {
    (sample * STRIDE).min(num_frames - 1)
}

/// Sample index of a sampled frame.
pub(in crate::stitch) fn frame_of_sample(frame: usize) -> usize {
    frame.div_ceil(STRIDE)
}

/// Sampled frames of a link, always including the last one (num_frames > 0).
pub(in crate::stitch) fn nearest_sampled(num_frames: usize) -> impl Iterator<Item = usize> {
    (0..num_samples(num_frames)).map(move |sample| frame_of(sample, num_frames))
}

/// Finds the first and last colliding frame of a link.
///
/// - `known`: a colliding frame, if known.
/// - `look`: samples a frame: `None` for a collision, else how many frames before and after it are free too.
pub(in crate::stitch) fn find_span(
    num_frames: usize,
    known: Option<usize>,
    mut sample: impl FnMut(usize) -> Option<usize>,
) -> Option<CollisionSpan> {
    let (known, num_sampled) = (known.map(frame_of_sample), num_samples(num_frames));
    let frame = |sample: usize| frame_of(sample, num_frames);
    let end = known.unwrap_or(num_sampled);
    let mut first = 0;
    while first < end {
        let Some(clear) = sample(frame(first)) else { break };
        first = (first + (clear / STRIDE).max(1)).min(end);
    }
    if first == num_sampled {
        return None;
    }
    let least = known.unwrap_or(first);
    let mut last = num_sampled - 1;
    while last > least {
        let Some(clear) = sample(frame(last)) else { break };
        last = last.saturating_sub((clear / STRIDE).max(1)).max(least);
    }
    Some(CollisionSpan { first: frame(first) as u16, last: frame(last) as u16 })
}

/// Collisions of links, found when first requested.
#[derive(Debug, Default)]
pub(in crate::stitch) struct CollisionSpans {
    /// First and last frame of each link; [`UNKNOWN`] until found (links).
    packed: OnceLock<Box<[AtomicU32]>>,
}

/// Larger than any length of a link.
const UNKNOWN: u32 = u32::MAX;

impl CollisionSpans {
    /// Collision of a link.
    ///
    /// - `num_links`: number of all links.
    /// - `find`: must always return the same.
    pub fn span_of_link(
        &self,
        link: usize,
        num_links: usize,
        find: impl FnOnce() -> Option<CollisionSpan>,
    ) -> Option<CollisionSpan> {
        let none = || (0..num_links).map(|_| AtomicU32::new(UNKNOWN)).collect();
        let packed = &self.packed.get_or_init(none)[link];
        match packed.load(Ordering::Relaxed) {
            UNKNOWN => {
                let hit = find()?;
                packed.store(u32::from(hit.first) | u32::from(hit.last) << 16, Ordering::Relaxed);
                Some(hit)
            }
            known => Some(CollisionSpan { first: known as u16, last: (known >> 16) as u16 }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_collision_of_a_link_are_found() {
        let clear = |frames: &[usize], k: usize| {
            frames.iter().map(|&f| f.abs_diff(k)).min().map_or(99, |d| d.saturating_sub(1))
        };
        let hit = |frames: &[usize]| find_span(30, None, |k| (!frames.contains(&k)).then(|| clear(frames, k)));
        assert_eq!(hit(&[]), None);
        assert_eq!(hit(&[4, 6, 20]), Some(CollisionSpan { first: 4, last: 20 }));
        assert_eq!(hit(&[29]), Some(CollisionSpan { first: 29, last: 29 }));
        assert_eq!(hit(&[8]), Some(CollisionSpan { first: 8, last: 8 }));
        let frames = [4, 10, 20];
        for known in frames {
            let hit = find_span(30, Some(known), |k| (!frames.contains(&k)).then(|| clear(&frames, k)));
            assert_eq!(hit, Some(CollisionSpan { first: 4, last: 20 }));
        }
        assert_eq!(find_span(30, Some(29), |k| (k != 29).then_some(0)), Some(CollisionSpan { first: 29, last: 29 }));
        assert_eq!(
            CollisionSpan { first: 8, last: 8 }.union(CollisionSpan { first: 2, last: 4 }),
            CollisionSpan { first: 2, last: 8 }
        );
    }

    #[test]
    fn a_hit_is_looked_for_once() {
        let (hits, hit) = (CollisionSpans::default(), CollisionSpan { first: 3, last: 700 });
        assert_eq!(hits.span_of_link(1, 2, || None), None);
        assert_eq!(hits.span_of_link(1, 2, || Some(hit)), Some(hit));
        assert_eq!(hits.span_of_link(1, 2, || None), Some(hit));
        assert_eq!(hits.span_of_link(0, 2, || None), None);
    }
}
