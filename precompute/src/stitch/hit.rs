//! Where a link collides first and last: it may be left before, and entered after.

/// Of a walk at 30 Hz every second frame is looked at: a hand moves some centimetres between them.
pub(super) const STRIDE: usize = 2;

/// First and last frame of a link at which a body is in a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Hit {
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

/// Number of frames of a link that are looked at. [Limit: num_frames > 0]
pub(super) fn num_looks(num_frames: usize) -> usize {
    (num_frames - 1).div_ceil(STRIDE) + 1
}

/// The frame of a link that is looked at as one of so many. [Limit: num_frames > 0]
pub(super) fn frame_of(look: usize, num_frames: usize) -> usize {
    (look * STRIDE).min(num_frames - 1)
}

/// The number of the look at a frame that is looked at.
pub(super) fn look_at(frame: usize) -> usize {
    frame.div_ceil(STRIDE)
}

/// The frames of a link that are looked at; the last one in any case. [Limit: num_frames > 0]
pub(super) fn looked_at(num_frames: usize) -> impl Iterator<Item = usize> {
    (0..num_looks(num_frames)).map(move |look| frame_of(look, num_frames))
}

/// The first look at a link that finds a collision.
///
/// - `look`: none where a frame collides, else how many frames before and after it do not either.
fn first_hit(num_frames: usize, look: &mut impl FnMut(usize) -> Option<usize>) -> Option<usize> {
    let mut at = 0;
    while at < num_looks(num_frames) {
        match look(frame_of(at, num_frames)) {
            None => return Some(at),
            Some(clear) => at += (clear / STRIDE).max(1),
        }
    }
    None
}

/// First and last frame of a link that collide. Of what is left or entered before a known collision, only the first one
/// matters, of what is after it only the last one.
pub(super) fn of_link(
    num_frames: usize,
    known: Option<usize>,
    offsets: [u32; 2],
    mut look: impl FnMut(usize) -> Option<usize>,
) -> Option<Hit> {
    let frame = |look: usize| frame_of(look, num_frames);
    let first = match known {
        Some(known) if known <= offsets[0] as usize => look_at(known),
        _ => first_hit(num_frames, &mut look)?,
    };
    let least = known.map_or(first, look_at);
    let mut last = if known.is_some_and(|k| k >= offsets[1] as usize) { least } else { num_looks(num_frames) - 1 };
    while last > least {
        let Some(clear) = look(frame(last)) else { break };
        last = last.saturating_sub((clear / STRIDE).max(1)).max(least);
    }
    Some(Hit { first: frame(first) as u16, last: frame(last) as u16 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_collision_of_a_link_are_found() {
        let clear = |frames: &[usize], k: usize| {
            frames.iter().map(|&f| f.abs_diff(k)).min().map_or(99, |d| d.saturating_sub(1))
        };
        let hit = |frames: &[usize]| of_link(30, None, [0, 29], |k| (!frames.contains(&k)).then(|| clear(frames, k)));
        assert_eq!(hit(&[]), None);
        assert_eq!(hit(&[4, 6, 20]), Some(Hit { first: 4, last: 20 }));
        assert_eq!(hit(&[29]), Some(Hit { first: 29, last: 29 }));
        assert_eq!(hit(&[8]), Some(Hit { first: 8, last: 8 }));
        let frames = [4, 10, 20];
        let known = |offsets| of_link(30, Some(10), offsets, |k| (!frames.contains(&k)).then(|| clear(&frames, k)));
        assert_eq!(known([7, 25]), Some(Hit { first: 4, last: 20 }));
        assert_eq!(known([10, 25]), Some(Hit { first: 10, last: 20 }));
        assert_eq!(known([3, 9]), Some(Hit { first: 4, last: 10 }));
        assert_eq!(of_link(30, Some(29), [0, 29], |k| (k != 29).then_some(0)), Some(Hit { first: 29, last: 29 }));
        assert_eq!(Hit { first: 8, last: 8 }.union(Hit { first: 2, last: 4 }), Hit { first: 2, last: 8 });
    }
}
