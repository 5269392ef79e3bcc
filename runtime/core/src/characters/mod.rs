//! Characters: many characters, moved and posed together.

mod adopt;
mod answer;
mod avoid;
mod bent;
mod block;
mod blow;
mod carriage;
mod config;
mod control;
mod decay;
mod detail;
mod idle;
#[cfg(any(test, feature = "made-up"))]
#[path = "../../tests/common/made_up.rs"]
pub mod made_up;
mod manner;
mod motion_set;
mod order;
mod pace;
mod policy_characters;
mod sample_job;
mod scheduled_clip;
mod snapshot;
mod spawn;
mod step;
#[cfg(test)]
pub(crate) mod tests;
mod transition;

pub use crate::body::FootLockConfig;
pub use crate::body::ReactionConfig;
pub use crate::body::head_centre;
use crate::body::{
    BodyVolume, HeightField, LimbTouch, LocalTransform, Mat3x4, PartnerTouch, RANGE_BLOCKS, RANGE_LEN, TouchConfig,
};
pub use crate::body::{Detail, DetailLevel, PoseInstance};
use crate::skeleton::{Joint, NUM_JOINTS};
use crate::{bundle::Bundle, contacts::Contacts, planar::Planar};
pub use avoid::AvoidConfig;
use avoid::PathAvoidance;
use block::{BodyBlock, MotionBlock};
pub use blow::{Blow, MAX_BLOWS};
use blow::{Blows, PassedHits};
use bytemuck::zeroed_vec;
pub use config::{ActionChoice, CharactersConfig};
pub use control::uniform_random;
use glam::{Vec2, Vec3};
pub use motion_set::MotionSet;
pub use order::{BundlePolicy, PolicyOrder};
pub use policy_characters::{ARRIVED_M, PolicyCharacters, Spawn};
pub use sample_job::SampleJob;
pub use scheduled_clip::ScheduledClip;
pub use snapshot::CharactersSnapshot;
use step::{CharacterRange, CharactersTick};
use throng_base::error::{check_index, check_length, check_value, ensure};
use throng_base::limits::{CAPACITY, STEP_S};
use throng_base::{Error, Executor, Id, Inline, Result, maths, run_each, simd::LANES};

/// Frames between which a character last travelled, and where a point of its body is in them: frames last longer than most steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct TravelPoints([(Option<u32>, Vec3); 2]);

/// Most behaviours weighed against each other in one step.
pub const MAX_GOALS: usize = control::MAX_GOALS;

/// Start of a character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterStart {
    /// Planar root in the world.
    pub root: Planar,
    /// State of the motion graph (< number of states).
    pub state: u32,
}

/// The engine beneath [`PolicyCharacters`], which applications use: rows without ids or orders.
///
/// Characters that move together, eight to a block; all memory is allocated at the start.
///
/// Every tick, [`Characters::step`] moves time on, lets characters at the end of a segment choose their next action by
/// the policies, samples and blends their motion, locks planted feet, and leaves each character's planar root,
/// contacts and joint matrices to be read.
#[derive(Clone, Debug)]
pub struct Characters {
    config: CharactersConfig,
    num_characters: usize,
    /// Number of characters that choose for themselves; the others play scheduled clips.
    num_choosers: usize,
    num_segments: usize,
    /// Bundle whose content is played.
    bundle: Bundle,
    blocks: Vec<MotionBlock>,
    /// (blocks)
    bodies: Vec<BodyBlock>,
    /// (blocks)
    levels: Vec<DetailLevel>,
    detail: Option<Detail>,
    passed: Vec<PassedHits>,
    blows: Blows,
    matrices: Vec<Mat3x4>,
    locals: Vec<LocalTransform>,
    instances: Vec<PoseInstance>,
    /// The ground that all stand on.
    ground: HeightField,
    /// What stops limbs at the body of a partner, if anything does, and their displacements (num_characters, or 0).
    touch: Option<Box<PartnerTouch>>,
    touches: Vec<LimbTouch>,
    /// Collision avoidance, if it is on.
    avoiding: Option<Box<PathAvoidance>>,
}

/// State and root of a character when it chose its action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastChoice {
    /// State it was in.
    pub state: u32,
    /// Planar root in the world.
    pub root: Planar,
}

