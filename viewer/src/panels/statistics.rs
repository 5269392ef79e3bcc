//! What was measured: time of a step and a frame, memory, foot slip, arrivals.

use crate::model::Model;
use crate::run::{Run, STEP_HZ};
use eframe::egui::{self, CollapsingHeader, Grid, Ui};
use egui_plot::{Corner, HoverPosition, Legend, Line, Plot, PlotPoints};
use throng_runtime::Tables;

/// Height of a plot. [Unit: points]
const PLOT_HEIGHT: f32 = 130.0;
/// Steps that a plot averages over, so that single outliers do not hide the rest.
const SMOOTH: usize = 6;

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model) {
    if let Some((_, run)) = model.document.crowd() {
        now(ui, model, run);
        step_times(ui, run);
        quality(ui, run);
    }
    frame_times(ui, model);
    match model.document.bundle() {
        Some(bundle) => memory(ui, bundle.tables(), model),
        None => {
            ui.weak("Open a bundle to see what its tables take and how fast a crowd runs on it.");
        }
    }
}

fn now(ui: &mut Ui, model: &Model, run: &Run) {
    let f = run.figures();
    let n = run.config().characters;
    Grid::new("now").num_columns(2).spacing([14.0, 3.0]).show(ui, |ui| {
        row(
            ui,
            "characters at target",
            format!("{} of {n} ({:.0} %)", f.at_target, 100.0 * f.at_target as f32 / n as f32),
        );
        row(ui, "foot slip", format!("{:.3} m/s mean, {:.3} at the 95th percentile", f.slip.mean_mps, f.slip.p95_mps));
        let per_character = 1e9 * f.wall_s / n as f64;
        row(ui, "step", format!("{:.3} ms, {per_character:.0} ns a character", 1e3 * f.wall_s));
        row(ui, "frame", format!("{:.1} ms, {} steps in it", 1e3 * model.times.frame_s, model.times.steps));
        row(
            ui,
            "record",
            format!("{} for {:.0} s", bytes(run.recording_bytes()), run.history().count() as f32 / STEP_HZ),
        );
    });
}

fn row(ui: &mut Ui, name: &str, text: String) {
    ui.label(name);
    ui.add(egui::Label::new(egui::RichText::new(text).strong()).wrap().selectable(true));
    ui.end_row();
}

fn step_times(ui: &mut Ui, run: &Run) {
    section(ui, "Time of a step by phase", |ui| {
        ui.weak("Milliseconds of all threads together, over the last minute.");
        let plot = plot("step times", "ms").legend(Legend::default().position(Corner::LeftTop));
        let history: Vec<_> = run.history().map(|(step, f)| (step, f.times.phases())).collect();
        plot.show(ui, |p| {
            let mut below = vec![0.0; history.len()];
            for phase in 0..5 {
                let name = history.first().map_or("", |h| h.1[phase].0);
                for (b, h) in below.iter_mut().zip(&history) {
                    *b += 1e3 * h.1[phase].1;
                }
                p.line(Line::new(name, smooth(history.iter().map(|h| h.0), &below)));
            }
        });
        let last = run.figures().times;
        let total = last.total_s().max(1e-12);
        Grid::new("phases").num_columns(3).striped(true).show(ui, |ui| {
            for (name, s) in last.phases() {
                ui.label(name);
                ui.monospace(format!("{:>8.1} µs", 1e6 * s));
                ui.monospace(format!("{:>3.0} %", 100.0 * s / total));
                ui.end_row();
            }
        });
    });
}

fn quality(ui: &mut Ui, run: &Run) {
    let steps = || run.history().map(|h| h.0);
    section(ui, "Foot slip", |ui| {
        let of = |f: fn(&crate::run::StepFigures) -> f32| run.history().map(|h| f64::from(f(h.1))).collect::<Vec<_>>();
        plot("slip", "m/s").legend(Legend::default().position(Corner::LeftTop)).show(ui, |p| {
            p.line(Line::new("mean", smooth(steps(), &of(|f| f.slip.mean_mps))));
            p.line(Line::new("95th percentile", smooth(steps(), &of(|f| f.slip.p95_mps))));
        });
    });
    section(ui, "Characters at target", |ui| {
        let n = run.config().characters as f64;
        let share: Vec<f64> = run.history().map(|h| 100.0 * h.1.at_target as f64 / n).collect();
        plot("at target", "%").include_y(100.0).show(ui, |p| p.line(Line::new("at target", smooth(steps(), &share))));
    });
}

