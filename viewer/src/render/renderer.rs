//! The whole view: upload a scene, then draw it from a camera.

use super::characters::{CharacterDraws, CharacterInstance, RecordInstance};
use super::mesh::{BodyStyle, LEVELS};
use super::offscreen::{Offscreen, RenderTargets};
use super::pipelines::{self, Layer, PipelineInput, PipelineOutput, PipelineRecipe};
use super::{OrbitCamera, RenderError, Result, Rgba, SceneColours, ShapeList, Solids, WornFrame};
use super::{device::Gpu, shape_draws::ShapeDraws, solid_draws::SolidDraws};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::sync::Arc;
use throng_core::{Mat3x4, NUM_JOINTS, Skeleton};

/// Storage buffers that the vertex stage reads.
const STORAGE_BUFFERS: u32 = 3;

/// Everything to show, borrowed.
#[derive(Clone, Copy)]
pub struct SceneFrame<'a> {
    /// Proportions of all characters.
    pub skeleton: &'a Skeleton,
    /// Appearance of the characters.
    pub body: BodyStyle,
    /// A mesh of the user's own that all instances wear; records have the appearance `body`.
    pub worn: Option<WornFrame<'a>>,
    /// Joints in model space (num_characters * num_joints).
    pub palette: &'a [Mat3x4],
    /// Positions and colours of the characters (num_characters).
    pub instances: &'a [CharacterInstance],
    /// Characters that are drawn from frame rows.
    pub records: &'a [RecordInstance],
    /// The poses of all rows, joints in model space (rows * num_joints); required with records.
    pub rows: Option<&'a Arc<[Mat3x4]>>,
    /// Further shapes.
    pub shapes: &'a ShapeList,
    /// Things that stand in the world.
    pub solids: &'a Solids,
}

/// Draws scenes into a picture of its own, which can be shown in a window or read back.
pub struct SceneRenderer {
    gpu: Gpu,
    uniform: wgpu::Buffer,
    scene_group: wgpu::BindGroup,
    ground: wgpu::RenderPipeline,
    sky: wgpu::RenderPipeline,
    characters: CharacterDraws,
    shapes: ShapeDraws,
    solids: SolidDraws,
    offscreen: Offscreen,
    skeleton: Skeleton,
}

impl SceneRenderer {
    /// A renderer for windows whose surface has the format `target_format`.
    ///
    /// # Errors
    /// [`RenderError::NoStorageBuffers`] where the device cannot read them in vertex shaders.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target_format: wgpu::TextureFormat) -> Result<Self> {
        let available = device.limits().max_storage_buffers_per_shader_stage;
        if available < STORAGE_BUFFERS {
            return Err(RenderError::NoStorageBuffers { available });
        }
        let gpu = Gpu { device: device.clone(), queue: queue.clone() };
        let scene_layout = pipelines::buffer_layout(device, "scene", &[wgpu::BufferBindingType::Uniform]);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("scene"),
            size: size_of::<SceneUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let scene_group = pipelines::bind_group(device, "scene", &scene_layout, &[uniform.as_entire_binding()]);
        let offscreen = Offscreen::new(device, target_format);
        let pieces = [include_str!("shaders/scene.wgsl"), include_str!("shaders/ground.wgsl")];
        let shader = &pipelines::shader(device, "ground", &pieces);
        let surface = |label, stages, output, strip| {
            let groups = &[&scene_layout, &offscreen.mask_layout];
            PipelineRecipe { label, shader, stages, groups, input: PipelineInput::Nothing, output, strip, hidden: None }
                .build(device)
        };
        Ok(Self {
            ground: surface("ground", ["ground_vertex", "ground_fragment"], PipelineOutput::SOLID, true),
            sky: surface("sky", ["sky_vertex", "sky_fragment"], PipelineOutput::BACKDROP, false),
            characters: CharacterDraws::new(device, &scene_layout),
            shapes: ShapeDraws::new(&gpu, &scene_layout)?,
            solids: SolidDraws::new(device, &scene_layout, &offscreen.mask_layout),
            offscreen,
            gpu,
            uniform,
            scene_group,
            skeleton: Skeleton::default(),
        })
    }

    /// Hands over everything to show; it stays until the next upload.
    ///
    /// # Errors
    /// [`RenderError::PaletteLength`] where the palette does not fit the instances, [`RenderError::Rows`] where a record
    /// names rows that there are not, [`RenderError::TooMany`] where the
    /// device cannot hold all. After an error no characters are drawn until an upload succeeds.
    pub fn upload(&mut self, frame: &SceneFrame<'_>) -> Result<()> {
        self.try_upload(frame).inspect_err(|_| self.characters.clear())
    }

    fn try_upload(&mut self, frame: &SceneFrame<'_>) -> Result<()> {
        self.characters.set_body(&self.gpu, frame.body, frame.skeleton)?;
        self.characters.upload(&self.gpu, frame)?;
        self.shapes.upload(&self.gpu, frame.shapes)?;
        self.solids.upload(&self.gpu, frame.solids)?;
        if self.skeleton != *frame.skeleton {
            self.skeleton = frame.skeleton.clone();
        }
        Ok(())
    }

    /// Draws into the picture and submits the work; the picture has the requested size, within the limits of the
    /// device (pixels).
    ///
    /// - returns the number of characters in view by level of detail, finest first.
    pub fn draw(&mut self, size_px: [u32; 2], camera: &OrbitCamera, colours: &SceneColours) -> [usize; LEVELS] {
        let targets = self.offscreen.resize(&self.gpu.device, size_px);
        let uniform = SceneUniform::new(camera, targets.size, colours, &self.skeleton);
        self.gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let lists = self.characters.choose(&self.gpu.queue, camera, targets.size);
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("scene") });
        {
            let mut pass = mask_pass(&mut encoder, targets);
            pass.set_bind_group(0, &self.scene_group, &[]);
            self.characters.draw(&mut pass, &lists, Layer::Sun);
            self.characters.draw(&mut pass, &lists, Layer::Contact);
        }
        {
            let mut pass = picture_pass(&mut encoder, targets);
            pass.set_bind_group(0, &self.scene_group, &[]);
            self.characters.draw(&mut pass, &lists, Layer::Solid);
            pass.set_bind_group(1, &targets.mask_group, &[]);
            self.solids.draw(&mut pass, false);
            pass.set_pipeline(&self.ground);
            pass.draw(0..4, 0..1);
            pass.set_pipeline(&self.sky);
            pass.draw(0..3, 0..1);
            self.solids.draw(&mut pass, true);
            self.shapes.draw_solids(&mut pass);
            self.characters.draw(&mut pass, &lists, Layer::Ghosts);
            self.shapes.draw_flat(&mut pass);
        }
        self.gpu.queue.submit([encoder.finish()]);
        lists.per_level()
    }

    /// Shows the last picture in the viewport of a pass that has one sample and no depth.
    pub fn blit(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.offscreen.blit(pass);
    }

    /// The last picture: its size, and sRGB with alpha, four bytes a pixel, rows from the top. Waits for the device.
    ///
    /// # Errors
    /// [`RenderError::ReadBack`] where the device fails, or where nothing has been drawn.
    pub fn pixels(&self) -> Result<([u32; 2], Vec<u8>)> {
        self.offscreen.pixels(&self.gpu)
    }
}

