//! Looks at the frames of links for bodies that are in a unit, and remembers what it saw.

use super::bodies::{Ball, Room};
use super::hit::{STRIDE, frame_of, look_at, num_looks};
use super::mask::Obstacle;
use super::seen::{Clearance, ENOUGH_M, Earlier, SLACK_M, Seen, Touch};
use glam::Vec3;
use std::ops::Range;

/// What was seen of links.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::stitch) struct Looks {
    /// Of each link.
    pub seen: Vec<Seen>,
    /// How clear of the unit links that do not collide are at each frame that is looked at.
    pub clear: Vec<Clearance>,
}

/// Looks at one link after the other.
pub(in crate::stitch) struct Looker<'l, 'a> {
    obstacle: &'l Obstacle<'a>,
    earlier: Option<Earlier<'l>>,
    /// As [`Looks::clear`].
    pub clear: Vec<Clearance>,
    /// Frame at which the last link collided.
    guess: usize,
    /// Looks that have to be taken, and about how far the unit is from the roots (m).
    likely: Vec<(f32, usize)>,
}

impl<'l, 'a> Looker<'l, 'a> {
    /// - `earlier`: where the unit stood elsewhere: what is the same as there is found sooner.
    pub fn new(obstacle: &'l Obstacle<'a>, earlier: Option<Earlier<'l>>) -> Self {
        Self { obstacle, earlier, clear: Vec::new(), guess: 0, likely: Vec::new() }
    }

    /// Looks at a link.
    ///
    /// - `radius`: no body of it reaches farther from its root (m).
    pub fn see(&mut self, link: usize, roots: Range<usize>, radius: f32) -> Seen {
        let first = self.clear.len();
        let seen = self.look_again(link, &roots).unwrap_or_else(|| self.look_through(&roots, radius));
        if matches!(seen, Seen::Collides(_)) {
            self.clear.truncate(first);
        }
        seen
    }

    /// Looks at what may not be as it was before the unit was moved; none where that is all of a link.
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

    /// Looks at all frames of a link, until one collides: first at the one at which the link before did, then at those
    /// to whose roots the unit is nearest.
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
                    // The last frame of a link is looked at in any case; of others, that one may not be.
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

    /// Finds how clear a link is of the unit where it passes far from it, and where it has to be looked at.
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
            // On from there, it comes nearer by no more than its steps.
            loop {
                self.clear.push(Clearance::new(clear));
                (look, clear) = (look + 1, clear - step);
                if look == num_looks || clear <= ENOUGH_M {
                    break;
                }
            }
        }
    }

    /// How far the unit may be moved without touching the body at a frame; what collides where it does.
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

    /// True where a point of a body, in the patch's frame, is in the unit beyond doubt.
    fn touches(&self, ball: Ball) -> bool {
        /// A body that is placed another way is no farther away than this (m).
        const ROUNDING_M: f32 = 1e-4;
        let [x, z] = self.obstacle.in_unit(ball.centre);
        let centre = Vec3::new(x, ball.centre.y - self.obstacle.at.y, z);
        self.obstacle.unit.is_nearer(centre, ball.limit - ROUNDING_M)
    }
}
