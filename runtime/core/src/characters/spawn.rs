//! Spawning and despawning: characters stay side by side in memory.

use super::block::{Block, LAID};
use super::lanes::Lanewise;
use super::motion_set::MotionSet;
use super::{Characters, CharactersConfig, Start};
use crate::planar::Planar;
use crate::pose::{FootLock, LocalTransform, Mat3x4, set};
use crate::skeleton::NUM_JOINTS;
use glam::Vec3;
use throng_base::simd::LANES;

impl Characters {
    pub(super) fn config(&self) -> &CharactersConfig {
        &self.config
    }

    /// Most blows of a step.
    pub(super) fn most_blows(&self) -> usize {
        self.blows.room()
    }

    /// Adds a character after the last one (below the capacity, the state exists).
    pub(super) fn enter(&mut self, motion_set: &MotionSet, start: Start, arrivals: &[u32], name: u64) {
        let at = self.num_characters;
        let (block, lane) = (&mut self.blocks[at / LANES], at % LANES);
        let state = start.state as usize;
        block.take(lane, &Block::ZERO, 0);
        block.start(lane, motion_set, start.root, motion_set.graph.states[state].frame, arrivals[state]);
        block.name[lane] = name;
        self.matrices[at * NUM_JOINTS..][..NUM_JOINTS].fill(Mat3x4::default());
        if let Some(locals) = self.locals.get_mut(at * NUM_JOINTS..(at + 1) * NUM_JOINTS) {
            locals.fill(LocalTransform::default());
        }
        self.num_characters += 1;
        self.num_choosers += 1;
    }

    /// One leaves, and the last one takes its place (at < num_characters).
    pub fn leave(&mut self, at: usize) {
        let last = self.num_characters - 1;
        self.num_choosers -= usize::from(self.blocks[at / LANES].segment[at % LANES] != LAID);
        let from = self.blocks[last / LANES];
        self.blocks[at / LANES].take(at % LANES, &from, last % LANES);
        self.blocks[last / LANES].take(last % LANES, &Block::ZERO, 0);
        self.matrices.copy_within(last * NUM_JOINTS..(last + 1) * NUM_JOINTS, at * NUM_JOINTS);
        if !self.locals.is_empty() {
            self.locals.copy_within(last * NUM_JOINTS..(last + 1) * NUM_JOINTS, at * NUM_JOINTS);
        }
        self.num_characters -= 1;
    }

    /// Puts one elsewhere, with free feet (at < num_characters).
    pub(super) fn put(&mut self, motion_set: &MotionSet, at: usize, root: Planar) {
        let (b, lane) = (&mut self.blocks[at / LANES], at % LANES);
        // As a step samples it: between two rows, linearly.
        let time = b.time[lane].max(0.0);
        let whole = (time as u32).min(b.length[lane].saturating_sub(1));
        let rows = [0, 1].map(|k| motion_set.planar(b.first[lane] + whole + k));
        let between = |from: f32, to: f32| from + (to - from) * (time - whole as f32);
        let [from, to] = rows;
        let sampled = Planar::new(between(from.x, to.x), between(from.z, to.z), between(from.heading, to.heading));
        b.set_clip_to_world(lane, root.compose(sampled.inverse()));
        set(&mut b.root, lane, Vec3::new(root.x, root.z, root.heading));
        b.feet.iter_mut().for_each(|foot| foot.take(lane, &FootLock::ZERO, 0));
    }

    /// What random choices of one depend on (at < num_characters).
    pub(super) fn name(&self, at: usize) -> u64 {
        self.blocks[at / LANES].name[at % LANES]
    }

    /// The block and lane of one (at < num_characters).
    pub(super) fn lane_mut(&mut self, at: usize) -> (&mut Block, usize) {
        (&mut self.blocks[at / LANES], at % LANES)
    }

    /// The pose that one was last shown in; none before its first step (at < num_characters).
    pub(super) fn shown(&self, at: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        self.pose(at).first_chunk().filter(|pose| pose[0] != Mat3x4::default())
    }

    /// Takes over what does not belong to a bundle, from characters in the same order (at < num_characters).
    pub(super) fn carry_over(&mut self, old: &Self, at: usize) {
        let (from, lane) = (&old.blocks[at / LANES], at % LANES);
        let block = &mut self.blocks[at / LANES];
        block.num_choices[lane] = from.num_choices[lane];
        block.reaction.take(lane, &from.reaction, lane);
        self.matrices[at * NUM_JOINTS..][..NUM_JOINTS].copy_from_slice(old.pose(at));
    }
}
