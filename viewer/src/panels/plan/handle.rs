//! Movable things and places, and the coordinates of the selected one.

use crate::command::{Commands, PlanCommand, PlanViewOptions, ViewerCommand};
use crate::document::TaskDocument;
use crate::model::Model;
use eframe::egui::{ComboBox, DragValue, Role, Ui, WidgetInfo};
use glam::Vec3;

/// Shows the selected thing or place.
pub fn show(ui: &mut Ui, model: &Model, task: &TaskDocument, wanted: &mut PlanViewOptions, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        ui.strong("Things and places");
        let name = wanted.handle.map_or_else(|| "none selected".into(), |h| task.task().handle_name(h));
        let combo = ComboBox::from_id_salt("handle").selected_text(name).show_ui(ui, |ui| {
            ui.selectable_value(&mut wanted.handle, None, "none");
            for handle in task.task().handles() {
                ui.selectable_value(&mut wanted.handle, Some(handle), task.task().handle_name(handle));
            }
        });
        combo.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "Thing or place"));
    });
    let selected = wanted.handle.and_then(|h| Some((h, task.place_of(h, model.task_time_s())?)));
    let Some((handle, place)) = selected else {
        ui.weak("Drag a thing or a place in the view; with Alt it goes up and down.");
        return;
    };
    let now = place.position.as_vec3();
    let mut to = now;
    ui.horizontal_wrapped(|ui| {
        for (name, value) in [("x", &mut to.x), ("y", &mut to.y), ("z", &mut to.z)] {
            ui.label(name);
            let field = DragValue::new(value).range(-1e3..=1e3).speed(0.0).update_while_editing(false);
            ui.add(field.suffix(" m").fixed_decimals(3));
        }
        let text = toml(task.task().written_position(handle).as_vec3());
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

/// The position as in a task file.
fn toml(at: Vec3) -> String {
    format!("at = [{:.3}, {:.3}, {:.3}]", at.x, at.y, at.z)
}
