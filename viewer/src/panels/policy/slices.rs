//! All heights, or times, of a grid side by side, with the same colours.

use super::PolicyPanelState;
use super::map::PolicyMapInput;
use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::PanelWidget;
use eframe::egui::{Align2, FontId, Rect, Role, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

/// Least width of one map (points).
const LEAST: f32 = 104.0;
/// Height of its title (points).
const TITLE: f32 = 15.0;
/// Space between maps (points).
const GAP: f32 = 4.0;

/// Shows the maps; a click shows one of them alone. Returns the least scale of their arrows.
pub fn show(ui: &mut Ui, shown: &PolicyMapInput<'_>, own: &mut PolicyPanelState, commands: &mut Commands) -> f32 {
    let (chart, heights) = (shown.chart(), shown.policy.grid_of(shown.state).record().num_heights);
    let [low, high] = chart.bounds(-shown.centre());
    let columns = ((ui.available_width() / LEAST) as u32).clamp(1, heights.min(6));
    let width = (ui.available_width() - GAP * (columns - 1) as f32) / columns as f32;
    let height = width * ((high.y - low.y) / (high.x - low.x)).clamp(0.4, 1.5) + TITLE;
    let rows = heights.div_ceil(columns);
    let size = vec2(ui.available_width(), rows as f32 * (height + GAP) - GAP);
    let (area, _) = ui.allocate_exact_size(size, Sense::hover());
    own.heats.truncate(heights as usize);
    let mut arrow_scale = 1.0f32;
    for k in 0..heights {
        let (column, row) = ((k % columns) as f32, (k / columns) as f32);
        let corner = pos2(area.left() + column * (width + GAP), area.top() + row * (height + GAP));
        let tile = Rect::from_min_size(corner, vec2(width, height));
        let name = chart.height_name(k);
        let response = ui.interact(tile, ui.scope_id().with(("slice", k)), Sense::click());
        let response = response.named(Role::Button, format!("Values {name}"));
        let visuals = ui.visuals();
        let is_chosen = shown.slice == k;
        let colour = if is_chosen { visuals.strong_text_color() } else { visuals.weak_text_color() };
        ui.painter().text(tile.center_top(), Align2::CENTER_TOP, &name, FontId::proportional(11.0), colour);
        if is_chosen || response.hovered() {
            ui.painter().rect_stroke(tile, 3.0, Stroke::new(1.0, colour), StrokeKind::Inside);
        }
        if response.clicked() {
            commands.push(ViewerCommand::SelectSlice(k));
            own.slices = false;
        }
        let map = tile.with_min_y(tile.top() + TITLE);
        arrow_scale = arrow_scale.min(own.paint(ui, shown, k, map, response));
    }
    arrow_scale
}
