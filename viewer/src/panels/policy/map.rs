//! The map: values around the character, the target, and where actions lead.

use super::heat::{HeatKey, HeatPicture, MapProjection};
use super::{PolicyPanelState, chart::PolicyChart, why::behaviour_name};
use crate::panels::paint::{PanelWidget, legend};
use crate::run::{ActionCandidate, ChoiceReason};
use crate::theme::{ThemePalette, viridis};
use crate::{bundle::OpenBundle, panels::words, volume::Volume};
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Response, Role, Sense, Shape, Slider, Stroke, StrokeKind, Ui,
    Vec2 as Span, pos2, vec2,
};
use glam::{Vec2, Vec3};
use throng_core::policy::PolicyTable;

/// The arrow of an action is at least as long, so that it shows beside the character (points).
const MIN_ARROW: f32 = 30.0;

/// Largest side of the map (points).
const LARGEST: f32 = 460.0;

/// Space around the only map, for the words "ahead" and so on, and around one of many (points).
const MARGINS: [f32; 2] = [18.0, 5.0];

/// Input of the map.
#[derive(Clone, Copy)]
pub struct PolicyMapInput<'a> {
    /// Generation of the document.
    pub document: u64,
    /// The bundle.
    pub bundle: &'a OpenBundle,
    /// The behaviour.
    pub policy: &'a PolicyTable,
    /// Number of the behaviour.
    pub number: usize,
    /// State whose values are shown.
    pub state: u32,
    /// Choice of the selected character, if it was made in this state.
    pub why: Option<&'a ChoiceReason>,
    /// Target as the selected character sees it now, and as it saw it when it chose (m).
    pub targets: [Option<Vec3>; 2],
}

impl PolicyMapInput<'_> {
    /// The grid of the state from above.
    pub fn chart(&self) -> PolicyChart {
        PolicyChart::new(&self.policy.grid_of(self.state))
    }

    /// Centre of the grid over ground (m).
    pub fn centre(&self) -> Vec2 {
        Vec2::new(self.policy.centre().x, self.policy.centre().z)
    }
}

/// Shows the map, or the maps of all heights, with options and legend.
pub fn show(ui: &mut Ui, shown: &PolicyMapInput<'_>, own: &mut PolicyPanelState) {
    options(ui, shown, own);
    let heights = shown.policy.grid_of(shown.state).record().num_heights;
    let arrow_scale = if own.slices && heights > 1 {
        show_slices(ui, shown, own)
    } else {
        let side = ui.available_width().min(LARGEST);
        let (rect, response) = ui.allocate_exact_size(Span::splat(side), Sense::hover());
        let response = response.named(Role::Canvas, "Values around the character");
        own.heats.truncate(1);
        own.paint(ui, shown, own.slice, rect, response)
    };
    let range = own.heats.first().map_or([0.0, 1.0], |h| h.range);
    ui.horizontal_wrapped(|ui| {
        legend(ui, range, &format!("value by {}", behaviour_name(shown.bundle, shown.number)), viridis::map)
    });
    ui.horizontal_wrapped(|ui| {
        ui.weak("cross: target now; ring: when it chose;");
        ui.colored_label(ThemePalette::for_visuals(ui.visuals()).character, "action taken (lengthened);");
        let scale = if arrow_scale < 1.0 { format!(" at {:.0} %", 100.0 * arrow_scale) } else { String::new() };
        ui.weak(format!("small arrows: best action if the target were there{scale}"));
    });
}

impl PolicyPanelState {
    /// Paints one height into a part of the screen; returns the scale of its arrows.
    ///
    /// - `height`: number of the height.
    pub fn paint(&mut self, ui: &Ui, shown: &PolicyMapInput<'_>, height: u32, rect: Rect, response: Response) -> f32 {
        let margin = MARGINS[usize::from(self.slices)];
        let (document, policy, state) = (shown.document, shown.number, shown.state);
        let key = HeatKey { document, policy, state, height, rect, margin };
        // One picture is kept for each map.
        let at = if self.slices { height as usize } else { 0 };
        if self.heats.get(at).is_none_or(|h| h.key != key) {
            let heat = HeatPicture::new(key, shown.policy, shown.bundle.tables().graph());
            self.heats.truncate(at);
            self.heats.push(heat);
        }
        let Some(heat) = self.heats.get(at) else { return 1.0 };
        let painter = ui.painter_at(rect);
        painter.add(Shape::mesh(heat.mesh.clone()));
        if !self.slices {
            directions(ui, &painter, shown, &heat.plan);
        }
        region(&painter, shown, height, &heat.plan);
        nose(&painter, &heat.plan, if self.slices { 0.7 } else { 1.0 });
        if self.arrows {
            heat.arrows.iter().for_each(|&[from, to]| arrow(&painter, from, to, 1.0, Color32::WHITE));
        }
        choice(&painter, shown, self, &heat.plan);
        targets(&painter, shown, height, &heat.plan);
        show_tooltip(response, shown, heat);
        heat.arrow_scale
    }
}

