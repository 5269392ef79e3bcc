//! Troupes: many characters, moved and posed together.

mod anatomy;
pub(crate) mod block;
mod blow;
mod config;
mod control;
mod course;
mod error;
pub(crate) mod foot_lock;
pub(crate) mod hierarchy;
mod reaction;
mod repertoire;
pub(crate) mod sample;
mod sample_job;
mod snapshot;
mod step;
#[cfg(test)]
pub(crate) mod tests;
mod times;
mod transition;

use crate::contacts::Contacts;
use crate::lanes::LANES;
use crate::planar::Planar;
use crate::pose::{LocalTransform, Mat3x4};
use crate::skeleton::{Joint, NUM_JOINTS};
pub(crate) use anatomy::head_centre;
use block::Block;
pub use blow::{Blow, MAX_BLOWS};
use blow::{Blows, PassedHits};
pub use config::{Choice, TroupeConfig};
pub(crate) use control::uniform;
pub use course::Course;
pub use error::TroupeError;
use error::{check, check_index};
pub use foot_lock::FootLockConfig;
use glam::{Vec2, Vec3};
pub use reaction::ReactionConfig;
pub use repertoire::Repertoire;
pub use sample_job::SampleJob;
pub use snapshot::TroupeSnapshot;
use step::{RANGE_BLOCKS, Range, Tick};
use times::Clock;
pub use times::StepTimes;

/// Longest tick. [Unit: s]
pub const MAX_STEP_S: f32 = 1.0;
/// Most behaviours weighed against each other in one step.
pub const MAX_GOALS: usize = control::MAX_GOALS;

/// Where a character starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Planar root in the world.
    pub root: Planar,
    /// State of the motion graph. [Limit: < number of states]
    pub state: u32,
}

/// A behaviour and where it is aimed.
#[derive(Clone, Copy, Debug)]
pub struct Goal<'a> {
    /// Number of the policy.
    pub policy: usize,
    /// What its values count in the sum over goals; 0 switches it off, as does a target outside the policy's region.
    /// A character all of whose goals are off takes the first action of its state.
    pub weight: f32,
    /// Target of every character in the world, for a grid of moments with the time left as y. [Unit: m, s]
    /// [Size: number of characters]
    pub targets: &'a [Vec3],
}

/// Characters that move together, eight to a block; all memory is allocated in [`Troupe::new`] or
/// [`Troupe::new_laid`].
///
/// Every tick, [`Troupe::step`] moves time on, lets characters at the end of a segment choose their next action by
/// the policies, samples and blends their motion, locks planted feet, and leaves each character's planar root,
/// contacts and joint matrices to be read.
#[derive(Clone, Debug)]
pub struct Troupe {
    config: TroupeConfig,
    num_characters: usize,
    /// Characters that choose for themselves; the others are laid on courses.
    num_choosers: usize,
    num_frames: usize,
    num_segments: usize,
    blocks: Vec<Block>,
    passed: Vec<PassedHits>,
    blows: Blows,
    matrices: Vec<Mat3x4>,
    locals: Vec<LocalTransform>,
    times: StepTimes,
}

/// What a character knew when it took its action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastChoice {
    /// State it was in.
    pub state: u32,
    /// Planar root in the world.
    pub root: Planar,
}

impl Troupe {
    /// Puts a character at every start. Poses are there after the first step.
    ///
    /// # Errors
    /// [`TroupeError::Index`] for a state that does not exist, [`TroupeError::Value`] for a start that is not
    /// finite or a setting out of its range.
    pub fn new(repertoire: &Repertoire<'_>, config: TroupeConfig, starts: &[Start]) -> Result<Self, TroupeError> {
        config.check()?;
        let n = starts.len();
        let mut blocks = vec![Block::ZERO; n.div_ceil(LANES)];
        let arrivals = arrivals(repertoire);
        for (c, start) in starts.iter().enumerate() {
            let limit = repertoire.graph.states.len();
            let Some(state) = repertoire.graph.states.get(start.state as usize) else {
                return Err(TroupeError::Index { what: "state", got: start.state as usize, limit });
            };
            let r = start.root;
            for (what, got) in [("start x", r.x), ("start z", r.z), ("start heading", r.heading)] {
                check(what, got, got.abs() < 1e6, "a finite number below 1e6")?;
            }
            let (b, lane) = (&mut blocks[c / LANES], c % LANES);
            let segment = arrivals[start.state as usize];
            b.set_segment(lane, segment, &repertoire.graph.segments[segment as usize]);
            b.time[lane] = b.length[lane] as f32;
            b.set_clip_to_world(lane, r.compose(repertoire.planar(state.frame).inverse()));
            block::set(&mut b.root, lane, Vec3::new(r.x, r.z, r.heading));
        }
        Ok(Self::with_blocks(repertoire, config, blocks, n, n))
    }

