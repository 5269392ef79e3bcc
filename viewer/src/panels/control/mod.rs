//! Control of the crowd or the scene: behaviours and weights, targets, number of characters, seed, saved states.

mod crowd;
mod scene;
mod target;

use crate::command::{Commands, ViewerCommand};
use crate::document::OpenDocument;
use crate::model::Model;
use crate::panels::paint::PanelWidget;
use crate::run::{CrowdRunConfig, RunInput};
use crate::settings::PanelKind;
use eframe::egui::{Grid, Slider, Ui};

/// State of the panel.
#[derive(Clone, Debug, Default)]
pub struct ControlPanelState {
    /// The config during a drag: every change starts a new run, so it takes effect on release.
    dragged: Option<CrowdRunConfig>,
    /// State of the controls of a scene.
    scene: scene::SceneControlState,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut ControlPanelState, commands: &mut Commands) {
    if model.document.world().is_some() {
        ui.weak("The panel Patches gives orders to the characters of a world.");
        return ui.button("Open it").request(commands, ViewerCommand::TogglePanel(PanelKind::Patches));
    }
    if let Some(scene) = model.document.scene() {
        return scene::show(ui, model, scene, &mut state.scene, commands);
    }
    let OpenDocument::Bundle(document) = &model.document else {
        return drop(ui.weak("Open a bundle to run a crowd: drop it on the window, or File > Open."));
    };
    let run = match &document.run {
        Ok(run) => run,
        Err(why) => {
            ui.label(why);
            if document.blend.is_some() {
                ui.weak("Its characters are blended from examples. The panel Blend controls one of them.");
                ui.button("Open it").request(commands, ViewerCommand::TogglePanel(PanelKind::Blend));
            }
            return;
        }
    };
    let names = &document.bundle.tables().meta().behaviours;
    let weighed: Vec<&str> =
        run.simulation.goals.iter().map(|g| names.get(g.policy).map_or("behaviour", String::as_str)).collect();
    behaviours(ui, &weighed, run.weights(), 0, commands);
    if names.len() > weighed.len() {
        ui.weak(format!("The first {} of {} behaviours can be weighed.", weighed.len(), names.len()));
    }
    ui.add_space(8.0);
    target::show(ui, model, run, commands);
    ui.add_space(8.0);
    crowd::show(ui, run.config(), &mut state.dragged, commands);
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
