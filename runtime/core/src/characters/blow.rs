//! Blows: the effective hits that characters pass as their motion plays (Lee and Lee 2004, section 6).

use super::motion_set::MotionSet;
use crate::{planar::Planar, skeleton::Joint};
use glam::Vec3;
use throng_base::maths;

/// Most blows of one character in one step; what it strikes beyond them in so long a step is left out.
pub const MAX_BLOWS: usize = 4;

/// An effective hit that a character has reached or is about to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blow {
    /// Striking character.
    pub character: u32,
    /// Number of the hit in [`crate::Bundle::hits`].
    pub hit: u32,
    /// The joint that strikes.
    pub joint: Joint,
    /// See [`crate::HitRecord::kind`].
    pub kind: u32,
    /// Effective place in the world, as it was captured (m).
    pub point: Vec3,
    /// Direction of the blow in the world, of unit length.
    pub direction: Vec3,
    /// Speed of the striking point (m/s).
    pub speed_mps: f32,
    /// Speed over that of the fastest hit of its kind (> 0, <= 1).
    pub force: f32,
}

impl Blow {
    /// Placeholder in memory that holds no blow.
    pub const NONE: Self = Self {
        character: 0,
        hit: 0,
        joint: Joint::Hips,
        kind: 0,
        point: Vec3::ZERO,
        direction: Vec3::Z,
        speed_mps: 0.0,
        force: 0.0,
    };

    /// Blow of a hit, by a character whose clip is placed in the world by `clip_to_world`.
    pub(crate) fn new(motion_set: &MotionSet, character: u32, hit: u32, clip_to_world: Planar) -> Self {
        let h = &motion_set.hits[hit as usize];
        let root = clip_to_world.compose(motion_set.planar_root(h.frame));
        let turn = root.rotation();
        Self {
            character,
            hit,
            joint: Joint::ALL[h.joint as usize],
            kind: h.kind,
            point: maths::rotate(turn, h.position()) + root.translation(),
            direction: maths::rotate(turn, h.direction()),
            speed_mps: h.speed_mps,
            force: h.force,
        }
    }
}

/// A hit that was passed, and the placement of the clip at that time.
#[derive(Clone, Copy, Debug)]
struct PassedHit {
    character: u32,
    hit: u32,
    clip_to_world: Planar,
}

/// The hits that the characters of one range pass in a step; memory for all of them, or none where there are no hits.
#[derive(Clone, Debug)]
pub(crate) struct PassedHits {
    slots: Vec<PassedHit>,
    len: usize,
}

impl PassedHits {
    /// Room for a number of characters.
    pub fn new(num_characters: usize, motion_set: &MotionSet) -> Self {
        let room = if motion_set.hits.is_empty() { 0 } else { num_characters * MAX_BLOWS };
        Self { slots: vec![PassedHit { character: 0, hit: 0, clip_to_world: Planar::IDENTITY }; room], len: 0 }
    }

    /// Forgets the last step.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// True where there is nothing to be passed.
    pub fn is_off(&self) -> bool {
        self.slots.is_empty()
    }

    /// Adds the hits of a segment after `from` and up to `to` (frames since the segment's start).
    #[inline]
    pub fn add_passed(&mut self, r: &MotionSet, character: u32, segment: u32, from: f32, to: f32, place: Planar) {
        let start = r.graph.segments[segment as usize].start;
        let offset = |hit: u32| (r.hits[hit as usize].frame - start) as f32;
        for hit in r.hits_after(segment, from).take_while(|&hit| offset(hit) <= to) {
            self.add(PassedHit { character, hit, clip_to_world: place });
        }
    }

    fn add(&mut self, passed: PassedHit) {
        let before = self.slots[..self.len].iter().filter(|p| p.character == passed.character).count();
        if before < MAX_BLOWS {
            self.slots[self.len] = passed;
            self.len += 1;
        }
    }

    /// Sorts the hits by character, and those of one character by time.
    ///
    /// They nearly are sorted: only a character that changed its segment within the step has hits in two places.
    pub fn sort(&mut self) {
        for i in 1..self.len {
            let mut at = i;
            while at > 0 && self.slots[at - 1].character > self.slots[at].character {
                self.slots.swap(at - 1, at);
                at -= 1;
            }
        }
    }
}

/// The blows of the last step, of all characters; memory for all of them.
#[derive(Clone, Debug)]
pub(crate) struct Blows {
    slots: Vec<Blow>,
    len: usize,
}

impl Blows {
    /// Room for what all ranges may pass.
    pub fn new(ranges: &[PassedHits]) -> Self {
        Self { slots: vec![Blow::NONE; ranges.iter().map(|r| r.slots.len()).sum()], len: 0 }
    }

    /// Most blows of a step.
    pub fn max_blows(&self) -> usize {
        self.slots.len()
    }

    /// Collects the blows of a step from its ranges.
    pub fn gather_blows(&mut self, ranges: &[PassedHits], motion_set: &MotionSet) {
        self.len = 0;
        for p in ranges.iter().flat_map(|r| &r.slots[..r.len]) {
            self.slots[self.len] = Blow::new(motion_set, p.character, p.hit, p.clip_to_world);
            self.len += 1;
        }
    }

    pub fn get(&self) -> &[Blow] {
        &self.slots[..self.len]
    }
}