fn frame_times(ui: &mut Ui, model: &Model) {
    let t = model.times;
    section(ui, "Time of a frame", |ui| {
        Grid::new("frame").num_columns(2).striped(true).spacing([14.0, 3.0]).show(ui, |ui| {
            let phases = [
                ("simulation", t.simulation_s),
                ("laying out", t.layout_s),
                ("upload", t.upload_s),
                ("drawing (encoding)", t.drawing_s),
            ];
            for (name, s) in phases {
                ui.label(name);
                ui.monospace(format!("{:>8.2} ms", 1e3 * s));
                ui.end_row();
            }
        });
    });
}

fn memory(ui: &mut Ui, tables: &Tables, model: &Model) {
    section(ui, "Memory of the tables", |ui| {
        let all = tables.num_bytes().max(1);
        Grid::new("memory").num_columns(3).striped(true).spacing([14.0, 3.0]).show(ui, |ui| {
            for &(tag, len) in tables.section_sizes() {
                ui.label(section_name(&tag.to_string())).on_hover_text(format!("section {tag}"));
                ui.monospace(format!("{:>10}", bytes(len)));
                ui.monospace(format!("{:>5.1} %", 100.0 * len as f64 / all as f64));
                ui.end_row();
            }
            ui.strong("whole bundle");
            ui.monospace(format!("{:>10}", bytes(all)));
            ui.end_row();
        });
        if let Some((_, run)) = model.document.crowd() {
            let poses = size_of_val(run.troupe().model_matrices());
            ui.label(format!("Poses of the crowd: {}", bytes(poses)));
        }
    });
}

fn section(ui: &mut Ui, title: &str, add: impl FnOnce(&mut Ui)) {
    ui.add_space(4.0);
    CollapsingHeader::new(egui::RichText::new(title).strong()).default_open(true).show(ui, add);
}

fn plot(id: &str, unit: &'static str) -> Plot<'static> {
    Plot::new(id.to_owned())
        .height(PLOT_HEIGHT)
        .include_y(0.0)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .x_axis_formatter(|mark, _| format!("{} s", mark.value))
        .y_axis_formatter(move |mark, _| format!("{} {unit}", mark.value))
        .label_formatter(move |hit| match hit {
            HoverPosition::NearDataPoint { plot_name, position, .. } => {
                Some(format!("{plot_name}\n{:.1} s: {:.3} {unit}", position.x, position.y))
            }
            HoverPosition::Elsewhere { .. } => None,
        })
}

/// Means over a few steps, against seconds.
fn smooth(steps: impl Iterator<Item = u32>, values: &[f64]) -> PlotPoints<'static> {
    let steps: Vec<u32> = steps.collect();
    let points = steps.chunks(SMOOTH).zip(values.chunks(SMOOTH));
    points
        .map(|(s, v)| {
            let mean = v.iter().sum::<f64>() / v.len() as f64;
            [f64::from(s[s.len() / 2]) / f64::from(STEP_HZ), mean]
        })
        .collect()
}

/// What a section holds, for people; its tag where that is not known.
fn section_name(tag: &str) -> String {
    let name = match tag {
        "META" => "names, provenance",
        "SKEL" => "skeleton",
        "CLIP" => "clips",
        "FRAM" => "frames",
        "CONT" => "contacts",
        "STAT" => "states",
        "SEGM" => "segments",
        "AOFF" | "ASEG" | "AERR" => "actions",
        "POLI" => "policies",
        "PSEG" => "segments of policies",
        "PVAL" => "values",
        "PBST" => "best actions",
        _ => return tag.to_owned(),
    };
    format!("{name} ({tag})")
}

fn bytes(n: usize) -> String {
    match n {
        0..10_000 => format!("{n} B"),
        10_000..10_000_000 => format!("{:.1} kB", n as f64 / 1e3),
        _ => format!("{:.1} MB", n as f64 / 1e6),
    }
}
