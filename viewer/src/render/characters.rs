//! Characters on the GPU: the matrix palette, roots and colours, and which are drawn at which level of detail.

use super::cull::{self, Frustum};
use super::device::{Gpu, GrowingBuffer};
use super::mesh::{self, BodyStyle, LEVELS};
use super::pipelines::{self, Layer, PipelineInput, PipelineRecipe};
use super::{OrbitCamera, RenderError, Result, Rgba, SceneFrame, picking::world_position, worn_draws::WornDraws};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::{ops::Range, sync::Arc};
use throng_core::{Mat3x4, NUM_JOINTS, Planar, Skeleton, characters::PoseInstance};
use wgpu::{BindGroup, BindGroupLayout, Device, Face, Queue, RenderPass, RenderPipeline};

/// From these heights in pixels on, a body is drawn at a level of detail, finest first; below, at the coarsest.
const LEVEL_PIXELS: [f32; LEVELS - 1] = [170.0, 72.0, 40.0];
/// The level of the shadow, by the level of the body.
const SHADOW_LEVEL: [usize; LEVELS] = [1, 2, 3, 3];
/// Number of finest shadow levels at which contact with the ground is drawn.
const CONTACT_LEVELS: usize = 2;
/// Shadows fall this far beyond the sphere of their body at most (m).
const SHADOW_REACH: f32 = 1.6;

/// One character to draw; its pose is in the palette.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterInstance {
    /// Model to world.
    pub root: Planar,
    /// Main colour; other parts are shades of it. With alpha below 1 the character is a ghost, drawn after all others.
    pub colour: Rgba,
    /// The edge of a selected character glows.
    pub is_selected: bool,
    /// Bits that choose the colours of clothes and skin; 0 for the default colours.
    pub look: u32,
}

/// One character to draw from frame rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordInstance {
    /// Which rows, and where.
    pub instance: PoseInstance,
    /// Main colour, see [`CharacterInstance`].
    pub colour: Rgba,
    /// Bits that choose colours, see [`CharacterInstance`].
    pub look: u32,
}

/// The struct `PoseInstance` of `shaders/instance.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct GpuInstance {
    root: [f32; 4],
    colour: Rgba,
    is_selected: u32,
    /// Rows of a record; [`FROM_PALETTE`] where the pose is in the palette.
    row_a: u32,
    row_b: u32,
    frac_blend: [u16; 2],
    y: f32,
    /// First matrix of a mesh of the user's own.
    worn: u32,
    look: u32,
}

/// Row number that stands for no row.
const FROM_PALETTE: u32 = u32::MAX;

/// Position and kind of a character, for choosing how it is drawn.
#[derive(Clone, Copy)]
struct CharacterPlace {
    hips: Vec3,
    ghost: bool,
    /// Drawn with a mesh of the user's own.
    worn: bool,
}

/// Draws of one frame: for each level of detail, a range of the list of character numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LevelLists {
    pub solid: [Range<u32>; LEVELS],
    pub ghosts: [Range<u32>; LEVELS],
    /// Characters whose shadow can be in view, by the level of the shadow.
    pub shadows: [Range<u32>; LEVELS],
}

impl LevelLists {
    /// Ranges of a layer. Far away, contact is too small to be visible.
    pub fn layer_ranges(&self, layer: Layer) -> &[Range<u32>] {
        match layer {
            Layer::Solid => &self.solid,
            Layer::Ghosts => &self.ghosts,
            Layer::Sun => &self.shadows,
            Layer::Contact => &self.shadows[..CONTACT_LEVELS],
        }
    }
}

/// Draws of one frame, with the bodies that the viewer makes and with the user's own.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct DrawLists {
    pub made: LevelLists,
    pub worn: LevelLists,
}

impl DrawLists {
    /// Characters in view, by level of detail.
    pub fn per_level(&self) -> [usize; LEVELS] {
        let of = |l: &LevelLists, i: usize| l.solid[i].len() + l.ghosts[i].len();
        std::array::from_fn(|i| of(&self.made, i) + of(&self.worn, i))
    }
}

