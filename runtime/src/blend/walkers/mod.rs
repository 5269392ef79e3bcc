//! Walkers: many characters on free trajectories, whose bodies come from a blend space.

mod block;
mod body;
mod feet;
mod reach;
mod snapshot;
mod spring;
mod steer;
mod step;

use super::error::{BlendError, check, check_length};
use super::ground::HeightField;
use super::records::MAX_AXES;
use super::space::BlendSpace;
use crate::contacts::Contacts;
use crate::lanes::LANES;
use crate::planar::Planar;
use crate::pose::{LocalTransform, Mat3x4};
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use block::Block;
use body::LaneBody;
use glam::{Vec2, Vec3};
pub use snapshot::WalkersSnapshot;
use step::{RANGE_BLOCKS, Range, Tick};

/// Longest tick. [Unit: s]
pub const MAX_STEP_S: f32 = 1.0;

/// How walkers move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkersConfig {
    /// Time in which a difference between the parameters asked for and those blended halves, where they jump; parameters
    /// that change steadily are followed without delay; 0 takes them at once. [Unit: s] [Limit: 0 to 10]
    pub parameter_half_life_s: f32,
    /// Time in which a difference between the heading aimed at and the body's halves, where it jumps; a heading that
    /// turns steadily is followed without delay. [Unit: s] [Limit: 0 to 10]
    pub heading_half_life_s: f32,
    /// Fastest turn of the body. [Unit: rad/s] [Limit: > 0]
    pub max_turning_rate: f32,
    /// How much slower and faster than the examples steps may be, so that strides fit the speed of the trajectory.
    /// [Limit: 0.2 to 1, 1 to 5; 1 and 1 leave the blended rates as they are]
    pub tempo: [f32; 2],
    /// Time in which what a foot was kept from moving halves, once it is in the air; it begins to move slowly. [Unit: s]
    /// [Limit: > 0]
    pub foot_half_life_s: f32,
    /// How far a planted foot may be from where the examples have it, before it takes a step of its own.
    /// [Unit: m, of the database skeleton] [Limit: > 0]
    pub foot_reach_m: f32,
    /// False leaves the bodies as blended: joint angles alone, feet that slide.
    pub retarget: bool,
    /// Also write local transforms.
    pub local_transforms: bool,
}

impl Default for WalkersConfig {
    fn default() -> Self {
        Self {
            parameter_half_life_s: 0.25,
            heading_half_life_s: 0.12,
            max_turning_rate: 3.0,
            tempo: [0.8, 1.25],
            foot_half_life_s: 0.08,
            foot_reach_m: 0.22,
            retarget: true,
            local_transforms: false,
        }
    }
}

/// Where and how a walker begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WalkerStart {
    /// Number of its body. [Limit: < number of bodies]
    pub body: usize,
    /// Planar root in the world.
    pub root: Planar,
    /// Generic time it begins at, so that not everybody walks in step.
    pub phase: f32,
}

/// A sample of a walker's trajectory, and how it is to move there. It may come from any path, or from a crowd.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    /// x and z in the world. [Unit: m]
    pub position: Vec2,
    /// Along x and z. [Unit: m/s]
    pub velocity: Vec2,
    /// Where to face; nothing faces the way that it goes. [Unit: rad]
    pub heading: Option<f32>,
    /// Turning rate, positive to the left; nothing takes that of the body. [Unit: rad/s]
    pub turning_rate: Option<f32>,
    /// Values of the style axes, in their order.
    pub style: [f32; MAX_AXES],
}

impl Default for Control {
    /// Standing at the origin.
    fn default() -> Self {
        Self { position: Vec2::ZERO, velocity: Vec2::ZERO, heading: None, turning_rate: None, style: [0.0; MAX_AXES] }
    }
}

/// Characters that follow trajectories with blended bodies, eight to a block; all memory is allocated in
/// [`Walkers::new`].
///
/// Every tick, [`Walkers::step`] puts each character on its trajectory, turns it, finds the weights of the examples for
/// its speed, turning rate and style, moves generic time on, blends a posture, and retargets it on line to the
/// character's body: the hips keep the elevation and sway of the examples, planted feet stay where they are, legs and
/// touching arms reach by analytic inverse kinematics (000 section 4.2).
#[derive(Clone, Debug)]
pub struct Walkers {
    config: WalkersConfig,
    num_characters: usize,
    num_examples: usize,
    stride: usize,
    blocks: Vec<Block>,
    bodies: Vec<LaneBody>,
    weights: Vec<f32>,
    matrices: Vec<Mat3x4>,
    locals: Vec<LocalTransform>,
}

