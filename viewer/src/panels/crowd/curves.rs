//! Curves over time: how messages spread, each with a button that triggers it, and event rates with a key that shows and hides kinds.

use super::{options_command, swatch};
use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::{PanelWidget, fixed_plot};
use crate::run::agents::{AgentEventKind, WINDOW_S};
use crate::run::{RunInput, STEP_HZ};
use crate::stage::agents::{colour_of_event, colour_of_message};
use crate::{document::SceneDocument, model::Model, panels::colour_of_view};
use eframe::egui::{Grid, RichText, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, vec2};
use egui_plot::{AxisHints, Line, LineStyle, PlotPoints, VLine, uniform_grid_spacer};
use throng_simulation::scenario::AgentBrains;

/// Height of the curve (points).
const MESSAGES_HEIGHT: f32 = 110.0;
/// Most corners of a curve.
const MAX_CORNERS: usize = 400;

/// Shows the spread of every message with a button that triggers it, and the curve of the inspected one.
pub fn show_messages(ui: &mut Ui, model: &Model, scene: &SceneDocument, brains: &AgentBrains, commands: &mut Commands) {
    let shown = model.selection.scene.message.filter(|e| *e < brains.event_names().len());
    Grid::new("news").num_columns(4).spacing([14.0, 3.0]).show(ui, |ui| {
        for (event, spread) in brains.event_spreads().into_iter().enumerate() {
            let is_on = shown == Some(event);
            ui.horizontal(|ui| {
                swatch(ui, colour_of_view(colour_of_message(event)));
                let r = ui.selectable_label(is_on, &spread.event);
                let name = format!("Message {}", spread.event);
                r.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, is_on, &name));
                r.request(commands, options_command(model, |l| l.message = (!is_on).then_some(event)));
                r.on_hover_text("Colours agents by whether they know of it, with lines from who told them");
            });
            ui.label(format!("{} know", spread.informed)).on_hover_text("Agents who know of it");
            let passed_on = ui.label(format!("{} informed by others", spread.passed_on));
            passed_on.on_hover_text("Agents that learnt of it from another one");
            let tip = "Lets it happen now; what was recorded after the step shown is dropped";
            let button = ui.small_button("happen").on_hover_text(tip);
            let button = button.named(Role::Button, format!("Happen {}", spread.event));
            button.request(commands, ViewerCommand::Input(RunInput::Event(spread.event)));
            ui.end_row();
        }
    });
    match shown {
        Some(event) => curve(ui, scene, brains, event),
        None => drop(ui.weak("Click a message to see how it spreads.")),
    }
    for (state, count) in brains.num_in_states() {
        ui.weak(format!("{count} in {state}"));
    }
}

/// Number of agents that know a message over time; the part after the shown time is faint.
fn curve(ui: &mut Ui, scene: &SceneDocument, brains: &AgentBrains, event: usize) {
    let run = &scene.run;
    let (now, end) = (run.simulation().time_s(), f64::from(*run.head.recorded().end()) / f64::from(STEP_HZ));
    let times = run.spread.times(event);
    let known = times.partition_point(|t| *t <= now);
    ui.weak(format!("{} of {} know of {} at {now:.1} s", known, brains.len(), brains.event_names()[event]));
    let line = colour_of_view(colour_of_message(event));
    let plot = fixed_plot("spread", MESSAGES_HEIGHT, |_, s, known| format!("{s:.1} s: {known:.0} know"))
        .include_x(0.0)
        .include_x(end.max(1.0))
        .include_y(brains.len() as f64)
        .custom_x_axes(vec![AxisHints::new_x().formatter(|m, _| format!("{} s", m.value)).label_spacing(40.0..=50.0)])
        .custom_y_axes(vec![AxisHints::new_y().formatter(|m, _| format!("{}", m.value)).label_spacing(14.0..=18.0)]);
    let head = crate::theme::ThemePalette::for_visuals(ui.visuals()).head;
    plot.show(ui, |p| {
        let before = steps(&times[..known], (0.0, 0), now);
        p.line(Line::new("knows", PlotPoints::from(before)).color(line).width(2.0).allow_band(false));
        if known < times.len() || now < end {
            let after = steps(&times[known..], (now, known), end);
            let line = Line::new("will know", PlotPoints::from(after)).color(line.gamma_multiply(0.45)).width(1.5);
            p.line(line.style(LineStyle::dashed_loose()));
        }
        p.vline(VLine::new("now", now).color(head).width(1.0));
    });
}