/// One body's triangles on the GPU.
pub(super) struct GpuMesh {
    vertices: GrowingBuffer,
    indices: GrowingBuffer,
    num_indices: u32,
}

impl GpuMesh {
    pub fn new(device: &Device) -> Self {
        Self {
            vertices: GrowingBuffer::new(device, "body vertices", wgpu::BufferUsages::VERTEX),
            indices: GrowingBuffer::new(device, "body triangles", wgpu::BufferUsages::INDEX),
            num_indices: 0,
        }
    }

    pub fn write<V: bytemuck::NoUninit>(&mut self, gpu: &Gpu, vertices: &[V], indices: &[u32]) -> Result<()> {
        self.vertices.write(gpu, vertices)?;
        self.indices.write(gpu, indices)?;
        self.num_indices = indices.len() as u32;
        Ok(())
    }

    /// Draws a range of instances.
    pub fn draw(&self, pass: &mut RenderPass<'_>, instances: &wgpu::Buffer, range: Range<u32>) {
        pass.set_vertex_buffer(0, self.vertices.buffer.slice(..));
        pass.set_vertex_buffer(1, instances.slice(..));
        pass.set_index_buffer(self.indices.buffer.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.num_indices, 0, range);
    }
}

/// Everything about characters that lives on the GPU.
pub(super) struct CharacterDraws {
    layout: BindGroupLayout,
    group: Option<BindGroup>,
    palette: GrowingBuffer,
    instances: GrowingBuffer,
    rows: GrowingBuffer,
    /// Content of the buffer of rows.
    uploaded_rows: Option<Arc<[Mat3x4]>>,
    lists: GrowingBuffer,
    meshes: [GpuMesh; LEVELS],
    built: Option<(BodyStyle, Skeleton)>,
    places: Vec<CharacterPlace>,
    staging: Vec<GpuInstance>,
    numbers: Vec<u32>,
    reach: f32,
    pipelines: [RenderPipeline; Layer::ALL.len()],
    worn: WornDraws,
    /// They were drawn in the last frame.
    was_worn: bool,
}

impl CharacterDraws {
    pub fn new(device: &Device, scene_layout: &BindGroupLayout) -> Self {
        use wgpu::BufferUsages as Usage;
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let layout = pipelines::buffer_layout(device, "characters", &[storage; 3]);
        let sources = [include_str!("shaders/skin.wgsl"), include_str!("shaders/body.wgsl")];
        let pipelines = layer_pipelines(device, PipelineInput::Body, sources, &[scene_layout, &layout]);
        Self {
            pipelines,
            layout,
            group: None,
            palette: GrowingBuffer::new(device, "joint matrices", Usage::STORAGE),
            instances: GrowingBuffer::new(device, "characters", Usage::STORAGE),
            rows: GrowingBuffer::new(device, "frame rows", Usage::STORAGE),
            uploaded_rows: None,
            lists: GrowingBuffer::new(device, "draws of characters", Usage::VERTEX),
            meshes: std::array::from_fn(|_| GpuMesh::new(device)),
            built: None,
            places: Vec::new(),
            staging: Vec::new(),
            numbers: Vec::new(),
            reach: 0.0,
            worn: WornDraws::new(device, scene_layout),
            was_worn: false,
        }
    }

    /// Makes the meshes of a body around a skeleton, unless they are there.
    pub fn set_body(&mut self, gpu: &Gpu, body: BodyStyle, skeleton: &Skeleton) -> Result<()> {
        if self.built.as_ref().is_some_and(|(b, s)| *b == body && s == skeleton) {
            return Ok(());
        }
        for (drawn, mesh) in self.meshes.iter_mut().zip(mesh::build(body, skeleton)) {
            drawn.write(gpu, &mesh.vertices, &mesh.indices)?;
        }
        self.reach = cull::reach(skeleton);
        self.built = Some((body, skeleton.clone()));
        Ok(())
    }

