//! The 3-D view: camera, selection, and targets that are dragged.

pub mod steer;
pub mod task;
pub mod world;

use super::{build, messages, paint::PanelWidget, words};
use crate::command::{BlackboardCell, Commands, SceneCommand, SceneViewOptions, ViewerCommand};
use crate::render::{self, OrbitCamera, Ray};
use crate::run::{RunInput, target_home};
use crate::stage::{self, StageLayout};
use crate::{model::Model, panels::crowd::blackboards, stage::agents::cell_at};
use eframe::egui::{self, CursorIcon, FontId, PointerButton, Pos2, Rect, Response, Sense, Ui, vec2};
use glam::{Vec2, Vec3};
use throng_simulation::AnyCharacterGroup;
use throng_world::inhabitants::InhabitantGoal;

/// Distance from the pointer within which a target can be grabbed (points).
const GRAB: f32 = 16.0;
/// Largest crowd in which targets of unselected characters can be dragged: in larger ones, targets would be in the way
/// of turning the camera.
const MAX_GRABBED: usize = 50;
/// Distance from the pointer within which other characters' targets can be grabbed (points).
const GRAB_OTHERS: f32 = 6.0;

/// State of the view.
#[derive(Clone, Debug, Default)]
pub struct ViewportState {
    /// Character whose target is dragged; the inner none stands for all targets.
    dragged: Option<Option<usize>>,
    /// A unit of a world that is dragged.
    dragged_unit: Option<world::DraggedUnit>,
    /// A thing of a task that is dragged.
    dragged_thing: Option<task::DraggedThing>,
    /// Heading of the unit that a click would place (rad).
    heading: f32,
    /// Width over height.
    pub aspect: f32,
}

/// Shows the view in all that is left of the window. `paint` adds the 3-D picture.
pub fn show(
    ui: &mut Ui,
    model: &Model,
    layout: &StageLayout,
    state: &mut ViewportState,
    commands: &mut Commands,
    paint: impl FnOnce(&Ui, Rect) -> Result<(), String>,
) {
    let response = ui.allocate_rect(ui.available_rect_before_wrap(), Sense::click_and_drag());
    let response = response.named(egui::Role::Image, "3-D view");
    let rect = response.rect;
    state.aspect = rect.width() / rect.height().max(1.0);
    if let Err(why) = paint(ui, rect) {
        show_caption(ui, rect, why, 0.9, |size| rect.center() - 0.5 * size);
    }
    drag(ui, &response, model, state, commands);
    click(ui, &response, model, layout, commands);
    show_label(ui, rect, model);
    steer::show(ui, rect, model);
    show_blackboard_tooltip(response, model);
    messages::show(ui, rect, model, commands);
    build::show_over(ui, rect, model, commands);
}

fn size(rect: Rect) -> Vec2 {
    Vec2::new(rect.width(), rect.height())
}

/// Place of the pointer within the view.
fn position_in_view(rect: Rect, at: Pos2) -> Vec2 {
    Vec2::new(at.x - rect.left(), at.y - rect.top())
}

/// Ray through a place on the screen.
fn ray_at(model: &Model, rect: Rect, at: Pos2) -> Ray {
    model.settings.camera.ray(position_in_view(rect, at), size(rect))
}

/// Text at a corner of the view, on a ground of its own.
///
/// - `width`: widest line, as a share of the view; `place`: where a text of some size lies.
fn show_caption(ui: &Ui, rect: Rect, text: String, width: f32, place: impl FnOnce(egui::Vec2) -> Pos2) {
    let (font, colour) = (FontId::proportional(13.0), ui.visuals().strong_text_color());
    let galley = ui.painter().layout(text, font, colour, (rect.width() * width).max(100.0));
    let at = place(galley.size());
    let back = Rect::from_min_size(at, galley.size()).expand(6.0);
    ui.painter().rect_filled(back, 4.0, ui.visuals().extreme_bg_color.gamma_multiply(0.75));
    ui.painter().galley(at, galley, colour);
}

