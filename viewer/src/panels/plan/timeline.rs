//! Timeline of a task: when limbs leave the clip, reach, and are back; below it the trees of the searches and the
//! paths of hands, one direction of space over time.

use crate::panels::paint::{FrameAxis, FrameSpan, RULER_HEIGHT, ruler};
use crate::stage::task::{TREES, colour_of_node, end_of_limb, inspected_steps};
use crate::theme::ThemePalette;
use crate::{command::PlanViewOptions, document::TaskDocument, model::Model, panels::colour_of_view};
use eframe::egui::epaint::Mesh;
use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Sense, Stroke, Ui, Visuals, pos2, vec2};
use glam::DVec3;
use throng_planner::task::StepOutcome;

/// Height of a row of something to do (points).
const ROW: f32 = 14.0;
/// Height of the plot below (points).
const PLOT: f32 = 150.0;
/// Space for numbers at the left (points).
const LEFT: f32 = 34.0;
/// Time shown around the steps (s).
const AROUND_S: f64 = 0.3;
/// Nodes of a tree that are drawn at most.
const MAX_NODES: usize = 6000;

/// Directions of space that the plot may show over time, with their names.
const DIRECTIONS: [(DVec3, &str); 3] = [(DVec3::Y, "height"), (DVec3::X, "x"), (DVec3::Z, "z")];

/// Shows it; returns the frame that the play head is moved to by a click or a drag.
///
/// - `along`: number of the shown direction.
pub fn show(ui: &mut Ui, model: &Model, along: &mut usize, wanted: &mut PlanViewOptions) -> Option<u32> {
    let task = model.document.task()?;
    ui.horizontal_wrapped(|ui| {
        ui.strong("Over time");
        ui.checkbox(&mut wanted.trees, "trees").on_hover_text("Where hands and feet are in the trees of the searches");
        for (direction, (_, name)) in DIRECTIONS.into_iter().enumerate() {
            ui.selectable_value(along, direction, name);
        }
        for (colour, name) in TREES.into_iter().zip(["from the start", "from the goal"]) {
            ui.colored_label(colour_of_view(colour), name);
        }
    });
    let (windows, (num_frames, rate_hz)) = (task.task().windows_s(), task.frames());
    let height = RULER_HEIGHT + ROW * windows.len() as f32 + 4.0 + if wanted.trees { PLOT } else { 0.0 };
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click_and_drag());
    let x = (rect.left() + LEFT..=rect.right() - 4.0).into();
    let axis = FrameAxis { span: span(task, &windows), x, rate_hz, num_frames };
    ruler(ui, Rect::from_x_y_ranges(axis.x, rect.top()..=rect.top() + RULER_HEIGHT), &axis);
    let rows = Rect::from_min_size(rect.min + vec2(0.0, RULER_HEIGHT), vec2(rect.width(), ROW * windows.len() as f32));
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let palette = ThemePalette::for_visuals(ui.visuals());
    let plot = TaskPlot { visuals: ui.visuals(), palette, painter, axis, task };
    plot.bars(rows, &windows, wanted.step);
    if wanted.trees {
        let at = Rect::from_x_y_ranges(axis.x, rows.bottom() + 4.0..=rect.bottom());
        let done: Vec<&StepOutcome> = inspected_steps(model, task).filter(|d| !d.trees.is_empty()).collect();
        plot.trees(at, &done, DIRECTIONS[*along].0);
    }
    let head = axis.x_of(model.player.frame.round());
    if axis.x.contains(head) {
        plot.painter.vline(head, rect.y_range(), Stroke::new(1.5, palette.head));
    }
    let at = response.interact_pointer_pos().filter(|_| response.clicked() || response.dragged());
    response.on_hover_text("Click or drag to move through the clip");
    at.map(|at| axis.frame_at(at.x))
}

/// From a little before the first thing to do until a little after the last one.
fn span(task: &TaskDocument, windows: &[Option<[f64; 3]>]) -> FrameSpan {
    let (num_frames, rate_hz) = task.frames();
    let whole = FrameSpan::whole(num_frames);
    let timed = windows.iter().flatten().filter(|w| w[2].is_finite());
    let spans = task.shown_motion().into_iter().flat_map(|m| m.outcome.done.iter().flat_map(|d| &d.trees));
    let ends = timed.map(|w| [w[0], w[2]]).chain(spans.map(|g| g.window_s));
    let both = ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let Some([from, to]) = both else { return whole };
    let frame = |s: f64| (s * f64::from(rate_hz)) as f32;
    FrameSpan { from: frame(from - AROUND_S).max(whole.from), to: frame(to + AROUND_S).min(whole.to) }
}

/// Input shared by the parts of the timeline.
struct TaskPlot<'a> {
    visuals: &'a Visuals,
    palette: ThemePalette,
    painter: Painter,
    axis: FrameAxis,
    task: &'a TaskDocument,
}

