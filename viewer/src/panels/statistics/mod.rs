//! Measurements: time of a step and a frame, memory, foot slip, arrivals, blows.

use crate::panels::paint::{facts, fixed_plot, section, swatch};
use crate::run::{BoutFigures, STEP_HZ, SceneRun, StepFigures};
use crate::stage::bout::{KINDS, colour_of};
use crate::{model::Model, panels::colour_of_view};
use eframe::egui::{Color32, Grid, RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints};
use throng_core::Bundle;
use throng_precompute::memory::bytes_text;

/// Height of a plot (points).
const PLOT_HEIGHT: f32 = 130.0;
/// Colours of lines, distinguished on dark and light.
const COLOURS: [Color32; 6] = [
    Color32::from_rgb(0x4b, 0x8b, 0xd6),
    Color32::from_rgb(0xe8, 0x74, 0x3b),
    Color32::from_rgb(0x2f, 0xb3, 0x9b),
    Color32::from_rgb(0xb0, 0x6c, 0xc9),
    Color32::from_rgb(0xc9, 0x9a, 0x2e),
    Color32::from_rgb(0xc7, 0x52, 0x6b),
];
/// Steps that a plot averages over, so that single outliers do not hide the rest.
const SMOOTH: usize = 6;

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model) {
    let scene = model.document.scene();
    if let Some(scene) = scene {
        show_scene(ui, model, &scene.run);
    }
    frame_times(ui, model);
    match model.document.bundle().filter(|_| scene.is_none_or(|s| s.is_crowd)) {
        Some(bundle) => memory(ui, bundle.tables()),
        None if scene.is_some() => {}
        None => drop(ui.weak("Open a bundle to see what its tables take and how fast a crowd runs on it.")),
    }
}

/// Shows the time of a step of a scene, and the state of its groups.
fn show_scene(ui: &mut Ui, model: &Model, run: &SceneRun) {
    let (f, n) = (run.figures(), run.simulation().num_characters());
    strong_facts(ui, "scene now", |row| {
        row("present", format!("{} of {n}", run.num_present()));
        if let Some(at_target) = f.at_target {
            let share = 100.0 * at_target as f32 / n as f32;
            row("characters at target", format!("{at_target} of {n} ({share:.0} %)"));
        }
        if f.slip.mean_mps > 0.0 {
            row("foot slip", format!("{:.3} m/s mean, {:.3} at the 95th percentile", f.slip.mean_mps, f.slip.p95_mps));
        }
        let each = 1e6 * f.wall_s * f64::from(STEP_HZ) / n.max(1) as f64;
        row("step", format!("{:.3} ms, {each:.1} µs a character and second", 1e3 * f.wall_s));
        row("frame", format!("{:.1} ms, {} steps in it", 1e3 * model.times.frame_s, model.times.steps));
        let kept = run.head.recorded();
        row("record", format!("{:.1} s", (kept.end() - kept.start()) as f32 / STEP_HZ));
    });
    let history: Vec<_> = run.history().collect();
    if f.bout.is_some_and(|bout| bout.blows.thrown > 0 || bout.penetration_m.is_some()) {
        show_bout(ui, &history, n);
    }
    if history.iter().any(|h| h.1.slip.mean_mps > 0.0) {
        slip(ui, &history);
    }
    if f.at_target.is_some() {
        at_target(ui, &history, n);
    }
}

/// Shows names and figures.
fn strong_facts(ui: &mut Ui, id: &str, add: impl FnOnce(&mut dyn FnMut(&str, String))) {
    facts(ui, id, true, |row| add(&mut |name, text| row(name, "", RichText::new(text).strong())));
}

fn slip(ui: &mut Ui, history: &[(u32, &StepFigures)]) {
    let steps = || history.iter().map(|h| h.0);
    section(ui, "Foot slip", |ui| {
        let of = |f: fn(&StepFigures) -> f32| history.iter().map(|h| f64::from(f(h.1))).collect::<Vec<_>>();
        ui.horizontal(|ui| {
            key(ui, "mean", COLOURS[0]);
            key(ui, "95th percentile", COLOURS[1]);
        });
        plot("slip", "m/s").show(ui, |p| {
            p.line(line("mean", COLOURS[0], smooth(steps(), &of(|f| f.slip.mean_mps))));
            p.line(line("95th percentile", COLOURS[1], smooth(steps(), &of(|f| f.slip.p95_mps))));
        });
    });
}

