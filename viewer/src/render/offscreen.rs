//! The textures that the view is drawn into, and their transfer into a window.

use super::device::{Gpu, wait};
use super::pipelines::{self, COLOUR, DEPTH, MASK, PipelineInput, PipelineOutput, PipelineRecipe, SAMPLES};
use super::{RenderError, Result};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, Device, Queue, Texture, TextureView};

/// Textures of one size.
pub(super) struct RenderTargets {
    /// Width and height (pixels).
    pub size: [u32; 2],
    /// Colour with several samples a pixel.
    pub colour: TextureView,
    pub depth: TextureView,
    /// Average of the samples.
    pub resolved: TextureView,
    /// Shadows on the ground, as the camera sees them.
    pub mask: TextureView,
    /// The mask for the ground's shader.
    pub mask_group: BindGroup,
    picture: Texture,
    picture_group: BindGroup,
}

/// Makes targets, shows them, reads them back.
pub(super) struct Offscreen {
    /// Layout of the mask in the ground's shader.
    pub mask_layout: BindGroupLayout,
    sampler: wgpu::Sampler,
    picture_layout: BindGroupLayout,
    blit: wgpu::RenderPipeline,
    targets: Option<RenderTargets>,
}

impl Offscreen {
    /// For windows of a format; nothing is allocated before the first picture.
    pub fn new(device: &Device, window: wgpu::TextureFormat) -> Self {
        let picture_layout = pipelines::texture_layout(device, "picture", wgpu::TextureViewDimension::D2);
        let shader = &pipelines::shader(device, "blit", &[include_str!("shaders/blit.wgsl")]);
        let fragment = if window.is_srgb() { "linear_fragment" } else { "encoded_fragment" };
        let (stages, groups) = (["vertex", fragment], &[&picture_layout]);
        let (input, output) = (PipelineInput::Nothing, PipelineOutput::Window(window));
        let blit = PipelineRecipe { label: "blit", shader, stages, groups, input, output, strip: false, hidden: None };
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("picture"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let blit = blit.build(device);
        let mask_layout = pipelines::texture_layout(device, "shadow mask", wgpu::TextureViewDimension::D2);
        Self { mask_layout, sampler, picture_layout, blit, targets: None }
    }

    /// The targets of a size, rebuilt if it has changed; sizes are limited to what the device supports.
    pub fn resize(&mut self, device: &Device, size: [u32; 2]) -> &RenderTargets {
        let size = size.map(|s| s.clamp(1, device.limits().max_texture_dimension_2d));
        let kept = self.targets.take().filter(|t| t.size == size);
        let targets = kept.unwrap_or_else(|| self.allocate(device, size));
        self.targets.insert(targets)
    }

    fn allocate(&self, device: &Device, size: [u32; 2]) -> RenderTargets {
        use wgpu::TextureUsages as Usage;
        let texture = |label, format, samples, usage| target_texture(device, label, size, format, samples, usage);
        let view = |t: &Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let picture = texture("picture", COLOUR, 1, Usage::TEXTURE_BINDING | Usage::COPY_SRC);
        let resolved = view(&picture);
        let mask = view(&texture("shadow mask", MASK, 1, Usage::TEXTURE_BINDING));
        RenderTargets {
            size,
            colour: view(&texture("samples", COLOUR, SAMPLES, Usage::empty())),
            depth: view(&texture("depth", DEPTH, SAMPLES, Usage::empty())),
            mask_group: self.group(device, &self.mask_layout, &mask),
            picture_group: self.group(device, &self.picture_layout, &resolved),
            resolved,
            mask,
            picture,
        }
    }

    fn group(&self, device: &Device, layout: &BindGroupLayout, view: &TextureView) -> BindGroup {
        let resources = [BindingResource::TextureView(view), BindingResource::Sampler(&self.sampler)];
        pipelines::bind_group(device, "texture", layout, &resources)
    }

    /// Draws the last picture over the viewport of a pass with one sample and no depth.
    pub fn blit(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(targets) = &self.targets {
            pass.set_pipeline(&self.blit);
            pass.set_bind_group(0, &targets.picture_group, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// The last picture: its size, and sRGB with alpha, four bytes a pixel, rows from the top.
    ///
    /// # Errors
    /// [`RenderError::ReadBack`] where the device fails, or where nothing has been drawn.
    pub fn pixels(&self, gpu: &Gpu) -> Result<([u32; 2], Vec<u8>)> {
        let nothing = || RenderError::ReadBack("nothing has been drawn".to_owned());
        read_back(&gpu.device, &gpu.queue, &self.targets.as_ref().ok_or_else(nothing)?.picture)
    }
}

/// A texture that is drawn into.
///
/// - `usage`: other uses.
pub fn target_texture(
    device: &Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    sample_count: u32,
    usage: wgpu::TextureUsages,
) -> Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

/// Size and bytes of a texture of four bytes a pixel; waits for the device.
///
/// # Errors
/// [`RenderError::ReadBack`] where the device fails or hangs.
pub fn read_back(device: &Device, queue: &Queue, texture: &Texture) -> Result<([u32; 2], Vec<u8>)> {
    let failed = |e: &dyn std::fmt::Display| RenderError::ReadBack(e.to_string());
    let [width, height] = [texture.width(), texture.height()];
    let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read back") });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    // Reading the range below fails if mapping failed.
    buffer.map_async(wgpu::MapMode::Read, .., |_| ());
    wait(device).map_err(|e| failed(&e))?;
    let mapped = buffer.get_mapped_range(..).map_err(|e| failed(&e))?;
    let rows = mapped.chunks_exact(row as usize).flat_map(|r| &r[..width as usize * 4]);
    Ok(([width, height], rows.copied().collect()))
}
