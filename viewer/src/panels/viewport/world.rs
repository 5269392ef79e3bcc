//! Mouse and keys in a world: select, send, place, drag and turn.

use super::ray_at;
use crate::command::{Commands, Tool, UnitDraft, ViewerCommand, WorldCommand};
use crate::render::{self, Ray};
use crate::{document::WorldDocument, document::world::UnitChange, model::Model, model::world::snapped};
use crate::{run::RunInput, stage::StageLayout};
use eframe::egui::{Context, CursorIcon, Key, PointerButton, Response, Ui};
use glam::Vec3;
use std::f32::consts::PI;
use throng_core::patch::Placement;
use throng_world::inhabitants::InhabitantGoal;

/// Distance within which a free place is searched around the clicked one (m).
pub const SENT_WITHIN_M: f32 = 5.0;
/// One press of a key turns a unit by this (rad).
const TURN: f32 = PI / 12.0;
/// Angle with Shift (rad).
const QUARTER: f32 = PI / 2.0;

/// A unit that is dragged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DraggedUnit {
    /// Number of the place.
    place: usize,
    /// Offset from the grabbed point, at that height, to the origin of the unit (m).
    offset: Vec3,
    /// That height (m).
    height: f32,
    /// Placement before snapping to other units.
    free: Placement,
}

/// Drags units; true while one is dragged.
pub fn drag(response: &Response, model: &Model, dragged: &mut Option<DraggedUnit>, commands: &mut Commands) -> bool {
    let ctx = &response.ctx;
    let ray = |at| ray_at(model, response.rect, at);
    let Some(world) = model.shown_world().filter(|_| model.selection.world.tool == Tool::Move) else {
        *dragged = None;
        return false;
    };
    if response.drag_started_by(PointerButton::Primary)
        && world.working.is_none()
        && !ctx.input(|i| i.modifiers.shift)
        && let Some(at) = ctx.input(|i| i.pointer.press_origin())
        && let Some((Some(place), met)) = world.pick(&ray(at))
        && let Some(p) = world.placed().get(place)
    {
        let offset = p.placement.translation() - met;
        *dragged = Some(DraggedUnit { place, offset, height: met.y, free: p.placement });
        commands.push(ViewerCommand::World(WorldCommand::SelectPlace(Some(place))));
    }
    let Some(d) = dragged else { return false };
    let Some(unit) = world.placed().get(d.place).map(|p| p.unit) else { return false };
    if let Some(to) = response.interact_pointer_pos().and_then(|p| ray(p).intersect_height(d.height)) {
        let at = to + d.offset;
        d.free = Placement { x: at.x, z: at.z, heading: d.free.heading + turned(ctx), ..d.free };
    }
    let at = fitted(ctx, world, unit, Some(d.place), d.free);
    commands.push(ViewerCommand::World(WorldCommand::Draft(Some(UnitDraft { unit, at }))));
    if !response.dragged_by(PointerButton::Primary) {
        let is_unmoved = world.placed()[d.place].placement == at;
        let change = WorldCommand::Edit(UnitChange::Move { place: d.place, to: at });
        commands.push(ViewerCommand::World(if is_unmoved { WorldCommand::Draft(None) } else { change }));
        *dragged = None;
        return false;
    }
    ctx.set_cursor_icon(CursorIcon::Grabbing);
    true
}

/// Placement of a dragged unit: snapped to others of its kind; with the Alt key, exactly as dragged.
fn fitted(ctx: &Context, world: &WorldDocument, unit: usize, but: Option<usize>, free: Placement) -> Placement {
    if ctx.input(|i| i.modifiers.alt) {
        return free;
    }
    let others = world.placed().iter().enumerate().filter(|(i, p)| p.unit == unit && Some(*i) != but);
    snapped(world.unit(unit), others.map(|o| o.1.placement), free)
}

