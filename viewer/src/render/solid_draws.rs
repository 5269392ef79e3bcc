//! Draws things that stand in the world: one instanced draw for each mesh.

use super::device::{Gpu, GrowingBuffer};
use super::pipelines::{self, PipelineInput, PipelineOutput, PipelineRecipe};
use super::solids::{SolidInstance, SolidMesh};
use super::{Result, Rgba, Solids};
use bytemuck::{Pod, Zeroable};
use std::{ops::Range, sync::Arc};
use wgpu::{BindGroupLayout, BufferUsages, Device, RenderPipeline};

/// The struct `SolidIn` of `shaders/solids.wgsl`, but for the corner.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GpuSolid {
    at: [f32; 3],
    colour: Rgba,
    /// x, y, z, w.
    turn: [f32; 4],
}

/// Copies of one mesh that are drawn at once.
struct SolidBatch {
    indices: Range<u32>,
    base_vertex: i32,
    instances: Range<u32>,
    is_ghost: bool,
}

/// Things that stand in the world, on the GPU.
pub(super) struct SolidDraws {
    solid: RenderPipeline,
    ghost: RenderPipeline,
    vertices: GrowingBuffer,
    indices: GrowingBuffer,
    instances: GrowingBuffer,
    /// Meshes of the last upload.
    meshes: Arc<[SolidMesh]>,
    /// First index and first vertex of each mesh.
    starts: Vec<(u32, i32)>,
    shown: Vec<SolidInstance>,
    batches: Vec<SolidBatch>,
}

impl SolidDraws {
    /// - `mask_layout`: layout of the shadow mask, which falls on flat things on the ground.
    pub fn new(device: &Device, scene_layout: &BindGroupLayout, mask_layout: &BindGroupLayout) -> Self {
        let pieces = [include_str!("shaders/scene.wgsl"), include_str!("shaders/solids.wgsl")];
        let shader = &pipelines::shader(device, "solids", &pieces);
        let groups = &[scene_layout, mask_layout];
        let pipeline = |output| {
            let (stages, hidden) = (["solid_vertex", "solid_fragment"], Some(wgpu::Face::Back));
            let input = PipelineInput::Solids;
            PipelineRecipe { label: "things", shader, stages, groups, input, output, strip: false, hidden }
                .build(device)
        };
        Self {
            solid: pipeline(PipelineOutput::SOLID),
            ghost: pipeline(PipelineOutput::GHOST),
            vertices: GrowingBuffer::new(device, "corners of things", BufferUsages::VERTEX),
            indices: GrowingBuffer::new(device, "triangles of things", BufferUsages::INDEX),
            instances: GrowingBuffer::new(device, "things", BufferUsages::VERTEX),
            meshes: Arc::default(),
            starts: Vec::new(),
            shown: Vec::new(),
            batches: Vec::new(),
        }
    }

    /// Uploads what has changed.
    pub fn upload(&mut self, gpu: &Gpu, solids: &Solids) -> Result<()> {
        let are_new = !Arc::ptr_eq(&self.meshes, &solids.meshes);
        if are_new {
            self.upload_meshes(gpu, &solids.meshes)?;
            self.meshes = Arc::clone(&solids.meshes);
        }
        if are_new || self.shown != solids.instances {
            self.shown.clone_from(&solids.instances);
            self.upload_instances(gpu)?;
        }
        Ok(())
    }

    fn upload_meshes(&mut self, gpu: &Gpu, meshes: &[SolidMesh]) -> Result<()> {
        self.batches.clear();
        self.starts.clear();
        let (mut vertices, mut indices) = (Vec::new(), Vec::new());
        for mesh in meshes {
            self.starts.push((indices.len() as u32, vertices.len() as i32));
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
        }
        self.vertices.write(gpu, &vertices)?;
        self.indices.write(gpu, &indices)?;
        Ok(())
    }

    fn upload_instances(&mut self, gpu: &Gpu) -> Result<()> {
        self.batches.clear();
        let is_ghost = |s: &SolidInstance| s.colour.0[3] < 255;
        let mut sorted: Vec<&SolidInstance> =
            self.shown.iter().filter(|s| (s.mesh as usize) < self.starts.len()).collect();
        sorted.sort_by_key(|s| (is_ghost(s), s.mesh));
        let placed = |s: &&SolidInstance| GpuSolid { at: s.at.to_array(), colour: s.colour, turn: s.turn.to_array() };
        self.instances.write(gpu, &sorted.iter().map(placed).collect::<Vec<_>>())?;
        let mut first = 0;
        for group in sorted.chunk_by(|a, b| (is_ghost(a), a.mesh) == (is_ghost(b), b.mesh)) {
            let mesh = group[0].mesh as usize;
            let (start, base_vertex) = self.starts[mesh];
            let next = first + group.len() as u32;
            let (indices, is_ghost) = (start..start + self.meshes[mesh].indices.len() as u32, is_ghost(group[0]));
            self.batches.push(SolidBatch { indices, base_vertex, instances: first..next, is_ghost });
            first = next;
        }
        Ok(())
    }

    /// Draws transparent things, or opaque ones. Group 1 has to be the shadow mask.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, ghosts: bool) {
        let batches = self.batches.iter().filter(|b| b.is_ghost == ghosts && !b.indices.is_empty());
        for (i, b) in batches.enumerate() {
            if i == 0 {
                pass.set_pipeline(if ghosts { &self.ghost } else { &self.solid });
                pass.set_vertex_buffer(0, self.vertices.buffer.slice(..));
                pass.set_vertex_buffer(1, self.instances.buffer.slice(..));
                pass.set_index_buffer(self.indices.buffer.slice(..), wgpu::IndexFormat::Uint32);
            }
            pass.draw_indexed(b.indices.clone(), b.base_vertex, b.instances.clone());
        }
    }
}
