//! What of a patch's motion a unit is in the way of, for every way in which the unit may stand to the patch.

use super::bits::{num_words, set};
use super::bodies::{Bodies, beside};
use super::field::Field;
use super::paths::Paths;
use super::swept::Swept;
use crate::environment::Bounds;
use glam::Vec3;
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
    /// The motion.
    pub paths: &'a Paths,
    /// The bodies of its frames.
    pub bodies: &'a Bodies,
    /// The unit.
    pub unit: &'a Field,
    /// Where it stands in the patch's frame.
    pub at: Placement,
    /// Bodies may be that deep in it. [Unit: m]
    pub depth_m: f32,
}

impl Obstacle<'_> {
    /// Bits of the links that collide; no words where none does.
    ///
    /// - `swept`: of the motion; none where links have most of their roots in common.
    pub fn links(&self, swept: Option<&Swept>) -> Vec<u64> {
        if self.unit.geometry.bounds.is_empty() {
            return Vec::new();
        }
        let near = self.near();
        let links = (0..self.paths.num_links()).filter(|&l| near.overlaps(self.paths.bounds(l)));
        let mut words = vec![0; num_words(self.paths.num_links())];
        let mut none = true;
        let mut add = |l: usize| {
            none = false;
            set(&mut words, l as u32);
        };
        match swept {
            Some(swept) => {
                let shadow = swept.shadow(self.unit, self.at);
                let middle = self.at.transform_point(self.unit.geometry.bounds.centre());
                links.filter(|&l| swept.meets(l, &shadow) && self.hits(l, middle)).for_each(&mut add);
            }
            None => {
                let shared = Shared::new(self, &near);
                links.filter(|&l| shared.hits(self.paths.range(l))).for_each(&mut add);
            }
        }
        if none { Vec::new() } else { words }
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

    /// True where a link collides; the frame nearest to the middle of the unit is likely to.
    fn hits(&self, link: usize, middle: Vec3) -> bool {
        const SOME: usize = 4;
        let range = self.paths.range(link);
        let distance = |k: &usize| {
            let r = self.paths.roots()[range.start + k];
            (r.x - middle.x).powi(2) + (r.z - middle.z).powi(2)
        };
        let nearest = looked_at(range.len()).step_by(SOME).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.is_some_and(|k| self.look(range.start + k).is_none())
            || first_hit(range.len(), &mut |k| self.look(range.start + k)).is_some()
    }

    /// Looks at a root: none where it collides, else how many frames before and after it do not either.
    fn look(&self, at: usize) -> Option<usize> {
        let (sin, cos) = self.at.heading.sin_cos();
        let p = self.paths.roots()[at];
        let (x, z) = (p.x - self.at.x, p.z - self.at.z);
        let root = Placement::new(cos * x - sin * z, p.y - self.at.y, sin * x + cos * z, p.heading - self.at.heading);
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
