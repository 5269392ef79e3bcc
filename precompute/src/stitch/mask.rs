//! What of a patch's motion a unit is in the way of, for every way in which the unit may stand to the patch.

use super::bits::{num_words, set};
use super::bodies::Bodies;
use super::field::Field;
use super::paths::Paths;
use super::seen::{After, Clear, Earlier, Mask, SLACK_M, Seen};
use super::swept::Swept;
use crate::environment::Bounds;
use rayon::prelude::*;
use throng_runtime::patch::Placement;
use throng_runtime::planar::wrap_angle;

/// Of a walk at 30 Hz every second frame is looked at: a hand moves some centimetres between them.
const STRIDE: usize = 2;

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

/// A unit that stands in a patch's motion.
#[derive(Clone, Copy)]
pub(super) struct Obstacle<'a> {
    paths: &'a Paths,
    bodies: &'a Bodies,
    unit: &'a Field,
    at: Placement,
    /// Sine and cosine of its heading.
    turn: [f32; 2],
}

impl<'a> Obstacle<'a> {
    /// - `paths`, `bodies`: the motion, and the bodies of its frames.
    /// - `at`: where the unit stands in the patch's frame.
    pub fn new(paths: &'a Paths, bodies: &'a Bodies, unit: &'a Field, at: Placement) -> Self {
        Self { paths, bodies, unit, at, turn: at.heading.sin_cos().into() }
    }

    /// How far any point of a unit, or that near it, moves from one place to another, at most. [Unit: m]
    pub fn moved(unit: &Bounds, from: Placement, to: Placement) -> f32 {
        let farthest = unit.min.abs().max(unit.max.abs()).with_y(0.0).length() + Field::MARGIN_M;
        let turn = wrap_angle(to.heading - from.heading).abs();
        (to.translation() - from.translation()).length() + turn * farthest
    }

    /// Which links collide.
    ///
    /// - `swept`: of the motion; none where links have most of their roots in common.
    /// - `earlier`: where the unit stood elsewhere: what is the same as there is found sooner.
    pub fn mask(&self, swept: Option<&Swept>, earlier: Option<Earlier<'_>>) -> Mask {
        if self.unit.geometry.bounds.is_empty() {
            return Mask::default();
        }
        let near = self.near();
        let is_near = |l: &u32| near.overlaps(self.paths.bounds(*l as usize));
        let num_links = self.paths.num_links();
        let Some(swept) = swept else {
            let shared = Shared::new(self, &near);
            let all = (0..num_links as u32).filter(is_near);
            return Mask {
                words: bits(num_links, all.filter(|&l| shared.hits(self.paths.range(l as usize)))),
                seen: Vec::new(),
            };
        };
        let order = self.paths.order();
        let meeting = swept.meeting(&swept.shadow(self.unit, self.at)).into_iter().map(|k| order[k as usize]);
        let links: Vec<u32> = meeting.filter(is_near).collect();
        let found: Vec<Seen> = links.par_chunks(256).flat_map_iter(|links| self.see(links, swept, earlier)).collect();
        let mut seen = vec![Seen::Nothing; num_links];
        links.iter().zip(&found).for_each(|(&l, &s)| seen[l as usize] = s);
        let hit = links.iter().zip(&found).filter(|(_, s)| matches!(s, Seen::Collides(_)));
        Mask { words: bits(num_links, hit.map(|(&l, _)| l)), seen }
    }

    /// Looks at some links; those that follow each other in [`Paths::order`] play much the same.
    fn see(&self, links: &[u32], swept: &Swept, earlier: Option<Earlier<'_>>) -> Vec<Seen> {
        let mut guess = Guess::default();
        let mut see = |link: usize| {
            let again = earlier.and_then(|earlier| self.look_again(link, earlier));
            again.unwrap_or_else(|| self.look_through(link, swept.radius(link), &mut guess))
        };
        links.iter().map(|&l| see(l as usize)).collect()
    }

