//! Control of the scene: behaviours and weights, targets, number of characters, seed, saved states.

use crate::command::{Commands, SceneCommand, SteerCommand, ViewerCommand};
use crate::document::{MAX_SCENE_CHARACTERS, OpenDocument, SceneChoice, SceneDocument};
use crate::panels::paint::{PanelWidget, coordinates};
use crate::panels::{character_field, offer_first_character, words};
use crate::run::{MAX_TARGET_M, RunInput, target_home};
use crate::{model::Model, settings::PanelKind};
use eframe::egui::{ComboBox, DragValue, Grid, Role, Slider, TextEdit, Ui};
use glam::Vec3;
use std::path::PathBuf;
use throng_crowd::Scheme;
use throng_simulation::{AnyCharacterGroup, CharacterEvent, Simulation, SimulationEvent};
use throng_simulation::{scene::engine, sparring::StruckPart};

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut SceneControlState, commands: &mut Commands) {
    if model.document.world().is_some() {
        ui.weak("The panel Patches gives orders to the characters of a world.");
        return ui.button("Open it").request(commands, ViewerCommand::TogglePanel(PanelKind::Patches));
    }
    if let Some(scene) = model.document.scene() {
        return show_scene(ui, model, scene, state, commands);
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

/// Events that are listed.
const MAX_EVENTS: usize = 12;

/// State of the controls of a scene.
#[derive(Clone, Debug, Default)]
pub struct SceneControlState {
    /// Numbers as they are dragged to.
    dragged: Option<SceneChoice>,
    /// File of a saved state as typed, and the scene that it belongs to.
    file: Option<(PathBuf, String)>,
}

/// Shows the groups of a scene, its settings, and its last events.
fn show_scene(
    ui: &mut Ui,
    model: &Model,
    scene: &SceneDocument,
    state: &mut SceneControlState,
    commands: &mut Commands,
) {
    let title = if scene.is_crowd { "Crowd of" } else { "Scene" };
    ui.strong(format!("{title} {}", scene.scene.name));
    ui.weak("A change restarts the run; the file is not changed.");
    scene_choice(ui, scene, &mut state.dragged, commands);
    saved(ui, scene, state, commands);
    ui.add_space(8.0);
    let simulation = scene.run.simulation();
    groups(ui, simulation);
    ui.add_space(8.0);
    selected(ui, model, scene, commands);
    ui.add_space(8.0);
    ui.strong("Last events");
    let mut events = scene.run.events().take(MAX_EVENTS).peekable();
    if events.peek().is_none() {
        ui.weak("Nothing has happened yet.");
    }
    for event in events {
        let link = ui.link(event_text(event)).on_hover_text("Select this character");
        link.request(commands, ViewerCommand::SelectCharacter(Some(event.who)));
    }
}

/// Shows the selected character, and the orders that it can be given.
fn selected(ui: &mut Ui, model: &Model, scene: &SceneDocument, commands: &mut Commands) {
    let simulation = scene.run.simulation();
    let who = model.selection.character.filter(|&who| who < simulation.num_characters());
    ui.strong("Selected");
    let Some((who, text)) = who.and_then(|who| Some((who, words::character(simulation, who)?))) else {
        return offer_first_character(ui, "Click a character or an agent in the 3-D view, or", true, commands);
    };
    ui.horizontal_wrapped(|ui| {
        character_field(ui, who, simulation.num_characters(), commands);
        ui.label(text);
    });
    if let Some((root, home)) = simulation.root(who).zip(target_home(simulation, who)) {
        show_target(ui, model, who, home, root.translation(), commands);
    }
    match simulation.locate(who) {
        (AnyCharacterGroup::Sparring(_), member) => {
            let opponent = who - member + (member ^ 1);
            ui.small_button("select its opponent").request(commands, ViewerCommand::SelectCharacter(Some(opponent)));
        }
        (AnyCharacterGroup::Patches(people), member) if people.is_ordered(member) => {
            let let_go = ui.button("Let go").on_hover_text("It decides for itself again");
            let_go.request(commands, ViewerCommand::Input(RunInput::Goal { character: who, goal: None }));
        }
        (AnyCharacterGroup::Patches(_), _) => _ = ui.weak("Ctrl and a click send it to a place."),
        _ => {}
    }
    if let Some((names, weights)) = scene.weights(who) {
        behaviours(ui, &names, weights, who, commands);
    }
}

fn scene_choice(ui: &mut Ui, scene: &SceneDocument, dragged: &mut Option<SceneChoice>, commands: &mut Commands) {
    let now = scene.restarting().unwrap_or(scene.choice);
    let mut wanted = dragged.unwrap_or(now);
    let mut is_dragged = false;
    Grid::new("choice").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
        if scene.scene.groups.iter().any(|g| g.is_of_agents()) {
            ui.label("engine").on_hover_text("How the events of agents are found and scheduled");
            let combo = ComboBox::from_id_salt("engine").selected_text(engine::name(wanted.engine)).show_ui(ui, |ui| {
                for &(name, scheme) in engine::ALL {
                    ui.selectable_value(&mut wanted.engine, scheme, name).on_hover_text(meaning(scheme));
                }
            });
            combo.response.named(Role::ComboBox, "Engine").on_hover_text(meaning(wanted.engine));
            ui.end_row();
        }
        let label = ui.label("characters").on_hover_text("Of all groups, each with its share");
        let slider =
            Slider::new(&mut wanted.characters, 1..=MAX_SCENE_CHARACTERS).update_while_editing(false).logarithmic(true);
        is_dragged |= ui.add(slider).labelled_by(label.id).dragged();
        ui.end_row();
        let label = ui.label("seed").on_hover_text("Of places, paths and choices");
        ui.horizontal(|ui| {
            let seed = DragValue::new(&mut wanted.seed).update_while_editing(false);
            is_dragged |= ui.add(seed).labelled_by(label.id).dragged();
            let restart = ui.button("Restart").on_hover_text("With the same settings (R)");
            restart.request(commands, ViewerCommand::Restart);
            if scene.restarting().is_some() {
                ui.spinner();
            }
        });
        ui.end_row();
    });
    *dragged = is_dragged.then_some(wanted);
    if !is_dragged && wanted != now {
        commands.push(ViewerCommand::Scene(SceneCommand::Restart(wanted)));
    }
}

