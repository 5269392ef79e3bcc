//! Frame times of crowds of several sizes.

use super::{FrameFigures, Headless, HeadlessError};
use crate::args::{Args, BENCH_FRAMES, PictureSize};
use crate::command::{SceneCommand, ViewerCommand};
use crate::document::SceneChoice;
use crate::model::Model;
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
        crowds.push(FrameFigures::from_frames(super::figures::num_characters(&headless.viewer), &spans));
    }
    let PictureSize { width, height } = args.size.unwrap_or_default();
    Ok(BenchReport { adapter: headless.screen.adapter_name(), width, height, crowds })
}
