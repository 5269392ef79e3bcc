//! Scenes of the project say what must be true of them, and it is.

use std::path::PathBuf;
use throng_precompute::run::{SceneRunConfig, check_expectations};
use throng_simulation::{GroupMotion, Scene};

/// Scenes that run quickly without bodies; `scripts/nightly.sh` runs all, with bodies and several seeds.
const QUICK: [&str; 5] = ["square", "museum", "park", "race", "ring"];

fn scene_files() -> Vec<PathBuf> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path()).collect();
    files.sort();
    files
}

/// The scene without bodies, which need a bundle.
fn without_bodies(mut scene: Scene) -> Scene {
    for group in scene.groups.iter_mut().filter(|g| g.motion == GroupMotion::Blend && g.paths.is_none()) {
        (group.motion, group.bundle, group.config) = (GroupMotion::None, None, None);
        group.spaces.clear();
        group.style_by_speed.clear();
    }
    scene
}

#[test]
fn every_scene_says_what_must_be_true() {
    for file in scene_files() {
        let scene = Scene::load(&file).unwrap();
        assert!(scene.expect.len() >= 2, "{}", file.display());
        let scene = without_bodies(scene);
        if scene.groups.iter().all(|g| g.motion == GroupMotion::None) {
            scene.open().unwrap_or_else(|e| panic!("{e}"));
        }
    }
}

#[test]
fn scenes_do_what_they_say() {
    let all = scene_files().into_iter().filter(|f| QUICK.contains(&f.file_stem().unwrap().to_str().unwrap()));
    for file in all {
        let scene = without_bodies(Scene::load(&file).unwrap());
        let config = SceneRunConfig { step_hz: 30.0, ..SceneRunConfig::default() };
        let broken: Vec<_> = check_expectations(&scene, 1, &config).unwrap().into_iter().filter(|e| !e.holds).collect();
        assert!(broken.is_empty(), "{}: {broken:#?}", scene.name);
    }
}
