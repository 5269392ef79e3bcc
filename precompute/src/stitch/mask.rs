//! What of a patch's motion a unit is in the way of, for every way in which the unit may stand to the patch.

use super::bits::{num_words, set};
use super::bodies::{Bodies, beside};
use super::field::Field;
use super::paths::Paths;
use super::swept::Swept;
use crate::environment::Bounds;
use rayon::prelude::*;
use throng_runtime::patch::Placement;

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
    depth_m: f32,
}

impl<'a> Obstacle<'a> {
    /// - `paths`, `bodies`: the motion, and the bodies of its frames.
    /// - `at`: where the unit stands in the patch's frame.
    /// - `depth_m`: bodies may be that deep in it. [Unit: m]
    pub fn new(paths: &'a Paths, bodies: &'a Bodies, unit: &'a Field, at: Placement, depth_m: f32) -> Self {
        Self { paths, bodies, unit, at, turn: at.heading.sin_cos().into(), depth_m }
    }

    /// Bits of the links that collide; no words where none does.
    ///
    /// - `swept`: of the motion; none where links have most of their roots in common.
    pub fn links(&self, swept: Option<&Swept>) -> Vec<u64> {
        if self.unit.geometry.bounds.is_empty() {
            return Vec::new();
        }
        let near = self.near();
        let words = match swept {
            Some(swept) => {
                let shadow = swept.shadow(self.unit, self.at);
                self.words(|l| near.overlaps(self.paths.bounds(l)) && swept.meets(l, &shadow) && self.hits(l))
            }
            None => {
                let shared = Shared::new(self, &near);
                self.words(|l| near.overlaps(self.paths.bounds(l)) && shared.hits(self.paths.range(l)))
            }
        };
        if words.iter().all(|w| *w == 0) { Vec::new() } else { words }
    }

    /// Bits of the links that something is true of, asked in the order in which they share frames.
    fn words(&self, of: impl Fn(usize) -> bool + Sync) -> Vec<u64> {
        let found: Vec<u32> =
            self.paths.order().par_iter().with_min_len(256).copied().filter(|&l| of(l as usize)).collect();
        let mut words = vec![0; num_words(self.paths.num_links())];
        found.into_iter().for_each(|l| set(&mut words, l));
        words
    }

    /// First and last frame of a link that collide: from both ends, so that what lies between is not looked at.
    pub fn hit(&self, link: usize) -> Option<Hit> {
        let range = self.paths.range(link);
        of_link(range.len(), |k| self.look(range.start + k))
    }

    /// Where a root must be for its body to touch the unit.
    fn near(&self) -> Bounds {
        self.bodies.around(&self.unit.geometry.bounds.placed(self.at))
    }

    /// True where a link collides. Of each quarter of it the frame at which the unit is nearest to the root is looked at
    /// first: it is likely to.
    fn hits(&self, link: usize) -> bool {
        const QUARTERS: usize = 4;
        let range = self.paths.range(link);
        let looks = num_looks(range.len());
        let mut likely = [(f32::INFINITY, 0); QUARTERS];
        for (i, k) in looked_at(range.len()).enumerate() {
            let [x, z] = self.in_unit(&self.paths.roots()[range.start + k]);
            let (distance, quarter) = (self.unit.far(x, z), &mut likely[i * QUARTERS / looks]);
            if distance < quarter.0 {
                *quarter = (distance, k);
            }
        }
        likely.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let collides = |k: usize| self.look(range.start + k).is_none();
        likely.iter().any(|&(_, k)| collides(k))
            || first_hit(range.len(), &mut |k| self.look(range.start + k)).is_some()
    }

    /// x and z of a root in the unit's frame.
    fn in_unit(&self, root: &Placement) -> [f32; 2] {
        let ([sin, cos], x, z) = (self.turn, root.x - self.at.x, root.z - self.at.z);
        [cos * x - sin * z, sin * x + cos * z]
    }

    /// Looks at a root: none where it collides, else how many frames before and after it do not either.
    fn look(&self, at: usize) -> Option<usize> {
        let p = &self.paths.roots()[at];
        let [x, z] = self.in_unit(p);
        let root = Placement::new(x, p.y - self.at.y, z, p.heading - self.at.heading);
        let way = beside(&self.unit.geometry.bounds, root) - self.bodies.radius();
        if way > 0.0 {
            return Some((way / self.paths.step().max(1e-3)) as usize);
        }
        let hit = self.bodies.collides(self.paths.rows()[at] as usize, root, self.unit, self.depth_m);
        (!hit).then_some(0)
    }
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

/// First and last frame of a link that collide.
fn of_link(num_frames: usize, mut look: impl FnMut(usize) -> Option<usize>) -> Option<Hit> {
    let frame = |i: usize| (i * STRIDE).min(num_frames - 1);
    let first = first_hit(num_frames, &mut look)?;
    let mut last = num_looks(num_frames) - 1;
    while last > first {
        let Some(clear) = look(frame(last)) else { break };
        last = last.saturating_sub((clear / STRIDE).max(1)).max(first);
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
        let hit = |frames: &[usize]| of_link(30, |k| (!frames.contains(&k)).then(|| clear(frames, k)));
        assert_eq!(hit(&[]), None);
        assert_eq!(hit(&[4, 6, 20]), Some(Hit { first: 4, last: 20 }));
        assert_eq!(hit(&[29]), Some(Hit { first: 29, last: 29 }));
        assert_eq!(hit(&[8]), Some(Hit { first: 8, last: 8 }));
        assert_eq!(Hit { first: 8, last: 8 }.union(Hit { first: 2, last: 4 }), Hit { first: 2, last: 8 });
    }
}
