//! Tasks of limbs: steps, planned motions, their trees over time, and movable things and places.

#[cfg(test)]
mod tests;
mod timeline;

use crate::command::{Commands, PlanCommand, PlanViewOptions, ViewerCommand};
use crate::document::{PlannedMotion, TaskDocument};
use crate::model::Model;
use crate::panels::paint::{PanelWidget, choose, coordinates};
use crate::theme::ThemePalette;
use eframe::egui::{Button, DragValue, ProgressBar, RichText, ScrollArea, TextEdit, Ui};
use std::path::PathBuf;

/// Most motions that are planned at once.
const MOST: u64 = 20;

/// State of the panel.
#[derive(Clone, Debug, Default)]
pub struct PlanPanelState {
    /// Vertical axis of the plot over time: number of its direction.
    along: usize,
    /// Files that a motion and the task are written to, as they were typed.
    file: Option<String>,
    task: Option<String>,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut PlanPanelState, commands: &mut Commands) {
    let Some(task) = model.document.task() else {
        ui.weak("Open a task of limbs: data/tasks/*.toml. Things and places can be dragged in the view then.");
        return;
    };
    let options = model.selection.plan;
    let mut wanted = options;
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        steps(ui, task, &mut wanted, commands);
        ui.separator();
        planning(ui, task, &mut wanted, commands);
        ui.separator();
        show_motions(ui, task, &mut wanted, commands);
        ui.separator();
        commands.extend(timeline::show(ui, model, &mut state.along, &mut wanted).map(ViewerCommand::Seek));
        ui.separator();
        show_handle(ui, model, task, &mut wanted, commands);
        ui.separator();
        save(ui, task, state, commands);
    });
    if wanted != options {
        commands.push(ViewerCommand::Plan(PlanCommand::SetOptions(wanted)));
    }
}

/// Shows the steps of the task, and their results.
fn steps(ui: &mut Ui, task: &TaskDocument, wanted: &mut PlanViewOptions, commands: &mut Commands) {
    let palette = ThemePalette::for_visuals(ui.visuals());
    let (windows, rate_hz) = (task.task().windows_s(), task.frames().1);
    let motion = task.shown_motion();
    ui.strong("To do");
    for (i, name) in task.task().step_names().enumerate() {
        let done = motion.and_then(|m| m.outcome.done.get(i));
        let (mark, colour) = match done {
            None => ("·", ui.visuals().weak_text_color()),
            Some(d) if d.reason.is_none() => ("✔", palette.good),
            Some(_) => ("✖", ui.visuals().error_fg_color),
        };
        let at_s = task.task().times_s()[i];
        ui.horizontal(|ui| {
            ui.label(RichText::new(mark).color(colour));
            let is_on = wanted.step == Some(i);
            if ui.selectable_label(is_on, name).on_hover_text("Look at its trees alone, and go to its time").clicked() {
                wanted.step = (!is_on).then_some(i);
                let to_s = at_s.or(windows[i].map(|w| w[1])).filter(|_| !is_on);
                commands.extend(to_s.map(|s| ViewerCommand::Seek((s * f64::from(rate_hz)).round() as u32)));
            }
            at_s.iter().for_each(|s| _ = ui.weak(format!("at {s:.2} s")));
        });
        if let Some(why) = done.and_then(|d| d.reason.as_deref()) {
            ui.label(RichText::new(why).small().color(ui.visuals().error_fg_color));
        }
    }
}

/// Shows the options of planning, and its progress.
fn planning(ui: &mut Ui, task: &TaskDocument, wanted: &mut PlanViewOptions, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        let tip = "Plan motions beside the window; the same seed gives the same motion";
        ui.button("Plan").on_hover_text(tip).request(commands, ViewerCommand::Plan(PlanCommand::Plan));
        let unit = if wanted.num_motions == 1 { " motion" } else { " motions" };
        let field = DragValue::new(&mut wanted.num_motions).range(1..=MOST).speed(0.05).suffix(unit);
        ui.add(field).on_hover_text("So many that differ, where seeds give them");
        wanted.num_motions = wanted.num_motions.clamp(1, MOST);
        let own = task.task().config.budget.seed;
        let mut seed = wanted.seed.unwrap_or(own);
        ui.add(DragValue::new(&mut seed).speed(0.05).prefix("seed ")).on_hover_text("In place of the task's");
        wanted.seed = (seed != own).then_some(seed);
        ui.checkbox(&mut wanted.replans, "after each drag").on_hover_text("Plan as soon as something was dragged");
    });
    if let Some(planning) = &task.planning {
        let ([tried, total], motion) = planning.progress();
        ui.horizontal(|ui| {
            let tip = "Stop planning; the motions stay as they are";
            ui.button("Cancel").on_hover_text(tip).request(commands, ViewerCommand::Plan(PlanCommand::Cancel));
            ui.label(format!("motion {motion}: {tried} of {total}"));
            ui.add(ProgressBar::new(tried as f32 / total.max(1) as f32).desired_height(8.0).corner_radius(4));
        });
    } else if task.is_changed() {
        let colour = ThemePalette::for_visuals(ui.visuals()).warning;
        ui.colored_label(colour, "The scene has changed since; what is shown was planned before.");
    }
}

