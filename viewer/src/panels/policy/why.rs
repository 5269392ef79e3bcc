//! "Why this action?": the candidates of a choice with their scores.

use super::{State, story};
use crate::command::Command;
use crate::document::Bundle;
use crate::model::Model;
use crate::panels::table::{self, Cell, Column};
use crate::panels::{colour, words};
use crate::run::{Candidate, Run, Why};
use eframe::egui::{DragValue, ScrollArea, Ui};

/// The columns that are always there.
const COLUMNS: [Column; 7] = [
    Column { title: "#", hint: "Place by score", width: 18.0, is_number: true, keeps_end: false },
    Column { title: "plays", hint: "Clip and frames of the segment", width: 112.0, is_number: false, keeps_end: true },
    Column {
        title: "score",
        hint: "Reward and discounted value of where it leads",
        width: 56.0,
        is_number: true,
        keeps_end: false,
    },
    Column { title: "leads", hint: "Displacement and turn", width: 104.0, is_number: false, keeps_end: false },
    Column { title: "s", hint: "Duration [s]", width: 30.0, is_number: true, keeps_end: false },
    Column {
        title: "gap",
        hint: "How far its score lies below the best",
        width: 48.0,
        is_number: true,
        keeps_end: false,
    },
    Column { title: "chance", hint: "How likely it was to be taken", width: 46.0, is_number: true, keeps_end: false },
];

/// Shows the choice of the selected character.
pub fn show(ui: &mut Ui, model: &Model, own: &mut State, why: Option<&Why>, commands: &mut Vec<Command>) {
    ui.strong("Why this action?");
    let Some((bundle, run)) = model.document.crowd() else {
        ui.weak("This bundle has no run.");
        return;
    };
    let Some(character) = model.selection.character else {
        ui.horizontal_wrapped(|ui| {
            ui.label("Click a character in the 3-D view, or");
            if ui.small_button("select character 0").clicked() {
                commands.push(Command::SelectCharacter(Some(0)));
            }
        });
        return;
    };
    let Some(why) = why else {
        ui.label(format!(
            "Character {character} plays what it was told to; it chooses for itself again when that is over."
        ));
        return;
    };
    ui.label(story::situation(why, bundle, character, run.now()));
    ui.label(story::decision(why, bundle, run.config()));
    behaviours(ui, bundle, why);
    let most = why.candidates.len();
    ui.horizontal(|ui| {
        let label = ui.label("Best");
        ui.add(DragValue::new(&mut own.shown).range(1..=most)).labelled_by(label.id);
        ui.label(format!("of {most} candidates"));
        let picked = own.picked.and_then(|s| why.candidates.iter().find(|c| c.segment == s));
        if let Some(c) = picked.or(why.candidates.get(why.chosen))
            && ui.button("Show motion").on_hover_text(bundle.describe_segment(c.segment)).clicked()
        {
            commands.push(show_motion(bundle, c.segment));
        }
    });
    candidates(ui, bundle, run, why, own);
}

fn behaviours(ui: &mut Ui, bundle: &Bundle, why: &Why) {
    if why.behaviours.len() < 2 {
        return;
    }
    for b in &why.behaviours {
        let name = name(bundle, b.policy);
        ui.weak(format!("{name}: weight {:.2}, value of the state {}", b.weight, colour::number(b.value)));
    }
}

fn candidates(ui: &mut Ui, bundle: &Bundle, run: &Run, why: &Why, own: &mut State) {
    let by_each = if why.behaviours.len() > 1 { why.behaviours.len() } else { 0 };
    let mut columns = COLUMNS.to_vec();
    let each = Column { title: "by", hint: "", width: 56.0, is_number: true, keeps_end: false };
    columns.resize(COLUMNS.len() + by_each, each);
    let chances = story::chances(why, run.config());
    let range = [why.candidates.last().map_or(0.0, |c| c.score), why.candidates[0].score];
    ScrollArea::horizontal().id_salt("candidates").show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        table::header(ui, &columns, None);
        for (rank, c) in why.candidates.iter().enumerate().take(own.shown) {
            let cells = cells(bundle, why, rank, c, chances[rank], range);
            let plays = bundle.describe_segment(c.segment);
            let response = table::row(ui, &columns, &format!("Candidate {plays}"), rank == why.chosen, &cells);
            if response.hovered() {
                own.hovered = Some(c.segment);
            }
            if response.clicked() {
                own.picked = if own.picked == Some(c.segment) { None } else { Some(c.segment) };
            }
            response.on_hover_ui(|ui| {
                ui.strong(plays);
                ui.label(words::way(c.displacement));
                for (b, score) in why.behaviours.iter().zip(&c.by_behaviour) {
                    ui.label(format!("{}: {score:.4}", name(bundle, b.policy)));
                }
                ui.weak("A click keeps its arrow on the map.");
            });
        }
    });
}

fn cells(bundle: &Bundle, why: &Why, rank: usize, c: &Candidate, chance: f32, range: [f32; 2]) -> Vec<Cell> {
    let frames = bundle.tables().graph().segments[c.segment as usize].num_frames;
    let chance = if chance > 0.0 { format!("{:.0} %", 100.0 * chance) } else { "–".into() };
    let gap = why.candidates[0].score - c.score;
    let mut cells = vec![
        Cell::text((rank + 1).to_string()),
        Cell::text(bundle.describe_segment(c.segment)),
        Cell { text: format!("{:.3}", c.score), bar: Some(colour::ratio(c.score, range)) },
        Cell::text(words::way(c.displacement)),
        Cell::text(format!("{:.2}", frames as f32 / bundle.rate_hz())),
        Cell::text(format!("{gap:.3}")),
        Cell::text(chance),
    ];
    if why.behaviours.len() > 1 {
        cells.extend(c.by_behaviour.iter().map(|s| Cell::text(format!("{s:.3}"))));
    }
    cells
}

/// Name of a behaviour.
pub fn name(bundle: &Bundle, policy: usize) -> &str {
    bundle.tables().meta().behaviours.get(policy).map_or("behaviour", String::as_str)
}

/// Shows a segment from its first frame on.
fn show_motion(bundle: &Bundle, segment: u32) -> Command {
    let s = bundle.tables().graph().segments[segment as usize];
    let clip = s.clip as usize;
    Command::ShowClip { clip, frame: s.start - bundle.tables().clips()[clip].first_frame }
}
