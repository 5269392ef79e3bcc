//! The characters at one instant, and one step of them.

use super::cast::{About, Cast, CastSnapshot, RunGoal};
use super::config::{RunConfig, STEP_HZ, TargetMode};
use super::figures::{BoutFigures, Slip, StepFigures};
use crate::bundle::OpenBundle;
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f32::consts::TAU;
use std::time::Instant;
use throng_precompute::BuildError;
use throng_precompute::scene::Scene;
use throng_precompute::slip::SlipMeter;
use throng_runtime::Planar;
use throng_runtime::characters::{Characters, CharactersError, Start};

/// Something done to a run from outside. Inputs are recorded and repeated when the run is.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// A target is moved; all targets if no character is named (m).
    Target {
        /// Whose.
        character: Option<usize>,
        /// Where to.
        to: Vec3,
    },
    /// What every behaviour counts (number of behaviours).
    Weights(Vec<f32>),
    /// A character plays a segment at once.
    Play {
        /// Which character.
        character: usize,
        /// Which segment.
        segment: u32,
    },
}

/// What of the run is not the characters' own: targets, weights, and when each character last chose.
#[derive(Clone, Debug, Default)]
pub(super) struct Surroundings {
    /// What each character's next choice is about.
    pub targets: Vec<Vec3>,
    /// Coming blows, for each character of a pair: x, seconds, z.
    pub threats: Vec<Vec3>,
    /// Targets that each character has reached so far.
    pub reached: Vec<u32>,
    /// What every goal counts.
    pub weights: Vec<f32>,
    /// Step at which each character last chose.
    pub choice_steps: Vec<u32>,
    /// Choices each character had made by the last step.
    pub num_choices: Vec<u32>,
    /// Target of each character when it last chose.
    pub choice_targets: Vec<Vec3>,
    /// Coming blow when it last chose.
    pub choice_threats: Vec<Vec3>,
    /// The step that comes next.
    pub step: u32,
}

/// All that later steps depend on.
#[derive(Clone, Debug)]
pub(super) struct Keyframe {
    cast: CastSnapshot,
    around: Surroundings,
}

impl Keyframe {
    /// The step that comes next after it.
    pub fn step(&self) -> u32 {
        self.around.step
    }

    pub fn weights(&self) -> &[f32] {
        &self.around.weights
    }

    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        let a = &self.around;
        let vectors = a.targets.len() + a.threats.len() + a.choice_targets.len() + a.choice_threats.len();
        let numbers = a.reached.len() + a.choice_steps.len() + a.num_choices.len() + a.weights.len();
        self.cast.num_bytes() + vectors * size_of::<Vec3>() + 4 * numbers
    }
}

/// The characters at one instant.
#[derive(Clone, Debug)]
pub(super) struct Simulation {
    pub config: RunConfig,
    pub cast: Cast,
    /// What is weighed (number of weights).
    pub goals: Vec<RunGoal>,
    pub around: Surroundings,
    slip: SlipMeter,
}

impl Simulation {
    /// Characters on a loose grid, each with a target in some direction. No step has been taken.
    ///
    /// - `weights`: of the first behaviours, which are weighed.
    pub fn new(bundle: &OpenBundle, config: RunConfig, weights: Vec<f32>) -> Result<Self, CharactersError> {
        let num_states = bundle.tables().graph().states.len() as u32;
        let (starts, targets) = scatter(&config, num_states);
        let characters = Characters::new(bundle.motion_set(), config.characters(), &starts)?;
        let goals = (0..weights.len()).map(|policy| RunGoal { policy, about: About::Target }).collect();
        let around = Surroundings { targets, weights, ..Surroundings::default() };
        Ok(Self::at_start(config, Cast::Crowd(Box::new(characters)), goals, around))
    }

    /// The characters of a scene where they start. No step has been taken.
    pub fn of_scene(bundle: &OpenBundle, scene: &Scene) -> Result<Self, BuildError> {
        let cast = Cast::Scene(Box::new(scene.play(bundle.tables(), bundle.motion_set())?));
        let mut around = Surroundings { weights: cast.weights(), ..Surroundings::default() };
        cast.observe(&mut around.targets, &mut around.threats);
        let goals = cast.goals();
        Ok(Self::at_start(RunConfig::of_scene(scene), cast, goals, around))
    }

    fn at_start(config: RunConfig, cast: Cast, goals: Vec<RunGoal>, around: Surroundings) -> Self {
        let n = config.characters;
        let around = Surroundings {
            reached: vec![0; n],
            choice_steps: vec![0; n],
            num_choices: vec![0; n],
            choice_targets: around.targets.clone(),
            choice_threats: around.threats.clone(),
            ..around
        };
        Self { config, cast, goals, around, slip: SlipMeter::new(n) }
    }

    pub fn keyframe(&self) -> Keyframe {
        Keyframe { cast: self.cast.snapshot(), around: self.around.clone() }
    }

