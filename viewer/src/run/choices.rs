//! Records of the last choice of every character.

use crate::bundle::OpenBundle;
use glam::Vec3;
use std::sync::Arc;
use throng_runtime::characters::Characters;

/// Subject of a behaviour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The character's target: a place, something to be struck, or the opponent's head.
    Target,
    /// Place and time of the opponent's next blow: x, seconds, z.
    Threat,
}

/// A behaviour that is weighed against others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunGoal {
    /// Number of the policy.
    pub policy: usize,
    /// Subject of the behaviour.
    pub about: About,
}

/// Data of a choice.
#[derive(Clone, Debug)]
pub struct LastChoice {
    /// Step of the choice.
    pub step: u32,
    /// Target of the character: a place, something to be struck, or the opponent's head (m).
    pub target: Vec3,
    /// Place and time of the opponent's next blow: x, seconds, z; zero without an opponent.
    pub threat: Vec3,
    /// Weight of every goal; empty if unknown, for choices before a saved state (number of goals).
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
    /// - `weights`: weight of every goal.
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

    /// The last choice of a character (< number of characters).
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
    /// All characters of its group.
    pub characters: &'a Characters,
    /// Number of the character among them.
    pub number: usize,
    /// Goals that are weighed.
    pub goals: &'a [RunGoal],
    /// Data of its last choice.
    pub choice: &'a LastChoice,
    /// Present target (m).
    pub target: Vec3,
    /// The coming blow now; none without an opponent: x, seconds, z.
    pub threat: Option<Vec3>,
    /// The stored best action is loaded, without look-ahead.
    pub single_load: bool,
    /// Randomness of its choices among the best actions.
    pub temperature: f32,
    /// The step that is shown.
    pub now: u32,
}

impl Chooser<'_> {
    /// Present position of a subject; none if no behaviour has that subject.
    pub fn about(&self, about: About) -> Option<Vec3> {
        match about {
            About::Target => Some(self.target),
            About::Threat => self.threat,
        }
    }

    /// Position of a subject at the last choice.
    pub fn was_about(&self, about: About) -> Vec3 {
        match about {
            About::Target => self.choice.target,
            About::Threat => self.choice.threat,
        }
    }
}