/// Camera and targets.
fn drag(ui: &Ui, response: &Response, model: &Model, state: &mut ViewportState, commands: &mut Commands) {
    let rect = response.rect;
    let shift = ui.input(|i| i.modifiers.shift);
    let ray = |at: Pos2| ray_at(model, rect, at);
    let was_dragged = state.dragged_unit.is_some();
    let drags_unit = world::drag(response, model, &mut state.dragged_unit, commands);
    world::keys(ui, model, was_dragged, commands);
    world::hover(ui, model, response.hover_pos().map(ray), &mut state.heading, commands);
    if drags_unit || task::drag(response, model, &mut state.dragged_thing, commands) {
        return;
    }
    let targets = targets(model);
    if response.drag_started_by(PointerButton::Primary)
        && let Some(at) = ui.input(|i| i.pointer.press_origin())
    {
        state.dragged = grabbed(model, &targets, rect, at).map(|c| Some(c).filter(|_| !shift));
    }
    if !response.dragged_by(PointerButton::Primary) {
        state.dragged = None;
    }
    if let (Some(character), Some(at)) = (state.dragged, response.interact_pointer_pos())
        && let Some(held) = targets.iter().find(|t| character.is_none_or(|c| c == t.who))
    {
        let (ray, home) = (ray(at), held.home);
        // A target in the air goes up and down while the Alt key is held, else it keeps its height.
        let lifts = home.y > 0.0 && ui.input(|i| i.modifiers.alt);
        let to = if lifts { upright(&ray, model.settings.camera, home) } else { ray.intersect_height(home.y) };
        commands.extend(to.map(|to| ViewerCommand::Input(RunInput::Target { character, to })));
        ui.set_cursor_icon(CursorIcon::Grabbing);
        return;
    }
    if response.hover_pos().is_some_and(|at| grabbed(model, &targets, rect, at).is_some()) {
        ui.set_cursor_icon(CursorIcon::Grab);
    }
    move_camera(ui, response, model, shift, commands);
}

fn move_camera(ui: &Ui, response: &Response, model: &Model, shift: bool, commands: &mut Commands) {
    let mut camera = model.settings.camera;
    let by = response.drag_delta();
    if response.dragged_by(PointerButton::Middle) || (response.dragged_by(PointerButton::Primary) && shift) {
        camera.pan(by.x, by.y, response.rect.height());
    } else if response.dragged_by(PointerButton::Primary) {
        camera.orbit(by.x, by.y);
    } else if response.dragged_by(PointerButton::Secondary) {
        camera.zoom((0.006 * by.y).exp());
    }
    if response.contains_pointer() {
        let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        camera.zoom((-0.0025 * scroll).exp() / pinch);
    }
    if camera != model.settings.camera {
        commands.push(ViewerCommand::Camera(camera));
    }
}

/// Point on the vertical line through a place that is nearest to a ray, found on the upright plane there that faces
/// the camera; above the ground (m).
fn upright(ray: &Ray, camera: OrbitCamera, place: Vec3) -> Option<Vec3> {
    let facing = camera.axes()[2].with_y(0.0).try_normalize()?;
    let distance = (place - ray.origin).dot(facing) / ray.direction.dot(facing);
    (distance.is_finite() && distance > 0.0).then(|| place.with_y(ray.point_at(distance).y.max(0.05)))
}

/// A target that can be moved.
struct MovableTarget {
    /// Its character.
    who: usize,
    /// Position (m).
    place: Vec3,
    /// Place where it hangs, or lies on the ground (m).
    home: Vec3,
}

/// Movable targets of the scene that is shown.
fn targets(model: &Model) -> Vec<MovableTarget> {
    let Some(simulation) = model.shown_scene().map(|s| s.run.simulation()) else { return Vec::new() };
    let target = |who| Some(MovableTarget { who, place: simulation.target(who)?, home: target_home(simulation, who)? });
    (0..simulation.num_characters()).filter_map(target).collect()
}

/// Character whose target is under the pointer.
fn grabbed(model: &Model, targets: &[MovableTarget], rect: Rect, at: Pos2) -> Option<usize> {
    let camera = model.settings.camera;
    let near = |target: Vec3| {
        let place = camera.project(target, size(rect))?;
        let distance = (place - position_in_view(rect, at)).length();
        (distance < GRAB).then_some(distance)
    };
    if let Some(own) = targets.iter().find(|t| model.selection.character == Some(t.who))
        && (near(own.place).is_some() || near(own.place + Vec3::Y * 0.9).is_some())
    {
        return Some(own.who);
    }
    if targets.len() > MAX_GRABBED || !model.settings.overlays.targets {
        return None;
    }
    let reach = |t: &MovableTarget| Some((t.who, near(t.place).filter(|&d| d < GRAB_OTHERS)?));
    targets.iter().filter_map(reach).min_by(|a, b| a.1.total_cmp(&b.1)).map(|t| t.0)
}