impl TaskPlot<'_> {
    fn x_of(&self, time_s: f64) -> f32 {
        self.axis.x_of((time_s * f64::from(self.axis.rate_hz)) as f32)
    }

    /// Bars of the times at which each limb leaves the clip, reaches, and is back.
    fn bars(&self, rows: Rect, windows: &[Option<[f64; 3]>], selected: Option<usize>) {
        for (i, window) in windows.iter().enumerate() {
            let top = rows.top() + ROW * i as f32;
            let at = pos2(rows.left() + LEFT - 4.0, top + 0.5 * ROW);
            self.paint_number(at, Align2::RIGHT_CENTER, format!("{}", i + 1));
            let Some(window) = window else { continue };
            let x = |s: f64| self.x_of(s.min(1e6)).clamp(self.axis.x.min, self.axis.x.max);
            let bar = Rect::from_x_y_ranges(x(window[0])..=x(window[2]), top + 3.0..=top + ROW - 3.0);
            let right = self.palette.right;
            let colour = if selected.is_none_or(|s| s == i) { right } else { right.gamma_multiply(0.35) };
            self.painter.rect_filled(bar, 2.0, colour.gamma_multiply(0.55));
            if window[1] > window[0] {
                self.painter.vline(x(window[1]), bar.y_range(), Stroke::new(2.5, colour));
            }
        }
    }

    fn paint_number(&self, at: Pos2, anchor: Align2, text: String) {
        self.painter.text(at, anchor, text, FontId::proportional(10.5), self.visuals.weak_text_color());
    }

    /// One direction over time: nodes and edges of trees, and the planned hand.
    fn trees(&self, rect: Rect, done: &[&StepOutcome], along: DVec3) {
        self.painter.rect_filled(rect, 0.0, self.visuals.extreme_bg_color);
        let nodes = done.iter().flat_map(|d| &d.trees).flat_map(|g| g.trees.iter().flatten());
        let [low, high] = nodes.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], n| {
            let v = along.dot(n.tip);
            [low.min(v), high.max(v)]
        });
        if low > high {
            let is_planning = self.task.planning.is_some();
            let text = if is_planning { "planning …" } else { "no search was needed, or none is shown" };
            let (font, weak) = (FontId::proportional(12.0), self.visuals.weak_text_color());
            self.painter.text(rect.center(), Align2::CENTER_CENTER, text, font, weak);
            return;
        }
        let (low, high) = (low - 0.05, high + 0.05);
        let y_of = |v: f64| rect.bottom() - ((v - low) / (high - low)) as f32 * rect.height();
        let point = |at: DVec3, time_s: f64| pos2(self.x_of(time_s), y_of(along.dot(at)));
        for (v, anchor) in [(low, Align2::RIGHT_BOTTOM), (high, Align2::RIGHT_TOP)] {
            self.paint_number(pos2(rect.left() - 4.0, y_of(v)), anchor, format!("{v:.2}"));
        }
        let painter = self.painter.with_clip_rect(rect.intersect(self.painter.clip_rect()));
        let mut mesh = Mesh::default();
        for grown in done.iter().flat_map(|d| &d.trees) {
            for (k, tree) in grown.trees.iter().enumerate() {
                for node in tree.iter().skip(1).step_by(tree.len() / MAX_NODES + 1) {
                    let [r, g, b, a] = colour_of_node(k, grown, node.time_s).0;
                    let parent = &tree[node.parent];
                    let ends = [point(parent.tip, parent.time_s), point(node.tip, node.time_s)];
                    line(&mut mesh, ends, 0.6, Color32::from_rgba_unmultiplied(r, g, b, a));
                }
                if let Some(root) = tree.first() {
                    painter.circle_filled(point(root.tip, root.time_s), 3.0, colour_of_view(TREES[k]));
                }
            }
        }
        painter.add(mesh);
        // Paths of the ends of limbs in the shown motion.
        for done in done {
            let clip = self.task.clip(done.character);
            let last = clip.num_frames() - 1;
            for grown in &done.trees {
                let [first, last] = grown.window_s.map(|t| ((t * clip.rate_hz).round() as usize).min(last));
                let place = |f: usize| point(end_of_limb(self.task, done, clip, f), f as f64 / clip.rate_hz);
                painter.line((first..=last).map(place).collect(), Stroke::new(2.0, self.palette.head));
            }
        }
    }
}

/// A straight line as two triangles: thousands of them are one mesh.
fn line(mesh: &mut Mesh, [a, b]: [Pos2; 2], half_width: f32, colour: Color32) {
    let across = (b - a).rot90().normalized() * half_width;
    let first = mesh.vertices.len() as u32;
    [a + across, a - across, b - across, b + across].into_iter().for_each(|p| mesh.colored_vertex(p, colour));
    mesh.add_triangle(first, first + 1, first + 2);
    mesh.add_triangle(first, first + 2, first + 3);
}
