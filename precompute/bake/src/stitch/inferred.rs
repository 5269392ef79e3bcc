//! Files of inferred surroundings, including a world.

use super::{StitchConfig, WorldSource};
use crate::config::to_toml;
use crate::environment::{EnvironmentFile, InferredEnvironment};
use serde::Serialize;
use std::path::{Path, PathBuf};
use throng_motion::{error::Result, files::write_atomically};

/// Paths of files of inferred surroundings.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct SavedFiles {
    /// Environment file.
    pub environment_out: PathBuf,
    /// Unit file.
    pub units_out: PathBuf,
    /// World file, to be stitched from the patches that a build makes of these surroundings.
    pub world_out: PathBuf,
}

impl InferredEnvironment {
    /// Writes the environment and, beside it, its unit file and a world, named after it with `-units` and `-world` at
    /// the end. The world's bundle has the environment's name and is expected beside it.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Io`] names the file.
    pub fn save(&self, path: &Path) -> Result<SavedFiles> {
        let stem = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let beside = |end: &str| PathBuf::from(format!("{stem}{end}"));
        let environment = EnvironmentFile { units: beside("-units.toml"), ..self.environment.clone() };
        let world = WorldSource {
            name: self.environment.name.clone(),
            bundle: beside(".throng"),
            config: None,
            // The capture need not contain motion between all inferred units.
            stitch: StitchConfig { allow_unreachable: true, ..StitchConfig::default() },
            prefabs: self.environment.prefabs.clone(),
            place: self.environment.place.clone(),
        };
        let saved = SavedFiles {
            environment_out: path.to_path_buf(),
            units_out: path.with_file_name(&environment.units),
            world_out: path.with_file_name(beside("-world.toml")),
        };
        let head: String =
            format!("Inferred from contacts.\n{}", self.report).lines().map(|l| format!("# {l}\n")).collect();
        let texts = [
            (&saved.units_out, self.units.to_toml()?),
            (&saved.world_out, to_toml(&world)?),
            (&saved.environment_out, to_toml(&environment)?),
        ];
        for (file, text) in texts {
            write_atomically(file, |w| w.write_all(format!("{head}{text}").as_bytes()))?;
        }
        Ok(saved)
    }
}
