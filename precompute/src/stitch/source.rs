//! World files (TOML): a bundle, settings, and the environment that is stitched from its patches.

use super::{Editor, Library, StitchConfig, StitchReport};
use crate::config::{explain, read_text};
use crate::environment::{Environment, EnvironmentFile, Place, UnitGeometry, UnitSet, geometries};
use crate::error::BuildError;
use crate::files::write_atomically;
use crate::progress::Progress;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use throng_runtime::Tables;
use throng_runtime::world::WorldData;

/// A world that is to be stitched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorldSource {
    /// Its name; the file's stem where absent.
    #[serde(default)]
    pub name: String,
    /// Bundle whose patches it is made of, relative to this file's folder.
    pub bundle: PathBuf,
    /// Config that the bundle is built from where it is not there, relative to this file's folder.
    #[serde(default)]
    pub config: Option<PathBuf>,
    /// How patches are joined.
    #[serde(default)]
    pub stitch: StitchConfig,
    /// Groups of the bundle's units that are placed together, by name; they may hold other groups.
    #[serde(default)]
    pub prefabs: BTreeMap<String, Vec<Place>>,
    /// What stands where.
    pub place: Vec<Place>,
}

impl WorldSource {
    /// Reads a world file; paths in it are taken from its folder.
    ///
    /// # Errors
    /// [`BuildError::Io`], or [`BuildError::Config`] with file, line and column.
    pub fn load(path: &Path) -> Result<Self, BuildError> {
        let text = read_text(path, "world")?;
        let help = "A world has `bundle`, `config`, `stitch`, `place` and `prefabs`; data/worlds/ has examples.";
        let mut world: Self =
            toml::from_str(&text).map_err(|e| BuildError::Config { message: explain(&e, &text, path, help) })?;
        if world.name.is_empty() {
            world.name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        world.bundle = folder.join(&world.bundle);
        world.config = world.config.map(|c| folder.join(c));
        Ok(world)
    }

    /// True for the text of a world, as against other files in TOML.
    pub fn is_one(path: &Path) -> bool {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        text.parse::<toml::Table>().is_ok_and(|t| t.contains_key("place") && t.contains_key("bundle"))
    }

    /// Where the stitched world is kept unless something else is said: beside the bundle, as `NAME.world`.
    pub fn stitched_path(&self) -> PathBuf {
        self.bundle.with_file_name(format!("{}.world", self.name))
    }

    /// What stands where.
    ///
    /// - `units`: the bundle's.
    /// - `path`: of the world file, for messages.
    ///
    /// # Errors
    /// [`BuildError::Config`] as [`EnvironmentFile::expand`].
    pub fn environment(&self, units: &UnitSet, path: &Path) -> Result<Environment, BuildError> {
        let file = EnvironmentFile {
            name: self.name.clone(),
            units: PathBuf::new(),
            prefabs: self.prefabs.clone(),
            place: self.place.clone(),
        };
        file.expand(units, path)
    }
}

/// What a bundle's patches need to be stitched, decoded once.
#[derive(Clone, Debug)]
pub struct Kit {
    /// The bundle's unit objects.
    pub units: UnitSet,
    /// Their geometry.
    pub geometries: Vec<Arc<UnitGeometry>>,
}

impl Kit {
    /// Of an open bundle; `path` is for messages and for mesh files, which are found from its folder.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a bundle without patches, [`BuildError::Config`] for units that cannot be read.
    pub fn new(tables: &Tables, path: &Path) -> Result<Self, BuildError> {
        if tables.patches().patches.is_empty() {
            return Err(BuildError::Stage {
                stage: "stitch",
                message: format!("{}: the bundle has no motion patches", path.display()),
                help: "Build it from a config with a table `[patches]`, such as data/playground.toml".into(),
            });
        }
        let units = UnitSet::parse(&tables.meta().units, path)?;
        let geometries = geometries(&units)?;
        Ok(Self { units, geometries })
    }

    /// What stitching needs to know.
    pub fn library<'a>(&'a self, tables: &'a Tables) -> Library<'a> {
        let meta = tables.meta();
        Library {
            bundle: &meta.name,
            fingerprint: tables.fingerprint(),
            rate_hz: meta.rate_hz,
            names: &meta.patches,
            units: &self.units,
            frames: tables.frames(),
            groups: tables.pose_groups(),
            contacts: tables.contacts(),
            geometries: &self.geometries,
            skeleton: tables.skeleton(),
        }
    }
}

/// Stitches a world from its file.
///
/// - `path`: of the world file, for messages.
///
/// # Errors
/// As [`WorldSource::environment`] and [`super::stitch`].
pub fn stitch_source(
    source: &WorldSource,
    path: &Path,
    tables: &Tables,
    kit: &Kit,
    progress: &dyn Progress,
) -> Result<(WorldData, StitchReport), BuildError> {
    let environment = source.environment(&kit.units, path)?;
    let editor = Editor::new(tables.patches(), kit.library(tables), environment, &source.stitch, progress)?;
    Ok(editor.into_world())
}

/// Writes a world, which takes its place only when it is whole.
///
/// - returns its length. [Unit: bytes]
///
/// # Errors
/// [`BuildError::Io`] where it cannot be written.
pub fn save(world: &WorldData, out: &Path) -> Result<u64, BuildError> {
    write_atomically(out, |mut w| world.write(&mut w))?;
    let length = std::fs::metadata(out).map_err(|source| BuildError::Io { path: out.to_path_buf(), source })?.len();
    Ok(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str) -> Result<WorldSource, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("square.toml");
        std::fs::write(&path, text).unwrap();
        WorldSource::load(&path).map_err(|e| e.to_string())
    }

    #[test]
    fn a_world_is_kept_beside_its_bundle_under_its_own_name() {
        let world = load("bundle = \"../b.throng\"\n[[place]]\nunit = \"ground\"\nat = [0, 0, 0]\n").unwrap();
        assert_eq!(world.name, "square");
        assert!(world.stitched_path().ends_with("../square.world"), "{}", world.stitched_path().display());
    }

    #[test]
    fn an_unknown_key_names_its_line() {
        let error = load("bundle = \"b.throng\"\nplace = []\nstich = {}\n").unwrap_err();
        assert!(error.contains("square.toml:3") && error.contains("`stitch`"), "{error}");
    }
}
