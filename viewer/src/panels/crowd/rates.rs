//! Event rates: a plot of the last ten seconds, with a key that shows and hides kinds.

use super::options_command;
use crate::command::Commands;
use crate::document::SceneDocument;
use crate::model::Model;
use crate::panels::colour_of_view;
use crate::panels::paint::{PanelWidget, fixed_plot};
use crate::run::agents::{AgentEventKind, WINDOW_S};
use crate::stage::agents::colour_of_event;
use eframe::egui::{Grid, RichText, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, vec2};
use egui_plot::{AxisHints, Line, PlotPoints, uniform_grid_spacer};

/// Height of the plot (points).
const HEIGHT: f32 = 120.0;
/// Distances of lines over the time, the fine and the strong ones (s).
const MARKS_S: [f64; 3] = [2.0, 10.0, 60.0];
/// Columns of the key.
const COLUMNS: usize = 3;

/// Shows the plot and the key.
pub fn show(ui: &mut Ui, model: &Model, scene: &SceneDocument, commands: &mut Commands) {
    let (run, dark) = (&scene.run, ui.visuals().dark_mode);
    let now = run.simulation().time_s();
    let rates = &run.log.rates;
    ui.weak("Events of one agent in a second, over the last 10 s.");
    let before = rates.rates_until(now);
    let plot = fixed_plot("event rates", HEIGHT, |kind, s, rate| format!("{kind}\n{s:.1} s: {rate:.2} /s"))
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
