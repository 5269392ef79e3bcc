//! Stored results of collision sampling, so that few samples are repeated when a unit is moved a little.

use super::{bodies::BodyPoint, collision_span::CollisionSpans, sampler::LinkSamples};

/// Clearance by place alone above which bodies are not sampled: a smaller one saves samples, but leaves clearances less
/// exact, so that bodies are sampled again after shorter moves (m).
pub(in crate::stitch) const ENOUGH_M: f32 = 0.12;
/// Clearance up to which sampled bodies are distinguished: with more, units can be moved farther before bodies are
/// sampled again, but more spheres have to be compared with the unit, on wider grids (m).
pub(in crate::stitch) const SLACK_M: f32 = 0.25;

/// Known relation of a link and a unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::stitch) enum LinkClearance {
    /// Not sampled: the link passes beside the unit.
    #[default]
    Nothing,
    /// Collision.
    Collides(LinkCollision),
    /// No collision: index in [`LinkSamples::clear`] of its first clearance; one for every sampled frame.
    Clear(u32),
}

impl LinkClearance {
    /// This result, with its index moved by so many clearances of other links.
    pub fn offset_by(self, others: u32) -> Self {
        match self {
            Self::Clear(first) => Self::Clear(first + others),
            seen => seen,
        }
    }
}

/// Collision of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) struct LinkCollision {
    /// Colliding frame, counted from its first one.
    pub frame: u16,
    /// Colliding sphere of the body, in the patch's frame: while it still collides, no other sample is needed.
    pub ball: BodyPoint,
}

/// Distance by which a unit may be moved without touching a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::stitch) struct Clearance {
    /// Rounded-down distance (mm).
    least: u16,
}

impl Clearance {
    /// A millimetre less than a distance, against rounding (m).
    pub fn new(metres: f32) -> Self {
        Self { least: (1000.0 * metres - 1.0) as u16 }
    }

    /// Remaining clearance after a move of the unit; `None` if it may touch the body (m).
    pub fn after_move(self, moved: f32) -> Option<Self> {
        let least = self.least.saturating_sub((1000.0 * moved).ceil() as u16);
        (least > 0).then_some(Self { least })
    }

    /// Lower bound of the distance of the body (m).
    #[cfg(test)]
    pub fn least(self) -> f32 {
        0.001 * f32::from(self.least)
    }
}

/// Links that a unit obstructs, for one relative placement of unit and patch.
#[derive(Debug, Default)]
pub(in crate::stitch) struct ObstacleMask {
    /// Bits of the links that collide; empty if there are none.
    pub words: Vec<u64>,
    /// Result for each link, or for each root.
    pub samples: LinkSamples,
    /// True if roots were sampled, each as a link of one frame, because links have most of them in common.
    pub by_roots: bool,
    /// First and last collisions of links.
    pub hits: CollisionSpans,
}

impl ObstacleMask {
    /// A colliding frame of a link, if known.
    pub fn frame(&self, link: usize) -> Option<usize> {
        match self.samples.clearance_of.get(link) {
            Some(LinkClearance::Collides(touch)) if !self.by_roots => Some(usize::from(touch.frame)),
            _ => None,
        }
    }
}

/// A mask for the same patch and unit at another place.
#[derive(Clone, Copy, Debug)]
pub(in crate::stitch) struct EarlierMask<'m> {
    /// The mask.
    pub mask: &'m ObstacleMask,
    /// Largest displacement of any point of the unit, or near it (m).
    pub moved: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_stays_clear_until_the_unit_may_have_got_there() {
        let clear = Clearance::new(0.05);
        assert!((0.0485..0.05).contains(&clear.least()));
        let after = clear.after_move(0.03).expect("it is farther away");
        assert!((0.0175..0.0191).contains(&after.least()), "{after:?}");
        assert_eq!(after.after_move(0.02), None);
        assert_eq!(Clearance::new(-0.3).after_move(0.0), None);
        assert_eq!(Clearance::new(1e9).after_move(1e9), None);
    }
}
