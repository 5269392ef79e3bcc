//! Bodies from records look as skinned ones do. Needs an adapter, Mesa's software adapter is one: `cargo test -- --ignored`.

use bevy::app::PluginsState;
use bevy::asset::{AssetPlugin, RenderAssetUsages};
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{PrimitiveTopology, TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::time::TimeUpdateStrategy;
use std::path::{Path, PathBuf};
use std::time::Duration;
use throng_bevy::{Aim, Character, Crowd, CrowdAppearance, CrowdMessage, Entered, Joints, ThrongPlugin};
use throng_core::characters::made_up;
use throng_runtime::{PlainBody, Skeleton};

const SIZE: [u32; 2] = [320, 240];

/// The picture that was taken.
#[derive(Resource, Default)]
struct Taken(Option<Image>);

fn body() -> Mesh {
    let body = PlainBody::fine(&Skeleton::default());
    let floats = |all: &[throng_runtime::glam::Vec3]| all.iter().map(|p| p.to_array()).collect::<Vec<_>>();
    let joints = body.joints.iter().map(|j| [u16::from(*j), 0, 0, 0]).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, floats(&body.positions))
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, floats(&body.normals))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0_f32, 0.0, 0.0, 0.0]; body.joints.len()])
        .with_inserted_indices(Indices::U16(body.triangles.as_flattened().to_vec()))
}

/// Six people, a camera that sleeps, and what it draws to.
struct Stage {
    app: App,
    camera: Entity,
    target: Handle<Image>,
}

fn step(dt_s: f32) -> TimeUpdateStrategy {
    TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(dt_s))
}

impl Stage {
    /// People of a bundle who have walked for a second and a half.
    fn new(folder: &Path, name: &str, near_m: f32) -> Self {
        let mut app = App::new();
        let file_path = folder.display().to_string();
        app.add_plugins(
            DefaultPlugins
                .set(AssetPlugin { file_path, watch_for_changes_override: Some(false), ..default() })
                .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
                .disable::<bevy::log::LogPlugin>(),
        );
        app.add_plugins(ThrongPlugin).init_resource::<Taken>();
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        app.insert_resource(ClearColor(Color::BLACK));
        let mut image = Image::new_target_texture(SIZE[0], SIZE[1], TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        let camera = (
            Camera3d::default(),
            Tonemapping::None,
            Camera { is_active: false, ..default() },
            RenderTarget::Image(target.clone().into()),
            Transform::from_xyz(1.0, 2.0, 9.0).looking_at(Vec3::new(1.0, 0.9, 0.0), Vec3::Y),
        );
        let camera = app.world_mut().spawn(camera).id();
        let bundle = app.world().resource::<AssetServer>().load(name.to_owned());
        let white = StandardMaterial { unlit: true, ..default() };
        let look = CrowdAppearance { near: Some(body()), far: None, materials: vec![white] };
        let crowd = app.world_mut().spawn((Crowd::new(bundle, 6).with_near_m(near_m), look)).id();
        for k in 0..6 {
            let at = Vec3::new(1.6 * (k % 3) as f32 - 0.8, 0.0, -2.0 * (k / 3) as f32);
            let start = Transform::from_translation(at).with_rotation(Quat::from_rotation_y(0.9 * k as f32));
            app.world_mut().spawn((Character { crowd }, start, Aim::approach(Vec3::new(1.0, 0.0, -1.0))));
        }
        app.insert_resource(step(0.0));
        let mut entered = app.world_mut().query::<&Entered>();
        while entered.iter(app.world()).count() < 6 {
            app.update();
        }
        let mut stage = Self { app, camera, target };
        stage.walk(90);
        stage
    }

    /// Moves people on; then time stands still.
    fn walk(&mut self, steps: usize) {
        self.app.insert_resource(step(1.0 / 60.0));
        (0..steps).for_each(|_| self.app.update());
        self.app.insert_resource(step(0.0));
    }

    /// Which pixels are people, row by row. Everybody's trunk is where it stands.
    fn picture(&mut self) -> Vec<bool> {
        let app = &mut self.app;
        app.world_mut().get_mut::<Camera>(self.camera).expect("it is there").is_active = true;
        (0..3).for_each(|_| app.update());
        app.world_mut()
            .spawn(Screenshot::image(self.target.clone()))
            .observe(|event: On<ScreenshotCaptured>, mut taken: ResMut<Taken>| taken.0 = Some(event.image.clone()));
        while app.world().resource::<Taken>().0.is_none() {
            app.update();
        }
        let image = app.world_mut().resource_mut::<Taken>().0.take().expect("just seen");
        let bytes = image.data.expect("pixels");
        let people: Vec<bool> = bytes.as_chunks::<4>().0.iter().map(|[r, ..]| *r > 100).collect();
        let mut places = app.world_mut().query_filtered::<&Transform, With<Entered>>();
        let world = app.world();
        let camera = world.get::<Camera>(self.camera).expect("one");
        let eye = world.get::<GlobalTransform>(self.camera).expect("one");
        for place in places.iter(world) {
            let at = camera.world_to_viewport(eye, place.translation + 0.8 * Vec3::Y).expect("before the camera");
            let is_seen = |dx: i32, dy: i32| {
                let (x, y) = (at.x as i32 + dx, at.y as i32 + dy);
                people[(y * SIZE[0] as i32 + x) as usize]
            };
            assert!((-4..=4).any(|dx| (-6..=6).any(|dy| is_seen(dx, dy))), "nobody at {at}");
        }
        people
    }

    fn with_joints(&mut self) -> usize {
        self.app.world_mut().query::<&Joints>().iter(self.app.world()).count()
    }
}

/// Pixels that are people in both pictures, and in any of them.
fn shared(a: &[bool], b: &[bool]) -> [usize; 2] {
    let count = |of: fn(bool, bool) -> bool| a.iter().zip(b).filter(|(a, b)| of(**a, **b)).count();
    [count(|a, b| a && b), count(|a, b| a || b)]
}

fn golden() -> (PathBuf, String) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/golden");
    (folder, format!("tables_v{}.throng", throng_runtime::format::VERSION))
}