    /// Hands over poses, instances and records.
    pub fn upload(&mut self, gpu: &Gpu, frame: &SceneFrame<'_>) -> Result<()> {
        let SceneFrame { palette, instances, records, .. } = *frame;
        let (characters, got, expected) = (instances.len(), palette.len(), instances.len() * NUM_JOINTS);
        if got != expected {
            return Err(RenderError::PaletteLength { characters, expected, got });
        }
        let num_frames = frame.worn.map_or(0, |w| w.mesh.num_frames);
        if let Some(worn) = frame.worn.filter(|w| w.matrices.len() != instances.len() * num_frames) {
            let (expected, got) = (instances.len() * num_frames, worn.matrices.len());
            return Err(RenderError::PaletteLength { characters, expected, got });
        }
        let num_rows = frame.rows.map_or(0, |rows| rows.len() / NUM_JOINTS);
        let highest = records.iter().map(|r| r.instance.row_a.max(r.instance.row_b)).max();
        if let Some(row) = highest.filter(|&row| row as usize >= num_rows) {
            return Err(RenderError::Rows { row, rows: num_rows });
        }
        self.places.clear();
        self.staging.clear();
        for (i, (instance, pose)) in instances.iter().zip(palette.chunks_exact(NUM_JOINTS)).enumerate() {
            let root = instance.root;
            let (hips, ghost) = (world_position(root, pose[0].translation()), instance.colour.0[3] < 255);
            self.places.push(CharacterPlace { hips, ghost, worn: frame.worn.is_some() });
            let (worn, look) = ((i * num_frames) as u32, instance.look);
            let is_selected = u32::from(instance.is_selected);
            let posed = GpuInstance { row_a: FROM_PALETTE, is_selected, worn, look, ..Zeroable::zeroed() };
            self.staging.push(GpuInstance { root: gpu_root(root), colour: instance.colour, ..posed });
        }
        for RecordInstance { instance: i, colour, look } in records {
            let hips = Vec3::new(i.x, i.y + frame.skeleton.rest_positions()[0].y, i.z);
            self.places.push(CharacterPlace { hips, ghost: colour.0[3] < 255, worn: false });
            let root = gpu_root(Planar::new(i.x, i.z, i.heading));
            let PoseInstance { row_a, row_b, frac_blend, y, .. } = *i;
            let recorded = GpuInstance { row_a, row_b, frac_blend, y, look: *look, ..Zeroable::zeroed() };
            self.staging.push(GpuInstance { root, colour: *colour, ..recorded });
        }
        // Every character may be in two lists: its body's and its shadow's.
        self.lists.reserve(&gpu.device, 2 * self.staging.len(), size_of::<u32>())?;
        let are_new = self.instances.write(gpu, &self.staging)?;
        let mut moved = self.palette.write(gpu, palette)? | are_new;
        if let Some(rows) = frame.rows.filter(|rows| self.uploaded_rows.as_ref().is_none_or(|u| !Arc::ptr_eq(u, rows)))
        {
            moved |= self.rows.write(gpu, rows)?;
            self.uploaded_rows = Some(Arc::clone(rows));
        }
        if moved || self.group.is_none() {
            let buffers = [&self.palette, &self.instances, &self.rows].map(|b| b.buffer.as_entire_binding());
            self.group = Some(pipelines::bind_group(&gpu.device, "characters", &self.layout, &buffers));
        }
        if let Some(worn) = &frame.worn {
            // The buffer may have been replaced while nothing was worn.
            self.worn.upload(gpu, worn, &self.instances.buffer, are_new || !self.was_worn)?;
            self.reach = self.reach.max(worn.mesh.reach * cull::reach(frame.skeleton));
        }
        self.was_worn = frame.worn.is_some();
        Ok(())
    }

    /// Forgets all characters.
    pub fn clear(&mut self) {
        self.places.clear();
    }

