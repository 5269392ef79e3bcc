//! The whole view: upload what there is, then draw it from a camera.

use super::characters::{CharacterInstance, Characters};
use super::mesh::{Body, LEVELS};
use super::offscreen::{Offscreen, Targets};
use super::pipelines::{self, Input, Output, Recipe};
use super::scene_uniform::SceneUniform;
use super::shape_draws::ShapeDraws;
use super::{Camera, RenderError, SceneColours, Shapes};
use throng_runtime::{Mat3x4, Skeleton};

/// Storage buffers that the vertex stage reads.
const STORAGE_BUFFERS: u32 = 2;

/// Everything to show, borrowed.
#[derive(Clone, Copy, Debug)]
pub struct SceneFrame<'a> {
    /// Proportions of all characters.
    pub skeleton: &'a Skeleton,
    /// What they look like.
    pub body: Body,
    /// Joints in model space. [Size: num_characters * num_joints]
    pub palette: &'a [Mat3x4],
    /// Where they are. [Size: num_characters]
    pub instances: &'a [CharacterInstance],
    /// What else there is.
    pub shapes: &'a Shapes,
}

/// What an upload moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UploadStats {
    /// Characters.
    pub characters: usize,
    /// Shapes.
    pub shapes: usize,
    /// [Unit: bytes]
    pub bytes: u64,
}

/// What was drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DrawStats {
    /// Triangles of everything, shadows included.
    pub triangles: u64,
    /// Characters in view by level of detail, finest first.
    pub per_level: [usize; LEVELS],
    /// Characters out of view.
    pub culled: usize,
}

/// Draws scenes into a picture of its own, which can be shown in a window or read back.
pub struct SceneRenderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    uniform: wgpu::Buffer,
    scene_group: wgpu::BindGroup,
    ground: wgpu::RenderPipeline,
    sky: wgpu::RenderPipeline,
    characters: Characters,
    shapes: ShapeDraws,
    offscreen: Offscreen,
    skeleton: Skeleton,
    num_characters: usize,
}

