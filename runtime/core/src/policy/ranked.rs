//! The best actions of a look-ahead, and the choice among them.

use super::maths::{greatest, least};
use super::table::NO_ACTION;
use throng_base::maths;
use throng_base::simd::{LANES, Lanes};

/// Number of actions that a look-ahead ranks.
pub const MAX_RANKED: usize = 4;

/// The best actions of a state for a target, best first; for equal scores the lower index comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankedActions {
    /// Scores, descending; negative infinity beyond the last action.
    pub scores: [f32; MAX_RANKED],
    /// Indices within the state's actions; [`NO_ACTION`] beyond the last one.
    pub actions: [u8; MAX_RANKED],
}

impl RankedActions {
    /// No action yet.
    pub const NONE: Self = Self { scores: [f32::NEG_INFINITY; MAX_RANKED], actions: [NO_ACTION; MAX_RANKED] };

    /// The best action.
    pub fn best(&self) -> u8 {
        self.actions[0]
    }

    /// The best of a state's actions by their scores.
    ///
    /// A first pass over eight lanes finds a bound that at least four actions reach; only those are ranked one by one.
    ///
    /// - `scores`: of actions 0, 1 and so on; padding beyond `num_actions` in the last group is overwritten.
    #[inline(always)]
    pub(crate) fn of_scores<F: Lanes>(scores: &mut [[f32; LANES]], num_actions: usize) -> Self {
        let groups = &mut scores[..num_actions.div_ceil(LANES)];
        groups.as_flattened_mut()[num_actions..].fill(f32::NEG_INFINITY);
        let mut most = F::splat(f32::NEG_INFINITY);
        for group in &*groups {
            most = most.max(F::load(group));
        }
        let bound = fourth(&most.to_array());
        let mut keys = [key(f32::NEG_INFINITY, NO_ACTION); MAX_RANKED];
        for (first, groups) in groups.chunks(8).enumerate() {
            let mut candidates = 0u64;
            for (g, group) in groups.iter().enumerate() {
                candidates |= u64::from(!F::load(group).bits_lt(F::splat(bound))) << (LANES * g);
            }
            candidates &= u64::MAX >> 64usize.saturating_sub(num_actions - first * 64);
            while candidates != 0 {
                let at = candidates.trailing_zeros() as usize;
                candidates &= candidates - 1;
                let action = first * 64 + at;
                insert(&mut keys, key(groups.as_flattened()[at], action as u8));
            }
        }
        Self { scores: keys.map(score_of), actions: keys.map(|k| !(k as u8)) }
    }

    /// One of the actions at random, better ones with higher probability (Lee and Lee 2004, section 5).
    ///
    /// An action whose score is below the best one by `temperature` times the best score's magnitude is e times less
    /// likely than the best.
    ///
    /// - `temperature`: 0 always gives the best (>= 0).
    /// - `random`: a uniform random number from the caller (0 to 1).
    pub fn choose(&self, temperature: f32, random: f32) -> u8 {
        let unit = temperature * self.scores[0].abs();
        if unit.is_nan() || unit <= 0.0 {
            return self.actions[0];
        }
        let weights = self.scores.map(|s| maths::exp((s - self.scores[0]) / unit));
        let mut left = random * weights.iter().sum::<f32>();
        for (w, &action) in weights.iter().zip(&self.actions) {
            left -= w;
            if left < 0.0 && action != NO_ACTION {
                return action;
            }
        }
        self.actions[0]
    }
}

/// The fourth largest of eight.
#[inline(always)]
fn fourth(v: &[f32; LANES]) -> f32 {
    let (a, b) = (sorted(v[0], v[1], v[2], v[3]), sorted(v[4], v[5], v[6], v[7]));
    // If k of the four largest are in `a`, the others are in `b`: the fourth is where the two sorted lists cross.
    let (c, d) = (greatest(a[0], b[3]), greatest(a[1], b[2]));
    let (e, f) = (greatest(a[2], b[1]), greatest(a[3], b[0]));
    least(least(c, d), least(e, f))
}