fn options(ui: &mut Ui, shown: &PolicyMapInput<'_>, own: &mut PolicyPanelState) {
    let heights = shown.policy.grid_of(shown.state).record().num_heights;
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut own.arrows, "best actions");
        if heights > 1 {
            let all = if shown.policy.grid().is_space_time() { "all times" } else { "all heights" };
            ui.checkbox(&mut own.slices, all).on_hover_text("Side by side, with the same colours");
        }
    });
    if heights > 1 && !own.slices {
        let chart = shown.chart();
        let what = if shown.policy.grid().is_space_time() { "time" } else { "height" };
        let slider = Slider::new(&mut own.slice, 0..=heights - 1).text(what);
        ui.add(slider.custom_formatter(move |n, _| chart.height_name(n as u32)));
    }
}

/// Draws the active region of the behaviour, dashed, with a note if it is not active at this height.
fn region(painter: &Painter, shown: &PolicyMapInput<'_>, height: u32, plan: &MapProjection) {
    let region = shown.policy.region();
    let Some(volume) = Volume::of_region(region) else { return };
    let mut outline: Vec<Pos2> = volume.over_ground().iter().map(|p| plan.screen(*p - shown.centre())).collect();
    outline.extend(outline.first().copied());
    let at = shown.chart().height(height);
    let is_active = shown.policy.grid().record().num_heights == 1 || (at >= region.height[0] && at <= region.height[1]);
    let colour = if is_active { Color32::WHITE } else { Color32::from_white_alpha(110) };
    painter.extend(Shape::dashed_line(&outline, Stroke::new(1.2, colour), 5.0, 4.0));
}

/// Labels the directions on a grid that goes all around.
fn directions(ui: &Ui, painter: &Painter, shown: &PolicyMapInput<'_>, plan: &MapProjection) {
    let chart = shown.chart();
    let radius = chart.rim();
    let weak = ui.visuals().weak_text_color();
    let font = FontId::proportional(11.0);
    let ahead = plan.screen(Vec2::new(0.0, radius)) - Span::new(0.0, 3.0);
    painter.text(ahead, Align2::CENTER_BOTTOM, "ahead", font.clone(), weak);
    if shown.policy.grid().is_polar() {
        let behind = plan.screen(Vec2::new(0.0, -radius)) + Span::new(0.0, 3.0);
        painter.text(behind, Align2::CENTER_TOP, "behind", font, weak);
        painter.circle_stroke(plan.screen(Vec2::ZERO), radius * plan.per_m, Stroke::new(1.0, weak.gamma_multiply(0.5)));
    }
}

/// The character, which faces up.
fn nose(painter: &Painter, plan: &MapProjection, size: f32) {
    let corners = [Span::new(0.0, -7.0), Span::new(5.0, 5.0), Span::new(0.0, 2.0), Span::new(-5.0, 5.0)];
    let points = corners.map(|d| plan.character + d * size).to_vec();
    painter.add(Shape::convex_polygon(points, Color32::WHITE, Stroke::new(1.5 * size, Color32::BLACK)));
}

fn choice(painter: &Painter, shown: &PolicyMapInput<'_>, own: &PolicyPanelState, plan: &MapProjection) {
    let Some(why) = shown.why else { return };
    let tip = |c: &ActionCandidate| {
        let to = Span::new(-c.displacement.x, -c.displacement.z) * plan.per_m;
        // A step is small on a map of many metres; an action without displacement has no direction.
        let length = if to.length() > 2.0 { to.length().max(MIN_ARROW) } else { 0.0 };
        plan.character + to.normalized() * length
    };
    if let Some(taken) = why.candidates.get(why.chosen) {
        arrow(painter, plan.character, tip(taken), 2.6, ThemePalette::CHARACTER_ON_MAP);
    }
    for (segment, width) in [(own.picked, 2.0), (own.hovered_before, 2.6)] {
        if let Some(c) = why.candidates.iter().find(|c| Some(c.segment) == segment) {
            arrow(painter, plan.character, tip(c), width, ThemePalette::POINTED_ON_MAP);
        }
    }
}

