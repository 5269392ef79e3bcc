//! Settings of a crowd.

use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::choose;
use crate::run::{CrowdRunConfig, MAX_CHARACTERS, TargetMode};
use eframe::egui::{self, DragValue, Grid, Slider, Ui};

/// Shows the settings of a crowd.
///
/// - `dragged`: the config during a drag.
pub fn show(ui: &mut Ui, config: &CrowdRunConfig, dragged: &mut Option<CrowdRunConfig>, commands: &mut Commands) {
    ui.strong("Crowd");
    ui.weak("A change restarts the run. The same settings give the same run.");
    let mut c = dragged.unwrap_or(*config);
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
        row(ui, "seed", "Seed of starting places, targets and choices", &mut |ui| {
            ui.add(DragValue::new(&mut c.seed).update_while_editing(false))
        });
        row(ui, "targets", "What targets do", &mut |ui| {
            choose(ui, "targets", None, &mut c.targets, TargetMode::ALL.map(|(mode, name)| (mode, name.to_owned())))
        });
        row(ui, "target distance", "Nearest and farthest a target stands", &mut |ui| {
            let fields = c.distances.each_mut().map(DragValue::new);
            let [near, far] = fields.map(|f| f.update_while_editing(false).speed(0.05).range(0.0..=100.0).suffix(" m"));
            let pair = ui.horizontal(|ui| {
                let near = ui.add(near);
                ui.label("to");
                near | ui.add(far)
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
        row(ui, "temperature", "Randomness of the choice among the best actions; 0 takes the best", &mut |ui| {
            ui.add_enabled(!c.single_load, Slider::new(&mut c.temperature, 0.0..=1.0).update_while_editing(false))
        });
        row(ui, "single load", "Take the stored best action instead of looking ahead", &mut |ui| {
            ui.checkbox(&mut c.single_load, "")
        });
        row(ui, "make way", "Nobody walks through anybody", &mut |ui| ui.checkbox(&mut c.avoid, ""));
        row(ui, "foot lock", "Hold planted feet where they are", &mut |ui| ui.checkbox(&mut c.foot_lock, ""));
    });
    *dragged = is_dragged.then_some(c);
    if c != *config && !is_dragged {
        commands.push(ViewerCommand::Configure(c));
    }
}