    /// Looks at what may not be as it was seen earlier; none where that is all of a link.
    fn look_again(&self, link: usize, earlier: Earlier<'_>) -> Option<Seen> {
        let range = self.paths.range(link);
        match *earlier.mask.seen.get(link)? {
            Seen::Nothing => None,
            Seen::Collides(k) => self.look(range.start + usize::from(k)).is_none().then_some(Seen::Collides(k)),
            Seen::Clear(clear) => match clear.after(earlier.moved) {
                After::Clear(clear) => Some(Seen::Clear(clear)),
                After::Near(known) => Some(self.look_closely(range.start, known, known.near(looked_at(range.len())))),
                After::Unknown => None,
            },
        }
    }

    /// Looks at some frames of a link until one collides.
    ///
    /// - `first`: the link's first root.
    /// - `known`: of all other frames.
    fn look_closely(&self, first: usize, known: Clear, frames: impl Iterator<Item = usize>) -> Seen {
        let (mut clear, most) = (known, known.least());
        for k in frames {
            let (row, root) = self.pose(first + k);
            match self.bodies.clearance(row, root, self.unit, most) {
                Some(clearance) if clearance < most => clear.add(k, clearance),
                Some(_) => {}
                None => return Seen::Collides(k as u16),
            }
        }
        Seen::Clear(clear)
    }

    /// First and last frame of a link that collide, as far as it matters for where it is left and entered.
    ///
    /// - `known`: a frame at which it collides, where one is known.
    /// - `offsets`: first and last frame at which it is left or entered.
    pub fn hit(&self, link: usize, known: Option<usize>, offsets: [u32; 2]) -> Option<Hit> {
        let range = self.paths.range(link);
        of_link(range.len(), known, offsets, |k| self.look(range.start + k))
    }

    /// Where a root must be for its body to touch the unit.
    fn near(&self) -> Bounds {
        self.bodies.around(&self.unit.geometry.bounds.placed(self.at))
    }

    /// Looks at all frames of a link, until one collides: first at the one at which the link before did, then at those
    /// to whose roots the unit is nearest.
    ///
    /// - `radius`: no body of the link reaches farther from its root. [Unit: m]
    fn look_through(&self, link: usize, radius: f32, guess: &mut Guess) -> Seen {
        let range = self.paths.range(link);
        if guess.frame < range.len() && self.look(range.start + guess.frame).is_none() {
            return Seen::Collides(guess.frame as u16);
        }
        guess.likely.clear();
        first_hit(range.len(), &mut |k| {
            let [x, z] = self.in_unit(&self.paths.roots()[range.start + k]);
            let clear = self.clear(x, z, radius + SLACK_M);
            if clear == 0 {
                guess.likely.push((self.unit.far(x, z), k));
            }
            Some(clear)
        });
        guess.likely.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let frames = guess.likely.iter().map(|(_, k)| *k);
        let seen = self.look_closely(range.start, Clear::new(), frames);
        // The last frame of a link is looked at in any case; of others, that one may not be.
        if let Seen::Collides(k) = seen
            && usize::from(k).is_multiple_of(STRIDE)
        {
            guess.frame = usize::from(k);
        }
        seen
    }

    /// For how many frames before and after a root are roots farther from the unit than `by`. [Unit: m]
    fn clear(&self, x: f32, z: f32, by: f32) -> usize {
        let way = self.unit.plan().beside(x, z) - by;
        if way > 0.0 { (way / self.paths.step().max(1e-3)) as usize } else { 0 }
    }

    /// Frame row and root in the unit's frame.
    fn pose(&self, at: usize) -> (usize, Placement) {
        let p = &self.paths.roots()[at];
        let [x, z] = self.in_unit(p);
        (self.paths.rows()[at] as usize, Placement::new(x, p.y - self.at.y, z, p.heading - self.at.heading))
    }

    /// x and z of a root in the unit's frame.
    fn in_unit(&self, root: &Placement) -> [f32; 2] {
        let ([sin, cos], x, z) = (self.turn, root.x - self.at.x, root.z - self.at.z);
        [cos * x - sin * z, sin * x + cos * z]
    }

