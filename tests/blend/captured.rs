//! The blend spaces of captured locomotion that come with the project, where the recordings are.

use crate::common::build;
use crate::common::mocap::recording;
use glam::Vec2;
use std::path::{Path, PathBuf};
use throng_core::blend::{BlendSpace, ExampleRecord, axis};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{Bundle, CharacterGroup, Inline};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::slip::{SlipMeter, Soles};

const DT_S: f32 = 1.0 / 60.0;

/// Builds a config that comes with the project from the recordings; without them, says so and gives nothing.
fn built(config: &str, folder_of_set: &str) -> Option<Bundle> {
    let mocap = recording("")?;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(config);
    let mut config = BuildConfig::load(&path).expect("the config that comes with the project");
    let of_file = |p: &PathBuf| mocap.join(folder_of_set).join(p.file_name().expect("a pattern"));
    config.inputs = config.inputs.iter().map(of_file).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("captured.throng");
    build(&config, &out, &Cache::disabled());
    Some(Bundle::open(&out).expect("the bundle opens"))
}

/// Stands, walks off to the fastest example ahead and stops again.
fn feet_hold(tables: &Bundle, number: usize) {
    let name = &tables.meta().blends[number].name;
    let space = BlendSpace::new(tables.blends(), number).expect("a space");
    let fastest = space.axes()[space.axis_of(axis::SPEED).expect("an axis of speed")].high;
    let (mut meter, mut control) = (SlipMeter::new(1, tables.skeleton()), Control::default());
    let mut walkers = Walkers::with_capacity(space, &[], WalkersConfig::default(), 1).expect("walkers");
    let id = walkers.spawn(WalkerStart::default()).expect("a walker");
    let (mut at_rest, mut moved) = (Soles::default(), 0.0f32);
    for step in 0..1200 {
        let t = step as f32 * DT_S;
        let speed = fastest * (0.25 * (t - 2.0)).clamp(0.0, 1.0).min((0.5 * (16.0 - t)).clamp(0.0, 1.0));
        control.velocity = Vec2::new(0.0, speed);
        walkers.order(id, control).expect("an order");
        walkers.step(DT_S, &Inline).expect("a step");
        let joints = walkers.joint_positions(0);
        assert!(joints.iter().all(|p| p.is_finite() && p.y > -0.1 && p.y < 2.5), "{name} at {t} s: {joints:?}");
        let soles = walkers.soles(0);
        meter.observe(0, DT_S, walkers.contacts(0), soles);
        if t > 18.5 {
            moved = (0..4).map(|k| soles[k / 2][k % 2].distance(at_rest[k / 2][k % 2]) / DT_S).fold(moved, f32::max);
        }
        at_rest = soles;
    }
    assert!(meter.samples() > 600, "{name}: feet are planted in {} ticks", meter.samples());
    assert!(meter.p95_mps() < 0.02, "{name}: planted feet slip by {} m/s", meter.p95_mps());
    assert!(moved < 0.1, "{name}: feet of a standing character move by {moved} m/s");
}

#[test]
fn fifteen_manners_walk_run_and_stand() {
    let Some(tables) = built("bandai-locomotion.toml", "bandai-1") else { return };
    let names: Vec<&str> = tables.meta().blends.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names.len(), 15, "{names:?}");
    for (number, name) in names.iter().enumerate() {
        let space = BlendSpace::new(tables.blends(), number).expect("a space");
        let still = space.examples().iter().filter(|e| e.flags & ExampleRecord::IS_STILL != 0).count();
        assert!(still == 1 && space.examples().len() >= 6, "{name}: {still} of {}", space.examples().len());
        let speed = space.axes()[0];
        assert!(speed.low <= 0.0 && speed.high > 1.5, "{name}: from standing, or back steps, to runs: {speed:?}");
        feet_hold(&tables, number);
    }
}

#[test]
fn walks_runs_and_turns_of_one_person_make_a_space() {
    let Some(tables) = built("snu-locomotion.toml", "snu/single") else { return };
    let space = BlendSpace::new(tables.blends(), 0).expect("a space");
    assert!(space.examples().len() >= 12, "{}", space.examples().len());
    let [speed, gyration] = [axis::SPEED, axis::GYRATION].map(|k| space.axes()[space.axis_of(k).expect("an axis")]);
    assert!(speed.low.abs() < 0.05 && speed.high > 1.4, "{speed:?}");
    assert!(gyration.low < -0.4 && gyration.high > 0.4, "turns to both sides: {gyration:?}");
    feet_hold(&tables, 0);
}
