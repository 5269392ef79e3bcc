//! Ten thousand people walk past each other; a picture of them, drawn without a screen.
//!
//! ```sh
//! cargo run --release -- demo                      # in the folder above: makes demo.throng
//! cargo run --release --example crowd -- ../demo.throng --people 10000 --seconds 8 --png crowd.png
//! ```

use bevy::app::PluginsState;
use bevy::asset::AssetPlugin;
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::light::{CascadeShadowConfigBuilder, GlobalAmbientLight};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::renderer::RenderAdapterInfo;
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::time::TimeUpdateStrategy;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use throng_bevy::runtime::characters::{ActionChoice, AvoidConfig, CharactersConfig};
use throng_bevy::{Aim, Character, Crowd, CrowdMessage, Joints, ThrongPlugin};

/// Each has a square of this side to start in (m).
const SPACING_M: f32 = 2.2;
const STEP: Duration = Duration::from_nanos(16_666_667);
/// Updates until a picture that was asked for is on the disk, at most.
const MOST_UPDATES: usize = 500;

fn main() -> Result<(), String> {
    let (mut bundle, mut people, mut seconds) = (PathBuf::from("../demo.throng"), 10_000, 8.0_f32);
    let mut png = PathBuf::from("crowd.png");
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg}: a value is missing"));
        match arg.as_str() {
            "--people" => people = value()?.parse().map_err(|e| format!("--people: {e}"))?,
            "--seconds" => seconds = value()?.parse().map_err(|e| format!("--seconds: {e}"))?,
            "--png" => png = value()?.into(),
            _ => bundle = arg.into(),
        }
    }
    let mut app = app(&bundle)?;
    let target = stage(&mut app, &bundle, people)?;
    // Nothing is drawn while they walk.
    wait_until_open(&mut app)?;
    let begun = Instant::now();
    let updates = (seconds / STEP.as_secs_f32()).ceil() as usize;
    (0..updates).for_each(|_| app.update());
    println!("{people} people: an update {:.1} ms", 1e3 * begun.elapsed().as_secs_f64() / updates.max(1) as f64);
    draw(&mut app, target, &png)
}

/// Bevy without a window.
fn app(bundle: &Path) -> Result<App, String> {
    let folder = bundle.canonicalize().map_err(|e| format!("{}: {e}; make it by `throng demo`", bundle.display()))?;
    let folder = folder.parent().unwrap_or(Path::new("/")).display().to_string();
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(AssetPlugin { file_path: folder, ..default() })
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() }),
    );
    app.add_plugins(ThrongPlugin).insert_resource(TimeUpdateStrategy::ManualDuration(STEP));
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    Ok(app)
}

/// Ground, light, a camera that sleeps, and everybody.
fn stage(app: &mut App, bundle: &Path, people: usize) -> Result<Handle<Image>, String> {
    let name = bundle.file_name().and_then(|n| n.to_str()).ok_or("the bundle has no name")?.to_owned();
    let world = app.world_mut();
    let side = (people as f32).sqrt().ceil().max(1.0);
    let half = 0.5 * side * SPACING_M;
    let mut image = Image::new_target_texture(1280, 720, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = world.resource_mut::<Assets<Image>>().add(image);
    let ground = world.resource_mut::<Assets<Mesh>>().add(Plane3d::new(Vec3::Y, Vec2::splat(half + 60.0)));
    let grey = StandardMaterial { base_color: Color::srgb(0.62, 0.62, 0.6), perceptual_roughness: 1.0, ..default() };
    let grey = world.resource_mut::<Assets<StandardMaterial>>().add(grey);
    world.spawn((Mesh3d(ground), MeshMaterial3d(grey)));
    let cascades = CascadeShadowConfigBuilder { num_cascades: 2, maximum_distance: 90.0, ..default() };
    world.spawn((
        DirectionalLight { illuminance: 9000.0, shadow_maps_enabled: true, ..default() },
        cascades.build(),
        Transform::from_xyz(3.0, 6.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    world.insert_resource(GlobalAmbientLight { brightness: 900.0, ..default() });
    world.insert_resource(ClearColor(Color::srgb(0.78, 0.86, 0.93)));
    world.spawn((
        Camera3d::default(),
        // One that needs no table.
        Tonemapping::AcesFitted,
        Camera { is_active: false, ..default() },
        RenderTarget::Image(target.clone().into()),
        Transform::from_xyz(0.0, 4.5, half + 3.0).looking_at(Vec3::new(0.0, 0.0, half - 18.0), Vec3::Y),
    ));
    let bundle = world.resource::<AssetServer>().load(name);
    let (avoid, choice) = (Some(AvoidConfig::default()), ActionChoice::LookAhead { temperature: 0.5 });
    let config = CharactersConfig { avoid, choice, ..CharactersConfig::default() };
    let crowd = world.spawn(Crowd::new(bundle, people).with_config(config)).id();
    for k in 0..people {
        let (column, row) = (k as f32 % side, (k as f32 / side).floor());
        let place = |at: f32| SPACING_M * (at + 0.5) - half;
        // Lanes in turn walk left and right.
        let way = if row as usize % 2 == 0 { 1.0 } else { -1.0 };
        // Scattered, each in its square, as the golden ratio scatters.
        let scattered = |by: f32| 0.9 * ((k as f32 * by).fract() - 0.5);
        let at = Vec3::new(place(column) + scattered(0.618_034), 0.0, place(row) + scattered(0.754_877));
        let turn = way * std::f32::consts::FRAC_PI_2 + 0.6 * scattered(0.569_84);
        let start = Transform::from_translation(at).with_rotation(Quat::from_rotation_y(turn));
        world.spawn((Character { crowd }, start, Aim::approach(at + 30.0 * way * Vec3::X)));
    }
    Ok(target)
}

/// Until the bundle is loaded, or what is wrong with it.
fn wait_until_open(app: &mut App) -> Result<(), String> {
    for _ in 0..100_000 {
        app.update();
        for message in app.world().resource::<Messages<CrowdMessage>>().iter_current_update_messages() {
            match message {
                CrowdMessage::Opened { .. } => return Ok(()),
                CrowdMessage::Failed { why, .. } => return Err(why.clone()),
                CrowdMessage::Adopted { .. } => {}
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Err("the bundle does not load".into())
}

/// Wakes the camera and writes what it sees.
fn draw(app: &mut App, target: Handle<Image>, png: &Path) -> Result<(), String> {
    let mut cameras = app.world_mut().query::<&mut Camera>();
    cameras.iter_mut(app.world_mut()).for_each(|mut camera| camera.is_active = true);
    // Buffers, shaders and shadows are there after a few.
    (0..2).for_each(|_| app.update());
    let begun = Instant::now();
    (0..2).for_each(|_| app.update());
    let frame_s = begun.elapsed().as_secs_f64() / 2.0;
    let near = app.world_mut().query::<&Joints>().iter(app.world()).count();
    let adapter = app.world().resource::<RenderAdapterInfo>();
    println!("drawn, {near} of them with joints: {:.2} s a frame on {}", frame_s, adapter.name);
    _ = std::fs::remove_file(png);
    app.world_mut().spawn(Screenshot::image(target)).observe(save_to_disk(png.to_path_buf()));
    for _ in 0..MOST_UPDATES {
        app.update();
        if png.exists() {
            println!("{}", png.display());
            return Ok(());
        }
    }
    Err(format!("{} was not written", png.display()))
}
