//! Characters that make way: each reserves the ground of what it does and of the stop that may follow, and takes no action
//! whose ground meets another's.
//!
//! The proof. Whenever a character has chosen, its path leads on to a stand and stays there, and meets no other path: that of
//! a chosen action because it was tested, that of a stop because it is the rest of the path that it has. Places of roots
//! are on their paths, which hold the bodies' discs. So no two discs ever overlap, whatever policies want. Choices are
//! made one after the other, in the order of their times within a step and of characters, so that threads change nothing.

mod choose;
mod path;
mod steer;

use super::Characters;
use super::block::Block;
use super::motion_set::MotionSet;
use super::pace;
use crate::reserve::{Held, Moving, Outsider, Path, ROUNDING_M, Reservations, Rod};
use crate::stops::BODY_RADIUS_M;
use glam::Vec2;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use throng_base::Result;
use throng_base::error::check;
use throng_base::simd::LANES;

pub(crate) use choose::{Step, choose};
pub(crate) use path::Plan;

/// How characters make way for each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AvoidConfig {
    /// How far ahead a collision is steered clear of (s, 0 to 20; 0 only stops).
    pub horizon_s: f32,
    /// Room that is left between bodies where there is a choice (m, 0 to 10).
    pub room_m: f32,
    /// How far characters 2i and 2i + 1 may come into each other's discs, who do not turn aside for each other, as opponents
    /// do; none where they make way as anybody (m, 0 to 10).
    pub pairs_m: Option<f32>,
}

impl Default for AvoidConfig {
    fn default() -> Self {
        Self { horizon_s: 2.0, room_m: 0.1, pairs_m: None }
    }
}

impl AvoidConfig {
    pub(super) fn check(&self) -> Result<()> {
        check("avoid.horizon_s", None, self.horizon_s, (0.0..=20.0).contains(&self.horizon_s), "between 0 and 20")?;
        check("avoid.room_m", None, self.room_m, (0.0..=10.0).contains(&self.room_m), "between 0 and 10")?;
        let pairs_m = self.pairs_m.unwrap_or(0.0);
        check("avoid.pairs_m", None, pairs_m, (0.0..=10.0).contains(&pairs_m), "between 0 and 10")
    }
}

/// The reservations of characters, and memory to work with.
///
/// All of it follows from the characters' state, so that snapshots do without.
#[derive(Clone, Debug)]
pub(crate) struct Avoiding {
    pub book: Reservations,
    /// Who comes to the end of a segment within the step, the first one on top: how long ago at its end (bits of frames).
    due: BinaryHeap<(u32, Reverse<u32>)>,
    /// The path that is tried.
    path: Path,
    /// Speed of those who walk (m/s).
    speed_mps: f32,
    turns: steer::Turns,
    /// See [`AvoidConfig::pairs_m`].
    pairs: bool,
    /// Paths follow from the state no more, as somebody was moved.
    is_stale: bool,
}

impl Avoiding {
    /// Room for so many characters.
    pub fn new(motion_set: &MotionSet, config: &AvoidConfig, capacity: usize) -> Self {
        let room = path::most_nodes(motion_set);
        let path = Path { nodes: Vec::with_capacity(room), ..Path::default() };
        let mut book = Reservations::with_capacity(capacity, room);
        book.set_group_depth(config.pairs_m.unwrap_or(0.0));
        Self {
            book,
            due: BinaryHeap::with_capacity(capacity),
            path,
            speed_mps: walking_speed(motion_set),
            turns: steer::turns(),
            pairs: config.pairs_m.is_some(),
            is_stale: true,
        }
    }

    /// Somebody was moved: all paths are laid anew at the next step.
    pub fn stale(&mut self) {
        self.is_stale = true;
    }

    /// Lays the path of one anew, from its state; false where it meets another's or a wall.
    fn lay(&mut self, blocks: &[Block], motion_set: &MotionSet, at: usize) -> bool {
        let (b, lane) = (&blocks[at / LANES], at % LANES);
        path::of_state(b, lane, motion_set, &mut self.path);
        let elapsed_s = elapsed_s(b, lane, motion_set);
        self.book.set_group(at, self.pairs.then_some(at as u32 / 2));
        let clear = self.book.meets_none(at, &Moving { nodes: &self.path.nodes, elapsed_s }, 0.0, -ROUNDING_M);
        self.book.set(at, &self.path, elapsed_s);
        clear
    }

    /// As [`Self::lay`], where the paths of all `n` others may have to be laid first.
    pub fn reserve(&mut self, blocks: &[Block], n: usize, motion_set: &MotionSet, at: usize) -> bool {
        if self.is_stale {
            self.rebuild(blocks, n, motion_set);
        }
        self.lay(blocks, motion_set, at)
    }