/// Corners of a curve that rises by one at each of some times, from a start value to an end time; no two corners
/// coincide.
fn steps(times: &[f64], (from_s, from): (f64, usize), until_s: f64) -> Vec<[f64; 2]> {
    let every = times.len().div_ceil(MAX_CORNERS).max(1);
    let mut out = vec![[from_s, from as f64]];
    let mut before = from as f64;
    for (i, &time_s) in times.iter().enumerate().filter(|(i, _)| (i + 1) % every == 0 || i + 1 == times.len()) {
        out.extend([[time_s, before], [time_s, (from + i + 1) as f64]]);
        before = (from + i + 1) as f64;
    }
    out.push([until_s, before]);
    out.dedup();
    out
}

/// Height of the plot (points).
const RATES_HEIGHT: f32 = 120.0;
/// Distances of lines over the time, the fine and the strong ones (s).
const MARKS_S: [f64; 3] = [2.0, 10.0, 60.0];
/// Columns of the key.
const COLUMNS: usize = 3;

/// Shows the plot and the key.
pub fn show_rates(ui: &mut Ui, model: &Model, scene: &SceneDocument, commands: &mut Commands) {
    let (run, dark) = (&scene.run, ui.visuals().dark_mode);
    let now = run.simulation().time_s();
    let rates = &run.log.rates;
    ui.weak("Events of one agent in a second, over the last 10 s.");
    let before = rates.rates_until(now);
    let plot = fixed_plot("event rates", RATES_HEIGHT, |kind, s, rate| format!("{kind}\n{s:.1} s: {rate:.2} /s"))
        .include_x(now - WINDOW_S)
        .include_x(now)
        .x_grid_spacer(uniform_grid_spacer(|_| MARKS_S))
        .custom_x_axes(vec![AxisHints::new_x().formatter(|m, _| format!("{} s", m.value)).label_spacing(40.0..=50.0)])
        .custom_y_axes(vec![AxisHints::new_y().formatter(|m, _| format!("{} /s", m.value)).label_spacing(14.0..=18.0)]);
    let totals = rates.totals(now);
    let kinds = model.selection.scene.kinds;
    plot.show(ui, |p| {
        for what in AgentEventKind::all().into_iter().filter(|w| kinds[w.number()] && totals[w.number()] > 0) {
            let points: PlotPoints<'_> = before.iter().map(|(t, r)| [*t, r[what.number()]]).collect();
            p.line(Line::new(what.name(), points).color(colour_of_view(colour_of_event(what, dark))).width(1.8));
        }
    });
    key(ui, model, totals, commands);
}

/// Names of kinds with how many there were; a click shows or hides one in plot, list and view.
fn key(ui: &mut Ui, model: &Model, totals: [u64; AgentEventKind::COUNT], commands: &mut Commands) {
    let dark = ui.visuals().dark_mode;
    // Kinds that only the occupancy scheme or agent brains report are left out if there are none.
    let of_occupancy = AgentEventKind::Entering.number()..=AgentEventKind::Separating.number();
    let is_special =
        |w: &AgentEventKind| of_occupancy.contains(&w.number()) || w.number() >= AgentEventKind::EnteredPlace.number();
    let there = AgentEventKind::all().into_iter().filter(|w| !is_special(w) || totals[w.number()] > 0);
    Grid::new("kinds").num_columns(COLUMNS).spacing([10.0, 2.0]).show(ui, |ui| {
        for (i, what) in there.enumerate() {
            let is_on = model.selection.scene.kinds[what.number()];
            let inner = ui.horizontal(|ui| {
                let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                let c = colour_of_view(colour_of_event(what, dark));
                match is_on {
                    true => ui.painter().rect_filled(rect, 2.0, c),
                    false => ui.painter().rect_stroke(rect, 2.0, Stroke::new(1.0, c), StrokeKind::Inside),
                };
                let text = RichText::new(format!("{} {}", what.name(), totals[what.number()]));
                ui.selectable_label(false, if is_on { text } else { text.weak() })
            });
            let r = inner.inner;
            r.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, is_on, format!("Kind {}", what.name())));
            r.request(commands, options_command(model, |l| l.kinds[what.number()] = !is_on));
            r.on_hover_text(format!("{}. A click shows or hides them.", what.meaning()));
            if i % COLUMNS == COLUMNS - 1 {
                ui.end_row();
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_go_up_where_somebody_learns() {
        let corners = steps(&[1.0, 3.0], (0.0, 4), 5.0);
        assert_eq!(corners, [[0.0, 4.0], [1.0, 4.0], [1.0, 5.0], [3.0, 5.0], [3.0, 6.0], [5.0, 6.0]]);
        assert_eq!(steps(&[], (2.0, 1), 5.0), [[2.0, 1.0], [5.0, 1.0]]);
        assert_eq!(steps(&[1.0, 1.0], (0.0, 0), 1.0), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]);
        let many: Vec<f64> = (0..5000).map(f64::from).collect();
        let corners = steps(&many, (0.0, 0), 5000.0);
        assert!(corners.len() < 900 && corners.last() == Some(&[5000.0, 5000.0]));
    }
}
