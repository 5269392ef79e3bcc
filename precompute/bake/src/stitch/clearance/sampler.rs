//! Collision sampling of the frames of links against a unit, with stored results.

use super::bodies::{BodyPoint, UnitRoom};
use super::collision_span::{STRIDE, frame_of, frame_of_sample, num_samples};
use super::link_clearance::{Clearance, ENOUGH_M, EarlierMask, LinkClearance, LinkCollision, SLACK_M};
use super::mask::MotionObstacle;
use glam::Vec3;
use std::ops::Range;

/// Results of the collision sampling of links.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::stitch) struct LinkSamples {
    /// Result of each link.
    pub clearance_of: Vec<LinkClearance>,
    /// Clearances at each sampled frame of links that do not collide.
    pub clear: Vec<Clearance>,
}

/// Samples one link after the other.
pub(in crate::stitch) struct CollisionSampler<'l, 'a> {
    obstacle: &'l MotionObstacle<'a>,
    earlier: Option<EarlierMask<'l>>,
    /// Clearances, as in [`LinkSamples::clear`].
    pub clear: Vec<Clearance>,
    /// Frame at which the last link collided.
    guess: usize,
    /// Samples to take, with the approximate distance of the unit from their roots (m).
    likely: Vec<(f32, usize)>,
}

impl<'l, 'a> CollisionSampler<'l, 'a> {
    /// - `earlier`: results for the unit at another place, which speed up equal ones.
    pub fn new(obstacle: &'l MotionObstacle<'a>, earlier: Option<EarlierMask<'l>>) -> Self {
        Self { obstacle, earlier, clear: Vec::new(), guess: 0, likely: Vec::new() }
    }

    /// Samples a link.
    ///
    /// - `radius`: largest distance of its bodies from their roots (m).
    pub fn sample_link(&mut self, link: usize, roots: Range<usize>, radius: f32) -> LinkClearance {
        let first = self.clear.len();
        let seen = self.resample(link, &roots).unwrap_or_else(|| self.sample_all(&roots, radius));
        if matches!(seen, LinkClearance::Collides(_)) {
            self.clear.truncate(first);
        }
        seen
    }

    /// Samples again where the move of the unit matters; `None` if that is the whole link.
    fn resample(&mut self, link: usize, roots: &Range<usize>) -> Option<LinkClearance> {
        let EarlierMask { mask, moved } = self.earlier?;
        match *mask.samples.clearance_of.get(link)? {
            LinkClearance::Nothing => None,
            LinkClearance::Collides(touch) if self.touches(touch.ball) => Some(LinkClearance::Collides(touch)),
            LinkClearance::Collides(touch) => {
                let sample = frame_of_sample(usize::from(touch.frame));
                let near =
                    [sample, sample + 1, sample.wrapping_sub(1)].into_iter().filter(|&l| l < num_samples(roots.len()));
                near.map(|sample| frame_of(sample, roots.len())).find_map(|frame| self.sample_frame(roots, frame).err())
            }
            LinkClearance::Clear(first) => {
                let begin = self.clear.len() as u32;
                let before = &mask.samples.clear[first as usize..first as usize + num_samples(roots.len())];
                for (sample, clear) in before.iter().enumerate() {
                    match clear
                        .after_move(moved)
                        .map_or_else(|| self.sample_frame(roots, frame_of(sample, roots.len())), Ok)
                    {
                        Ok(clear) => self.clear.push(clear),
                        Err(collides) => return Some(collides),
                    }
                }
                Some(LinkClearance::Clear(begin))
            }
        }
    }

    /// Samples all frames of a link until one collides: first the one at which the previous link did, then in order of
    /// the distance of their roots from the unit.
    fn sample_all(&mut self, roots: &Range<usize>, radius: f32) -> LinkClearance {
        if self.guess < roots.len()
            && let Err(collides) = self.sample_frame(roots, self.guess)
        {
            return collides;
        }
        let first = self.clear.len();
        self.estimate_clearance(roots, radius);
        let mut likely = std::mem::take(&mut self.likely);
        likely.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut seen = LinkClearance::Clear(first as u32);
        for (_, sample) in likely.drain(..) {
            let frame = frame_of(sample, roots.len());
            match self.sample_frame(roots, frame) {
                Ok(clear) => self.clear[first + sample] = clear,
                Err(collides) => {
                    // The last frame of a link is always sampled; at other links it may not be.
                    if frame.is_multiple_of(STRIDE) {
                        self.guess = frame;
                    }
                    seen = collides;
                    break;
                }
            }
        }
        likely.clear();
        self.likely = likely;
        seen
    }

    /// Estimates the clearance of a link where it passes far from the unit, and collects the frames to sample.
    fn estimate_clearance(&mut self, roots: &Range<usize>, radius: f32) {
        let num_sampled = num_samples(roots.len());
        let step = STRIDE as f32 * self.obstacle.paths.longest_step;
        let mut sample = 0;
        while sample < num_sampled {
            let root = &self.obstacle.paths.roots[roots.start + frame_of(sample, roots.len())];
            let [x, z] = self.obstacle.in_unit(root.translation());
            let mut clear = self.obstacle.unit.plan.least_distance(x, z) - radius;
            if clear <= ENOUGH_M {
                self.likely.push((self.obstacle.unit.distance_to_line(x, z), sample));
            }
            // From there on, it approaches by at most its steps.
            loop {
                self.clear.push(Clearance::new(clear));
                (sample, clear) = (sample + 1, clear - step);
                if sample == num_sampled || clear <= ENOUGH_M {
                    break;
                }
            }
        }
    }

    /// Distance by which the unit may be moved without touching the body at a frame; the collision if there is one.
    fn sample_frame(&self, roots: &Range<usize>, frame: usize) -> Result<Clearance, LinkClearance> {
        let (row, root) = self.obstacle.pose(roots.start + frame);
        let (bodies, unit) = (self.obstacle.bodies, self.obstacle.unit);
        let apart = bodies.reaches[row].least_distance(root, unit);
        if apart > ENOUGH_M {
            return Ok(Clearance::new(apart));
        }
        match bodies.room(row, root, unit, SLACK_M) {
            UnitRoom::Clear(clear) => Ok(Clearance::new(clear)),
            UnitRoom::Taken(ball) => {
                let centre = self.obstacle.at.transform_point(ball.centre);
                Err(LinkClearance::Collides(LinkCollision { frame: frame as u16, ball: BodyPoint { centre, ..ball } }))
            }
        }
    }

    /// True if a sphere of a body, in the patch's frame, is certainly in the unit.
    fn touches(&self, ball: BodyPoint) -> bool {
        /// Largest error of the distance by another order of placements (m).
        const ROUNDING_M: f32 = 1e-4;
        let [x, z] = self.obstacle.in_unit(ball.centre);
        let centre = Vec3::new(x, ball.centre.y - self.obstacle.at.y, z);
        self.obstacle.unit.is_nearer(centre, ball.limit - ROUNDING_M)
    }
}
