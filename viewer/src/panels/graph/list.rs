//! The list of a state's actions; a click plays one.

use super::State;
use super::links::{Link, outgoing};
use crate::command::Command;
use crate::document::Bundle;
use crate::model::Model;
use crate::panels::table::{self, Cell, Column};
use crate::panels::words;
use crate::run::Input;
use eframe::egui::{RichText, ScrollArea, Ui};
use std::cmp::Ordering;
use throng_runtime::Planar;

/// The columns.
const COLUMNS: &[Column] = &[
    Column { title: "plays", hint: "Clip and frames of the segment", width: 150.0, is_number: false, keeps_end: true },
    Column { title: "s", hint: "Duration [s]", width: 34.0, is_number: true, keeps_end: false },
    Column {
        title: "leads",
        hint: "Displacement and turn, as seen from the character",
        width: 190.0,
        is_number: false,
        keeps_end: false,
    },
    Column {
        title: "error",
        hint: "How much frames differ at the transition [rad]; 0 where the clip goes on",
        width: 44.0,
        is_number: true,
        keeps_end: false,
    },
    Column { title: "to", hint: "State it leads to", width: 40.0, is_number: true, keeps_end: false },
];

/// Width of the list. [Unit: points]
pub fn width() -> f32 {
    table::width(COLUMNS) + 16.0
}

/// Shows the actions of a state; notes the segment under the pointer.
pub fn show(ui: &mut Ui, model: &Model, bundle: &Bundle, state: u32, own: &mut State, commands: &mut Vec<Command>) {
    let graph = bundle.tables().graph();
    let Some(record) = graph.states.get(state as usize) else { return };
    let clip = bundle.clip_of(record.frame);
    let frame = record.frame - bundle.tables().clips()[clip].first_frame;
    let followed = model.selection.state.is_none();
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("State {state}")).strong());
        let kind = if record.standing != 0 { ", standing" } else { "" };
        ui.label(format!("{} {frame}{kind}", bundle.clip_name(clip)));
        if ui.small_button("show").on_hover_text("Show this frame in the 3-D view").clicked() {
            commands.push(Command::ShowClip { clip, frame });
        }
    });
    let incoming = own.drawn.as_ref().map_or(0, |d| d.links.leading_to(state).len());
    let outgoing_count = graph.segments_of(state).len();
    ui.label(
        RichText::new(format!(
            "{outgoing_count} actions, {incoming} lead here{}",
            if followed { "; follows the selected character" } else { "" }
        ))
        .weak(),
    );
    let player = model.document.crowd().and(model.selection.character);
    match player {
        Some(c) => ui.label(RichText::new(format!("Click an action: character {c} plays it.")).weak()),
        None => ui.label(RichText::new("No character is selected: a click shows the motion instead.").weak()),
    };
    let rows = sorted(bundle, state, own);
    ScrollArea::both().id_salt("actions").auto_shrink([false, false]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        table::header(ui, COLUMNS, Some(&mut own.order));
        for link in &rows {
            show_action(ui, bundle, link, player, own, commands);
        }
    });
}

fn show_action(
    ui: &mut Ui,
    bundle: &Bundle,
    link: &Link,
    player: Option<usize>,
    own: &mut State,
    commands: &mut Vec<Command>,
) {
    let segment = bundle.tables().graph().segments[link.segment as usize];
    let plays = bundle.describe_segment(link.segment);
    let cells = [
        Cell::text(plays.as_str()),
        Cell::text(format!("{:.2}", segment.num_frames as f32 / bundle.rate_hz())),
        Cell::text(words::way(segment.displacement())),
        Cell::text(format!("{:.3}", link.error)),
        Cell::text(segment.end.to_string()),
    ];
    let response = table::row(ui, COLUMNS, &format!("Play {plays}"), own.marked == Some(link.segment), &cells);
    if response.hovered() {
        own.hovered_action = Some(link.segment);
    }
    if response.clicked() {
        let first = bundle.tables().clips()[segment.clip as usize].first_frame;
        commands.push(match player {
            Some(character) => Command::Input(Input::Play { character, segment: link.segment }),
            None => Command::ShowClip { clip: segment.clip as usize, frame: segment.start - first },
        });
    }
    response.on_hover_text(format!("{plays}, {} frames, leads to state {}", segment.num_frames, segment.end));
}

/// A state's actions in the order asked for.
fn sorted(bundle: &Bundle, state: u32, own: &State) -> Vec<Link> {
    let graph = bundle.tables().graph();
    let mut links: Vec<Link> = outgoing(&graph, state).collect();
    let of = |l: &Link| &graph.segments[l.segment as usize];
    let distance = |l: &Link| {
        let Planar { x, z, .. } = of(l).displacement();
        x.hypot(z)
    };
    let compare = |a: &Link, b: &Link| -> Ordering {
        match own.order.column {
            0 => (of(a).clip, of(a).start).cmp(&(of(b).clip, of(b).start)),
            1 => of(a).num_frames.cmp(&of(b).num_frames),
            2 => distance(a).total_cmp(&distance(b)),
            3 => a.error.total_cmp(&b.error),
            _ => of(a).end.cmp(&of(b).end),
        }
    };
    links.sort_by(|a, b| if own.order.descending { compare(b, a) } else { compare(a, b) });
    links
}
