//! Where a link collides first and last: it may be left before, and entered after.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Of a walk at 30 Hz every second frame is looked at: a hand moves some centimetres between them.
pub(in crate::stitch) const STRIDE: usize = 2;

/// First and last frame of a link at which a body is in a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::stitch) struct Hit {
    /// Counted from the link's first one.
    pub first: u16,
    /// The same frame or a later one.
    pub last: u16,
}

impl Hit {
    /// Of both.
    pub fn union(self, other: Self) -> Self {
        Self { first: self.first.min(other.first), last: self.last.max(other.last) }
    }
}

/// Number of frames of a link that are looked at (num_frames > 0).
pub(in crate::stitch) fn num_looks(num_frames: usize) -> usize {
    (num_frames - 1).div_ceil(STRIDE) + 1
}

/// The frame of a link that is looked at as one of so many (num_frames > 0).
pub(in crate::stitch) fn frame_of(look: usize, num_frames: usize) -> usize {
    (look * STRIDE).min(num_frames - 1)
}

/// The number of the look at a frame that is looked at.
pub(in crate::stitch) fn look_at(frame: usize) -> usize {
    frame.div_ceil(STRIDE)
}

/// The frames of a link that are looked at; the last one in any case (num_frames > 0).
pub(in crate::stitch) fn looked_at(num_frames: usize) -> impl Iterator<Item = usize> {
    (0..num_looks(num_frames)).map(move |look| frame_of(look, num_frames))
}

/// First and last frame of a link that collide.
///
/// - `known`: a frame at which it does, where one is known.
/// - `look`: none where a frame collides, else how many frames before and after it do not either.
pub(in crate::stitch) fn of_link(
    num_frames: usize,
    known: Option<usize>,
    mut look: impl FnMut(usize) -> Option<usize>,
) -> Option<Hit> {
    let (known, num_looks) = (known.map(look_at), num_looks(num_frames));
    let frame = |look: usize| frame_of(look, num_frames);
    let end = known.unwrap_or(num_looks);
    let mut first = 0;
    while first < end {
        let Some(clear) = look(frame(first)) else { break };
        first = (first + (clear / STRIDE).max(1)).min(end);
    }
    if first == num_looks {
        return None;
    }
    let least = known.unwrap_or(first);
    let mut last = num_looks - 1;
    while last > least {
        let Some(clear) = look(frame(last)) else { break };
        last = last.saturating_sub((clear / STRIDE).max(1)).max(least);
    }
    Some(Hit { first: frame(first) as u16, last: frame(last) as u16 })
}

/// Hits of links, found when they are first asked for.
#[derive(Debug, Default)]
pub(in crate::stitch) struct Hits {
    /// First and last frame of each link; [`UNKNOWN`] until they are found (links).
    packed: OnceLock<Box<[AtomicU32]>>,
}

/// No link is that long.
const UNKNOWN: u32 = u32::MAX;

impl Hits {
    /// The hit of a link.
    ///
    /// - `num_links`: of all.
    /// - `find`: gives the same every time.
    pub fn of(&self, link: usize, num_links: usize, find: impl FnOnce() -> Option<Hit>) -> Option<Hit> {
        let none = || (0..num_links).map(|_| AtomicU32::new(UNKNOWN)).collect();
        let packed = &self.packed.get_or_init(none)[link];
        match packed.load(Ordering::Relaxed) {
            UNKNOWN => {
                let hit = find()?;
                packed.store(u32::from(hit.first) | u32::from(hit.last) << 16, Ordering::Relaxed);
                Some(hit)
            }
            known => Some(Hit { first: known as u16, last: (known >> 16) as u16 }),
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
        let hit = |frames: &[usize]| of_link(30, None, |k| (!frames.contains(&k)).then(|| clear(frames, k)));
        assert_eq!(hit(&[]), None);
        assert_eq!(hit(&[4, 6, 20]), Some(Hit { first: 4, last: 20 }));
        assert_eq!(hit(&[29]), Some(Hit { first: 29, last: 29 }));
        assert_eq!(hit(&[8]), Some(Hit { first: 8, last: 8 }));
        let frames = [4, 10, 20];
        for known in frames {
            let hit = of_link(30, Some(known), |k| (!frames.contains(&k)).then(|| clear(&frames, k)));
            assert_eq!(hit, Some(Hit { first: 4, last: 20 }));
        }
        assert_eq!(of_link(30, Some(29), |k| (k != 29).then_some(0)), Some(Hit { first: 29, last: 29 }));
        assert_eq!(Hit { first: 8, last: 8 }.union(Hit { first: 2, last: 4 }), Hit { first: 2, last: 8 });
    }

    #[test]
    fn a_hit_is_looked_for_once() {
        let (hits, hit) = (Hits::default(), Hit { first: 3, last: 700 });
        assert_eq!(hits.of(1, 2, || None), None);
        assert_eq!(hits.of(1, 2, || Some(hit)), Some(hit));
        assert_eq!(hits.of(1, 2, || None), Some(hit));
        assert_eq!(hits.of(0, 2, || None), None);
    }
}
