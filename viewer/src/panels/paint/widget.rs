//! Widgets as panels use them: found by their names, and asking the model for something.

use crate::command::{Commands, ViewerCommand};
use eframe::egui::{
    CollapsingHeader, Color32, ComboBox, DragValue, Grid, Label, Response, RichText, Role, Sense, Ui, WidgetInfo, vec2,
};

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
