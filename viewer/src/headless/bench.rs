//! Frame times of crowds of several sizes.

use super::{Headless, HeadlessError};
use crate::app::Viewer;
use crate::args::{Args, BENCH_FRAMES, PictureSize};
use crate::command::{SceneCommand, ViewerCommand};
use crate::document::SceneChoice;
use crate::model::{FrameTimes, Model};
use serde::Serialize;
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
        let columns = ["simulation", "layout", "upload", "drawing", "interface", "frame"];
        writeln!(f, "{:>10}{}", "characters", columns.map(|column| format!(" {column:>17}")).concat())?;
        for c in &self.crowds {
            let cells = [
                (c.simulation_ms, c.simulation_p95_ms),
                (c.layout_ms, c.layout_p95_ms),
                (c.upload_ms, c.upload_p95_ms),
                (c.drawing_ms, c.drawing_p95_ms),
                (c.interface_ms, c.interface_p95_ms),
                (c.frame_ms, c.frame_p95_ms),
            ];
            let cells = cells.map(|(median, p95)| format!(" {:>17}", format!("{median:.2} ({p95:.2})")));
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
