//! The viewer without a window: pictures and frame times.
//!
//! The [`Viewer`] of the window runs here in its own egui context; time is counted in frames, and frames are drawn
//! into a texture. On a software adapter the same arguments give the same picture, bit for bit.

mod frame_figures;
mod screen;

pub use frame_figures::FrameFigures;
pub use screen::Screen;

use crate::args::{Args, PICTURE_FRAMES, PanelChoice, PictureSize};
use crate::{app::Viewer, model::FrameTimes, run::STEP_HZ};
use eframe::egui;
use image::RgbImage;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::{io::Cursor, time::Instant};
use throng_precompute::BuildError;
use throng_precompute::files::{check_target, write_atomically};

/// Final frames during which time stands still, so that layouts that need two passes settle.
const SETTLING_FRAMES: u32 = 3;

/// Reason why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HeadlessError {
    /// Nothing can draw.
    #[error(
        "no graphics adapter was found ({reason}); Mesa's software adapter is enough: `apt-get install \
         mesa-vulkan-drivers` on Debian and Ubuntu, the package vulkan-swrast or mesa-vulkan-drivers elsewhere"
    )]
    NoAdapter {
        /// Message of the graphics library.
        reason: String,
    },
    /// The picture is too large for the adapter.
    #[error("--size {}x{}: {adapter} draws pictures of at most {limit} pixels a side", size.width, size.height)]
    Size {
        /// Requested size.
        size: PictureSize,
        /// Name of the adapter.
        adapter: String,
        /// Largest side that the adapter can draw (pixels).
        limit: u32,
    },
    /// The adapter failed.
    #[error("{adapter} failed to draw: {reason}; a smaller --size, fewer --characters or another --adapter may help")]
    Drawing {
        /// Name of the adapter.
        adapter: String,
        /// Message of the graphics library.
        reason: String,
    },
    /// The content named by the arguments does not exist.
    #[error("{0}")]
    Scene(String),
    /// The picture cannot be written.
    #[error(transparent)]
    Write(#[from] BuildError),
}

/// Report on a picture and its times.
#[derive(Debug, Serialize)]
pub struct PictureReport {
    /// The picture.
    pub file: PathBuf,
    /// Name of the graphics adapter.
    pub adapter: String,
    /// From left to right (pixels).
    pub width: u32,
    /// From top to bottom (pixels).
    pub height: u32,
    /// Times of its frames.
    #[serde(flatten)]
    pub figures: FrameFigures,
}

/// The viewer without a window.
pub struct Headless {
    ctx: egui::Context,
    /// The viewer.
    pub viewer: Viewer,
    screen: Screen,
    frame: u32,
}

impl Headless {
    /// Opens the document named by the arguments.
    ///
    /// # Errors
    /// [`HeadlessError`] where nothing can draw, or what is asked for is not there.
    pub fn new(args: &Args) -> Result<Self, HeadlessError> {
        let screen = Screen::new(args.adapter, args.size.unwrap_or_default(), args.scale.unwrap_or(1.0))?;
        let ctx = egui::Context::default();
        let settings = args.settings(crate::settings::ViewerSettings::default());
        let mut viewer = Viewer::new(settings, Some(&screen.state));
        (viewer.model.is_unhurried, viewer.model.is_untrusted) = (true, args.untrusted);
        viewer.states.bare = args.panel.contains(&PanelChoice::None);
        args.dress(&mut viewer.model).map_err(HeadlessError::Scene)?;
        args.open(&ctx, &mut viewer.model).map_err(HeadlessError::Scene)?;
        Ok(Self { ctx, viewer, screen, frame: 0 })
    }

    /// Advances by one frame of 1/60 s; without `draws`, skips drawing it.
    ///
    /// # Errors
    /// [`HeadlessError::Drawing`]
    pub fn advance(&mut self, draws: bool) -> Result<FrameTimes, HeadlessError> {
        self.frame += 1;
        self.run_frame(1.0 / STEP_HZ, draws)
    }

    /// The picture, after the layout has settled. No time passes.
    ///
    /// # Errors
    /// [`HeadlessError::Drawing`]
    pub fn picture(&mut self) -> Result<RgbImage, HeadlessError> {
        for i in 1..=SETTLING_FRAMES {
            self.run_frame(0.0, i == SETTLING_FRAMES)?;
        }
        self.screen.read()
    }

    fn run_frame(&mut self, wall_s: f32, draws: bool) -> Result<FrameTimes, HeadlessError> {
        let begin = Instant::now();
        let mut passed_s = Some(wall_s);
        let (ctx, viewer) = (&self.ctx, &mut self.viewer);
        let output = ctx.run_ui(self.screen.input(f64::from(self.frame) / f64::from(STEP_HZ)), |ui| {
            // Where a frame is laid out twice, time passes once.
            if let Some(wall_s) = passed_s.take() {
                viewer.logic(&ui.ctx().clone(), wall_s);
            }
            viewer.ui(ui);
        });
        let drawing_s = self.screen.draw_output(&self.ctx, output, draws)?;
        Ok(FrameTimes { drawing_s, frame_s: begin.elapsed().as_secs_f64(), ..self.viewer.model.times })
    }
}

/// Draws the picture that the arguments ask for and writes it.
///
/// # Errors
/// [`HeadlessError`]; what stood at the place of the picture before stays as it was.
pub fn draw_picture(args: &Args, out: &Path) -> Result<PictureReport, HeadlessError> {
    check_target(out)?;
    let mut headless = Headless::new(args)?;
    let frames = 0..args.frames.unwrap_or(PICTURE_FRAMES);
    let spans = frames.map(|_| headless.advance(args.json)).collect::<Result<Vec<_>, _>>()?;
    let image = headless.picture()?;
    save_png(&image, out)?;
    let (width, height) = image.dimensions();
    let model = &headless.viewer.model;
    let figures = FrameFigures::from_frames(if model.shows_clip() { 0 } else { model.num_characters() }, &spans);
    Ok(PictureReport { file: out.to_path_buf(), adapter: headless.screen.adapter_name(), width, height, figures })
}

/// Writes a PNG file.
///
/// # Errors
/// [`BuildError::Io`] names the file; what stood there before stays as it was.
pub fn save_png(image: &RgbImage, path: &Path) -> Result<(), BuildError> {
    let mut png = Cursor::new(Vec::new());
    let written = image.write_to(&mut png, image::ImageFormat::Png);
    written.map_err(|e| BuildError::Io { path: path.to_path_buf(), source: std::io::Error::other(e) })?;
    write_atomically(path, |file| file.write_all(png.get_ref()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_written_and_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let image = RgbImage::from_fn(5, 3, |x, y| image::Rgb([x as u8 * 50, y as u8 * 80, 7]));
        save_png(&image, &path).expect("written");
        assert_eq!(image::open(&path).expect("a PNG").into_rgb8(), image);
        assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 1);
        let error = save_png(&image, &folder.path().join("no/a.png")).expect_err("no folder");
        assert!(error.to_string().contains("no"), "{error}");
    }
}
