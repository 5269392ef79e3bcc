//! Exact model: reward and outcome of an action for the target's true place, and policies followed in it.

use glam::Vec3;
use throng_core::policy::{LookAheadGoal, LookAheadJob, PathRecord, PolicyTable, RankedActions, SegmentRecord};

/// A state, and a target in the character's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolicySituation {
    /// State of the motion graph.
    pub state: u32,
    /// Target: +Z ahead, +X left, Y the height above ground, or in a space-time grid the time left (m, or s).
    pub target: Vec3,
}

impl PolicySituation {
    /// True if the event of a space-time grid has happened: there is no more reward.
    pub fn is_over(&self, table: &PolicyTable) -> bool {
        table.grid().is_space_time() && self.target.y < 0.0
    }
}

/// Reward and outcome of an action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayedAction {
    /// Reward, as in the solved policy.
    pub reward: f32,
    /// Discount over the segment.
    pub discount: f32,
    /// State and target afterwards.
    pub then: PolicySituation,
}

/// Plays an action. The target keeps its place in the world, and is not clamped to the grid.
///
/// Reward and discount include the cost of the transition.
///
/// - `action`: index within the state's actions (both exist).
pub fn play(table: &PolicyTable, from: PolicySituation, action: u8) -> PlayedAction {
    let (action, target) = (usize::from(action), from.target);
    let segment = table.actions().segments_of(from.state)[action];
    let left = table.reward().after_transition(table.errors_of(from.state)[action]);
    let (record, place) = (&table.segments()[segment as usize], table.to_grid(target));
    let (seen, [x, z, distance]) = table.target_along(segment, place);
    let (y, reward) = match table.paths().get(segment as usize) {
        Some(path) => (target.y - path.duration_s, event_reward(table, record, path, place)),
        None => (target.y, sample_reward(table, record, seen, distance)),
    };
    let target = Vec3::new(x, y, z) + table.centre();
    let then = PolicySituation { state: record.end, target };
    PlayedAction { reward: left * reward, discount: left * record.discount, then }
}

/// Reward of a segment's samples.
fn sample_reward(table: &PolicyTable, record: &SegmentRecord, place: Vec3, end_distance: f32) -> f32 {
    let reward = table.reward();
    let start_kernel = reward.kernel((place.x * place.x + place.z * place.z).sqrt());
    if table.grid().is_polar() {
        reward.of_segment::<true>(record, place, start_kernel, end_distance)
    } else {
        reward.of_segment::<false>(record, place, start_kernel, end_distance)
    }
}

/// Reward of a segment during which the event happens, discounted to then.
fn event_reward(table: &PolicyTable, record: &SegmentRecord, path: &PathRecord, place: Vec3) -> f32 {
    if !(0.0..path.duration_s).contains(&place.y) {
        return 0.0;
    }
    record.discount.powf(place.y / path.duration_s) * table.reward().of_event(path.position_at(place.y), place)
}

/// Discounted reward that a policy collects from each situation, by look-ahead as in the runtime.
///
/// - `negligible`: discount below which further rewards are ignored (> 0, < 1).
/// - `pick`: selects one of the ranked actions in a situation.
/// - returns one sum for each situation.
pub fn collect_rewards(
    table: &PolicyTable,
    from: &[PolicySituation],
    negligible: f64,
    mut pick: impl FnMut(PolicySituation, &RankedActions) -> u8,
) -> Vec<f64> {
    let n = from.len();
    let mut states: Vec<u32> = from.iter().map(|s| s.state).collect();
    let mut targets: Vec<Vec3> = from.iter().map(|s| s.target).collect();
    let (mut discounts, mut sums) = (vec![1.0f64; n], vec![0.0; n]);
    let (mut ranked, weights) = (vec![RankedActions::NONE; n], vec![1.0; n]);
    while discounts.iter().any(|&d| d > negligible) {
        let goals = [LookAheadGoal { policy: table, weights: &weights, targets: &targets }];
        let done = LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run();
        done.unwrap_or_else(|e| unreachable!("states come from the table, targets are near: {e}"));
        for i in 0..n {
            let from = PolicySituation { state: states[i], target: targets[i] };
            let played = play(table, from, pick(from, &ranked[i]));
            sums[i] += discounts[i] * f64::from(played.reward);
            discounts[i] *= f64::from(played.discount);
            (states[i], targets[i]) = (played.then.state, played.then.target);
        }
    }
    sums
}
