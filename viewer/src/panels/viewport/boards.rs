//! Blackboards on the floor: entries under the pointer, and a click that selects a blackboard.

use crate::command::{BoardCell, Command, SceneCommand, SceneLook};
use crate::model::Model;
use crate::panels::crowd::boards;
use crate::render::Ray;
use crate::stage::agents::cell_at;
use eframe::egui::Response;

/// The smallest cell with an entry where a ray meets the ground.
fn met(model: &Model, ray: &Ray) -> Option<BoardCell> {
    let minds = model.shown_scene()?.run().simulation().minds()?;
    cell_at(minds, &model.selection.scene, ray.meets_ground()?)
}

/// Shows a tooltip with the entries of the blackboard under the pointer.
pub fn tell(response: Response, model: &Model, ray: impl Fn() -> Option<Ray>) {
    let Some(scene) = model.shown_scene() else { return };
    let Some(minds) = scene.run().simulation().minds() else { return };
    let Some(cell) = ray().and_then(|ray| met(model, &ray)) else { return };
    response.on_hover_ui_at_pointer(|ui| {
        let of_cell = minds.posts().filter(|p| p.cell.is_some_and(|c| BoardCell::of(&c) == cell));
        for (i, entry) in of_cell.enumerate() {
            if let (0, Some(c)) = (i, entry.cell) {
                ui.strong(format!("board of a cell of {} m", c.side_m));
            }
            ui.label(boards::in_words(scene, minds, &entry));
        }
    });
}

/// Selects the blackboard of the cell that was clicked; none for a cell without entries.
pub fn read(model: &Model, ray: &Ray) -> Option<Command> {
    let cell = Some(met(model, ray)?);
    Some(Command::Scene(SceneCommand::Look(SceneLook { cell, ..model.selection.scene })))
}
