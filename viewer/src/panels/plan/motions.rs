//! The motions that were planned, side by side in a list, and the figures of the one shown.

use crate::command::{Commands, PlanCommand, PlanViewOptions, ViewerCommand};
use crate::document::{PlannedMotion, TaskDocument};
use crate::panels::paint::PanelWidget;
use crate::theme::ThemePalette;
use eframe::egui::Ui;

/// Shows the list.
pub fn show(ui: &mut Ui, task: &TaskDocument, wanted: &mut PlanViewOptions, commands: &mut Commands) {
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
