//! The texture that stands for a screen.

use super::HeadlessError;
use crate::args::{AdapterChoice, PictureSize};
use crate::render::{device_descriptor, read_back, target_texture, wait};
use eframe::egui;
use eframe::egui_wgpu::{
    RenderState, RendererOptions, ScreenDescriptor, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew, wgpu,
};
use image::RgbImage;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use wgpu::{Backend, DeviceType};

/// A texture that egui draws into.
pub struct Screen {
    /// Device and renderer of egui and the 3-D view.
    pub(super) state: RenderState,
    texture: wgpu::Texture,
    size: PictureSize,
    scale: f32,
    /// The first thing that the graphics library complained about.
    complaint: Arc<Mutex<Option<String>>>,
}

impl Screen {
    /// Opens an adapter and makes a texture of a size; `scale` pixels are a point.
    ///
    /// # Errors
    /// [`HeadlessError`] where there is no adapter or it does not draw so large a picture.
    pub fn new(choice: AdapterChoice, size: PictureSize, scale: f32) -> Result<Self, HeadlessError> {
        let state = open_adapter(choice)?;
        let limit = state.device.limits().max_texture_dimension_2d;
        if size.width.max(size.height) > limit {
            return Err(HeadlessError::Size { size, adapter: state.adapter.get_info().name, limit });
        }
        let complaint = Arc::new(Mutex::new(None));
        let heard = Arc::clone(&complaint);
        state.device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
            heard.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| e.to_string());
        }));
        let (pixels, usage) = ([size.width, size.height], wgpu::TextureUsages::COPY_SRC);
        let texture = target_texture(&state.device, "screen", pixels, state.target_format, 1, usage);
        Ok(Self { state, texture, size, scale, complaint })
    }

    /// Name of the graphics adapter.
    pub fn adapter_name(&self) -> String {
        self.state.adapter.get_info().name
    }

    /// Input that a window of this size would pass to egui.
    pub(super) fn input(&self, time_s: f64) -> egui::RawInput {
        let size = egui::vec2(self.size.width as f32, self.size.height as f32) / self.scale;
        let mut input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            max_texture_side: Some(self.state.device.limits().max_texture_dimension_2d as usize),
            time: Some(time_s),
            ..egui::RawInput::default()
        };
        input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = Some(self.scale);
        input
    }

    /// Applies the output of egui, and draws it if `draws` is set; returns the time from encoding until drawing has
    /// ended (s).
    pub(super) fn draw_output(
        &self,
        ctx: &egui::Context,
        mut output: egui::FullOutput,
        draws: bool,
    ) -> Result<f64, HeadlessError> {
        let RenderState { device, queue, renderer, .. } = &self.state;
        for (id, images) in output.textures_delta.set.drain() {
            images.iter().for_each(|image| renderer.write().update_texture(device, queue, id, image));
        }
        let shapes = std::mem::take(&mut output.shapes);
        let drawing_s = if draws {
            let primitives = ctx.tessellate(shapes, output.pixels_per_point);
            let begin = Instant::now();
            self.draw(&primitives, output.pixels_per_point)?;
            begin.elapsed().as_secs_f64()
        } else {
            // Hands on the textures, which would pile up.
            queue.submit([]);
            0.0
        };
        output.textures_delta.free.drain().for_each(|id| renderer.write().free_texture(&id));
        self.complaint()?;
        Ok(drawing_s)
    }

    fn draw(&self, primitives: &[egui::ClippedPrimitive], pixels_per_point: f32) -> Result<(), HeadlessError> {
        let RenderState { device, queue, renderer, .. } = &self.state;
        let screen = ScreenDescriptor { size_in_pixels: [self.size.width, self.size.height], pixels_per_point };
        let mut renderer = renderer.write();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        let mut commands = renderer.update_buffers(device, queue, &mut encoder, primitives, &screen);
        let view = self.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
        let colour = wgpu::RenderPassColorAttachment { view: &view, depth_slice: None, resolve_target: None, ops };
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("frame"),
                color_attachments: &[Some(colour)],
                ..wgpu::RenderPassDescriptor::default()
            })
            .forget_lifetime();
        renderer.render(&mut pass, primitives, &screen);
        drop(pass);
        commands.push(encoder.finish());
        queue.submit(commands);
        wait(device).map_err(|e| self.failed(&e))
    }

    /// Error that the graphics library reported since the last call.
    fn complaint(&self) -> Result<(), HeadlessError> {
        let complaint = self.complaint.lock().unwrap_or_else(PoisonError::into_inner).take();
        complaint.map_or(Ok(()), |c| Err(self.failed(&c)))
    }

    fn failed(&self, reason: &dyn std::fmt::Display) -> HeadlessError {
        HeadlessError::Drawing { adapter: self.adapter_name(), reason: reason.to_string() }
    }

    /// The picture that was drawn last.
    ///
    /// # Errors
    /// [`HeadlessError::Drawing`]
    pub fn read(&self) -> Result<RgbImage, HeadlessError> {
        let read = read_back(&self.state.device, &self.state.queue, &self.texture);
        self.complaint()?;
        let ([width, height], rgba) = read.map_err(|e| self.failed(&e))?;
        let rgb = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        Ok(RgbImage::from_raw(width, height, rgb).unwrap_or_default())
    }
}

