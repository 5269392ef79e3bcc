//! The target of the selected character: a place on the ground, or something to be struck.

use crate::command::{Commands, SteerCommand, ViewerCommand};
use crate::model::Model;
use crate::panels::paint::{PanelWidget, coordinates};
use crate::run::{MAX_TARGET_M, RunInput};
use eframe::egui::Ui;
use glam::Vec3;

/// Shows the position of the target of a character, and lets it be moved; lets the character be steered.
///
/// - `home`: position of the target; `at`: position of the character (m).
pub fn show(ui: &mut Ui, model: &Model, who: usize, home: Vec3, at: Vec3, commands: &mut Commands) {
    let mut to = home;
    ui.horizontal_wrapped(|ui| {
        ui.label("its target");
        coordinates(ui, &mut [("x", &mut to.x), ("y", &mut to.y), ("z", &mut to.z)], MAX_TARGET_M, 0.02, 2);
    });
    if to != home {
        commands.push(ViewerCommand::Input(RunInput::Target { character: Some(who), to }));
    }
    ui.horizontal_wrapped(|ui| {
        let tip = "With W A S D; Shift runs, X strikes (G)";
        if model.steering().is_none() {
            ui.button("Steer it").on_hover_text(tip).request(commands, ViewerCommand::Steer(SteerCommand::Toggle));
        }
        let gather = ui.button("Everybody comes here").on_hover_text("All targets move to where this character stands");
        let here = ViewerCommand::Input(RunInput::Target { character: None, to: at.with_y(home.y) });
        gather.request(commands, here);
    });
}
