//! Why a character took its action: the scores of all it could have done, as they were when it chose.

use super::{GoalSubject, PolicyChooser};
use glam::{Vec2, Vec3};
use throng_core::Planar;

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
        let target = seen(chooser.chosen_subject_position(goal.subject));
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
