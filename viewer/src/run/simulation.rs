//! The characters at one instant, and one step of them.

use super::choices::{ChoiceRecord, GoalSubject, RunGoal};
use super::config::{CrowdRunConfig, MOST_POSED, STEP_HZ, TargetMode};
use super::figures::{Slip, StepFigures};
use crate::bundle::OpenBundle;
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f32::consts::TAU;
use std::sync::Arc;
use std::time::Instant;
use throng_core::characters::{CharacterStart, Characters, CharactersSnapshot, Detail, PolicyOrder};
use throng_core::{Executor, Inline, Planar, Rayon, Result};
use throng_precompute::slip::SlipMeter;
use throng_precompute::trial;
use throng_world::inhabitants::InhabitantGoal;

/// Characters from which on a step is split over threads.
const PARALLEL_FROM: usize = 1000;

/// Distance from the eye up to which feet are locked, in crowds that are not posed in full (m).
const FULL_M: f32 = 20.0;
/// Distance from the eye up to which poses are computed, in such crowds (m).
const POSED_M: f32 = 40.0;

/// Something done to a run from outside. Inputs are recorded and repeated when the run is.
#[derive(Clone, Debug, PartialEq)]
pub enum RunInput {
    /// A target is moved; all targets if no character is named (m).
    Target {
        /// Character with the target.
        character: Option<usize>,
        /// New position.
        to: Vec3,
    },
    /// Weights of the behaviours of a group.
    Weights {
        /// Any character of the group.
        member: usize,
        /// Weight of each (number of behaviours).
        weights: Vec<f32>,
    },
    /// A character plays a segment at once.
    Play {
        /// Which character.
        character: usize,
        /// Which segment.
        segment: u32,
    },
    /// An event of the scene happens.
    Event(String),
    /// A character of a world gets an order.
    Goal {
        /// Which character.
        character: usize,
        /// Goal of the order; none lets it decide for itself.
        goal: Option<InhabitantGoal>,
    },
}

impl RunInput {
    /// The input within valid bounds; none for a target that is not a number.
    pub(super) fn limited(self) -> Option<Self> {
        let most = Vec3::splat(super::MAX_TARGET_M);
        match self {
            Self::Target { to, .. } if to.is_nan() => None,
            Self::Target { character, to } => Some(Self::Target { character, to: to.clamp(-most, most) }),
            other => Some(other),
        }
    }

    /// True if this makes an older input at the same step obsolete.
    pub(super) fn replaces(&self, old: &Self) -> bool {
        match (old, self) {
            (Self::Target { character: a, .. }, Self::Target { character: b, .. }) => a == b,
            (Self::Weights { member: a, .. }, Self::Weights { member: b, .. }) => a == b,
            (Self::Goal { character: a, .. }, Self::Goal { character: b, .. }) => a == b,
            _ => false,
        }
    }
}

/// State of the run beside the characters: targets, weights, and last choices.
#[derive(Clone, Debug)]
pub(super) struct RunSurroundings {
    /// Target of each character's next choice.
    pub targets: Vec<Vec3>,
    /// Number of targets that each character has reached so far.
    pub reached: Vec<u32>,
    /// Weight of every goal.
    pub weights: Arc<[f32]>,
    /// Data of the last choices.
    pub choices: ChoiceRecord,
    /// The step that comes next.
    pub step: u32,
}

/// All that later steps depend on.
#[derive(Clone, Debug)]
pub(super) struct CrowdKeyframe {
    characters: CharactersSnapshot,
    pub around: RunSurroundings,
}

impl CrowdKeyframe {
    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        let a = &self.around;
        self.characters.num_bytes()
            + a.choices.num_bytes()
            + a.targets.len() * size_of::<Vec3>()
            + 4 * (a.reached.len() + a.weights.len())
    }
}

/// The characters at one instant. A copy goes on by itself, beside the run that is shown, without its later inputs.
#[derive(Clone, Debug)]
pub struct CrowdSimulation {
    pub(super) config: CrowdRunConfig,
    pub(crate) characters: Characters,
    /// Goals that are weighed (number of weights).
    pub(crate) goals: Vec<RunGoal>,
    pub(super) around: RunSurroundings,
    /// Position of the eye, x and z (m). Only the number of fully posed characters depends on it.
    pub(crate) eye: Vec2,
    slip: SlipMeter,
}

impl CrowdSimulation {
    /// Characters on a loose grid, each with a target in some direction. No step has been taken.
    ///
    /// - `weights`: of the first behaviours, which are weighed.
    pub(super) fn new(bundle: &OpenBundle, config: CrowdRunConfig, weights: Vec<f32>) -> Result<Self> {
        let (starts, targets) = scatter(&config, &trial::start_states(bundle.tables(), &config.characters()));
        let characters = Characters::new(&bundle.motion_set, config.characters(), &starts)?;
        let goals = (0..weights.len()).map(|policy| RunGoal { policy, subject: GoalSubject::Target }).collect();
        let n = config.characters;
        let (reached, choices) = (vec![0; n], ChoiceRecord::new(n));
        let around = RunSurroundings { targets, reached, weights: weights.into(), choices, step: 0 };
        let slip = SlipMeter::new(n, bundle.tables().skeleton());
        Ok(Self { config, characters, goals, around, eye: Vec2::ZERO, slip })
    }

    pub(super) fn keyframe(&self) -> CrowdKeyframe {
        CrowdKeyframe { characters: self.characters.snapshot(), around: self.around.clone() }
    }

    pub(super) fn restore(&mut self, bundle: &OpenBundle, keyframe: &CrowdKeyframe) -> Result<()> {
        self.characters.restore(&bundle.motion_set, &keyframe.characters)?;
        self.around.clone_from(&keyframe.around);
        self.slip.forget_step();
        Ok(())
    }

