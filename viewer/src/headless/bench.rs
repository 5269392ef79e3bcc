//! Frame times of crowds of several sizes.

use super::{Headless, HeadlessError};
use crate::app::Viewer;
use crate::args::{Args, BENCH_FRAMES, PictureSize};
use crate::command::{SceneCommand, ViewerCommand};
use crate::document::SceneChoice;
use crate::model::{FrameTimes, Model};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// Frame times of crowds of several sizes.
#[derive(Clone, Debug, Serialize)]
pub struct BenchReport {
    /// Name of the graphics adapter.
    pub adapter: String,
    /// From left to right (pixels).
    pub width: u32,
    /// From top to bottom (pixels).
    pub height: u32,
    /// One entry for every number of characters.
    pub crowds: Vec<FrameFigures>,
}

impl fmt::Display for BenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { adapter, width, height, .. } = self;
        writeln!(f, "{adapter}, {width} x {height} pixels; median (95th percentile) of a frame, in ms")?;
        let names = PARTS.map(|part| part.0);
        writeln!(f, "{:>10}{}", "characters", names.map(|name| format!(" {name:>17}")).concat())?;
        for c in &self.crowds {
            let cells = names.map(|name| {
                let [median, p95] = ["ms", "p95_ms"].map(|unit| c.times[&format!("{name}_{unit}")]);
                format!(" {:>17}", format!("{median:.2} ({p95:.2})"))
            });
            writeln!(f, "{:>10}{}", c.characters, cells.concat())?;
        }
        Ok(())
    }
}

/// Another number of characters, rounded up to pairs if the scene has pairs.
fn with_characters(model: &Model, characters: usize) -> ViewerCommand {
    let now = model.document.choice().unwrap_or(model.settings.crowd);
    ViewerCommand::Scene(SceneCommand::Restart(SceneChoice { characters, ..now }))
}

/// Measures frames of every crowd that the arguments ask for.
///
/// # Errors
/// [`HeadlessError`]
pub fn bench(args: &Args) -> Result<BenchReport, HeadlessError> {
    let mut headless = Headless::new(args)?;
    if headless.viewer.model.num_characters() == 0 {
        let why = "--bench: there is no crowd to measure; open a bundle that was built with `behaviours`";
        return Err(HeadlessError::Scene(why.into()));
    }
    let mut crowds = Vec::new();
    for &characters in &args.bench {
        headless.apply(with_characters(&headless.viewer.model, characters));
        headless.apply(ViewerCommand::Play(true));
        if !args.camera.is_some_and(|view| view.is_placed) {
            headless.apply(ViewerCommand::FrameAll);
        }
        let frames = args.frames.unwrap_or(BENCH_FRAMES);
        let spans = (0..frames).map(|_| headless.advance(true)).collect::<Result<Vec<_>, _>>()?;
        crowds.push(FrameFigures::from_frames(num_characters(&headless.viewer), &spans));
    }
    let PictureSize { width, height } = args.size.unwrap_or_default();
    Ok(BenchReport { adapter: headless.screen.adapter_name(), width, height, crowds })
}

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
        let is = |key: &str, ms: f64| (f.times[key] - ms).abs() < 1e-9;
        assert!(is("frame_ms", 50.0) && is("frame_p95_ms", 95.0), "{f:?}");
        assert!(is("interface_ms", 49.0) && is("drawing_ms", 0.0), "{f:?}");
        let none = FrameFigures::from_frames(1, &[]);
        assert!(none.frames == 0 && none.times.len() == 12 && none.times.values().all(|ms| *ms == 0.0), "{none:?}");
        assert_eq!(FrameFigures::from_frames(1, &frames[..1]).frames, 1);
    }
}
