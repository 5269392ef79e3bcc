//! Built-in scenes of agents, which need no file.

use std::path::Path;
use throng_core::Result;
use throng_simulation::Scene;

/// Names and texts.
const TEXTS: [(&str, &str); 7] = [
    ("flock", include_str!("../../../../data/scenes/flock.toml")),
    ("corridor", include_str!("../../../../data/scenes/corridor.toml")),
    ("lanes", include_str!("../../../../data/scenes/lanes.toml")),
    ("circle", include_str!("../../../../data/scenes/circle.toml")),
    ("ring", include_str!("../../../../data/scenes/ring.toml")),
    ("bottleneck", include_str!("../../../../data/scenes/bottleneck.toml")),
    ("square", include_str!("../../../../data/scenes/square.toml")),
];

/// Names of the built-in scenes.
pub const BUILT_IN_SCENES: [&str; 7] = ["flock", "corridor", "lanes", "circle", "ring", "bottleneck", "square"];

/// A built-in scene by its name; `None` for any other name.
///
/// # Errors
/// As [`Scene::parse`].
pub fn built_in_scene(name: &str) -> Result<Option<Scene>> {
    let text = TEXTS.iter().find(|t| t.0 == name);
    text.map(|(name, text)| Scene::parse(text, Path::new(&format!("{name}.toml")))).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_simulation::Simulation;

    #[test]
    fn every_own_scene_is_read_and_laid_out_and_resized() {
        for name in BUILT_IN_SCENES {
            let scene = built_in_scene(name).unwrap().expect("it is there");
            assert_eq!(scene.name, name);
            for agents in [scene.num_characters(), 100, 1000] {
                let sim = Simulation::new(&scene.resized(agents).open().unwrap()).unwrap();
                assert_eq!(sim.num_characters(), agents, "{name}");
            }
        }
        assert!(built_in_scene("moon").unwrap().is_none());
    }
}
