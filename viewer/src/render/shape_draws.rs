//! Draws a list of shapes: one instanced draw for each kind.

use super::device::{Gpu, GrowingBuffer};
use super::pipelines::{self, PipelineInput, PipelineOutput, PipelineRecipe};
use super::{Result, ShapeList, characters::GpuMesh};
use bytemuck::{Pod, Zeroable};
use std::f32::consts::{PI, TAU};
use wgpu::{BindGroupLayout, BufferUsages, RenderPass, RenderPipeline};

/// Points around a round cone, and rings of each of its ends.
const AROUND: usize = 14;
const END_RINGS: usize = 4;

/// Corner of the mesh all round cones share: a direction, and 0 at the first or 1 at the second end.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct RoundCorner {
    pub direction: [f32; 3],
    pub end: f32,
}

/// Shapes on the GPU.
pub(super) struct ShapeDraws {
    lines: (RenderPipeline, GrowingBuffer, u32),
    rounds: (RenderPipeline, GrowingBuffer, u32),
    rings: (RenderPipeline, GrowingBuffer, u32),
    round: GpuMesh,
}

impl ShapeDraws {
    pub fn new(gpu: &Gpu, scene_layout: &BindGroupLayout) -> Result<Self> {
        let device = &gpu.device;
        let pieces = [include_str!("shaders/scene.wgsl"), include_str!("shaders/shapes.wgsl")];
        let shader = &pipelines::shader(device, "shapes", &pieces);
        let kind = |label, stages, input, output| {
            let strip = input != PipelineInput::Rounds;
            let hidden = (!strip).then_some(wgpu::Face::Back);
            let groups = &[scene_layout];
            let pipeline = PipelineRecipe { label, shader, stages, groups, input, output, strip, hidden }.build(device);
            (pipeline, GrowingBuffer::new(device, label, BufferUsages::VERTEX), 0)
        };
        let (corners, triangles) = round_mesh(AROUND, END_RINGS);
        let mut round = GpuMesh::new(device);
        round.write(gpu, &corners, &triangles)?;
        Ok(Self {
            lines: kind("lines", ["line_vertex", "line_fragment"], PipelineInput::Lines, PipelineOutput::OVERLAY),
            rounds: kind("solids", ["round_vertex", "round_fragment"], PipelineInput::Rounds, PipelineOutput::GHOST),
            rings: kind("rings", ["ring_vertex", "ring_fragment"], PipelineInput::Rings, PipelineOutput::OVERLAY),
            round,
        })
    }

    /// Hands the shapes over.
    pub fn upload(&mut self, gpu: &Gpu, shapes: &ShapeList) -> Result<()> {
        let counts = [shapes.lines.len(), shapes.rounds.len(), shapes.rings.len()];
        [self.lines.2, self.rounds.2, self.rings.2] = counts.map(|count| count as u32);
        self.lines.1.write(gpu, &shapes.lines)?;
        self.rounds.1.write(gpu, &shapes.rounds)?;
        self.rings.1.write(gpu, &shapes.rings)?;
        Ok(())
    }

    /// Draws solids.
    pub fn draw_solids(&self, pass: &mut RenderPass<'_>) {
        let (pipeline, instances, count) = &self.rounds;
        if *count > 0 {
            pass.set_pipeline(pipeline);
            self.round.draw(pass, &instances.buffer, 0..*count);
        }
    }

    /// Draws rings, then lines.
    pub fn draw_flat(&self, pass: &mut RenderPass<'_>) {
        for (pipeline, instances, count) in [&self.rings, &self.lines] {
            if *count > 0 {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, instances.buffer.slice(..));
                pass.draw(0..4, 0..*count);
            }
        }
    }
}

/// A sphere cut at its equator; the halves belong to the two ends.
pub(super) fn round_mesh(around: usize, end_rings: usize) -> (Vec<RoundCorner>, Vec<u32>) {
    let mut corners = Vec::new();
    let mut ring = |angle: f32, end: f32| {
        for i in 0..around {
            let ((s, c), (up, out)) = ((TAU * i as f32 / around as f32).sin_cos(), angle.sin_cos());
            corners.push(RoundCorner { direction: [out * s, up, out * c], end });
        }
    };
    let step = |i: usize| 0.5 * PI * i as f32 / end_rings as f32;
    (0..=end_rings).rev().for_each(|i| ring(-step(i), 0.0));
    (0..=end_rings).for_each(|i| ring(step(i), 1.0));
    let mut indices = Vec::new();
    for r in 0..2 * end_rings + 1 {
        for i in 0..around {
            let at = |r: usize, i: usize| (r * around + i % around) as u32;
            let [a, b, c, d] = [at(r, i), at(r, i + 1), at(r + 1, i + 1), at(r + 1, i)];
            indices.extend([a, b, c, a, c, d]);
        }
    }
    (corners, indices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_shared_mesh_faces_outwards() {
        let (corners, indices) = round_mesh(AROUND, END_RINGS);
        for t in indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| {
                let corner = corners[t[i] as usize];
                Vec3::from(corner.direction) + Vec3::Y * corner.end
            });
            let normal = (b - a).cross(c - a);
            let middle = (a + b + c) / 3.0 - Vec3::Y * 0.5;
            assert!(normal.dot(middle) > -1e-6);
        }
    }
}
