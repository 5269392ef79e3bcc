//! Why a character took its action, in plain words.

use crate::bundle::OpenBundle;
use crate::panels::{clip_frame, words};
use crate::run::{BehaviourScore, ChoiceReason, GoalSubject, PolicyChooser, STEP_HZ};
use glam::Vec2;
use throng_core::policy::{MAX_RANKED, RegionRecord};

/// Chances of the candidates (number of candidates).
pub fn chances(why: &ChoiceReason, chooser: &PolicyChooser<'_>) -> Vec<f32> {
    let scores: Vec<f32> = why.candidates.iter().map(|c| c.score).collect();
    choice_chances(&scores, chooser.temperature)
}

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

/// Text: when, where and towards which target the character chose.
pub fn situation(why: &ChoiceReason, bundle: &OpenBundle, character: usize, now: u32) -> String {
    let (clip, within) = clip_frame(bundle, bundle.tables().graph().states[why.state as usize].frame);
    let (at, ago) = (why.step as f32 / STEP_HZ, now.saturating_sub(why.step) as f32 / STEP_HZ);
    let place = words::place(Vec2::new(why.local_target.x, why.local_target.z));
    format!(
        "At {at:.2} s, {ago:.2} s ago, character {character} was in state {} ({}, frame {within}), its target {place}.",
        why.state,
        bundle.clip_name(clip),
    )
}

/// Why a behaviour was not active: by how its target missed the region, in words.
pub fn inactivity(region: &RegionRecord, b: &BehaviourScore) -> String {
    let t = b.target;
    let (is_threat, distance, angle) = (b.subject == GoalSubject::Threat, t.x.hypot(t.z), t.x.atan2(t.z));
    let outside = |v: f32, [low, high]: [f32; 2]| v < low || v > high;
    let within = |[low, high]: [f32; 2]| format!("{low:.2} to {high:.2}");
    if outside(t.y, region.height) {
        return match is_threat {
            true if t.y > 100.0 => "no blow was coming".into(),
            true => format!("the blow was {:.2} s away, it acts at {} s", t.y, within(region.height)),
            false => format!("the target was {:.2} m high, it acts at {} m", t.y, within(region.height)),
        };
    }
    let what = if is_threat { "the blow" } else { "the target" };
    if outside(distance, region.distance) {
        return format!("{what} was {distance:.2} m away, it acts at {} m", within(region.distance));
    }
    let degrees = region.angle.map(f32::to_degrees);
    format!("{what} was {}, it acts from {:.0}° to {:.0}°", words::direction(angle), degrees[0], degrees[1])
}

/// Text: the action taken, and the rule.
pub fn decision(why: &ChoiceReason, chooser: &PolicyChooser<'_>) -> String {
    let bundle = chooser.bundle;
    let Some(taken) = why.candidates.get(why.chosen) else { return String::new() };
    let action = format!("{}: {}", bundle.describe_segment(taken.segment), words::displacement(taken.displacement));
    let n = why.candidates.len();
    if why.behaviours.iter().all(|b| b.counted() == 0.0) {
        return format!("No behaviour counted, so all {n} actions were alike; it took {action}.");
    }
    let rank = words::ordinal(why.chosen + 1);
    let chance = chances(why, chooser)[why.chosen];
    let percent = 100.0 * chance;
    match why.chosen {
        0 if chance > 0.999 => format!("Of {n} actions it took the best, {action}."),
        0 => format!("Of {n} actions it took the best (its chance was {percent:.0} %), {action}."),
        _ => format!("Of {n} actions it took the {rank} best (at random; its chance was {percent:.0} %), {action}."),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::golden_run;
    use super::*;
    use crate::run::explain_choice;
    use glam::Vec3;
    use throng_core::policy::{NO_ACTION, RankedActions};

    #[test]
    fn the_reason_of_an_inactive_behaviour_is_named() {
        let region = RegionRecord { distance: [0.3, 1.2], angle: [-1.0, 1.0], height: [1.2, 1.7] };
        let why = |about, x, y, z| {
            let target = Vec3::new(x, y, z);
            inactivity(
                &region,
                &BehaviourScore { policy: 0, weight: 1.0, subject: about, target, is_active: false, value: 0.0 },
            )
        };
        assert_eq!(why(GoalSubject::Target, 0.0, 1.5, 2.0), "the target was 2.00 m away, it acts at 0.30 to 1.20 m");
        assert_eq!(why(GoalSubject::Target, 0.0, 1.9, 2.0), "the target was 1.90 m high, it acts at 1.20 to 1.70 m");
        assert_eq!(why(GoalSubject::Target, 0.9, 1.5, 0.0), "the target was 90° to the left, it acts from -57° to 57°");
        assert_eq!(why(GoalSubject::Threat, 0.0, 1e3, 0.0), "no blow was coming");
    }

    #[test]
    fn the_story_names_the_action_that_is_played() {
        for temperature in [0.0, 0.5] {
            let scene = golden_run(temperature);
            for c in 0..scene.choice.characters {
                let chooser = scene.chooser(c).unwrap();
                let why = explain_choice(&chooser).unwrap();
                let text = decision(&why, &chooser);
                let played = chooser.bundle.describe_segment(chooser.characters.segment(c).0);
                assert!(text.contains(&played), "{text}");
                assert!((chances(&why, &chooser).iter().sum::<f32>() - 1.0).abs() < 1e-5);
                let text = situation(&why, chooser.bundle, c, scene.run.head.shown_step());
                assert!(text.contains(&format!("state {} ", why.state)), "{text}");
            }
        }
    }

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
