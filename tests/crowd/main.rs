//! Scenes of crowds: starts that cannot be are refused by name, ways keep clear of walls, runs repeat, news spread.

mod runs;
mod starts;

use std::path::Path;
use throng_precompute::scene::crowd::{CrowdScene, own_scene};

/// A scene from its text.
fn scene(text: &str) -> CrowdScene {
    CrowdScene::from_text(text, Path::new("made-up.toml")).expect("a scene")
}

/// One of the project's own scenes with so many members.
fn own(name: &str, members: usize) -> CrowdScene {
    own_scene(name).expect("it can be read").expect("it is there").resized(members)
}
