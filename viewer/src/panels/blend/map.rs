//! The map of two axes: the weight of an example in colours, all examples as dots, and the point.

use super::plane::{MapPlane, unit};
use super::surface::{self, SurfaceKey, WeightSurface};
use super::{BlendPanelInput, BlendPanelState, describe_example, weight_colour};
use crate::panels::paint::{PanelWidget, legend};
use crate::{run::Blending, theme::ThemePalette};
use eframe::egui::{
    Align2, Color32, EventFilter, FontId, Key, Modifiers, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke,
    StrokeKind, Ui, Visuals, pos2, vec2,
};

/// Room for the numbers at the left of the map, and below it (points).
const LEFT: f32 = 38.0;
const BELOW: f32 = 30.0;
/// Heights that the map may have; one axis alone needs little (points).
const HEIGHTS: [f32; 2] = [190.0, 420.0];
const LOW_HEIGHT: f32 = 90.0;
/// Parts of the map that a press of an arrow key moves the point by: with Shift, and without.
const STEPS: [f32; 2] = [0.1, 0.02];
/// Radius of a dot with weight 0, and the addition for a weight of 1 (points).
const DOT: [f32; 2] = [2.6, 6.0];

/// Shows the map; dragging moves the point.
pub fn show(ui: &mut Ui, input: &BlendPanelInput<'_>, state: &mut BlendPanelState, wanted: &mut Blending) {
    let Some((_, shown)) = state.shown else { return };
    let width = ui.available_width();
    let height = if shown.up.is_some() { (0.74 * width).clamp(HEIGHTS[0], HEIGHTS[1]) } else { LOW_HEIGHT };
    let (all, response) = ui.allocate_exact_size(vec2(width, height), Sense::click_and_drag());
    let response = response.named(Role::Canvas, "Parameter space");
    let rect = Rect::from_min_max(all.min + vec2(LEFT, 8.0), all.max - vec2(10.0, BELOW));
    let plane = MapPlane::new(input.space.axes(), shown, rect);
    state.move_point(&response, input, plane, wanted);
    let dark = ui.visuals().dark_mode;
    let (document, space, example) = (input.document, input.blending.space, input.example);
    let through = plane.point_with(&wanted.point, 0.0, 0.0);
    let key = SurfaceKey { document, space, example, through, plane, dark };
    if state.surface.as_ref().is_none_or(|s| s.key != key) {
        state.surface = Some(WeightSurface::new(key, input.space));
    }
    let painter = ui.painter_at(all);
    if let Some(s) = &state.surface {
        painter.add(Shape::mesh(std::sync::Arc::clone(&s.mesh)));
    }
    frame(&painter, ui.visuals(), input, &plane, response.has_focus());
    dots(&painter, ui.visuals(), input, state, &plane);
    point(&painter, ui.visuals(), input, &plane, wanted);
    key_to_colours(ui, input, state);
}

impl BlendPanelState {
    /// Moves the point by the mouse and the arrow keys.
    fn move_point(&mut self, response: &Response, input: &BlendPanelInput<'_>, plane: MapPlane, wanted: &mut Blending) {
        let (axes, examples) = (input.space.axes(), input.space.examples());
        let pointed_at = |at: Pos2| plane.pointed_at(axes, examples, &wanted.point, at);
        self.hovered = response.hover_pos().filter(|_| !response.dragged()).and_then(pointed_at);
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        if let Some(at) = response.interact_pointer_pos() {
            match pointed_at(at) {
                // A click on an example shows its weights; a drag moves the point over it.
                Some(example) if response.clicked() => self.toggle_example(example),
                _ if response.dragged() || response.clicked() => wanted.point = plane.moved(&wanted.point, at),
                _ => {}
            }
        }
        if let Some(example) = self.hovered {
            response.clone().on_hover_ui_at_pointer(|ui| {
                describe_example(ui, input, example);
                ui.weak("A click shows its weights.");
            });
        }
        self.focus = response.has_focus();
        if !self.focus {
            return;
        }
        // The arrow keys do not move the focus meanwhile.
        let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        response.ctx.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
        for (key, right, up) in ARROWS {
            for (modifiers, step) in [Modifiers::SHIFT, Modifiers::NONE].into_iter().zip(STEPS) {
                let step = step * response.ctx.input_mut(|i| i.count_and_consume_key(modifiers, key)) as f32;
                if step > 0.0 {
                    wanted.point = plane.stepped(&wanted.point, right * step, up * step);
                }
            }
        }
    }
}

/// The arrow keys, and where they lead: to the right, upwards.
const ARROWS: [(Key, f32, f32); 4] =
    [(Key::ArrowLeft, -1.0, 0.0), (Key::ArrowRight, 1.0, 0.0), (Key::ArrowDown, 0.0, -1.0), (Key::ArrowUp, 0.0, 1.0)];

