//! The start page: demonstrations, the user's own motion, recently opened files.

mod demos;
mod motion;
mod recent;

use super::{PanelStates, build};
use crate::command::Commands;
use crate::model::Model;
use eframe::egui::{Label, RichText, ScrollArea, Ui};
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
        motion::show(ui, &mut states.dialog);
        ui.add_space(GAP);
        demos::show(ui, &mut states.start.demos, commands);
        ui.add_space(GAP);
        return recent::show(ui, &states.start.recent, commands);
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
            motion::show(ui, &mut states.dialog);
            ui.add_space(GAP);
            recent::show(ui, &states.start.recent, commands);
        });
    });
}

/// A heading of a part of the page.
fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).size(18.0).strong());
    ui.add_space(6.0);
}

#[cfg(test)]
mod tests;
