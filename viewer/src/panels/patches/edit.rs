//! Units of a world: one that is created, the selected one, the last edit, and the file to save to.

use super::PatchesPanelState;
use crate::command::{Commands, Tool, ViewerCommand, WorldCommand};
use crate::panels::paint::{PanelWidget, choose, coordinates};
use crate::{document::WorldDocument, document::world::UnitChange, model::Model};
use eframe::egui::{Button, DragValue, TextEdit, Ui};
use std::path::{Path, PathBuf};
use throng_core::patch::Placement;

/// Shows the editing controls.
pub fn show(ui: &mut Ui, model: &Model, world: &WorldDocument, state: &mut PatchesPanelState, commands: &mut Commands) {
    ui.strong("Units");
    create(ui, model, world, state, commands);
    selected(ui, model, world, commands);
    if let Some(e) = &world.edited {
        let lost = if e.num_lost > 0 { format!("; {} characters found no place", e.num_lost) } else { String::new() };
        let free = match e.num_released {
            0 => String::new(),
            n => format!("; {n} can no longer do what they were ordered to"),
        };
        let [total, stitch] = [e.total_s, e.stitch_s].map(|s| 1e3 * s);
        ui.label(format!("{} in {total:.0} ms, {stitch:.0} ms of it stitching{lost}{free}", e.description));
    }
    let r = &world.report;
    ui.weak(format!(
        "{} patches, {} cells, {} transitions, {:.2} h of motion, {} kinds of joints",
        r.instances, r.cells, r.transitions, r.motion_hours, r.tables
    ));
    save(ui, world, state, commands);
}

fn create(ui: &mut Ui, model: &Model, world: &WorldDocument, state: &mut PatchesPanelState, commands: &mut Commands) {
    let units = &world.kit.units.units;
    state.unit = state.unit.min(units.len().saturating_sub(1));
    ui.horizontal_wrapped(|ui| {
        ui.label("Create");
        let before = state.unit;
        let names = units.iter().map(|u| u.name.clone()).enumerate();
        choose(ui, "Unit", None, &mut state.unit, names);
        let creates = matches!(model.selection.world.tool, Tool::Create(_));
        let text = if creates { "click where it is to stand" } else { "Place …" };
        let clicked = ui.selectable_label(creates, text).clicked();
        if clicked || (creates && before != state.unit) {
            let tool = if clicked && creates { Tool::Select } else { Tool::Create(state.unit) };
            commands.push(ViewerCommand::World(WorldCommand::Tool(tool)));
        }
    });
}

/// The selected unit by its numbers.
fn selected(ui: &mut Ui, model: &Model, world: &WorldDocument, commands: &mut Commands) {
    let Some(place) = model.selection.world.place.filter(|&p| p < world.placed().len()) else {
        return drop(ui.weak("No unit is selected."));
    };
    let placed = &world.placed()[place];
    let now = world.ordered_placement(place);
    let mut p = now;
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("{} {place}", world.unit(placed.unit).name));
        coordinates(ui, &mut [("x", &mut p.x), ("y", &mut p.y), ("z", &mut p.z)], 1e4, 0.0, 2);
        let mut degrees = p.with_wrapped_heading().heading.to_degrees();
        let field = DragValue::new(&mut degrees).range(-180.0..=180.0).speed(0.0).update_while_editing(false);
        if ui.add(field.suffix("°").fixed_decimals(0)).changed() {
            p.heading = degrees.to_radians();
        }
        if p != now {
            commands.push(edit(UnitChange::Move { place, to: p }));
        }
    });
    ui.horizontal_wrapped(|ui| {
        for (text, tip, degrees) in [("⟲ 90°", "Turn it left", 90.0f32), ("⟳ 90°", "Turn it right", -90.0)] {
            let to = Placement { heading: p.heading + degrees.to_radians(), ..p }.with_wrapped_heading();
            ui.button(text).on_hover_text(tip).request(commands, edit(UnitChange::Move { place, to }));
        }
        let remove = ui.add_enabled(world.working.is_none(), Button::new("Remove"));
        let remove = remove.on_hover_text("Delete, while units are moved");
        remove.request(commands, edit(UnitChange::Remove { place }));
    });
}

fn edit(change: UnitChange) -> ViewerCommand {
    ViewerCommand::World(WorldCommand::Edit(change))
}

fn save(ui: &mut Ui, world: &WorldDocument, state: &mut PatchesPanelState, commands: &mut Commands) {
    ui.horizontal(|ui| {
        let file = state.file.get_or_insert_with(|| suggested(&world.path).display().to_string());
        let button = ui.button("Save").on_hover_text("Write the world as a list of places");
        ui.add(TextEdit::singleline(file).desired_width(f32::INFINITY));
        if button.clicked() && !file.trim().is_empty() {
            commands.push(ViewerCommand::World(WorldCommand::Save(PathBuf::from(file.trim()))));
        }
    });
}

/// A file beside a world's that is not its own.
fn suggested(world: &Path) -> PathBuf {
    let stem = world.file_stem().unwrap_or_default().to_string_lossy();
    world.with_file_name(format!("{stem}-edited.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_world_itself_is_not_written_over_unless_that_is_asked_for() {
        assert_eq!(suggested(Path::new("worlds/logo.toml")), Path::new("worlds/logo-edited.toml"));
    }
}