fn save(ui: &mut Ui, task: &TaskDocument, state: &mut PlanPanelState, commands: &mut Commands) {
    // A clip in the current folder, called as the task.
    let stem = task.path.file_stem().unwrap_or_default().to_string_lossy();
    let file = state.file.get_or_insert_with(|| format!("{stem}.bvh"));
    let tip = "Write the motion that is shown, and who carries what beside it, as `throng plan` does";
    let motion = written(ui, file, Button::new("Save"), tip, task.shown_motion().is_some()).map(PlanCommand::Save);
    let file = state.task.get_or_insert_with(|| task.path.display().to_string());
    let tip = "Write the task with things and places where they are; comments and all other numbers stay";
    let own = written(ui, file, Button::new("Save the task"), tip, true).map(PlanCommand::SaveTask);
    commands.extend(motion.into_iter().chain(own).map(ViewerCommand::Plan));
}

/// A file's name, and the button that writes it; returns the name when that was clicked.
fn written(ui: &mut Ui, file: &mut String, button: Button<'_>, tip: &str, is_on: bool) -> Option<PathBuf> {
    ui.horizontal(|ui| {
        let button = ui.add_enabled(is_on, button).on_hover_text(tip);
        ui.add(TextEdit::singleline(file).desired_width(f32::INFINITY)).labelled_by(button.id);
        (button.clicked() && !file.trim().is_empty()).then(|| PathBuf::from(file.trim()))
    })
    .inner
}

/// Shows the selected thing or place.
fn show_handle(ui: &mut Ui, model: &Model, task: &TaskDocument, wanted: &mut PlanViewOptions, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        ui.strong("Things and places");
        let named = task.task().handles().into_iter().map(|h| (Some(h), task.task().handle_name(h)));
        let options = std::iter::once((None, "none selected".into())).chain(named);
        choose(ui, "Thing or place", None, &mut wanted.handle, options);
    });
    let selected = wanted.handle.and_then(|h| Some((h, task.place_of(h, model.task_time_s())?)));
    let Some((handle, place)) = selected else {
        return drop(ui.weak("Drag a thing or a place in the view; with Alt it goes up and down."));
    };
    let now = place.position.as_vec3();
    let mut to = now;
    ui.horizontal_wrapped(|ui| {
        coordinates(ui, &mut [("x", &mut to.x), ("y", &mut to.y), ("z", &mut to.z)], 1e3, 0.0, 3);
        // The position as in a task file.
        let at = task.task().written_position(handle).as_vec3();
        let text = format!("at = [{:.3}, {:.3}, {:.3}]", at.x, at.y, at.z);
        if ui.small_button("Copy").on_hover_text(format!("{text}: for the task's file")).clicked() {
            ui.ctx().copy_text(text);
        }
    });
    // The fields show rounded numbers: rounding alone moves nothing.
    if to.distance(now) > 6e-4 {
        commands.push(ViewerCommand::Plan(PlanCommand::Move(handle, to - now)));
        commands.push(ViewerCommand::Plan(PlanCommand::EndMove));
    }
}

/// Shows the list.
fn show_motions(ui: &mut Ui, task: &TaskDocument, wanted: &mut PlanViewOptions, commands: &mut Commands) {
    ui.horizontal(|ui| {
        ui.strong("Motions");
        ui.checkbox(&mut wanted.ghosts, "ghosts of the others").on_hover_text("Other motions, and the clip as it was");
    });
    let shown = task.shown();
    let label = ui.selectable_label(shown.is_none(), "the clip as it was");
    label.request(commands, ViewerCommand::Plan(PlanCommand::Show(None)));
    for (i, motion) in task.motions().iter().enumerate() {
        let apart = motion.distance_rad.map_or_else(String::new, |d| format!(" · {d:.3} rad from the next"));
        let length = motion.report.path_length_rad;
        ui.horizontal(|ui| {
            let text = format!("{} · seed {} · {length:.2} rad long{apart}", i + 1, motion.seed);
            let label = ui.selectable_label(shown == Some(i), text);
            label.request(commands, ViewerCommand::Plan(PlanCommand::Show(Some(i))));
            if !motion.report.solved {
                ui.colored_label(ui.visuals().error_fg_color, "✖");
            }
        });
    }
    if task.motions().is_empty() {
        ui.weak(if task.planning.is_some() { "The first one is planned …" } else { "None was planned yet." });
    }
    if let Some(motion) = task.shown_motion() {
        figures(ui, motion);
    }
}

fn figures(ui: &mut Ui, motion: &PlannedMotion) {
    let r = &motion.report;
    let number = |x: Option<f64>, unit: &str| x.map_or_else(|| "-".into(), |x| format!("{x:.3}\u{a0}{unit}"));
    let clear = number(r.clearance_min_m, "m");
    let jerk = format!("jerk {:.0} rad/s³ ({:.0} before smoothing)", r.jerk_after, r.jerk_before);
    ui.weak(format!("{clear} clear, {}; {jerk}; {} nodes", r.limits(), r.nodes));
    let (colour, text) = match motion.outcome.recheck.violations.first() {
        None => (ThemePalette::for_visuals(ui.visuals()).good, "The check finds no fault.".to_owned()),
        Some(v) => {
            let text = format!("The check finds {} faults: at {:.3} s {}", r.recheck_violations, v.time_s, v.what);
            (ui.visuals().error_fg_color, text)
        }
    };
    ui.colored_label(colour, text);
}
