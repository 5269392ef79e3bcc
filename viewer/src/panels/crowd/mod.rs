//! Agents of a scene: view options, figures, the selected agent, and events.

mod agent;
pub mod blackboards;
mod events;
mod figures;
mod graphs;
mod message_spread;
mod overlays;
mod rates;

use super::colour_of_view;
use super::paint::{empty, swatch};
use crate::command::{Commands, SceneCommand, SceneViewOptions, ViewerCommand};
use crate::document::SceneDocument;
use crate::model::Model;
use crate::run::agents::first_agent;
use crate::stage::agents::colour_of_group;
use eframe::egui::{CollapsingHeader, RichText, Ui};
use throng_simulation::scenario::AgentBrains;

/// State of the panel.
#[derive(Clone, Debug, Default)]
pub struct CrowdPanelState {
    /// Only events of the selected agent are listed.
    only_selected: bool,
    /// Only events about the place, or the message, of this number are listed.
    place: Option<usize>,
    message: Option<usize>,
}

const NO_SCENE: &str = "Scenes of agents need no bundle: data/scenes/corridor.toml, circle.toml, ring.toml, \
     bottleneck.toml, square.toml, flock.toml.";

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut CrowdPanelState, commands: &mut Commands) {
    let Some(scene) = model.document.scene().filter(|s| first_agent(s.run.simulation()).is_some()) else {
        return empty(ui, "No scene with agents is open", NO_SCENE);
    };
    ui.horizontal_wrapped(|ui| {
        for (g, group) in scene.run.simulation().groups().iter().enumerate() {
            swatch(ui, colour_of_view(colour_of_group(g)));
            ui.label(&group.name);
        }
    });
    overlays::show(ui, model, commands);
    section(ui, "Now", |ui| figures::show(ui, scene));
    section(ui, "Agent", |ui| agent::show(ui, model, scene, commands));
    if let Some(brains) = scene.run.simulation().brains() {
        section(ui, "Brain", |ui| agent::show_brain(ui, model, scene, brains));
        if !scene.run.simulation().scene().graphs.is_empty() {
            section(ui, "State graphs", |ui| graphs::show(ui, model, scene, brains));
        }
        if brains.has_events() {
            section(ui, "News", |ui| message_spread::show(ui, model, scene, brains, commands));
            section(ui, "Blackboards", |ui| blackboards::show(ui, model, scene, brains, commands));
        }
    }
    section(ui, "Event rate", |ui| rates::show(ui, model, scene, commands));
    section(ui, "Events", |ui| events::show(ui, model, scene, state, commands));
}

fn section(ui: &mut Ui, title: &str, add: impl FnOnce(&mut Ui)) {
    ui.add_space(2.0);
    CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show(ui, add);
}

/// Number of the selected agent among those with brains; none without one.
fn selected_brain(model: &Model, scene: &SceneDocument, brains: &AgentBrains) -> Option<usize> {
    let first = first_agent(scene.run.simulation()).unwrap_or(0);
    model.selection.character.and_then(|who| who.checked_sub(first)).filter(|a| *a < brains.len())
}

/// Name of an agent, for people.
fn agent_name(scene: &SceneDocument, agent: usize) -> String {
    let groups = scene.run.simulation().groups();
    match groups.iter().find(|g| g.characters.contains(&agent)) {
        Some(group) if groups.len() > 1 => format!("{agent} ({})", group.name),
        _ => agent.to_string(),
    }
}

/// Draws more or less.
fn options_command(model: &Model, change: impl FnOnce(&mut SceneViewOptions)) -> ViewerCommand {
    let mut options = model.selection.scene;
    change(&mut options);
    ViewerCommand::Scene(SceneCommand::SetOptions(options))
}

#[cfg(test)]
mod tests;