fn at_target(ui: &mut Ui, history: &[(u32, &StepFigures)], n: usize) {
    section(ui, "Characters at target", |ui| {
        let share = |h: &(u32, &StepFigures)| 100.0 * h.1.at_target.unwrap_or(0) as f64 / n as f64;
        let share: Vec<f64> = history.iter().map(share).collect();
        let of_all = line("at target", COLOURS[2], smooth(history.iter().map(|h| h.0), &share));
        plot("at target", "%").include_y(100.0).show(ui, |p| p.line(of_all));
    });
}

fn line<'a>(name: &str, colour: Color32, points: PlotPoints<'a>) -> Line<'a> {
    Line::new(name, points).color(colour).width(1.6)
}

/// A name with the colour of its line.
fn key(ui: &mut Ui, name: &str, colour: Color32) {
    ui.horizontal(|ui| {
        swatch(ui, colour);
        ui.label(name);
    });
}

fn frame_times(ui: &mut Ui, model: &Model) {
    let t = model.times;
    section(ui, "Time of a frame", |ui| {
        Grid::new("frame").num_columns(2).striped(true).spacing([14.0, 3.0]).show(ui, |ui| {
            for (name, s) in [
                ("simulation", t.simulation_s),
                ("laying out", t.layout_s),
                ("upload", t.upload_s),
                ("drawing (encoding)", t.drawing_s),
            ] {
                ui.label(name);
                ui.monospace(format!("{:>8.2} ms", 1e3 * s));
                ui.end_row();
            }
        });
    });
}

fn memory(ui: &mut Ui, tables: &Bundle) {
    section(ui, "Memory of the tables", |ui| {
        let all = tables.num_bytes().max(1);
        Grid::new("memory").num_columns(3).striped(true).spacing([14.0, 3.0]).show(ui, |ui| {
            for (tag, len) in tables.section_sizes() {
                ui.label(section_name(&tag.to_string())).on_hover_text(format!("section {tag}"));
                ui.monospace(format!("{:>10}", bytes_text(len as u64)));
                ui.monospace(format!("{:>5.1} %", 100.0 * len as f64 / all as f64));
                ui.end_row();
            }
            ui.strong("whole bundle");
            ui.monospace(format!("{:>10}", bytes_text(all as u64)));
            ui.end_row();
        });
    });
}

fn plot(id: &str, unit: &'static str) -> Plot<'static> {
    fixed_plot(id, PLOT_HEIGHT, move |name, s, value| format!("{name}\n{s:.1} s: {value:.3} {unit}"))
        .x_axis_formatter(|mark, _| format!("{} s", mark.value))
        .y_axis_formatter(move |mark, _| format!("{} {unit}", mark.value))
}

/// Means over a few steps, against seconds.
fn smooth(steps: impl Iterator<Item = u32>, values: &[f64]) -> PlotPoints<'static> {
    let steps: Vec<u32> = steps.collect();
    let point = |(s, v): (&[u32], &[f64])| {
        let mean = v.iter().sum::<f64>() / v.len() as f64;
        [f64::from(s[s.len() / 2]) / f64::from(STEP_HZ), mean]
    };
    steps.chunks(SMOOTH).zip(values.chunks(SMOOTH)).map(point).collect()
}

/// Description of a section; the tag if unknown.
fn section_name(tag: &str) -> String {
    let name = match tag {
        "META" => "names, provenance",
        "SKEL" => "skeleton",
        "CLIP" => "clips",
        "FRAM" => "frames",
        "CONT" => "contacts",
        "HITS" => "effective hits",
        "STAT" => "states",
        "SEGM" => "segments",
        "AOFF" | "ASEG" | "AERR" => "actions",
        "POLI" => "policies",
        "PSEG" => "segments of policies",
        "PPTH" => "paths of body points",
        "PVAL" => "values",
        "PBST" => "best actions",
        "BLND" => "blend spaces",
        "BEXM" => "examples",
        "BWGT" => "weights of examples",
        "BREF" | "BCHN" => "postures",
        "PGRD" => "grids of states",
        "PATC" => "motion patches",
        "PEDG" => "edges of tiles",
        "PCEL" => "cells of patches",
        "PLNK" => "links of patches",
        "PPAR" => "pairs of links",
        "GRPS" => "pose groups",
        _ => return tag.to_owned(),
    };
    format!("{name} ({tag})")
}

