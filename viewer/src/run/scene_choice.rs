//! Settings of a scene that the viewer can change.

use serde::{Deserialize, Serialize};
use throng_crowd::Scheme;
use throng_simulation::Scene;
use throng_simulation::scene::engine;

/// Settings of a scene that the viewer can change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct SceneChoice {
    /// Number of characters and agents of all groups.
    pub characters: usize,
    /// Seed of places, paths and choices.
    pub seed: u64,
    /// Engine that finds the events of agents.
    #[serde(with = "engine")]
    pub engine: Scheme,
}

impl Default for SceneChoice {
    /// The crowd of a bundle.
    fn default() -> Self {
        Self { characters: 100, seed: 1, engine: Scheme::default() }
    }
}

impl SceneChoice {
    /// Settings in the file of a scene.
    pub fn from_scene(scene: &Scene) -> Self {
        Self { characters: scene.num_characters(), seed: scene.seed, engine: scene.agents.engine }
    }
}