impl Walkers {
    /// Puts a character at every start. Poses are there after the first step.
    ///
    /// - `database`: the skeleton of the examples, that of the bundle.
    /// - `bodies`: skeletons of other sizes and proportions; the rest pose stands on the ground.
    ///
    /// # Errors
    /// [`BlendError::Index`] for a body that does not exist, [`BlendError::Value`] for a start, body or setting that
    /// is out of its range.
    pub fn new(
        space: &BlendSpace<'_>,
        database: &Skeleton,
        bodies: &[Skeleton],
        config: WalkersConfig,
        starts: &[WalkerStart],
    ) -> Result<Self, BlendError> {
        check_config(&config)?;
        bodies.iter().chain([database]).try_for_each(check_body)?;
        let n = starts.len();
        let mut blocks = vec![Block::ZERO; n.div_ceil(LANES)];
        let mut lane_bodies = vec![LaneBody::ZERO; n.div_ceil(LANES)];
        for block in &mut lane_bodies {
            // Lanes without a character have a body too, so that nothing is divided by 0.
            (0..LANES).for_each(|lane| block.put(lane, database, database));
        }
        for (c, start) in starts.iter().enumerate() {
            let Some(body) = bodies.get(start.body) else {
                return Err(BlendError::Index { what: "body", got: start.body, limit: bodies.len() });
            };
            let r = start.root;
            for (what, got) in [("start x", r.x), ("start z", r.z), ("start heading", r.heading)] {
                check(what, got, got.abs() < 1e6, "a finite number below 1e6")?;
            }
            check("start phase", start.phase, start.phase.abs() < 1e6, "a finite number below 1e6")?;
            let (block, lane) = (&mut blocks[c / LANES], c % LANES);
            for (axis, value) in block.root.iter_mut().zip([r.x, r.z, r.heading]) {
                axis[lane] = value;
            }
            block.aim[lane] = r.heading;
            block.phase[lane] = start.phase - start.phase.floor();
            lane_bodies[c / LANES].put(lane, body, database);
        }
        Ok(Self {
            config,
            num_characters: n,
            num_examples: space.examples().len(),
            stride: space.stride(),
            blocks,
            bodies: lane_bodies,
            weights: vec![0.0; n * space.stride()],
            matrices: vec![Mat3x4::default(); n * NUM_JOINTS],
            locals: vec![LocalTransform::default(); if config.local_transforms { n * NUM_JOINTS } else { 0 }],
        })
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.num_characters
    }

    /// Moves every character on by `dt_s` on this thread. Allocates nothing.
    ///
    /// - `controls`: where each character is and how it moves at the end of the tick. [Size: number of characters]
    ///
    /// # Errors
    /// [`BlendError`] where `dt_s` is not in `0..=1`, a control is not finite, or the space is another one; nothing
    /// has moved then.
    pub fn step(
        &mut self,
        space: &BlendSpace<'_>,
        dt_s: f32,
        controls: &[Control],
        ground: &HeightField,
    ) -> Result<(), BlendError> {
        self.validate(space, dt_s, controls)?;
        let tick = Tick::new(space, &self.config, dt_s, ground);
        const RANGE: usize = RANGE_BLOCKS * LANES;
        let mut locals = self.locals.chunks_mut(RANGE * NUM_JOINTS);
        let parts = self.blocks.chunks_mut(RANGE_BLOCKS).zip(self.bodies.chunks(RANGE_BLOCKS));
        let parts = parts.zip(controls.chunks(RANGE)).zip(self.weights.chunks_mut(RANGE * self.stride));
        let parts = parts.zip(self.matrices.chunks_mut(RANGE * NUM_JOINTS));
        for ((((blocks, bodies), controls), weights), matrices) in parts {
            let locals = locals.next().unwrap_or_default();
            step::step(Range { blocks, bodies, controls, weights, matrices, locals }, &tick);
        }
        Ok(())
    }

    /// As [`Walkers::step`], on the threads of the current rayon pool. The result is the same, bit by bit.
    ///
    /// # Errors
    /// As [`Walkers::step`].
    #[cfg(feature = "rayon")]
    pub fn par_step(
        &mut self,
        space: &BlendSpace<'_>,
        dt_s: f32,
        controls: &[Control],
        ground: &HeightField,
    ) -> Result<(), BlendError> {
        use rayon::prelude::*;
        self.validate(space, dt_s, controls)?;
        let tick = Tick::new(space, &self.config, dt_s, ground);
        const RANGE: usize = RANGE_BLOCKS * LANES;
        let parts = self.blocks.par_chunks_mut(RANGE_BLOCKS).zip(self.bodies.par_chunks(RANGE_BLOCKS));
        let parts = parts.zip(controls.par_chunks(RANGE)).zip(self.weights.par_chunks_mut(RANGE * self.stride));
        let parts = parts.zip(self.matrices.par_chunks_mut(RANGE * NUM_JOINTS));
        if self.locals.is_empty() {
            parts.for_each(|((((blocks, bodies), controls), weights), matrices)| {
                step::step(Range { blocks, bodies, controls, weights, matrices, locals: &mut [] }, &tick);
            });
        } else {
            let parts = parts.zip(self.locals.par_chunks_mut(RANGE * NUM_JOINTS));
            parts.for_each(|(((((blocks, bodies), controls), weights), matrices), locals)| {
                step::step(Range { blocks, bodies, controls, weights, matrices, locals }, &tick);
            });
        }
        Ok(())
    }

