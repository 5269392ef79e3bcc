//! The list of the ways out of a frame.

use super::outgoing::{Outgoing, displacement_texts};
use crate::command::Command;
use crate::document::Bundle;
use crate::panels::paint::{Cell, Click, Column, Table, time_text};
use eframe::egui::{RichText, Ui};

const COLUMNS: [Column<'static>; 6] = [
    Column::text("Leads to", "Clip, and the frames of it that are played", 96.0, 1.0),
    Column::number("Ahead", "How far it goes ahead, as seen from its start", 48.0),
    Column::number("Aside", "How far it goes to the side, as seen from its start", 74.0).spare(1),
    Column::number("Turn", "How far it turns", 66.0).spare(1),
    Column::number("Lasts", "Duration", 52.0).spare(2),
    Column::number("Error", ERROR_HINT, 60.0),
];
const ERROR_HINT: &str = "How much the pose that is left and the one that follows differ; none where the clip goes on";

/// Shows the actions; a click shows where one leads.
///
/// - returns the segment that is pointed at.
pub fn show(
    ui: &mut Ui,
    bundle: &Bundle,
    out: Option<&Outgoing>,
    frame: u32,
    commands: &mut Vec<Command>,
) -> Option<u32> {
    let Some(out) = out else {
        ui.strong("Ways out");
        ui.label(
            RichText::new("No state of the motion graph follows in this clip: no character comes past here.").weak(),
        );
        return None;
    };
    let wait = out.from.frame.saturating_sub(frame);
    ui.horizontal_wrapped(|ui| {
        let n = out.ways.len();
        ui.strong(if n == 1 { "1 way out".to_owned() } else { format!("{n} ways out") });
        let standing = if out.from.standing { ", standing" } else { "" };
        let when = if wait == 0 { "here".to_owned() } else { format!("in {wait} frames") };
        let text = format!("of state {}{standing}, {when}", out.from.state);
        let response = ui.link(text).on_hover_text("Look at this state, and go to its frame");
        if response.clicked() {
            commands.push(Command::SelectState(Some(out.from.state)));
            commands.push(Command::ShowClip { clip: bundle.clip_of(row_of(bundle, out)), frame: out.from.frame });
        }
    });
    let table = Table { click: Click::Does("Go to"), ..Table::new("ways", &COLUMNS, out.ways.len()) };
    let response = table.show(ui, |row, column| {
        let way = &out.ways[row];
        match column {
            0 => {
                let name = bundle.clip_name(way.clip);
                Cell::new(format!("{name} {}–{}", way.start, way.start + way.num_frames)).ending()
            }
            1..=3 => {
                let texts = displacement_texts(way.displacement);
                Cell::new(texts.into_iter().nth(column - 1).unwrap_or_default())
            }
            4 => Cell::new(time_text(f64::from(way.num_frames) / f64::from(bundle.rate_hz()))),
            _ if way.goes_on => Cell::weak("goes on"),
            _ => Cell::new(format!("{:.2}", way.error)),
        }
    });
    if let Some(way) = response.chosen.and_then(|row| out.ways.get(row)) {
        commands.push(Command::ShowClip { clip: way.clip, frame: way.start });
    }
    response.hovered.and_then(|(row, _)| out.ways.get(row)).map(|w| w.segment)
}

fn row_of(bundle: &Bundle, out: &Outgoing) -> u32 {
    bundle.tables().graph().states[out.from.state as usize].frame
}
