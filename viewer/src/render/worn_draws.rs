//! Draws characters of the user's own.

use super::characters::{GpuMesh, draw_levels, layer_pipelines};
use super::device::{Gpu, GrowingBuffer};
use super::pipelines::{self, Layer, PipelineInput};
use super::worn_mesh::{TEXTURE_PX, WornMesh};
use super::{Result, mesh::LEVELS};
use std::{ops::Range, sync::Arc};
use throng_core::Mat3x4;
use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, Buffer, Device, RenderPass, RenderPipeline};

/// Characters that wear a mesh of the user's own, for one frame.
#[derive(Clone, Copy)]
pub struct WornFrame<'a> {
    /// The triangles.
    pub mesh: &'a Arc<WornMesh>,
    /// Matrices of all instances, in model space (instances * frames of the mesh).
    pub matrices: &'a [Mat3x4],
}

/// Everything about such characters that lives on the GPU.
pub(super) struct WornDraws {
    layout: BindGroupLayout,
    texture_layout: BindGroupLayout,
    group: Option<BindGroup>,
    textures: Option<BindGroup>,
    matrices: GrowingBuffer,
    meshes: [GpuMesh; LEVELS],
    built: Option<Arc<WornMesh>>,
    pipelines: [RenderPipeline; Layer::ALL.len()],
}

impl WornDraws {
    pub fn new(device: &Device, scene_layout: &BindGroupLayout) -> Self {
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let layout = pipelines::buffer_layout(device, "worn characters", &[storage; 2]);
        let texture_layout =
            pipelines::texture_layout(device, "textures of characters", wgpu::TextureViewDimension::D2Array);
        let sources = [include_str!("shaders/worn.wgsl"), include_str!("shaders/worn_body.wgsl")];
        let groups = &[scene_layout, &layout, &texture_layout];
        let pipelines = layer_pipelines(device, PipelineInput::Worn, sources, groups);
        Self {
            pipelines,
            layout,
            texture_layout,
            group: None,
            textures: None,
            matrices: GrowingBuffer::new(device, "matrices of worn characters", wgpu::BufferUsages::STORAGE),
            meshes: std::array::from_fn(|_| GpuMesh::new(device)),
            built: None,
        }
    }

    /// Hands over matrices, and a mesh that was not there.
    ///
    /// - `instances`: the instances that are drawn; `are_new`: true if that buffer was replaced.
    pub fn upload(&mut self, gpu: &Gpu, worn: &WornFrame<'_>, instances: &Buffer, are_new: bool) -> Result<()> {
        if !self.built.as_ref().is_some_and(|b| Arc::ptr_eq(b, worn.mesh)) {
            for (drawn, level) in self.meshes.iter_mut().zip(&worn.mesh.levels) {
                drawn.write(gpu, &level.vertices, &level.indices)?;
            }
            self.textures = Some(self.upload_textures(gpu, worn.mesh));
            self.built = Some(Arc::clone(worn.mesh));
        }
        let moved = self.matrices.write(gpu, worn.matrices)?;
        if moved || are_new || self.group.is_none() {
            let buffers = [&self.matrices.buffer, instances].map(Buffer::as_entire_binding);
            self.group = Some(pipelines::bind_group(&gpu.device, "worn characters", &self.layout, &buffers));
        }
        Ok(())
    }

    fn upload_textures(&self, Gpu { device, queue }: &Gpu, mesh: &WornMesh) -> BindGroup {
        let mip_level_count = TEXTURE_PX.ilog2() + 1;
        let mut data = Vec::new();
        for pixels in &mesh.layers {
            let mut smaller = pixels.clone();
            for level in 0..mip_level_count {
                if level > 0 {
                    let side = TEXTURE_PX >> level;
                    smaller = image::imageops::thumbnail(&smaller, side, side);
                }
                data.extend_from_slice(&smaller);
            }
        }
        let depth_or_array_layers = mesh.layers.len() as u32;
        let descriptor = wgpu::TextureDescriptor {
            label: Some("textures of characters"),
            size: wgpu::Extent3d { width: TEXTURE_PX, height: TEXTURE_PX, depth_or_array_layers },
            mip_level_count,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: pipelines::COLOUR,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let texture = device.create_texture_with_data(queue, &descriptor, TextureDataOrder::LayerMajor, &data);
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("textures of characters"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let resources = [BindingResource::TextureView(&view), BindingResource::Sampler(&sampler)];
        pipelines::bind_group(device, "textures of characters", &self.texture_layout, &resources)
    }

    /// Draws the characters of a layer.
    ///
    /// - `numbers`: numbers of characters, of which each list is a range.
    pub fn draw(&self, pass: &mut RenderPass<'_>, numbers: &Buffer, lists: &[Range<u32>], layer: Layer) {
        let (Some(group), Some(textures)) = (&self.group, &self.textures) else { return };
        if lists.iter().all(Range::is_empty) {
            return;
        }
        pass.set_pipeline(&self.pipelines[layer as usize]);
        pass.set_bind_group(1, group, &[]);
        if !layer.is_shadow() {
            pass.set_bind_group(2, textures, &[]);
        }
        draw_levels(pass, &self.meshes, numbers, lists);
    }
}
