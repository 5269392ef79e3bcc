//! Small scenes that need no file: their bundles are made from synthetic motion, and their world is stitched.

use std::path::Path;
use throng_lab::run::{BUILT_IN_SCENES, BuildContext, built_in_scene, ensure_scene};
use throng_motion::error::BuildError;
use throng_motion::files::write_atomically;
use throng_simulation::Scene;

/// Names and texts of files.
const FILES: [(&str, &str); 7] = [
    (
        "boxing.toml",
        concat!(
            "name = \"boxing\"\nsynth = { set = \"boxing\", minutes = 0.6 }\n[policy]\ncompare_samples = 100\n",
            include_str!("boxing.toml")
        ),
    ),
    ("units.toml", include_str!("../../../../data/units/playground.toml")),
    (
        "tiles.toml",
        r#"
name = "tiles"
behaviours = []
synth = { set = "walk", minutes = 3.0 }
[resample]
mirror = true
[graph]
enabled = false
[patches]
units = "units.toml"
[[patches.tiles]]
unit = "ground"
"#,
    ),
    (
        "floor.toml",
        r#"
bundle = "tiles.throng"
config = "tiles.toml"
[[place]]
unit = "ground"
at = [0, 0, 0]
repeat = [7, 1, 7]
step = [[2.8, 0, 0], [0, 0, 0], [0, 0, 2.8]]
"#,
    ),
    (
        "policy.toml",
        r#"
name = "policy"
bundle = "boxing.throng"
config = "boxing.toml"
[[groups]]
motion = "policy"
count = 24
place = { grid = { spacing_m = 6.0, distance_m = 1.5 } }
temperature = 0.05
behaviours = [{ name = "approach" }, { name = "throw-punches", weight = 2.0 }]
target = { height_m = 1.4, drag = [{ time_s = 0.7, x_m = 0.4 }, { time_s = 1.9, z_m = 0.3 }] }
"#,
    ),
    (
        "sparring.toml",
        r#"
name = "sparring"
bundle = "boxing.throng"
config = "boxing.toml"
[[groups]]
motion = "sparring"
count = 24
place = { grid = { spacing_m = 6.0, distance_m = 2.0 } }
temperature = 0.02
behaviours = [{ name = "approach" }, { name = "throw-punches", weight = 2.0 }, { name = "evade", weight = 3.0 }]
"#,
    ),
    (
        "inhabited.toml",
        r#"
name = "inhabited"
bundle = "tiles.throng"
config = "tiles.toml"
environment = { world = "floor.world", world_config = "floor.toml" }
[[groups]]
motion = "patches"
count = 12
goals = [{ share = 1.0, goal = { roam = { seconds = [4.0, 9.0] } } }, { share = 1.0, goal = { visit = {} } }]
"#,
    ),
];

/// Agents of each crowd.
const AGENTS: usize = 200;

/// The scenes: policy characters, every crowd of the project, an inhabited world, sparring.
///
/// - `folder`: takes the bundles and the world, which are made where they are missing.
///
/// # Errors
/// What building and stitching say, and [`BuildError::Io`] where the folder cannot be written.
pub fn scenes(folder: &Path, with: &BuildContext<'_>) -> Result<Vec<Scene>, BuildError> {
    std::fs::create_dir_all(folder).map_err(|source| BuildError::Io { path: folder.to_path_buf(), source })?;
    for (name, text) in FILES {
        write_atomically(&folder.join(name), |out| out.write_all(text.as_bytes()))?;
    }
    let mut out = Vec::new();
    for name in ["policy", "inhabited", "sparring"] {
        let scene = Scene::load(folder.join(format!("{name}.toml"))).map_err(super::fault)?;
        ensure_scene(&scene, with)?;
        out.push(scene);
    }
    for (k, name) in BUILT_IN_SCENES.into_iter().enumerate() {
        let scene = built_in_scene(name).map_err(super::fault)?.map(|s| s.resized(AGENTS));
        // In turns with the others.
        out.splice((2 * k + 1).min(out.len())..(2 * k + 1).min(out.len()), scene);
    }
    Ok(out)
}
