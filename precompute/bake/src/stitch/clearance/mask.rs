//! Parts of a patch's motion that a unit obstructs, for every relative placement of the unit.

use super::collision_span::{CollisionSpan, STRIDE, find_span};
use super::link_clearance::{EarlierMask, LinkClearance, ObstacleMask};
use super::sampler::{CollisionSampler, LinkSamples};
use super::{bodies::FrameBodies, field::DistanceField, swept::SweptSquares};
use crate::stitch::place::paths::LinkRoots;
use crate::stitch::sets::rows::{num_words, set_bit};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
use throng_core::{patch::Placement, planar::wrap_angle};
use throng_geometry::BoundingBox;

/// A unit as an obstacle to a patch's motion.
#[derive(Clone, Copy)]
pub(in crate::stitch) struct MotionObstacle<'a> {
    /// The motion.
    pub paths: &'a LinkRoots,
    /// The bodies of its frames.
    pub bodies: &'a FrameBodies,
    /// The unit.
    pub unit: &'a DistanceField,
    /// Placement in the patch's frame.
    pub at: Placement,
    /// Sine and cosine of its heading.
    turn: [f32; 2],
}

impl<'a> MotionObstacle<'a> {
    /// - `paths`, `bodies`: the motion, and the bodies of its frames.
    /// - `at`: placement of the unit in the patch's frame.
    pub fn new(paths: &'a LinkRoots, bodies: &'a FrameBodies, unit: &'a DistanceField, at: Placement) -> Self {
        Self { paths, bodies, unit, at, turn: at.heading.sin_cos().into() }
    }

    /// Largest displacement of any point of a unit, or near it, from one placement to another (m).
    pub fn greatest_shift(unit: &BoundingBox, from: Placement, to: Placement) -> f32 {
        let farthest = unit.min.abs().max(unit.max.abs()).with_y(0.0).length() + DistanceField::MARGIN_M;
        let turn = wrap_angle(to.heading - from.heading).abs();
        (to.translation() - from.translation()).length() + turn * farthest
    }

    /// Finds the colliding links.
    ///
    /// - `swept`: of the motion; `None` if links have most of their roots in common.
    /// - `earlier`: results for the unit at another place, which speed up equal ones.
    pub fn mask(&self, swept: Option<&SweptSquares>, earlier: Option<EarlierMask<'_>>) -> ObstacleMask {
        if self.unit.geometry.bounds.is_empty() {
            return ObstacleMask::default();
        }
        let near = self.bodies.root_bounds(&self.unit.geometry.bounds.mapped(|p| self.at.transform_point(p)));
        let num_links = self.paths.num_links();
        let Some(swept) = swept else {
            // Each root is sampled once, as a link of one frame.
            let is_near = |at: &u32| near.contains(self.paths.roots[*at as usize].translation());
            let roots: Vec<u32> = (0..self.paths.roots.len() as u32).filter(is_near).collect();
            let radius = |at: usize| self.bodies.reaches[self.paths.rows[at] as usize].radius;
            let samples = self.sample_links(&roots, |at| (at..at + 1, radius(at)), earlier, self.paths.roots.len());
            let shared = SharedRoots::new(&samples.clearance_of);
            let collides = |r: Range<usize>| (shared.next[r.start] as usize) < r.end || shared.hits[r.end - 1];
            let hit = (0..num_links as u32).filter(|&l| collides(self.paths.root_range(l as usize)));
            return ObstacleMask { words: link_bits(num_links, hit), samples, by_roots: true, ..Default::default() };
        };
        let order = &self.paths.play_order;
        let meeting = swept.links_meeting(&swept.shadow(self.unit, self.at)).into_iter().map(|k| order[k as usize]);
        let is_near = |l: &u32| near.overlaps(&self.paths.bounds[*l as usize]);
        let links: Vec<u32> = meeting.filter(is_near).collect();
        let samples =
            self.sample_links(&links, |link| (self.paths.root_range(link), swept.radii[link]), earlier, num_links);
        let collides = |l: &u32| matches!(samples.clearance_of[*l as usize], LinkClearance::Collides(_));
        let words = link_bits(num_links, links.iter().copied().filter(collides));
        ObstacleMask { words, samples, ..Default::default() }
    }

