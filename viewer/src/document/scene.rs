//! A scene file and the bundle that it is played on.

use crate::bundle::OpenBundle;
use std::path::{Path, PathBuf};
use throng_precompute::config::BuildConfig;
use throng_precompute::progress::Progress;
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
    /// Reads a scene file and opens its bundle, or builds it.
    ///
    /// # Errors
    /// A message that names the file and line or key, or why the bundle cannot be opened, and the way out.
    pub fn open(path: &Path, progress: &dyn Progress) -> Result<(Self, OpenBundle), String> {
        let scene = Scene::load(path).map_err(|e| match BuildConfig::load(path) {
            Ok(_) => format!(
                "{}: this is the config of a build, not a scene; open the bundle that `throng build` makes of it",
                path.display()
            ),
            Err(_) => e.to_string(),
        })?;
        let bundle = OpenBundle::open_or_build(path, &scene.bundle, scene.config.as_deref(), progress)?;
        Ok((Self { path: path.to_path_buf(), scene }, bundle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_precompute::progress::Silent;

    fn refused(name: &str, text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        SceneFile::open(&path, &Silent).map(|_| ()).unwrap_err()
    }

    #[test]
    fn other_files_and_missing_bundles_are_refused_with_the_way_out() {
        let goals = "[[groups]]\nmotion = \"sparring\"\ncount = 2\nbehaviours = [{ name = \"approach\" }]\n";
        let e = refused("duel.toml", &format!("bundle = \"no.throng\"\nconfig = \"boxing.toml\"\n{goals}"));
        assert!(e.contains("duel.toml") && e.contains("no.throng") && e.contains("boxing.toml"), "{e}");
        let e = refused("duel.toml", &format!("bundle = \"no.throng\"\n{goals}"));
        assert!(e.contains("no.throng is missing") && e.contains("`bundle`"), "{e}");
        let e = refused("walk.toml", "name = \"walk\"\ninputs = [\"clips\"]\n");
        assert!(e.contains("config of a build"), "{e}");
        let e = refused("wrong.toml", "colour = 3\n");
        assert!(e.contains("wrong.toml") && e.contains("colour"), "{e}");
    }
}
