//! Records of the last choice of every character.

use crate::bundle::OpenBundle;
use glam::{Vec2, Vec3};
use std::sync::Arc;
use throng_core::{Planar, characters::Characters};

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
    pub fn observe(&mut self, group: &Characters, targets: &[Vec3], threats: &[Vec3], weights: &Arc<[f32]>, step: u32) {
        for (c, (num, last)) in self.num.iter_mut().zip(&mut self.last).enumerate() {
            let made = group.num_choices(c);
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

/// Contribution of one behaviour to a choice.
#[derive(Clone, Debug, PartialEq)]
pub struct BehaviourScore {
    /// Number of the policy.
    pub policy: usize,
    /// Weight while it is active.
    pub weight: f32,
    /// Subject of the behaviour.
    pub subject: GoalSubject,
    /// Position of the subject relative to the character: x, height or seconds, z (m).
    pub target: Vec3,
    /// The target was where the behaviour is active (Lee and Lee 2004, section 6); otherwise it did not count.
    pub is_active: bool,
    /// Value of the state for the target, before any action (Lee and Lee 2004, eq. 4).
    pub value: f32,
}

impl BehaviourScore {
    /// Weight in this choice.
    pub fn counted(&self) -> f32 {
        if self.is_active { self.weight } else { 0.0 }
    }
}

/// An action that could have been taken.
#[derive(Clone, Debug, PartialEq)]
pub struct ActionCandidate {
    /// Number among the actions of the state.
    pub action: usize,
    /// Segment it plays.
    pub segment: u32,
    /// Weighted sum of the behaviours' scores: reward and discounted value of where it leads.
    pub score: f32,
    /// Score by each behaviour, unweighted (number of behaviours).
    pub by_behaviour: Vec<f32>,
    /// Displacement relative to the character (m, m, rad).
    pub displacement: Planar,
}

/// A choice and all that bore on it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChoiceReason {
    /// Step of the choice.
    pub step: u32,
    /// State of the character then.
    pub state: u32,
    /// Root of the character then (m, m, rad).
    pub root: Planar,
    /// Target then, in the world (m).
    pub target: Vec3,
    /// The target as seen from the character (m).
    pub local_target: Vec3,
    /// The behaviours.
    pub behaviours: Vec<BehaviourScore>,
    /// All actions of the state, the best first.
    pub candidates: Vec<ActionCandidate>,
    /// Index of the taken action among the candidates.
    pub chosen: usize,
}

/// Explains the choice of a character's segment; none before its first choice and for a segment that was not chosen.
pub fn explain_choice(chooser: &PolicyChooser<'_>) -> Option<ChoiceReason> {
    let (bundle, c) = (chooser.bundle, chooser.choice);
    let choice = chooser.characters.last_choice(chooser.number).filter(|_| !c.weights.is_empty())?;
    let seen = |target: Vec3| {
        let local = choice.root.inverse_transform_point(Vec2::new(target.x, target.z));
        Vec3::new(local.x, target.y, local.y)
    };
    let graph = bundle.tables().graph();
    let segments = graph.segments_of(choice.state);
    let candidate = |(action, &segment): (usize, &u32)| {
        let displacement = graph.segments[segment as usize].displacement();
        ActionCandidate { action, segment, score: 0.0, by_behaviour: Vec::new(), displacement }
    };
    let mut candidates: Vec<ActionCandidate> = segments.iter().enumerate().map(candidate).collect();
    let mut behaviours = Vec::new();
    let mut scores = vec![0.0; segments.len()];
    for (goal, &weight) in chooser.goals.iter().zip(c.weights.iter()) {
        let table = bundle.motion_set.policy(goal.policy)?;
        let target = seen(if goal.subject == GoalSubject::Threat { c.threat } else { c.target });
        table.action_scores(choice.state, target, &mut scores).ok()?;
        let value = table.value(choice.state, target);
        let is_active = table.region().contains(target);
        let b = BehaviourScore { policy: goal.policy, weight, subject: goal.subject, target, is_active, value };
        for (candidate, &score) in candidates.iter_mut().zip(&scores) {
            candidate.by_behaviour.push(score);
            candidate.score += b.counted() * score;
        }
        behaviours.push(b);
    }
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.action.cmp(&b.action)));
    let played = chooser.characters.segment(chooser.number).0;
    let chosen = candidates.iter().position(|c| c.segment == played)?;
    let (step, target, local_target) = (c.step, c.target, seen(c.target));
    let (state, root) = (choice.state, choice.root);
    Some(ChoiceReason { step, state, root, target, local_target, behaviours, candidates, chosen })
}