    /// Samples some links; consecutive ones play nearly equal motion.
    ///
    /// - `link`: its roots, and the largest distance of bodies from them (m).
    /// - `num_links`: number of all links.
    fn sample_links(
        &self,
        links: &[u32],
        link: impl Fn(usize) -> (Range<usize>, f32) + Sync,
        earlier: Option<EarlierMask<'_>>,
        num_links: usize,
    ) -> LinkSamples {
        let see = |links: &[u32]| {
            let mut looker = CollisionSampler::new(self, earlier);
            let seen = links.iter().map(|&l| {
                let (roots, radius) = link(l as usize);
                looker.sample_link(l as usize, roots, radius)
            });
            LinkSamples { clearance_of: seen.collect(), clear: looker.clear }
        };
        let parts: Vec<LinkSamples> = links.par_chunks(256).map(see).collect();
        let mut all = LinkSamples { clearance_of: vec![LinkClearance::Nothing; num_links], clear: Vec::new() };
        for (links, part) in links.chunks(256).zip(parts) {
            let first = all.clear.len() as u32;
            for (&l, seen) in links.iter().zip(part.clearance_of) {
                all.clearance_of[l as usize] = seen.offset_by(first);
            }
            all.clear.extend(part.clear);
        }
        all
    }

    /// First and last colliding frame of a link.
    ///
    /// - `mask`: result at this placement of the unit.
    pub fn collision_span(&self, mask: &ObstacleMask, link: usize) -> Option<CollisionSpan> {
        let range = self.paths.root_range(link);
        let find = || find_span(range.len(), mask.frame(link), |k| self.sample_root(range.start + k));
        mask.hits.span_of_link(link, self.paths.num_links(), find)
    }

    /// Samples a root: `None` for a collision, else how many frames before and after it are free too.
    fn sample_root(&self, at: usize) -> Option<usize> {
        let (row, root) = self.pose(at);
        let distance = self.unit.plan.least_distance(root.x, root.z) - self.bodies.radius;
        let clear = if distance > 0.0 { (distance / self.paths.longest_step.max(1e-3)) as usize } else { 0 };
        (clear > 0 || !self.bodies.collides(row, root, self.unit)).then_some(clear)
    }

    /// Frame row and root in the unit's frame.
    pub fn pose(&self, at: usize) -> (usize, Placement) {
        let p = &self.paths.roots[at];
        let [x, z] = self.in_unit(p.translation());
        (self.paths.rows[at] as usize, Placement::new(x, p.y - self.at.y, z, p.heading - self.at.heading))
    }

    /// x and z of a point in the unit's frame.
    pub fn in_unit(&self, p: Vec3) -> [f32; 2] {
        let ([sin, cos], x, z) = (self.turn, p.x - self.at.x, p.z - self.at.z);
        [cos * x - sin * z, sin * x + cos * z]
    }
}

/// Bits of some of a patch's links; empty if there are none.
fn link_bits(num_links: usize, links: impl Iterator<Item = u32>) -> Vec<u64> {
    let mut links = links.peekable();
    let mut words = vec![0; if links.peek().is_some() { num_words(num_links) } else { 0 }];
    links.for_each(|l| set_bit(&mut words, l));
    words
}

/// Collisions of roots shared by many links.
struct SharedRoots {
    hits: Vec<bool>,
    /// First colliding root among every [`STRIDE`]th from each one on (hits.len()).
    next: Vec<u32>,
}

impl SharedRoots {
    fn new(seen: &[LinkClearance]) -> Self {
        let hits: Vec<bool> = seen.iter().map(|s| matches!(s, LinkClearance::Collides(_))).collect();
        let mut next = vec![u32::MAX; hits.len()];
        for at in (0..hits.len()).rev() {
            next[at] = if hits[at] { at as u32 } else { next.get(at + STRIDE).copied().unwrap_or(u32::MAX) };
        }
        Self { hits, next }
    }
}

#[cfg(test)]
mod tests;
