//! Times of frames.

use crate::app::Viewer;
use crate::model::FrameTimes;
use serde::Serialize;

/// Times of many frames: medians and 95th percentiles (ms).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FrameFigures {
    /// Characters of the crowd; 0 where a clip is shown.
    pub characters: usize,
    /// Frames that were measured.
    pub frames: usize,
    /// Steps of the crowd.
    pub simulation_ms: f64,
    /// 95th percentile of `simulation_ms`.
    pub simulation_p95_ms: f64,
    /// Laying out the frame (ms).
    pub layout_ms: f64,
    /// 95th percentile of `layout_ms`.
    pub layout_p95_ms: f64,
    /// Handing poses to the graphics device.
    pub upload_ms: f64,
    /// 95th percentile of `upload_ms`.
    pub upload_p95_ms: f64,
    /// From encoding until all is drawn.
    pub drawing_ms: f64,
    /// 95th percentile of `drawing_ms`.
    pub drawing_p95_ms: f64,
    /// Remaining time: panels and text (ms).
    pub interface_ms: f64,
    /// 95th percentile of `interface_ms`.
    pub interface_p95_ms: f64,
    /// All of it.
    pub frame_ms: f64,
    /// 95th percentile of `frame_ms`.
    pub frame_p95_ms: f64,
}

impl FrameFigures {
    /// Figures of frames; the first ones, up to ten, warm up and do not count.
    pub fn from_frames(characters: usize, all: &[FrameTimes]) -> Self {
        let counted = &all[(all.len() / 4).min(10)..];
        let figures = |part: fn(&FrameTimes) -> f64| {
            let mut ms: Vec<f64> = counted.iter().map(|s| 1000.0 * part(s)).collect();
            ms.sort_by(f64::total_cmp);
            (share(&ms, 0.5), share(&ms, 0.95))
        };
        let mut f = Self { characters, frames: counted.len(), ..Self::default() };
        (f.simulation_ms, f.simulation_p95_ms) = figures(|s| s.simulation_s);
        (f.layout_ms, f.layout_p95_ms) = figures(|s| s.layout_s);
        (f.upload_ms, f.upload_p95_ms) = figures(|s| s.upload_s);
        (f.drawing_ms, f.drawing_p95_ms) = figures(|s| s.drawing_s);
        (f.interface_ms, f.interface_p95_ms) =
            figures(|s| (s.frame_s - s.simulation_s - s.layout_s - s.upload_s - s.drawing_s).max(0.0));
        (f.frame_ms, f.frame_p95_ms) = figures(|s| s.frame_s);
        f
    }
}

/// The value that a share of sorted values does not exceed; 0 of none.
fn share(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

/// Characters of the crowd that is shown; 0 where a clip is shown.
pub(super) fn num_characters(viewer: &Viewer) -> usize {
    if viewer.model.shows_clip() { 0 } else { viewer.model.num_characters() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_leave_the_first_frames_out() {
        let frame = |ms: f64| FrameTimes { simulation_s: 0.001, frame_s: ms / 1000.0, ..FrameTimes::default() };
        let mut frames = vec![frame(1000.0); 10];
        frames.extend((1..=100).map(|ms| frame(f64::from(ms))));
        let f = FrameFigures::from_frames(7, &frames);
        assert_eq!((f.characters, f.frames), (7, 100));
        assert!((f.frame_ms - 50.0).abs() < 1e-9 && (f.frame_p95_ms - 95.0).abs() < 1e-9, "{f:?}");
        assert!((f.interface_ms - 49.0).abs() < 1e-9 && f.drawing_ms == 0.0, "{f:?}");
        assert_eq!(FrameFigures::from_frames(1, &[]), FrameFigures { characters: 1, ..FrameFigures::default() });
        assert_eq!(FrameFigures::from_frames(1, &frames[..1]).frames, 1);
    }
}