impl Characters {
    /// Places a character at every start. Poses are there after the first step.
    ///
    /// # Errors
    /// [`Error::Index`] for a state that does not exist, [`Error::Value`] for a start that is not finite or a setting
    /// out of its range, [`Error::Occupied`] for characters with collision avoidance that start inside each other.
    pub fn new(motion_set: &MotionSet, config: CharactersConfig, starts: &[CharacterStart]) -> Result<Self> {
        let mut out = Self::with_capacity(motion_set, config, starts.len())?;
        let arrivals = segments_into_states(motion_set);
        for (c, start) in starts.iter().enumerate() {
            let who = Some(Id::first(c));
            check_index("state", who, start.state as usize, motion_set.graph.states.len())?;
            check_root(who, start.root)?;
            out.add_character(motion_set, *start, &arrivals, c as u64);
        }
        out.reserve_all(motion_set).map_or(Ok(out), |at| Err(occupied_error(Id::first(at))))
    }

    /// Room for characters that enter later: see [`Characters::enter_scheduled`].
    ///
    /// # Errors
    /// [`Error::Value`] for a setting or capacity out of its range.
    pub fn with_capacity(motion_set: &MotionSet, config: CharactersConfig, capacity: usize) -> Result<Self> {
        config.check()?;
        CAPACITY.check_count("capacity", capacity)?;
        let ranges = (0..capacity).step_by(RANGE_LEN).map(|first| RANGE_LEN.min(capacity - first));
        let passed: Vec<_> = ranges.map(|count| PassedHits::new(count, motion_set)).collect();
        let num_blocks = capacity.div_ceil(LANES);
        Ok(Self {
            config,
            num_characters: 0,
            num_choosers: 0,
            num_segments: motion_set.graph.segments.len(),
            bundle: motion_set.bundle.clone(),
            blocks: vec![MotionBlock::ZERO; num_blocks],
            // Memory for bodies that are never posed is never written, and takes no room.
            bodies: zeroed_vec(num_blocks),
            levels: vec![DetailLevel::Full; num_blocks],
            detail: None,
            blows: Blows::new(&passed),
            passed,
            matrices: zeroed_vec(capacity * NUM_JOINTS),
            locals: vec![LocalTransform::default(); if config.local_transforms { capacity * NUM_JOINTS } else { 0 }],
            instances: zeroed_vec(if config.instances { capacity } else { 0 }),
            ground: HeightField::flat(),
            touch: None,
            touches: Vec::new(),
            avoiding: config.avoid.map(|avoid| Box::new(PathAvoidance::new(motion_set, &avoid, capacity))),
        })
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.num_characters
    }

    /// Moves every character on by `dt_s` on this thread. Allocates nothing.
    ///
    /// - `orders`: (num_characters, or none where all play scheduled clips)
    ///
    /// # Errors
    /// [`Error`] where `dt_s` is not in `0..=1`, orders do not fit, or the motion set is another bundle's; nothing has
    /// moved then.
    pub fn step(&mut self, motion_set: &MotionSet, dt_s: f32, orders: &[PolicyOrder]) -> Result<()> {
        self.step_on(motion_set, dt_s, orders, &Inline)
    }

    /// Moves every character on, on threads of the caller's choice. The result equals that of [`Characters::step`] bit
    /// by bit.
    ///
    /// # Errors
    /// As [`Characters::step`].
    pub fn step_on(
        &mut self,
        motion_set: &MotionSet,
        dt_s: f32,
        orders: &[PolicyOrder],
        run: &dyn Executor,
    ) -> Result<()> {
        self.check_bundle(motion_set)?;
        STEP_S.check("dt_s", None, dt_s)?;
        // Characters on scheduled clips choose nothing.
        if self.num_choosers > 0 || !orders.is_empty() {
            check_length("orders", orders.len(), self.num_characters)?;
        }
        for (character, order) in orders.iter().enumerate() {
            order.check(Some(Id::first(character)), motion_set)?;
        }
        self.run(motion_set, dt_s, orders, run);
        Ok(())
    }

