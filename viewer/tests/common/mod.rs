//! What several tests need: the golden bundle, a short motion file, and the viewer in a harness.

#![allow(dead_code)] // Every test file is a crate of its own and uses a part of this.

pub mod boxing;
pub mod meeting;
pub mod paces;
pub mod square;

use eframe::egui;
use egui_kittest::Harness;
use std::path::{Path, PathBuf};
use throng_precompute::synth::{SynthConfig, SynthSet, make, save};
use throng_runtime::format::VERSION;
use throng_viewer::app::Viewer;
use throng_viewer::args::Args;
use throng_viewer::command::Command;
use throng_viewer::model::Model;
use throng_viewer::settings::Settings;

/// The bundle of the current version that every checkout has.
pub fn golden() -> PathBuf {
    // Tests run in the package's folder; a path that is the same everywhere looks the same in pictures.
    PathBuf::from(format!("../data/golden/tables_v{VERSION}.throng"))
}

/// A short synthetic walk as a BVH file in a folder.
pub fn bvh(folder: &Path) -> PathBuf {
    let short = SynthConfig { minutes: 0.1, clip_seconds: 10.0, ..SynthConfig::default() };
    let files = save(&make(SynthSet::Walk, &short).expect("a walk"), folder).expect("motion files");
    files.into_iter().next().expect("at least one file")
}

/// Name of the adapter that pictures are drawn with; none, with the reason printed, where there is none.
pub fn adapter() -> Option<String> {
    use throng_viewer::args::{Adapter, Size};
    match throng_viewer::headless::Screen::new(Adapter::Software, Size { width: 16, height: 16 }, 1.0) {
        Ok(screen) => Some(screen.adapter_name()),
        Err(e) => {
            println!("skipped: {e}");
            None
        }
    }
}

/// The viewer in a harness.
pub struct Viewing {
    /// What runs it, 1/60 s a step.
    pub harness: Harness<'static, Viewer>,
}

impl Viewing {
    /// With nothing open. It draws where there is an adapter.
    pub fn empty() -> Self {
        Self::new(&Args::default(), egui::vec2(900.0, 600.0))
    }

    /// With a file open.
    pub fn of(file: &Path) -> Self {
        let args = Args { file: Some(file.to_path_buf()), ..Args::default() };
        Self::new(&args, egui::vec2(900.0, 600.0))
    }

    /// With what arguments say.
    pub fn new(args: &Args, size: egui::Vec2) -> Self {
        let settings = args.settings(Settings::default());
        let theme = if settings.theme == egui::ThemePreference::Light { egui::Theme::Light } else { egui::Theme::Dark };
        let builder = Harness::builder()
            .with_size(size)
            .with_step_dt(1.0 / 60.0)
            .with_max_steps(8)
            .with_theme(theme)
            .with_accessibility_check(false);
        let builder = if adapter().is_some() { builder.wgpu() } else { builder };
        let args = args.clone();
        let harness = builder.build_eframe(move |cc| {
            let mut viewer = Viewer::new(settings, cc.wgpu_render_state.as_ref());
            args.open(&cc.egui_ctx, &mut viewer.model).expect("what the test asks for is there");
            viewer
        });
        Self { harness }
    }

    /// All that the viewer knows.
    pub fn model(&self) -> &Model {
        &self.harness.state().model
    }

    /// Carries out a command as a panel's would be.
    pub fn apply(&mut self, command: Command) {
        let ctx = self.harness.ctx.clone();
        self.harness.state_mut().model.apply(&ctx, command);
    }

    /// Shows frames until something has happened that takes time of its own, such as reading a file.
    pub fn until(&mut self, what: &str, happened: impl Fn(&Self) -> bool) {
        for _ in 0..3000 {
            if happened(self) {
                return;
            }
            self.harness.step();
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        panic!("{what} did not come; messages: {:?}", self.model().messages);
    }
}