/// Angle that keys turn a unit by (rad).
fn turned(ctx: &Context) -> f32 {
    if ctx.text_edit_focused() {
        return 0.0;
    }
    ctx.input(|i| {
        let step = if i.modifiers.shift { QUARTER } else { TURN };
        let count = |key| f32::from(u8::from(i.key_pressed(key)));
        step * (count(Key::Q) - count(Key::E))
    })
}

/// Keys that turn and remove the selected unit, while units are moved.
pub fn keys(ui: &Ui, model: &Model, is_dragging: bool, commands: &mut Commands) {
    let Some(world) = model.shown_world().filter(|_| model.selection.world.tool == Tool::Move && !is_dragging) else {
        return;
    };
    let Some(place) = model.selection.world.place.filter(|&p| p < world.placed().len()) else { return };
    let angle = turned(ui);
    if angle != 0.0 {
        let at = world.ordered_placement(place);
        let to = Placement { heading: at.heading + angle, ..at }.with_wrapped_heading();
        commands.push(ViewerCommand::World(WorldCommand::Edit(UnitChange::Move { place, to })));
    }
    let is_asked = || !ui.ctx().text_edit_focused() && ui.input(|i| i.key_pressed(Key::Delete));
    if world.working.is_none() && is_asked() {
        commands.push(ViewerCommand::World(WorldCommand::Edit(UnitChange::Remove { place })));
    }
}

/// Shows the unit that a click would place.
pub fn hover(ui: &Ui, model: &Model, ray: Option<Ray>, heading: &mut f32, commands: &mut Commands) {
    let (Some(world), Tool::Create(unit)) = (model.shown_world(), model.selection.world.tool) else { return };
    if unit >= world.kit.units.units.len() {
        return;
    }
    *heading += turned(ui);
    let draft = ray
        .and_then(|r| r.intersect_height(height(world, unit, &r)))
        .map(|p| UnitDraft { unit, at: fitted(ui, world, unit, None, Placement::new(p.x, p.y, p.z, *heading)) });
    if draft != model.selection.world.draft {
        commands.push(ViewerCommand::World(WorldCommand::Draft(draft)));
    }
}

/// Height for a new unit: that of the point under the pointer; panels are level with others (m).
fn height(world: &WorldDocument, unit: usize, ray: &Ray) -> f32 {
    match world.pick(ray) {
        Some((Some(place), _)) if world.unit(unit).floor => world.placed()[place].placement.y,
        Some((Some(_), met)) => met.y,
        _ => 0.0,
    }
}

/// Effect of a click.
pub fn click(ui: &Ui, model: &Model, world: &WorldDocument, layout: &StageLayout, ray: &Ray, commands: &mut Commands) {
    let options = &model.selection.world;
    let sends = options.tool == Tool::Send || ui.input(|i| i.modifiers.command);
    if sends && let Some(character) = model.selection.character {
        let goal = |(_, place)| Some(InhabitantGoal::GoNear { place, within_m: SENT_WITHIN_M });
        let order = world.pick(ray).map(|met| RunInput::Goal { character, goal: goal(met) });
        return commands.extend(order.map(ViewerCommand::Input));
    }
    if let Tool::Create(_) = options.tool {
        let change = options.draft.map(|d| UnitChange::Add { unit: d.unit, at: d.at });
        return commands.extend(change.map(|c| ViewerCommand::World(WorldCommand::Edit(c))));
    }
    let character = render::pick(ray, &layout.skeleton, layout.poses(model), &layout.instances);
    let unit = world.pick(ray);
    let far = unit.map_or(f32::INFINITY, |u| u.1.distance(ray.origin));
    match character.filter(|h| options.tool != Tool::Move && h.distance < far + 0.3) {
        Some(hit) => commands.push(ViewerCommand::SelectCharacter(Some(hit.character))),
        None => {
            let place = unit.and_then(|u| u.0);
            if place.is_none() && options.place.is_none() {
                commands.push(ViewerCommand::SelectCharacter(None));
            }
            commands.push(ViewerCommand::World(WorldCommand::SelectPlace(place)));
        }
    }
}
