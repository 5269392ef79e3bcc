//! View options for agents.

use super::options_command;
use crate::command::{Commands, OverlayScope, ViewerCommand};
use crate::model::Model;
use crate::panels::paint::PanelWidget;
use crate::settings::ViewerSettings;
use eframe::egui::{Grid, Role, Ui};

/// Shows the view options.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let now = model.selection.scene;
    let (mut l, mut overlays) = (now, model.settings.overlays);
    Grid::new("drawn").num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
        scope_row(ui, "bounds", "Time-varying bounds: where an agent can be, whatever it does", &mut l.bounds);
        scope_row(ui, "paths", "Planned paths to goals", &mut l.paths);
        let trails = if overlays.trails && overlays.of_all { OverlayScope::All } else { OverlayScope::Selected };
        let mut trails = if overlays.trails { trails } else { OverlayScope::None };
        if scope_row(ui, "trails", "Where agents were in the last seconds", &mut trails) {
            overlays.trails = trails != OverlayScope::None;
            overlays.of_all = trails == OverlayScope::All;
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut l.cells, "cells").on_hover_text("Cell C, region R and the cells α(C) of the selected agent");
        ui.checkbox(&mut l.forces, "forces").on_hover_text("Each force of the selected agent, and its stop region");
        ui.checkbox(&mut l.marks, "marks").on_hover_text("Marks at events; they fade");
        if has_bodies(model) {
            ui.checkbox(&mut l.bodies, "bodies").on_hover_text("Bodies of agents, over their discs");
        }
    });
    if l != now {
        commands.push(options_command(model, |options| *options = l));
    }
    if overlays != model.settings.overlays {
        let settings = ViewerSettings { overlays, ..model.settings.clone() };
        commands.push(ViewerCommand::Settings(Box::new(settings)));
    }
}

/// A row of the grid: the agents for which something is drawn; true if one of the choices was clicked.
fn scope_row(ui: &mut Ui, name: &str, tip: &str, scope: &mut OverlayScope) -> bool {
    ui.label(name).on_hover_text(tip);
    let clicked = ui.horizontal(|ui| {
        OverlayScope::ALL.map(|(one, text)| {
            let label = ui.selectable_value(scope, one, text);
            label.named(Role::RadioButton, format!("{name}: {text}")).clicked()
        })
    });
    ui.end_row();
    clicked.inner.contains(&true)
}

/// True where some agent has a body.
fn has_bodies(model: &Model) -> bool {
    let Some(simulation) = model.document.scene().map(|s| s.run.simulation()) else { return false };
    (0..simulation.num_characters()).any(|who| simulation.disc(who).is_some() && simulation.pose(who).is_some())
}
