//! Spawning and despawning: characters stay side by side in memory.

use super::block::{BodyBlock, MotionBlock, NO_STATE, SCHEDULED};
use super::{CharacterStart, Characters, control::draw_random, manner::MannerName, motion_set::MotionSet, pace};
use crate::body::{FootLock, Lanewise, LimbTouch, LocalTransform, Mat3x4, set_lane};
use crate::{planar::Planar, skeleton::NUM_JOINTS};
use glam::Vec3;
use throng_base::simd::LANES;

impl Characters {
    /// Adds a character after the last one (below the capacity, the state exists).
    pub(super) fn add_character(&mut self, motion_set: &MotionSet, start: CharacterStart, arrivals: &[u32], name: u64) {
        let at = self.num_characters;
        self.clear_row(at);
        let (block, lane) = (&mut self.blocks[at / LANES], at % LANES);
        let state = start.state as usize;
        block.start_at_state(lane, motion_set, start.root, motion_set.graph.states[state].frame, arrivals[state]);
        block.name[lane] = name;
        if self.touch.is_some() {
            self.touches.push(LimbTouch::default());
        }
        self.num_characters += 1;
        self.num_choosers += 1;
    }

    /// Height of the floor that one is on; 0 where the ground has one floor (m, at < num_characters).
    pub fn floor_m(&self, at: usize) -> f32 {
        self.blocks[at / LANES].floor[at % LANES]
    }

    /// Sets the height to which the floor of one is the nearest one (m, at < num_characters).
    pub(super) fn set_floor(&mut self, at: usize, floor_m: f32) {
        self.blocks[at / LANES].floor[at % LANES] = floor_m;
    }

    /// Empties a row, without writing memory that was never written (at < capacity).
    pub(super) fn clear_row(&mut self, at: usize) {
        self.blocks[at / LANES].copy_lane(at % LANES, &MotionBlock::ZERO, 0);
        self.bodies[at / LANES].clear(at % LANES);
        if self.last_pose(at).is_some() {
            self.matrices[at * NUM_JOINTS..][..NUM_JOINTS].fill(Mat3x4::default());
            if let Some(locals) = self.locals.get_mut(at * NUM_JOINTS..(at + 1) * NUM_JOINTS) {
                locals.fill(LocalTransform::default());
            }
        }
    }

    /// Removes a character; the last one takes its row (at < num_characters).
    pub fn remove_character(&mut self, at: usize) {
        let last = self.num_characters - 1;
        self.num_choosers -= usize::from(self.blocks[at / LANES].segment[at % LANES] != SCHEDULED);
        let from = self.blocks[last / LANES];
        self.blocks[at / LANES].copy_lane(at % LANES, &from, last % LANES);
        let body = self.bodies[last / LANES];
        self.bodies[at / LANES].take_lane(at % LANES, &body, last % LANES);
        if self.last_pose(last).is_some() || self.last_pose(at).is_some() {
            self.matrices.copy_within(last * NUM_JOINTS..(last + 1) * NUM_JOINTS, at * NUM_JOINTS);
            if !self.locals.is_empty() {
                self.locals.copy_within(last * NUM_JOINTS..(last + 1) * NUM_JOINTS, at * NUM_JOINTS);
            }
        }
        if !self.instances.is_empty() {
            self.instances[at] = self.instances[last];
        }
        if self.touch.is_some() {
            self.touches.swap_remove(at);
        }
        self.clear_row(last);
        self.num_characters -= 1;
        self.mark_paths_stale();
    }

    /// Lets one that has entered and not begun stand in a manner from the start, where there is room for it (at <
    /// num_characters).
    pub(super) fn enter_manner(&mut self, motion_set: &MotionSet, arrivals: &[u32], at: usize, manner: MannerName) {
        let (b, lane) = (&mut self.blocks[at / LANES], at % LANES);
        let (before, pace, graph) = (*b, b.pace[lane], &motion_set.graph);
        if b.segment[lane] == SCHEDULED || b.num_choices[lane] > 0 || b.time[lane] < b.length[lane] as f32 {
            return;
        }
        let wanted = motion_set.manners.wanted(manner, graph.segments[b.segment[lane] as usize].end);
        let draw = draw_random(b, lane, &self.config);
        let state = wanted.and_then(|manner| motion_set.manners.draw_state(&motion_set.stops.stops, manner, draw));
        let Some(state) = state else { return };
        let frame = graph.states[state as usize].frame;
        b.start_at_state(lane, motion_set, b.root(lane), frame, arrivals[state as usize]);
        b.pace[lane] = pace;
        if !self.reserve_path(motion_set, at) {
            self.blocks[at / LANES].copy_lane(lane, &before, lane);
            self.reserve_path(motion_set, at);
        }
    }

    /// Reserves the path of one that has come; where there is no room for the stop from its state, it is held in it.
    /// False where not even its place is free (at < num_characters, always true without avoidance).
    pub(super) fn reserve_start(&mut self, motion_set: &MotionSet, at: usize) -> bool {
        self.reserve_path(motion_set, at) || self.reserve_held(motion_set, at)
    }

