//! Recently opened files.

use super::heading;
use crate::command::{Commands, ViewerCommand};
use crate::model::name_of;
use crate::panels::paint::PanelWidget;
use crate::panels::words::path_list;
use crate::theme::ThemePalette;
use eframe::egui::{Align, Button, Label, Layout, Link, RichText, Ui, vec2};
use std::path::PathBuf;

/// Height of an entry (points).
const ROW: f32 = 34.0;

/// Shows the list.
///
/// - `entries`: the files of each, and whether all of them are there.
pub fn show(ui: &mut Ui, entries: &[(Vec<PathBuf>, bool)], commands: &mut Commands) {
    heading(ui, "Opened last");
    if entries.is_empty() {
        ui.weak("Nothing yet.");
    }
    for (paths, is_there) in entries {
        let size = vec2(ui.available_width(), ROW);
        ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Min), |ui| {
            let remove = ui.add(Button::new("✖").small()).on_hover_text("Take it off this list");
            remove.request(commands, ViewerCommand::Forget(paths.clone()));
            if !is_there {
                ui.colored_label(ThemePalette::for_visuals(ui.visuals()).warning, "missing");
            }
            ui.with_layout(Layout::top_down(Align::Min), |ui| entry(ui, paths, *is_there, commands));
        });
        ui.add_space(2.0);
    }
}

fn entry(ui: &mut Ui, paths: &[PathBuf], is_there: bool, commands: &mut Commands) {
    ui.spacing_mut().item_spacing.y = 1.0;
    let more = if paths.len() > 1 { format!(" and {} more", paths.len() - 1) } else { String::new() };
    let name = RichText::new(format!("{}{more}", name_of(paths))).size(14.0);
    let link = ui.add_enabled(is_there, Link::new(name)).on_hover_text(path_list(paths));
    link.request(commands, ViewerCommand::Open(paths.to_vec()));
    let folder = paths.first().and_then(|p| p.parent()).map_or_else(String::new, |p| p.display().to_string());
    ui.add(Label::new(RichText::new(folder).weak().size(11.5)).truncate());
}
