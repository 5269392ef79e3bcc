//! The list of the actions from a frame.

use super::outgoing::displacement_texts;
use super::timeline::TimelineInput;
use crate::bundle::OpenBundle;
use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::{RowClick, RowTable, TableCell, TableColumn, time_text};
use crate::panels::words::counted;
use eframe::egui::{RichText, Ui};

const COLUMNS: [TableColumn<'static>; 6] = [
    TableColumn::text("Leads to", "Clip, and the frames of it that are played", 96.0, 1.0),
    TableColumn::number("Ahead", "How far it goes ahead, as seen from its start", 48.0),
    TableColumn::number("Aside", "How far it goes to the side, as seen from its start", 74.0).spare(1),
    TableColumn::number("Turn", "How far it turns", 66.0).spare(1),
    TableColumn::number("Lasts", "Duration", 52.0).spare(2),
    TableColumn::number("Error", ERROR_HINT, 60.0),
];
const ERROR_HINT: &str = "Difference of the poses before and after; none if the clip continues";

/// Shows the actions; a click shows where one leads.
///
/// - returns the segment that is pointed at.
pub fn show(ui: &mut Ui, bundle: &OpenBundle, scene: &TimelineInput<'_>, commands: &mut Commands) -> Option<u32> {
    let Some(out) = scene.outgoing else {
        ui.strong("Actions from here");
        ui.label(RichText::new("No state of the motion graph follows in this clip: no character passes here.").weak());
        return None;
    };
    let wait = out.from.frame.saturating_sub(scene.head);
    ui.horizontal_wrapped(|ui| {
        ui.strong(counted(out.actions.len(), "action"));
        let standing = if out.from.standing { ", standing" } else { "" };
        let when = if wait == 0 { "here".to_owned() } else { format!("in {wait} frames") };
        let text = format!("of state {}{standing}, {when}", out.from.state);
        let response = ui.link(text).on_hover_text("Select this state, and go to its frame");
        if response.clicked() {
            commands.push(ViewerCommand::SelectState(Some(out.from.state)));
            let row = bundle.tables().graph().states[out.from.state as usize].frame;
            commands.push(ViewerCommand::ShowClip { clip: bundle.clip_of(row), frame: out.from.frame });
        }
    });
    let table = RowTable { click: RowClick::Does("Go to"), ..RowTable::new("actions", &COLUMNS, out.actions.len()) };
    let response = table.show(ui, |row, column| {
        let action = &out.actions[row];
        match column {
            0 => {
                let name = bundle.clip_name(action.clip);
                TableCell::new(format!("{name} {}–{}", action.start, action.start + action.num_frames)).ending()
            }
            1..=3 => TableCell::new(displacement_texts(action.displacement)[column - 1].as_str()),
            4 => TableCell::new(time_text(f64::from(action.num_frames) / f64::from(bundle.rate_hz()))),
            _ if action.continues => TableCell::weak("continues"),
            _ => TableCell::new(format!("{:.2}", action.error)),
        }
    });
    let chosen = response.chosen.and_then(|row| out.actions.get(row));
    commands.extend(chosen.map(|action| ViewerCommand::ShowClip { clip: action.clip, frame: action.start }));
    response.hovered.and_then(|(row, _)| out.actions.get(row)).map(|w| w.segment)
}
