//! The map: values around the character, the target, and where actions lead.

use super::chart::Chart;
use super::heat::{Heat, Key, Plan};
use super::{State, why::name};
use crate::document::Bundle;
use crate::panels::paint::{Palette, legend, viridis};
use crate::panels::words;
use crate::run::{Candidate, Why};
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Response, RichText, Role, Sense, Shape, Stroke, Ui, Vec2 as Span,
    WidgetInfo,
};
use glam::{Vec2, Vec3};
use throng_runtime::policy::PolicyTable;

/// The arrow of an action is at least as long, so that it shows beside the character. [Unit: points]
const MIN_ARROW: f32 = 30.0;

/// Largest side of the map. [Unit: points]
const LARGEST: f32 = 460.0;

/// What is shown on the map.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    /// Generation of the document.
    pub document: u64,
    /// The bundle.
    pub bundle: &'a Bundle,
    /// The behaviour.
    pub policy: &'a PolicyTable<'a>,
    /// Its number.
    pub number: usize,
    /// State whose values are shown.
    pub state: u32,
    /// Choice of the selected character, where it was made in that state.
    pub why: Option<&'a Why>,
    /// Target as the selected character sees it now. [Unit: m]
    pub target_now: Option<Vec3>,
}

/// Shows the map with its options and legend.
pub fn show(ui: &mut Ui, shown: &Shown<'_>, own: &mut State) {
    options(ui, shown, own);
    let side = ui.available_width().min(LARGEST);
    let (rect, response) = ui.allocate_exact_size(Span::splat(side), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Values around the character"));
    let key = Key {
        document: shown.document,
        policy: shown.number,
        state: shown.state,
        height: own.height,
        smooth: own.smooth,
        rect,
    };
    if own.heat.as_ref().is_none_or(|h| h.key != key) {
        own.heat = Some(Heat::new(key, shown.policy, &shown.bundle.tables().graph()));
    }
    let Some(heat) = &own.heat else { return };
    let painter = ui.painter_at(rect);
    painter.add(Shape::mesh(heat.mesh.clone()));
    directions(ui, &painter, shown, &heat.plan);
    if own.arrows {
        heat.arrows.iter().for_each(|&[from, to]| arrow(&painter, from, to, 1.0, Color32::WHITE));
    }
    choice(&painter, shown, own, &heat.plan);
    targets(&painter, shown, &heat.plan);
    tell(response, shown, own, heat);
    ui.horizontal_wrapped(|ui| {
        legend(ui, heat.range, &format!("value by {}", name(shown.bundle, shown.number)), viridis::map)
    });
    ui.horizontal_wrapped(|ui| {
        ui.weak("cross: target now; ring: when it chose;");
        ui.colored_label(Palette::of(ui.visuals()).character, "action taken (lengthened);");
        let scale =
            if heat.arrow_scale < 1.0 { format!(" at {:.0} %", 100.0 * heat.arrow_scale) } else { String::new() };
        ui.weak(format!("small arrows: best action if the target were there{scale}"));
    });
}

fn options(ui: &mut Ui, shown: &Shown<'_>, own: &mut State) {
    let heights = shown.policy.grid().record().num_heights;
    own.height = own.height.min(heights - 1);
    ui.horizontal_wrapped(|ui| {
        ui.selectable_value(&mut own.smooth, false, "cells").on_hover_text("The stored value of every cell");
        ui.selectable_value(&mut own.smooth, true, "interpolated").on_hover_text("Values as the look-ahead reads them");
        ui.checkbox(&mut own.arrows, "best actions");
        if heights > 1 {
            let chart = Chart::new(shown.policy.grid());
            let slider = eframe::egui::Slider::new(&mut own.height, 0..=heights - 1).text("height");
            ui.add(slider.custom_formatter(move |n, _| format!("{:.2} m", chart.height(n as u32))));
        }
    });
}

/// The character, and which way is which.
fn directions(ui: &Ui, painter: &Painter, shown: &Shown<'_>, plan: &Plan) {
    let chart = Chart::new(shown.policy.grid());
    let radius = chart.rim() * plan.per_m;
    let weak = ui.visuals().weak_text_color();
    let font = FontId::proportional(11.0);
    let up = plan.centre - Span::new(0.0, radius + 3.0);
    painter.text(up, Align2::CENTER_BOTTOM, "ahead", font.clone(), weak);
    let down = plan.centre + Span::new(0.0, radius + 3.0);
    painter.text(down, Align2::CENTER_TOP, "behind", font, weak);
    painter.circle_stroke(plan.centre, radius, Stroke::new(1.0, weak.gamma_multiply(0.5)));
    let c = plan.centre;
    let nose =
        vec![c + Span::new(0.0, -7.0), c + Span::new(5.0, 5.0), c + Span::new(0.0, 2.0), c + Span::new(-5.0, 5.0)];
    painter.add(Shape::convex_polygon(nose, Color32::WHITE, Stroke::new(1.5, Color32::BLACK)));
}

fn choice(painter: &Painter, shown: &Shown<'_>, own: &State, plan: &Plan) {
    let Some(why) = shown.why else { return };
    let tip = |c: &Candidate| {
        let to = plan.screen(Vec2::new(c.displacement.x, c.displacement.z)) - plan.centre;
        // A step is small on a map of many metres; one that stays where it is has no direction.
        let length = if to.length() > 2.0 { to.length().max(MIN_ARROW) } else { 0.0 };
        plan.centre + to.normalized() * length
    };
    if let Some(taken) = why.candidates.get(why.chosen) {
        arrow(painter, plan.centre, tip(taken), 2.6, Palette::CHARACTER_ON_MAP);
    }
    for (segment, width) in [(own.picked, 2.0), (own.hovered_before, 2.6)] {
        if let Some(c) = why.candidates.iter().find(|c| Some(c.segment) == segment) {
            arrow(painter, plan.centre, tip(c), width, Palette::POINTED_ON_MAP);
        }
    }
}

fn targets(painter: &Painter, shown: &Shown<'_>, plan: &Plan) {
    let grid = shown.policy.grid();
    let at = |t: Vec3| {
        let c = grid.clamp(t);
        (plan.screen(Vec2::new(c.x, c.z)), !grid.contains(t))
    };
    let ring = |p: Pos2, r: f32| {
        painter.circle_stroke(p, r, Stroke::new(4.0, Color32::from_black_alpha(170)));
        painter.circle_stroke(p, r, Stroke::new(2.0, Color32::WHITE));
    };
    if let Some(why) = shown.why {
        ring(at(why.local_target).0, 5.0);
    }
    if let Some((p, beyond)) = shown.target_now.map(at) {
        ring(p, 7.0);
        for d in [Span::new(10.0, 0.0), Span::new(0.0, 10.0)] {
            painter.line_segment([p - d, p + d], Stroke::new(1.5, Color32::WHITE));
        }
        if beyond && (p - plan.centre).length() > 20.0 {
            let out = (p - plan.centre).normalized();
            arrow(painter, p + out * 3.0, p + out * 16.0, 2.0, Color32::WHITE);
        }
    }
}

/// An arrow that shows on every colour; a dot where it leads nowhere.
fn arrow(painter: &Painter, from: Pos2, to: Pos2, width: f32, colour: Color32) {
    let way = to - from;
    let shade = Color32::from_black_alpha(130);
    if way.length() < 2.0 {
        painter.circle_filled(from, width + 0.8, shade);
        painter.circle_filled(from, width, colour);
        return;
    }
    let ahead = way.normalized();
    let size = (3.0 + 2.0 * width).min(0.6 * way.length());
    let aside = Span::new(-ahead.y, ahead.x) * 0.55 * size;
    let base = to - ahead * size;
    painter.line_segment([from, base], Stroke::new(width + 1.6, shade));
    let head = vec![to, base + aside, base - aside];
    painter.add(Shape::convex_polygon(head, colour, Stroke::new(0.8, shade)));
    painter.line_segment([from, base], Stroke::new(width, colour));
}

/// Says what the value is under the pointer, and what would be done there.
fn tell(response: Response, shown: &Shown<'_>, own: &State, heat: &Heat) {
    let Some(point) = response.hover_pos() else { return };
    let chart = Chart::new(shown.policy.grid());
    let place = heat.plan.ground(point);
    if !chart.covers(place) {
        return;
    }
    let target = chart.target(place, own.height);
    let cell = shown.policy.grid().nearest_cell(target);
    let own_cell = shown.policy.own_cell(shown.state, cell);
    let value = if own.smooth {
        shown.policy.value(shown.state, target)
    } else {
        shown.policy.values_of(shown.state)[own_cell]
    };
    let graph = shown.bundle.tables().graph();
    let best = usize::from(shown.policy.best_of(shown.state, own_cell)[0]);
    let segment = graph.segments_of(shown.state)[best];
    response.on_hover_ui_at_pointer(|ui| {
        ui.label(RichText::new(format!("value {}", words::number(value))).strong());
        ui.label(format!("target {}", words::place(place)));
        let centre = shown.policy.grid().cell_coordinates(cell);
        ui.label(format!("cell {cell}: {:.2} m, {}", centre.y, words::direction(centre.x)));
        ui.label(format!("best: {}", shown.bundle.describe_segment(segment)));
        ui.label(words::way(graph.segments[segment as usize].displacement()));
    });
}
