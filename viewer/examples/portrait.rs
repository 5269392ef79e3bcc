//! Draws characters of a bundle without a window and writes a picture (PPM).
//!
//! ```sh
//! cargo run -p throng-viewer --example portrait -- demo.throng /tmp/a.ppm camera=side,distance=3 count=9 body=capsules
//! ```
//!
//! Settings: `camera`, `count`, `steps` (of 1/60 s before the picture), `spacing` (m), `size` (`WIDTHxHEIGHT`), `body`
//! (`mannequin` or `capsules`), `theme` (`light` or `dark`), `ghosts` (how many of the first are see-through),
//! `shapes` (`yes` shows every kind).

use glam::{Quat, Vec2, Vec3};
use std::collections::HashMap;
use std::error::Error;
use std::time::Instant;
use throng_runtime::troupe::{Goal, Repertoire, Start, Troupe, TroupeConfig};
use throng_runtime::{Joint, Planar, Tables};
use throng_viewer::render::{
    Body, Camera, CharacterInstance, Emphasis, Rgba, SceneColours, SceneFrame, SceneRenderer, Shapes, device_descriptor,
};

const COLOURS: [u32; 6] = [0x4f8fc0, 0xe08a4a, 0x5aa88a, 0xb0699c, 0xc9a83f, 0x7d87a6];

struct Settings(HashMap<String, String>);

impl Settings {
    fn get(&self, key: &str, default: &str) -> String {
        self.0.get(key).cloned().unwrap_or_else(|| default.to_owned())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let usage = "usage: portrait BUNDLE PICTURE.ppm [key=value ...]";
    let (bundle, picture) = args.next().zip(args.next()).ok_or(usage)?;
    let pairs = args.filter_map(|a| a.split_once('=').map(|(k, v)| (k.to_owned(), v.to_owned())));
    let settings = Settings(pairs.collect());
    let size = settings.get("size", "1280x800");
    let (width, height) = size.split_once('x').ok_or("size must be WIDTHxHEIGHT")?;
    let size = [width.parse()?, height.parse()?];

    let tables = Tables::open(&bundle)?;
    let repertoire = Repertoire::new(&tables);
    let troupe = walk(&tables, &repertoire, &settings)?;
    let ghosts: usize = settings.get("ghosts", "0").parse()?;
    let instances: Vec<CharacterInstance> = (0..troupe.num_characters())
        .map(|i| {
            let colour = Rgba::hex(COLOURS[i % COLOURS.len()]);
            let colour = if i < ghosts { colour.alpha(0.4) } else { colour };
            let emphasis = match i {
                1 => Emphasis::Selected,
                2 => Emphasis::Highlighted,
                _ => Emphasis::None,
            };
            CharacterInstance { root: troupe.root(i), colour, emphasis }
        })
        .collect();
    let body = if settings.get("body", "mannequin") == "capsules" { Body::Capsules } else { Body::Mannequin };
    let colours = if settings.get("theme", "light") == "dark" { SceneColours::DARK } else { SceneColours::LIGHT };
    let mut camera: Camera = settings.get("camera", "three-quarter").parse()?;
    let first = instances.first().ok_or("count must be at least 1")?.root;
    camera.target += Vec3::new(first.x, 0.0, first.z);
    let shapes = if settings.get("shapes", "no") == "yes" { every_shape(&troupe) } else { Shapes::new() };

    let (device, queue) = device()?;
    let mut renderer = SceneRenderer::new(&device, &queue, wgpu::TextureFormat::Bgra8Unorm)?;
    let frame = SceneFrame {
        skeleton: repertoire.skeleton(),
        body,
        palette: troupe.model_matrices(),
        instances: &instances,
        shapes: &shapes,
    };
    for _ in 0..2 {
        let started = Instant::now();
        let uploaded = renderer.upload(&frame)?;
        let upload = started.elapsed();
        let drawn = renderer.draw(size, &camera, &colours);
        let submitted = started.elapsed();
        let (size, pixels) = renderer.pixels()?;
        println!(
            "{uploaded:?} in {upload:?}; {drawn:?} in {:?}; done after {:?}",
            submitted - upload,
            started.elapsed()
        );
        write_ppm(&picture, size, &pixels)?;
    }
    Ok(())
}

/// Characters on a square, some way into their motion.
fn walk(tables: &Tables, repertoire: &Repertoire<'_>, settings: &Settings) -> Result<Troupe, Box<dyn Error>> {
    let count: usize = settings.get("count", "1").parse()?;
    let spacing: f32 = settings.get("spacing", "1.5").parse()?;
    let num_states = tables.graph().states.len();
    let side = (count as f32).sqrt().ceil().max(1.0) as usize;
    let start = |i: usize| Start {
        root: Planar::new((i % side) as f32 * spacing, (i / side) as f32 * -spacing, 0.0),
        state: (i * 7919 % num_states) as u32,
    };
    let starts: Vec<Start> = (0..count).map(start).collect();
    let mut troupe = Troupe::new(repertoire, TroupeConfig::default(), &starts)?;
    // The first behaviour decides, towards a far target.
    let targets = vec![Vec3::new(20.0, 0.0, 30.0); count];
    let weight = |policy| if policy == 0 { 1.0 } else { 0.0 };
    let goals: Vec<Goal<'_>> = (0..repertoire.num_policies())
        .map(|policy| Goal { policy, weight: weight(policy), targets: &targets })
        .collect();
    for _ in 0..settings.get("steps", "20").parse()? {
        troupe.step(repertoire, 1.0 / 60.0, &goals)?;
    }
    Ok(troupe)
}

/// One of everything around the first character.
fn every_shape(troupe: &Troupe) -> Shapes {
    let root = troupe.root(0);
    let world = |p: Vec3| {
        let q = root.transform_point(Vec2::new(p.x, p.z));
        Vec3::new(q.x, p.y, q.y)
    };
    let joints = troupe.joint_positions(0);
    let mut shapes = Shapes::new();
    let trail: Vec<Vec3> =
        (0..60).map(|i| world(Vec3::new((i as f32 * 0.1).sin() * 0.2, 0.004, -0.05 * i as f32))).collect();
    shapes.polyline(&trail, 3.0, Rgba::hex(0xe8743b));
    shapes.ring(world(Vec3::ZERO), 0.42, 0.46, Rgba::hex(0x7a2bbf).alpha(0.8));
    shapes.disc(world(Vec3::new(1.2, 0.0, 0.6)), 0.25, Rgba::hex(0x1f9e89).alpha(0.6));
    shapes.arrow(world(Vec3::new(0.0, 0.02, 0.3)), world(Vec3::new(0.0, 0.02, 1.2)), 0.02, Rgba::hex(0x1f9e89));
    shapes.sphere(world(Vec3::new(1.2, 0.1, 0.6)), 0.1, Rgba::hex(0xd9483b));
    shapes.on_top(true);
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            shapes.capsule(joints[parent.index()], joints[joint.index()], 0.008, Rgba::hex(0xf2c94c));
        }
        shapes.axes(joints[joint.index()], Quat::from_rotation_y(root.heading), 0.06, 2.0);
    }
    shapes
}

fn device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    Ok(pollster::block_on(adapter.request_device(&device_descriptor(&adapter)))?)
}

fn write_ppm(path: &str, size: [u32; 2], rgba: &[u8]) -> std::io::Result<()> {
    let mut bytes = format!("P6 {} {} 255\n", size[0], size[1]).into_bytes();
    bytes.extend(rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]));
    std::fs::write(path, bytes)
}
