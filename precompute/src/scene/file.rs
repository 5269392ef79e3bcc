//! What the readers of all kinds of scene files share.

use crate::config::{explain, read_text};
use crate::error::BuildError;
use serde::de::DeserializeOwned;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// A key, and what is wrong with its value.
pub(super) type Fault = (String, String);

/// A kind of scene file.
pub(super) trait SceneFile: DeserializeOwned {
    /// The scene's name; the file's stem where the file names none.
    fn name_mut(&mut self) -> &mut String;

    /// Paths that the file has, which start from its folder.
    fn paths_mut(&mut self) -> Vec<&mut PathBuf>;

    /// Checks numbers.
    fn find_fault(&self) -> Result<(), Fault>;

    /// Reads a file.
    ///
    /// # Errors
    /// [`BuildError::Io`], or [`BuildError::Config`] with file, line and column, or file and key.
    fn read(path: &Path) -> Result<Self, BuildError> {
        Self::parse(&read_text(path, "scene")?, path)
    }

    /// Reads the text of a file; `path` is for its name, its folder and messages.
    ///
    /// # Errors
    /// [`BuildError::Config`] as [`SceneFile::read`].
    fn parse(text: &str, path: &Path) -> Result<Self, BuildError> {
        let help = "data/scenes/ has examples of scenes.";
        let mut scene: Self =
            toml::from_str(text).map_err(|e| BuildError::Config { message: explain(&e, text, path, help) })?;
        if scene.name_mut().is_empty() {
            *scene.name_mut() = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        scene.paths_mut().into_iter().for_each(|p| *p = folder.join(&*p));
        scene.check_file(path)?;
        Ok(scene)
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

/// A fault of a key.
pub(super) fn fault<T>(key: &str, why: impl Into<String>) -> Result<T, Fault> {
    Err((key.into(), why.into()))
}

/// Seed of a scene that names none.
pub(super) fn one() -> u64 {
    1
}

/// The number of characters of a scene. [Limit: 1 to 1000000]
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

/// True for the text of a file whose topmost table has a key.
pub(super) fn has_key(path: &Path, key: &str) -> bool {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.parse::<toml::Table>().is_ok_and(|t| t.contains_key(key))
}
