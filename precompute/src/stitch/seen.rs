//! What is remembered of looking at links, so that little is looked at again where a unit is moved a little.

use super::bodies::Ball;

/// Bodies that are farther from a unit than this are not told apart. [Unit: m]
pub(super) const SLACK_M: f32 = 0.12;
/// Where less is left of that, a link is looked through again. [Unit: m]
const LEAST_M: f32 = 0.03;

/// What is known of a link and a unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Seen {
    /// Nobody looked: it passes beside the unit.
    #[default]
    Nothing,
    /// It collides.
    Collides(Touch),
    /// It does not.
    Clear(Clear),
}

/// What of a link collides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// At this frame, counted from its first one.
    pub frame: u16,
    /// This point of the body, in the patch's frame: where it still does, nothing else need be looked at.
    pub ball: Ball,
}

/// How far a link that does not collide is from a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Clear {
    /// No body is nearer than this. [Unit: mm]
    all: u16,
    /// Before and after some frames no body is nearer than this. [Unit: mm]
    others: u16,
    /// The first and the last of those frames, counted from the link's first one.
    near: [u16; 2],
}

impl Clear {
    /// Nothing has come near yet.
    pub fn new() -> Self {
        Self { all: millimetres(SLACK_M), others: millimetres(SLACK_M), near: [u16::MAX, 0] }
    }

    /// Adds a frame at which a body is no nearer than `clearance`. [Unit: m] [Limit: <= SLACK_M]
    pub fn add(&mut self, frame: usize, clearance: f32) {
        let mm = millimetres(clearance);
        self.all = self.all.min(mm);
        if mm < self.others {
            self.near = [self.near[0].min(frame as u16), self.near[1].max(frame as u16)];
        }
    }

    /// No body is nearer than this. [Unit: m]
    pub fn least(&self) -> f32 {
        0.001 * f32::from(self.all)
    }

    /// What is known after the unit was moved by `moved`. [Unit: m]
    pub fn after(self, moved: f32) -> After {
        let left = |mm: u16| f32::from(mm) * 0.001 - moved;
        let [all, others] = [left(self.all), left(self.others)];
        if all > 0.0 {
            return After::Clear(Self { all: millimetres(all), others: millimetres(others), ..self });
        }
        if others < LEAST_M {
            return After::Unknown;
        }
        After::Near(Self { all: millimetres(others), others: millimetres(others), ..self })
    }

    /// Frames that have to be looked at, of all that are.
    pub fn near(&self, frames: impl Iterator<Item = usize>) -> impl Iterator<Item = usize> {
        let [first, last] = self.near.map(usize::from);
        frames.skip_while(move |k| *k < first).take_while(move |k| *k <= last)
    }
}

/// What is known of a link that did not collide, after the unit was moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum After {
    /// It still does not.
    Clear(Clear),
    /// Some frames have to be looked at, and added to this.
    Near(Clear),
    /// All have to be.
    Unknown,
}

/// A millimetre less, so that no rounding makes it more.
fn millimetres(metres: f32) -> u16 {
    (1000.0 * metres - 1.0).max(0.0) as u16
}

/// What a unit is in the way of, for one way in which it stands to a patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mask {
    /// Bits of the links that collide; no words where none does.
    pub words: Vec<u64>,
    /// What was seen of each link; empty where links have most of their roots in common. [Size: links, or 0]
    pub links: Vec<Seen>,
    /// There, what was seen of each root, as of a link of one frame. [Size: roots, or 0]
    pub roots: Vec<Seen>,
}

impl Mask {
    /// A frame at which a link collides, where one is known.
    pub fn frame(&self, link: usize) -> Option<usize> {
        match self.links.get(link) {
            Some(Seen::Collides(touch)) => Some(usize::from(touch.frame)),
            _ => None,
        }
    }
}

/// A mask for the same patch and unit, which stood elsewhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Earlier<'m> {
    /// The mask.
    pub mask: &'m Mask,
    /// No point of the unit, nor any near it, has been moved farther. [Unit: m]
    pub moved: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_stays_clear_until_the_unit_may_have_got_there() {
        let mut clear = Clear::new();
        clear.add(10, 0.05);
        clear.add(30, 0.11);
        clear.add(40, SLACK_M);
        assert_eq!((clear.all, clear.near), (49, [10, 30]));
        let After::Clear(moved) = clear.after(0.03) else { panic!("it is farther away") };
        assert!((0.017..0.0191).contains(&moved.least()) && moved.near == clear.near);
        let After::Near(moved) = moved.after(0.03) else { panic!("it may be there") };
        assert!(moved.least() < SLACK_M - 0.06 && moved.least() > SLACK_M - 0.07);
        assert_eq!(moved.near([8, 10, 12, 30, 31, 32].into_iter()).collect::<Vec<_>>(), [10, 12, 30]);
        assert_eq!(clear.after(0.1), After::Unknown);
    }
}
