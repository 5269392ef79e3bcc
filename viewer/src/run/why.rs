//! Why a character took its action: the scores of all it could have done, as they were when it chose.

use super::Run;
use crate::document::Bundle;
use glam::{Vec2, Vec3};
use throng_runtime::Planar;

/// One behaviour's say in a choice.
#[derive(Clone, Debug, PartialEq)]
pub struct BehaviourScore {
    /// Number of the policy.
    pub policy: usize,
    /// What it counted.
    pub weight: f32,
    /// Value of the state for the target, before any action (003 eq. 4).
    pub value: f32,
}

/// An action that could have been taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Number among the actions of the state.
    pub action: usize,
    /// Segment it plays.
    pub segment: u32,
    /// Weighted sum of the behaviours' scores: reward and discounted value of where it leads.
    pub score: f32,
    /// Score by each behaviour, unweighted. [Size: number of behaviours]
    pub by_behaviour: Vec<f32>,
    /// Where it leads, as seen from the character. [Unit: m, m, rad]
    pub displacement: Planar,
}

/// A choice and all that bore on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Why {
    /// Step at which it was made.
    pub step: u32,
    /// State of the character then.
    pub state: u32,
    /// Where it stood. [Unit: m, m, rad]
    pub root: Planar,
    /// Its target then, in the world. [Unit: m]
    pub target: Vec3,
    /// The target as seen from the character. [Unit: m]
    pub local_target: Vec3,
    /// The behaviours.
    pub behaviours: Vec<BehaviourScore>,
    /// All actions of the state, the best first.
    pub candidates: Vec<Candidate>,
    /// Place among the candidates of the one that was taken.
    pub chosen: usize,
}

pub(super) fn explain(bundle: &Bundle, run: &Run, character: usize) -> Option<Why> {
    let choice = run.troupe().last_choice(character)?;
    let (target, step) = run.last_choice(character);
    let local = choice.root.inverse_transform_point(Vec2::new(target.x, target.z));
    let local_target = Vec3::new(local.x, target.y, local.y);
    let weights = run.weights_at(step);
    let graph = bundle.tables().graph();
    let segments = graph.segments_of(choice.state);
    let mut candidates: Vec<Candidate> = segments
        .iter()
        .enumerate()
        .map(|(action, &segment)| Candidate {
            action,
            segment,
            score: 0.0,
            by_behaviour: Vec::new(),
            displacement: graph.segments[segment as usize].displacement(),
        })
        .collect();
    let mut behaviours = Vec::new();
    let mut scores = vec![0.0; segments.len()];
    for (policy, &weight) in weights.iter().enumerate() {
        let table = bundle.repertoire().policy(policy)?;
        table.action_scores(choice.state, local_target, &mut scores).ok()?;
        for (c, &score) in candidates.iter_mut().zip(&scores) {
            c.by_behaviour.push(score);
            c.score += weight * score;
        }
        behaviours.push(BehaviourScore { policy, weight, value: table.value(choice.state, local_target) });
    }
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.action.cmp(&b.action)));
    let played = run.troupe().segment(character).0;
    let chosen = candidates.iter().position(|c| c.segment == played)?;
    let state = choice.state;
    Some(Why { step, state, root: choice.root, target, local_target, behaviours, candidates, chosen })
}