/// Description of an engine, in a sentence.
fn meaning(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::Registration => "Bounds registered in cells: resetting and colliding events",
        Scheme::Occupancy => "Bounds listed in every cell that they occupy, groups in contact",
    }
}

/// Saves the state at the step shown, and goes on from a saved one.
fn saved(ui: &mut Ui, scene: &SceneDocument, state: &mut SceneControlState, commands: &mut Commands) {
    if state.file.as_ref().is_none_or(|f| f.0 != scene.path) {
        let suggested = scene.path.with_extension("state");
        state.file = Some((scene.path.clone(), suggested.display().to_string()));
    }
    let Some((_, file)) = &mut state.file else { return };
    ui.horizontal(|ui| {
        let save = ui.button("Save").on_hover_text("Save the state at the step shown");
        let restore = ui.button("Restore").on_hover_text("Continue from a saved state");
        ui.add(TextEdit::singleline(file).desired_width(f32::INFINITY)).named(Role::TextInput, "Snapshot file");
        if !file.trim().is_empty() {
            let path = PathBuf::from(file.trim());
            save.request(commands, ViewerCommand::Scene(SceneCommand::Save(path.clone())));
            restore.request(commands, ViewerCommand::Scene(SceneCommand::Restore(path)));
        }
    });
}

fn groups(ui: &mut Ui, simulation: &Simulation) {
    Grid::new("groups").num_columns(3).striped(true).spacing([12.0, 4.0]).show(ui, |ui| {
        ["group", "motion", "present"].into_iter().for_each(|title| _ = ui.strong(title));
        ui.end_row();
        for group in simulation.groups() {
            ui.label(&group.name);
            ui.label(group.motion.name());
            let num_present = group.characters.clone().filter(|&who| simulation.root(who).is_some()).count();
            ui.label(format!("{num_present} of {}", group.characters.len()));
            ui.end_row();
        }
    });
}

/// An event in words.
fn event_text(event: &SimulationEvent) -> String {
    let what = match event.kind {
        CharacterEvent::Hit { .. } => "hit its target".to_owned(),
        CharacterEvent::Struck { opponent, part: StruckPart::Arm, .. } => format!("was blocked by {opponent}"),
        CharacterEvent::Struck { opponent, .. } => format!("hit {opponent}"),
        CharacterEvent::Fulfilled => "did what it wanted".to_owned(),
        CharacterEvent::Arrived => "arrived at its goal".to_owned(),
        CharacterEvent::Left => "left at its goal".to_owned(),
        CharacterEvent::Stuck => "makes no progress".to_owned(),
        CharacterEvent::RunInto { obstacle } => format!("was run into by obstacle {obstacle}"),
    };
    format!("{:.2} s  {} {what}", event.time_s, event.who)
}

/// Shows the position of the target of a character, and lets it be moved; lets the character be steered.
///
/// - `home`: position of the target; `at`: position of the character (m).
fn show_target(ui: &mut Ui, model: &Model, who: usize, home: Vec3, at: Vec3, commands: &mut Commands) {
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

#[cfg(test)]
mod tests;
