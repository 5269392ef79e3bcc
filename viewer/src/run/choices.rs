//! What the last choice of every character was about.

use crate::bundle::OpenBundle;
use glam::Vec3;
use std::sync::Arc;
use throng_runtime::characters::Characters;

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

/// What a character chose about.
#[derive(Clone, Debug)]
pub struct LastChoice {
    /// Step at which it was.
    pub step: u32,
    /// Its target: a place, something to be struck, or the opponent's head (m).
    pub target: Vec3,
    /// Where and when the opponent's next blow was to land: x, seconds, z; zero without an opponent.
    pub threat: Vec3,
    /// What every goal counted; empty where that is not known, because it was before a saved state (number of goals).
    pub weights: Arc<[f32]>,
}

/// The last choice of every character.
#[derive(Clone, Debug, Default)]
pub(super) struct Choices {
    /// Choices that each had made by the last step.
    num: Vec<u32>,
    last: Vec<LastChoice>,
}

impl Choices {
    /// Before any choice.
    pub fn new(characters: usize) -> Self {
        let none = LastChoice { step: 0, target: Vec3::ZERO, threat: Vec3::ZERO, weights: Arc::from([]) };
        Self { num: vec![0; characters], last: vec![none; characters] }
    }

    /// Records the choices of a step.
    ///
    /// - `targets`, `threats`: as they were before the step; there may be no threats (number of characters).
    /// - `weights`: what every goal counted.
    pub fn observe(
        &mut self,
        characters: &Characters,
        (targets, threats): (&[Vec3], &[Vec3]),
        weights: &Arc<[f32]>,
        step: u32,
    ) {
        for (c, (num, last)) in self.num.iter_mut().zip(&mut self.last).enumerate() {
            let made = characters.num_choices(c);
            if made != std::mem::replace(num, made) {
                let threat = threats.get(c).copied().unwrap_or_default();
                *last = LastChoice { step, target: targets[c], threat, weights: Arc::clone(weights) };
            }
        }
    }

    /// Number of characters.
    pub fn len(&self) -> usize {
        self.last.len()
    }

    /// That of a character (< number of characters).
    pub fn last(&self, character: usize) -> &LastChoice {
        &self.last[character]
    }

    /// Memory that it takes, but for weights, which are shared (bytes).
    pub fn num_bytes(&self) -> usize {
        size_of_val(self.num.as_slice()) + size_of_val(self.last.as_slice())
    }
}

/// A character that chooses by policies, and all that bears on its choices.
#[derive(Clone, Copy, Debug)]
pub struct Chooser<'a> {
    /// The tables.
    pub bundle: &'a OpenBundle,
    /// Its companions.
    pub characters: &'a Characters,
    /// Its number among them.
    pub number: usize,
    /// What is weighed.
    pub goals: &'a [RunGoal],
    /// What its last choice was about.
    pub choice: &'a LastChoice,
    /// Its target now (m).
    pub target: Vec3,
    /// The coming blow now; none without an opponent: x, seconds, z.
    pub threat: Option<Vec3>,
    /// It loads the stored best action instead of looking ahead.
    pub single_load: bool,
    /// Randomness of its choices among the best actions.
    pub temperature: f32,
    /// The step that is shown.
    pub now: u32,
}

impl Chooser<'_> {
    /// What a behaviour is about for it now; none where no behaviour asks for that.
    pub fn about(&self, about: About) -> Option<Vec3> {
        match about {
            About::Target => Some(self.target),
            About::Threat => self.threat,
        }
    }

    /// What a behaviour was about when it chose.
    pub fn was_about(&self, about: About) -> Vec3 {
        match about {
            About::Target => self.choice.target,
            About::Threat => self.choice.threat,
        }
    }
}
