//! Scenes of crowds: engine, number of agents, what is drawn, figures, the selected agent, and what happens.

mod agent;
mod choose;
mod events;
mod figures;
mod rates;

use super::paint::empty;
use crate::command::{Command, CrowdCommand, CrowdLook};
use crate::document::{CrowdChoice, CrowdDocument};
use crate::model::Model;
use crate::render::Rgba;
use eframe::egui::{CollapsingHeader, Color32, RichText, Sense, Ui, vec2};
use std::path::PathBuf;

pub use choose::in_words;

/// What the panel remembers.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Engine, number of agents and seed as they are dragged to.
    dragged: Option<CrowdChoice>,
    /// File of a snapshot as it was typed, and the scene that it is for.
    file: Option<(PathBuf, String)>,
    /// Only events of the selected agent are listed.
    only_selected: bool,
}

const NO_SCENE: &str = "Scenes of crowds need no bundle: data/scenes/corridor.toml, circle.toml, ring.toml, \
     bottleneck.toml, square.toml, flock.toml.";

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut State, commands: &mut Vec<Command>) {
    let Some(crowd) = model.document.crowd_scene() else {
        return empty(ui, "No scene of a crowd is open", NO_SCENE);
    };
    choose::show(ui, crowd, state, commands);
    ui.separator();
    choose::drawn(ui, model, commands);
    section(ui, "Now", |ui| figures::show(ui, crowd));
    section(ui, "Agent", |ui| agent::show(ui, model, crowd, commands));
    section(ui, "Event rate", |ui| rates::show(ui, model, crowd, commands));
    section(ui, "Events", |ui| events::show(ui, model, crowd, state, commands));
}

fn section(ui: &mut Ui, title: &str, add: impl FnOnce(&mut Ui)) {
    ui.add_space(2.0);
    CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show(ui, add);
}

/// A colour of the view for a panel.
fn colour(c: Rgba) -> Color32 {
    let [r, g, b, _] = c.0;
    Color32::from_rgb(r, g, b)
}

/// A small square that says which colour something has in the view.
fn swatch(ui: &mut Ui, colour: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, colour);
}

/// Name of an agent, for people.
fn who(crowd: &CrowdDocument, agent: usize) -> String {
    let cast = crowd.run().cast();
    match cast.groups.get(agent) {
        Some(&g) if cast.names.len() > 1 => format!("{agent} ({})", cast.names[g]),
        _ => agent.to_string(),
    }
}

/// Draws more or less.
fn look(model: &Model, change: impl FnOnce(&mut CrowdLook)) -> Command {
    let mut look = model.selection.crowd;
    change(&mut look);
    Command::Crowd(CrowdCommand::Look(look))
}

#[cfg(test)]
mod tests;
