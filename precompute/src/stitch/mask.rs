//! What of a patch's motion a unit is in the way of, for every way in which the unit may stand to the patch.

use super::bits::{num_words, set};
use super::bodies::{Ball, Bodies, Room};
use super::field::Field;
use super::paths::Paths;
use super::seen::{After, Clear, Earlier, Mask, SLACK_M, Seen, Touch};
use super::swept::Swept;
use crate::environment::Bounds;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
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
        let Some(swept) = swept else { return self.mask_of_roots(&near, earlier) };
        let is_near = |l: &u32| near.overlaps(self.paths.bounds(*l as usize));
        let num_links = self.paths.num_links();
        let order = self.paths.order();
        let meeting = swept.meeting(&swept.shadow(self.unit, self.at)).into_iter().map(|k| order[k as usize]);
        let links: Vec<u32> = meeting.filter(is_near).collect();
        let found: Vec<Seen> = links.par_chunks(256).flat_map_iter(|links| self.see(links, swept, earlier)).collect();
        let mut seen = vec![Seen::Nothing; num_links];
        links.iter().zip(&found).for_each(|(&l, &s)| seen[l as usize] = s);
        let hit = links.iter().zip(&found).filter(|(_, s)| matches!(s, Seen::Collides(_)));
        Mask { words: bits(num_links, hit.map(|(&l, _)| l)), links: seen, roots: Vec::new() }
    }

    /// The same where links have most of their roots in common: each root is looked at once.
    fn mask_of_roots(&self, near: &Bounds, earlier: Option<Earlier<'_>>) -> Mask {
        let roots = self.paths.roots();
        let see = |at: usize| {
            if !near.contains(roots[at].translation()) {
                return Seen::Nothing;
            }
            let known = earlier.and_then(|e| e.mask.roots.get(at).map(|seen| (*seen, e.moved)));
            let again = known.and_then(|(seen, moved)| self.look_again(at..at + 1, seen, moved));
            again.unwrap_or_else(|| self.look_closely(at..at + 1, Clear::new(), 0..1))
        };
        let seen: Vec<Seen> = (0..roots.len()).into_par_iter().with_min_len(1024).map(see).collect();
        let num_links = self.paths.num_links();
        let shared = Shared::new(&seen);
        let hit = (0..num_links as u32).filter(|&l| shared.hits(self.paths.range(l as usize)));
        Mask { words: bits(num_links, hit), links: Vec::new(), roots: seen }
    }

    /// Looks at some links; those that follow each other in [`Paths::order`] play much the same.
    fn see(&self, links: &[u32], swept: &Swept, earlier: Option<Earlier<'_>>) -> Vec<Seen> {
        let mut guess = Guess::default();
        let mut see = |link: usize| {
            let range = self.paths.range(link);
            let known = earlier.and_then(|e| e.mask.links.get(link).map(|seen| (*seen, e.moved)));
            let again = known.and_then(|(seen, moved)| self.look_again(range.clone(), seen, moved));
            again.unwrap_or_else(|| self.look_through(range, swept.radius(link), &mut guess))
        };
        links.iter().map(|&l| see(l as usize)).collect()
    }

    /// Looks at what may not be as it was seen before the unit was moved; none where that is all of a link.
    ///
    /// - `roots`: the link's.
    fn look_again(&self, roots: Range<usize>, seen: Seen, moved: f32) -> Option<Seen> {
        match seen {
            Seen::Nothing => None,
            Seen::Collides(touch) if self.touches(touch.ball) => Some(seen),
            Seen::Collides(touch) => self.collides(roots.start, usize::from(touch.frame)),
            Seen::Clear(clear) => match clear.after(moved) {
                After::Clear(clear) => Some(Seen::Clear(clear)),
                After::Near(known) => {
                    let frames = known.near(looked_at(roots.len()));
                    Some(self.look_closely(roots, known, frames))
                }
                After::Unknown => None,
            },
        }
    }

    /// True where a point of a body, in the patch's frame, is in the unit beyond doubt.
    fn touches(&self, ball: Ball) -> bool {
        /// A body that is placed another way is no farther away than this. [Unit: m]
        const ROUNDING_M: f32 = 1e-4;
        let [x, z] = self.in_unit(ball.centre);
        let centre = Vec3::new(x, ball.centre.y - self.at.y, z);
        self.unit.is_nearer(centre, ball.limit - ROUNDING_M)
    }

    /// What of a link collides at one of its frames.
    ///
    /// - `first`: the link's first root.
    fn collides(&self, first: usize, frame: usize) -> Option<Seen> {
        match self.room(first + frame, 0.0) {
            Room::Clear(_) => None,
            Room::Taken(ball) => Some(self.seen(frame, ball)),
        }
    }

    /// A point of a body that is in the unit, in the unit's frame.
    fn seen(&self, frame: usize, ball: Ball) -> Seen {
        let centre = self.at.transform_point(ball.centre);
        Seen::Collides(Touch { frame: frame as u16, ball: Ball { centre, ..ball } })
    }

    /// Looks at some frames of a link until one collides.
    ///
    /// - `roots`: the link's.
    /// - `known`: of all other frames.
    fn look_closely(&self, roots: Range<usize>, known: Clear, frames: impl Iterator<Item = usize>) -> Seen {
        let (mut clear, most) = (known, known.least());
        for k in frames {
            match self.room(roots.start + k, most) {
                Room::Clear(clearance) if clearance < most => clear.add(k, clearance),
                Room::Clear(_) => {}
                Room::Taken(ball) => return self.seen(k, ball),
            }
        }
        Seen::Clear(clear)
    }

    /// How far the unit may be moved without touching the body at a root.
    ///
    /// - `most`: what is clearer is not told apart.
    fn room(&self, at: usize, most: f32) -> Room {
        let (row, root) = self.pose(at);
        self.bodies.room(row, root, self.unit, most)
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
    /// - `roots`: the link's.
    /// - `radius`: no body of the link reaches farther from its root. [Unit: m]
    fn look_through(&self, roots: Range<usize>, radius: f32, guess: &mut Guess) -> Seen {
        if guess.frame < roots.len()
            && let Some(seen) = self.collides(roots.start, guess.frame)
        {
            return seen;
        }
        guess.likely.clear();
        first_hit(roots.len(), &mut |k| {
            let [x, z] = self.in_unit(self.paths.roots()[roots.start + k].translation());
            let clear = self.clear(x, z, radius + SLACK_M);
            if clear == 0 {
                guess.likely.push((self.unit.far(x, z), k));
            }
            Some(clear)
        });
        guess.likely.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let frames = guess.likely.iter().map(|(_, k)| *k);
        let seen = self.look_closely(roots, Clear::new(), frames);
        // The last frame of a link is looked at in any case; of others, that one may not be.
        if let Seen::Collides(touch) = seen
            && usize::from(touch.frame).is_multiple_of(STRIDE)
        {
            guess.frame = usize::from(touch.frame);
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
        let [x, z] = self.in_unit(p.translation());
        (self.paths.rows()[at] as usize, Placement::new(x, p.y - self.at.y, z, p.heading - self.at.heading))
    }

    /// x and z of a point in the unit's frame.
    fn in_unit(&self, p: Vec3) -> [f32; 2] {
        let ([sin, cos], x, z) = (self.turn, p.x - self.at.x, p.z - self.at.z);
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

/// What roots collide that many links have in common.
struct Shared {
    hits: Vec<bool>,
    /// The first root that collides among every [`STRIDE`]th from one on. [Size: hits.len()]
    next: Vec<u32>,
}

impl Shared {
    fn new(seen: &[Seen]) -> Self {
        let hits: Vec<bool> = seen.iter().map(|s| matches!(s, Seen::Collides(_))).collect();
        let mut next = vec![u32::MAX; hits.len()];
        for at in (0..hits.len()).rev() {
            next[at] = if hits[at] { at as u32 } else { next.get(at + STRIDE).copied().unwrap_or(u32::MAX) };
        }
        Self { hits, next }
    }

    fn hits(&self, roots: Range<usize>) -> bool {
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
