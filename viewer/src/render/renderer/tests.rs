use super::*;
use crate::bundle::OpenBundle;
use crate::fixtures::golden_path;
use crate::render::offscreen::{read_back, target_texture};
use crate::render::{Rgba, Solids, device_descriptor};
use glam::{Quat, Vec2, Vec3};
use throng_core::characters::{
    CharacterStart, Characters as People, CharactersConfig, FootLockConfig, PolicyOrder, PoseInstance,
};
use throng_core::{Joint, NUM_JOINTS, Planar};

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
        adapter.request_device(&device_descriptor(&adapter)).await.map_err(|e| e.to_string())
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
    CharacterInstance { root: Planar::IDENTITY, colour, is_selected: false, look: 0 }
}

struct Picture(Vec<u8>);

impl Picture {
    fn take(
        renderer: &mut SceneRenderer,
        body: BodyStyle,
        palette: &[Mat3x4],
        instances: &[CharacterInstance],
        camera: &OrbitCamera,
    ) -> (Self, [usize; LEVELS]) {
        let (skeleton, shapes) = (&Skeleton::default(), &ShapeList::default());
        let solids = &Solids::default();
        let (records, rows) = (&[], None);
        let uploaded = renderer.upload(&SceneFrame {
            skeleton,
            body,
            worn: None,
            palette,
            instances,
            records,
            rows,
            shapes,
            solids,
        });
        assert_eq!(uploaded, Ok(()));
        let per_level = renderer.draw(SIZE, camera, &SceneColours::for_theme(false));
        let (size, pixels) = renderer.pixels().unwrap_or_default();
        assert_eq!((size, pixels.len()), (SIZE, 400 * 300 * 4));
        (Self(pixels), per_level)
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
    let (camera, palette) = (OrbitCamera::default(), standing(&skeleton, 0.0));
    let instance = [at_origin(Rgba::hex(0xd02020))];
    let (empty, nothing) = Picture::take(&mut renderer, BodyStyle::Mannequin, &[], &[], &camera);
    assert_eq!(nothing, [0; LEVELS]);
    for body in [BodyStyle::Mannequin, BodyStyle::Capsules] {
        let (picture, per_level) = Picture::take(&mut renderer, body, &palette, &instance, &camera);
        assert_eq!(per_level, [1, 0, 0, 0]);
        for joint in Joint::ALL {
            let p = camera.project(skeleton.rest_positions()[joint.index()], size()).unwrap_or_default();
            assert!(picture.differs(&empty, p) > 40, "{body:?} {}", joint.name());
        }
        let above = camera.project(Vec3::new(0.0, 2.1, 0.0), size()).unwrap_or_default();
        assert_eq!(picture.differs(&empty, above), 0);
    }
    let mut away = camera;
    away.target.x += 50.0;
    let (_, per_level) = Picture::take(&mut renderer, BodyStyle::Mannequin, &palette, &instance, &away);
    assert_eq!(per_level, [0; LEVELS]);
}

#[test]
fn the_ground_is_darkest_at_a_planted_foot() {
    let Some(mut renderer) = renderer() else { return };
    let skeleton = Skeleton::default();
    let camera: OrbitCamera = "yaw=60,pitch=12,distance=1,target=0.1:0.05:0.05".parse().unwrap_or_default();
    let instance = [at_origin(Rgba::WHITE)];
    let (empty, _) = Picture::take(&mut renderer, BodyStyle::Mannequin, &[], &[], &camera);
    // Just outside the outer edge of the left sole, on the side of the camera.
    let beside = Vec3::new(skeleton.rest_positions()[Joint::LeftToe.index()].x + 0.056, 0.0, 0.1);
    let pixel = camera.project(beside, size()).unwrap_or_default();
    let mut darkening = |lift: f32| {
        let palette = standing(&skeleton, lift);
        let (picture, _) = Picture::take(&mut renderer, BodyStyle::Mannequin, &palette, &instance, &camera);
        picture.differs(&empty, pixel)
    };
    let (planted, lifted) = (darkening(0.0), darkening(0.2));
    assert!(planted > 60 && planted > lifted + 30, "planted {planted}, lifted {lifted}");
}

#[test]
fn ghosts_let_the_ground_through() {
    let Some(mut renderer) = renderer() else { return };
    let skeleton = Skeleton::default();
    let (camera, palette) = (OrbitCamera::default(), standing(&skeleton, 0.0));
    let chest = camera.project(skeleton.rest_positions()[Joint::Chest.index()], size()).unwrap_or_default();
    let mut take =
        |colour| Picture::take(&mut renderer, BodyStyle::Mannequin, &palette, &[at_origin(colour)], &camera).0;
    let red = Rgba::hex(0xd02020);
    let (solid, ghost) = (take(red), take(red.alpha(0.3)));
    assert!(ghost.at(chest)[1] > solid.at(chest)[1] + 40);
}

#[test]
fn a_window_shows_the_picture_unchanged_whether_it_encodes_or_not() {
    use wgpu::TextureFormat::{Rgba8Unorm, Rgba8UnormSrgb};
    for format in [Rgba8Unorm, Rgba8UnormSrgb] {
        let Some(mut renderer) = renderer_for(format) else { return };
        renderer.draw(SIZE, &OrbitCamera::default(), &SceneColours::for_theme(true));
        let (device, queue) = (renderer.gpu.device.clone(), renderer.gpu.queue.clone());
        let window = target_texture(&device, "window", SIZE, format, 1, wgpu::TextureUsages::COPY_SRC);
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
fn bad_uploads_are_refused_and_the_view_keeps_drawing() {
    let Some(mut renderer) = renderer() else { return };
    let (skeleton, shapes) = (&Skeleton::default(), &ShapeList::default());
    let (palette, instances) = (&standing(skeleton, 0.0)[1..], &[at_origin(Rgba::WHITE)]);
    let solids = &Solids::default();
    let (body, records, rows) = (BodyStyle::Mannequin, &[] as &[RecordInstance], None);
    let frame = SceneFrame { skeleton, body, worn: None, palette, instances, records, rows, shapes, solids };
    let expected = RenderError::PaletteLength { characters: 1, expected: NUM_JOINTS, got: NUM_JOINTS - 1 };
    assert!(renderer.pixels().is_err());
    assert_eq!(renderer.upload(&frame), Err(expected));
    let per_level = renderer.draw([0, 0], &OrbitCamera::default(), &SceneColours::for_theme(true));
    assert_eq!(per_level, [0; LEVELS]);
    assert_eq!(renderer.pixels().map(|p| p.0), Ok([1, 1]));
}

#[test]
fn more_than_the_device_can_hold_is_an_error() {
    use crate::render::device::GrowingBuffer;
    let Some(renderer) = renderer() else { return };
    let mut buffer = GrowingBuffer::new(&renderer.gpu.device, "joint matrices", wgpu::BufferUsages::STORAGE);
    assert_eq!(buffer.reserve(&renderer.gpu.device, 1000, 48), Ok(true));
    assert_eq!(buffer.reserve(&renderer.gpu.device, 900, 48), Ok(false));
    let error = buffer.reserve(&renderer.gpu.device, usize::MAX / 64, 48).err().map(|e| e.to_string());
    assert!(error.is_some_and(|e| e.contains("joint matrices") && e.contains("fewer than")));
}

#[test]
fn records_look_as_posed_characters_do() {
    let Some(mut renderer) = renderer() else { return };
    let bundle = OpenBundle::open(&golden_path()).expect("the golden bundle");
    let (motion_set, skeleton) = (&bundle.motion_set, bundle.tables().skeleton());
    let n = 40;
    let place = |i: usize| Planar::new((i % 8) as f32 - 3.5, 1.5 * (i / 8) as f32 - 3.0, 0.7 * i as f32);
    let starts: Vec<CharacterStart> = (0..n).map(|i| CharacterStart { root: place(i), state: 0 }).collect();
    let free = FootLockConfig { enabled: false, ..FootLockConfig::default() };
    // How many are in a transition at a time, and so how much differs, is in proportion to this.
    let half_life_s = 0.1;
    let config = CharactersConfig { instances: true, foot_lock: free, half_life_s, ..CharactersConfig::default() };
    let mut people = People::new(motion_set, config, &starts).expect("starts exist");
    let orders: Vec<PolicyOrder> = (0..n).map(|i| PolicyOrder::towards(0, place(i * 7 % n).translation())).collect();
    let camera = OrbitCamera { distance: 12.0, pitch: 0.4, ..OrbitCamera::default() };
    let (shapes, solids, body) = (&ShapeList::default(), &Solids::default(), BodyStyle::Mannequin);
    let colour = Rgba::hex(0xd0a020);
    // Shares of the pixels of bodies that differ: of those whom no transition fades in, and of all.
    let mut worst = [0.0f32; 2];
    for _ in 0..6 {
        // Half a second each, at no whole number of frames.
        (0..17).for_each(|_| people.step(motion_set, 1.0 / 34.0, &orders).expect("a step"));
        let mut take = |palette: &[Mat3x4], instances: &[CharacterInstance], records: &[RecordInstance]| {
            let rows = Some(bundle.row_poses());
            let frame = SceneFrame { skeleton, body, worn: None, palette, instances, records, rows, shapes, solids };
            renderer.upload(&frame).expect("uploaded");
            let per_level = renderer.draw(SIZE, &camera, &SceneColours::for_theme(false));
            assert_eq!(per_level.iter().sum::<usize>(), instances.len() + records.len());
            renderer.pixels().expect("a picture").1
        };
        let nobody = take(&[], &[], &[]);
        for (worst, most_blend) in worst.iter_mut().zip([0, u16::MAX]) {
            let shown = |&c: &usize| people.instances()[c].frac_blend[1] <= most_blend;
            let shown: Vec<usize> = (0..n).filter(shown).collect();
            let of = |&c: &usize| CharacterInstance { root: people.root(c), colour, is_selected: false, look: 0 };
            let palette: Vec<Mat3x4> = shown.iter().flat_map(|&c| people.pose(c)).copied().collect();
            let posed = take(&palette, &shown.iter().map(of).collect::<Vec<_>>(), &[]);
            let record = |&c: &usize| RecordInstance { instance: people.instances()[c], colour, look: 0 };
            let recorded = take(&[], &[], &shown.iter().map(record).collect::<Vec<_>>());
            let differing = |a: &[u8], b: &[u8]| {
                let differs = |(a, b): (&[u8], &[u8])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max() > Some(32);
                a.chunks_exact(4).zip(b.chunks_exact(4)).filter(|&pair| differs(pair)).count() as f32
            };
            *worst = worst.max(differing(&posed, &recorded) / differing(&posed, &nobody).max(1.0));
        }
    }
    // Motion is straight between rows; transitions fade where they would be inertial.
    assert!(worst[0] < 0.01 && worst[1] < 0.12, "{worst:?} of the pixels of bodies differ");
}

#[test]
fn rows_that_there_are_not_are_refused() {
    let Some(mut renderer) = renderer() else { return };
    let (skeleton, shapes, solids) = (&Skeleton::default(), &ShapeList::default(), &Solids::default());
    let rows: Arc<[Mat3x4]> = vec![Mat3x4::default(); 3 * NUM_JOINTS].into();
    let record = |row_b| RecordInstance {
        instance: PoseInstance { row_b, ..PoseInstance::default() },
        colour: Rgba::WHITE,
        look: 0,
    };
    let mut upload = |records: &[RecordInstance], rows| {
        let (body, palette, instances) = (BodyStyle::Capsules, &[] as &[Mat3x4], &[] as &[CharacterInstance]);
        renderer
            .upload(&SceneFrame { skeleton, body, worn: None, palette, instances, records, rows, shapes, solids })
            .err()
    };
    assert_eq!(upload(&[record(2)], Some(&rows)), None);
    assert_eq!(upload(&[record(3)], Some(&rows)), Some(RenderError::Rows { row: 3, rows: 3 }));
    assert_eq!(upload(&[record(0)], None), Some(RenderError::Rows { row: 0, rows: 0 }));
}
