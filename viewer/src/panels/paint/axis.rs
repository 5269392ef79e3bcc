//! Frames along a horizontal axis, and a ruler in seconds.

use eframe::egui::{Align2, FontId, Rangef, Rect, Stroke, Ui, vec2};
use std::ops::Range;
use throng_precompute::picture::step_up;

/// Fewest frames that a view may show (frames).
const FEWEST: f32 = 8.0;

/// Height of a ruler (points).
pub const RULER_HEIGHT: f32 = 20.0;
/// Least distance of two labels (points).
const LABEL_DISTANCE: f32 = 72.0;
/// Least distance of two ticks (points).
const TICK_DISTANCE: f32 = 7.0;

/// Distance of a label from its tick, clear of a play head there (points).
const BESIDE: f32 = 8.0;

/// Visible part of a clip, from the left edge to the right one. A frame is as wide as the time to the next and its
/// instant lies in its middle, so that a whole clip of n frames goes from -0.5 to n - 0.5. (frames)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameSpan {
    /// At the left edge.
    pub from: f32,
    /// At the right edge.
    pub to: f32,
}

impl FrameSpan {
    /// All of a clip.
    pub fn whole(num_frames: u32) -> Self {
        Self { from: -0.5, to: num_frames.max(1) as f32 - 0.5 }
    }

    /// Frames shown.
    pub fn len(self) -> f32 {
        self.to - self.from
    }

    /// True where everything of a clip is shown.
    pub fn is_whole(self, num_frames: u32) -> bool {
        self == Self::whole(num_frames)
    }

    /// The span `factor` times closer, with `about` at the same place.
    pub fn zoomed(self, about: f32, factor: f32, num_frames: u32) -> Self {
        let whole = Self::whole(num_frames).len();
        if !(factor.is_finite() && factor > 0.0) {
            return self;
        }
        let len = (self.len() / factor).clamp(FEWEST.min(whole), whole);
        let ratio = (about - self.from) / self.len();
        Self { from: about - ratio * len, to: about + (1.0 - ratio) * len }.inside(num_frames)
    }

    /// The span moved, within the clip.
    pub fn panned(self, by: f32, num_frames: u32) -> Self {
        Self { from: self.from + by, to: self.to + by }.inside(num_frames)
    }

    /// The span moved if the frame is out of sight, so that the frame is at the left or, going back, in the middle.
    pub fn followed(self, frame: f32, num_frames: u32) -> Self {
        let at = match frame {
            f if f > self.to => 0.05,
            f if f < self.from => 0.5,
            _ => return self,
        };
        self.panned(frame - at * self.len() - self.from, num_frames)
    }

    /// A span of the same length inside the clip; the whole clip if it is shorter.
    fn inside(self, num_frames: u32) -> Self {
        let whole = Self::whole(num_frames);
        let len = self.len();
        if len >= whole.len() {
            return whole;
        }
        let from = self.from.clamp(whole.from, whole.to - len);
        Self { from, to: from + len }
    }
}

/// Maps frames to the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameAxis {
    /// The frames that are seen.
    pub span: FrameSpan,
    /// Range on the screen (points).
    pub x: Rangef,
    /// Frames a second (Hz).
    pub rate_hz: f32,
    /// Frames of the clip.
    pub num_frames: u32,
}

impl FrameAxis {
    /// Place of an instant (points).
    pub fn x_of(&self, frame: f32) -> f32 {
        self.x.min + (frame - self.span.from) * self.points_per_frame()
    }

    /// Instant at a place (frames).
    pub fn instant_at(&self, x: f32) -> f32 {
        self.span.from + (x - self.x.min) / self.points_per_frame()
    }

    /// The frame at a place; the first or the last one where it lies outside.
    pub fn frame_at(&self, x: f32) -> u32 {
        (self.instant_at(x).round().max(0.0) as u32).min(self.num_frames.saturating_sub(1))
    }

    /// Width of a frame (points).
    pub fn points_per_frame(&self) -> f32 {
        self.x.span() / self.span.len()
    }

