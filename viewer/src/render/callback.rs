//! The view inside an egui window.

use super::{Camera, DrawStats, SceneColours, SceneRenderer};
use eframe::egui;
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, ScreenDescriptor};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What drawing cost, shared with whoever shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawReport {
    /// What was drawn.
    pub stats: DrawStats,
    /// Time to choose, encode and submit; the device may still be at work.
    pub time: Duration,
}

/// Draws the uploaded scene before egui's own pass and shows it there.
#[derive(Clone)]
pub struct SceneCallback {
    /// What draws, shared with whoever uploads.
    pub renderer: Arc<Mutex<SceneRenderer>>,
    /// From where.
    pub camera: Camera,
    /// Size of the picture. [Unit: pixels]
    pub size: [u32; 2],
    /// Colours of the surroundings.
    pub colours: SceneColours,
    /// Where the cost of the drawing is left.
    pub report: Arc<Mutex<DrawReport>>,
}

impl SceneCallback {
    /// The shape that shows the view in a rectangle of a panel.
    pub fn shape(mut self, ui: &egui::Ui, rect: egui::Rect) -> egui::Shape {
        let scale = ui.ctx().pixels_per_point();
        self.size = [rect.width(), rect.height()].map(|s| (s * scale).round().max(1.0) as u32);
        egui::Shape::Callback(Callback::new_paint_callback(rect, self))
    }
}

impl CallbackTrait for SceneCallback {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let started = Instant::now();
        let mut renderer = self.renderer.lock().unwrap_or_else(PoisonError::into_inner);
        let stats = renderer.draw(self.size, &self.camera, &self.colours);
        let report = DrawReport { stats, time: started.elapsed() };
        *self.report.lock().unwrap_or_else(PoisonError::into_inner) = report;
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &CallbackResources,
    ) {
        self.renderer.lock().unwrap_or_else(PoisonError::into_inner).blit(pass);
    }
}
