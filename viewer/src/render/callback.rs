//! The view inside an egui window.

use super::{OrbitCamera, SceneColours, SceneRenderer};
use eframe::egui;
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, ScreenDescriptor};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Draws the uploaded scene before egui's own pass and shows it there.
///
/// A renderer keeps one picture: for two views in one frame, use two renderers. The window's pass must have one sample a
/// pixel and no depth buffer, which is what eframe makes unless told otherwise.
#[derive(Clone)]
pub struct SceneCallback {
    /// The renderer, shared with the upload.
    pub renderer: Arc<Mutex<SceneRenderer>>,
    /// From where.
    pub camera: OrbitCamera,
    /// Size of the picture (pixels).
    pub size: [u32; 2],
    /// Colours of the surroundings.
    pub colours: SceneColours,
    /// Time to choose, encode and submit the last frame; the device may still be at work.
    pub time: Arc<Mutex<Duration>>,
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
        renderer.draw(self.size, &self.camera, &self.colours);
        *self.time.lock().unwrap_or_else(PoisonError::into_inner) = started.elapsed();
        Vec::new()
    }

    fn paint(&self, _: egui::PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, _: &CallbackResources) {
        self.renderer.lock().unwrap_or_else(PoisonError::into_inner).blit(pass);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui_wgpu::RendererOptions;
    use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};

    #[test]
    fn a_panel_shows_the_view_at_its_own_size() {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        if let Err(reason) = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())) {
            println!("skipped: no graphics adapter ({reason})");
            return;
        }
        let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
        let renderer = match SceneRenderer::new(&state.device, &state.queue, state.target_format) {
            Ok(renderer) => renderer,
            Err(reason) => {
                println!("skipped: {} cannot draw this ({reason})", state.adapter.get_info().name);
                return;
            }
        };
        let colours = SceneColours { horizon: crate::render::Rgba::hex(0x2080c0), ..SceneColours::for_theme(false) };
        let colours = SceneColours { sky: colours.horizon, ..colours };
        let callback = SceneCallback {
            renderer: Arc::new(Mutex::new(renderer)),
            camera: OrbitCamera::default(),
            size: [1, 1],
            colours,
            time: Arc::default(),
        };
        let shown = callback.clone();
        let rect = egui::Rect::from_min_size(egui::pos2(40.0, 20.0), egui::vec2(200.0, 100.0));
        let mut harness = egui_kittest::Harness::builder()
            .with_size([300.0, 200.0])
            .with_pixels_per_point(2.0)
            .renderer(WgpuTestRenderer::from_render_state(state))
            .build_ui(move |ui| {
                ui.painter().add(shown.clone().shape(ui, rect));
            });
        let Ok(image) = harness.render() else { panic!("egui drew nothing") };
        let blue = |x: u32, y: u32| {
            let [r, g, b, _] = image.get_pixel(x, y).0;
            r.abs_diff(0x20) < 3 && g.abs_diff(0x80) < 3 && b.abs_diff(0xc0) < 3
        };
        assert!(blue(84, 44) && blue(476, 44), "{:?}", image.get_pixel(84, 44));
        assert!(!blue(70, 44) && !blue(490, 44) && !blue(84, 30));
        let size = callback.renderer.lock().unwrap_or_else(PoisonError::into_inner).pixels().map(|p| p.0);
        assert_eq!(size, Ok([400, 200]));
    }
}
