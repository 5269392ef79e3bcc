//! Parts of a patch's motion that a unit obstructs, for every relative placement of the unit.

use super::bodies::Bodies;
use super::field::Field;
use super::hit::{Hit, Hits, STRIDE, of_link};
use super::looks::{Looker, Looks};
use super::seen::{Earlier, Mask, Seen};
use super::swept::Swept;
use crate::environment::Bounds;
use crate::stitch::place::paths::Paths;
use crate::stitch::sets::bits::{num_words, set};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
use throng_core::patch::Placement;
use throng_core::planar::wrap_angle;

/// A unit as an obstacle to a patch's motion.
#[derive(Clone, Copy)]
pub(in crate::stitch) struct Obstacle<'a> {
    /// The motion.
    pub paths: &'a Paths,
    /// The bodies of its frames.
    pub bodies: &'a Bodies,
    /// The unit.
    pub unit: &'a Field,
    /// Placement in the patch's frame.
    pub at: Placement,
    /// Sine and cosine of its heading.
    turn: [f32; 2],
}

impl<'a> Obstacle<'a> {
    /// - `paths`, `bodies`: the motion, and the bodies of its frames.
    /// - `at`: placement of the unit in the patch's frame.
    pub fn new(paths: &'a Paths, bodies: &'a Bodies, unit: &'a Field, at: Placement) -> Self {
        Self { paths, bodies, unit, at, turn: at.heading.sin_cos().into() }
    }

    /// Largest displacement of any point of a unit, or near it, from one placement to another (m).
    pub fn moved(unit: &Bounds, from: Placement, to: Placement) -> f32 {
        let farthest = unit.min.abs().max(unit.max.abs()).with_y(0.0).length() + Field::MARGIN_M;
        let turn = wrap_angle(to.heading - from.heading).abs();
        (to.translation() - from.translation()).length() + turn * farthest
    }

    /// Finds the colliding links.
    ///
    /// - `swept`: of the motion; `None` if links have most of their roots in common.
    /// - `earlier`: results for the unit at another place, which speed up equal ones.
    pub fn mask(&self, swept: Option<&Swept>, earlier: Option<Earlier<'_>>) -> Mask {
        if self.unit.geometry.bounds.is_empty() {
            return Mask::default();
        }
        let near = self.bodies.around(&self.unit.geometry.bounds.placed(self.at));
        let num_links = self.paths.num_links();
        let Some(swept) = swept else {
            // Each root is sampled once, as a link of one frame.
            let is_near = |at: &u32| near.contains(self.paths.roots()[*at as usize].translation());
            let roots: Vec<u32> = (0..self.paths.roots().len() as u32).filter(is_near).collect();
            let radius = |at: usize| self.bodies.radius_of(self.paths.rows()[at] as usize);
            let looks = self.see(&roots, |at| (at..at + 1, radius(at)), earlier, self.paths.roots().len());
            let shared = Shared::new(&looks.seen);
            let hit = (0..num_links as u32).filter(|&l| shared.hits(self.paths.range(l as usize)));
            return Mask { words: bits(num_links, hit), looks, by_roots: true, hits: Hits::default() };
        };
        let order = self.paths.order();
        let meeting = swept.meeting(&swept.shadow(self.unit, self.at)).into_iter().map(|k| order[k as usize]);
        let is_near = |l: &u32| near.overlaps(self.paths.bounds(*l as usize));
        let links: Vec<u32> = meeting.filter(is_near).collect();
        let looks = self.see(&links, |link| (self.paths.range(link), swept.radius(link)), earlier, num_links);
        let hit = links.iter().copied().filter(|&l| matches!(looks.seen[l as usize], Seen::Collides(_)));
        Mask { words: bits(num_links, hit), looks, by_roots: false, hits: Hits::default() }
    }

    /// Samples some links; consecutive ones play nearly equal motion.
    ///
    /// - `link`: its roots, and the largest distance of bodies from them (m).
    /// - `num_links`: number of all links.
    fn see(
        &self,
        links: &[u32],
        link: impl Fn(usize) -> (Range<usize>, f32) + Sync,
        earlier: Option<Earlier<'_>>,
        num_links: usize,
    ) -> Looks {
        let see = |links: &[u32]| {
            let mut looker = Looker::new(self, earlier);
            let seen = links.iter().map(|&l| {
                let (roots, radius) = link(l as usize);
                looker.see(l as usize, roots, radius)
            });
            Looks { seen: seen.collect(), clear: looker.clear }
        };
        let parts: Vec<Looks> = links.par_chunks(256).map(see).collect();
        let mut all = Looks { seen: vec![Seen::Nothing; num_links], clear: Vec::new() };
        for (links, part) in links.chunks(256).zip(parts) {
            let first = all.clear.len() as u32;
            links.iter().zip(part.seen).for_each(|(&l, seen)| all.seen[l as usize] = seen.after(first));
            all.clear.extend(part.clear);
        }
        all
    }

    /// First and last colliding frame of a link.
    ///
    /// - `mask`: result at this placement of the unit.
    pub fn hit(&self, mask: &Mask, link: usize) -> Option<Hit> {
        let range = self.paths.range(link);
        let find = || of_link(range.len(), mask.frame(link), |k| self.look(range.start + k));
        mask.hits.of(link, self.paths.num_links(), find)
    }

    /// Samples a root: `None` for a collision, else how many frames before and after it are free too.
    fn look(&self, at: usize) -> Option<usize> {
        let (row, root) = self.pose(at);
        let way = self.unit.plan().beside(root.x, root.z) - self.bodies.radius();
        let clear = if way > 0.0 { (way / self.paths.step().max(1e-3)) as usize } else { 0 };
        (clear > 0 || !self.bodies.collides(row, root, self.unit)).then_some(clear)
    }

    /// Frame row and root in the unit's frame.
    pub fn pose(&self, at: usize) -> (usize, Placement) {
        let p = &self.paths.roots()[at];
        let [x, z] = self.in_unit(p.translation());
        (self.paths.rows()[at] as usize, Placement::new(x, p.y - self.at.y, z, p.heading - self.at.heading))
    }

    /// x and z of a point in the unit's frame.
    pub fn in_unit(&self, p: Vec3) -> [f32; 2] {
        let ([sin, cos], x, z) = (self.turn, p.x - self.at.x, p.z - self.at.z);
        [cos * x - sin * z, sin * x + cos * z]
    }
}

/// Bits of some of a patch's links; empty if there are none.
fn bits(num_links: usize, links: impl Iterator<Item = u32>) -> Vec<u64> {
    let mut links = links.peekable();
    let mut words = vec![0; if links.peek().is_some() { num_words(num_links) } else { 0 }];
    links.for_each(|l| set(&mut words, l));
    words
}

/// Collisions of roots shared by many links.
struct Shared {
    hits: Vec<bool>,
    /// First colliding root among every [`STRIDE`]th from each one on (hits.len()).
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

#[cfg(test)]
mod tests;
