//! Blackboards on the floor: entries under the pointer, and a click that selects a blackboard.

use super::ray_at;
use crate::command::{BlackboardCell, SceneCommand, SceneViewOptions, ViewerCommand};
use crate::model::Model;
use crate::panels::crowd::blackboards;
use crate::render::Ray;
use crate::stage::agents::cell_at;
use eframe::egui::Response;

/// The smallest cell with an entry where a ray meets the ground.
fn pick_cell(model: &Model, ray: &Ray) -> Option<BlackboardCell> {
    let brains = model.shown_scene()?.run.simulation().brains()?;
    cell_at(brains, &model.selection.scene, ray.intersect_ground()?)
}

/// Shows a tooltip with the entries of the blackboard under the pointer.
pub fn show_tooltip(response: Response, model: &Model) {
    let Some(scene) = model.shown_scene() else { return };
    let Some(brains) = scene.run.simulation().brains() else { return };
    let cell = response.hover_pos().and_then(|at| pick_cell(model, &ray_at(model, response.rect, at)));
    let Some(cell) = cell else { return };
    response.on_hover_ui_at_pointer(|ui| {
        let of_cell = brains.posts().filter(|p| p.cell.is_some_and(|c| BlackboardCell::from_cell(&c) == cell));
        for (i, entry) in of_cell.enumerate() {
            if let (0, Some(c)) = (i, entry.cell) {
                ui.strong(format!("board of a cell of {} m", c.side_m));
            }
            ui.label(blackboards::in_words(scene, brains, &entry));
        }
    });
}

/// Selects the blackboard of the cell that was clicked; none for a cell without entries.
pub fn select_cell(model: &Model, ray: &Ray) -> Option<ViewerCommand> {
    let cell = Some(pick_cell(model, ray)?);
    Some(ViewerCommand::Scene(SceneCommand::SetOptions(SceneViewOptions { cell, ..model.selection.scene })))
}
