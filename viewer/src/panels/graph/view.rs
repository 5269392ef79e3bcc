//! From places in the layout to places on the screen: zoom and pan.

use super::layout::{ClipLane, GraphLayout, SegmentBar};
use eframe::egui::{Pos2, Rect, Response, Ui, Vec2};

/// Least and largest height of a row (points).
const ROW_HEIGHT: [f32; 2] = [18.0, 64.0];
/// Rows at least this high have names above their bars (points).
const NAMED_FROM: f32 = 30.0;
/// Height of a name (points).
const NAME_HEIGHT: f32 = 14.0;
/// Largest scale (points/s).
const MAX_SCALE: f32 = 800.0;
/// Space around the drawing (points).
const MARGIN: f32 = 8.0;

/// Which part of the drawing is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraphView {
    /// Zoom relative to the scale at which everything fits (>= 1).
    zoom: f32,
    /// Scroll offset to the right and down (points).
    offset: Vec2,
}

impl Default for GraphView {
    fn default() -> Self {
        Self { zoom: 1.0, offset: Vec2::ZERO }
    }
}

/// The scale of a drawing on a part of the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraphScale {
    /// The part of the screen.
    pub rect: Rect,
    origin: Pos2,
    /// Points that a second takes.
    pub per_s: f32,
    row_height: f32,
}

impl GraphView {
    /// Scale for a part of the screen.
    pub fn scale(&self, layout: &GraphLayout, rect: Rect) -> GraphScale {
        let rows = layout.rows.len().max(1) as f32;
        let fit = (rect.width() - 2.0 * MARGIN).max(1.0) / layout.length_s.max(1e-3);
        let fit_height = (rect.height() - 2.0 * MARGIN).max(1.0) / rows;
        let [least, most] = ROW_HEIGHT;
        let row_height = (fit_height.clamp(least, most) * self.zoom).min(most);
        let origin = rect.min + Vec2::splat(MARGIN) - self.offset;
        GraphScale { rect, origin, per_s: fit * self.zoom, row_height }
    }

    /// Drags, scrolls and zooms.
    pub fn interact(&mut self, ui: &Ui, layout: &GraphLayout, response: &Response) {
        let rect = response.rect;
        if response.dragged() {
            self.offset -= response.drag_delta();
        }
        if let Some(pointer) = response.hover_pos() {
            let (zoom, pan) = ui.input(|i| (i.zoom_delta(), i.smooth_scroll_delta()));
            self.offset -= pan;
            if zoom != 1.0 {
                self.zoom_at(layout, rect, pointer, zoom);
            }
        }
        self.limit(layout, rect);
    }

    /// Zooms around a point.
    pub fn zoom_at(&mut self, layout: &GraphLayout, rect: Rect, point: Pos2, factor: f32) {
        let before = self.scale(layout, rect);
        let (s, row) = (before.seconds(point.x), (point.y - before.origin.y) / before.row_height);
        let fit = before.per_s / self.zoom;
        self.zoom = (self.zoom * factor).clamp(1.0, (MAX_SCALE / fit).max(1.0));
        let after = self.scale(layout, rect);
        self.offset += Vec2::new(after.x(s) - point.x, after.origin.y + row * after.row_height - point.y);
        self.limit(layout, rect);
    }

    /// Centres a place, zooming in until `span_s` fills the width.
    pub fn show(&mut self, layout: &GraphLayout, rect: Rect, place: (usize, f32), span_s: f32) {
        let fit = self.scale(layout, rect).per_s / self.zoom;
        let zoom = rect.width() / span_s.max(0.1) / fit;
        self.zoom = zoom.clamp(1.0, (MAX_SCALE / fit).max(1.0));
        self.centre(layout, rect, place);
    }

    /// Centres a place.
    pub fn centre(&mut self, layout: &GraphLayout, rect: Rect, (row, s): (usize, f32)) {
        let scale = self.scale(layout, rect);
        let place = Pos2::new(scale.x(s), scale.row_top(row) + 0.5 * scale.row_height);
        self.offset += place - rect.center();
        self.limit(layout, rect);
    }

