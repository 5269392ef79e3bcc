//! The target of the selected character: a place on the ground, or something to be struck.

use crate::command::{Commands, SteerCommand, ViewerCommand};
use crate::model::Model;
use crate::panels::paint::{PanelWidget, coordinates};
use crate::panels::{character_field, offer_first_character};
use crate::run::{CrowdRun, MAX_TARGET_M, RunInput, TargetMode};
use eframe::egui::Ui;
use glam::Vec3;

/// Shows the target of the selected character of a crowd, and lets it be moved.
pub fn show(ui: &mut Ui, model: &Model, run: &CrowdRun, commands: &mut Commands) {
    ui.strong("Target");
    let Some(c) = model.selection.character else {
        return offer_first_character(ui, "Click a character in the 3-D view, or", true, commands);
    };
    let (root, target) = (run.characters().root(c), run.targets()[c]);
    let mut to = target;
    ui.horizontal_wrapped(|ui| {
        ui.label("of character");
        character_field(ui, c, run.config().characters, commands);
        coordinates(ui, &mut [("x", &mut to.x), ("z", &mut to.z)], MAX_TARGET_M, 0.02, 2);
    });
    ui.label(format!("{:.2} m away", (root.x - target.x).hypot(root.z - target.z)));
    if to != target {
        let who = (run.config().targets != TargetMode::Shared).then_some(c);
        commands.push(ViewerCommand::Input(RunInput::Target { character: who, to }));
    }
    let tip = "With W A S D; Shift runs, X strikes (G)";
    if model.steering().is_none() {
        ui.button("Steer it").on_hover_text(tip).request(commands, ViewerCommand::Steer(SteerCommand::Toggle));
    }
    let gather = ui.button("Everybody comes here").on_hover_text("All targets move to where this character stands");
    let here = Vec3::new(root.x, 0.0, root.z);
    gather.request(commands, ViewerCommand::Input(RunInput::Target { character: None, to: here }));
}

/// Shows the position of a hanging target, and lets it be moved.
pub fn hanging(ui: &mut Ui, who: usize, home: Vec3, commands: &mut Commands) {
    let mut to = home;
    ui.horizontal_wrapped(|ui| {
        ui.label("its target");
        coordinates(ui, &mut [("x", &mut to.x), ("y", &mut to.y), ("z", &mut to.z)], MAX_TARGET_M, 0.02, 2);
    });
    if to != home {
        commands.push(ViewerCommand::Input(RunInput::Target { character: Some(who), to }));
    }
}