/// Opens a graphics adapter without a window.
fn open_adapter(choice: AdapterChoice) -> Result<RenderState, HeadlessError> {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.native_adapter_selector = Some(Arc::new(move |adapters, _| {
        let best = adapters.iter().min_by_key(|a| rank(choice, &a.get_info()));
        best.cloned().ok_or_else(|| "the system has none".to_owned())
    }));
    setup.device_descriptor = Arc::new(device_descriptor);
    let setup = WgpuSetup::CreateNew(setup);
    let instance = pollster::block_on(setup.new_instance());
    let config = WgpuConfiguration { wgpu_setup: setup, ..WgpuConfiguration::default() };
    let state = pollster::block_on(RenderState::create(&config, &instance, None, RendererOptions::PREDICTABLE));
    state.map_err(|e| HeadlessError::NoAdapter { reason: e.to_string() })
}

/// The lower, the better: first the kind of adapter, then the interface to it.
fn rank(choice: AdapterChoice, info: &wgpu::AdapterInfo) -> (u8, u8) {
    let kind = match info.device_type {
        DeviceType::Cpu if choice == AdapterChoice::Software => 0,
        DeviceType::DiscreteGpu => 1,
        DeviceType::IntegratedGpu => 2,
        DeviceType::VirtualGpu | DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    let backend = match info.backend {
        Backend::Vulkan | Backend::Metal | Backend::Dx12 => 0,
        Backend::Gl => 1,
        Backend::BrowserWebGpu | Backend::Noop => 2,
    };
    // A backend that draws nothing is the last resort, whatever its device.
    if backend == 2 { (5, backend) } else { (kind, backend) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(device_type: DeviceType, backend: Backend) -> wgpu::AdapterInfo {
        wgpu::AdapterInfo::new(device_type, backend)
    }

    #[test]
    fn software_comes_first_where_pictures_are_to_be_alike() {
        let lavapipe = info(DeviceType::Cpu, Backend::Vulkan);
        let llvmpipe = info(DeviceType::Cpu, Backend::Gl);
        let card = info(DeviceType::DiscreteGpu, Backend::Vulkan);
        let none = info(DeviceType::Cpu, Backend::Noop);
        let order = |choice, all: [&wgpu::AdapterInfo; 4]| {
            let mut ranks = all.map(|i| rank(choice, i));
            let given = ranks;
            ranks.sort();
            given == ranks
        };
        assert!(order(AdapterChoice::Software, [&lavapipe, &llvmpipe, &card, &none]));
        assert!(order(AdapterChoice::Any, [&card, &lavapipe, &llvmpipe, &none]));
    }
}
