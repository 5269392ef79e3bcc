//! Agents of a scene: view options, figures, the selected agent, and events.

mod agent;
pub mod blackboards;
mod curves;
mod events;
mod graphs;

use super::colour_of_view;
use super::paint::{PanelWidget, empty, facts, section, swatch, time_text};
use crate::command::{Commands, OverlayScope, SceneCommand, SceneViewOptions, ViewerCommand};
use crate::{document::SceneDocument, model::Model, run::agents::first_agent, settings::ViewerSettings};
use crate::{stage::agents::colour_of_group, theme::ThemePalette};
use eframe::egui::{Grid, RichText, Role, Ui};
use throng_simulation::{AnyCharacterGroup, scenario::AgentBrains};

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
    show_overlays(ui, model, commands);
    section(ui, "Now", |ui| show_figures(ui, scene));
    section(ui, "Agent", |ui| agent::show(ui, model, scene, commands));
    if let Some(brains) = scene.run.simulation().brains() {
        section(ui, "Brain", |ui| agent::show_brain(ui, model, scene, brains));
        if !scene.run.simulation().scene().graphs.is_empty() {
            section(ui, "State graphs", |ui| graphs::show(ui, model, scene, brains));
        }
        if brains.has_events() {
            section(ui, "News", |ui| curves::show_messages(ui, model, scene, brains, commands));
            section(ui, "Blackboards", |ui| blackboards::show(ui, model, scene, brains, commands));
        }
    }
    section(ui, "Event rate", |ui| curves::show_rates(ui, model, scene, commands));
    section(ui, "Events", |ui| events::show(ui, model, scene, state, commands));
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

/// Shows the view options.
fn show_overlays(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let now = model.selection.scene;
    let (mut l, mut overlays) = (now, model.settings.overlays);
    Grid::new("drawn").num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
        scope_row(ui, "bounds", "Time-varying bounds: where an agent can be, whatever it does", &mut l.bounds);
        scope_row(ui, "paths", "Planned paths to goals", &mut l.paths);
        let trails = if overlays.trails && overlays.of_all { OverlayScope::All } else { OverlayScope::Selected };
        let mut trails = if overlays.trails { trails } else { OverlayScope::None };
        if scope_row(ui, "trails", "Where agents were in the last seconds", &mut trails) {
            overlays.trails = trails != OverlayScope::None;
            overlays.of_all = trails == OverlayScope::All;
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut l.cells, "cells").on_hover_text("Cell C, region R and the cells α(C) of the selected agent");
        ui.checkbox(&mut l.forces, "forces").on_hover_text("Each force of the selected agent, and its stop region");
        ui.checkbox(&mut l.marks, "marks").on_hover_text("Marks at events; they fade");
        if has_bodies(model) {
            ui.checkbox(&mut l.bodies, "bodies").on_hover_text("Bodies of agents, over their discs");
        }
    });
    if l != now {
        commands.push(options_command(model, |options| *options = l));
    }
    if overlays != model.settings.overlays {
        let settings = ViewerSettings { overlays, ..model.settings.clone() };
        commands.push(ViewerCommand::Settings(Box::new(settings)));
    }
}

/// A row of the grid: the agents for which something is drawn; true if one of the choices was clicked.
fn scope_row(ui: &mut Ui, name: &str, tip: &str, scope: &mut OverlayScope) -> bool {
    ui.label(name).on_hover_text(tip);
    let clicked = ui.horizontal(|ui| {
        OverlayScope::ALL.map(|(one, text)| {
            let label = ui.selectable_value(scope, one, text);
            label.named(Role::RadioButton, format!("{name}: {text}")).clicked()
        })
    });
    ui.end_row();
    clicked.inner.contains(&true)
}

/// True where some agent has a body.
fn has_bodies(model: &Model) -> bool {
    let Some(simulation) = model.document.scene().map(|s| s.run.simulation()) else { return false };
    (0..simulation.num_characters()).any(|who| simulation.disc(who).is_some() && simulation.pose(who).is_some())
}

/// Shows figures of the moment shown.
fn show_figures(ui: &mut Ui, scene: &SceneDocument) {
    let simulation = scene.run.simulation();
    let Some(f) = scene.run.figures().agents else { return };
    let discs = (0..simulation.num_characters()).filter_map(|who| simulation.disc(who));
    let speed = discs.map(|d| f64::from(d.velocity.length())).sum::<f64>() / f.present.max(1) as f64;
    let speeds: Vec<f64> = simulation.character_groups().iter().flat_map(desired_speeds).collect();
    let n = speeds.len();
    let desired = speeds.iter().sum::<f64>() / n.max(1) as f64;
    let palette = ThemePalette::for_visuals(ui.visuals());
    let good = |is_good: bool| if is_good { palette.good } else { palette.warning };
    facts(ui, "now", false, |row| {
        row("simulated", "Since the start of the scene", RichText::new(time_text(simulation.time_s())));
        let left = if f.present < n { format!(", {} have left", n - f.present) } else { String::new() };
        row("agents", "Who is there", RichText::new(format!("{}{left}", f.present)));
        let tip = "Mean speed along planned paths so far, of agents not yet at their goals";
        row("progress", tip, RichText::new(format!("{:.2} m/s, {desired:.2} wanted", f.progress_mps)));
        row("speed now", "Mean of all agents", RichText::new(format!("{speed:.2} m/s")));
        let overlaps = RichText::new(format!("{} pairs over 1 mm", f.overlaps)).color(good(f.overlaps == 0));
        row("overlaps", "Pairs that overlap now", overlaps);
        let deepest = if f.deepest_m > 0.0 { format!("{:.2} mm", 1e3 * f.deepest_m) } else { "none so far".into() };
        row("deepest", "The deepest overlap so far", RichText::new(deepest).color(good(f.deepest_m <= 1e-3)));
        row("arrived", "Agents that have reached their goals", RichText::new(format!("{} of {n}", f.arrived)));
        let stuck = RichText::new(f.stuck.to_string()).color(good(f.stuck == 0));
        row("stuck", "Agents that moved less than half a metre in 10 s on their way, or came no nearer in 20 s", stuck);
    });
}

/// Desired speeds of the agents among characters, at their start (m/s).
fn desired_speeds(group: &AnyCharacterGroup) -> Vec<f64> {
    match group {
        AnyCharacterGroup::Ground(agents) => agents.layout().setup.agents.iter().map(|a| f64::from(a.speed)).collect(),
        AnyCharacterGroup::Air(agents) => agents.layout().setup.agents.iter().map(|a| f64::from(a.speed)).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests;