    /// Planar root of a character: on its trajectory, facing where the body faces. [Limit: character < num_characters]
    pub fn root(&self, character: usize) -> Planar {
        self.blocks[character / LANES].root(character % LANES)
    }

    /// Planted parts of a character's feet. [Limit: character < num_characters]
    pub fn contacts(&self, character: usize) -> Contacts {
        self.blocks[character / LANES].contacts[character % LANES]
    }

    /// Generic time of a character, in [0, 1). [Limit: character < num_characters]
    pub fn phase(&self, character: usize) -> f32 {
        self.blocks[character / LANES].phase[character % LANES]
    }

    /// Place of a character in the parameter box, scaled to the database skeleton and eased.
    /// [Limit: character < num_characters]
    pub fn parameters(&self, character: usize) -> [f32; MAX_AXES] {
        self.blocks[character / LANES].parameters[character % LANES]
    }

    /// Weights of the examples in a character. [Size: number of examples] [Limit: character < num_characters]
    pub fn weights(&self, character: usize) -> &[f32] {
        &self.weights[character * self.stride..][..self.num_examples]
    }

    /// Joints of all characters in model space, which [`Walkers::root`] places in the world; heights contain that of
    /// the ground. [Size: num_characters * NUM_JOINTS]
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

    /// What a character's feet stand on, in the world: the bottom of the heel, and the ball (the toe's joint), of the left
    /// foot and of the right one. [Unit: m] [Limit: character < num_characters]
    pub fn soles(&self, character: usize) -> [[Vec3; 2]; 2] {
        let (root, pose) = (self.root(character), self.pose(character));
        let (turn, move_by) = (root.rotation(), root.translation());
        let body = &self.bodies[character / LANES];
        std::array::from_fn(|side| {
            let [_, _, foot, toe] = body::LEGS[side].map(Joint::index);
            let heel = Vec3::from_array(body.legs[side].heel.map(|axis| axis[character % LANES]));
            let heel = pose[foot].translation() + pose[foot].rotation() * heel;
            [heel, pose[toe].translation()].map(|p| turn * p + move_by)
        })
    }

    fn validate(&self, space: &BlendSpace<'_>, dt_s: f32, controls: &[Control]) -> Result<(), BlendError> {
        for (what, expected, got) in
            [("examples", self.num_examples, space.examples().len()), ("weights a row", self.stride, space.stride())]
        {
            if got != expected {
                return Err(BlendError::OtherSpace { what, expected, got });
            }
        }
        check("dt_s", dt_s, (0.0..=MAX_STEP_S).contains(&dt_s), "between 0 and 1")?;
        check_length("controls", controls.len(), self.num_characters)?;
        for c in controls {
            let numbers = c.position.to_array().into_iter().chain(c.velocity.to_array()).chain(c.style);
            for number in numbers.chain(c.heading).chain(c.turning_rate) {
                check("control", number, number.abs() < 1e6, "finite numbers below 1e6")?;
            }
        }
        Ok(())
    }
}

fn check_config(c: &WalkersConfig) -> Result<(), BlendError> {
    for (what, got) in
        [("parameter_half_life_s", c.parameter_half_life_s), ("heading_half_life_s", c.heading_half_life_s)]
    {
        check(what, got, (0.0..=10.0).contains(&got), "between 0 and 10")?;
    }
    let [slow, fast] = c.tempo;
    check("tempo[0]", slow, (0.2..=1.0).contains(&slow), "between 0.2 and 1")?;
    check("tempo[1]", fast, (1.0..=5.0).contains(&fast), "between 1 and 5")?;
    let rate = c.max_turning_rate;
    check("max_turning_rate", rate, rate > 0.0 && rate < 1e3, "above 0 and below 1000")?;
    let half_life = c.foot_half_life_s;
    check("foot_half_life_s", half_life, (1e-3..10.0).contains(&half_life), "between 0.001 and 10")?;
    check("foot_reach_m", c.foot_reach_m, (0.01..10.0).contains(&c.foot_reach_m), "between 0.01 and 10")
}

/// Legs and arms have a length, and the rest pose stands on the ground.
fn check_body(s: &Skeleton) -> Result<(), BlendError> {
    let rest = s.rest_positions();
    let size = s.offsets.iter().chain(&s.tips).fold(0.0f32, |l, o| l.max(o.length()));
    let finite = s.offsets.iter().chain(&s.tips).all(|o| o.is_finite());
    check("offset of a body's joint", size, finite && size < 100.0, "finite and below 100")?;
    for limb in [body::LEGS.map(|l| [l[1], l[2]]), body::ARMS.map(|a| [a[1], a[2]])].concat() {
        for joint in limb {
            let length = s.offsets[joint.index()].length();
            check("length of a body's limb", length, length > 0.01, "above 0.01")?;
        }
    }
    for foot in [Joint::LeftFoot, Joint::RightFoot] {
        let height = rest[foot.index()].y;
        check("height of a body's ankle", height, (-0.01..1.0).contains(&height), "in rest pose between 0 and 1")?;
    }
    Ok(())
}
