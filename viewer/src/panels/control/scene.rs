//! What a scene is made of.

use crate::command::Command;
use crate::run::MAX_CHARACTERS;
use eframe::egui::{Button, DragValue, Grid, Response, Slider, Ui};
use throng_precompute::scene::{Scene, SceneKind};

/// Shows what a scene is made of.
///
/// - `dragged`: the scene as it is dragged to.
pub fn show(ui: &mut Ui, scene: &Scene, dragged: &mut Option<Box<Scene>>, commands: &mut Vec<Command>) {
    ui.strong(format!("Scene {}", scene.name));
    ui.weak("A change restarts the scene; the file is not changed.");
    let mut s = dragged.as_deref().unwrap_or(scene).clone();
    let of_pairs = s.kind == SceneKind::Pairs;
    let mut is_dragged = false;
    Grid::new("scene").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
        let mut row = |ui: &mut Ui, name: &str, tip: &str, add: &mut dyn FnMut(&mut Ui) -> Response| {
            ui.label(name).on_hover_text(tip);
            is_dragged |= add(ui).on_hover_text(tip).dragged();
            ui.end_row();
        };
        if of_pairs {
            let mut pairs = s.characters / 2;
            row(ui, "pairs", "Number of pairs; characters 2i and 2i + 1 are opponents", &mut |ui| {
                ui.add(Slider::new(&mut pairs, 1..=MAX_CHARACTERS / 2).update_while_editing(false).logarithmic(true))
            });
            s.characters = 2 * pairs;
        } else {
            row(ui, "characters", "Number of characters, each with its own target", &mut |ui| {
                let slider = Slider::new(&mut s.characters, 1..=MAX_CHARACTERS);
                ui.add(slider.update_while_editing(false).logarithmic(true))
            });
        }
        row(ui, "seed", "Seed of starting places and choices", &mut |ui| {
            ui.add(DragValue::new(&mut s.seed).update_while_editing(false))
        });
        let apart = if of_pairs { "Between opponents at the start" } else { "Between a character and its target" };
        row(ui, "distance", apart, &mut |ui| {
            ui.add(Slider::new(&mut s.distance_m, 0.5..=6.0).update_while_editing(false).suffix(" m"))
        });
        row(ui, "spacing", "Between neighbours' places", &mut |ui| {
            ui.add(Slider::new(&mut s.spacing_m, 1.0..=20.0).update_while_editing(false).suffix(" m"))
        });
        row(ui, "temperature", "Randomness of the choice among the best actions; 0 takes the best", &mut |ui| {
            ui.add(Slider::new(&mut s.temperature, 0.0..=1.0).update_while_editing(false))
        });
        if !of_pairs {
            row(ui, "target height", "Height of the middle of the targets", &mut |ui| {
                ui.add(Slider::new(&mut s.target.height_m, 0.2..=2.2).update_while_editing(false).suffix(" m"))
            });
        }
    });
    if !of_pairs && !s.target.drag.is_empty() {
        let tip = "The scene moves its targets; a target that you move stays there";
        if ui.add(Button::new("Hold targets still")).on_hover_text(tip).clicked() {
            s.target.drag.clear();
        }
    }
    *dragged = is_dragged.then(|| Box::new(s.clone()));
    if s != *scene && !is_dragged {
        commands.push(Command::ConfigureScene(Box::new(s)));
    }
}