    /// Lays all paths anew, from the state of characters; one whose path meets another's, if any does.
    pub fn rebuild(&mut self, blocks: &[Block], n: usize, motion_set: &MotionSet) -> Option<usize> {
        self.book.clear();
        self.is_stale = false;
        (0..n).filter(|&at| !self.lay(blocks, motion_set, at)).last()
    }
}

/// Time since the path of a character began (s).
fn elapsed_s(b: &Block, lane: usize, motion_set: &MotionSet) -> f32 {
    pace::time(b.pace[lane], b.length[lane] as f32, b.time[lane]) / motion_set.rate_hz
}

/// The middle one of the speeds of segments that lead anywhere (m/s).
fn walking_speed(motion_set: &MotionSet) -> f32 {
    let speed = |s: &crate::graph::MotionSegment| {
        let d = s.displacement();
        throng_base::maths::hypot(d.x, d.z) * motion_set.rate_hz / s.num_frames as f32
    };
    let mut speeds: Vec<f32> = motion_set.graph.segments.iter().map(speed).filter(|v| *v > 0.4).collect();
    speeds.sort_unstable_by(f32::total_cmp);
    speeds.get(speeds.len() / 2).copied().unwrap_or(1.0)
}

impl Characters {
    /// What stands for good, for characters that make way: nobody walks into it. Others take no notice.
    ///
    /// Set it before anybody walks there: whoever is on the way through a new wall goes on to its stop, and may have to stay.
    pub fn set_walls(&mut self, walls: &[Rod]) {
        if let Some(avoiding) = &mut self.avoiding {
            avoiding.book.set_walls(walls);
        }
    }

    /// Whom others move, for characters that make way: nobody walks onto ground that these hold.
    pub fn mind<'a>(&mut self, others: impl Iterator<Item = &'a Held>) {
        if let Some(avoiding) = &mut self.avoiding {
            avoiding.book.outsiders_mut().set(others);
        }
    }

    /// Minds what other characters mind.
    pub(super) fn surround_as(&mut self, other: &Self) {
        if let (Some(avoiding), Some(other)) = (&mut self.avoiding, &other.avoiding) {
            avoiding.book.surround_as(&other.book);
        }
    }

    /// Adds all bodies, and the ground that they hold: of those who make way, what they need for what they do and for the
    /// stop after it.
    pub fn hold_ground(&mut self, motion_set: &MotionSet, out: &mut Held) {
        let n = self.num_characters;
        if let Some(avoiding) = self.avoiding.as_mut().filter(|a| a.is_stale) {
            avoiding.rebuild(&self.blocks, n, motion_set);
        }
        if let Some(avoiding) = &self.avoiding {
            // What is held before a step and after it, however long the ways become.
            let most = 2 * n * Moving::most_held(avoiding.book.room());
            out.ground.reserve(most.saturating_sub(out.ground.len()));
        }
        for at in 0..n {
            let root = self.root(at);
            let mut body =
                Outsider { place: Vec2::new(root.x, root.z), radius_m: BODY_RADIUS_M, ..Outsider::default() };
            match &self.avoiding {
                Some(avoiding) => {
                    body.velocity = avoiding.book.velocity(at);
                    avoiding.book.path(at).hold(&mut out.ground);
                    out.bodies.push(body);
                }
                None => out.ahead(body),
            }
        }
    }

    /// Moves one over the ground as a whole, unless that is in another's way; see [`Characters::shift`].
    pub(super) fn shift_aside(&mut self, motion_set: &MotionSet, at: usize, by: Vec2) -> Result<()> {
        let is_stale = self.avoiding.as_ref().is_some_and(|a| a.is_stale);
        let before = self.blocks[at / LANES];
        self.shift(at, by)?;
        if let Some(avoiding) = &mut self.avoiding {
            // Nobody else was moved.
            avoiding.is_stale = is_stale;
            if !self.reserve(motion_set, at) {
                self.blocks[at / LANES] = before;
                self.reserve(motion_set, at);
            }
        }
        Ok(())
    }

    /// Choices in a row at which nothing was clear for a character that makes way (character < num_characters).
    pub fn blocked(&self, character: usize) -> u32 {
        self.blocks[character / LANES].blocked[character % LANES]
    }

    /// The reservations of characters that make way, by number.
    pub fn reservations(&self) -> Option<&Reservations> {
        self.avoiding.as_ref().map(|a| &a.book)
    }
}

#[cfg(test)]
mod tests;