impl SceneRenderer {
    /// A renderer for windows whose surface has the format `target_format`.
    ///
    /// # Errors
    /// [`RenderError::NoStorageBuffers`] where the device cannot read them in vertex shaders.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        target_format: wgpu::TextureFormat,
    ) -> Result<Self, RenderError> {
        let available = device.limits().max_storage_buffers_per_shader_stage;
        if available < STORAGE_BUFFERS {
            return Err(RenderError::NoStorageBuffers { available });
        }
        let scene_layout = pipelines::buffer_layout(device, "scene", &[wgpu::BufferBindingType::Uniform]);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("scene"),
            size: size_of::<SceneUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let scene_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene"),
            layout: &scene_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let offscreen = Offscreen::new(device, target_format);
        let pieces = [include_str!("shaders/scene.wgsl"), include_str!("shaders/ground.wgsl")];
        let shader = &pipelines::shader(device, "ground", &pieces);
        let surface = |label, stages, output, strip| {
            let groups = &[&scene_layout, &offscreen.mask_layout];
            Recipe { label, shader, stages, groups, input: Input::Nothing, output, strip, one_sided: false }
                .build(device)
        };
        Ok(Self {
            ground: surface("ground", ["ground_vertex", "ground_fragment"], Output::SOLID, true),
            sky: surface("sky", ["sky_vertex", "sky_fragment"], Output::BACKDROP, false),
            characters: Characters::new(device, &scene_layout),
            shapes: ShapeDraws::new(device, queue, &scene_layout)?,
            offscreen,
            device: device.clone(),
            queue: queue.clone(),
            uniform,
            scene_group,
            skeleton: Skeleton::default(),
            num_characters: 0,
        })
    }

    /// Hands over everything to show; it stays until the next upload.
    ///
    /// # Errors
    /// [`RenderError::PaletteLength`] where the palette does not fit the instances, [`RenderError::TooMany`] where the
    /// device cannot hold all. After an error no characters are drawn until an upload succeeds.
    pub fn upload(&mut self, frame: &SceneFrame<'_>) -> Result<UploadStats, RenderError> {
        let result = self.try_upload(frame);
        if result.is_err() {
            self.characters.clear();
            self.num_characters = 0;
        }
        result
    }

    fn try_upload(&mut self, frame: &SceneFrame<'_>) -> Result<UploadStats, RenderError> {
        let (device, queue) = (&self.device, &self.queue);
        self.characters.set_body(device, queue, frame.body, frame.skeleton)?;
        let mut bytes = self.characters.upload(device, queue, frame.palette, frame.instances)?;
        bytes += self.shapes.upload(device, queue, frame.shapes)?;
        if self.skeleton != *frame.skeleton {
            self.skeleton = frame.skeleton.clone();
        }
        self.num_characters = frame.instances.len();
        Ok(UploadStats { characters: frame.instances.len(), shapes: frame.shapes.len(), bytes })
    }

    /// Draws into the picture and submits the work; the picture has the size that was asked for, within what the device
    /// can do. [Unit: pixels]
    pub fn draw(&mut self, size_px: [u32; 2], camera: &Camera, colours: &SceneColours) -> DrawStats {
        let targets = self.offscreen.resize(&self.device, size_px);
        let uniform = SceneUniform::new(camera, targets.size, colours, &self.skeleton);
        self.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let lists = self.characters.choose(&self.queue, camera, targets.size);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("scene") });
        let mut triangles = 0;
        {
            let mut pass = mask_pass(&mut encoder, targets);
            pass.set_bind_group(0, &self.scene_group, &[]);
            triangles += self.characters.draw_shadows(&mut pass, &lists);
        }
        {
            let mut pass = picture_pass(&mut encoder, targets);
            pass.set_bind_group(0, &self.scene_group, &[]);
            triangles += self.characters.draw_solid(&mut pass, &lists);
            pass.set_bind_group(1, &targets.mask_group, &[]);
            pass.set_pipeline(&self.ground);
            pass.draw(0..4, 0..1);
            pass.set_pipeline(&self.sky);
            pass.draw(0..3, 0..1);
            triangles += self.shapes.draw_solids(&mut pass);
            triangles += self.characters.draw_ghosts(&mut pass, &lists);
            triangles += self.shapes.draw_flat(&mut pass);
        }
        self.queue.submit([encoder.finish()]);
        let per_level = lists.per_level();
        DrawStats { triangles, per_level, culled: self.num_characters - per_level.iter().sum::<usize>() }
    }

    /// Shows the last picture in the viewport of a pass that has one sample and no depth.
    pub fn blit(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.offscreen.blit(pass);
    }

    /// The last picture: its size, and sRGB with alpha, four bytes a pixel, rows from the top. Waits for the device.
    ///
    /// # Errors
    /// [`RenderError::ReadBack`] where the device fails, or where nothing has been drawn.
    pub fn pixels(&self) -> Result<([u32; 2], Vec<u8>), RenderError> {
        self.offscreen.pixels(&self.device, &self.queue)
    }
}

fn mask_pass<'e>(encoder: &'e mut wgpu::CommandEncoder, targets: &Targets) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("shadow mask"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &targets.mask,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    })
}

