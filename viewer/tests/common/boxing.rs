//! A small bundle of shadow-boxing, with effective hits and policies of every kind of grid, and scenes on it.

use std::path::PathBuf;
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::pipeline;
use throng_precompute::progress::Silent;

const CONFIG: &str = r#"
[synth]
set = "boxing"
minutes = 2.0

[resample]
rate_hz = 30.0
mirror = true

[[behaviours]]
name = "approach"
centre = "hits"
grid = { rings = 5, angles = 13, radius = 2.0, inner_spacing = 0.5 }

[[behaviours]]
name = "throw-punches"
kind = "throw_punches"
grid = { rings = 6, angles = 8, heights = 3 }

[[behaviours]]
name = "evade"
kind = "evade"
grid = { rings = 4, angles = 8, times = 4 }
"#;

/// A folder with the bundle and scenes.
pub struct Boxing {
    folder: tempfile::TempDir,
}

impl Boxing {
    /// Builds the bundle.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let (config, out) = (folder.path().join("boxing.toml"), folder.path().join("boxing.throng"));
        std::fs::write(&config, CONFIG).expect("a config");
        let config = BuildConfig::load(&config).expect("a sound config");
        pipeline::build(&config, &out, &Cache::disabled(), &Silent).expect("a bundle");
        Self { folder }
    }

    /// The bundle.
    pub fn bundle(&self) -> PathBuf {
        self.folder.path().join("boxing.throng")
    }

    /// A scene of pairs.
    pub fn pairs(&self, characters: usize) -> PathBuf {
        self.scene("pairs", "sparring", characters, "[[groups.behaviours]]\nname = \"evade\"\n")
    }

    /// A scene of characters with targets that stay in place.
    pub fn targets(&self, characters: usize) -> PathBuf {
        self.scene("targets", "policy", characters, "[groups.target]\nheight_m = 1.5\n")
    }

    /// A scene of people on the way to a goal behind a wall.
    pub fn travellers(&self, characters: usize) -> PathBuf {
        let text = format!(
            "bundle = \"boxing.throng\"\n[[groups]]\nmotion = \"policy\"\ncount = {characters}\n\
             place = {{ block = {{ from = [0.0, 0.0], to = [6.0, 6.0] }} }}\n\
             goal = {{ point = {{ at = [3.0, 12.0] }} }}\nbehaviours = [{{ name = \"approach\" }}]\n\
             [[environment.obstacles]]\nwall = {{ points = [[0.0, 8.0], [6.0, 8.0]] }}\n"
        );
        let path = self.folder.path().join("travellers.toml");
        std::fs::write(&path, text).expect("a scene");
        path
    }

    fn scene(&self, name: &str, motion: &str, characters: usize, more: &str) -> PathBuf {
        let text = format!(
            "bundle = \"boxing.throng\"\n[[groups]]\nmotion = \"{motion}\"\ncount = {characters}\n\
             place = {{ grid = {{ distance_m = 1.2 }} }}\n[[groups.behaviours]]\nname = \"approach\"\n\
             [[groups.behaviours]]\nname = \"throw-punches\"\nweight = 2.0\n{more}"
        );
        let path = self.folder.path().join(format!("{name}.toml"));
        std::fs::write(&path, text).expect("a scene");
        path
    }
}
