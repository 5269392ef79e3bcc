//! The list of the actions from a frame: those of its state, or of the next state.

use super::timeline::TimelineInput;
use crate::bundle::OpenBundle;
use crate::command::{Commands, ViewerCommand};
use crate::panels::graph::list::show_actions;
use crate::panels::paint::TableSort;
use crate::panels::show_segment;
use crate::panels::words::counted;
use eframe::egui::{RichText, Ui};

/// Shows the actions; a click shows where one leads.
///
/// - `sort`: order, none until one was asked for.
/// - returns the segment that is pointed at.
pub fn show(
    ui: &mut Ui,
    bundle: &OpenBundle,
    scene: &TimelineInput<'_>,
    sort: &mut Option<TableSort>,
    commands: &mut Commands,
) -> Option<u32> {
    let Some(from) = scene.next_state else {
        ui.strong("Actions from here");
        ui.label(RichText::new("No state of the motion graph follows in this clip: no character passes here.").weak());
        return None;
    };
    let wait = from.frame.saturating_sub(scene.head);
    let graph = bundle.tables().graph();
    ui.horizontal_wrapped(|ui| {
        ui.strong(counted(graph.segments_of(from.state).len(), "action"));
        let standing = if from.standing { ", standing" } else { "" };
        let when = if wait == 0 { "here".to_owned() } else { format!("in {wait} frames") };
        let text = format!("of state {}{standing}, {when}", from.state);
        let response = ui.link(text).on_hover_text("Select this state, and go to its frame");
        if response.clicked() {
            commands.push(ViewerCommand::SelectState(Some(from.state)));
            let row = graph.states[from.state as usize].frame;
            commands.push(ViewerCommand::ShowClip { clip: bundle.clip_of(row), frame: from.frame });
        }
    });
    let touched = show_actions(ui, bundle, from.state, "Go to", sort);
    commands.extend(touched.chosen.map(|segment| show_segment(bundle, segment)));
    touched.hovered
}