    pub fn restore(&mut self, bundle: &OpenBundle, keyframe: &Keyframe) -> throng_runtime::Result<()> {
        self.cast.restore(bundle.motion_set(), &keyframe.cast)?;
        self.around.clone_from(&keyframe.around);
        self.slip.forget_step();
        Ok(())
    }

    /// Lets an input take effect.
    pub fn take(&mut self, bundle: &OpenBundle, input: &Input) -> Result<(), CharactersError> {
        match input {
            Input::Target { character, to } => self.move_target(*character, *to)?,
            Input::Weights(weights) => self.around.weights.clone_from(weights),
            Input::Play { character, segment } => self.cast.play_segment(bundle, *character, *segment)?,
        }
        Ok(())
    }

    /// Moves a target; all targets if no character is named. Opponents' heads cannot be moved.
    pub fn move_target(&mut self, character: Option<usize>, to: Vec3) -> Result<(), CharactersError> {
        if self.cast.play().is_some() {
            self.cast.move_target(character, to)?;
            self.cast.observe(&mut self.around.targets, &mut self.around.threats);
            return Ok(());
        }
        match character {
            None => self.around.targets.fill(to),
            Some(c) => {
                if let Some(target) = self.around.targets.get_mut(c) {
                    *target = to;
                }
            }
        }
        Ok(())
    }

    /// One step; the very first one only takes the first choices. Measures it.
    pub fn step(&mut self, bundle: &OpenBundle) -> Result<StepFigures, CharactersError> {
        let dt = if self.around.step == 0 { 0.0 } else { 1.0 / STEP_HZ };
        let a = &mut self.around;
        let begin = Instant::now();
        self.cast.step(bundle, dt, (&self.goals, &a.weights), &a.targets)?;
        let wall_s = begin.elapsed().as_secs_f64();
        for c in 0..self.config.characters {
            let made = self.cast.characters().num_choices(c);
            if made != std::mem::replace(&mut a.num_choices[c], made) {
                a.choice_steps[c] = a.step;
                a.choice_targets[c] = a.targets[c];
                if let Some(&threat) = a.threats.get(c) {
                    a.choice_threats[c] = threat;
                }
            }
        }
        self.cast.observe(&mut a.targets, &mut a.threats);
        let figures = StepFigures { wall_s, ..self.measure(dt) };
        self.around.step += 1;
        if self.cast.play().is_none() && self.config.targets == TargetMode::Wander {
            self.move_targets_on();
        }
        Ok(figures)
    }

    fn measure(&mut self, dt: f32) -> StepFigures {
        let characters = self.cast.characters();
        self.slip.clear();
        self.slip.observe(characters, dt);
        let slip = Slip::from(&self.slip);
        let at_target = (0..self.config.characters).filter(|&c| self.is_at_target(c)).count();
        let bout = self.cast.play().map(BoutFigures::from);
        StepFigures { times: characters.times(), slip, at_target, bout, ..StepFigures::default() }
    }

    fn is_at_target(&self, c: usize) -> bool {
        let (root, target) = (self.cast.characters().root(c), self.around.targets[c]);
        (root.x - target.x).hypot(root.z - target.z) < self.config.reach_m
    }

    fn move_targets_on(&mut self) {
        for c in 0..self.config.characters {
            if self.is_at_target(c) {
                self.around.reached[c] += 1;
                let draw = u64::from(self.around.reached[c]) << 32 | c as u64;
                let mut rng = Pcg64Mcg::seed_from_u64(self.config.seed ^ draw.wrapping_mul(0x9E37_79B9_7F4A_7C15));
                self.around.targets[c] += somewhere(&mut rng, self.config.distances);
            }
        }
    }
}

/// A place in some direction, within the distances.
fn somewhere(rng: &mut Pcg64Mcg, [near, far]: [f32; 2]) -> Vec3 {
    let (angle, ratio) = (rng.random_range(0.0..TAU), rng.random_range(0.0..1.0f32));
    let distance = near + (far - near) * ratio;
    Vec3::new(distance * angle.sin(), 0.0, distance * angle.cos())
}

fn scatter(config: &RunConfig, num_states: u32) -> (Vec<Start>, Vec<Vec3>) {
    let mut rng = Pcg64Mcg::seed_from_u64(config.seed);
    let side = (config.characters as f32).sqrt().ceil() as usize;
    let middle = (side as f32 - 1.0) * 0.5;
    (0..config.characters)
        .map(|i| {
            let place = |k: usize| (k as f32 - middle) * config.spacing_m;
            let mut jitter = || rng.random_range(-0.3..0.3f32) * config.spacing_m;
            let (x, z) = (place(i % side) + jitter(), place(i / side) + jitter());
            let root = Planar::new(x, z, rng.random_range(0.0..TAU));
            let own = Vec3::new(x, 0.0, z) + somewhere(&mut rng, config.distances);
            let target = if config.targets == TargetMode::Shared { Vec3::ZERO } else { own };
            (Start { root, state: rng.random_range(0..num_states.max(1)) }, target)
        })
        .unzip()
}
