//! The few best actions of a look-ahead, and the choice among them.

use super::table::NO_ACTION;

/// Actions a look-ahead ranks.
pub const MAX_RANKED: usize = 4;

/// The best actions of a state for a target, best first; of equal scores the lower index comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankedActions {
    /// Scores, descending; negative infinity where there are no more actions.
    pub scores: [f32; MAX_RANKED],
    /// Indices within the state's actions; [`NO_ACTION`] where there are no more.
    pub actions: [u8; MAX_RANKED],
}

impl RankedActions {
    /// No action yet.
    pub const NONE: Self = Self { scores: [f32::NEG_INFINITY; MAX_RANKED], actions: [NO_ACTION; MAX_RANKED] };

    /// The best action.
    pub fn best(&self) -> u8 {
        self.actions[0]
    }

    /// Takes an action in if it belongs to the best; actions come by ascending index.
    #[inline]
    pub fn insert(&mut self, action: u8, score: f32) {
        if score <= self.scores[MAX_RANKED - 1] {
            return;
        }
        let mut at = MAX_RANKED - 1;
        while at > 0 && score > self.scores[at - 1] {
            self.scores[at] = self.scores[at - 1];
            self.actions[at] = self.actions[at - 1];
            at -= 1;
        }
        self.scores[at] = score;
        self.actions[at] = action;
    }

    /// One of the actions at random: the better, the likelier (003 section 5).
    ///
    /// An action whose score is less than the best by `temperature` times the best score's size is e times less
    /// likely than the best one.
    ///
    /// - `temperature`: 0 always gives the best. [Limit: >= 0]
    /// - `random`: uniform, the caller's. [Limit: 0 to 1]
    pub fn choose(&self, temperature: f32, random: f32) -> u8 {
        let unit = temperature * self.scores[0].abs();
        if unit.is_nan() || unit <= 0.0 {
            return self.actions[0];
        }
        let weights = self.scores.map(|s| ((s - self.scores[0]) / unit).exp());
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ranks_as_a_stable_sort_does(scores in proptest::collection::vec(0i8..6, 1..40)) {
            let mut ranked = RankedActions::NONE;
            for (i, &s) in scores.iter().enumerate() {
                ranked.insert(i as u8, f32::from(s));
            }
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
