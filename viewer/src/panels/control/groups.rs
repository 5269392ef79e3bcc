//! A scene of groups: who is there, how many, the seed, and what has happened.

use crate::command::Command;
use crate::document::{MAX_CHARACTERS, SceneChoice, SceneDocument};
use crate::panels::words;
use eframe::egui::{DragValue, Grid, Slider, Ui};
use throng_runtime::simulation::{Event, Group, Happened, Simulation};
use throng_runtime::sparring::Part;

/// Events that are listed.
const MAX_EVENTS: usize = 12;

/// Shows the groups of a scene, what can be changed of it, and its last events.
///
/// - `dragged`: numbers while they are dragged.
pub fn show(
    ui: &mut Ui,
    scene: &SceneDocument,
    selected: Option<usize>,
    dragged: &mut Option<SceneChoice>,
    commands: &mut Vec<Command>,
) {
    ui.strong(format!("Scene {}", scene.scene().name));
    ui.weak("A change restarts the scene; the file is not changed.");
    choose(ui, scene, dragged, commands);
    ui.add_space(8.0);
    let simulation = scene.run().simulation();
    groups(ui, simulation);
    ui.add_space(8.0);
    ui.strong("Selected");
    match selected.and_then(|who| words::character(simulation, who)) {
        Some(text) => ui.label(text),
        None => ui.weak("Click a character or an agent in the 3-D view."),
    };
    ui.add_space(8.0);
    ui.strong("Last events");
    let mut events = scene.run().events().take(MAX_EVENTS).peekable();
    if events.peek().is_none() {
        ui.weak("Nothing has happened yet.");
    }
    for event in events {
        if ui.link(told(event)).on_hover_text("Select this character").clicked() {
            commands.push(Command::SelectCharacter(Some(event.who)));
        }
    }
}

fn choose(ui: &mut Ui, scene: &SceneDocument, dragged: &mut Option<SceneChoice>, commands: &mut Vec<Command>) {
    let now = scene.restarting().unwrap_or(scene.choice());
    let mut wanted = dragged.unwrap_or(now);
    let mut is_dragged = false;
    Grid::new("choice").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
        let label = ui.label("characters").on_hover_text("Of all groups, each with its share");
        let slider =
            Slider::new(&mut wanted.characters, 1..=MAX_CHARACTERS).update_while_editing(false).logarithmic(true);
        is_dragged |= ui.add(slider).labelled_by(label.id).dragged();
        ui.end_row();
        let label = ui.label("seed").on_hover_text("Of places, paths and choices");
        ui.horizontal(|ui| {
            let seed = DragValue::new(&mut wanted.seed).update_while_editing(false);
            is_dragged |= ui.add(seed).labelled_by(label.id).dragged();
            if ui.button("Restart").on_hover_text("With the same settings (R)").clicked() {
                commands.push(Command::Restart);
            }
            if scene.restarting().is_some() {
                ui.spinner();
            }
        });
        ui.end_row();
    });
    *dragged = is_dragged.then_some(wanted);
    if !is_dragged && wanted != now {
        commands.push(Command::RestartScene(wanted));
    }
}

fn groups(ui: &mut Ui, simulation: &Simulation) {
    Grid::new("groups").num_columns(3).striped(true).spacing([12.0, 4.0]).show(ui, |ui| {
        ui.strong("group");
        ui.strong("motion");
        ui.strong("present");
        ui.end_row();
        for group in simulation.groups() {
            ui.label(&group.name);
            ui.label(group.motion.name());
            ui.label(format!("{} of {}", present(simulation, group), group.characters.len()));
            ui.end_row();
        }
    });
}

fn present(simulation: &Simulation, group: &Group) -> usize {
    group.characters.clone().filter(|&who| simulation.root(who).is_some()).count()
}

/// An event in words.
fn told(event: &Event) -> String {
    let what = match event.happened {
        Happened::Hit { .. } => "hit its target".to_owned(),
        Happened::Struck { opponent, part: Part::Arm, .. } => format!("was blocked by {opponent}"),
        Happened::Struck { opponent, .. } => format!("hit {opponent}"),
        Happened::Fulfilled => "did what it wanted".to_owned(),
        Happened::Arrived => "arrived at its goal".to_owned(),
        Happened::Left => "left at its goal".to_owned(),
        Happened::Stuck => "makes no progress".to_owned(),
        Happened::RunInto { obstacle } => format!("was run into by obstacle {obstacle}"),
    };
    format!("{:.2} s  {} {what}", event.time_s, event.who)
}