fn mask_pass<'e>(encoder: &'e mut wgpu::CommandEncoder, targets: &RenderTargets) -> wgpu::RenderPass<'e> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
    let mask = wgpu::RenderPassColorAttachment { view: &targets.mask, depth_slice: None, resolve_target: None, ops };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("shadow mask"),
        color_attachments: &[Some(mask)],
        ..Default::default()
    })
}

fn picture_pass<'e>(encoder: &'e mut wgpu::CommandEncoder, targets: &RenderTargets) -> wgpu::RenderPass<'e> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Discard };
    let (view, resolve_target) = (&targets.colour, Some(&targets.resolved));
    let colour = wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target, ops };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("picture"),
        color_attachments: &[Some(colour)],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &targets.depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

/// Towards the sun. Steep, so that shadows stay near their feet.
pub(super) const SUN: Vec3 = Vec3::new(0.34, 0.87, 0.36);

/// Distance at which the ground has faded into the horizon, at least (m).
const MIN_GROUND_RADIUS: f32 = 60.0;

/// The struct `Scene` of `shaders/scene.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SceneUniform {
    view_proj: [[f32; 4]; 4],
    /// Eye, and the radius of the ground around it.
    eye: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    /// Width and height in pixels, tangents of half the opening angles.
    viewport: [f32; 4],
    sun: [f32; 4],
    colours: [[f32; 4]; 12],
    rest: [[f32; 4]; NUM_JOINTS],
}

impl SceneUniform {
    pub fn new(camera: &OrbitCamera, size: [u32; 2], colours: &SceneColours, skeleton: &Skeleton) -> Self {
        let [width, height] = size.map(|s| s.max(1) as f32);
        let aspect = width / height;
        let tan = (0.5 * camera.fov_y).tan();
        let [right, up, back] = camera.axes();
        let eye = camera.eye();
        let radius = MIN_GROUND_RADIUS.max(3.0 * camera.distance + 12.0 * eye.y);
        let vector = |v: Vec3, w: f32| v.extend(w).to_array();
        Self {
            view_proj: camera.view_proj(aspect).to_cols_array_2d(),
            eye: vector(eye, radius),
            right: vector(right, 0.0),
            up: vector(up, 0.0),
            forward: vector(-back, 0.0),
            viewport: [width, height, tan * aspect, tan],
            sun: vector(SUN.normalize(), 0.0),
            colours: bytemuck::cast::<_, [Rgba; 12]>(*colours).map(|c| c.linear().to_array()),
            rest: skeleton.rest_positions().map(|p| vector(p, 1.0)),
        }
    }
}

#[cfg(test)]
mod tests;