    /// Screen range of a run of frames; none if it is out of sight.
    pub fn place(&self, run: &Range<u32>) -> Option<Rangef> {
        let (from, to) = (self.x_of(run.start as f32 - 0.5), self.x_of(run.end as f32 - 0.5));
        let seen = Rangef::new(from.max(self.x.min), to.min(self.x.max));
        (seen.min < seen.max).then_some(seen)
    }

    /// The frames of which something is seen.
    pub fn seen(&self) -> Range<u32> {
        let at = |v: f32| (v.max(0.0) as u32).min(self.num_frames);
        at((self.span.from + 0.5).floor())..at((self.span.to + 0.5).ceil())
    }
}

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

    fn axis(span: FrameSpan) -> FrameAxis {
        FrameAxis { span, x: Rangef::new(70.0, 770.0), rate_hz: 30.0, num_frames: 1000 }
    }

    #[test]
    fn a_frame_goes_to_its_place_and_back() {
        for span in [FrameSpan::whole(1000), FrameSpan { from: 11.3, to: 42.0 }, FrameSpan { from: 900.0, to: 999.5 }] {
            let axis = axis(span);
            for frame in axis.seen() {
                assert_eq!(axis.frame_at(axis.x_of(frame as f32)), frame, "{span:?}");
                assert!((axis.instant_at(axis.x_of(frame as f32)) - frame as f32).abs() < 1e-2);
            }
        }
        assert_eq!(axis(FrameSpan::whole(1000)).frame_at(-1e6), 0);
        assert_eq!(axis(FrameSpan::whole(1000)).frame_at(1e6), 999);
    }

    #[test]
    fn neighbouring_runs_meet_and_those_out_of_sight_have_no_place() {
        let axis = axis(FrameSpan { from: 99.5, to: 199.5 });
        let (a, b) = (axis.place(&(90..120)).unwrap(), axis.place(&(120..150)).unwrap());
        assert_eq!(a.min, 70.0);
        assert_eq!(a.max, b.min);
        assert_eq!(axis.place(&(0..100)), None);
        assert_eq!(axis.place(&(200..300)), None);
        assert_eq!(axis.seen(), 100..200);
    }

    #[test]
    fn zooming_keeps_what_is_pointed_at_and_stays_inside() {
        let span = FrameSpan::whole(1000).zoomed(400.0, 4.0, 1000);
        assert!((span.len() - 250.0).abs() < 1e-3);
        let ratio = |s: FrameSpan| (400.0 - s.from) / s.len();
        assert!((ratio(span) - ratio(FrameSpan::whole(1000))).abs() < 1e-4);
        assert!(span.zoomed(400.0, 1e-6, 1000).is_whole(1000));
        assert!((span.zoomed(400.0, 1e9, 1000).len() - FEWEST).abs() < 1e-3);
        assert_eq!(span.zoomed(400.0, f32::NAN, 1000), span);
        assert_eq!(span.panned(1e6, 1000).to, 999.5);
        assert_eq!(span.panned(-1e6, 1000).from, -0.5);
        assert!(FrameSpan::whole(3).zoomed(1.0, 100.0, 3).is_whole(3));
    }

    #[test]
    fn a_frame_out_of_sight_is_followed() {
        let span = FrameSpan { from: 100.0, to: 200.0 };
        assert_eq!(span.followed(150.0, 1000), span);
        for frame in [201.0, 640.0, 999.0, 99.0, 0.0] {
            let s = span.followed(frame, 1000);
            assert!(s.from <= frame && frame <= s.to && (s.len() - 100.0).abs() < 1e-3, "{frame} {s:?}");
        }
    }

    #[test]
    fn labels_have_the_digits_of_their_step() {
        assert_eq!(label(1.5, 0.5), "1.5 s");
        assert_eq!(label(20.0, 10.0), "20 s");
        assert_eq!(label(0.04, 0.02), "0.04 s");
    }
}
