//! "Why this action?": the candidates of a choice with their scores.

use super::PolicyPanelState;
use crate::panels::paint::{PanelWidget, RowClick, RowTable, TableCell, TableColumn};
use crate::panels::{clip_frame, offer_first_character, show_segment, words};
use crate::run::{ActionCandidate, BehaviourScore, ChoiceReason, GoalSubject, PolicyChooser, STEP_HZ};
use crate::{bundle::OpenBundle, command::Commands, model::Model, theme::viridis};
use eframe::egui::{DragValue, Response, Ui};
use glam::Vec2;
use throng_core::policy::{MAX_RANKED, RegionRecord};

/// Columns for every choice. A panel of the usual width has room for the action and its score.
const COLUMNS: [TableColumn<'static>; 7] = [
    TableColumn::number("#", "Place by score", 26.0),
    TableColumn::text("plays", "Clip and frames of the segment", 122.0, 1.0),
    TableColumn::number("score", "Reward and discounted value of where it leads", 58.0),
    TableColumn::text("leads", "Displacement and turn", 124.0, 0.6).spare(4),
    TableColumn::number("s", "Duration [s]", 40.0).spare(2),
    TableColumn::number("gap", "How far its score lies below the best", 52.0).spare(1),
    TableColumn::number("chance", "How likely it was to be taken", 56.0),
];

/// Shows the choice of the selected character.
pub fn show(
    ui: &mut Ui,
    model: &Model,
    own: &mut PolicyPanelState,
    chooser: Option<&PolicyChooser<'_>>,
    why: Option<&ChoiceReason>,
    commands: &mut Commands,
) {
    ui.strong("Why this action?");
    let Some(character) = model.selection.character else {
        return offer_first_character(ui, "Click a character in the 3-D view, or", true, commands);
    };
    let Some(chooser) = chooser else {
        return drop(ui.weak(format!("Character {character} does not choose by the policies of this bundle.")));
    };
    let Some(why) = why else {
        let text = "plays what it was ordered to; it chooses for itself again when that is over.";
        return drop(ui.label(format!("Character {character} {text}")));
    };
    let bundle = chooser.bundle;
    ui.label(situation(why, bundle, character, chooser.now));
    ui.label(decision(why, chooser));
    behaviours(ui, bundle, why);
    let most = why.candidates.len();
    ui.horizontal(|ui| {
        let label = ui.label("Best");
        // A choice of few candidates does not change how many are listed of the next one.
        let mut shown = own.shown.min(most);
        if ui.add(DragValue::new(&mut shown).range(1..=most)).labelled_by(label.id).changed() {
            own.shown = shown;
        }
        ui.label(format!("of {most} candidates"));
        let picked = own.picked.and_then(|s| why.candidates.iter().find(|c| c.segment == s));
        if let Some(c) = picked.or(why.candidates.get(why.chosen)) {
            let show = ui.button("Show motion").on_hover_text(bundle.describe_segment(c.segment));
            show.request(commands, show_segment(bundle, c.segment));
        }
    });
    candidates(ui, chooser, why, own);
}

fn behaviours(ui: &mut Ui, bundle: &OpenBundle, why: &ChoiceReason) {
    if why.behaviours.len() < 2 && why.behaviours.iter().all(|b| b.is_active) {
        return;
    }
    for b in &why.behaviours {
        let name = behaviour_name(bundle, b.policy);
        if b.is_active {
            ui.weak(format!("{name}: weight {:.2}, value of the state {}", b.weight, words::number(b.value)));
        } else if let Some(policy) = bundle.motion_set.policy(b.policy) {
            ui.label(format!("{name}: not active, it does not count: {}", inactivity(policy.region(), b)));
        }
    }
}

fn candidates(ui: &mut Ui, chooser: &PolicyChooser<'_>, why: &ChoiceReason, own: &mut PolicyPanelState) {
    let bundle = chooser.bundle;
    let mut columns: Vec<TableColumn<'_>> = COLUMNS.to_vec();
    if why.behaviours.len() > 1 {
        let by_each = why.behaviours.iter().map(|b| behaviour_name(bundle, b.policy));
        columns.extend(by_each.map(|n| TableColumn::number(n, "Score by this behaviour alone", 60.0).spare(3)));
    }
    let chances = chances(why, chooser);
    let shown = own.shown.min(why.candidates.len());
    let table = RowTable {
        named_by: 1,
        click: RowClick::Does("Candidate"),
        selected: Some(why.chosen),
        most_rows: Some(shown),
        ..RowTable::new("candidates", &columns, shown)
    };
    let response = table.show(ui, |row, column| cell(bundle, why, row, column, &chances));
    if let Some(c) = response.chosen.and_then(|row| why.candidates.get(row)) {
        own.picked = if own.picked == Some(c.segment) { None } else { Some(c.segment) };
    }
    if let Some((row, response)) = response.hovered {
        own.hovered = Some(why.candidates[row].segment);
        show_tooltip(bundle, why, response, &why.candidates[row]);
    }
}

fn cell(bundle: &OpenBundle, why: &ChoiceReason, rank: usize, column: usize, chances: &[f32]) -> TableCell {
    let c = &why.candidates[rank];
    let best = why.candidates[0].score;
    match column {
        0 => TableCell::new((rank + 1).to_string()),
        1 => TableCell::new(bundle.describe_segment(c.segment)).ending(),
        2 => {
            let least = why.candidates.last().map_or(0.0, |c| c.score);
            TableCell::new(format!("{:.3}", c.score)).bar(viridis::ratio(c.score, [least, best]))
        }
        3 => TableCell::new(words::displacement(c.displacement)),
        4 => TableCell::new(format!("{:.2}", seconds(bundle, c))),
        5 => TableCell::new(format!("{:.3}", best - c.score)),
        6 if chances[rank] > 0.0 => TableCell::new(format!("{:.0} %", 100.0 * chances[rank])),
        6 => TableCell::weak("–"),
        _ => {
            let score = c.by_behaviour.get(column - COLUMNS.len());
            score.map_or_else(TableCell::default, |s| TableCell::new(format!("{s:.3}")))
        }
    }
}

/// Shows a tooltip with details that may not fit the row.
fn show_tooltip(bundle: &OpenBundle, why: &ChoiceReason, response: Response, c: &ActionCandidate) {
    response.on_hover_ui(|ui| {
        ui.strong(bundle.describe_segment(c.segment));
        ui.label(format!("{:.2} s: {}", seconds(bundle, c), words::displacement(c.displacement)));
        for (b, score) in why.behaviours.iter().zip(&c.by_behaviour) {
            ui.label(format!("{}: {score:.4}", behaviour_name(bundle, b.policy)));
        }
        ui.weak("A click keeps its arrow on the map.");
    });
}

/// Duration of a candidate's segment (s).
fn seconds(bundle: &OpenBundle, c: &ActionCandidate) -> f32 {
    bundle.tables().graph().segments[c.segment as usize].num_frames as f32 / bundle.rate_hz()
}

/// Name of a behaviour.
pub fn behaviour_name(bundle: &OpenBundle, policy: usize) -> &str {
    bundle.tables().meta().behaviours.get(policy).map_or("behaviour", String::as_str)
}

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
    let chance = chances(why, chooser)[why.chosen];
    let percent = 100.0 * chance;
    match why.chosen {
        0 if chance > 0.999 => format!("Of {n} actions it took the best, {action}."),
        0 => format!("Of {n} actions it took the best (its chance was {percent:.0} %), {action}."),
        c => format!("Of {n} actions it took number {} by score (its chance was {percent:.0} %), {action}.", c + 1),
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