    /// Applies an input.
    pub(super) fn apply_input(&mut self, bundle: &OpenBundle, input: &RunInput) -> Result<()> {
        match input {
            RunInput::Target { character, to } => self.move_target(*character, *to),
            RunInput::Weights { weights, .. } => self.around.weights = weights.as_slice().into(),
            RunInput::Play { character, segment } => self.characters.play(&bundle.motion_set, *character, *segment)?,
            RunInput::Goal { .. } | RunInput::Event(_) => {}
        }
        Ok(())
    }

    /// Moves a target, or all targets if no character is named, within [`super::MAX_TARGET_M`].
    pub(crate) fn send(&mut self, character: Option<usize>, to: Vec3) {
        if let Some(RunInput::Target { character, to }) = (RunInput::Target { character, to }).limited() {
            self.move_target(character, to);
        }
    }

    /// Moves a target; all targets if no character is named.
    pub(super) fn move_target(&mut self, character: Option<usize>, to: Vec3) {
        let targets = &mut self.around.targets;
        match character {
            None => targets.fill(to),
            Some(c) => targets.get_mut(c).into_iter().for_each(|target| *target = to),
        }
    }

    /// One step; the very first one only takes the first choices. Measures it.
    pub(crate) fn step(&mut self, bundle: &OpenBundle) -> Result<StepFigures> {
        let dt = if self.around.step == 0 { 0.0 } else { 1.0 / STEP_HZ };
        let begin = Instant::now();
        self.move_characters(bundle, dt)?;
        let wall_s = begin.elapsed().as_secs_f64();
        let a = &mut self.around;
        a.choices.observe(&self.characters, &a.targets, &[], &a.weights, a.step);
        let figures = StepFigures { wall_s, ..self.measure(dt) };
        self.around.step += 1;
        if self.config.targets == TargetMode::Wander {
            self.move_targets_on();
        }
        Ok(figures)
    }

    fn move_characters(&mut self, bundle: &OpenBundle, dt: f32) -> Result<()> {
        let (motion_set, a) = (&bundle.motion_set, &self.around);
        if self.characters.num_characters() > MOST_POSED {
            self.characters.set_detail(Some(Detail { eye: self.eye, full_m: FULL_M, posed_m: POSED_M }))?;
        }
        // One behaviour alone can be loaded without look-ahead; those of weight 0 do not count.
        let none_counts = a.weights.iter().all(|&w| w == 0.0);
        let weighed = self.goals.iter().zip(a.weights.iter()).filter(|(_, weight)| **weight != 0.0 || none_counts);
        let order = weighed.fold(PolicyOrder::IDLE, |order, (g, &weight)| order.with_policy(g.policy, weight));
        let orders: Vec<PolicyOrder> = a.targets.iter().map(|&target| order.with_target(target)).collect();
        let run: &dyn Executor = if orders.len() >= PARALLEL_FROM { &Rayon } else { &Inline };
        self.characters.step_on(motion_set, dt, &orders, run)
    }

    fn measure(&mut self, dt: f32) -> StepFigures {
        self.slip.clear();
        self.slip.observe_characters(&self.characters, dt);
        let slip = Slip::from(&self.slip);
        let at_target = (0..self.config.characters).filter(|&c| self.is_at_target(c)).count();
        StepFigures { times: self.characters.times(), slip, at_target, ..StepFigures::default() }
    }

    fn is_at_target(&self, c: usize) -> bool {
        let (root, target) = (self.characters.root(c), self.around.targets[c]);
        (root.x - target.x).hypot(root.z - target.z) < self.config.reach_m
    }

    fn move_targets_on(&mut self) {
        for c in 0..self.config.characters {
            if self.is_at_target(c) {
                self.around.reached[c] += 1;
                let draw = u64::from(self.around.reached[c]) << 32 | c as u64;
                let mut rng = Pcg64Mcg::seed_from_u64(self.config.seed ^ draw.wrapping_mul(0x9E37_79B9_7F4A_7C15));
                self.around.targets[c] += random_offset(&mut rng, self.config.distances);
            }
        }
    }
}

/// Least distance between two starts along an axis, halved (m).
const APART_M: f32 = 0.4;

/// A place in some direction, within the distances.
fn random_offset(rng: &mut Pcg64Mcg, [near, far]: [f32; 2]) -> Vec3 {
    let (angle, ratio) = (rng.random_range(0.0..TAU), rng.random_range(0.0..1.0f32));
    let distance = near + (far - near) * ratio;
    Vec3::new(distance * angle.sin(), 0.0, distance * angle.cos())
}

/// Random start states and targets; starts are far enough apart for two bodies.
fn scatter(config: &CrowdRunConfig, states: &[u32]) -> (Vec<CharacterStart>, Vec<Vec3>) {
    let mut rng = Pcg64Mcg::seed_from_u64(config.seed);
    let side = (config.characters as f32).sqrt().ceil() as usize;
    let middle = (side as f32 - 1.0) * 0.5;
    (0..config.characters)
        .map(|i| {
            let place = |k: usize| (k as f32 - middle) * config.spacing_m;
            let most = (0.5 * config.spacing_m - APART_M).clamp(1e-3, 0.3 * config.spacing_m);
            let mut jitter = || rng.random_range(-most..most);
            let (x, z) = (place(i % side) + jitter(), place(i / side) + jitter());
            let root = Planar::new(x, z, rng.random_range(0.0..TAU));
            let own = Vec3::new(x, 0.0, z) + random_offset(&mut rng, config.distances);
            let target = if config.targets == TargetMode::Shared { Vec3::ZERO } else { own };
            (CharacterStart { root, state: states[rng.random_range(0..states.len())] }, target)
        })
        .unzip()
}
