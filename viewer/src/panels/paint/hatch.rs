//! Hatching of excluded frames.

use eframe::egui::{Painter, Rect, Stroke, pos2};

/// Distance of two lines (points).
const DISTANCE: f32 = 6.0;

/// Hatches a rectangle with lines that rise to the right and continue in its neighbours.
pub fn hatch(painter: &Painter, rect: Rect, stroke: Stroke) {
    let painter = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let seen = painter.clip_rect();
    if !seen.is_positive() {
        return;
    }
    let height = rect.height();
    let first = ((seen.left() - height) / DISTANCE).floor() as i32;
    let last = (seen.right() / DISTANCE).ceil() as i32;
    for i in first..=last {
        let x = i as f32 * DISTANCE;
        painter.line_segment([pos2(x, rect.bottom()), pos2(x + height, rect.top())], stroke);
    }
}
