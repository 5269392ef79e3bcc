//! A scene of walkers: how many, and the seed of their bodies and paths.

use crate::command::Command;
use crate::document::WalkersDocument;
use crate::run::MAX_CHARACTERS;
use eframe::egui::{DragValue, Grid, Slider, Ui};

/// Shows what a scene of walkers is made of.
///
/// - `dragged`: number of characters and seed as they are dragged to.
pub fn show(ui: &mut Ui, walkers: &WalkersDocument, dragged: &mut Option<(usize, u64)>, commands: &mut Vec<Command>) {
    let scene = walkers.scene();
    ui.strong(format!("Scene {}", scene.name));
    ui.weak("A change restarts the scene; the file is not changed.");
    let (mut characters, mut seed) = dragged.unwrap_or((scene.characters, scene.seed));
    let mut is_dragged = false;
    Grid::new("walkers").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
        ui.label("characters");
        let slider = Slider::new(&mut characters, 1..=MAX_CHARACTERS).update_while_editing(false).logarithmic(true);
        is_dragged |= ui.add(slider).dragged();
        ui.end_row();
        ui.label("seed").on_hover_text("Seed of bodies and paths");
        is_dragged |= ui.add(DragValue::new(&mut seed).update_while_editing(false)).dragged();
        ui.end_row();
        for (name, text) in facts(walkers) {
            ui.label(name);
            ui.label(text);
            ui.end_row();
        }
    });
    *dragged = is_dragged.then_some((characters, seed));
    if !is_dragged && (characters, seed) != (scene.characters, scene.seed) {
        commands.push(Command::Walkers { characters, seed });
    }
}

/// What else the file says, and their speeds now.
fn facts(walkers: &WalkersDocument) -> Vec<(&'static str, String)> {
    let (scene, speeds) = (walkers.scene(), &walkers.run().moment().speeds);
    let mean = speeds.iter().sum::<f32>() / speeds.len().max(1) as f32;
    let most = speeds.iter().copied().fold(0.0, f32::max);
    let [smallest, largest] = scene.bodies.sizes;
    vec![
        ("blend spaces", scene.spaces.join(", ")),
        ("bodies", format!("{} kinds, sizes {smallest} to {largest}", scene.bodies.kinds)),
        ("speeds now", format!("{mean:.1} m/s on average, {most:.1} at most")),
    ]
}
