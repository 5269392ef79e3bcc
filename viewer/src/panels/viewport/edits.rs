//! The result of an edit of a world, shown beside its unit.

use super::size;
use crate::command::{Commands, ViewerCommand, WorldCommand};
use crate::document::WorldDocument;
use crate::model::Model;
use crate::panels::paint::PanelWidget;
use eframe::egui::{Align2, Area, Frame, Id, Pos2, Rect, Stroke, Ui, vec2};
use throng_precompute::environment::PlacedUnit;

/// Widest note (points).
const WIDTH: f32 = 340.0;
/// Distance of a note from its subject (points).
const BESIDE: f32 = 14.0;

/// Shows the edit under way, or why the last edit was refused.
pub fn show(ui: &Ui, rect: Rect, model: &Model, commands: &mut Commands) {
    let Some(world) = model.shown_world() else { return };
    if let Some(working) = &world.working {
        note(ui, rect, place(model, world, working.at.as_ref(), rect), |ui| {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(format!("{} …", working.doing));
            });
        });
    } else if let Some(refused) = &world.refused {
        note(ui, rect, place(model, world, refused.at.as_ref(), rect), |ui| {
            ui.horizontal(|ui| {
                ui.colored_label(ui.visuals().error_fg_color, "The world is unchanged");
                let close = ui.button("✖").on_hover_text("Close this message (Escape)");
                close.request(commands, ViewerCommand::World(WorldCommand::ForgetRefused));
            });
            ui.label(&refused.reason);
        });
    }
}

/// Screen position of the upper end of a unit; none if it is not in view.
fn place(model: &Model, world: &WorldDocument, unit: Option<&PlacedUnit>, rect: Rect) -> Option<Pos2> {
    let unit = unit?;
    let bounds = world.kit.geometries.get(unit.unit)?.bounds;
    let top = if bounds.is_empty() { glam::Vec3::ZERO } else { bounds.centre().with_y(bounds.max.y) };
    let at = model.settings.camera.project(unit.placement.transform_point(top), size(rect))?;
    let at = rect.min + vec2(at.x, at.y);
    rect.contains(at).then_some(at)
}

/// A note beside a place, or at the lower edge of the view.
fn note(ui: &Ui, rect: Rect, at: Option<Pos2>, add: impl FnOnce(&mut Ui)) {
    let (pivot, at) = match at {
        Some(at) => (Align2::LEFT_BOTTOM, at + vec2(BESIDE, -BESIDE)),
        None => (Align2::CENTER_BOTTOM, rect.center_bottom() - vec2(0.0, BESIDE)),
    };
    let area = Area::new(Id::unique("edit")).fixed_pos(at).pivot(pivot).constrain_to(rect.shrink(4.0));
    area.show(ui.ctx(), |ui| {
        ui.set_max_width(WIDTH.min(rect.width() - 20.0));
        let stroke = Stroke::new(1.0, ui.visuals().selection.bg_fill);
        Frame::popup(ui.style()).stroke(stroke).show(ui, add);
    });
}
