//! Small painters that panels share: a time axis with its ruler, legends, tables of many rows.

mod axis;
mod figure;
mod table;
mod widget;

pub use axis::{FrameAxis, FrameSpan, RULER_HEIGHT, ruler};
pub use figure::{FigureStyle, figure_of_pose, paint_figure};
pub use table::{RowClick, RowTable, TableCell, TableColumn, TableResponse, TableSort, least_width};
pub use widget::{PanelWidget, choose, coordinates, facts, section, swatch};

use super::words::number;
use crate::document::OpenDocument;
use eframe::egui::epaint::Mesh;
use eframe::egui::{Align, Color32, Layout, Painter, Pos2, Rect, RichText, Sense, Shape, Stroke, Ui, pos2};
use egui_plot::{HoverPosition, Plot};

/// Distance of two lines of a hatching (points).
const HATCH_DISTANCE: f32 = 6.0;

/// Shows a title and a hint in the middle of an empty panel.
pub fn empty(ui: &mut Ui, title: &str, hint: &str) {
    ui.with_layout(Layout::top_down(Align::Center), |ui| {
        ui.add_space((0.5 * ui.available_height() - 30.0).max(8.0));
        ui.label(RichText::new(title).strong());
        ui.label(RichText::new(hint).weak());
    });
}

/// Hint of panels about bundles for a document without one.
pub fn no_bundle(ui: &mut Ui, document: &OpenDocument) {
    match document {
        OpenDocument::Task(_) => empty(ui, "A task has no bundle", "The panel Plan (F11) shows what is to do."),
        OpenDocument::Scene(_) => empty(ui, "This scene has no bundle", "The panel Control (F1) shows its groups."),
        _ => empty(ui, "Nothing is open", "Open a bundle or a motion file: drop it here or use File > Open."),
    }
}

/// Paints a chain of limbs with round joints, so that bent limbs have no notches.
pub fn paint_chain(painter: &Painter, points: &[Pos2], width: f32, colour: Color32) {
    points.windows(2).for_each(|w| _ = painter.line_segment([w[0], w[1]], Stroke::new(width, colour)));
    points.iter().for_each(|p| _ = painter.circle_filled(*p, 0.5 * width, colour));
}

/// Hatches a rectangle with lines that rise to the right and continue in its neighbours.
pub fn hatch(painter: &Painter, rect: Rect, stroke: Stroke) {
    let painter = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let seen = painter.clip_rect();
    if !seen.is_positive() {
        return;
    }
    let height = rect.height();
    let first = ((seen.left() - height) / HATCH_DISTANCE).floor() as i32;
    let last = (seen.right() / HATCH_DISTANCE).ceil() as i32;
    for i in first..=last {
        let x = i as f32 * HATCH_DISTANCE;
        painter.line_segment([pos2(x, rect.bottom()), pos2(x + height, rect.top())], stroke);
    }
}

/// Shows a legend: a bar that runs through colours, with the numbers at its ends. Goes into a row of widgets.
pub fn legend(ui: &mut Ui, [low, high]: [f32; 2], what: &str, colour: impl Fn(f32) -> Color32) {
    ui.label(format!("{what} {}", number(low)));
    let (rect, _) = ui.allocate_exact_size([70.0, 10.0].into(), Sense::hover());
    const PARTS: usize = 18;
    let mut mesh = Mesh::default();
    for i in 0..=PARTS {
        let t = i as f32 / PARTS as f32;
        let x = rect.left() + rect.width() * t;
        mesh.colored_vertex(pos2(x, rect.top()), colour(t));
        mesh.colored_vertex(pos2(x, rect.bottom()), colour(t));
        if i > 0 {
            let k = 2 * i as u32;
            mesh.add_triangle(k - 2, k - 1, k);
            mesh.add_triangle(k - 1, k, k + 1);
        }
    }
    ui.painter().add(Shape::mesh(mesh));
    ui.label(number(high));
}

/// A plot that shows all of its values from 0 on, cannot be moved, and tells what is under the pointer.
///
/// - `tip`: text of a point: the name of its line, and its two values.
pub fn fixed_plot(id: &str, height: f32, tip: impl Fn(&str, f64, f64) -> String + 'static) -> Plot<'static> {
    Plot::new(id.to_owned())
        .height(height)
        .include_y(0.0)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .label_formatter(move |hit| match hit {
            HoverPosition::NearDataPoint { plot_name, position, .. } => Some(tip(plot_name, position.x, position.y)),
            HoverPosition::Elsewhere { .. } => None,
        })
}

/// A length of time as people read it, such as `3.20 s` or `2:05 min` (s).
pub fn time_text(seconds: f64) -> String {
    if seconds < 60.0 {
        format!("{seconds:.2} s")
    } else {
        let whole = seconds.round() as u64;
        format!("{}:{:02} min", whole / 60, whole % 60)
    }
}

#[cfg(test)]
mod tests {
    use super::time_text;

    #[test]
    fn times_are_short() {
        assert_eq!(time_text(3.2), "3.20 s");
        assert_eq!(time_text(125.4), "2:05 min");
        assert_eq!(time_text(59.999), "60.00 s");
    }
}
