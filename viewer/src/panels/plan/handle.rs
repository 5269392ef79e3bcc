//! Movable things and places, and the coordinates of the selected one.

use crate::command::{Commands, PlanCommand, PlanViewOptions, ViewerCommand};
use crate::document::TaskDocument;
use crate::model::Model;
use crate::panels::paint::{PanelWidget, choose, coordinates};
use eframe::egui::Ui;

/// Shows the selected thing or place.
pub fn show(ui: &mut Ui, model: &Model, task: &TaskDocument, wanted: &mut PlanViewOptions, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        ui.strong("Things and places");
        let named = task.task().handles().into_iter().map(|h| (Some(h), task.task().handle_name(h)));
        let options = std::iter::once((None, "none selected".into())).chain(named);
        choose(ui, "Thing or place", None, &mut wanted.handle, options);
    });
    let selected = wanted.handle.and_then(|h| Some((h, task.place_of(h, model.task_time_s())?)));
    let Some((handle, place)) = selected else {
        return drop(ui.weak("Drag a thing or a place in the view; with Alt it goes up and down."));
    };
    let now = place.position.as_vec3();
    let mut to = now;
    ui.horizontal_wrapped(|ui| {
        coordinates(ui, &mut [("x", &mut to.x), ("y", &mut to.y), ("z", &mut to.z)], 1e3, 0.0, 3);
        // The position as in a task file.
        let at = task.task().written_position(handle).as_vec3();
        let text = format!("at = [{:.3}, {:.3}, {:.3}]", at.x, at.y, at.z);
        if ui.small_button("Copy").on_hover_text(format!("{text}: for the task's file")).clicked() {
            ui.ctx().copy_text(text);
        }
    });
    // The fields show rounded numbers: rounding alone moves nothing.
    if to.distance(now) > 6e-4 {
        commands.push(ViewerCommand::Plan(PlanCommand::Move(handle, to - now)));
        commands.push(ViewerCommand::Plan(PlanCommand::EndMove));
    }
}