fn picture_pass<'e>(encoder: &'e mut wgpu::CommandEncoder, targets: &Targets) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("picture"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &targets.colour,
            depth_slice: None,
            resolve_target: Some(&targets.resolved),
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Discard },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &targets.depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::offscreen::read_back;
    use crate::render::{Emphasis, Rgba};
    use glam::{Quat, Vec2, Vec3};
    use throng_runtime::{Joint, NUM_JOINTS, Planar};

    const SIZE: [u32; 2] = [400, 300];

    /// A renderer, or `None` with a printed reason.
    fn renderer() -> Option<SceneRenderer> {
        renderer_for(wgpu::TextureFormat::Bgra8Unorm)
    }

    fn renderer_for(format: wgpu::TextureFormat) -> Option<SceneRenderer> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions::default();
        let device = pollster::block_on(async {
            let adapter = instance.request_adapter(&options).await.map_err(|e| e.to_string())?;
            adapter.request_device(&wgpu::DeviceDescriptor::default()).await.map_err(|e| e.to_string())
        });
        match device {
            Ok((device, queue)) => SceneRenderer::new(&device, &queue, format).ok(),
            Err(reason) => {
                println!("skipped: no graphics adapter ({reason})");
                None
            }
        }
    }

    /// Standing at the origin, `lift` above the ground.
    fn standing(skeleton: &Skeleton, lift: f32) -> Vec<Mat3x4> {
        let place = |p: Vec3| Mat3x4::from_rotation_translation(Quat::IDENTITY, p + Vec3::Y * lift);
        skeleton.rest_positions().map(place).to_vec()
    }

    fn at_origin(colour: Rgba) -> CharacterInstance {
        CharacterInstance { root: Planar::IDENTITY, colour, emphasis: Emphasis::None }
    }

    struct Picture(Vec<u8>);

    impl Picture {
        fn take(
            renderer: &mut SceneRenderer,
            body: Body,
            palette: &[Mat3x4],
            instances: &[CharacterInstance],
            camera: &Camera,
        ) -> (Self, DrawStats) {
            let (skeleton, shapes) = (&Skeleton::default(), &Shapes::new());
            let uploaded = renderer.upload(&SceneFrame { skeleton, body, palette, instances, shapes });
            assert_eq!(uploaded.map(|u| u.characters), Ok(instances.len()));
            let stats = renderer.draw(SIZE, camera, &SceneColours::LIGHT);
            let (size, pixels) = renderer.pixels().unwrap_or_default();
            assert_eq!((size, pixels.len()), (SIZE, 400 * 300 * 4));
            (Self(pixels), stats)
        }

        fn at(&self, p: Vec2) -> [i32; 3] {
            let i = 4 * (p.y as usize * SIZE[0] as usize + p.x as usize);
            [0, 1, 2].map(|k| i32::from(self.0[i + k]))
        }

        /// Sum of the differences of the channels.
        fn differs(&self, other: &Self, p: Vec2) -> i32 {
            self.at(p).iter().zip(other.at(p)).map(|(a, b)| (a - b).abs()).sum()
        }
    }

    fn size() -> Vec2 {
        Vec2::new(SIZE[0] as f32, SIZE[1] as f32)
    }

    #[test]
    fn a_body_appears_where_its_joints_project() {
        let Some(mut renderer) = renderer() else { return };
        let skeleton = Skeleton::default();
        let (camera, palette) = (Camera::default(), standing(&skeleton, 0.0));
        let instance = [at_origin(Rgba::hex(0xd02020))];
        let (empty, nothing) = Picture::take(&mut renderer, Body::Mannequin, &[], &[], &camera);
        assert_eq!((nothing.triangles, nothing.culled), (0, 0));
        for body in [Body::Mannequin, Body::Capsules] {
            let (picture, stats) = Picture::take(&mut renderer, body, &palette, &instance, &camera);
            assert_eq!(stats.per_level, [1, 0, 0]);
            for joint in Joint::ALL {
                let p = camera.project(skeleton.rest_positions()[joint.index()], size()).unwrap_or_default();
                assert!(picture.differs(&empty, p) > 40, "{body:?} {}", joint.name());
            }
            let above = camera.project(Vec3::new(0.0, 2.1, 0.0), size()).unwrap_or_default();
            assert_eq!(picture.differs(&empty, above), 0);
        }
        let mut away = camera;
        away.target.x += 50.0;
        let (_, stats) = Picture::take(&mut renderer, Body::Mannequin, &palette, &instance, &away);
        assert_eq!((stats.per_level, stats.culled), ([0; 3], 1));
    }

    #[test]
    fn the_ground_is_darkest_at_a_planted_foot() {
        let Some(mut renderer) = renderer() else { return };
        let skeleton = Skeleton::default();
        let camera: Camera = "yaw=60,pitch=12,distance=1,target=0.1:0.05:0.05".parse().unwrap_or_default();
        let instance = [at_origin(Rgba::WHITE)];
        let (empty, _) = Picture::take(&mut renderer, Body::Mannequin, &[], &[], &camera);
        // Just outside the outer edge of the left sole, on the side of the camera.
        let beside = Vec3::new(skeleton.rest_positions()[Joint::LeftToe.index()].x + 0.056, 0.0, 0.1);
        let pixel = camera.project(beside, size()).unwrap_or_default();
        let mut darkening = |lift: f32| {
            let palette = standing(&skeleton, lift);
            let (picture, _) = Picture::take(&mut renderer, Body::Mannequin, &palette, &instance, &camera);
            picture.differs(&empty, pixel)
        };
        let (planted, lifted) = (darkening(0.0), darkening(0.2));
        assert!(planted > 60 && planted > lifted + 30, "planted {planted}, lifted {lifted}");
    }

    #[test]
    fn ghosts_let_the_ground_through() {
        let Some(mut renderer) = renderer() else { return };
        let skeleton = Skeleton::default();
        let (camera, palette) = (Camera::default(), standing(&skeleton, 0.0));
        let chest = camera.project(skeleton.rest_positions()[Joint::Chest.index()], size()).unwrap_or_default();
        let mut take =
            |colour| Picture::take(&mut renderer, Body::Mannequin, &palette, &[at_origin(colour)], &camera).0;
        let red = Rgba::hex(0xd02020);
        let (solid, ghost) = (take(red), take(red.alpha(0.3)));
        assert!(ghost.at(chest)[1] > solid.at(chest)[1] + 40);
    }

    #[test]
    fn a_window_shows_the_picture_unchanged_whether_it_encodes_or_not() {
        use wgpu::TextureFormat::{Rgba8Unorm, Rgba8UnormSrgb};
        for format in [Rgba8Unorm, Rgba8UnormSrgb] {
            let Some(mut renderer) = renderer_for(format) else { return };
            renderer.draw(SIZE, &Camera::default(), &SceneColours::DARK);
            let (device, queue) = (renderer.device.clone(), renderer.queue.clone());
            let window = device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            let view = window.create_view(&wgpu::TextureViewDescriptor::default());
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            renderer.blit(&mut encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations::default(),
                })],
                ..Default::default()
            }));
            queue.submit([encoder.finish()]);
            let shown = read_back(&device, &queue, &window).unwrap_or_default().1;
            let picture = renderer.pixels().unwrap_or_default().1;
            assert_eq!((shown.len(), picture.len()), (400 * 300 * 4, 400 * 300 * 4));
            assert!(shown.iter().zip(&picture).all(|(a, b)| a.abs_diff(*b) <= 1), "{format:?}");
        }
    }

    #[test]
    fn bad_uploads_are_refused_and_the_view_lives_on() {
        let Some(mut renderer) = renderer() else { return };
        let (skeleton, shapes) = (&Skeleton::default(), &Shapes::new());
        let (palette, instances) = (&standing(skeleton, 0.0)[1..], &[at_origin(Rgba::WHITE)]);
        let frame = SceneFrame { skeleton, body: Body::Mannequin, palette, instances, shapes };
        let expected = RenderError::PaletteLength { characters: 1, expected: NUM_JOINTS, got: NUM_JOINTS - 1 };
        assert!(renderer.pixels().is_err());
        assert_eq!(renderer.upload(&frame), Err(expected));
        let stats = renderer.draw([0, 0], &Camera::default(), &SceneColours::DARK);
        assert_eq!(stats.per_level, [0; 3]);
        assert_eq!(renderer.pixels().map(|p| p.0), Ok([1, 1]));
    }

    #[test]
    fn more_than_the_device_can_hold_is_an_error() {
        use crate::render::buffer::GrowingBuffer;
        let Some(renderer) = renderer() else { return };
        let mut buffer = GrowingBuffer::new(&renderer.device, "joint matrices", wgpu::BufferUsages::STORAGE);
        assert_eq!(buffer.reserve(&renderer.device, 1000, 48), Ok(true));
        assert_eq!(buffer.reserve(&renderer.device, 900, 48), Ok(false));
        let error = buffer.reserve(&renderer.device, usize::MAX / 64, 48).err().map(|e| e.to_string());
        assert!(error.is_some_and(|e| e.contains("joint matrices") && e.contains("fewer than")));
    }
}
