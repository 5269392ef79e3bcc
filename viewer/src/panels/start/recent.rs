//! What was opened last.

use super::heading;
use crate::command::Command;
use crate::model::name_of;
use crate::panels::words::all;
use crate::theme::Palette;
use eframe::egui::{Align, Button, Label, Layout, Link, RichText, Ui};
use std::path::PathBuf;

/// Shows the list.
///
/// - `entries`: the files of each, and whether all of them are there.
pub fn show(ui: &mut Ui, entries: &[(Vec<PathBuf>, bool)], commands: &mut Vec<Command>) {
    heading(ui, "Opened last");
    if entries.is_empty() {
        ui.weak("Nothing yet.");
    }
    for (paths, is_there) in entries {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let remove = ui.add(Button::new("✖").small()).on_hover_text("Take it off this list");
            if remove.clicked() {
                commands.push(Command::Forget(paths.clone()));
            }
            if !is_there {
                ui.colored_label(Palette::of(ui.visuals()).warning, "missing");
            }
            ui.with_layout(Layout::top_down(Align::Min), |ui| entry(ui, paths, *is_there, commands));
        });
        ui.add_space(4.0);
    }
}

fn entry(ui: &mut Ui, paths: &[PathBuf], is_there: bool, commands: &mut Vec<Command>) {
    ui.spacing_mut().item_spacing.y = 1.0;
    let more = if paths.len() > 1 { format!(" and {} more", paths.len() - 1) } else { String::new() };
    let name = RichText::new(format!("{}{more}", name_of(paths))).size(14.0);
    if ui.add_enabled(is_there, Link::new(name)).on_hover_text(all(paths)).clicked() {
        commands.push(Command::Open(paths.to_vec()));
    }
    let folder = paths.first().and_then(|p| p.parent()).map_or_else(String::new, |p| p.display().to_string());
    ui.add(Label::new(RichText::new(folder).weak().small()).truncate());
}
