//! Paints the graph: clips, segments, states, and the links of the selected states.

use super::layout::{ClipLane, GraphLayout, SegmentBar};
use super::links::{ActionLink, ActionLinks, outgoing};
use super::view::GraphScale;
use crate::bundle::OpenBundle;
use crate::theme::{ThemePalette, viridis};
use eframe::egui::epaint::CubicBezierShape;
use eframe::egui::text::{LayoutJob, TextFormat, TextWrapping};
use eframe::egui::{Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, Ui, Vec2, pos2};
use throng_core::graph::MotionGraph;

/// Lanes narrower than this have no name (points).
const NAMED_FROM: f32 = 44.0;
/// Distance from which a state can be pointed at (points).
const REACH: f32 = 7.0;

/// Input of the drawing.
#[derive(Clone, Copy)]
pub struct GraphDrawing<'a> {
    /// The bundle.
    pub bundle: &'a OpenBundle,
    /// Places.
    pub layout: &'a GraphLayout,
    /// Links.
    pub links: &'a ActionLinks,
    /// Places on the screen.
    pub scale: GraphScale,
    /// Selected state.
    pub selected: Option<u32>,
    /// State under the pointer.
    pub hovered: Option<u32>,
    /// Segment that stands out, such as the one under the pointer in the list.
    pub marked: Option<u32>,
    /// Segment that the selected character plays, and the time within it (frames).
    pub playing: Option<(u32, f32)>,
}