    /// Memory for `n` characters beside their blocks.
    fn with_blocks(
        repertoire: &Repertoire<'_>,
        config: TroupeConfig,
        blocks: Vec<Block>,
        n: usize,
        num_choosers: usize,
    ) -> Self {
        const RANGE: usize = RANGE_BLOCKS * LANES;
        let ranges = (0..n).step_by(RANGE).map(|first| RANGE.min(n - first));
        let passed: Vec<_> = ranges.map(|count| PassedHits::new(count, repertoire)).collect();
        let locals = if config.local_transforms { n * NUM_JOINTS } else { 0 };
        Self {
            config,
            num_characters: n,
            num_choosers,
            num_frames: repertoire.frames.len(),
            num_segments: repertoire.graph.segments.len(),
            blocks,
            blows: Blows::new(&passed),
            passed,
            matrices: vec![Mat3x4::default(); n * NUM_JOINTS],
            locals: vec![LocalTransform::default(); locals],
            times: StepTimes::default(),
        }
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.num_characters
    }

    /// Moves every character on by `dt_s` on this thread. Allocates nothing.
    ///
    /// # Errors
    /// [`TroupeError`] where `dt_s` is not in `0..=1`, goals do not fit, or the repertoire is another bundle's;
    /// nothing has moved then.
    pub fn step(&mut self, repertoire: &Repertoire<'_>, dt_s: f32, goals: &[Goal<'_>]) -> Result<(), TroupeError> {
        self.validate(repertoire, dt_s, goals)?;
        let clock = self.config.timed.then(Clock::default);
        let tick = Tick { dt_s, repertoire, config: &self.config, goals, clock: clock.as_ref() };
        let n = self.num_characters;
        let matrices = self.matrices.chunks_mut(RANGE_BLOCKS * LANES * NUM_JOINTS);
        let mut locals = self.locals.chunks_mut(RANGE_BLOCKS * LANES * NUM_JOINTS);
        let parts = self.blocks.chunks_mut(RANGE_BLOCKS).zip(&mut self.passed);
        for (i, (part, matrices)) in parts.zip(matrices).enumerate() {
            step::step(range(i, n, part, matrices, locals.next().unwrap_or_default()), &tick);
        }
        self.blows.gather(&self.passed, repertoire);
        self.times = clock.map_or(self.times, |c| c.times());
        Ok(())
    }

    /// As [`Troupe::step`], on the threads of the current rayon pool. The result is the same, bit by bit.
    ///
    /// # Errors
    /// As [`Troupe::step`].
    #[cfg(feature = "rayon")]
    pub fn par_step(&mut self, repertoire: &Repertoire<'_>, dt_s: f32, goals: &[Goal<'_>]) -> Result<(), TroupeError> {
        use rayon::prelude::*;
        self.validate(repertoire, dt_s, goals)?;
        let clock = self.config.timed.then(Clock::default);
        let tick = Tick { dt_s, repertoire, config: &self.config, goals, clock: clock.as_ref() };
        let n = self.num_characters;
        const POSES: usize = RANGE_BLOCKS * LANES * NUM_JOINTS;
        let parts = self.blocks.par_chunks_mut(RANGE_BLOCKS).zip(&mut self.passed);
        let parts = parts.zip(self.matrices.par_chunks_mut(POSES)).enumerate();
        if self.locals.is_empty() {
            parts.for_each(|(i, (b, m))| step::step(range(i, n, b, m, &mut []), &tick));
        } else {
            let parts = parts.zip(self.locals.par_chunks_mut(POSES));
            parts.for_each(|((i, (b, m)), l)| step::step(range(i, n, b, m, l), &tick));
        }
        self.blows.gather(&self.passed, repertoire);
        self.times = clock.map_or(self.times, |c| c.times());
        Ok(())
    }

    /// Planar root of a character in the world. [Limit: character < num_characters]
    pub fn root(&self, character: usize) -> Planar {
        self.blocks[character / LANES].root(character % LANES)
    }

    /// Planted parts of a character's feet. [Limit: character < num_characters]
    pub fn contacts(&self, character: usize) -> Contacts {
        self.blocks[character / LANES].contacts[character % LANES]
    }

    /// Segment that a character plays, and the time within it; `u32::MAX` where it is laid on a [`Course`].
    /// [Unit: frames] [Limit: character < num_characters]
    pub fn segment(&self, character: usize) -> (u32, f32) {
        let (b, lane) = (&self.blocks[character / LANES], character % LANES);
        (b.segment[lane], b.time[lane])
    }

    /// Choices a character has made so far. [Limit: character < num_characters]
    pub fn num_choices(&self, character: usize) -> u32 {
        self.blocks[character / LANES].num_choices[character % LANES]
    }

    /// What the action a character plays was chosen by; none before the first choice and after [`Troupe::play`].
    /// The choice lies as far back as [`Troupe::segment`] has played. [Limit: character < num_characters]
    pub fn last_choice(&self, character: usize) -> Option<LastChoice> {
        let (b, lane) = (&self.blocks[character / LANES], character % LANES);
        let state = b.choice_state[lane];
        (state != block::NO_STATE).then(|| LastChoice { state, root: b.choice_root(lane) })
    }

    /// Lets a character leave what it plays and start a segment from where it stands, with a smooth transition.
    /// After the segment it chooses for itself again.
    ///
    /// # Errors
    /// [`TroupeError::Index`] for a character or segment that does not exist, [`TroupeError::OtherBundle`] as
    /// [`Troupe::step`]; nothing has changed then.
    pub fn play(&mut self, repertoire: &Repertoire<'_>, character: usize, segment: u32) -> Result<(), TroupeError> {
        self.check_bundle(repertoire)?;
        check_index("character", character, self.num_characters)?;
        check_index("segment", segment as usize, self.num_segments)?;
        let laid = self.blocks[character / LANES].segment[character % LANES] == block::LAID;
        control::play(&mut self.blocks, character, segment, repertoire, &self.config);
        self.num_choosers += usize::from(laid);
        Ok(())
    }

    /// Blows of the last step, in the order of characters. [Size: at most MAX_BLOWS a character]
    ///
    /// A character strikes where it passes the frame of an effective hit; a hit on the frame that a segment starts
    /// with belongs to the segment before.
    pub fn blows(&self) -> &[Blow] {
        self.blows.get()
    }

    /// The next blow of the segment that a character plays, and the time until it; its place is where it would land
    /// if the path were bent no further. [Unit: s] [Limit: character < num_characters]
    pub fn next_blow(&self, repertoire: &Repertoire<'_>, character: usize) -> Option<(Blow, f32)> {
        let (segment, time) = self.segment(character);
        let start = repertoire.graph.segments.get(segment as usize)?.start;
        let frames = |hit: u32| (repertoire.hits[hit as usize].frame - start) as f32 - time;
        let hit = repertoire.hits_of(segment).find(|&hit| frames(hit) > 0.0)?;
        let place = self.blocks[character / LANES].clip_to_world(character % LANES);
        Some((Blow::new(repertoire, character as u32, hit, place), frames(hit) / repertoire.rate_hz))
    }

    /// Displaces a part of a character's body, which then comes back; see [`ReactionConfig`].
    ///
    /// The head (for head and neck) or the upper trunk reaches the displacement shortly after; what stands for limbs
    /// moves the trunk by a share. Pushes add up to the largest displacement of the config.
    ///
    /// - `displacement`: in the world. [Unit: m]
    ///
    /// # Errors
    /// [`TroupeError::Index`] for a character that does not exist, [`TroupeError::Value`] for a displacement that is
    /// not finite; nothing has changed then.
    pub fn push(&mut self, character: usize, joint: Joint, displacement: Vec3) -> Result<(), TroupeError> {
        check_index("character", character, self.num_characters)?;
        let largest = displacement.abs().max_element();
        check("displacement", largest, displacement.is_finite() && largest < 1e3, "finite and below 1e3")?;
        if self.config.reaction.enabled {
            let block = &mut self.blocks[character / LANES];
            reaction::push(&mut block.reaction, character % LANES, &self.config.reaction, joint, displacement);
        }
        Ok(())
    }

    /// Moves a character over the ground as a whole, at the next step. Planted feet stay, where they are locked and as
    /// far as the lock reaches, and follow when they are lifted.
    ///
    /// - `by`: x and z in the world. [Unit: m]
    ///
    /// # Errors
    /// As [`Troupe::push`].
    pub fn shift(&mut self, character: usize, by: Vec2) -> Result<(), TroupeError> {
        check_index("character", character, self.num_characters)?;
        let largest = by.abs().max_element();
        check("shift", largest, by.is_finite() && largest < 1e3, "finite and below 1e3")?;
        let (block, lane) = (&mut self.blocks[character / LANES], character % LANES);
        block.clip_to_world[0][lane] += by.x;
        block.clip_to_world[1][lane] += by.y;
        Ok(())
    }

    /// Times of the last step's phases; zero unless [`TroupeConfig::timed`].
    pub fn times(&self) -> StepTimes {
        self.times
    }

    /// Joints of all characters in model space, which [`Troupe::root`] places in the world.
    /// [Size: num_characters * NUM_JOINTS]
    pub fn model_matrices(&self) -> &[Mat3x4] {
        &self.matrices
    }

    /// Joints of one character in model space. [Size: NUM_JOINTS] [Limit: character < num_characters]
    pub fn pose(&self, character: usize) -> &[Mat3x4] {
        &self.matrices[character * NUM_JOINTS..][..NUM_JOINTS]
    }

    /// Joints of all characters relative to their parents; empty unless the config asks for them.
    /// [Size: num_characters * NUM_JOINTS]
    pub fn local_transforms(&self) -> &[LocalTransform] {
        &self.locals
    }

    /// World positions of one character's joints. [Unit: m] [Limit: character < num_characters]
    pub fn joint_positions(&self, character: usize) -> [Vec3; NUM_JOINTS] {
        let root = self.root(character);
        let (turn, move_by) = (root.rotation(), root.translation());
        let pose = self.pose(character);
        std::array::from_fn(|j| turn * pose[j].translation() + move_by)
    }

    fn validate(&self, repertoire: &Repertoire<'_>, dt_s: f32, goals: &[Goal<'_>]) -> Result<(), TroupeError> {
        self.check_bundle(repertoire)?;
        check("dt_s", dt_s, (0.0..=MAX_STEP_S).contains(&dt_s), "between 0 and 1")?;
        // Characters on courses choose nothing.
        let fewest = usize::from(self.num_choosers > 0);
        if goals.len() < fewest || goals.len() > MAX_GOALS {
            return Err(TroupeError::Length { what: "goals", got: goals.len(), expected: MAX_GOALS });
        }
        for g in goals {
            let (got, expected) = (g.targets.len(), self.num_characters);
            if got != expected {
                return Err(TroupeError::Length { what: "targets", got, expected });
            }
            if g.policy >= repertoire.policies.len() {
                return Err(TroupeError::Index { what: "policy", got: g.policy, limit: repertoire.policies.len() });
            }
            check("weight", g.weight, g.weight.abs() < 1e6, "a finite number below 1e6")?;
            for t in g.targets {
                let largest = t.abs().max_element();
                check("target", largest, largest < 1e6 && !t.is_nan(), "finite coordinates below 1e6")?;
            }
        }
        Ok(())
    }

    fn check_bundle(&self, repertoire: &Repertoire<'_>) -> Result<(), TroupeError> {
        for (what, expected, got) in [
            ("frames", self.num_frames, repertoire.frames.len()),
            ("segments", self.num_segments, repertoire.graph.segments.len()),
        ] {
            if got != expected {
                return Err(TroupeError::OtherBundle { what, expected, got });
            }
        }
        Ok(())
    }
}

/// A segment that ends in each state. [Size: number of states]
fn arrivals(repertoire: &Repertoire<'_>) -> Vec<u32> {
    let mut found = vec![0; repertoire.graph.states.len()];
    for (i, s) in repertoire.graph.segments.iter().enumerate().rev() {
        found[s.end as usize] = i as u32;
    }
    found
}

fn range<'a>(
    index: usize,
    num_characters: usize,
    (blocks, passed): (&'a mut [Block], &'a mut PassedHits),
    matrices: &'a mut [Mat3x4],
    locals: &'a mut [LocalTransform],
) -> Range<'a> {
    let first = index * RANGE_BLOCKS * LANES;
    let count = (num_characters - first).min(RANGE_BLOCKS * LANES);
    Range { first, count, blocks, passed, matrices, locals }
}
