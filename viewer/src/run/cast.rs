//! The cast of a run: a crowd, or the characters of a scene.

use super::Input;
use crate::bundle::OpenBundle;
use glam::Vec3;
use throng_precompute::scene::{Cast as SceneCast, Play, PlaySnapshot};
use throng_runtime::characters::{Characters, CharactersError, CharactersSnapshot, Goal, MotionSet};
use throng_runtime::sparring::Aim;

/// Characters from which on a step of a crowd is split over threads.
const PARALLEL_FROM: usize = 1000;

/// What a behaviour is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The character's target: a place, something to be struck, or the opponent's head.
    Target,
    /// Where and when the opponent's next blow lands: x, seconds, z.
    Threat,
}

/// A behaviour that is weighed against others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunGoal {
    /// Number of the policy.
    pub policy: usize,
    /// What it is about.
    pub about: About,
}

/// Who moves.
#[derive(Clone, Debug)]
pub(super) enum Cast {
    /// Characters that chase targets over the ground.
    Crowd(Box<Characters>),
    /// The characters of a scene.
    Scene(Box<Play>),
}

/// What it remembers at one instant.
#[derive(Clone, Debug)]
pub(super) enum CastSnapshot {
    Crowd(CharactersSnapshot),
    Scene(PlaySnapshot),
}

impl CastSnapshot {
    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        match self {
            Self::Crowd(s) => s.num_bytes(),
            Self::Scene(s) => s.num_bytes(),
        }
    }
}

impl Cast {
    pub fn characters(&self) -> &Characters {
        match self {
            Self::Crowd(characters) => characters,
            Self::Scene(play) => play.characters(),
        }
    }

    /// The scene that is played.
    pub fn play(&self) -> Option<&Play> {
        match self {
            Self::Crowd(_) => None,
            Self::Scene(play) => Some(play),
        }
    }

    /// What is weighed in a scene; none in a crowd, which weighs all behaviours.
    pub fn goals(&self) -> Vec<RunGoal> {
        let target = |policy| RunGoal { policy, about: About::Target };
        match self.play().map(|p| &p.cast) {
            None => Vec::new(),
            Some(SceneCast::Targets(practice)) => practice.config().goals.iter().map(|g| target(g.policy)).collect(),
            Some(SceneCast::Pairs(pairs)) => {
                let about = |aim| if aim == Aim::OpponentThreat { About::Threat } else { About::Target };
                let goals = pairs.config().goals.iter();
                goals.map(|g| RunGoal { policy: g.policy, about: about(g.aim) }).collect()
            }
        }
    }

    /// What each goal of a scene counts.
    pub fn weights(&self) -> Vec<f32> {
        match self.play().map(|p| &p.cast) {
            None => Vec::new(),
            Some(SceneCast::Targets(practice)) => practice.config().goals.iter().map(|g| g.weight).collect(),
            Some(SceneCast::Pairs(pairs)) => pairs.config().goals.iter().map(|g| g.weight).collect(),
        }
    }

    /// Takes the targets of a scene over: opponents' heads or what hangs there, and coming blows. Leaves those of a
    /// crowd as they are.
    pub fn observe(&self, targets: &mut Vec<Vec3>, threats: &mut Vec<Vec3>) {
        match self.play().map(|p| &p.cast) {
            None => {}
            Some(SceneCast::Pairs(pairs)) => {
                targets.clear();
                targets.extend(pairs.heads());
                threats.clear();
                threats.extend(pairs.threats());
            }
            Some(SceneCast::Targets(practice)) => {
                targets.clear();
                targets.extend(practice.targets().iter().map(|t| t.position()));
            }
        }
    }

    /// Takes a step.
    ///
    /// - `goals` and `weights`: of the run. Targets of a crowd are in `targets`.
    pub fn step(
        &mut self,
        bundle: &OpenBundle,
        dt: f32,
        (goals, weights): (&[RunGoal], &[f32]),
        targets: &[Vec3],
    ) -> Result<(), CharactersError> {
        let motion_set = bundle.motion_set();
        let characters = match self {
            Self::Scene(play) => {
                play.set_weights(weights)?;
                return play.step(motion_set, dt);
            }
            Self::Crowd(characters) => characters,
        };
        let all = goals.iter().zip(weights).map(|(g, &weight)| Goal { policy: g.policy, weight, targets });
        // One behaviour alone can be loaded without looking ahead; those switched off do not count.
        let none_counts = weights.iter().all(|&w| w == 0.0);
        let goals: Vec<Goal<'_>> = all.filter(|g| g.weight != 0.0 || none_counts).collect();
        if characters.num_characters() >= PARALLEL_FROM {
            characters.par_step(motion_set, dt, &goals)
        } else {
            characters.step(motion_set, dt, &goals)
        }
    }

    /// Moves a target of a scene; all targets if no character is named. Nothing else can be moved this way.
    pub fn move_target(&mut self, character: Option<usize>, to: Vec3) -> Result<(), CharactersError> {
        let Self::Scene(play) = self else { return Ok(()) };
        let all = 0..play.homes.len();
        all.filter(|&c| character.is_none_or(|who| who == c)).try_for_each(|c| play.set_home(c, to))
    }

    /// Lets a character play a segment at once.
    pub fn play_segment(&mut self, bundle: &OpenBundle, character: usize, segment: u32) -> Result<(), CharactersError> {
        match self {
            Self::Crowd(characters) => characters.play(bundle.motion_set(), character, segment),
            Self::Scene(play) => play.play(bundle.motion_set(), character, segment),
        }
    }

    pub fn snapshot(&self) -> CastSnapshot {
        match self {
            Self::Crowd(characters) => CastSnapshot::Crowd(characters.snapshot()),
            Self::Scene(play) => CastSnapshot::Scene(play.snapshot()),
        }
    }

    pub fn restore(&mut self, motion_set: &MotionSet, snapshot: &CastSnapshot) -> throng_runtime::Result<()> {
        match (self, snapshot) {
            (Self::Crowd(characters), CastSnapshot::Crowd(s)) => characters.restore(motion_set, s),
            (Self::Scene(play), CastSnapshot::Scene(s)) => play.restore(motion_set, s),
            _ => unreachable!("a run's record is of its own cast"),
        }
    }
}

impl Input {
    /// The same where it can be taken: a target within bounds; none for one that is nowhere.
    pub(super) fn limited(self) -> Option<Self> {
        let most = Vec3::splat(super::MAX_TARGET_M);
        match self {
            Self::Target { to, .. } if to.is_nan() => None,
            Self::Target { character, to } => Some(Self::Target { character, to: to.clamp(-most, most) }),
            other => Some(other),
        }
    }
}
