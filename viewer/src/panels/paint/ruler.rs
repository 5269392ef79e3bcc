//! Seconds along an axis.

use super::FrameAxis;
use eframe::egui::{Align2, FontId, Rect, Stroke, Ui, vec2};
use throng_precompute::picture::step_up;

/// Height of a ruler (points).
pub const RULER_HEIGHT: f32 = 20.0;
/// Least distance of two labels (points).
const LABEL_DISTANCE: f32 = 72.0;
/// Least distance of two ticks (points).
const TICK_DISTANCE: f32 = 7.0;

/// Distance of a label from its tick, clear of a play head there (points).
const BESIDE: f32 = 8.0;

/// Paints a ruler in seconds; where frames are wide enough, they have ticks of their own.
pub fn ruler(ui: &Ui, rect: Rect, axis: &FrameAxis) {
    let visuals = ui.visuals();
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let points_per_s = axis.points_per_frame() * axis.rate_hz;
    let step = step_up(f64::from((LABEL_DISTANCE / points_per_s).clamp(1e-3, 1e6)));
    let base = rect.bottom();
    let line = Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color);
    painter.hline(rect.x_range(), base, line);
    ticks(axis, step / 5.0, |x, _| _ = painter.vline(x, base - 4.0..=base, line));
    if axis.points_per_frame() >= TICK_DISTANCE {
        for frame in axis.seen() {
            painter.vline(axis.x_of(frame as f32), base - 3.0..=base, line);
        }
    }
    ticks(axis, step, |x, seconds| {
        painter.vline(x, base - 8.0..=base, Stroke::new(1.0, visuals.weak_text_color()));
        let at = rect.left_top() + vec2(x - rect.left() + BESIDE, 1.0);
        painter.text(at, Align2::LEFT_TOP, label(seconds, step), FontId::proportional(11.0), visuals.weak_text_color());
    });
}

fn ticks(axis: &FrameAxis, step_s: f64, mut tick: impl FnMut(f32, f64)) {
    let rate = f64::from(axis.rate_hz);
    let first = (f64::from(axis.span.from.max(0.0)) / rate / step_s).ceil() as i64;
    let last = (f64::from(axis.span.to) / rate / step_s).floor() as i64;
    for i in first..=last {
        let seconds = i as f64 * step_s;
        tick(axis.x_of((seconds * rate) as f32), seconds);
    }
}

fn label(seconds: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{seconds:.decimals$} s")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_the_digits_of_their_step() {
        assert_eq!(label(1.5, 0.5), "1.5 s");
        assert_eq!(label(20.0, 10.0), "20 s");
        assert_eq!(label(0.04, 0.02), "0.04 s");
    }
}
