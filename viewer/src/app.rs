//! The viewer without its window: the same code runs in a window, for a picture and in tests.

use crate::command::{Commands, ViewerCommand};
use crate::panels::{PANELS, PanelStates, SystemDialog, dock, keys, messages, start, top_bar, transport, viewport};
use crate::render::{SceneCallback, SceneColours, SceneFrame, SceneRenderer, WornFrame};
use crate::settings::{Dock, ViewerSettings};
use crate::{document::OpenDocument, model::Model, panels::viewport::steer::Pads, stage::StageLayout, theme};
use eframe::egui::{self, CentralPanel, Frame, Panel, Ui};
use eframe::egui_wgpu::RenderState;
use keys::KeyAction;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use std::{path::PathBuf, pin::Pin};
use throng_precompute::import;

/// The viewer.
pub struct Viewer {
    /// All that it knows.
    pub model: Model,
    /// View states of the panels.
    pub states: PanelStates,
    renderer: Result<Arc<Mutex<SceneRenderer>>, String>,
    /// Time for encoding the last frame of the 3-D view.
    drawing: Arc<Mutex<Duration>>,
    layout: StageLayout,
    /// Commands that panels asked for in the last frame.
    pending: Commands,
    dialog: Option<(SystemDialog, Receiver<Vec<PathBuf>>)>,
    /// Scale of the window as last set.
    zoom: Option<f32>,
    pads: Pads,
}

impl Viewer {
    /// A viewer with nothing open. Without a graphics device, the 3-D view shows an error.
    pub fn new(settings: ViewerSettings, render_state: Option<&RenderState>) -> Self {
        let renderer = render_state.ok_or("There is no graphics device to draw with.".to_owned()).and_then(|r| {
            let renderer = SceneRenderer::new(&r.device, &r.queue, r.target_format);
            renderer.map(|r| Arc::new(Mutex::new(r))).map_err(|e| e.to_string())
        });
        Self {
            model: Model::new(settings.limited()),
            states: PanelStates::default(),
            renderer,
            drawing: Arc::default(),
            layout: StageLayout::default(),
            pending: Vec::new(),
            dialog: None,
            zoom: None,
            pads: Pads::default(),
        }
    }

    /// Carries out the commands of the last frame and advances time. No user interface is shown here, and nothing is
    /// simulated anywhere else.
    pub fn logic(&mut self, ctx: &egui::Context, wall_s: f32) {
        if wall_s > 0.0 {
            self.model.times.frame_s = f64::from(wall_s);
        }
        self.model.times.drawing_s = self.drawing.lock().unwrap_or_else(PoisonError::into_inner).as_secs_f64();
        if let Some((wanted, paths)) = self.dialog.as_ref().and_then(|(w, d)| Some((*w, d.try_recv().ok()?))) {
            self.dialog = None;
            match (wanted, &paths[..]) {
                (SystemDialog::Body, [path]) => self.model.apply(ctx, ViewerCommand::Wear(path.clone())),
                _ => self.model.apply(ctx, ViewerCommand::Open(paths)),
            }
        }
        let begin = Instant::now();
        for command in self.pending.drain(..) {
            self.model.apply(ctx, command);
        }
        self.model.advance(ctx, wall_s);
        self.model.times.simulation_s = begin.elapsed().as_secs_f64();
        if self.model.is_playing() || self.model.is_busy() {
            ctx.request_repaint();
        } else if self.model.loading().is_some() {
            ctx.request_repaint_after(Duration::from_millis(100));
        } else {
            // Files are watched while nothing moves, too.
            ctx.request_repaint_after(Duration::from_millis(500));
        }
    }

