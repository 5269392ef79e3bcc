//! Small painters that panels share: a time axis with its ruler, legends, tables of many rows.

mod axis;
mod figure;
mod table;

pub use axis::{FrameAxis, FrameSpan, RULER_HEIGHT, ruler};
pub use figure::{FigureStyle, figure_of_pose, paint_figure};
pub use table::{RowClick, RowTable, TableCell, TableColumn, TableResponse, TableSort, least_width};

use super::words::number;
use crate::command::{Commands, ViewerCommand};
use crate::document::OpenDocument;
use eframe::egui::epaint::Mesh;
use eframe::egui::{
    Align, CollapsingHeader, Color32, ComboBox, DragValue, Grid, Label, Layout, Painter, Pos2, Rect, Response,
    RichText, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2,
};
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

/// A widget with a name, or one that asks the model for something.
pub trait PanelWidget {
    /// Gives the widget a role and a name, by which tests and assistive tools find it.
    fn named(self, role: Role, name: impl ToString) -> Self;

    /// Adds a request if the widget was clicked.
    fn request(&self, commands: &mut Commands, request: ViewerCommand);
}

impl PanelWidget for Response {
    fn named(self, role: Role, name: impl ToString) -> Self {
        self.widget_info(|| WidgetInfo::labeled(role, true, name.to_string()));
        self
    }

    fn request(&self, commands: &mut Commands, request: ViewerCommand) {
        commands.extend(self.clicked().then_some(request));
    }
}

/// Shows a list that opens, to choose one of some values by their texts.
///
/// - `width`: width while it is closed; none takes the usual one (points).
pub fn choose<T: PartialEq>(
    ui: &mut Ui,
    name: &str,
    width: Option<f32>,
    value: &mut T,
    options: impl IntoIterator<Item = (T, String)>,
) -> Response {
    let options: Vec<(T, String)> = options.into_iter().collect();
    let shown = options.iter().find(|o| o.0 == *value).map_or("", |o| &o.1);
    let width = width.unwrap_or(ui.spacing().combo_width);
    let combo = ComboBox::from_id_salt(name).width(width).selected_text(shown).show_ui(ui, |ui| {
        options.into_iter().for_each(|(option, text)| _ = ui.selectable_value(value, option, text));
    });
    combo.response.named(Role::ComboBox, name)
}

/// Shows fields for coordinates with their names (m).
///
/// - `limit`: largest coordinate of either sign (m); `speed`: change for a point that a field is dragged by (m).
pub fn coordinates(ui: &mut Ui, values: &mut [(&str, &mut f32)], limit: f32, speed: f64, num_decimals: usize) {
    for (name, value) in values {
        ui.label(*name);
        let field = DragValue::new(*value).range(-limit..=limit).speed(speed).update_while_editing(false);
        ui.add(field.suffix(" m").fixed_decimals(num_decimals));
    }
}

/// Shows a small square with a colour of the 3-D view, or of a line.
pub fn swatch(ui: &mut Ui, colour: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, colour);
}

/// Shows a grid of facts: each has a name, a hint about the name that may be empty, and a value.
///
/// - `wraps`: values take several lines where the panel is narrow.
pub fn facts(ui: &mut Ui, id: &str, wraps: bool, add: impl FnOnce(&mut dyn FnMut(&str, &str, RichText))) {
    Grid::new(id).num_columns(2).spacing([14.0, 3.0]).show(ui, |ui| {
        add(&mut |name, hint, value| {
            let name = ui.label(name);
            if !hint.is_empty() {
                name.on_hover_text(hint);
            }
            ui.add(if wraps { Label::new(value).wrap() } else { Label::new(value) });
            ui.end_row();
        });
    });
}

/// A part of a panel below its title, which folds it away.
pub fn section(ui: &mut Ui, title: &str, add: impl FnOnce(&mut Ui)) {
    ui.add_space(2.0);
    CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show(ui, add);
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