    /// Looks at a root: none where it collides, else how many frames before and after it do not either.
    fn look(&self, at: usize) -> Option<usize> {
        let (row, root) = self.pose(at);
        let clear = self.clear(root.x, root.z, self.bodies.radius());
        (clear > 0 || !self.bodies.collides(row, root, self.unit)).then_some(clear)
    }
}

/// The bits of some of a patch's links; no words where there are none.
fn bits(num_links: usize, links: impl Iterator<Item = u32>) -> Vec<u64> {
    let mut links = links.peekable();
    let mut words = vec![0; if links.peek().is_some() { num_words(num_links) } else { 0 }];
    links.for_each(|l| set(&mut words, l));
    words
}

/// Where a link is likely to collide.
#[derive(Default)]
struct Guess {
    /// Frame at which the last one did.
    frame: usize,
    /// Frames and how far the unit is from their roots. [Unit: m]
    likely: Vec<(f32, usize)>,
}

/// What roots collide that many links have in common: each is looked at once.
struct Shared {
    hits: Vec<bool>,
    /// The first root that collides among every [`STRIDE`]th from one on. [Size: hits.len()]
    next: Vec<u32>,
}

impl Shared {
    fn new(obstacle: &Obstacle<'_>, near: &Bounds) -> Self {
        let roots = obstacle.paths.roots();
        let hits: Vec<bool> =
            (0..roots.len()).map(|at| near.contains(roots[at].translation()) && obstacle.look(at).is_none()).collect();
        let mut next = vec![u32::MAX; roots.len()];
        for at in (0..roots.len()).rev() {
            next[at] = if hits[at] { at as u32 } else { next.get(at + STRIDE).copied().unwrap_or(u32::MAX) };
        }
        Self { hits, next }
    }

    fn hits(&self, roots: std::ops::Range<usize>) -> bool {
        (self.next[roots.start] as usize) < roots.end || self.hits[roots.end - 1]
    }
}

/// Number of frames of a link that are looked at. [Limit: num_frames > 0]
fn num_looks(num_frames: usize) -> usize {
    (num_frames - 1).div_ceil(STRIDE) + 1
}

/// The frames of a link that are looked at; the last one in any case. [Limit: num_frames > 0]
pub(super) fn looked_at(num_frames: usize) -> impl Iterator<Item = usize> {
    (0..num_looks(num_frames)).map(move |i| (i * STRIDE).min(num_frames - 1))
}

/// The first look at a link that finds a collision.
///
/// - `look`: none where a frame collides, else how many frames before and after it do not either.
fn first_hit(num_frames: usize, look: &mut impl FnMut(usize) -> Option<usize>) -> Option<usize> {
    let mut at = 0;
    while at < num_looks(num_frames) {
        match look((at * STRIDE).min(num_frames - 1)) {
            None => return Some(at),
            Some(clear) => at += (clear / STRIDE).max(1),
        }
    }
    None
}

/// First and last frame of a link that collide. Of what is left or entered before a known collision, only the first one
/// matters, of what is after it only the last one.
fn of_link(
    num_frames: usize,
    known: Option<usize>,
    offsets: [u32; 2],
    mut look: impl FnMut(usize) -> Option<usize>,
) -> Option<Hit> {
    let frame = |i: usize| (i * STRIDE).min(num_frames - 1);
    let looks_to = |k: usize| k.div_ceil(STRIDE);
    let first = match known {
        Some(known) if known <= offsets[0] as usize => looks_to(known),
        _ => first_hit(num_frames, &mut look)?,
    };
    let least = known.map_or(first, looks_to);
    let mut last = if known.is_some_and(|k| k >= offsets[1] as usize) { least } else { num_looks(num_frames) - 1 };
    while last > least {
        let Some(clear) = look(frame(last)) else { break };
        last = last.saturating_sub((clear / STRIDE).max(1)).max(least);
    }
    Some(Hit { first: frame(first) as u16, last: frame(last) as u16 })
}

#[cfg(test)]
mod tests;