/// Sorts four numbers in descending order.
#[inline(always)]
fn sorted(a: f32, b: f32, c: f32, d: f32) -> [f32; 4] {
    let (a, b) = (greatest(a, b), least(a, b));
    let (c, d) = (greatest(c, d), least(c, d));
    let (a, c) = (greatest(a, c), least(a, c));
    let (b, d) = (greatest(b, d), least(b, d));
    [a, greatest(b, c), least(b, c), d]
}

/// A key that is larger for a better score, and for equal scores larger for a lower action.
#[inline(always)]
fn key(score: f32, action: u8) -> u64 {
    // Adding zero turns -0.0 into 0.0: the two compare equal.
    let bits = (score + 0.0).to_bits();
    let ordered = bits ^ (((bits as i32 >> 31) as u32) | 1 << 31);
    u64::from(ordered) << 32 | u64::from(!action)
}

/// The score of a [`key`].
#[inline(always)]
fn score_of(key: u64) -> f32 {
    let ordered = (key >> 32) as u32;
    f32::from_bits(ordered ^ ((!((ordered as i32) >> 31)) as u32 | 1 << 31))
}

/// Inserts a key into the descending list and drops the smallest. Branch-free, since the position is unpredictable.
#[inline(always)]
fn insert(keys: &mut [u64; MAX_RANKED], mut key: u64) {
    for k in keys {
        (*k, key) = ((*k).max(key), (*k).min(key));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use throng_base::simd::{ArrayLanes, LaneWork, dispatch};

    struct Rank<'a>(&'a [f32]);

    impl LaneWork for Rank<'_> {
        type Output = RankedActions;

        fn run<F: Lanes>(self) -> RankedActions {
            let mut groups = [[0.0; LANES]; 32];
            groups.as_flattened_mut()[..self.0.len()].copy_from_slice(self.0);
            RankedActions::of_scores::<F>(&mut groups, self.0.len())
        }
    }

    proptest! {
        #[test]
        fn ranking_equals_a_stable_sort(scores in proptest::collection::vec(-6i8..60, 1..256)) {
            let floats: Vec<f32> = scores.iter().map(|&s| f32::from(s) * 0.37).collect();
            let ranked = dispatch(Rank(&floats));
            prop_assert_eq!(ranked, Rank(&floats).run::<ArrayLanes>());
            for k in 0..MAX_RANKED.min(scores.len()) {
                prop_assert_eq!(ranked.scores[k], floats[usize::from(ranked.actions[k])]);
            }
            prop_assert!(ranked.scores[scores.len().min(MAX_RANKED)..].iter().all(|&s| s == f32::NEG_INFINITY));
            let mut order: Vec<usize> = (0..scores.len()).collect();
            order.sort_by_key(|&i| -scores[i]);
            for k in 0..MAX_RANKED {
                let expected = order.get(k).map_or(NO_ACTION, |&i| i as u8);
                prop_assert_eq!(ranked.actions[k], expected);
            }
        }
    }

    #[test]
    fn choice_follows_the_temperature() {
        let ranked = RankedActions { scores: [1.0, 0.9, 0.5, f32::NEG_INFINITY], actions: [7, 3, 5, NO_ACTION] };
        assert_eq!(ranked.choose(0.0, 0.999), 7);
        let share = |t: f32, action: u8| (0..1000).filter(|&i| ranked.choose(t, i as f32 / 1000.0) == action).count();
        let expected = 1.0 / (1.0 + (-1.0f64).exp() + (-5.0f64).exp());
        assert!((share(0.1, 7) as f64 / 1000.0 - expected).abs() < 2e-3);
        assert!(share(1e6, 5).abs_diff(333) <= 2 && share(1e6, NO_ACTION) == 0);
        assert_eq!(RankedActions::NONE.choose(1.0, 0.5), NO_ACTION);
    }
}
