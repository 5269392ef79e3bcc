//! Probability of each of the ranked actions to be taken.

use throng_core::policy::MAX_RANKED;

/// Probability of each score, the best first, to be taken by [`RankedActions::choose`] with uniform random numbers.
/// Beyond the first [`MAX_RANKED`] it is 0.
///
/// [`RankedActions::choose`]: throng_core::policy::RankedActions::choose
pub fn choice_chances(scores: &[f32], temperature: f32) -> Vec<f32> {
    let Some(&best) = scores.first() else { return Vec::new() };
    let unit = temperature * best.abs();
    let weight = |(rank, &score): (usize, &f32)| match rank {
        0 => 1.0,
        r if r < MAX_RANKED && unit > 0.0 => ((score - best) / unit).exp(),
        _ => 0.0,
    };
    let weights: Vec<f32> = scores.iter().enumerate().map(weight).collect();
    let sum: f32 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::policy::{NO_ACTION, RankedActions};

    #[test]
    fn chances_are_how_often_each_action_is_chosen() {
        let cases: [&[f32]; 4] = [&[1.0, 0.9, 0.5, 0.4, 0.39], &[0.2, 0.19], &[-0.5, -0.6, -0.7], &[0.0, -1.0]];
        for scores in cases {
            let mut ranked = RankedActions::NONE;
            for (i, &score) in scores.iter().take(MAX_RANKED).enumerate() {
                (ranked.scores[i], ranked.actions[i]) = (score, i as u8);
            }
            for temperature in [0.0, 0.05, 0.3, 5.0] {
                let chances = choice_chances(scores, temperature);
                assert!((chances.iter().sum::<f32>() - 1.0).abs() < 1e-6);
                let mut counts = vec![0; scores.len()];
                const DRAWS: usize = 20_000;
                for i in 0..DRAWS {
                    let action = ranked.choose(temperature, (i as f32 + 0.5) / DRAWS as f32);
                    assert_ne!(action, NO_ACTION);
                    counts[usize::from(action)] += 1;
                }
                for (chance, count) in chances.iter().zip(counts) {
                    assert!((chance - count as f32 / DRAWS as f32).abs() < 1e-3, "{scores:?} {temperature}");
                }
            }
        }
    }

    #[test]
    fn without_chance_the_best_is_taken() {
        assert_eq!(choice_chances(&[0.3, 0.3, 0.1], 0.0), [1.0, 0.0, 0.0]);
        assert!(choice_chances(&[], 1.0).is_empty());
    }
}