    /// Takes one step with checked arguments.
    pub(super) fn run(&mut self, motion_set: &MotionSet, dt_s: f32, orders: &[PolicyOrder], run: &dyn Executor) {
        let (config, ground, partners) = (self.config, self.ground.clone(), self.touch.take());
        let (config, ground, touch) = (&config, &ground, partners.as_deref());
        let tick = CharactersTick { dt_s, motion_set, config, ground, orders, touch, moves: true };
        let n = self.num_characters;
        let num_ranges = n.div_ceil(RANGE_LEN);
        if let Some(detail) = &self.detail {
            for (at, (level, block)) in self.levels.iter_mut().zip(&self.blocks[..n.div_ceil(LANES)]).enumerate() {
                *level = detail.level(&block.root, (n - at * LANES).min(LANES));
            }
        }
        match &config.avoid {
            Some(avoid) => {
                // First all move on, then they choose one after the other, then all are posed.
                let blocks = self.blocks[..n.div_ceil(LANES)].chunks_mut(RANGE_BLOCKS);
                let parts = blocks.zip(&mut self.passed).enumerate();
                run_each(run, parts, |(i, (blocks, passed))| {
                    let (first, count) = range_span(i, n);
                    step::advance_all(blocks, passed, first, count, &tick);
                });
                self.choose_avoiding(&avoid::ChoiceInputs { motion_set, config, avoid, orders });
                self.passed[..num_ranges].iter_mut().for_each(|passed| passed.sort());
                run_each(run, self.ranges(), |range| step::pose_all(range, &tick));
            }
            None => run_each(run, self.ranges(), |range| step::step(range, &tick)),
        }
        self.blows.gather_blows(&self.passed[..num_ranges], motion_set);
        self.touch = partners;
    }