impl GraphDrawing<'_> {
    /// Paints all that can be seen.
    pub fn paint(&self, ui: &Ui, painter: &Painter) {
        let focused: Vec<u32> = self.selected.into_iter().chain(self.hovered).collect();
        let graph = self.bundle.tables().graph();
        for lane in self.lanes() {
            self.paint_lane(ui, painter, lane, !focused.is_empty());
        }
        // Segments that the actions of these states play.
        for link in focused.iter().flat_map(|&state| outgoing(graph, state)) {
            let rect = self.rect(self.layout.bar(link.segment));
            if rect.intersects(self.scale.rect) {
                painter.rect_filled(rect, 1.0, self.cost_colour(ui, link.error));
            }
        }
        for &state in &focused {
            self.paint_links(ui, painter, graph, state);
        }
        self.paint_names(ui, painter);
        self.paint_states(ui, painter, graph);
        self.paint_character(ui, painter);
    }

    fn lanes(&self) -> impl Iterator<Item = &ClipLane> {
        let [low, high] = self.scale.range_s();
        let rows = &self.layout.rows[self.scale.rows(self.layout)];
        rows.iter().flat_map(|r| &self.layout.lanes[r.clone()]).filter(move |l| l.end >= low && l.start <= high)
    }

    fn rect(&self, bar: &SegmentBar) -> Rect {
        self.scale.bar(&self.layout.lanes[bar.lane as usize], bar)
    }

    fn paint_lane(&self, ui: &Ui, painter: &Painter, lane: &ClipLane, faint: bool) {
        let visuals = ui.visuals();
        let rect = self.scale.lane(lane);
        painter.rect_filled(rect.expand2(Vec2::new(2.0, 0.0)), 2.0, visuals.faint_bg_color);
        // Neighbours are kept apart if there is room.
        let gap = (0.03 * self.scale.per_s).min(1.0);
        for bar in self.layout.bars_within(lane, self.scale.range_s()) {
            let plays = self.links.plays[bar.segment as usize] as f32 / self.links.max_plays.max(1) as f32;
            let colour = viridis::line(plays.sqrt(), visuals.dark_mode);
            let colour = if faint { visuals.panel_fill.lerp_to_gamma(colour, 0.3) } else { colour };
            let rect = self.scale.bar(lane, bar);
            painter.rect_filled(rect.with_max_x((rect.right() - gap).max(rect.left() + 0.5)), 1.0, colour);
        }
    }

    /// Names over the links, so that they can be read.
    fn paint_names(&self, ui: &Ui, painter: &Painter) {
        for lane in self.lanes().filter(|_| self.scale.has_names()) {
            let rect = self.scale.lane(lane);
            let seen = rect.intersect(self.scale.rect.shrink(2.0));
            if seen.width() < NAMED_FROM {
                continue;
            }
            let (at, colour) = (pos2(seen.left(), rect.top()), ui.visuals().weak_text_color());
            let format = TextFormat::simple(FontId::proportional(11.0), colour);
            let mut job = LayoutJob::single_section(self.bundle.clip_name(lane.clip).to_owned(), format);
            let max_width = seen.width();
            job.wrap = TextWrapping { max_width, max_rows: 1, break_anywhere: true, ..TextWrapping::default() };
            let galley = painter.layout_job(job);
            let back = Rect::from_min_size(at, galley.size()).expand2(Vec2::new(2.0, 0.0));
            painter.rect_filled(back, 2.0, ui.visuals().extreme_bg_color.gamma_multiply(0.8));
            painter.galley(at, galley, colour);
        }
    }

    fn paint_links(&self, ui: &Ui, painter: &Painter, graph: &MotionGraph, state: u32) {
        let incoming = ThemePalette::for_visuals(ui.visuals()).incoming.gamma_multiply(0.7);
        for link in &self.links.incoming[state as usize] {
            self.paint_link(painter, link, Stroke::new(0.8, incoming));
        }
        for link in outgoing(graph, state) {
            self.paint_link(painter, &link, Stroke::new(1.3, self.cost_colour(ui, link.error)));
        }
        if let Some(link) = outgoing(graph, state).find(|l| Some(l.segment) == self.marked) {
            let colour = ui.visuals().strong_text_color();
            self.paint_link(painter, &link, Stroke::new(2.5, colour));
            let rect = self.rect(self.layout.bar(link.segment)).expand(1.5);
            painter.rect_stroke(rect, 1.0, Stroke::new(1.5, colour), eframe::egui::StrokeKind::Outside);
        }
    }

    /// From a state to where the next segment starts.
    fn paint_link(&self, painter: &Painter, link: &ActionLink, stroke: Stroke) {
        let Some(from) = self.state_place(link.from) else { return };
        let to = self.rect(self.layout.bar(link.segment)).left_center();
        if from.distance(to) < 2.0 {
            return;
        }
        let below = from.y - self.scale.rect.top() < 40.0;
        let points = curve(from, to, below);
        if !Rect::from_points(&points).intersects(self.scale.rect) {
            return;
        }
        painter.add(CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke));
        painter.circle_filled(to, stroke.width + 0.7, stroke.color);
    }

    fn paint_states(&self, ui: &Ui, painter: &Painter, graph: &MotionGraph) {
        let visuals = ui.visuals();
        let radius = (0.1 * self.scale.per_s).clamp(1.2, 4.0);
        let (fill, edge) = (visuals.text_color(), visuals.panel_fill);
        for lane in self.lanes() {
            for bar in self.layout.bars_within(lane, self.scale.range_s()) {
                let state = graph.segments[bar.segment as usize].end;
                let at = self.scale.bar(lane, bar).right_center();
                if graph.states[state as usize].standing != 0 {
                    let square = Rect::from_center_size(at, Vec2::splat(2.2 * radius));
                    painter.rect_filled(square, 0.0, ThemePalette::for_visuals(visuals).standing);
                } else {
                    painter.circle(at, radius, fill, Stroke::new(0.5, edge));
                }
            }
        }
        for (state, colour) in [(self.hovered, visuals.text_color()), (self.selected, visuals.strong_text_color())] {
            if let Some(at) = state.and_then(|s| self.state_place(s)) {
                painter.circle(at, radius.max(3.0) + 2.0, edge, Stroke::new(2.0, colour));
                painter.circle_filled(at, radius.max(2.0), colour);
            }
        }
    }

    /// A pointer above the bar that the character plays.
    fn paint_character(&self, ui: &Ui, painter: &Painter) {
        let Some((segment, frames)) = self.playing else { return };
        let bar = self.layout.bar(segment);
        let rect = self.rect(bar);
        let x = self.scale.x(self.layout.moment(bar, frames));
        let colour = ThemePalette::for_visuals(ui.visuals()).character;
        painter.rect_stroke(rect.expand(1.0), 1.0, Stroke::new(1.5, colour), eframe::egui::StrokeKind::Outside);
        painter.vline(x, rect.expand(3.0).y_range(), Stroke::new(2.0, colour));
        let tip = pos2(x, rect.top() - 2.0);
        let corners = vec![tip, tip + Vec2::new(-5.0, -8.0), tip + Vec2::new(5.0, -8.0)];
        painter.add(Shape::convex_polygon(corners, colour, Stroke::new(1.0, ui.visuals().panel_fill)));
    }

    /// Screen position of a state.
    pub fn state_place(&self, state: u32) -> Option<Pos2> {
        let bar = self.layout.state_bars.get(state as usize).copied().flatten()?;
        Some(self.rect(&self.layout.segments[bar as usize]).right_center())
    }

    /// The state near a point.
    pub fn state_at(&self, point: Pos2) -> Option<u32> {
        let graph = self.bundle.tables().graph();
        let reach = [-REACH, REACH].map(|r| self.scale.seconds(point.x + r));
        let near = |lane: &ClipLane| self.scale.lane(lane).expand(REACH).contains(point);
        let bars = self.lanes().filter(|l| near(l)).flat_map(|l| {
            self.layout.bars_within(l, reach).iter().map(|b| (b, self.scale.bar(l, b).right_center().distance(point)))
        });
        let nearest = bars.filter(|b| b.1 <= REACH).min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(graph.segments[nearest.0.segment as usize].end)
    }

    /// The segment at a point.
    pub fn segment_at(&self, point: Pos2) -> Option<u32> {
        let s = self.scale.seconds(point.x);
        let lane = self.lanes().find(|l| self.scale.lane(l).contains(point))?;
        let mut bars = self.layout.bars_within(lane, [s, s]).iter();
        bars.find(|b| self.scale.bar(lane, b).expand2(Vec2::new(0.0, 2.0)).contains(point)).map(|b| b.segment)
    }

    fn cost_colour(&self, ui: &Ui, error: f32) -> Color32 {
        viridis::line(viridis::ratio(error, [0.0, self.links.max_error]), ui.visuals().dark_mode)
    }
}

/// A curve that leaves along time and arrives along time; between rows as an S, within a row as an arc above
/// or below it.
fn curve(from: Pos2, to: Pos2, below: bool) -> [Pos2; 4] {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    if dy.abs() < 6.0 {
        let height = (6.0 + 0.12 * dx.abs()).min(40.0);
        let lift = Vec2::new(0.0, if below { height } else { -height });
        return [from, from + lift, to + lift, to];
    }
    let reach = (0.25 * dx.abs()).clamp(12.0, 80.0);
    [from, from + Vec2::new(reach, 0.0), to - Vec2::new(reach, 0.0), to]
}
