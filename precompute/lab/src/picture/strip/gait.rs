//! The gait diagram: planted heels and toes over time.

use super::super::canvas::{Area, Picture};
use super::super::colour;
use super::super::text::{Align, TextStyle, draw_text};
use super::{StripFrame, StripLayout};
use glam::Vec2;
use throng_core::Contacts;
use throng_motion::clip::runs_where;

/// Draws a lane for each foot, heel above and toe below, over the columns of the strip.
pub(super) fn draw(page: &mut Picture, layout: &StripLayout, frames: &[StripFrame]) {
    let (unit, area) = (layout.unit, layout.gait);
    let lane = 0.5 * area.size.y - 3.0 * unit;
    let feet = [
        ("L", Contacts::LEFT_HEEL, Contacts::LEFT_TOE, colour::LEFT),
        ("R", Contacts::RIGHT_HEEL, Contacts::RIGHT_TOE, colour::RIGHT),
    ];
    for (i, (name, heel, toe, tint)) in feet.into_iter().enumerate() {
        let y = area.min.y + i as f32 * (lane + 6.0 * unit);
        page.fill_rect(Area::new(area.min.x, y, area.size.x, lane), 4.0 * unit, colour::GROUND);
        for (part, offset) in [(heel, 0.14), (toe, 0.54)] {
            for run in runs_where(0..frames.len(), |f| frames[f].contacts.any(part)) {
                let [x0, x1] = [run.start, run.end].map(|f| frame_x(layout, frames, f as f32 - 0.5));
                let bar = Area::new(x0, y + offset * lane, x1 - x0, 0.32 * lane);
                page.fill_rect(bar, 3.0 * unit, tint);
            }
        }
        let style = TextStyle { size: 19.0 * unit, colour: tint.mix(colour::INK, 0.2), align: Align::Left, bold: true };
        draw_text(page, Vec2::new(area.min.x + 8.0 * unit, y + 0.5 * lane + 6.0 * unit), name, style);
    }
}

/// Horizontal position of a frame; a frame with a column is at its centre (px).
fn frame_x(layout: &StripLayout, frames: &[StripFrame], frame: f32) -> f32 {
    let last = frames.len().saturating_sub(1).max(1) as f32;
    layout.column_x(frame.clamp(0.0, last) / last * (layout.columns - 1) as f32)
}