#[test]
#[ignore = "needs a GPU, or Mesa's software adapter"]
fn bodies_from_records_look_as_skinned_ones_do() {
    let (folder, name) = golden();
    let (mut near, mut far) = (Stage::new(&folder, &name, 50.0), Stage::new(&folder, &name, 0.0));
    assert_eq!([near.with_joints(), far.with_joints()], [6, 0]);
    let [both, either] = shared(&near.picture(), &far.picture());
    println!("{both} of {either} pixels of people are those of both");
    assert!(both > 2000 && both as f32 > 0.93 * either as f32, "{both} of {either}");
}

#[test]
#[ignore = "needs a GPU, or Mesa's software adapter"]
fn records_of_an_adopted_bundle_are_drawn_from_its_rows() {
    let (folder, name) = golden();
    let own = tempfile::tempdir().expect("a folder");
    let file = own.path().join("people.throng");
    std::fs::write(&file, made_up::bytes(&[], false)).expect("written");
    let mut stage = Stage::new(own.path(), "people.throng", 0.0);
    stage.picture();
    std::fs::copy(folder.join(name), &file).expect("copied");
    stage.app.world().resource::<AssetServer>().reload("people.throng");
    let adopted = |m: &CrowdMessage| matches!(m, CrowdMessage::Adopted { .. });
    while !stage.app.world().resource::<Messages<CrowdMessage>>().iter_current_update_messages().any(adopted) {
        stage.app.update();
    }
    // Transitions have faded.
    stage.walk(90);
    let far = stage.picture();
    // The same people at the same moment, with joints.
    let mut crowds = stage.app.world_mut().query::<&mut Crowd>();
    crowds.single_mut(stage.app.world_mut()).expect("one").near_m = 50.0;
    stage.app.update();
    assert_eq!(stage.with_joints(), 6);
    let [both, either] = shared(&stage.picture(), &far);
    println!("{both} of {either} pixels of people are those of both");
    assert!(both > 2000 && both as f32 > 0.9 * either as f32, "{both} of {either}");
}
