//! Records of the last choice of every character.

use crate::bundle::OpenBundle;
use glam::Vec3;
use std::sync::Arc;
use throng_core::characters::Characters;

/// Subject of a behaviour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalSubject {
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
    pub subject: GoalSubject,
}

/// Data of a choice.
#[derive(Clone, Debug)]
pub struct RecordedChoice {
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
pub(super) struct ChoiceRecord {
    /// Choices that each had made by the last step.
    num: Vec<u32>,
    last: Vec<RecordedChoice>,
}

impl ChoiceRecord {
    /// Before any choice.
    pub fn new(characters: usize) -> Self {
        let none = RecordedChoice { step: 0, target: Vec3::ZERO, threat: Vec3::ZERO, weights: Arc::from([]) };
        Self { num: vec![0; characters], last: vec![none; characters] }
    }

    /// Records the choices of a step.
    ///
    /// - `targets`, `threats`: as they were before the step; there may be no threats (number of characters).
    /// - `weights`: weight of every goal.
    pub fn observe(
        &mut self,
        characters: &Characters,
        targets: &[Vec3],
        threats: &[Vec3],
        weights: &Arc<[f32]>,
        step: u32,
    ) {
        for (c, (num, last)) in self.num.iter_mut().zip(&mut self.last).enumerate() {
            let made = characters.num_choices(c);
            if made != std::mem::replace(num, made) {
                let threat = threats.get(c).copied().unwrap_or_default();
                *last = RecordedChoice { step, target: targets[c], threat, weights: Arc::clone(weights) };
            }
        }
    }

    /// Number of characters.
    pub fn len(&self) -> usize {
        self.last.len()
    }

    /// The last choice of a character (< number of characters).
    pub fn last(&self, character: usize) -> &RecordedChoice {
        &self.last[character]
    }
}

/// A character that chooses by policies, and all that bears on its choices.
#[derive(Clone, Copy, Debug)]
pub struct PolicyChooser<'a> {
    /// The tables.
    pub bundle: &'a OpenBundle,
    /// All characters of its group.
    pub characters: &'a Characters,
    /// Number of the character among them.
    pub number: usize,
    /// Goals that are weighed.
    pub goals: &'a [RunGoal],
    /// Data of its last choice.
    pub choice: &'a RecordedChoice,
    /// Present target (m).
    pub target: Vec3,
    /// The coming blow now; none without an opponent: x, seconds, z.
    pub threat: Option<Vec3>,
    /// Randomness of its choices among the best actions.
    pub temperature: f32,
    /// The step that is shown.
    pub now: u32,
}

impl PolicyChooser<'_> {
    /// Present position of a subject; none if no behaviour has that subject.
    pub fn subject_position(&self, about: GoalSubject) -> Option<Vec3> {
        match about {
            GoalSubject::Target => Some(self.target),
            GoalSubject::Threat => self.threat,
        }
    }

    /// Position of a subject at the last choice.
    pub fn chosen_subject_position(&self, about: GoalSubject) -> Vec3 {
        match about {
            GoalSubject::Target => self.choice.target,
            GoalSubject::Threat => self.choice.threat,
        }
    }
}
