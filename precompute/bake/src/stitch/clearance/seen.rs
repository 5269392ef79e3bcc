//! What is remembered of looking at links, so that little is looked at again where a unit is moved a little.

use super::bodies::Ball;
use super::hit::Hits;
use super::looks::Looks;

/// Bodies that are clear by more than this because of their place alone are not looked at: a smaller one saves looks, but
/// less is known of how clear they are, so they are looked at again after shorter moves (m).
pub(in crate::stitch) const ENOUGH_M: f32 = 0.12;
/// How far those are told apart that are looked at: with more, units can be moved farther before bodies are looked at
/// again, but more spheres have to be told from the unit, on wider grids (m).
pub(in crate::stitch) const SLACK_M: f32 = 0.25;

/// What is known of a link and a unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::stitch) enum Seen {
    /// Not looked at: it passes beside the unit.
    #[default]
    Nothing,
    /// It collides.
    Collides(Touch),
    /// It does not: where in [`Looks::clear`] its clearances begin, one for every frame that is looked at.
    Clear(u32),
}

impl Seen {
    /// The same where so many clearances of others come first.
    pub fn after(self, others: u32) -> Self {
        match self {
            Self::Clear(first) => Self::Clear(first + others),
            seen => seen,
        }
    }
}

/// What of a link collides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) struct Touch {
    /// At this frame, counted from its first one.
    pub frame: u16,
    /// This point of the body, in the patch's frame: where it still does, nothing else need be looked at.
    pub ball: Ball,
}

/// How far a unit may be moved without touching a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::stitch) struct Clearance {
    /// (mm)
    least: u16,
}

impl Clearance {
    /// A millimetre less than so many metres, so that no rounding makes it more.
    pub fn new(metres: f32) -> Self {
        Self { least: (1000.0 * metres - 1.0) as u16 }
    }

    /// What is left of it after the unit was moved; none where it may have got there (m).
    pub fn after(self, moved: f32) -> Option<Self> {
        let least = self.least.saturating_sub((1000.0 * moved).ceil() as u16);
        (least > 0).then_some(Self { least })
    }

    /// No body is nearer than this (m).
    #[cfg(test)]
    pub fn least(self) -> f32 {
        0.001 * f32::from(self.least)
    }
}

/// What a unit is in the way of, for one way in which it stands to a patch.
#[derive(Debug, Default)]
pub(in crate::stitch) struct Mask {
    /// Bits of the links that collide; no words where none does.
    pub words: Vec<u64>,
    /// What was seen of each link, or of each root.
    pub looks: Looks,
    /// True where roots were looked at, each as a link of one frame, because links have most of them in common.
    pub by_roots: bool,
    /// First and last collisions of links.
    pub hits: Hits,
}

impl Mask {
    /// A frame at which a link collides, where one is known.
    pub fn frame(&self, link: usize) -> Option<usize> {
        match self.looks.seen.get(link) {
            Some(Seen::Collides(touch)) if !self.by_roots => Some(usize::from(touch.frame)),
            _ => None,
        }
    }
}

/// A mask for the same patch and unit, which stood elsewhere.
#[derive(Clone, Copy, Debug)]
pub(in crate::stitch) struct Earlier<'m> {
    /// The mask.
    pub mask: &'m Mask,
    /// No point of the unit, nor any near it, has been moved farther (m).
    pub moved: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_stays_clear_until_the_unit_may_have_got_there() {
        let clear = Clearance::new(0.05);
        assert!((0.0485..0.05).contains(&clear.least()));
        let after = clear.after(0.03).expect("it is farther away");
        assert!((0.0175..0.0191).contains(&after.least()), "{after:?}");
        assert_eq!(after.after(0.02), None);
        assert_eq!(Clearance::new(-0.3).after(0.0), None);
        assert_eq!(Clearance::new(1e9).after(1e9), None);
    }
}
