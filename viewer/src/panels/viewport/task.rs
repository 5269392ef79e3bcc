//! Mouse in a task of limbs: selects and drags things and places.

use super::{ray_at, size, upright};
use crate::command::{Commands, PlanCommand, PlanViewOptions, ViewerCommand};
use crate::{model::Model, render::Ray};
use eframe::egui::{CursorIcon, PointerButton, Pos2, Response};
use glam::{Vec2, Vec3};
use throng_planner::task::Handle;

/// Distance from the pointer within which places can be grabbed (points).
const GRAB: f32 = 10.0;

/// Something that is dragged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DraggedThing {
    handle: Handle,
    /// Grabbed point, moved along (m).
    at: Vec3,
    has_moved: bool,
}

/// Thing or place under the pointer, and the point that was hit.
fn pick_handle(model: &Model, ray: &Ray, view: Vec2) -> Option<(Handle, Vec3)> {
    let camera = model.settings.camera;
    let radius = |at: Vec3| GRAB / camera.pixels_per_metre(at.distance(camera.eye()), view.y);
    model.document.task()?.pick(ray, model.task_time_s(), radius)
}

/// Drags things; true while one is dragged.
pub fn drag(response: &Response, model: &Model, held: &mut Option<DraggedThing>, commands: &mut Commands) -> bool {
    if model.document.task().is_none() {
        *held = None;
        return false;
    }
    let (ctx, rect) = (&response.ctx, response.rect);
    let ray = |at: Pos2| ray_at(model, rect, at);
    let is_camera = ctx.input(|i| i.modifiers.shift);
    if response.drag_started_by(PointerButton::Primary)
        && !is_camera
        && let Some(origin) = ctx.input(|i| i.pointer.press_origin())
        && let Some((handle, at)) = pick_handle(model, &ray(origin), size(rect))
    {
        *held = Some(DraggedThing { handle, at, has_moved: false });
        select(model, Some(handle), commands);
    }
    let Some(h) = held else {
        let is_over = response.hover_pos().is_some_and(|at| pick_handle(model, &ray(at), size(rect)).is_some());
        if is_over && !response.dragged() {
            ctx.set_cursor_icon(CursorIcon::Grab);
        }
        return false;
    };
    if !response.dragged_by(PointerButton::Primary) {
        if h.has_moved {
            commands.push(ViewerCommand::Plan(PlanCommand::EndMove));
        }
        *held = None;
        return false;
    }
    if let Some(at) = response.interact_pointer_pos() {
        // The thing moves up and down while the Alt key is held, else it keeps its height.
        let to = match ctx.input(|i| i.modifiers.alt) {
            true => upright(&ray(at), model.settings.camera, h.at),
            false => ray(at).intersect_height(h.at.y),
        };
        let by = to.map(|to| to - h.at).filter(|by| by.length() > 1e-5 && by.length() < 100.0);
        if let Some(by) = by {
            (h.at, h.has_moved) = (h.at + by, true);
            commands.push(ViewerCommand::Plan(PlanCommand::Move(h.handle, by)));
        }
    }
    ctx.set_cursor_icon(CursorIcon::Grabbing);
    true
}

/// A click selects what is under the pointer.
pub fn click(model: &Model, ray: &Ray, view: Vec2, commands: &mut Commands) {
    select(model, pick_handle(model, ray, view).map(|u| u.0), commands);
}

fn select(model: &Model, handle: Option<Handle>, commands: &mut Commands) {
    let options = PlanViewOptions { handle, ..model.selection.plan };
    if options != model.selection.plan {
        commands.push(ViewerCommand::Plan(PlanCommand::SetOptions(options)));
    }
}
