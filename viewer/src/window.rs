//! The window.

use crate::args::{Args, PictureSize};
use crate::document::{OpenDocument, may_be_made};
use crate::{app::Viewer, render::device_descriptor, settings::ViewerSettings};
use eframe::egui;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use throng_core::base::file::{MAX_BUNDLE_BYTES, open_file};

/// Key of the settings in the store.
const SETTINGS_KEY: &str = "settings";
/// Under this name the settings are kept between runs.
const APP_ID: &str = "throng-viewer";
/// The window is at least as large (points).
const MIN_SIZE: [f32; 2] = [640.0, 400.0];
/// Second sentence of every message about a missing window.
const WAY_OUT: &str = "`throng-viewer FILE --png OUT` draws a picture without one";

/// Opens the window, and returns when it is closed.
///
/// # Errors
/// A message that says why there is no window, and the way out.
pub fn run(args: &Args) -> Result<(), String> {
    // There windows need a display server, which the environment names.
    let needs_display = cfg!(all(unix, not(target_os = "macos")));
    let has_value = |variable| std::env::var_os(variable).is_some_and(|v| !v.is_empty());
    if needs_display && !["DISPLAY", "WAYLAND_DISPLAY"].into_iter().any(has_value) {
        return Err(format!("there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set); {WAY_OUT}"));
    }
    if let Some(file) = args.file.as_ref().filter(|f| !f.is_dir()) {
        open_file(file, "a file to show", MAX_BUNDLE_BYTES).map_err(|e| e.to_string())?;
    }
    let is_open = Arc::new(AtomicBool::new(false));
    let (args, opened) = (args.clone(), Arc::clone(&is_open));
    let native = options(args.size);
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        opened.store(true, Ordering::Relaxed);
        Ok(Box::new(ViewerWindow::new(&args, cc)?))
    });
    // The windowing library panics where a shared library of the system is not there.
    match catch_unwind(AssertUnwindSafe(|| eframe::run_native(APP_ID, native, create))) {
        Ok(Ok(())) => Ok(()),
        Ok(Err(eframe::Error::AppCreation(e))) => Err(e.to_string()),
        Ok(Err(e)) => Err(format!("the window cannot be opened: {e}; {WAY_OUT}")),
        Err(panic) if is_open.load(Ordering::Relaxed) => resume_unwind(panic),
        Err(_) => Err(format!("the window cannot be opened on this system; {WAY_OUT}")),
    }
}

fn options(size: Option<PictureSize>) -> eframe::NativeOptions {
    let asked = size.unwrap_or_default();
    let viewport = egui::ViewportBuilder::default()
        .with_title("Throng")
        .with_app_id(APP_ID)
        .with_inner_size([asked.width as f32, asked.height as f32])
        .with_min_inner_size(MIN_SIZE)
        .with_drag_and_drop(true);
    // eframe adds the handle of the display.
    let setup = WgpuSetupCreateNew {
        device_descriptor: Arc::new(device_descriptor),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    let wgpu_options = WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..WgpuConfiguration::default() };
    eframe::NativeOptions {
        viewport,
        wgpu_options,
        renderer: eframe::Renderer::Wgpu,
        // A size that was asked for goes over the one of the last run.
        persist_window: size.is_none(),
        ..eframe::NativeOptions::default()
    }
}

/// The viewer with the parts that only a window has: stored settings, and an end.
struct ViewerWindow {
    viewer: Viewer,
    /// Arguments to apply when the document under construction is ready.
    waiting: Option<Args>,
    /// Frames after which the window closes.
    frames_left: Option<u32>,
}

impl ViewerWindow {
    fn new(args: &Args, cc: &eframe::CreationContext<'_>) -> Result<Self, String> {
        let kept = cc.storage.and_then(|s| eframe::get_value::<ViewerSettings>(s, SETTINGS_KEY)).unwrap_or_default();
        let mut settings = args.settings(kept);
        settings.zoom = args.scale.unwrap_or(settings.zoom);
        let mut viewer = Viewer::new(settings, cc.wgpu_render_state.as_ref());
        viewer.model.is_untrusted = args.untrusted;
        args.dress(&mut viewer.model)?;
        let made = args.file.as_ref().filter(|f| may_be_made(f));
        match made {
            Some(file) => viewer.model.start_reading(&cc.egui_ctx, std::slice::from_ref(file)),
            None => args.open(&cc.egui_ctx, &mut viewer.model)?,
        }
        Ok(Self { viewer, waiting: made.map(|_| args.clone()), frames_left: args.frames })
    }

    /// Applies the arguments to the document that was built.
    fn show_waiting(&mut self, ctx: &egui::Context) {
        let model = &mut self.viewer.model;
        if model.loading().is_none()
            && let Some(args) = self.waiting.take()
            && !matches!(model.document, OpenDocument::Nothing)
            && let Err(why) = args.show(ctx, model)
        {
            model.complain(why);
        }
    }
}

impl eframe::App for ViewerWindow {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.viewer.logic(ctx, ctx.input(|i| i.unstable_dt));
        self.show_waiting(ctx);
        if let Some(left) = self.frames_left.as_mut().filter(|_| self.waiting.is_none()) {
            *left = left.saturating_sub(1);
            if *left == 0 {
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            ctx.request_repaint();
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.viewer.ui(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, SETTINGS_KEY, &self.viewer.model.settings);
    }
}
