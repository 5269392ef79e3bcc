//! Scenes of crowds: starts that cannot be are refused by name, ways keep clear of walls, runs repeat, news spread.

mod runs;
mod starts;
mod travel;

use std::path::Path;
use throng_precompute::run::built_in_scene;
use throng_simulation::{CompiledScene, Scene};

/// A scene from its text.
fn scene(text: &str) -> CompiledScene {
    let scene = Scene::parse(text, Path::new("made-up.toml")).unwrap_or_else(|e| panic!("{e}"));
    scene.open().expect("it names no files")
}

/// One of the project's own scenes with so many agents.
fn own(name: &str, agents: usize) -> Scene {
    built_in_scene(name).expect("it can be read").expect("it is there").resized(agents)
}
