//! How the crowd is driven: behaviours and weights, targets, number of characters, seed.

use crate::command::Command;
use crate::document::Document;
use crate::model::Model;
use crate::run::{Input, MAX_CHARACTERS, MAX_TARGET_M, Run, RunConfig, TargetMode};
use eframe::egui::{self, ComboBox, DragValue, Grid, Slider, Ui};
use glam::Vec3;

/// What the panel remembers.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// The config as it is dragged to: every change is a new run, so it takes effect when it is let go.
    dragged: Option<RunConfig>,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut State, commands: &mut Vec<Command>) {
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
            return;
        }
    };
    behaviours(ui, bundle.tables().meta().behaviours.as_slice(), run, commands);
    ui.add_space(8.0);
    character(ui, model, run, commands);
    ui.add_space(8.0);
    crowd(ui, run.config(), state, commands);
}

fn behaviours(ui: &mut Ui, names: &[String], run: &Run, commands: &mut Vec<Command>) {
    ui.strong("Behaviours");
    ui.weak("What counts how much when an action is chosen; 0 switches a behaviour off.");
    let mut weights = run.weights().to_vec();
    Grid::new("weights").num_columns(2).show(ui, |ui| {
        for (weight, name) in weights.iter_mut().zip(names) {
            ui.label(name);
            ui.add(Slider::new(weight, 0.0..=2.0).step_by(0.05).fixed_decimals(2));
            ui.end_row();
        }
    });
    if names.len() > weights.len() {
        ui.weak(format!("The first {} of {} behaviours can be weighed.", weights.len(), names.len()));
    }
    if weights != run.weights() {
        commands.push(Command::Input(Input::Weights(weights)));
    }
}

fn character(ui: &mut Ui, model: &Model, run: &Run, commands: &mut Vec<Command>) {
    ui.strong("Target");
    let Some(c) = model.selection.character else {
        ui.horizontal_wrapped(|ui| {
            ui.weak("Click a character in the 3-D view, or");
            if ui.small_button("select character 0").clicked() {
                commands.push(Command::SelectCharacter(Some(0)));
            }
        });
        return;
    };
    let (root, target) = (run.troupe().root(c), run.targets()[c]);
    let mut to = target;
    ui.horizontal(|ui| {
        let mut number = c;
        ui.label("of character");
        let last = run.config().characters - 1;
        if ui.add(DragValue::new(&mut number).range(0..=last)).changed() {
            commands.push(Command::SelectCharacter(Some(number)));
        }
        ui.label("x");
        ui.add(
            DragValue::new(&mut to.x)
                .range(-MAX_TARGET_M..=MAX_TARGET_M)
                .update_while_editing(false)
                .speed(0.02)
                .suffix(" m")
                .fixed_decimals(2),
        );
        ui.label("z");
        ui.add(
            DragValue::new(&mut to.z)
                .range(-MAX_TARGET_M..=MAX_TARGET_M)
                .update_while_editing(false)
                .speed(0.02)
                .suffix(" m")
                .fixed_decimals(2),
        );
    });
    ui.label(format!("{:.2} m away", (root.x - target.x).hypot(root.z - target.z)));
    if to != target {
        let who = (run.config().targets != TargetMode::Shared).then_some(c);
        commands.push(Command::Input(Input::Target { character: who, to: Vec3::new(to.x, 0.0, to.z) }));
    }
    if ui.button("Everybody comes here").on_hover_text("All targets move to where this character stands").clicked() {
        let here = Vec3::new(root.x, 0.0, root.z);
        commands.push(Command::Input(Input::Target { character: None, to: here }));
    }
}

fn crowd(ui: &mut Ui, config: &RunConfig, state: &mut State, commands: &mut Vec<Command>) {
    ui.strong("Crowd");
    ui.weak("A change starts the run anew. The same numbers give the same run.");
    let mut c = state.dragged.unwrap_or(*config);
    let mut is_dragged = false;
    Grid::new("crowd").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
        let mut row = |ui: &mut Ui, name: &str, tip: &str, add: &mut dyn FnMut(&mut Ui) -> egui::Response| {
            ui.label(name).on_hover_text(tip);
            is_dragged |= add(ui).on_hover_text(tip).dragged();
            ui.end_row();
        };
        row(ui, "characters", "How many", &mut |ui| {
            ui.add(Slider::new(&mut c.characters, 1..=MAX_CHARACTERS).update_while_editing(false).logarithmic(true))
        });
        row(ui, "seed", "Of places, targets and choices", &mut |ui| {
            ui.add(DragValue::new(&mut c.seed).update_while_editing(false))
        });
        row(ui, "targets", "What targets do", &mut |ui| {
            let name = TargetMode::ALL.iter().find(|t| t.0 == c.targets).map_or("", |t| t.1);
            let combo = ComboBox::from_id_salt("targets").selected_text(name).show_ui(ui, |ui| {
                for (mode, name) in TargetMode::ALL {
                    ui.selectable_value(&mut c.targets, mode, name);
                }
            });
            combo.response
        });
        row(ui, "target distance", "Nearest and farthest a target stands", &mut |ui| {
            let [near, far] = &mut c.distances;
            let pair = ui.horizontal(|ui| {
                let a = ui
                    .add(DragValue::new(near).update_while_editing(false).speed(0.05).range(0.0..=100.0).suffix(" m"));
                ui.label("to");
                a | ui.add(DragValue::new(far).update_while_editing(false).speed(0.05).range(0.0..=100.0).suffix(" m"))
            });
            pair.inner
        });
        row(ui, "spacing", "Between neighbours at the start", &mut |ui| {
            ui.add(Slider::new(&mut c.spacing_m, 0.5..=10.0).update_while_editing(false).suffix(" m"))
        });
        row(ui, "reach", "A target counts as reached within this distance", &mut |ui| {
            ui.add(Slider::new(&mut c.reach_m, 0.1..=2.0).update_while_editing(false).suffix(" m"))
        });
        row(ui, "bend", "How far a walked action may be turned towards the target", &mut |ui| {
            ui.add(Slider::new(&mut c.bend_rad_per_m, 0.0..=1.0).update_while_editing(false).suffix(" rad/m"))
        });
        row(ui, "temperature", "Chance in the choice among the best actions; 0 takes the best", &mut |ui| {
            ui.add_enabled(!c.single_load, Slider::new(&mut c.temperature, 0.0..=1.0).update_while_editing(false))
        });
        row(ui, "single load", "Take the stored best action instead of looking ahead", &mut |ui| {
            ui.checkbox(&mut c.single_load, "")
        });
        row(ui, "foot lock", "Hold planted feet where they are", &mut |ui| ui.checkbox(&mut c.foot_lock, ""));
    });
    state.dragged = is_dragged.then_some(c);
    if c != *config && !is_dragged {
        commands.push(Command::Configure(c));
    }
}
