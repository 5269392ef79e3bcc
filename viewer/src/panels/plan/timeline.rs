//! Timeline of a task: when limbs leave the clip, reach, and are back; below it the trees of the searches and the
//! paths of hands, one direction of space over time.

use crate::command::{Commands, PlanViewOptions, ViewerCommand};
use crate::document::TaskDocument;
use crate::model::Model;
use crate::panels::paint::{FrameAxis, FrameSpan, RULER_HEIGHT, ruler};
use crate::stage::task::{TREES, colour_of_node, end_of_limb, inspected_steps};
use crate::theme::ThemePalette;
use eframe::egui::epaint::Mesh;
use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
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

/// A direction of space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlotDirection {
    /// +X.
    X,
    /// Up.
    #[default]
    Up,
    /// +Z.
    Z,
}

impl PlotDirection {
    const ALL: [(Self, &'static str); 3] = [(Self::Up, "height"), (Self::X, "x"), (Self::Z, "z")];

    fn component(self, p: DVec3) -> f64 {
        match self {
            Self::X => p.x,
            Self::Up => p.y,
            Self::Z => p.z,
        }
    }
}

/// Shows it; a click or a drag moves the play head.
pub fn show(
    ui: &mut Ui,
    model: &Model,
    task: &TaskDocument,
    along: &mut PlotDirection,
    wanted: &mut PlanViewOptions,
    commands: &mut Commands,
) {
    ui.horizontal_wrapped(|ui| {
        ui.strong("Over time");
        ui.checkbox(&mut wanted.trees, "trees").on_hover_text("Where hands and feet are in the trees of the searches");
        for (direction, name) in PlotDirection::ALL {
            ui.selectable_value(along, direction, name);
        }
        for (colour, name) in TREES.into_iter().zip(["from the start", "from the goal"]) {
            let [r, g, b, _] = colour.0;
            ui.colored_label(Color32::from_rgb(r, g, b), name);
        }
    });
    let (windows, (num_frames, rate_hz)) = (task.task().windows_s(), task.frames());
    let height = RULER_HEIGHT + ROW * windows.len() as f32 + 4.0 + if wanted.trees { PLOT } else { 0.0 };
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click_and_drag());
    let x = (rect.left() + LEFT..=rect.right() - 4.0).into();
    let axis = FrameAxis { span: span(task, &windows), x, rate_hz, num_frames };
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    ruler(ui, Rect::from_x_y_ranges(axis.x, rect.top()..=rect.top() + RULER_HEIGHT), &axis);
    let rows = Rect::from_min_size(rect.min + vec2(0.0, RULER_HEIGHT), vec2(rect.width(), ROW * windows.len() as f32));
    bars(ui, &painter, rows, &axis, &windows, wanted.step);
    if wanted.trees {
        let at = Rect::from_x_y_ranges(axis.x, rows.bottom() + 4.0..=rect.bottom());
        plot(ui, &painter, at, &axis, model, task, *along);
    }
    let head = axis.x_of(model.player.frame.round());
    if axis.x.contains(head) {
        painter.vline(head, rect.y_range(), Stroke::new(1.5, ThemePalette::for_visuals(ui.visuals()).head));
    }
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked() || response.dragged()) {
        commands.push(ViewerCommand::Seek(axis.frame_at(at.x)));
    }
    response.on_hover_text("Click or drag to move through the clip");
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

/// Bars of the times at which each limb leaves the clip, reaches, and is back.
fn bars(
    ui: &Ui,
    painter: &Painter,
    rows: Rect,
    axis: &FrameAxis,
    windows: &[Option<[f64; 3]>],
    selected: Option<usize>,
) {
    let palette = ThemePalette::for_visuals(ui.visuals());
    for (i, window) in windows.iter().enumerate() {
        let top = rows.top() + ROW * i as f32;
        let y = pos2(rows.left() + LEFT - 4.0, top + 0.5 * ROW);
        let weak = ui.visuals().weak_text_color();
        painter.text(y, Align2::RIGHT_CENTER, format!("{}", i + 1), FontId::proportional(10.5), weak);
        let Some(window) = window else { continue };
        let at = |s: f64| axis.x_of((s.min(1e6) * f64::from(axis.rate_hz)) as f32).clamp(axis.x.min, axis.x.max);
        let bar = Rect::from_x_y_ranges(at(window[0])..=at(window[2]), top + 3.0..=top + ROW - 3.0);
        let colour = if selected.is_none_or(|s| s == i) { palette.right } else { palette.right.gamma_multiply(0.35) };
        painter.rect_filled(bar, 2.0, colour.gamma_multiply(0.55));
        if window[1] > window[0] {
            painter.vline(at(window[1]), bar.y_range(), Stroke::new(2.5, colour));
        }
    }
}

/// One direction over time: nodes and edges of trees, and the planned hand.
fn plot(
    ui: &Ui,
    painter: &Painter,
    rect: Rect,
    axis: &FrameAxis,
    model: &Model,
    task: &TaskDocument,
    along: PlotDirection,
) {
    painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
    let done: Vec<&StepOutcome> = inspected_steps(model, task).filter(|d| !d.trees.is_empty()).collect();
    let nodes = || done.iter().flat_map(|d| &d.trees).flat_map(|g| g.trees.iter().flatten());
    let [low, high] = nodes().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], n| {
        let v = along.component(n.tip);
        [low.min(v), high.max(v)]
    });
    if low > high {
        let text = if task.planning().is_some() { "planning …" } else { "no search was needed, or none is shown" };
        painter.text(
            rect.center(),
            Align2::CENTER_CENTER,
            text,
            FontId::proportional(12.0),
            ui.visuals().weak_text_color(),
        );
        return;
    }
    let (low, high) = (low - 0.05, high + 0.05);
    let y_of = |v: f64| rect.bottom() - ((v - low) / (high - low)) as f32 * rect.height();
    let point =
        |at: DVec3, time_s: f64| pos2(axis.x_of((time_s * f64::from(axis.rate_hz)) as f32), y_of(along.component(at)));
    for (v, anchor) in [(low, Align2::RIGHT_BOTTOM), (high, Align2::RIGHT_TOP)] {
        let at = pos2(rect.left() - 4.0, y_of(v));
        painter.text(at, anchor, format!("{v:.2}"), FontId::proportional(10.5), ui.visuals().weak_text_color());
    }
    let painter = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
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
                let [r, g, b, _] = TREES[k].0;
                painter.circle_filled(point(root.tip, root.time_s), 3.0, Color32::from_rgb(r, g, b));
            }
        }
    }
    painter.add(mesh);
    hands(&painter, task, &done, &point, ThemePalette::for_visuals(ui.visuals()).head);
}

/// Paths of the ends of limbs in the shown motion.
fn hands(
    painter: &Painter,
    task: &TaskDocument,
    done: &[&StepOutcome],
    point: &dyn Fn(DVec3, f64) -> Pos2,
    colour: Color32,
) {
    for done in done {
        let clip = task.clip(done.character);
        let last = clip.num_frames() - 1;
        for grown in &done.trees {
            let frames = grown.window_s.map(|t| ((t * clip.rate_hz).round() as usize).min(last));
            let points =
                (frames[0]..=frames[1]).map(|f| point(end_of_limb(task, done, clip, f), f as f64 / clip.rate_hz));
            painter.line(points.collect(), Stroke::new(2.0, colour));
        }
    }
}

/// A straight line as two triangles: thousands of them are one mesh.
fn line(mesh: &mut Mesh, [a, b]: [Pos2; 2], half_width: f32, colour: Color32) {
    let across = (b - a).rot90().normalized() * half_width;
    let first = mesh.vertices.len() as u32;
    for p in [a + across, a - across, b - across, b + across] {
        mesh.colored_vertex(p, colour);
    }
    mesh.add_triangle(first, first + 1, first + 2);
    mesh.add_triangle(first, first + 2, first + 3);
}