    /// Holds one that has come, and reserves its place; false where that is another's (at < num_characters, always true
    /// without avoidance).
    pub(super) fn reserve_held(&mut self, motion_set: &MotionSet, at: usize) -> bool {
        if self.avoiding.is_some() {
            self.set_held(at, true);
        }
        self.reserve_path(motion_set, at)
    }

    /// Reserves the paths of all characters that have entered and not begun, all at once: each is held, which takes no
    /// more than its place, until there is room for the stop from its state. Returns one whose place is another's, if
    /// there is any (none without avoidance).
    pub(super) fn reserve_all(&mut self, motion_set: &MotionSet) -> Option<usize> {
        let n = self.num_characters;
        self.avoiding.as_ref()?;
        for at in 0..n {
            if self.has_not_begun(at) {
                self.set_held(at, true);
            }
        }
        let meets = self.avoiding.as_mut().and_then(|a| a.rebuild_paths(&self.blocks, n, motion_set));
        for at in 0..n {
            if self.has_not_begun(at) {
                self.set_held(at, false);
                self.reserve_start(motion_set, at);
            }
        }
        meets
    }

    /// True for one that waits where it has come, for its first choice (at < num_characters).
    fn has_not_begun(&self, at: usize) -> bool {
        let (b, lane) = (&self.blocks[at / LANES], at % LANES);
        b.choice_state[lane] == NO_STATE && b.time[lane] >= b.length[lane] as f32
    }

    /// Reserves the path of a character that was moved; false where it meets another path or a wall (at <
    /// num_characters, always true without avoidance).
    pub(super) fn reserve_path(&mut self, motion_set: &MotionSet, at: usize) -> bool {
        let n = self.num_characters;
        self.avoiding.as_mut().is_none_or(|a| a.reserve_path(&self.blocks, n, motion_set, at))
    }

    /// Holds one where it is, as after a stop in the middle of its motion; it chooses at the next step
    /// (at < num_characters).
    pub(super) fn set_held(&mut self, at: usize, holds: bool) {
        let (b, lane) = (&mut self.blocks[at / LANES], at % LANES);
        b.pace[lane] = if holds { pace::HELD_STILL } else { pace::NORMAL };
        b.wait[lane] = 0.0;
    }

    /// Moves a character elsewhere, with free feet (at < num_characters).
    pub(super) fn put_at(&mut self, motion_set: &MotionSet, at: usize, root: Planar) {
        let (b, lane) = (&mut self.blocks[at / LANES], at % LANES);
        // What it plays goes on as captured from here.
        b.bend[lane] = 0.0;
        if b.pace[lane] == pace::IN_PLACE {
            b.pace[lane] = pace::NORMAL;
            set_lane(&mut b.drift, lane, Vec3::ZERO);
        }
        let sampled = motion_set.planar_at(b.first[lane], b.time[lane].clamp(0.0, b.length[lane] as f32));
        b.set_clip_to_world(lane, root.compose(sampled.inverse()));
        b.set_choice_root(lane, root.compose(sampled.inverse()).compose(motion_set.planar_root(b.first[lane])));
        set_lane(&mut b.root, lane, Vec3::new(root.x, root.z, root.heading));
        let body = &mut self.bodies[at / LANES];
        if body.awake == 1 {
            body.feet.iter_mut().for_each(|foot| foot.copy_lane(lane, &FootLock::ZERO, 0));
            body.state.seen[lane] = 0.0;
        }
    }

    /// Ends what the touch of one that was moved elsewhere, and of its partner, displaces (at < num_characters).
    pub(super) fn reset_touch(&mut self, at: usize) {
        for (row, was_moved) in [(at, true), (at ^ 1, false)] {
            if let Some(touch) = self.touches.get_mut(row) {
                touch.reset(was_moved);
            }
        }
    }

    /// The block, the body and the lane of one (at < num_characters).
    pub(super) fn lane_mut(&mut self, at: usize) -> (&mut MotionBlock, &mut BodyBlock, usize) {
        (&mut self.blocks[at / LANES], &mut self.bodies[at / LANES], at % LANES)
    }

    /// The pose that one was last shown in; none before its first step (at < num_characters).
    pub(super) fn last_pose(&self, at: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        self.pose(at).first_chunk().filter(|pose| pose[0] != Mat3x4::default())
    }

    /// Copies state that does not depend on the bundle, from characters in the same order (at < num_characters).
    pub(super) fn carry_over(&mut self, old: &Self, at: usize) {
        let (from, lane) = (&old.blocks[at / LANES], at % LANES);
        self.blocks[at / LANES].num_choices[lane] = from.num_choices[lane];
        let reaction = &old.bodies[at / LANES].state.reaction;
        if reaction.active[lane] != 0.0 {
            self.bodies[at / LANES].state.reaction.copy_lane(lane, reaction, lane);
        }
        if let Some(shown) = old.last_pose(at) {
            self.matrices[at * NUM_JOINTS..][..NUM_JOINTS].copy_from_slice(shown);
        }
    }
}
