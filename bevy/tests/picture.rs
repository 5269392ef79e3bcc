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
use std::time::Duration;
use throng_bevy::{Aim, Character, Crowd, CrowdLook, Entered, Joints, ThrongPlugin};
use throng_runtime::{PlainBody, Skeleton};

const SIZE: [u32; 2] = [320, 240];
const STEPS: usize = 90;

/// The picture that was taken.
#[derive(Resource, Default)]
struct Taken(Option<Image>);

fn body() -> Mesh {
    let body = PlainBody::of(&Skeleton::default());
    let floats = |all: &[throng_runtime::glam::Vec3]| all.iter().map(|p| p.to_array()).collect::<Vec<_>>();
    let joints = body.joints.iter().map(|j| [u16::from(*j), 0, 0, 0]).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, floats(&body.positions))
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, floats(&body.normals))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0_f32, 0.0, 0.0, 0.0]; body.joints.len()])
        .with_inserted_indices(Indices::U16(body.triangles.as_flattened().to_vec()))
}

/// Which pixels are people, row by row, after a second and a half of walking; and where people stand, in pixels.
fn people_seen(near_m: f32) -> (Vec<bool>, Vec<Vec2>) {
    let mut app = App::new();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/golden");
    app.add_plugins(
        DefaultPlugins
            .set(AssetPlugin { file_path: golden.into(), watch_for_changes_override: Some(false), ..default() })
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
            .disable::<bevy::log::LogPlugin>(),
    );
    app.add_plugins(ThrongPlugin).init_resource::<Taken>();
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    let step = |dt_s| TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(dt_s));
    app.insert_resource(step(1.0 / 60.0)).insert_resource(ClearColor(Color::BLACK));
    let mut image = Image::new_target_texture(SIZE[0], SIZE[1], TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    let camera = app.world_mut().spawn((
        Camera3d::default(),
        Tonemapping::None,
        Camera { is_active: false, ..default() },
        RenderTarget::Image(target.clone().into()),
        Transform::from_xyz(1.0, 2.0, 9.0).looking_at(Vec3::new(1.0, 0.9, 0.0), Vec3::Y),
    ));
    let camera = camera.id();
    let name = format!("tables_v{}.throng", throng_runtime::format::VERSION);
    let bundle = app.world().resource::<AssetServer>().load(name);
    let white = StandardMaterial { unlit: true, ..default() };
    let look = CrowdLook { near: Some(body()), far: None, materials: vec![white] };
    let crowd = app.world_mut().spawn((Crowd::new(bundle, 6).with_near_m(near_m), look)).id();
    for k in 0..6 {
        let at = Vec3::new(1.6 * (k % 3) as f32 - 0.8, 0.0, -2.0 * (k / 3) as f32);
        let start = Transform::from_translation(at).with_rotation(Quat::from_rotation_y(0.9 * k as f32));
        app.world_mut().spawn((Character { crowd }, start, Aim::approach(Vec3::new(1.0, 0.0, -1.0))));
    }
    let mut entered = app.world_mut().query::<&Entered>();
    while entered.iter(app.world()).count() < 6 {
        app.update();
    }
    (0..STEPS).for_each(|_| app.update());
    // Time stands still while it is drawn.
    app.insert_resource(step(0.0));
    app.world_mut().get_mut::<Camera>(camera).expect("it is there").is_active = true;
    (0..3).for_each(|_| app.update());
    let with_joints = app.world_mut().query::<&Joints>().iter(app.world()).count();
    assert_eq!(with_joints, if near_m > 0.0 { 6 } else { 0 });
    app.world_mut()
        .spawn(Screenshot::image(target))
        .observe(|event: On<ScreenshotCaptured>, mut taken: ResMut<Taken>| taken.0 = Some(event.image.clone()));
    while app.world().resource::<Taken>().0.is_none() {
        app.update();
    }
    let image = app.world_mut().resource_mut::<Taken>().0.take().expect("just seen");
    let bytes = image.data.expect("pixels");
    let people = bytes.as_chunks::<4>().0.iter().map(|[r, ..]| *r > 100).collect();
    let places: Vec<Vec3> = {
        let mut query = app.world_mut().query_filtered::<&Transform, With<Entered>>();
        query.iter(app.world()).map(|t| t.translation + 0.8 * Vec3::Y).collect()
    };
    let world = app.world();
    let (camera, at) = (world.get::<Camera>(camera).expect("one"), world.get::<GlobalTransform>(camera).expect("one"));
    let pixel = |place: &Vec3| camera.world_to_viewport(at, *place).expect("before the camera");
    (people, places.iter().map(pixel).collect())
}

#[test]
#[ignore = "needs a GPU, or Mesa's software adapter"]
fn bodies_from_records_look_as_skinned_ones_do() {
    let ((near, places), (far, _)) = (people_seen(50.0), people_seen(0.0));
    let [both, either] = [|a: bool, b: bool| a && b, |a: bool, b: bool| a || b]
        .map(|of: fn(bool, bool) -> bool| near.iter().zip(&far).filter(|(a, b)| of(**a, **b)).count());
    println!("{both} of {either} pixels of people are those of both");
    assert!(both > 2000 && both as f32 > 0.93 * either as f32, "{both} of {either}");
    // The trunk of everybody is where it stands.
    for at in places {
        let trunk = |dx: i32, dy: i32| {
            let (x, y) = (at.x as i32 + dx, at.y as i32 + dy);
            near[(y * SIZE[0] as i32 + x) as usize]
        };
        assert!((-4..=4).any(|dx| (-6..=6).any(|dy| trunk(dx, dy))), "nobody at {at}");
    }
}
