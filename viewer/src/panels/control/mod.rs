//! How the crowd or the scene is driven: behaviours and weights, targets, number of characters, seed.

mod crowd;
mod groups;
mod scene;
mod target;
mod walkers;

use crate::command::Command;
use crate::document::{Document, SceneChoice};
use crate::model::Model;
use crate::run::{Input, Run, RunConfig};
use crate::settings::PanelKind;
use eframe::egui::{Grid, Slider, Ui};
use throng_precompute::scene::Scene;

/// What the panel remembers.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// The config as it is dragged to: every change is a new run, so it takes effect when it is let go.
    dragged: Option<RunConfig>,
    /// The same of a scene.
    dragged_scene: Option<Box<Scene>>,
    /// Number and seed of a scene of walkers.
    dragged_walkers: Option<(usize, u64)>,
    /// Numbers of a scene of groups.
    dragged_groups: Option<SceneChoice>,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut State, commands: &mut Vec<Command>) {
    if model.document.world().is_some() {
        ui.weak("The panel Patches gives orders to the characters of a world.");
        if ui.button("Open it").clicked() {
            commands.push(Command::TogglePanel(PanelKind::Patches));
        }
        return;
    }
    if let Some(scene) = model.document.simulated() {
        return groups::show(ui, scene, model.selection.character, &mut state.dragged_groups, commands);
    }
    if let Some(scene) = model.document.walkers() {
        return walkers::show(ui, scene, &mut state.dragged_walkers, commands);
    }
    if model.document.crowd_scene().is_some() {
        ui.weak("The panel Crowd controls this scene.");
        if ui.button("Open it").clicked() {
            commands.push(Command::TogglePanel(PanelKind::Crowd));
        }
        return;
    }
    let Some(bundle) = model.document.bundle() else {
        ui.weak("Open a bundle to run a crowd: drop it on the window, or File > Open.");
        return;
    };
    let run = match &model.document {
        Document::Bundle(b) => &b.run,
        _ => return,
    };
    let run = match run {
        Ok(run) => run,
        Err(why) => {
            ui.label(why);
            if model.document.blend().is_some() {
                ui.weak("Its characters are blended from examples. The panel Blend controls one of them.");
                if ui.button("Open it").clicked() {
                    commands.push(Command::TogglePanel(PanelKind::Blend));
                }
            }
            return;
        }
    };
    behaviours(ui, bundle.tables().meta().behaviours.as_slice(), run, commands);
    ui.add_space(8.0);
    target::show(ui, model, run, commands);
    ui.add_space(8.0);
    match model.document.scene() {
        Some(file) => scene::show(ui, &file.scene, &mut state.dragged_scene, commands),
        None => crowd::show(ui, run.config(), &mut state.dragged, commands),
    }
}

fn behaviours(ui: &mut Ui, names: &[String], run: &Run, commands: &mut Vec<Command>) {
    ui.strong("Behaviours");
    ui.weak("Weight of each behaviour when an action is chosen; 0 switches it off.");
    let mut weights = run.weights().to_vec();
    // A scene may weigh more.
    let most = weights.iter().fold(2.0, |most: f32, w| most.max(2.0 * w));
    Grid::new("weights").num_columns(2).show(ui, |ui| {
        for (weight, goal) in weights.iter_mut().zip(run.goals()) {
            ui.label(names.get(goal.policy).map_or("behaviour", String::as_str));
            ui.add(Slider::new(weight, 0.0..=most).step_by(0.05).fixed_decimals(2));
            ui.end_row();
        }
    });
    if run.scene().is_none() && names.len() > weights.len() {
        ui.weak(format!("The first {} of {} behaviours can be weighed.", weights.len(), names.len()));
    }
    if weights != run.weights() {
        commands.push(Command::Input(Input::Weights(weights)));
    }
}
