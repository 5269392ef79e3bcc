//! Worlds of motion patches: the selected patch, the path of a character, its orders, and edits.

mod character;
mod edit;
mod facts;

use crate::command::{Commands, Tool, ViewerCommand, WorldCommand};
use crate::{document::WorldDocument, model::Model, panels::paint::PanelWidget};
use eframe::egui::{Button, Ui};
use facts::InstanceFacts;
use throng_precompute::stitch::InstanceItem;

/// World, its state, instance and link that a reason is for.
type ReasonKey = (u64, u64, u32, u32);

/// State of the panel.
#[derive(Clone, Debug, Default)]
pub struct PatchesPanelState {
    /// Figures of the selected patch, with the world, its revision and the instance that they belong to.
    facts: Option<((u64, u64, u32), InstanceFacts)>,
    /// Why the selected link is disabled, with the key that the reason belongs to.
    why: Option<(ReasonKey, Option<String>)>,
    /// Unit that is to be placed.
    unit: usize,
    /// File that the world is written to, as typed.
    file: Option<String>,
    /// Duration of an ordered action (s).
    seconds: Option<f32>,
    /// Number of characters as typed.
    characters: Option<usize>,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut PatchesPanelState, commands: &mut Commands) {
    let Some(world) = model.document.world() else {
        ui.weak("Open a world of motion patches, or a scene in one: data/worlds/*.toml, data/scenes/*.toml.");
        return;
    };
    tools(ui, model, world, state, commands);
    ui.separator();
    character::show(ui, model, world, state, commands);
    ui.separator();
    match model.inspected_instance() {
        None => _ = ui.weak("Click a unit, or a character, to see the patch there."),
        Some(instance) => {
            let key = (model.generation, world.revision, instance);
            if state.facts.as_ref().is_none_or(|f| f.0 != key) {
                // No reason is available while the world is stitched again.
                let is_known = world.working.is_none();
                state.facts = is_known.then(|| (key, InstanceFacts::count_cells(world, instance)));
            }
            if let Some((_, facts)) = &state.facts {
                facts::show(ui, model, world, facts, commands);
                facts::show_links(ui, model, world, facts, commands);
            }
            show_reason(ui, model, state, instance);
        }
    }
    ui.separator();
    edit::show(ui, model, world, state, commands);
}

/// Choice of the tool.
fn tools(ui: &mut Ui, model: &Model, world: &WorldDocument, state: &PatchesPanelState, commands: &mut Commands) {
    let now = model.selection.world.tool;
    ui.horizontal_wrapped(|ui| {
        for (tool, name, tip) in [
            (Tool::Select, "Look", "A click selects a character or a unit"),
            (Tool::Send, "Send", "A click sends the selected character there; Ctrl + click always does"),
            (Tool::Move, "Move", "Units are dragged; Q and E turn the selected one, Delete removes it"),
            (Tool::Create(state.unit), "Create", "A click places a unit; Q and E turn it first"),
        ] {
            let is_on = std::mem::discriminant(&now) == std::mem::discriminant(&tool);
            let label = ui.selectable_label(is_on, name).on_hover_text(tip);
            label.request(commands, ViewerCommand::World(WorldCommand::Tool(tool)));
        }
        ui.separator();
        history(ui, world, commands);
    });
    let hint = match now {
        Tool::Select => "Click a character or a unit.",
        Tool::Send if model.selection.character.is_none() => "Select a character first (Look).",
        Tool::Send => "Click where the selected character is to go.",
        Tool::Move => {
            "Drag a unit; Q, E turn it (Shift: quarter turns), Alt leaves it off the grid, Delete removes it."
        }
        Tool::Create(_) => "Click where the unit is to stand; Q, E turn it.",
    };
    ui.weak(hint);
    if let Some(working) = &world.working {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.label(format!("{} …", working.doing));
        });
    }
}

/// Buttons that take changes back and make them again.
fn history(ui: &mut Ui, world: &WorldDocument, commands: &mut Commands) {
    for (text, change, tip, key, command) in [
        ("Undo", world.to_undo(), "Undo", "Ctrl+Z", WorldCommand::Undo),
        ("Redo", world.to_redo(), "Redo", "Ctrl+Shift+Z or Ctrl+Y", WorldCommand::Redo),
    ] {
        let button = ui.add_enabled(change.is_some(), Button::new(text));
        let tip = format!("{tip}: {} ({key})", change.unwrap_or("nothing"));
        let button = button.on_hover_text(&tip).on_disabled_hover_text(&tip);
        button.request(commands, ViewerCommand::World(command));
    }
}

/// Shows why the selected link is disabled.
fn show_reason(ui: &mut Ui, model: &Model, state: &mut PatchesPanelState, instance: u32) {
    let (Some(world), Some(link)) = (model.document.world(), model.selection.world.link) else { return };
    if link as usize >= world.graph().links(instance).len() {
        return;
    }
    let key = (model.generation, world.revision, instance, link);
    if state.why.as_ref().is_none_or(|w| w.0 != key) {
        if world.working.is_some() {
            return;
        }
        state.why = Some((key, world.full_reason(instance, InstanceItem::Link(link)).map(|w| w.message)));
    }
    ui.add_space(4.0);
    match state.why.as_ref().and_then(|w| w.1.as_deref()) {
        Some(message) => ui.label(message),
        None => ui.label(format!("Link {link} is left: characters take it.")),
    };
}
