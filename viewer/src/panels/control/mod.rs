//! Control of the scene: behaviours and weights, targets, number of characters, seed, saved states.

mod scene;

use crate::command::{Commands, ViewerCommand};
use crate::document::OpenDocument;
use crate::model::Model;
use crate::panels::paint::PanelWidget;
use crate::run::RunInput;
use crate::settings::PanelKind;
use eframe::egui::{Grid, Slider, Ui};

pub use scene::SceneControlState;

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut SceneControlState, commands: &mut Commands) {
    if model.document.world().is_some() {
        ui.weak("The panel Patches gives orders to the characters of a world.");
        return ui.button("Open it").request(commands, ViewerCommand::TogglePanel(PanelKind::Patches));
    }
    if let Some(scene) = model.document.scene() {
        return scene::show(ui, model, scene, state, commands);
    }
    let OpenDocument::Bundle(document) = &model.document else {
        return drop(ui.weak("Open a bundle to run a crowd: drop it on the window, or File > Open."));
    };
    if let Err(why) = &document.crowd {
        ui.label(why);
    }
    if document.blend.is_some() {
        ui.weak("Its characters are blended from examples. The panel Blend controls one of them.");
        ui.button("Open it").request(commands, ViewerCommand::TogglePanel(PanelKind::Blend));
    }
}

/// Weights of behaviours.
///
/// - `of`: any character of the group that they are for.
fn behaviours(ui: &mut Ui, names: &[&str], now: &[f32], of: usize, commands: &mut Commands) {
    ui.strong("Behaviours");
    ui.weak("Weight of each behaviour when an action is chosen; 0 switches it off.");
    let mut weights = now.to_vec();
    // A scene may weigh more.
    let most = weights.iter().fold(2.0, |most: f32, w| most.max(2.0 * w));
    Grid::new("weights").num_columns(2).show(ui, |ui| {
        for (weight, name) in weights.iter_mut().zip(names) {
            ui.label(*name);
            ui.add(Slider::new(weight, 0.0..=most).step_by(0.05).fixed_decimals(2));
            ui.end_row();
        }
    });
    if weights != now {
        commands.push(ViewerCommand::Input(RunInput::Weights { member: of, weights }));
    }
}

#[cfg(test)]
mod tests;