/// Edges, ticks and names of the axes.
fn frame(painter: &Painter, visuals: &Visuals, input: &BlendPanelInput<'_>, plane: &MapPlane, has_focus: bool) {
    let (rect, weak) = (plane.rect, visuals.weak_text_color());
    let line = if has_focus { visuals.selection.stroke } else { visuals.widgets.noninteractive.bg_stroke };
    painter.rect_stroke(rect, 0.0, line, StrokeKind::Outside);
    let font = FontId::proportional(11.0);
    let grid = Stroke::new(1.0, visuals.text_color().gamma_multiply(0.10));
    for (v, at) in plane.ticks_across() {
        painter.vline(at.x, rect.y_range(), grid);
        painter.text(at + vec2(0.0, 2.0), Align2::CENTER_TOP, short(v), font.clone(), weak);
    }
    for (v, at) in plane.ticks_up() {
        painter.hline(rect.x_range(), at.y, grid);
        painter.text(pos2(rect.left() - 4.0, at.y), Align2::RIGHT_CENTER, short(v), font.clone(), weak);
    }
    let name = |a: usize| format!("{}{}", input.meta.axes[a], bracketed(input.space.axes()[a].kind));
    let below = vec2(0.0, 15.0);
    painter.text(rect.center_bottom() + below, Align2::CENTER_TOP, name(plane.shown.across), font.clone(), weak);
    if plane.turned {
        painter.text(rect.left_bottom() + below, Align2::LEFT_TOP, "left", font.clone(), weak);
        painter.text(rect.right_bottom() + below, Align2::RIGHT_TOP, "right", font.clone(), weak);
    }
    if let Some(up) = plane.shown.up {
        let galley = painter.layout_no_wrap(name(up), font, weak);
        let at = pos2(rect.left() - LEFT, rect.center().y + 0.5 * galley.size().x);
        let text = eframe::egui::epaint::TextShape::new(at, galley, weak).with_angle(-std::f32::consts::FRAC_PI_2);
        painter.add(text);
    }
}

fn short(v: f32) -> String {
    let text = format!("{v:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn bracketed(kind: u32) -> String {
    let unit = unit(kind).trim();
    if unit.is_empty() { String::new() } else { format!(" ({unit})") }
}

/// Draws the examples as dots: larger with their weights, fainter with their distance from the plane.
fn dots(painter: &Painter, visuals: &Visuals, input: &BlendPanelInput<'_>, state: &BlendPanelState, plane: &MapPlane) {
    let edge = visuals.extreme_bg_color;
    for (i, e) in input.space.examples().iter().enumerate() {
        let (at, weight) = (plane.screen(&e.parameters), input.moment.weights.get(i).copied().unwrap_or(0.0));
        let depth = plane.depth(input.space.axes(), e, &input.blending.point);
        let strength = 1.0 - 0.8 * depth;
        let radius = DOT[0] + DOT[1] * weight.abs().min(1.2).sqrt();
        if weight.abs() >= 0.005 {
            let fill = weight_colour(weight, visuals.dark_mode).gamma_multiply(strength.max(0.5));
            painter.circle(at, radius, fill, Stroke::new(1.5, edge));
        } else {
            let ink = visuals.strong_text_color().gamma_multiply(0.75 * strength);
            painter.circle(at, radius, edge.gamma_multiply(strength), Stroke::new(1.4, ink));
        }
        let is_hovered = state.hovered == Some(i);
        if is_hovered || input.example == i {
            let ring = if is_hovered { visuals.strong_text_color() } else { ThemePalette::for_visuals(visuals).state };
            painter.circle_stroke(at, radius + 3.0, Stroke::new(1.8, ring));
        }
    }
}

/// Draws the requested point as a cross-hair, and the blended point that approaches it.
fn point(painter: &Painter, visuals: &Visuals, input: &BlendPanelInput<'_>, plane: &MapPlane, wanted: &Blending) {
    let (at, now) = (plane.screen(&wanted.point), plane.screen(&input.moment.point));
    let colour = ThemePalette::for_visuals(visuals).head;
    if at.distance(now) > 1.0 {
        painter.line_segment([now, at], Stroke::new(1.5, colour.gamma_multiply(0.6)));
        painter.circle_filled(now, 3.0, colour);
    }
    let shade = if visuals.dark_mode { Color32::from_black_alpha(190) } else { Color32::from_white_alpha(220) };
    for (width, colour) in [(4.5, shade), (2.0, colour)] {
        painter.circle_stroke(at, 7.0, Stroke::new(width, colour));
        for d in [vec2(7.0, 0.0), vec2(0.0, 7.0), vec2(-7.0, 0.0), vec2(0.0, -7.0)] {
            painter.line_segment([at + d, at + 1.9 * d], Stroke::new(width, colour));
        }
    }
}

/// Shows the example on the map, and the range of its colours.
fn key_to_colours(ui: &mut Ui, input: &BlendPanelInput<'_>, state: &mut BlendPanelState) {
    let dark = ui.visuals().dark_mode;
    ui.horizontal_wrapped(|ui| {
        let [low, high] = surface::RANGE;
        legend(ui, surface::RANGE, "weight", |t| surface::colour(low + t * (high - low), dark));
        let name = input.meta.examples.get(input.example).map_or("", String::as_str);
        ui.label(format!("of {name}"));
        let range = state.surface.as_ref().map(|s| s.range).filter(|r| r[0] <= r[1]);
        if let Some([least, most]) = range {
            ui.weak(format!("{least:.2} to {most:.2}")).on_hover_text("Least and largest weight on this map");
        }
        if state.example.is_some() && ui.small_button("strongest").on_hover_text("Follow the strongest one").clicked() {
            state.example = None;
        }
    });
}