    /// Shows everything, and keeps the commands of panels until [`Viewer::logic`] carries them out.
    pub fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.appearance(&ctx);
        let mut commands = Vec::new();
        self.keys(&ctx, &mut commands);
        let dropped = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_path_buf()).collect::<Vec<_>>());
        if !dropped.is_empty() {
            commands.push(ViewerCommand::Open(dropped));
        }
        self.upload(ctx.theme() == egui::Theme::Dark);
        self.panels(ui, &mut commands);
        self.model.aspect = self.states.viewport.aspect;
        keys::show(ui, &mut self.states.help);
        if !commands.is_empty() {
            self.pending.append(&mut commands);
            ctx.request_repaint();
        }
        if let Some(wanted) = self.states.dialog.take() {
            self.open_dialog(&ctx, wanted);
        }
    }

    fn appearance(&mut self, ctx: &egui::Context) {
        let s = &mut self.model.settings;
        if self.zoom.is_none() {
            theme::prepare(ctx);
        }
        ctx.set_theme(s.theme);
        if self.zoom.is_some_and(|z| z != ctx.zoom_factor()) {
            // Changed by the keys that every window has for it.
            s.zoom = ctx.zoom_factor();
        }
        s.zoom = s.zoom.clamp(0.5, 3.0);
        self.zoom = Some(s.zoom);
        ctx.set_zoom_factor(s.zoom);
    }

    fn panels(&mut self, ui: &mut Ui, commands: &mut Commands) {
        let (model, states) = (&self.model, &mut self.states);
        if !states.bare {
            Panel::top("top bar").show(ui, |ui| top_bar::show(ui, model, states, commands));
        }
        if matches!(model.document, OpenDocument::Nothing) {
            CentralPanel::default().show(ui, |ui| {
                start::show(ui, model, states, commands);
                messages::show(ui, ui.max_rect(), model, commands);
            });
            return;
        }
        if !states.bare {
            Panel::bottom("transport").show(ui, |ui| {
                ui.add_space(3.0);
                transport::show(ui, model, commands);
                ui.add_space(3.0);
            });
        }
        if model.settings.side_panel.is_some() {
            let side = Panel::right("side").default_size(370.0).size_range(260.0..=900.0);
            side.show(ui, |ui| dock::show(ui, Dock::Side, model, states, commands));
        }
        if model.settings.bottom_panel.is_some() {
            let bottom = Panel::bottom("bottom").resizable(true).default_size(300.0).size_range(140.0..=900.0);
            bottom.show(ui, |ui| dock::show(ui, Dock::Bottom, model, states, commands));
        }
        let dark = ui.visuals().dark_mode;
        let (renderer, drawing, layout) = (&self.renderer, &self.drawing, &self.layout);
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            let paint = |ui: &Ui, rect: egui::Rect| {
                let renderer = renderer.as_ref().map_err(Clone::clone)?;
                let callback = SceneCallback {
                    renderer: Arc::clone(renderer),
                    camera: model.settings.camera,
                    size: [1, 1],
                    colours: SceneColours::for_theme(dark),
                    time: Arc::clone(drawing),
                };
                ui.painter().add(callback.shape(ui, rect));
                Ok(())
            };
            let mut viewport = std::mem::take(&mut states.viewport);
            viewport::show(ui, model, layout, &mut viewport, commands, paint);
            states.viewport = viewport;
        });
    }

    /// Lays out the frame and hands it to the graphics device.
    fn upload(&mut self, dark: bool) {
        let begin = Instant::now();
        self.layout.lay_out(&self.model, dark);
        self.model.times.layout_s = begin.elapsed().as_secs_f64();
        let Ok(renderer) = &self.renderer else { return };
        let mut renderer = renderer.lock().unwrap_or_else(PoisonError::into_inner);
        let begin = Instant::now();
        let frame = SceneFrame {
            skeleton: &self.layout.skeleton,
            body: self.model.settings.body,
            worn: self.model.worn_outfit().map(|o| WornFrame { mesh: &o.mesh, matrices: &self.layout.worn }),
            palette: self.layout.poses(&self.model),
            instances: &self.layout.instances,
            records: &self.layout.records,
            rows: self.layout.rows.as_ref(),
            shapes: &self.layout.shapes,
            solids: &self.layout.solids,
        };
        let uploaded = renderer.upload(&frame);
        drop(renderer);
        self.model.times.upload_s = begin.elapsed().as_secs_f64();
        if let Err(e) = uploaded {
            self.model.complain(e.to_string());
        }
    }

    fn keys(&mut self, ctx: &egui::Context, commands: &mut Commands) {
        if ctx.text_edit_focused() || egui::Popup::is_any_open(ctx) {
            return;
        }
        viewport::steer::keys(ctx, &self.model, self.pads.read(), commands);
        for panel in PANELS {
            if ctx.input_mut(|i| i.consume_key(egui::Modifiers::NONE, panel.key)) {
                commands.push(ViewerCommand::TogglePanel(panel.kind));
            }
        }
        for pressed in keys::take_pressed(ctx, self.states.blend.has_focus()) {
            if self.states.help {
                // Over everything else, the list only waits to be closed.
                self.states.help = ![egui::Key::Escape, egui::Key::H].contains(&pressed.key);
                continue;
            }
            match pressed.action {
                KeyAction::Ask(command) => commands.push(command(&self.model)),
                KeyAction::Change(change) => {
                    let mut settings = self.model.settings.clone();
                    change(&mut settings, &self.model, ctx.theme() == egui::Theme::Dark);
                    commands.push(ViewerCommand::Settings(Box::new(settings)));
                }
                KeyAction::Open => self.states.dialog = Some(SystemDialog::Files),
                KeyAction::Help => self.states.help = true,
            }
        }
    }

    /// Asks for files or a folder in the system's own dialog, away from this thread.
    fn open_dialog(&mut self, ctx: &egui::Context, wanted: SystemDialog) {
        let dialog = rfd::AsyncFileDialog::new();
        let chosen: Pin<Box<dyn Future<Output = Option<Vec<_>>> + Send>> = match wanted {
            SystemDialog::Files => {
                let extensions = [&["throng", "toml", "zip"], &import::EXTENSIONS[..]].concat();
                let dialog = dialog.add_filter("bundles, scenes, worlds, motion files, archives of them", &extensions);
                Box::pin(dialog.add_filter("all files", &["*"]).pick_files())
            }
            SystemDialog::Body => {
                let chosen = dialog.add_filter("characters with a skin", &["glb", "gltf"]).pick_file();
                Box::pin(async { chosen.await.map(|file| vec![file]) })
            }
            SystemDialog::Folder => {
                let chosen = dialog.pick_folder();
                Box::pin(async { chosen.await.map(|folder| vec![folder]) })
            }
        };
        let (send, receive) = channel();
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            // Nothing is sent where the dialog is closed, or where the viewer is.
            if let Some(files) = pollster::block_on(chosen)
                && send.send(files.iter().map(|f| f.path().to_path_buf()).collect()).is_ok()
            {
                ctx.request_repaint();
            }
        });
        self.dialog = Some((wanted, receive));
    }
}
