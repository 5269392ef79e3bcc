//! "Why this action?": the candidates of a choice with their scores.

use super::{PolicyPanelState, story};
use crate::bundle::OpenBundle;
use crate::command::Commands;
use crate::model::Model;
use crate::panels::paint::{PanelWidget, RowClick, RowTable, TableCell, TableColumn};
use crate::panels::{offer_first_character, show_segment, words};
use crate::run::{ActionCandidate, ChoiceReason, PolicyChooser};
use crate::theme::viridis;
use eframe::egui::{DragValue, Response, Ui};

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
        let text = "plays what it was told to; it chooses for itself again when that is over.";
        return drop(ui.label(format!("Character {character} {text}")));
    };
    let bundle = chooser.bundle;
    ui.label(story::situation(why, bundle, character, chooser.now));
    ui.label(story::decision(why, chooser));
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
            ui.label(format!("{name}: not active, it does not count: {}", story::inactivity(policy.region(), b)));
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
    let chances = story::chances(why, chooser);
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
