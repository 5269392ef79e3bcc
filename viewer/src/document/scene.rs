//! A scene file and the bundle that it is played on.

use super::Bundle;
use std::path::{Path, PathBuf};
use throng_precompute::config::BuildConfig;
use throng_precompute::scene::Scene;

/// A scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// The file.
    pub path: PathBuf,
    /// What it says.
    pub scene: Scene,
}

impl SceneFile {
    /// Reads a scene file and opens its bundle.
    ///
    /// # Errors
    /// A message that names the file and line or key, or the bundle that is not there, and the way out.
    pub fn open(path: &Path) -> Result<(Self, Bundle), String> {
        let scene = Scene::load(path).map_err(|e| match BuildConfig::load(path) {
            Ok(_) => format!(
                "{}: this is the config of a build, not a scene; open the bundle that `throng build` makes of it",
                path.display()
            ),
            Err(_) => e.to_string(),
        })?;
        if !scene.bundle.exists() {
            return Err(missing(path, &scene));
        }
        let bundle = Bundle::open(&scene.bundle).map_err(|e| format!("{}: its bundle: {e}", path.display()))?;
        Ok((Self { path: path.to_path_buf(), scene }, bundle))
    }
}

fn missing(path: &Path, scene: &Scene) -> String {
    let (file, bundle) = (path.display(), scene.bundle.display());
    match &scene.config {
        Some(config) => {
            let config = config.display();
            format!("{file}: its bundle {bundle} is not there; `throng build {config} --out {bundle}` makes it")
        }
        None => format!("{file}: its bundle {bundle} is not there; build it, or correct the key `bundle`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(name: &str, text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        SceneFile::open(&path).map(|_| ()).unwrap_err()
    }

    #[test]
    fn what_is_no_scene_or_has_no_bundle_is_refused_with_the_way_out() {
        let goals = "kind = \"pairs\"\ncharacters = 2\n[[goals]]\nbehaviour = \"approach\"\n";
        let e = refused("duel.toml", &format!("bundle = \"no.throng\"\nconfig = \"boxing.toml\"\n{goals}"));
        assert!(e.contains("duel.toml") && e.contains("throng build") && e.contains("boxing.toml"), "{e}");
        let e = refused("duel.toml", &format!("bundle = \"no.throng\"\n{goals}"));
        assert!(e.contains("no.throng is not there") && e.contains("`bundle`"), "{e}");
        let e = refused("walk.toml", "name = \"walk\"\ninputs = [\"clips\"]\n");
        assert!(e.contains("config of a build"), "{e}");
        let e = refused("wrong.toml", "colour = 3\n");
        assert!(e.contains("wrong.toml") && e.contains("colour"), "{e}");
    }
}
