//! What several tests need: the golden bundle, a short motion file, and the viewer in a harness.

#![allow(dead_code)] // Every test file is a crate of its own and uses a part of this.

pub mod boxing;
pub mod market;
pub mod meeting;
pub mod paces;
pub mod rig;
pub mod square;

use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::{Vec2, Vec3};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use throng_core::format::VERSION;
use throng_precompute::synth::{SynthConfig, SynthSet, make_set, save};
use throng_viewer::app::Viewer;
use throng_viewer::args::Args;
use throng_viewer::command::ViewerCommand;
use throng_viewer::headless::draw_picture;
use throng_viewer::model::Model;
use throng_viewer::settings::ViewerSettings;

/// The bundle of the current version that every checkout has.
pub fn golden() -> PathBuf {
    // Tests run in the package's folder; a path that is the same everywhere looks the same in pictures.
    PathBuf::from(format!("../data/golden/tables_v{VERSION}.throng"))
}

/// Draws a picture twice, the same both times, and another one with other arguments.
pub fn assert_drawn_alike(folder: &Path, args: &Args, characters: usize, other: &Args) {
    let [first, second, last] = [("a.png", args), ("b.png", args), ("c.png", other)].map(|(name, args)| {
        let out = folder.join(name);
        let report = draw_picture(args, &out).expect("a picture");
        (report.figures.characters, std::fs::read(&out).expect("a picture"))
    });
    assert_eq!((first.0, second.0), (characters, characters));
    assert!(first.1 == second.1, "two pictures differ");
    assert!(first.1 != last.1, "the arguments change nothing");
}

/// A short synthetic walk as a BVH file in a folder.
pub fn bvh(folder: &Path) -> PathBuf {
    walk(folder, 0.1).into_iter().next().expect("at least one file")
}

/// Some minutes of synthetic walking as BVH files of ten seconds in a folder.
pub fn walk(folder: &Path, minutes: f64) -> Vec<PathBuf> {
    let config = SynthConfig { minutes, clip_seconds: 10.0, ..SynthConfig::default() };
    save(&make_set(SynthSet::Walk, &config).expect("a walk"), folder).expect("motion files")
}

/// A synthetic walk as a BVH file with faults of a recording put in: a joint that is elsewhere for a frame, a body that is
/// elsewhere from one frame on, and one that stops dead for half a second.
pub fn faulty_bvh(folder: &Path) -> PathBuf {
    let path = bvh(folder);
    let text = std::fs::read_to_string(&path).expect("a motion file");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let first = lines.iter().position(|l| l.starts_with("Frame Time")).expect("frames") + 1;
    // The first two numbers are the hips' place in centimetres.
    let shifted = |line: &str, by: f64| {
        let mut numbers: Vec<f64> = line.split_whitespace().map(|n| n.parse().expect("a number")).collect();
        numbers[0] += by;
        numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
    };
    lines[first + 40] = shifted(&lines[first + 40], 70.0);
    for line in &mut lines[first + 80..] {
        *line = shifted(line, 90.0);
    }
    let still = lines[first + 120].clone();
    lines[first + 121..first + 141].fill(still);
    let path = folder.join("faulty.bvh");
    std::fs::write(&path, lines.join("\n") + "\n").expect("a motion file");
    path
}

/// A file as the window system drops it.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

/// Drops files or folders on the window.
pub fn drop_files(v: &mut Viewing, paths: &[&Path]) {
    for path in paths {
        v.harness.input_mut().dropped_files.push(Arc::new(Dropped(path.to_path_buf())));
    }
    v.harness.step();
}

/// Name of the adapter that pictures are drawn with; none, with the reason printed, where there is none.
pub fn adapter() -> Option<String> {
    use throng_viewer::args::{AdapterChoice, PictureSize};
    match throng_viewer::headless::Screen::new(AdapterChoice::Software, PictureSize { width: 16, height: 16 }, 1.0) {
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
    pub harness: Harness<'static, Windowed>,
}

/// The viewer as an application of eframe.
pub struct Windowed(pub Viewer);

impl eframe::App for Windowed {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.0.logic(ctx, ctx.input(|i| i.unstable_dt));
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.0.ui(ui);
    }
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
        let settings = args.settings(ViewerSettings::default());
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
            Windowed(viewer)
        });
        Self { harness }
    }

    /// All that the viewer knows.
    pub fn model(&self) -> &Model {
        &self.harness.state().0.model
    }

    /// Carries out a command as a panel's would be.
    pub fn apply(&mut self, command: ViewerCommand) {
        let ctx = self.harness.ctx.clone();
        self.harness.state_mut().0.model.apply(&ctx, command);
    }

    /// True where nothing has gone wrong so far.
    pub fn has_no_errors(&self) -> bool {
        self.model().messages.iter().all(|m| !m.is_error)
    }

    /// Where a place of the 3-D view is on the screen.
    pub fn on_screen(&self, place: Vec3) -> Pos2 {
        let rect = self.harness.get_by_label("3-D view").rect();
        let size = Vec2::new(rect.width(), rect.height());
        let at = self.model().settings.camera.project(place, size).expect("the place is in the view");
        rect.min + egui::vec2(at.x, at.y)
    }

    /// Presses the primary button or lets go of it.
    pub fn press(&mut self, pos: Pos2, pressed: bool) {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        self.harness.event(Event::PointerButton { pos, button, pressed, modifiers });
        self.harness.run_steps(2);
    }

    /// Points there and clicks.
    pub fn click(&mut self, pos: Pos2) {
        self.harness.hover_at(pos);
        self.harness.run_steps(2);
        self.press(pos, true);
        self.press(pos, false);
    }

    /// Drags with the primary button, a frame for each move.
    pub fn drag(&mut self, from: Pos2, to: Pos2) {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        self.harness.event(Event::PointerMoved(from));
        self.harness.event(Event::PointerButton { pos: from, button, pressed: true, modifiers });
        self.harness.step();
        for i in 1..=6 {
            self.harness.event(Event::PointerMoved(from.lerp(to, i as f32 / 6.0)));
            self.harness.step();
        }
        self.harness.event(Event::PointerButton { pos: to, button, pressed: false, modifiers });
        self.harness.run_steps(3);
    }

    /// Presses a key or lets go of it.
    pub fn key(&mut self, key: Key, pressed: bool) {
        let modifiers = Modifiers::NONE;
        self.harness.event(Event::Key { key, physical_key: None, pressed, repeat: false, modifiers });
        self.harness.run_steps(2);
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
