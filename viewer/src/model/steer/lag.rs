//! Delay from a key press to a visible change: a twin without the key press runs beside the steered character.

use crate::run::{BlendRun, RunInput, SceneFork, SceneRun, target_home};
use crate::{bundle::OpenBundle, command::SteerInput};
use glam::Vec3;
use throng_core::{Mat3x4, NUM_JOINTS, Planar};

/// A change is seen where some joint is farther than this from where it would be (m).
const SEEN_M: f32 = 0.02;
/// Steps after which a key without a visible effect counts as having none.
const MOST_STEPS: u32 = 180;
/// Runs of more characters are not copied for it.
const MOST_CHARACTERS: usize = 2000;
/// Measurements that are kept.
const KEPT: usize = 200;

/// Delays from key presses to visible changes, the latest last (frames).
#[derive(Clone, Debug, Default)]
pub struct Lags {
    frames: Vec<u32>,
    /// Keys without an effect.
    unseen: u32,
}

impl Lags {
    /// The last one (frames of 1/60 s).
    pub fn last(&self) -> Option<u32> {
        self.frames.last().copied()
    }

    /// Median, and 95th percentile (frames of 1/60 s).
    pub fn median_and_p95(&self) -> Option<(u32, u32)> {
        let mut sorted = self.frames.clone();
        sorted.sort_unstable();
        let at = |share: usize| sorted.get((sorted.len() * share / 100).min(sorted.len().saturating_sub(1))).copied();
        Some((at(50)?, at(95)?))
    }

    /// Number of measured keys, and of keys without a visible effect.
    pub fn count(&self) -> (usize, u32) {
        (self.frames.len(), self.unseen)
    }

    fn record(&mut self, steps: Option<u32>) {
        match steps {
            // The first step that depends on a key is shown one frame after the key press.
            Some(steps) => self.frames.push(steps),
            None => self.unseen += 1,
        }
        if self.frames.len() > KEPT {
            self.frames.remove(0);
        }
    }
}

/// A copy of the run in which the key was not pressed.
#[derive(Clone)]
pub(super) struct Twin {
    who: TwinRun,
    steps: u32,
}

#[derive(Clone)]
enum TwinRun {
    Scene { fork: Box<SceneFork>, character: usize, held: SteerInput },
    Blend(Box<BlendRun>),
}

impl Twin {
    /// - `held`: input that the twin keeps holding down.
    pub fn fork_scene(run: &SceneRun, character: usize, held: SteerInput) -> Option<Self> {
        let is_small = run.simulation().num_characters() <= MOST_CHARACTERS;
        let fork = || TwinRun::Scene { fork: Box::new(run.fork()), character, held };
        is_small.then(|| Self { who: fork(), steps: 0 })
    }

    pub fn copy_blend(run: &BlendRun) -> Option<Self> {
        Some(Self { who: TwinRun::Blend(Box::new(run.clone())), steps: 0 })
    }

    /// Goes on by as many steps and compares; false where that is over.
    ///
    /// - `seen`: root and joints of the steered character; `way`: target for an input and a position.
    pub fn compare(
        &mut self,
        bundle: &OpenBundle,
        steps: u32,
        seen: (Planar, &[Mat3x4]),
        direction: impl Fn(SteerInput, Vec3) -> Option<Vec3>,
        lags: &mut Lags,
    ) -> bool {
        for _ in 0..steps {
            let done = match &mut self.who {
                TwinRun::Scene { fork, character, held } => {
                    let root = fork.simulation().root(*character).map(|root| root.translation());
                    let home = target_home(fork.simulation(), *character);
                    let to = root.and_then(|at| direction(*held, at)).zip(home).map(|(to, home)| to.with_y(home.y));
                    let input = to.map(|to| RunInput::Target { character: Some(*character), to });
                    input.map_or(Ok(()), |input| fork.input(input)).and_then(|()| fork.step())
                }
                TwinRun::Blend(run) => run.step(bundle),
            };
            if done.is_err() {
                return false;
            }
            self.steps += 1;
        }
        let (root, pose) = match &self.who {
            TwinRun::Scene { fork, character, .. } => {
                let simulation = fork.simulation();
                let Some(there) = simulation.root(*character).zip(simulation.pose(*character)) else { return false };
                (there.0, &there.1[..])
            }
            TwinRun::Blend(run) => (run.reel.moment().roots[0], &run.reel.moment().poses[..NUM_JOINTS]),
        };
        let place = |root: Planar, m: &Mat3x4| root.rotation() * m.translation() + root.translation();
        let apart = seen.1.iter().zip(pose).map(|(a, b)| place(seen.0, a).distance(place(root, b)));
        let is_seen = apart.fold(0.0, f32::max) > SEEN_M;
        let is_over = is_seen || self.steps >= MOST_STEPS;
        if is_over {
            lags.record(is_seen.then_some(self.steps));
        }
        !is_over
    }
}
