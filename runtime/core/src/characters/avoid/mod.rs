//! Collision avoidance of characters: each reserves the ground of its action and of the stop that may follow, and takes
//! no action whose ground meets another's.
//!
//! The proof. Whenever a character has chosen, its path leads on to a stand and stays there, and meets no other path:
//! that of a chosen action because it was tested, that of a stop because it is the rest of the character's own path.
//! Roots are on their paths, whose discs hold the bodies. So no two discs ever overlap, whatever the policies choose.
//! Choices are made one after the other, in the order of their times within a step and of characters, so that threads
//! change nothing.

mod choose;
mod path;
mod steer;

use super::{Characters, block::MotionBlock, motion_set::MotionSet, pace};
use crate::body::HeightField;
use crate::reserve::{
    ExternalObstacle, FloorWall, PathReservations, ROUNDING_M, ReservedPath, ReservedRegion, TimedPath,
};
use crate::stops::BODY_RADIUS_M;
use glam::Vec2;
use std::{cmp::Reverse, collections::BinaryHeap};
use throng_base::{Result, error::check_range, simd::LANES, thresholds::WALKING_MPS};

pub(crate) use choose::ChoiceInputs;
pub(crate) use path::{SegmentPlan, stop_of};

/// Settings of collision avoidance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AvoidConfig {
    /// Time ahead within which collisions are avoided by steering (s, 0 to 20; 0 only stops).
    pub horizon_s: f32,
    /// Room that is left between bodies where there is a choice (m, 0 to 10).
    pub room_m: f32,
    /// Depth to which the discs of characters 2i and 2i + 1 may overlap; such pairs, as opponents are, do not turn
    /// aside for each other. None treats them as any others (m, 0 to 10).
    pub pairs_m: Option<f32>,
}

impl Default for AvoidConfig {
    fn default() -> Self {
        Self { horizon_s: 2.0, room_m: 0.1, pairs_m: None }
    }
}

impl AvoidConfig {
    pub(super) fn check(&self) -> Result<()> {
        check_range("avoid.horizon_s", self.horizon_s, 0.0..=20.0, "between 0 and 20")?;
        check_range("avoid.room_m", self.room_m, 0.0..=10.0, "between 0 and 10")?;
        check_range("avoid.pairs_m", self.pairs_m.unwrap_or(0.0), 0.0..=10.0, "between 0 and 10")
    }
}

/// The reservations of characters, and memory to work with.
///
/// All of it follows from the characters' state, so that snapshots do without.
#[derive(Clone, Debug)]
pub(crate) struct PathAvoidance {
    pub book: PathReservations,
    /// Characters that reach the end of a segment within the step, the first one on top: time since that end (bits of
    /// frames).
    due: BinaryHeap<(u32, Reverse<u32>)>,
    /// The path that is tried.
    path: ReservedPath,
    /// Speed of a walking character (m/s).
    speed_mps: f32,
    turns: steer::Turns,
    /// The ground that all stand on.
    pub ground: HeightField,
    /// See [`AvoidConfig::pairs_m`].
    pairs: bool,
    /// True after a character was moved: paths no longer follow from the state.
    is_stale: bool,
}

impl PathAvoidance {
    /// Room for so many characters.
    pub fn new(motion_set: &MotionSet, config: &AvoidConfig, capacity: usize) -> Self {
        let room = path::most_nodes(motion_set);
        let path = ReservedPath { nodes: Vec::with_capacity(room), ..ReservedPath::default() };
        let mut book = PathReservations::with_capacity(capacity, room);
        book.group_depth_m = config.pairs_m.unwrap_or(0.0);
        Self {
            book,
            due: BinaryHeap::with_capacity(capacity),
            path,
            speed_mps: walking_speed(motion_set),
            turns: steer::candidate_turns(),
            ground: HeightField::flat(),
            pairs: config.pairs_m.is_some(),
            is_stale: true,
        }
    }

    /// Finds the heights of the ground on the path that is tried.
    ///
    /// - `near_m`: height to which the floor at its beginning is the nearest one (m).
    fn find_heights(&mut self, near_m: f32) {
        if self.ground.has_floors() {
            let mut height = near_m;
            self.path.heights_m = [near_m; 2];
            for node in &self.path.nodes {
                height = self.ground.ground_at(node.place, height).height;
                let [low, high] = self.path.heights_m;
                self.path.heights_m = [low.min(height), high.max(height)];
            }
        }
    }

    /// Reserves the path of one character anew, from its state; false where it meets another path or a wall.
    fn update_path(&mut self, blocks: &[MotionBlock], motion_set: &MotionSet, at: usize) -> bool {
        let (b, lane) = (&blocks[at / LANES], at % LANES);
        path::path_of_state(b, lane, motion_set, &mut self.path);
        self.find_heights(b.floor[lane]);
        let elapsed_s = elapsed_s(b, lane, motion_set);
        self.book.set_group(at, self.pairs.then_some(at as u32 / 2));
        let clear = self.book.is_clear_of_all(at, &self.path.begun(elapsed_s), 0.0, -ROUNDING_M);
        self.book.set(at, &self.path, elapsed_s);
        clear
    }