/// The target now and when it chose, on the map of the height that is nearest to it.
fn targets(painter: &Painter, shown: &PolicyMapInput<'_>, height: u32, plan: &MapProjection) {
    let (grid, chart) = (shown.policy.grid(), shown.chart());
    let at = |t: Vec3| {
        let t = shown.policy.to_grid(t);
        let c = grid.clamp(t);
        (plan.screen(Vec2::new(c.x, c.z)), !grid.contains(t))
    };
    let [now, then] = shown.targets.map(|t| t.filter(|t| chart.nearest_height(t.y) == height).map(at));
    let ring = |p: Pos2, r: f32| {
        painter.circle_stroke(p, r, Stroke::new(4.0, Color32::from_black_alpha(170)));
        painter.circle_stroke(p, r, Stroke::new(2.0, Color32::WHITE));
    };
    if let Some((p, _)) = then {
        ring(p, 5.0);
    }
    if let Some((p, beyond)) = now {
        ring(p, 7.0);
        for d in [Span::new(10.0, 0.0), Span::new(0.0, 10.0)] {
            painter.line_segment([p - d, p + d], Stroke::new(1.5, Color32::WHITE));
        }
        let centre = plan.screen(Vec2::ZERO);
        if beyond && (p - centre).length() > 20.0 {
            let out = (p - centre).normalized();
            arrow(painter, p + out * 3.0, p + out * 16.0, 2.0, Color32::WHITE);
        }
    }
}

/// An arrow that shows on every colour; a dot where it leads nowhere.
fn arrow(painter: &Painter, from: Pos2, to: Pos2, width: f32, colour: Color32) {
    let offset = to - from;
    let shade = Color32::from_black_alpha(130);
    if offset.length() < 2.0 {
        painter.circle_filled(from, width + 0.8, shade);
        painter.circle_filled(from, width, colour);
        return;
    }
    let ahead = offset.normalized();
    let size = (3.0 + 2.0 * width).min(0.6 * offset.length());
    let aside = Span::new(-ahead.y, ahead.x) * 0.55 * size;
    let base = to - ahead * size;
    painter.line_segment([from, base], Stroke::new(width + 1.6, shade));
    let head = vec![to, base + aside, base - aside];
    painter.add(Shape::convex_polygon(head, colour, Stroke::new(0.8, shade)));
    painter.line_segment([from, base], Stroke::new(width, colour));
}

/// Shows a tooltip with the value under the pointer, and the best action there.
fn show_tooltip(response: Response, shown: &PolicyMapInput<'_>, heat: &HeatPicture) {
    let Some(point) = response.hover_pos() else { return };
    let (chart, height) = (shown.chart(), heat.key.height);
    let place = heat.plan.ground(point);
    if !chart.covers(place) {
        return;
    }
    let target = chart.target(place, height) + shown.policy.centre();
    let cell = shown.policy.nearest_cell(shown.state, target);
    let value = shown.policy.values_of(shown.state)[cell];
    let graph = shown.bundle.tables().graph();
    let best = usize::from(shown.policy.best_of(shown.state, cell)[0]);
    let segment = graph.segments_of(shown.state)[best];
    let of_heights = shown.policy.grid_of(shown.state).record().num_heights > 1;
    response.on_hover_ui_at_pointer(|ui| {
        ui.strong(format!("value {}", words::number(value)));
        let height = if of_heights { format!(", {}", chart.height_name(height)) } else { String::new() };
        ui.label(format!("target {}{height}", words::place(Vec2::new(target.x, target.z))));
        if !shown.policy.region().contains(target) {
            ui.label("not active there");
        }
        let centre = shown.policy.grid_of(shown.state).cell_coordinates(cell);
        ui.label(format!("cell {cell}: {:.2} m, {}", centre.y, words::direction(centre.x)));
        ui.label(format!("best: {}", shown.bundle.describe_segment(segment)));
        ui.label(words::displacement(graph.segments[segment as usize].displacement()));
    });
}

/// Least width of one map (points).
const LEAST: f32 = 104.0;
/// Height of its title (points).
const TITLE: f32 = 15.0;
/// Space between maps (points).
const GAP: f32 = 4.0;

/// Shows the maps; a click shows one of them alone. Returns the least scale of their arrows.
fn show_slices(ui: &mut Ui, shown: &PolicyMapInput<'_>, own: &mut PolicyPanelState) -> f32 {
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
        let is_chosen = own.slice == k;
        let colour = if is_chosen { visuals.strong_text_color() } else { visuals.weak_text_color() };
        ui.painter().text(tile.center_top(), Align2::CENTER_TOP, &name, FontId::proportional(11.0), colour);
        if is_chosen || response.hovered() {
            ui.painter().rect_stroke(tile, 3.0, Stroke::new(1.0, colour), StrokeKind::Inside);
        }
        if response.clicked() {
            (own.slice, own.slices) = (k, false);
        }
        let map = tile.with_min_y(tile.top() + TITLE);
        arrow_scale = arrow_scale.min(own.paint(ui, shown, k, map, response));
    }
    arrow_scale
}