    /// The parts of a step that threads may share.
    fn ranges(&mut self) -> impl Iterator<Item = CharacterRange<'_>> {
        let n = self.num_characters;
        let blocks = self.blocks[..n.div_ceil(LANES)].chunks_mut(RANGE_BLOCKS);
        let bodies = self.bodies.chunks_mut(RANGE_BLOCKS).zip(self.levels.chunks(RANGE_BLOCKS));
        let matrices = self.matrices[..n * NUM_JOINTS].chunks_mut(RANGE_LEN * NUM_JOINTS);
        let mut locals = self.locals.chunks_mut(RANGE_LEN * NUM_JOINTS);
        let (mut instances, mut touches) = (self.instances.chunks_mut(RANGE_LEN), self.touches.chunks_mut(RANGE_LEN));
        let parts = blocks.zip(bodies).zip(&mut self.passed).zip(matrices).enumerate();
        parts.map(move |(i, (((blocks, (bodies, levels)), passed), matrices))| {
            let (first, count) = range_span(i, n);
            let (locals, instances) = (locals.next().unwrap_or_default(), instances.next().unwrap_or_default());
            let touches = touches.next().unwrap_or_default();
            CharacterRange { first, count, blocks, bodies, levels, passed, matrices, locals, instances, touches }
        })
    }

    /// Changes the ground that all stand on: feet follow it from the next step on. The ground of clips that are laid on
    /// heights of their own adds to it.
    pub fn set_ground(&mut self, ground: HeightField) {
        if self.ground.is_flat() != ground.is_flat() {
            self.bodies.iter_mut().filter(|b| b.awake == 1).for_each(|b| b.state.seen = [0.0; LANES]);
        }
        if let Some(avoiding) = &mut self.avoiding {
            avoiding.ground = ground.clone();
        }
        self.ground = ground;
        self.mark_paths_stale();
    }

    /// Stops the limbs of characters in rows 2i and 2i + 1 at each other's bodies, from the next step on.
    ///
    /// - `volume`: of the skeleton's body, with the radii that stop limbs.
    ///
    /// # Errors
    /// [`Error::Value`] for a setting out of its range.
    pub fn set_partner_touch(&mut self, motion_set: &MotionSet, volume: BodyVolume, config: TouchConfig) -> Result<()> {
        config.check()?;
        self.touch = Some(Box::new(PartnerTouch::new(motion_set.skeleton(), volume, config)));
        self.touches.clear();
        self.touches.reserve_exact(self.matrices.len() / NUM_JOINTS);
        self.touches.resize(self.num_characters, LimbTouch::default());
        Ok(())
    }

    /// Sets viewpoint and distances of the level of detail from the next step on; with none, all characters are posed
    /// whole.
    ///
    /// # Errors
    /// [`Error::Value`] for invalid distances.
    pub fn set_detail(&mut self, detail: Option<Detail>) -> Result<()> {
        detail.map_or(Ok(()), |detail| detail.check())?;
        self.detail = detail;
        self.levels.fill(DetailLevel::Full);
        Ok(())
    }

    /// Level at which the last step computed a character (character < num_characters).
    pub fn level(&self, character: usize) -> DetailLevel {
        self.levels[character / LANES]
    }

    /// Records of all characters, whatever their level; empty unless the config requests them (num_characters).
    pub fn instances(&self) -> &[PoseInstance] {
        &self.instances[..self.num_characters.min(self.instances.len())]
    }

    /// Planar root of a character in the world (character < num_characters).
    pub fn root(&self, character: usize) -> Planar {
        self.blocks[character / LANES].root(character % LANES)
    }

    /// Planted parts of a character's feet (character < num_characters).
    pub fn contacts(&self, character: usize) -> Contacts {
        self.blocks[character / LANES].contacts[character % LANES]
    }

    /// Segment that a character plays, and the time within it; `u32::MAX` for a [`ScheduledClip`]. (frames, character <
    /// num_characters)
    pub fn segment(&self, character: usize) -> (u32, f32) {
        let (b, lane) = (&self.blocks[character / LANES], character % LANES);
        (b.segment[lane], b.time[lane])
    }

    /// Choices a character has made so far (character < num_characters).
    pub fn num_choices(&self, character: usize) -> u32 {
        self.blocks[character / LANES].num_choices[character % LANES]
    }

    /// State and root at the choice of the action that a character plays; none before the first choice and after
    /// [`Characters::play`]. The choice lies as far back as [`Characters::segment`] has played (character <
    /// num_characters).
    pub fn last_choice(&self, character: usize) -> Option<LastChoice> {
        let (b, lane) = (&self.blocks[character / LANES], character % LANES);
        let state = b.choice_state[lane];
        (state != block::NO_STATE).then(|| LastChoice { state, root: b.choice_root(lane) })
    }

    /// Starts a segment from where a character stands, with a smooth transition from what it plays. After the segment
    /// it chooses for itself again.
    ///
    /// # Errors
    /// [`Error::Index`] for a character or segment that does not exist, [`Error::OtherBundle`] as [`Characters::step`],
    /// [`Error::Occupied`] where collision avoidance is on and the ground is another's; nothing has changed then.
    pub fn play(&mut self, motion_set: &MotionSet, character: usize, segment: u32) -> Result<()> {
        self.check_bundle(motion_set)?;
        check_index("character", None, character, self.num_characters)?;
        check_index("segment", None, segment as usize, self.num_segments)?;
        let before = (self.blocks[character / LANES], self.bodies[character / LANES]);
        let scheduled = before.0.segment[character % LANES] == block::SCHEDULED;
        self.play_segment(motion_set, character, segment);
        if !self.reserve_path(motion_set, character) {
            (self.blocks[character / LANES], self.bodies[character / LANES]) = before;
            self.reserve_path(motion_set, character);
            return Err(occupied_error(Id::first(character)));
        }
        self.num_choosers += usize::from(scheduled);
        Ok(())
    }

    /// Blows of the last step, in the order of characters (at most MAX_BLOWS a character).
    ///
    /// A character strikes where it passes the frame of an effective hit; a hit on the frame that a segment starts
    /// with belongs to the segment before.
    pub fn blows(&self) -> &[Blow] {
        self.blows.get()
    }

    /// The next blow of the segment that a character plays, and the time until it; its place is where it would land
    /// if the path were bent no further (s, character < num_characters).
    pub fn next_blow(&self, motion_set: &MotionSet, character: usize) -> Option<(Blow, f32)> {
        let (segment, time) = self.segment(character);
        let start = motion_set.graph.segments.get(segment as usize)?.start;
        let frames = |hit: u32| (motion_set.hits[hit as usize].frame - start) as f32 - time;
        let hit = motion_set.hits_after(segment, time).next()?;
        let place = self.blocks[character / LANES].clip_to_world(character % LANES);
        Some((Blow::new(motion_set, character as u32, hit, place), frames(hit) / motion_set.rate_hz))
    }

    /// Displacement of a point of a character by the motion that it plays, within a time or until its action ends,
    /// without further bending of the path (m, in the world, character < num_characters).
    ///
    /// - `offset`: of the point, in the joint's own frame (m).
    /// - `known`: of earlier calls for the same point and motion set; the result is the same without it.
    pub fn travel_of_point(
        &self,
        motion_set: &MotionSet,
        character: usize,
        joint: Joint,
        offset: Vec3,
        ahead_s: f32,
        known: &mut TravelPoints,
    ) -> Vec3 {
        let (block, lane) = (&self.blocks[character / LANES], character % LANES);
        let (first, length) = (block.first[lane], block.length[lane]);
        let place = block.clip_to_world(lane);
        let mut at = |k: usize, time: f32| {
            let frame = first + (time.round().max(0.0) as u32).min(length);
            let (seen, point) = &mut known.0[k];
            if *seen != Some(frame) {
                (*seen, *point) = (Some(frame), motion_set.joint_point(frame, joint, offset));
            }
            maths::rotate(place.rotation(), *point)
        };
        at(1, block.time[lane] + ahead_s * motion_set.rate_hz) - at(0, block.time[lane])
    }

    /// Displaces a part of a character's body, which then comes back; see [`ReactionConfig`].
    ///
    /// The head (for head and neck) or the upper trunk reaches the displacement shortly after; what stands for limbs
    /// moves the trunk by a share. Pushes add up to the largest displacement of the config.
    ///
    /// - `displacement`: in the world (m).
    ///
    /// # Errors
    /// [`Error::Index`] for a character that does not exist, [`Error::Value`] for a displacement
    /// that is not finite; nothing has changed then.
    pub fn push(&mut self, character: usize, joint: Joint, displacement: Vec3) -> Result<()> {
        check_index("character", None, character, self.num_characters)?;
        let state = &mut self.bodies[character / LANES].state;
        state.push(character % LANES, &self.config.reaction, None, joint, displacement)
    }

    /// Moves a character over the ground as a whole, at the next step. Planted feet stay, where they are locked and as
    /// far as the lock reaches, and follow when they are lifted.
    ///
    /// - `by`: x and z in the world (m).
    ///
    /// # Errors
    /// As [`Characters::push`].
    pub fn shift_by(&mut self, character: usize, by: Vec2) -> Result<()> {
        check_index("character", None, character, self.num_characters)?;
        let largest = by.abs().max_element();
        check_value("shift", None, largest, by.is_finite() && largest < 1e3, "finite and below 1e3")?;
        let (block, lane) = (&mut self.blocks[character / LANES], character % LANES);
        block.clip_to_world[0][lane] += by.x;
        block.clip_to_world[1][lane] += by.y;
        block.choice_root[0][lane] += by.x;
        block.choice_root[1][lane] += by.y;
        self.mark_paths_stale();
        Ok(())
    }

    /// Joints of all characters in model space, which [`Characters::root`] places in the world.
    /// (num_characters * NUM_JOINTS)
    pub fn model_matrices(&self) -> &[Mat3x4] {
        &self.matrices[..self.num_characters * NUM_JOINTS]
    }

    /// Joints of one character in model space (NUM_JOINTS, character < num_characters).
    pub fn pose(&self, character: usize) -> &[Mat3x4] {
        &self.matrices[character * NUM_JOINTS..][..NUM_JOINTS]
    }

    /// Joints of all characters relative to their parents; empty unless the config asks for them.
    /// (num_characters * NUM_JOINTS)
    pub fn local_transforms(&self) -> &[LocalTransform] {
        &self.locals
    }

    /// World positions of one character's joints (m, character < num_characters).
    pub fn joint_positions(&self, character: usize) -> [Vec3; NUM_JOINTS] {
        let root = self.root(character);
        let (turn, move_by) = (root.rotation(), root.translation());
        let pose = self.pose(character);
        std::array::from_fn(|j| maths::rotate(turn, pose[j].translation()) + move_by)
    }

    fn check_bundle(&self, motion_set: &MotionSet) -> Result<()> {
        let (own, other) = (&self.bundle, &motion_set.bundle);
        ensure(own.is_same(other), || Error::OtherBundle { expected: own.hash(), got: other.hash() })
    }
}

/// Error of a place whose ground, or that of the stop from there, is another's.
fn occupied_error(who: Id) -> Error {
    Error::Occupied { who, by: "another character, who is there or on the way there, or a wall".into() }
}

fn check_root(who: Option<Id>, root: Planar) -> Result<()> {
    for (what, got) in [("x", root.x), ("z", root.z), ("heading", root.heading)] {
        check_value(what, who, got, got.abs() < 1e6, "a finite number below 1e6")?;
    }
    Ok(())
}

/// A segment that ends in each state (number of states).
fn segments_into_states(motion_set: &MotionSet) -> Vec<u32> {
    let mut found = vec![0; motion_set.graph.states.len()];
    for (i, s) in motion_set.graph.segments.iter().enumerate().rev() {
        found[s.end as usize] = i as u32;
    }
    found
}

/// First character of a range, and how many it has.
fn range_span(index: usize, num_characters: usize) -> (usize, usize) {
    let first = index * RANGE_LEN;
    (first, (num_characters - first).min(RANGE_LEN))
}
