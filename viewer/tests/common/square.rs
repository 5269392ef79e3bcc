//! A small bundle of walking tiles, and worlds of a few panels that are stitched from it.

use std::path::{Path, PathBuf};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::pipeline;
use throng_precompute::progress::Silent;

const UNITS: &str = r#"
[[units]]
name = "ground"
symmetry = 4
floor = true
region = { min = [-1.4, 0.3, -1.4], max = [1.4, 1.5, 1.4] }
shapes = [{ box = { at = [0.0, -0.05, 0.0], size = [2.8, 0.1, 2.8] } }]
tile = { steps = [[2.8, 0.0, 0.0], [0.0, 0.0, 2.8]], widths = [2.8, 2.8] }

[[units]]
name = "post"
symmetry = 4
shapes = [
    { box = { at = [0.0, 0.1, 0.0], size = [0.4, 0.2, 0.4] } },
    { bar = { from = [0.0, 0.2, 0.0], to = [0.0, 1.1, 0.0], radius = 0.08 } },
]
"#;

const CONFIG: &str = r#"
behaviours = []

[synth]
set = "walk"
minutes = 6.0

[resample]
rate_hz = 30.0
mirror = true

[graph]
enabled = false

[patches]
units = "units.toml"

[[patches.tiles]]
unit = "ground"
"#;

/// A folder with the bundle and worlds.
pub struct Square {
    folder: tempfile::TempDir,
}

impl Square {
    /// Builds the bundle.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("units.toml"), UNITS).expect("units");
        std::fs::write(at("tiles.toml"), CONFIG).expect("a config");
        let config = BuildConfig::load(&at("tiles.toml")).expect("a sound config");
        pipeline::build(&config, &at("tiles.throng"), &Cache::disabled(), &Silent).expect("a bundle");
        Self { folder }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// A world of `side` times `side` panels, the first one at the origin, and a post beside them.
    pub fn world(&self, side: u32) -> PathBuf {
        let text = format!(
            "bundle = \"tiles.throng\"\n[stitch]\nobstacles = [\"post\"]\n\
             [[place]]\nunit = \"ground\"\nat = [0, 0, 0]\nrepeat = [{side}, 1, {side}]\n\
             step = [[2.8, 0, 0], [0, 0, 0], [0, 0, 2.8]]\n\
             [[place]]\nunit = \"post\"\nat = [-2.2, 0, 0]\nheading_deg = 20\n"
        );
        let path = self.folder.path().join("square.toml");
        std::fs::write(&path, text).expect("a world");
        path
    }

    /// A scene of so many characters in that world.
    #[allow(dead_code)] // Not every crate that has this file opens scenes.
    pub fn scene(&self, characters: usize) -> PathBuf {
        let path = self.folder.path().join("scene.toml");
        let text = format!(
            "bundle = \"tiles.throng\"\n[environment]\nworld = \"square.world\"\nworld_config = \"square.toml\"\n\
                 [[groups]]\nmotion = \"patches\"\ncount = {characters}\ngoals = [{{ goal = {{ visit = {{}} }} }}]\n"
        );
        std::fs::write(&path, text).expect("a scene");
        path
    }
}
