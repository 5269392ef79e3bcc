//! Collision sampling of the frames of links against a unit, with stored results.

use super::bodies::{Ball, Room};
use super::hit::{STRIDE, frame_of, look_at, num_looks};
use super::mask::Obstacle;
use super::seen::{Clearance, ENOUGH_M, Earlier, SLACK_M, Seen, Touch};
use glam::Vec3;
use std::ops::Range;

/// Results of the collision sampling of links.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::stitch) struct Looks {
    /// Result of each link.
    pub seen: Vec<Seen>,
    /// Clearances at each sampled frame of links that do not collide.
    pub clear: Vec<Clearance>,
}

/// Samples one link after the other.
pub(in crate::stitch) struct Looker<'l, 'a> {
    obstacle: &'l Obstacle<'a>,
    earlier: Option<Earlier<'l>>,
    /// Clearances, as in [`Looks::clear`].
    pub clear: Vec<Clearance>,
    /// Frame at which the last link collided.
    guess: usize,
    /// Samples to take, with the approximate distance of the unit from their roots (m).
    likely: Vec<(f32, usize)>,
}

impl<'l, 'a> Looker<'l, 'a> {
    /// - `earlier`: results for the unit at another place, which speed up equal ones.
    pub fn new(obstacle: &'l Obstacle<'a>, earlier: Option<Earlier<'l>>) -> Self {
        Self { obstacle, earlier, clear: Vec::new(), guess: 0, likely: Vec::new() }
    }

    /// Samples a link.
    ///
    /// - `radius`: largest distance of its bodies from their roots (m).
    pub fn see(&mut self, link: usize, roots: Range<usize>, radius: f32) -> Seen {
        let first = self.clear.len();
        let seen = self.look_again(link, &roots).unwrap_or_else(|| self.look_through(&roots, radius));
        if matches!(seen, Seen::Collides(_)) {
            self.clear.truncate(first);
        }
        seen
    }

    /// Samples again where the move of the unit matters; `None` if that is the whole link.
    fn look_again(&mut self, link: usize, roots: &Range<usize>) -> Option<Seen> {
        let Earlier { mask, moved } = self.earlier?;
        match *mask.looks.seen.get(link)? {
            Seen::Nothing => None,
            Seen::Collides(touch) if self.touches(touch.ball) => Some(Seen::Collides(touch)),
            Seen::Collides(touch) => {
                let look = look_at(usize::from(touch.frame));
                let near = [look, look + 1, look.wrapping_sub(1)].into_iter().filter(|&l| l < num_looks(roots.len()));
                near.map(|look| frame_of(look, roots.len())).find_map(|frame| self.look(roots, frame).err())
            }
            Seen::Clear(first) => {
                let begin = self.clear.len() as u32;
                let before = &mask.looks.clear[first as usize..first as usize + num_looks(roots.len())];
                for (look, clear) in before.iter().enumerate() {
                    match clear.after(moved).map_or_else(|| self.look(roots, frame_of(look, roots.len())), Ok) {
                        Ok(clear) => self.clear.push(clear),
                        Err(collides) => return Some(collides),
                    }
                }
                Some(Seen::Clear(begin))
            }
        }
    }

    /// Samples all frames of a link until one collides: first the one at which the previous link did, then in order of
    /// the distance of their roots from the unit.
    fn look_through(&mut self, roots: &Range<usize>, radius: f32) -> Seen {
        if self.guess < roots.len()
            && let Err(collides) = self.look(roots, self.guess)
        {
            return collides;
        }
        let first = self.clear.len();
        self.glance(roots, radius);
        let mut likely = std::mem::take(&mut self.likely);
        likely.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut seen = Seen::Clear(first as u32);
        for (_, look) in likely.drain(..) {
            let frame = frame_of(look, roots.len());
            match self.look(roots, frame) {
                Ok(clear) => self.clear[first + look] = clear,
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
    fn glance(&mut self, roots: &Range<usize>, radius: f32) {
        let num_looks = num_looks(roots.len());
        let step = STRIDE as f32 * self.obstacle.paths.step();
        let mut look = 0;
        while look < num_looks {
            let root = &self.obstacle.paths.roots()[roots.start + frame_of(look, roots.len())];
            let [x, z] = self.obstacle.in_unit(root.translation());
            let mut clear = self.obstacle.unit.plan().beside(x, z) - radius;
            if clear <= ENOUGH_M {
                self.likely.push((self.obstacle.unit.far(x, z), look));
            }
            // From there on, it approaches by at most its steps.
            loop {
                self.clear.push(Clearance::new(clear));
                (look, clear) = (look + 1, clear - step);
                if look == num_looks || clear <= ENOUGH_M {
                    break;
                }
            }
        }
    }

    /// Distance by which the unit may be moved without touching the body at a frame; the collision if there is one.
    fn look(&self, roots: &Range<usize>, frame: usize) -> Result<Clearance, Seen> {
        let (row, root) = self.obstacle.pose(roots.start + frame);
        let (bodies, unit) = (self.obstacle.bodies, self.obstacle.unit);
        let apart = bodies.apart(row, root, unit);
        if apart > ENOUGH_M {
            return Ok(Clearance::new(apart));
        }
        match bodies.room(row, root, unit, SLACK_M) {
            Room::Clear(clear) => Ok(Clearance::new(clear)),
            Room::Taken(ball) => {
                let centre = self.obstacle.at.transform_point(ball.centre);
                Err(Seen::Collides(Touch { frame: frame as u16, ball: Ball { centre, ..ball } }))
            }
        }
    }

    /// True if a sphere of a body, in the patch's frame, is certainly in the unit.
    fn touches(&self, ball: Ball) -> bool {
        /// Largest error of the distance by another order of placements (m).
        const ROUNDING_M: f32 = 1e-4;
        let [x, z] = self.obstacle.in_unit(ball.centre);
        let centre = Vec3::new(x, ball.centre.y - self.obstacle.at.y, z);
        self.obstacle.unit.is_nearer(centre, ball.limit - ROUNDING_M)
    }
}