/// Time that hits a minute are counted over, in the plot (s).
const WINDOW_S: f32 = 10.0;

/// Shows the results of blows up to the last of some steps.
fn show_bout(ui: &mut Ui, history: &[(u32, &StepFigures)], n: usize) {
    let history: Vec<(u32, BoutFigures)> = history.iter().filter_map(|(s, f)| Some((*s, f.bout?))).collect();
    let Some(&(_, f)) = history.last() else { return };
    section(ui, "Blows", |ui| {
        let share = |count: u32| {
            let percent = 100.0 * f64::from(count) / f64::from(f.blows.thrown.max(1));
            format!("{count} ({percent:.0} %)")
        };
        strong_facts(ui, "blows", |row| {
            row("thrown", f.blows.thrown.to_string());
            row("landed", share(f.blows.landed));
            if f.penetration_m.is_some() {
                row("blocked", share(f.blows.blocked));
            }
            row("missed", share(f.blows.missed));
            let since = BoutFigures::default();
            row("hits a minute", format!("{:.1} a character", f.hits_per_minute(&since, n)));
            if let Some(now) = f.penetration_m {
                let most = f.max_penetration_m;
                row("penetration", format!("{:.1} cm now, {:.1} cm at most", 100.0 * now, 100.0 * most));
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.weak("marks:");
            for (met, name) in KINDS {
                match colour_of(met) {
                    Some(colour) => key(ui, name, colour_of_view(colour)),
                    None => _ = ui.label(name),
                }
            }
        });
        key(ui, &format!("hits a minute and character, over {WINDOW_S:.0} s"), COLOURS[1]);
        let (steps, values) = (history.iter().map(|h| h.0), windowed(&history, n));
        plot("hits", "").show(ui, |p| p.line(line("hits a minute", COLOURS[1], smooth(steps, &values))));
        if f.penetration_m.is_some() {
            penetration(ui, &history);
        }
    });
}

/// Hits a minute over the last [`WINDOW_S`], or since the start where that is less, at every step.
fn windowed(history: &[(u32, BoutFigures)], characters: usize) -> Vec<f64> {
    let window = (WINDOW_S * STEP_HZ) as u32;
    let mut first = 0;
    let at = |(step, f): &(u32, BoutFigures)| {
        while history[first].0 + window < *step {
            first += 1;
        }
        f.hits_per_minute(&history[first].1, characters)
    };
    history.iter().map(at).collect()
}

fn penetration(ui: &mut Ui, history: &[(u32, BoutFigures)]) {
    key(ui, "deepest penetration", COLOURS[3]);
    // Peaks, which a mean would hide.
    let peaks = history.chunks(SMOOTH).flat_map(|c| {
        let most = c.iter().filter_map(|h| h.1.penetration_m).fold(0.0, f32::max);
        c.iter().map(move |_| 100.0 * f64::from(most))
    });
    let values: Vec<f64> = peaks.collect();
    let steps = history.iter().map(|h| h.0);
    plot("penetration", "cm").show(ui, |p| p.line(line("penetration", COLOURS[3], smooth(steps, &values))));
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_simulation::sparring::BlowTally;

    #[test]
    fn hits_a_minute_are_those_of_the_window() {
        // Two characters, one hit a second for 30 s, then none.
        let at = |step: u32| {
            let seconds = f64::from(step) / 60.0;
            let landed = (seconds as u32).min(30);
            (
                step,
                BoutFigures { blows: BlowTally { landed, ..BlowTally::default() }, seconds, ..BoutFigures::default() },
            )
        };
        let history: Vec<_> = (0..=3600).map(at).collect();
        let rates = windowed(&history, 2);
        assert!((rates[1500] - 30.0).abs() < 2.0, "{}", rates[1500]);
        assert!(rates[3600] == 0.0 && (rates[2100] - 15.0).abs() < 2.0, "{}", rates[2100]);
        assert_eq!(rates[0], 0.0);
    }
}
