//! A small bundle of walks at four speeds and five turning rates as a blend space, and scenes of walkers on it.

use std::path::{Path, PathBuf};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::pipeline;
use throng_precompute::progress::Silent;

/// The set begins with the walks of one manner: twenty clips of four seconds.
const CONFIG: &str = r#"
behaviours = []

[synth]
set = "locomotion"
minutes = 1.333

[graph]
enabled = false

[blend.paces]
axes = [{ kind = "speed" }, { kind = "gyration" }]
examples = [{ clip = "walk_*" }]
phases = 32
"#;

/// A folder with the bundle and scenes.
pub struct Paces {
    folder: tempfile::TempDir,
}

impl Paces {
    /// Builds the bundle.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let (config, out) = (folder.path().join("paces.toml"), folder.path().join("paces.throng"));
        std::fs::write(&config, CONFIG).expect("a config");
        let config = BuildConfig::load(&config).expect("a sound config");
        pipeline::build(&config, &out, &Cache::disabled(), &Silent).expect("a bundle");
        Self { folder }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The bundle.
    pub fn bundle(&self) -> PathBuf {
        self.folder.path().join("paces.throng")
    }

    /// A scene of a crowd with bodies: two groups of so many that meet; those of one leave at their goal.
    pub fn crowd(&self, each: usize) -> PathBuf {
        let group = |from: f32, by: f32, end: &str| {
            format!(
                "[[groups]]\nmotion = \"blend\"\nspaces = [\"paces\"]\ncount = {each}\nplace = {{ block = {{ from = [{from:.1}, -2.5], to = [{:.1}, 2.5] }} }}\n\
                 goal = {{ shift = {{ by = [{by:.1}, 0.0] }} }}\nspeed_mps = [0.9, 1.3]\nat_end = \"{end}\"\n",
                from + 4.0
            )
        };
        let bodies = "bundle = \"paces.throng\"\nconfig = \"paces.toml\"\n";
        let path = self.folder.path().join("people.toml");
        let text = format!("{bodies}{}{}", group(-5.5, 7.0, "stay"), group(1.5, -3.0, "leave"));
        std::fs::write(&path, text).expect("a scene");
        path
    }

    /// A scene of walkers on hills of a height (m).
    pub fn scene(&self, characters: usize, hills_m: f32) -> PathBuf {
        let text = format!(
            "bundle = \"paces.throng\"\nenvironment.hills_m = {hills_m:.1}\n[[groups]]\nmotion = \"blend\"\n\
             spaces = [\"paces\"]\ncount = {characters}\nbodies = {{ kinds = 3 }}\n\
             paths = {{ speeds = [0.7, 1.5], standing = 0.0, area_m = 12.0 }}\n"
        );
        let path = self.folder.path().join("parade.toml");
        std::fs::write(&path, text).expect("a scene");
        path
    }
}
