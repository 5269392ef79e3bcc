//! The start page: demonstrations, the user's own motion, recently opened files.

mod demos;

use super::{PanelStates, build};
use crate::command::{Commands, ViewerCommand};
use crate::model::{Model, name_of};
use crate::{document::path_list, panels::SystemDialog, panels::paint::PanelWidget, theme::ThemePalette};
use eframe::egui::{Align, Button, Frame, Label, Layout, Link, Margin, RichText, ScrollArea, Shape, Stroke, Ui, vec2};
use std::path::PathBuf;

/// Width of the page at most (points).
const MAX_WIDTH: f32 = 1140.0;
/// From this width on, demonstrations lie beside the rest (points).
const WIDE: f32 = 900.0;
/// Width of the column beside them (points).
const SIDE: f32 = 320.0;
/// Space at both sides of the page at least (points).
const MARGIN: f32 = 16.0;
/// Space between parts of the page (points).
const GAP: f32 = 20.0;
/// Interval between two checks of the files on the page (s).
const EVERY_S: f64 = 1.0;

/// State of the page.
#[derive(Clone, Default)]
pub struct StartPageState {
    demos: demos::DemosState,
    /// Recently opened entries, each with true if its files exist.
    recent: Vec<(Vec<PathBuf>, bool)>,
    /// When the files were looked at; none before that.
    looked_s: Option<f64>,
}

impl StartPageState {
    /// Checks at intervals which files exist.
    fn check_files(&mut self, now_s: f64, model: &Model) {
        let is_new = self.recent.len() != model.settings.opened.len();
        if !is_new && self.looked_s.is_some_and(|s| (s..s + EVERY_S).contains(&now_s)) {
            return;
        }
        self.looked_s = Some(now_s);
        self.demos.check_files();
        let is_there = |paths: &Vec<PathBuf>| (paths.clone(), paths.iter().all(|p| p.exists()));
        self.recent = model.settings.opened.iter().map(is_there).collect();
    }
}

/// Shows the page in all that is left of the window.
pub fn show(ui: &mut Ui, model: &Model, states: &mut PanelStates, commands: &mut Commands) {
    let now_s = ui.input(|i| i.time);
    states.start.check_files(now_s, model);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let room = ui.available_width();
        let width = (room - 2.0 * MARGIN).clamp(200.0, MAX_WIDTH);
        ui.horizontal_top(|ui| {
            ui.add_space((0.5 * (room - width)).floor().max(0.0));
            ui.vertical(|ui| {
                ui.set_width(width);
                page(ui, model, states, commands);
            });
        });
    });
}

fn page(ui: &mut Ui, model: &Model, states: &mut PanelStates, commands: &mut Commands) {
    ui.add_space(GAP);
    ui.label(RichText::new("Throng").size(32.0).strong());
    ui.add(Label::new(RichText::new("Motion capture in, thousands of characters out.").size(15.0).weak()).wrap());
    ui.add_space(GAP);
    if model.build.as_ref().is_some_and(build::is_shown) {
        build::show(ui, model, commands);
        ui.add_space(GAP);
    }
    let width = ui.available_width();
    if width < WIDE {
        show_motion(ui, &mut states.dialog);
        ui.add_space(GAP);
        demos::show(ui, &mut states.start.demos, commands);
        ui.add_space(GAP);
        return show_recent(ui, &states.start.recent, commands);
    }
    ui.horizontal_top(|ui| {
        let spacing = ui.spacing().item_spacing.x;
        ui.vertical(|ui| {
            ui.set_width(width - SIDE - GAP - spacing);
            demos::show(ui, &mut states.start.demos, commands);
        });
        ui.add_space(GAP);
        ui.vertical(|ui| {
            ui.set_width(SIDE);
            show_motion(ui, &mut states.dialog);
            ui.add_space(GAP);
            show_recent(ui, &states.start.recent, commands);
        });
    });
}

/// A heading of a part of the page.
fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).size(18.0).strong());
    ui.add_space(6.0);
}

/// Shows the place.
fn show_motion(ui: &mut Ui, dialog: &mut Option<SystemDialog>) {
    heading(ui, "Your own motion");
    let is_over = ui.input(|i| !i.raw.hovered_files.is_empty());
    let visuals = ui.visuals();
    let fill = if is_over { visuals.selection.bg_fill.gamma_multiply(0.4) } else { visuals.extreme_bg_color };
    let edge = if is_over { visuals.selection.stroke.color } else { visuals.weak_text_color() };
    let shown = Frame::NONE.fill(fill).corner_radius(8).inner_margin(Margin::same(14)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.label(RichText::new("Drop a folder or files here").size(16.0).strong());
        let what = "A folder, a .zip or files of motion (.bvh, .amc, .npz, .glb, .fbx) are built and run. A bundle, a \
                    scene, a world or a single clip is opened.";
        ui.add(Label::new(RichText::new(what).weak()).wrap());
        ui.add_space(6.0);
        ui.horizontal_wrapped(|ui| {
            for (text, kind) in [("Choose a folder…", SystemDialog::Folder), ("Choose files…", SystemDialog::Files)]
            {
                if ui.button(text).clicked() {
                    *dialog = Some(kind);
                }
            }
        });
    });
    let rect = shown.response.rect.shrink(1.0);
    let corners = [rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom(), rect.left_top()];
    ui.painter().extend(Shape::dashed_line(&corners, Stroke::new(1.5, edge), 6.0, 5.0));
}

/// Height of an entry (points).
const RECENT_ROW: f32 = 34.0;

/// Shows the list.
///
/// - `entries`: the files of each, and whether all of them are there.
fn show_recent(ui: &mut Ui, entries: &[(Vec<PathBuf>, bool)], commands: &mut Commands) {
    heading(ui, "Opened last");
    if entries.is_empty() {
        ui.weak("Nothing yet.");
    }
    for (paths, is_there) in entries {
        let size = vec2(ui.available_width(), RECENT_ROW);
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

#[cfg(test)]
mod tests;