    /// Reserves the path of one character, and first those of all `n` characters where they are stale; see
    /// [`Self::update_path`].
    pub fn reserve_path(&mut self, blocks: &[MotionBlock], n: usize, motion_set: &MotionSet, at: usize) -> bool {
        if self.is_stale {
            self.rebuild_paths(blocks, n, motion_set);
        }
        self.update_path(blocks, motion_set, at)
    }

    /// Reserves all paths anew, from the state of the characters; returns one whose path meets another one, if there is
    /// any.
    pub fn rebuild_paths(&mut self, blocks: &[MotionBlock], n: usize, motion_set: &MotionSet) -> Option<usize> {
        self.book.clear();
        self.is_stale = false;
        (0..n).filter(|&at| !self.update_path(blocks, motion_set, at)).last()
    }
}

/// Time since the path of a character began (s).
fn elapsed_s(b: &MotionBlock, lane: usize, motion_set: &MotionSet) -> f32 {
    pace::time_at_frame(b.pace[lane], b.length[lane] as f32, b.time[lane]) / motion_set.rate_hz
}

/// The middle one of the speeds of segments that lead anywhere (m/s).
fn walking_speed(motion_set: &MotionSet) -> f32 {
    let speed = |s: &crate::graph::MotionSegment| {
        let d = s.displacement();
        throng_base::maths::hypot(d.x, d.z) * motion_set.rate_hz / s.num_frames as f32
    };
    let speeds = motion_set.graph.segments.iter().map(speed).filter(|v| *v > WALKING_MPS);
    throng_base::maths::quantile(speeds, [1, 2]).unwrap_or(1.0)
}

impl Characters {
    /// Sets the walls, which characters with collision avoidance never enter. Others ignore them.
    ///
    /// Set walls before characters walk there: a character whose path crosses a new wall goes on to its stop, and may
    /// be unable to leave.
    pub fn set_walls(&mut self, walls: impl IntoIterator<Item: Into<FloorWall>>) {
        if let Some(avoiding) = &mut self.avoiding {
            avoiding.book.set_walls(walls.into_iter().map(Into::into));
        }
    }

    /// Sets the external obstacles: characters with collision avoidance do not enter the regions that these reserve.
    pub fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        if let Some(avoiding) = &mut self.avoiding {
            avoiding.book.external_obstacles.replace_all(others);
        }
    }

    /// Marks all paths as stale after a character was moved: they are reserved anew at the next step.
    pub(super) fn mark_paths_stale(&mut self) {
        if let Some(avoiding) = &mut self.avoiding {
            avoiding.is_stale = true;
        }
    }

    /// Copies walls and external obstacles from other characters.
    pub(super) fn copy_surroundings(&mut self, other: &Self) {
        if let (Some(avoiding), Some(other)) = (&mut self.avoiding, &other.avoiding) {
            avoiding.book.copy_surroundings(&other.book);
            avoiding.ground = other.ground.clone();
        }
    }

    /// Adds the bodies of all characters and the regions that they reserve: with collision avoidance, those of their
    /// actions and of the stops after them.
    pub fn add_reserved_regions(&mut self, motion_set: &MotionSet, out: &mut ReservedRegion) {
        let n = self.num_characters;
        if let Some(avoiding) = self.avoiding.as_mut().filter(|a| a.is_stale) {
            avoiding.rebuild_paths(&self.blocks, n, motion_set);
        }
        if let Some(avoiding) = &self.avoiding {
            // Regions reserved before a step and after it, however long the paths become.
            let most = 2 * n * TimedPath::max_reserved_regions(avoiding.book.max_nodes);
            out.ground.reserve(most.saturating_sub(out.ground.len()));
        }
        for at in 0..n {
            let root = self.root(at);
            let mut body = ExternalObstacle {
                place: Vec2::new(root.x, root.z),
                radius_m: BODY_RADIUS_M,
                ..ExternalObstacle::default()
            };
            match &self.avoiding {
                Some(avoiding) => {
                    body.velocity = avoiding.book.velocity(at);
                    avoiding.book.path(at).add_reserved_regions(&mut out.ground);
                    out.bodies.push(body);
                }
                None => out.reserve_ahead(body),
            }
        }
    }

    /// Moves a character over the ground as a whole, unless that blocks another one; see [`Characters::shift_by`].
    pub(super) fn shift_aside(&mut self, motion_set: &MotionSet, at: usize, by: Vec2) -> Result<()> {
        let is_stale = self.avoiding.as_ref().is_some_and(|a| a.is_stale);
        let before = self.blocks[at / LANES];
        self.shift_by(at, by)?;
        if let Some(avoiding) = &mut self.avoiding {
            // No other character was moved.
            avoiding.is_stale = is_stale;
            if !self.reserve_path(motion_set, at) {
                self.blocks[at / LANES] = before;
                self.reserve_path(motion_set, at);
            }
        }
        Ok(())
    }

    /// Number of choices in a row at which no action of a character with collision avoidance was clear (character <
    /// num_characters).
    pub fn num_blocked_choices(&self, character: usize) -> u32 {
        self.blocks[character / LANES].blocked[character % LANES]
    }

    /// Reservations of the characters with collision avoidance, by number.
    pub fn reservations(&self) -> Option<&PathReservations> {
        self.avoiding.as_ref().map(|a| &a.book)
    }
}

#[cfg(test)]
mod tests;