    /// Keeps the drawing in sight.
    fn limit(&mut self, layout: &GraphLayout, rect: Rect) {
        let scale = self.scale(layout, rect);
        let size = Vec2::new(layout.length_s * scale.per_s, layout.rows.len() as f32 * scale.row_height);
        let most = (size + Vec2::splat(2.0 * MARGIN) - rect.size()).max(Vec2::ZERO);
        self.offset = self.offset.clamp(Vec2::ZERO, most);
    }
}

impl GraphScale {
    /// Screen position of a place along a row.
    pub fn x(&self, s: f32) -> f32 {
        self.origin.x + s * self.per_s
    }

    /// Place along a row of a screen position (s).
    pub fn seconds(&self, x: f32) -> f32 {
        (x - self.origin.x) / self.per_s
    }

    /// Upper edge of a row.
    pub fn row_top(&self, row: usize) -> f32 {
        self.origin.y + row as f32 * self.row_height
    }

    /// Rows that can be seen.
    pub fn rows(&self, layout: &GraphLayout) -> std::ops::Range<usize> {
        let at = |y: f32| ((y - self.origin.y) / self.row_height).max(0.0);
        let to = (at(self.rect.bottom()).ceil() as usize).min(layout.rows.len());
        (at(self.rect.top()) as usize).min(to)..to
    }

    /// Places along rows that can be seen (s).
    pub fn range_s(&self) -> [f32; 2] {
        [self.seconds(self.rect.left()), self.seconds(self.rect.right())]
    }

    /// True where lanes have room for their names.
    pub fn has_names(&self) -> bool {
        self.row_height >= NAMED_FROM
    }

    /// The part of the screen that a lane takes, its name above its bars.
    pub fn lane(&self, lane: &ClipLane) -> Rect {
        let top = self.row_top(lane.row);
        Rect::from_min_max(Pos2::new(self.x(lane.start), top), Pos2::new(self.x(lane.end), top + self.row_height - 4.0))
    }

    /// The part of the screen that a bar takes.
    pub fn bar(&self, lane: &ClipLane, bar: &SegmentBar) -> Rect {
        let lane_rect = self.lane(lane);
        let top = lane_rect.top() + if self.has_names() { NAME_HEIGHT } else { 2.0 };
        let height = (lane_rect.bottom() - top) / lane.num_tracks as f32;
        let thick = height.min(12.0);
        let y = top + bar.track as f32 * height + 0.5 * (height - thick);
        Rect::from_min_max(Pos2::new(self.x(bar.start), y), Pos2::new(self.x(bar.end), y + thick))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::golden;
    use super::*;

    fn screen() -> Rect {
        Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(600.0, 200.0))
    }

    #[test]
    fn zooming_keeps_the_place_under_the_pointer() {
        let layout = GraphLayout::new(golden().tables());
        let mut view = GraphView::default();
        let point = Pos2::new(300.0, 120.0);
        for factor in [1.5, 1.2, 2.0] {
            let before = view.scale(&layout, screen()).seconds(point.x);
            view.zoom_at(&layout, screen(), point, factor);
            let after = view.scale(&layout, screen()).seconds(point.x);
            assert!((before - after).abs() < 1e-3, "{before} {after}");
        }
        assert!(view.zoom > 3.5);
    }

    #[test]
    fn all_of_it_fits_at_first_and_bars_lie_within_their_lanes() {
        let layout = GraphLayout::new(golden().tables());
        let scale = GraphView::default().scale(&layout, screen());
        assert_eq!(scale.rows(&layout), 0..layout.rows.len());
        for bar in &layout.segments {
            let lane = &layout.lanes[bar.lane as usize];
            let rect = scale.bar(lane, bar);
            assert!(scale.lane(lane).expand(0.1).contains_rect(rect));
            assert!(rect.left() >= screen().left() && rect.right() <= screen().right());
        }
    }

    #[test]
    fn a_place_can_be_brought_into_sight() {
        let layout = GraphLayout::new(golden().tables());
        let lane = layout.lanes.last().unwrap();
        let mut view = GraphView::default();
        view.show(&layout, screen(), (lane.row, lane.end), 2.0);
        let scale = view.scale(&layout, screen());
        assert!(scale.rect.x_range().contains(scale.x(lane.end)));
        assert!(scale.rows(&layout).contains(&lane.row));
    }
}