fn click(ui: &Ui, response: &Response, model: &Model, layout: &StageLayout, commands: &mut Commands) {
    let rect = response.rect;
    let Some(at) = response.interact_pointer_pos() else { return };
    let ray = ray_at(model, rect, at);
    if response.double_clicked() {
        if let Some(place) = ray.intersect_ground() {
            let mut camera = model.settings.camera;
            camera.target = place.with_y(camera.target.y);
            commands.push(ViewerCommand::Camera(camera));
        }
        return;
    }
    if !response.clicked() {
        return;
    }
    if model.document.task().is_some() {
        return task::click(model, &ray, size(rect), commands);
    }
    if let Some(world) = model.shown_world() {
        return world::click(ui, model, world, layout, &ray, commands);
    }
    let is_order = ui.input(|i| i.modifiers.command);
    if is_order && let Some(input) = order(model, &ray) {
        return commands.push(ViewerCommand::Input(input));
    }
    if let Some(scene) = model.shown_scene() {
        let body = render::pick(&ray, &layout.skeleton, layout.poses(model), &layout.instances);
        let body = body.and_then(|hit| layout.drawn.get(hit.character).copied());
        let hit = body.or_else(|| stage::scene::pick(scene, &model.settings.camera, &ray, size(rect)));
        let blackboard = select_cell(model, &ray).filter(|_| hit.is_none());
        commands.push(blackboard.unwrap_or(ViewerCommand::SelectCharacter(hit)));
    }
}

/// Input of a click with the command key: moves a target there, or sends an inhabitant of a world there.
fn order(model: &Model, ray: &Ray) -> Option<RunInput> {
    let scene = model.shown_scene()?;
    let character = model.selection.character.filter(|&who| who < model.num_characters())?;
    if let Some(home) = target_home(scene.run.simulation(), character) {
        return Some(RunInput::Target { character: Some(character), to: ray.intersect_height(home.y)? });
    }
    match scene.run.simulation().locate(character).0 {
        AnyCharacterGroup::Patches(_) => {
            let place = scene.surroundings.intersect_units(ray).or(ray.intersect_ground())?;
            let goal = InhabitantGoal::GoNear { place, within_m: world::SENT_WITHIN_M };
            Some(RunInput::Goal { character, goal: Some(goal) })
        }
        _ => None,
    }
}

/// Shows the selected character and its activity, at the upper right.
fn show_label(ui: &Ui, rect: Rect, model: &Model) {
    let Some(text) = describe(model) else { return };
    show_caption(ui, rect, text, 0.6, |size| rect.right_top() + vec2(-size.x - 16.0, 12.0));
}

fn describe(model: &Model) -> Option<String> {
    if model.shows_clip() {
        let bundle = model.document.bundle()?;
        let row = model.shown_row()?;
        let first = bundle.tables().clips().get(model.selection.clip)?.first_frame;
        return Some(format!("{}  frame {}", bundle.clip_name(model.selection.clip), row - first));
    }
    if let Some(world) = model.document.world() {
        let c = model.selection.character?;
        let state = world.run.reel.moment().states.get(c)?;
        let tags = &world.bundle().tables().meta().link_tags;
        let patch = world.patch_name(state.node.instance);
        let (activity, goal) = (words::inhabitant_activity(state), words::goal(state.goal, tags));
        return Some(format!("character {c} · {activity} · {goal} · on {patch}"));
    }
    if let Some((bundle, run)) = model.document.blend().filter(|_| model.shows_blend()) {
        let b = run.blending();
        return Some(format!("{} · size {:.2}", bundle.blend_meta(b.space).name, b.size));
    }
    let (scene, who) = (model.document.scene()?, model.selection.character?);
    let plays = scene.chooser(who).map(|c| c.bundle.describe_segment(c.characters.segment(c.number).0));
    let text = words::character(scene.run.simulation(), who)?;
    Some(plays.map_or(text.clone(), |plays| format!("{text} · {plays}")))
}

/// The smallest cell with an entry where a ray meets the ground.
fn pick_cell(model: &Model, ray: &Ray) -> Option<BlackboardCell> {
    let brains = model.shown_scene()?.run.simulation().brains()?;
    cell_at(brains, &model.selection.scene, ray.intersect_ground()?)
}

/// Shows a tooltip with the entries of the blackboard under the pointer.
fn show_blackboard_tooltip(response: Response, model: &Model) {
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
fn select_cell(model: &Model, ray: &Ray) -> Option<ViewerCommand> {
    let cell = Some(pick_cell(model, ray)?);
    Some(ViewerCommand::Scene(SceneCommand::SetOptions(SceneViewOptions { cell, ..model.selection.scene })))
}
