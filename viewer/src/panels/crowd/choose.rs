//! What runs, snapshots of it, and what is drawn of it.

use super::{State, colour, look, swatch};
use crate::command::{Command, CrowdCommand, Whose};
use crate::document::{CrowdChoice, CrowdDocument, MAX_MEMBERS};
use crate::model::Model;
use crate::settings::Settings;
use crate::stage::agents::colour_of_group;
use eframe::egui::{ComboBox, DragValue, Grid, Role, Slider, TextEdit, Ui, WidgetInfo};
use std::path::{Path, PathBuf};
use throng_precompute::scene::crowd::Engine;

/// What an engine is, in a sentence.
fn meaning(engine: Engine) -> &'static str {
    match engine {
        Engine::Events => "Bounds registered in cells: resetting and colliding events",
        Engine::Occupancy => "Bounds listed in every cell that they occupy, groups in contact",
        Engine::Fixed => "All agents act at every step: the baseline",
    }
}

/// Shows engine, number of agents and seed, and snapshots.
pub fn show(ui: &mut Ui, crowd: &CrowdDocument, state: &mut State, commands: &mut Vec<Command>) {
    ui.horizontal_wrapped(|ui| {
        ui.strong(format!("Scene {}", crowd.scene().name));
        let cast = crowd.run().cast();
        for (g, name) in cast.names.iter().enumerate() {
            swatch(ui, colour(colour_of_group(g)));
            ui.label(name);
        }
    });
    let now = crowd.beginning().unwrap_or(crowd.choice());
    let mut wanted = state.dragged.unwrap_or(now);
    let mut is_dragged = false;
    Grid::new("choice").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
        ui.label("engine").on_hover_text("How events are found and scheduled");
        let combo = ComboBox::from_id_salt("engine").selected_text(wanted.engine.name()).show_ui(ui, |ui| {
            for engine in Engine::ALL {
                ui.selectable_value(&mut wanted.engine, engine, engine.name()).on_hover_text(meaning(engine));
            }
        });
        combo.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "Engine"));
        combo.response.on_hover_text(meaning(wanted.engine));
        ui.end_row();
        let label = ui.label("agents").on_hover_text("A change restarts the scene; the file is not changed");
        let slider = Slider::new(&mut wanted.agents, 1..=MAX_MEMBERS).update_while_editing(false).logarithmic(true);
        is_dragged |= ui.add(slider).labelled_by(label.id).dragged();
        ui.end_row();
        let label = ui.label("seed").on_hover_text("Seed of starting places and variation");
        ui.horizontal(|ui| {
            let seed = DragValue::new(&mut wanted.seed).update_while_editing(false);
            is_dragged |= ui.add(seed).labelled_by(label.id).dragged();
            if ui.button("Restart").on_hover_text("With the same settings (R)").clicked() {
                commands.push(Command::Restart);
            }
            if crowd.beginning().is_some() {
                ui.spinner();
                ui.weak("is laid out");
            }
        });
        ui.end_row();
    });
    state.dragged = is_dragged.then_some(wanted);
    if !is_dragged && wanted != now {
        commands.push(Command::Crowd(CrowdCommand::Begin(wanted)));
    }
    snapshots(ui, crowd, state, commands);
}

fn snapshots(ui: &mut Ui, crowd: &CrowdDocument, state: &mut State, commands: &mut Vec<Command>) {
    if state.file.as_ref().is_none_or(|f| f.0 != crowd.path()) {
        state.file = Some((crowd.path().to_path_buf(), suggested(crowd.path()).display().to_string()));
    }
    let Some((_, file)) = &mut state.file else { return };
    ui.horizontal(|ui| {
        let save = ui.button("Save").on_hover_text("Save the state at the last step");
        let restore = ui.button("Restore").on_hover_text("Continue from a saved state");
        let field = ui.add(TextEdit::singleline(file).desired_width(f32::INFINITY));
        field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "Snapshot file"));
        let path = PathBuf::from(file.trim());
        if save.clicked() && !file.trim().is_empty() {
            commands.push(Command::Crowd(CrowdCommand::Save(path)));
        } else if restore.clicked() && !file.trim().is_empty() {
            commands.push(Command::Crowd(CrowdCommand::Restore(path)));
        }
    });
}

/// A file beside a scene's.
fn suggested(scene: &Path) -> PathBuf {
    scene.with_extension("crowd")
}

/// Shows what is drawn.
pub fn drawn(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let now = model.selection.crowd;
    let (mut l, mut overlays) = (now, model.settings.overlays);
    Grid::new("drawn").num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
        for (name, tip, whose) in [
            ("bounds", "Time-varying bounds: where an agent can be, whatever it does", &mut l.bounds),
            ("paths", "Planned paths to goals", &mut l.paths),
        ] {
            ui.label(name).on_hover_text(tip);
            ui.horizontal(|ui| {
                for (w, text) in Whose::ALL {
                    let r = ui.selectable_label(*whose == w, text);
                    r.widget_info(|| WidgetInfo::labeled(Role::RadioButton, true, format!("{name}: {text}")));
                    if r.clicked() {
                        *whose = w;
                    }
                }
            });
            ui.end_row();
        }
        ui.label("trails").on_hover_text("Where agents were in the last seconds");
        let trails = if overlays.trails && overlays.of_all { Whose::All } else { Whose::Selected };
        let trails = if overlays.trails { trails } else { Whose::Nobody };
        ui.horizontal(|ui| {
            for (w, text) in Whose::ALL {
                let r = ui.selectable_label(trails == w, text);
                r.widget_info(|| WidgetInfo::labeled(Role::RadioButton, true, format!("trails: {text}")));
                if r.clicked() {
                    overlays.trails = w != Whose::Nobody;
                    overlays.of_all = w == Whose::All;
                }
            }
        });
        ui.end_row();
    });
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut l.cells, "cells").on_hover_text("Cell C, region R and the cells α(C) of the selected agent");
        ui.checkbox(&mut l.forces, "forces").on_hover_text("Each force of the selected agent, and its stop region");
        ui.checkbox(&mut l.marks, "marks").on_hover_text("Marks at events; they fade");
        if let Some(bundle) = model.document.crowd_scene().and_then(|c| c.bundle()) {
            let tip = format!("Blended from the examples of {}", bundle.path().display());
            ui.checkbox(&mut l.bodies, "bodies").on_hover_text(tip);
        }
    });
    if l != now {
        commands.push(look(model, |look| *look = l));
    }
    if overlays != model.settings.overlays {
        let settings = Settings { overlays, ..model.settings.clone() };
        commands.push(Command::Settings(Box::new(settings)));
    }
}

/// Number of agents and seed in words, for the bar at the top.
pub fn in_words(choice: CrowdChoice) -> String {
    format!("{} agents · {} · seed {}", choice.agents, choice.engine.name(), choice.seed)
}
