//! Exhaustive search: the best result of a few actions, as a reference for policies.
//!
//! A sequence of actions is worth the discounted rewards that it collects at the target's exact place, plus the
//! discounted value at its end. A look-ahead is a search of depth 1; every further action leaves less to the values
//! that are interpolated between cells.

mod bound;
mod squares;
#[cfg(test)]
mod tests;

pub use bound::ValueBounds;

use throng_bake::policy::{PolicySituation, play};
use throng_core::policy::{MAX_ACTIONS, PolicyTable};

/// Most actions in a sequence.
pub const MAX_DEPTH: usize = 8;

/// The best sequence of actions from a situation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BestSequence {
    /// Rewards and the value at the end, discounted.
    pub score: f32,
    /// Index of each action within its state's (the search's depth, then zeros).
    pub actions: [u8; MAX_DEPTH],
    /// Look-aheads made on the way.
    pub look_aheads: u64,
}

/// Depth-first search over all sequences of actions.
///
/// The last action of all sequences through a state is one look-ahead of the runtime. With bounds, actions that
/// cannot lead to more than is found already are left out: the score found is the same.
#[derive(Clone, Copy, Debug)]
pub struct PolicySearch<'a> {
    table: &'a PolicyTable,
    depth: usize,
    bounds: Option<&'a ValueBounds>,
}

impl<'a> PolicySearch<'a> {
    /// - `depth`: actions in a sequence (1 to 8; clamped).
    /// - `bounds`: of the same table for at least this depth, or none to try every sequence.
    pub fn new(table: &'a PolicyTable, depth: usize, bounds: Option<&'a ValueBounds>) -> Self {
        Self { table, depth: depth.clamp(1, MAX_DEPTH), bounds }
    }

    /// The best sequence (the state exists, the target is finite and, with bounds, covered by them).
    pub fn best(&self, from: PolicySituation) -> BestSequence {
        let mut found = BestSequence { score: f32::NEG_INFINITY, actions: [0; MAX_DEPTH], look_aheads: 0 };
        let (score, actions) = self.descend(from, self.depth, f32::NEG_INFINITY, &mut found.look_aheads);
        (found.score, found.actions) = (score, actions);
        found
    }

    /// The best score with `left` actions to go, and the actions; no more than `enough` where there is none above it.
    fn descend(&self, at: PolicySituation, left: usize, enough: f32, look_aheads: &mut u64) -> (f32, [u8; MAX_DEPTH]) {
        if at.is_over(self.table) {
            return (0.0, [0; MAX_DEPTH]);
        }
        let mut scores = [0.0; MAX_ACTIONS];
        let n = self.table.exact_scores(at.state, at.target, &mut scores);
        let n = n.unwrap_or_else(|e| unreachable!("the state exists, the target is finite: {e}"));
        *look_aheads += 1;
        let mut best = (f32::NEG_INFINITY, [0; MAX_DEPTH]);
        if left == 1 {
            let (action, score) = most(&scores[..n]);
            best.0 = score;
            best.1[0] = action;
            return best;
        }
        for action in by_score(&scores[..n]) {
            let played = play(self.table, at, action);
            let floor = best.0.max(enough);
            if let Some(bounds) = self.bounds {
                let most = bounds.upper_bound(left - 1, played.then);
                if bounds.is_hopeless(played.reward + played.discount * most, floor) {
                    continue;
                }
            }
            let needed = (floor - played.reward) / played.discount;
            let (rest, actions) = self.descend(played.then, left - 1, needed, look_aheads);
            let score = played.reward + played.discount * rest;
            if score > best.0 {
                best.0 = score;
                best.1[0] = action;
                best.1[1..].copy_from_slice(&actions[..MAX_DEPTH - 1]);
            }
        }
        best
    }
}

/// The first of the greatest scores.
fn most(scores: &[f32]) -> (u8, f32) {
    let mut best = (0, f32::NEG_INFINITY);
    for (i, &score) in scores.iter().enumerate() {
        if score > best.1 {
            best = (i as u8, score);
        }
    }
    best
}

/// Actions, the best score first: what is found early rules out more.
fn by_score(scores: &[f32]) -> impl Iterator<Item = u8> {
    let mut order: [u8; MAX_ACTIONS] = std::array::from_fn(|i| i as u8);
    order[..scores.len()].sort_unstable_by(|&a, &b| scores[usize::from(b)].total_cmp(&scores[usize::from(a)]));
    order.into_iter().take(scores.len())
}
