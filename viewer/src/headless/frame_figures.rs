//! Times of frames and their parts.

use crate::model::FrameTimes;
use serde::Serialize;
use std::collections::BTreeMap;

/// A part of a frame with its name, and its time (s).
type FramePart = (&'static str, fn(&FrameTimes) -> f64);

/// Parts of a frame: steps of the crowd, laying out, handing poses to the graphics device, from encoding until
/// all is drawn, remaining time (panels and text), and all of it (s).
const PARTS: [FramePart; 6] = [
    ("simulation", |t| t.simulation_s),
    ("layout", |t| t.layout_s),
    ("upload", |t| t.upload_s),
    ("drawing", |t| t.drawing_s),
    ("interface", |t| (t.frame_s - t.simulation_s - t.layout_s - t.upload_s - t.drawing_s).max(0.0)),
    ("frame", |t| t.frame_s),
];

/// Times of many frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameFigures {
    /// Characters of the crowd; 0 where a clip is shown.
    pub characters: usize,
    /// Frames that were measured.
    pub frames: usize,
    /// Median and 95th percentile of each part, as `NAME_ms` and `NAME_p95_ms`.
    #[serde(flatten)]
    pub times: BTreeMap<String, f64>,
}

impl FrameFigures {
    /// Figures of frames; the first ones, up to ten, warm up and do not count.
    pub fn from_frames(characters: usize, all: &[FrameTimes]) -> Self {
        let counted = &all[(all.len() / 4).min(10)..];
        let mut times = BTreeMap::new();
        for (name, part) in PARTS {
            let mut ms: Vec<f64> = counted.iter().map(|t| 1000.0 * part(t)).collect();
            ms.sort_by(f64::total_cmp);
            times.insert(format!("{name}_ms"), share(&ms, 0.5));
            times.insert(format!("{name}_p95_ms"), share(&ms, 0.95));
        }
        Self { characters, frames: counted.len(), times }
    }
}

/// The value that a share of sorted values does not exceed; 0 of none.
fn share(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
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
        let is = |key: &str, ms: f64| (f.times[key] - ms).abs() < 1e-9;
        assert!(is("frame_ms", 50.0) && is("frame_p95_ms", 95.0), "{f:?}");
        assert!(is("interface_ms", 49.0) && is("drawing_ms", 0.0), "{f:?}");
        let none = FrameFigures::from_frames(1, &[]);
        assert!(none.frames == 0 && none.times.len() == 12 && none.times.values().all(|ms| *ms == 0.0), "{none:?}");
        assert_eq!(FrameFigures::from_frames(1, &frames[..1]).frames, 1);
    }
}