    /// Chooses which characters are drawn, at which level of detail, and uploads the lists.
    pub fn choose(&mut self, queue: &Queue, camera: &OrbitCamera, size: [u32; 2]) -> DrawLists {
        let [width, height] = size.map(|s| s.max(1) as f32);
        let frustum = Frustum::new(camera.view_proj(width / height));
        let (eye, per_metre) = (camera.eye(), camera.pixels_per_metre(1.0, height));
        let level = |p: &CharacterPlace| {
            let pixels = 1.8 * per_metre / p.hips.distance(eye).max(1e-3);
            LEVEL_PIXELS.iter().filter(|&&least| pixels < least).count()
        };
        let mut bins: [Vec<u32>; 6 * LEVELS] = std::array::from_fn(|_| Vec::new());
        for (i, place) in self.places.iter().enumerate() {
            if !frustum.intersects_sphere(place.hips, self.reach + SHADOW_REACH) {
                continue;
            }
            let (level, first) = (level(place), if place.worn { 3 * LEVELS } else { 0 });
            if frustum.intersects_sphere(place.hips, self.reach) {
                bins[first + level + if place.ghost { LEVELS } else { 0 }].push(i as u32);
            }
            bins[first + 2 * LEVELS + SHADOW_LEVEL[level]].push(i as u32);
        }
        self.numbers.clear();
        let mut ranges = bins.iter().map(|bin| {
            let start = self.numbers.len() as u32;
            self.numbers.extend(bin);
            start..self.numbers.len() as u32
        });
        let mut by_level = || std::array::from_fn(|_| ranges.next().unwrap_or_default());
        let mut lists = || LevelLists { solid: by_level(), ghosts: by_level(), shadows: by_level() };
        let lists = DrawLists { made: lists(), worn: lists() };
        if !self.numbers.is_empty() {
            queue.write_buffer(&self.lists.buffer, 0, bytemuck::cast_slice(&self.numbers));
        }
        lists
    }

    /// Draws the bodies of a layer.
    pub fn draw(&self, pass: &mut RenderPass<'_>, lists: &DrawLists, layer: Layer) {
        if let Some(group) = &self.group {
            pass.set_pipeline(&self.pipelines[layer as usize]);
            pass.set_bind_group(1, group, &[]);
            draw_levels(pass, &self.meshes, &self.lists.buffer, lists.made.layer_ranges(layer));
        }
        self.worn.draw(pass, &self.lists.buffer, lists.worn.layer_ranges(layer), layer);
    }
}

/// Draws characters with the mesh of their level of detail.
///
/// - `numbers`: numbers of characters, of which each list is a range.
pub(super) fn draw_levels(pass: &mut RenderPass<'_>, meshes: &[GpuMesh], numbers: &wgpu::Buffer, lists: &[Range<u32>]) {
    for (mesh, list) in meshes.iter().zip(lists).filter(|(_, list)| !list.is_empty()) {
        mesh.draw(pass, numbers, list.clone());
    }
}

/// A planar root as the shader takes it.
fn gpu_root(root: Planar) -> [f32; 4] {
    let (sin, cos) = root.heading.sin_cos();
    [root.x, root.z, sin, cos]
}

/// Pipelines of all layers of bodies.
///
/// - `sources`: of the shader, to place a corner and to draw a body.
/// - `groups`: shadows need the first two.
pub(super) fn layer_pipelines(
    device: &Device,
    input: PipelineInput,
    [skin, body]: [&str; 2],
    groups: &[&BindGroupLayout],
) -> [RenderPipeline; Layer::ALL.len()] {
    let label = if input == PipelineInput::Worn { "worn bodies" } else { "bodies" };
    let common = [include_str!("shaders/scene.wgsl"), include_str!("shaders/instance.wgsl"), skin];
    let with = |last| pipelines::shader(device, label, &[&common[..], &[last]].concat());
    let (body, shadow) = (with(body), with(include_str!("shaders/shadow.wgsl")));
    Layer::ALL.map(|layer| {
        let shadow_groups = &groups[..2];
        // The faces away from the light are the lower ones, where shadows are darkest.
        let (shader, groups, hidden) =
            if layer.is_shadow() { (&shadow, shadow_groups, Face::Front) } else { (&body, groups, Face::Back) };
        // Clothes and hair are often made of single sheets.
        let hidden = Some(hidden).filter(|_| input == PipelineInput::Body);
        let (stages, output) = layer.stages_and_output();
        PipelineRecipe { label, shader, stages, groups, input, output, strip: false, hidden }.build(device)
    })
}
