//! What the readers of all kinds of scene files share.

use serde::de::DeserializeOwned;
use std::fmt::Display;
use std::path::Path;
use throng_motion::error::BuildError;

/// A key, and what is wrong with its value.
pub(super) type Fault = (String, String);

/// A kind of scene that a document of the viewer shows.
pub(super) trait SceneFile: Sized {
    /// What it shows of a scene file; `None` where nobody of its kind is there.
    fn of(scene: &throng_runtime::simulation::Scene) -> Option<Self>;

    /// Checks numbers.
    fn find_fault(&self) -> Result<(), Fault>;

    /// Reads a file.
    ///
    /// # Errors
    /// [`BuildError::Config`] with file, line and column.
    fn read(path: &Path) -> Result<Self, BuildError> {
        let scene = throng_runtime::simulation::Scene::load(path);
        Self::taken(&scene.map_err(|e| BuildError::Config { message: e.to_string() })?, path)
    }

    /// Reads the text of a file; `path` is for its name, its folder and messages.
    ///
    /// # Errors
    /// [`BuildError::Config`] as [`SceneFile::read`].
    fn parse(text: &str, path: &Path) -> Result<Self, BuildError> {
        let scene = throng_runtime::simulation::Scene::parse(text, path);
        Self::taken(&scene.map_err(|e| BuildError::Config { message: e.to_string() })?, path)
    }

    /// What it shows of a scene.
    fn taken(scene: &throng_runtime::simulation::Scene, path: &Path) -> Result<Self, BuildError> {
        Self::of(scene)
            .ok_or_else(|| BuildError::Config { message: format!("{}: nobody of this kind is there", path.display()) })
    }

    /// True for a file that it shows something of.
    fn is_one_of(path: &Path) -> bool {
        throng_runtime::simulation::Scene::load(path).is_ok_and(|s| Self::of(&s).is_some())
    }

    /// Checks numbers; `path` is for messages alone.
    ///
    /// # Errors
    /// [`BuildError::Config`] with file and key.
    fn check_file(&self, path: &Path) -> Result<(), BuildError> {
        self.find_fault()
            .map_err(|(key, why)| BuildError::Config { message: format!("{}: key `{key}`: {why}", path.display()) })
    }
}

/// The same in a type of the same keys.
pub(super) fn same<A: serde::Serialize, B: DeserializeOwned>(of: &A) -> Option<B> {
    toml::Value::try_from(of).ok()?.try_into().ok()
}

/// A fault of a key.
pub(super) fn fault<T>(key: &str, why: impl Into<String>) -> Result<T, Fault> {
    Err((key.into(), why.into()))
}

/// Seed of a scene that names none.
pub(super) fn one() -> u64 {
    1
}

/// The number of characters of a scene (1 to 1000000).
pub(super) fn check_count(key: &str, count: usize) -> Result<(), Fault> {
    match count {
        1..=1_000_000 => Ok(()),
        _ => fault(key, format!("expected 1 to 1000000, found {count}")),
    }
}

/// Numbers between bounds, as (key, value, lowest, highest); NaN is never between them.
pub(super) fn check_numbers<N: PartialOrd + Display>(numbers: &[(&str, N, N, N)]) -> Result<(), Fault> {
    match numbers.iter().find(|(_, value, low, high)| !(low <= value && value <= high)) {
        Some((key, value, low, high)) => fault(key, format!("expected {low} to {high}, found {value}")),
        None => Ok(()),
    }
}
