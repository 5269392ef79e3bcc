//! The list of a state's actions; in the panel of the graph, a click plays one.

use super::GraphPanelState;
use super::links::{ActionLink, outgoing};
use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::{PanelWidget, RowClick, RowTable, TableCell, TableColumn, TableSort, least_width};
use crate::panels::{clip_frame, show_segment, words};
use crate::{bundle::OpenBundle, model::Model, run::RunInput};
use eframe::egui::{Response, Ui};
use std::cmp::Ordering;
use throng_core::Planar;

/// The columns.
const COLUMNS: [TableColumn<'static>; 5] = [
    TableColumn::text("plays", "Clip and frames of the segment", 165.0, 1.0),
    TableColumn::number("s", "Duration [s]", 44.0).spare(1),
    TableColumn::text("leads", "Displacement and turn, as seen from the character", 200.0, 0.5).spare(2),
    TableColumn::number("error", "Difference of the frames at the transition [rad]; 0 if the clip continues", 56.0),
    TableColumn::number("to", "State it leads to", 46.0).spare(3),
];

/// The order of the rows at first: by error, so that an action that continues the clip comes first.
pub const BY_ERROR: TableSort = TableSort { column: 3, descending: false };

/// Width of the list (points).
pub fn width() -> f32 {
    least_width(&COLUMNS) + 28.0
}

/// Shows the actions of a state; notes the segment under the pointer.
pub fn show(ui: &mut Ui, model: &Model, state: u32, own: &mut GraphPanelState, commands: &mut Commands) {
    let Some(bundle) = model.document.bundle() else { return };
    let graph = bundle.tables().graph();
    let Some(record) = graph.states.get(state as usize) else { return };
    let (clip, frame) = clip_frame(bundle, record.frame);
    ui.horizontal(|ui| {
        ui.strong(format!("State {state}"));
        let kind = if record.standing != 0 { ", standing" } else { "" };
        ui.label(format!("{} {frame}{kind}", bundle.clip_name(clip)));
        let show = ui.small_button("show").on_hover_text("Show this frame in the 3-D view");
        show.request(commands, ViewerCommand::ShowClip { clip, frame });
    });
    let incoming = own.drawn.as_ref().map_or(0, |d| d.links.incoming[state as usize].len());
    let follows = if model.selection.state.is_none() { "; follows the selected character" } else { "" };
    ui.weak(format!("{} actions, {incoming} lead here{follows}", graph.segments_of(state).len()));
    let player = model.selection.character.filter(|&c| model.document.chooser(c).is_some());
    match player {
        Some(c) => ui.weak(format!("Click an action: character {c} plays it.")),
        None => ui.weak("No character is selected: a click shows the motion instead."),
    };
    let touched = show_actions(ui, bundle, state, "Play", &mut own.sort);
    own.hovered_action = touched.hovered.or(own.hovered_action);
    if let Some(segment) = touched.chosen {
        // Without a character, the motion is shown instead.
        let play = |character| ViewerCommand::Input(RunInput::Play { character, segment });
        commands.push(player.map_or_else(|| show_segment(bundle, segment), play));
    }
}

/// Segments of the rows that the pointer touches.
#[derive(Clone, Copy, Debug, Default)]
pub struct TouchedActions {
    /// Segment that was clicked.
    pub chosen: Option<u32>,
    /// Segment that is pointed at.
    pub hovered: Option<u32>,
}

/// Shows a table of the actions of a state.
///
/// - `click`: effect of a click, for people who hear the panel; `sort`: order, none until one was asked for.
pub fn show_actions(
    ui: &mut Ui,
    bundle: &OpenBundle,
    state: u32,
    click: &'static str,
    sort: &mut Option<TableSort>,
) -> TouchedActions {
    let order = sort.unwrap_or(BY_ERROR);
    let rows = sorted(bundle, state, order);
    let (click, order) = (RowClick::Does(click), Some(order));
    let table = RowTable { click, sort: order, ..RowTable::new("actions", &COLUMNS, rows.len()) };
    let response = table.show(ui, |row, column| cell(bundle, &rows[row], column));
    *sort = response.sort.or(*sort);
    let chosen = response.chosen.and_then(|row| rows.get(row)).map(|link| link.segment);
    let hovered = response.hovered.map(|(row, response)| {
        show_tooltip(bundle, response, &rows[row]);
        rows[row].segment
    });
    TouchedActions { chosen, hovered }
}

fn cell(bundle: &OpenBundle, link: &ActionLink, column: usize) -> TableCell {
    let segment = bundle.tables().graph().segments[link.segment as usize];
    match column {
        0 => TableCell::new(bundle.describe_segment(link.segment)).ending(),
        1 => TableCell::new(format!("{:.2}", segment.num_frames as f32 / bundle.rate_hz())),
        2 => TableCell::new(words::displacement(segment.displacement())),
        3 => TableCell::new(format!("{:.3}", link.error)),
        _ => TableCell::new(segment.end.to_string()),
    }
}

/// Shows a tooltip with details that may not fit the row.
fn show_tooltip(bundle: &OpenBundle, response: Response, link: &ActionLink) {
    let segment = bundle.tables().graph().segments[link.segment as usize];
    response.on_hover_ui(|ui| {
        ui.strong(bundle.describe_segment(link.segment));
        let (frames, leads) = (segment.num_frames, words::displacement(segment.displacement()));
        ui.label(format!("{:.2} s, {frames} frames: {leads}", frames as f32 / bundle.rate_hz()));
        ui.label(format!("error {:.3} rad, leads to state {}", link.error, segment.end));
    });
}

/// A state's actions in the order asked for.
pub fn sorted(bundle: &OpenBundle, state: u32, sort: TableSort) -> Vec<ActionLink> {
    let graph = bundle.tables().graph();
    let mut links: Vec<ActionLink> = outgoing(graph, state).collect();
    let of = |l: &ActionLink| &graph.segments[l.segment as usize];
    let distance = |l: &ActionLink| {
        let Planar { x, z, .. } = of(l).displacement();
        x.hypot(z)
    };
    let compare = |a: &ActionLink, b: &ActionLink| -> Ordering {
        match sort.column {
            0 => (of(a).clip, of(a).start).cmp(&(of(b).clip, of(b).start)),
            1 => of(a).num_frames.cmp(&of(b).num_frames),
            2 => distance(a).total_cmp(&distance(b)),
            3 => a.error.total_cmp(&b.error),
            _ => of(a).end.cmp(&of(b).end),
        }
    };
    links.sort_by(|a, b| sort.directed(compare(a, b)));
    links
}
