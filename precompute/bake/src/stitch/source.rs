//! World files (TOML): a bundle, settings, and the environment that is stitched from its patches.

use super::edit::make::{as_toml, source_hash};
use super::{Editor, Library, StitchConfig, StitchReport, library::STAGE};
use crate::environment::{
    Environment, EnvironmentFile, PlacedUnit, PlacementPattern, UnitGeometry, UnitSet, geometries,
};
use crate::stages::stage_error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Component, Path, PathBuf};
use std::{collections::BTreeMap, sync::Arc};
use throng_base::text::TomlSource;
use throng_core::{Bundle, patch::PatchTables};
use throng_motion::error::{BuildError, Result};
use throng_motion::files::{self, write_atomically};
use throng_motion::progress::Progress;
use throng_world::{PathCosts, WORLD_MAGIC, World, WorldData, WorldGraph};

/// Source of a world to be stitched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorldSource {
    /// Name; the file's stem if absent.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Bundle with the patches, relative to this file's folder.
    pub bundle: PathBuf,
    /// Config from which a missing bundle is built, relative to this file's folder.
    pub config: Option<PathBuf>,
    /// Settings of stitching.
    #[serde(default)]
    pub stitch: StitchConfig,
    /// Groups of the bundle's units that are placed together, by name; may hold other groups.
    #[serde(default)]
    pub prefabs: BTreeMap<String, Vec<PlacementPattern>>,
    /// Placed units and prefabs.
    pub place: Vec<PlacementPattern>,
}

impl WorldSource {
    /// Reads a world file; paths in it are relative to its folder.
    ///
    /// # Errors
    /// [`BuildError::File`] with file, line and column.
    pub fn load(path: &Path) -> Result<Self> {
        let source = TomlSource::read(path, "a world")?;
        let help = "A world has `bundle`, `config`, `stitch`, `place` and `prefabs`; data/worlds/ has examples.";
        let mut world: Self = source.parse(help)?;
        if world.name.is_empty() {
            world.name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        }
        // The stitched world is named after it, beside the bundle.
        if Path::new(&world.name).file_name().is_none_or(|n| n != world.name.as_str()) || world.name.contains('\\') {
            let why = format!("expected the name of a file without folders, found \"{}\"", world.name);
            return Err(BuildError::key("name", why).with_position(&source));
        }
        world.stitch.check().map_err(|e| e.with_position(&source))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        world.bundle = folder.join(&world.bundle);
        world.config = world.config.map(|c| folder.join(c));
        Ok(world)
    }

    /// True for the text of a world, as opposed to other TOML files.
    pub fn is_one(path: &Path) -> bool {
        let has_keys =
            |source: TomlSource| source.table().is_some_and(|t| ["place", "bundle"].iter().all(|&k| t.contains_key(k)));
        TomlSource::read(path, "a world").is_ok_and(has_keys)
    }

    /// Default path of the stitched world: beside the bundle, as `NAME.world`.
    pub fn stitched_path(&self) -> PathBuf {
        self.bundle.with_file_name(format!("{}.world", self.name))
    }

    /// This world with the units of an environment, placed one by one.
    ///
    /// - `units`: the bundle's.
    pub fn with_environment(&self, environment: &Environment, units: &UnitSet) -> Self {
        let place = |p: &PlacedUnit| PlacementPattern {
            unit: units.units[p.unit].name.clone(),
            at: p.placement.translation().to_array(),
            heading_deg: p.placement.with_wrapped_heading().heading.to_degrees(),
            repeat: [1; 3],
            step: [[0.0; 3]; 3],
        };
        let place = environment.units.iter().map(place).collect();
        Self { prefabs: BTreeMap::new(), place, ..self.clone() }
    }

    /// Writes a world file, which replaces an older one only when complete. The world is named after the file; the
    /// bundle and its config are relative to the file's folder.
    ///
    /// # Errors
    /// [`BuildError::Io`] where it cannot be written, [`BuildError::Stage`] for numbers that TOML cannot hold.
    pub fn save(&self, path: &Path) -> Result<()> {
        let io = |source| BuildError::Io { path: path.to_path_buf(), source };
        let folder = std::path::absolute(path.parent().unwrap_or(Path::new(""))).map_err(io)?;
        let beside = |p: &Path| std::path::absolute(p).map(|p| relative(&p, &folder)).map_err(io);
        let config = self.config.as_deref().map(beside).transpose()?;
        let saved = Self { name: String::new(), bundle: beside(&self.bundle)?, config, ..self.clone() };
        let why = |e| format!("world {} cannot be written as TOML: {e}", self.name);
        let text = toml::to_string(&saved).map_err(|e| stage_error(STAGE, why(e), "Give every unit a finite place"))?;
        write_atomically(path, |w| w.write_all(text.as_bytes()))
    }

    /// Content hash of all inputs of a world, as stored in [`throng_world::WorldMeta::source_hash`].
    ///
    /// # Errors
    /// As [`WorldSource::environment`].
    pub fn hash(&self, library: &Library<'_>, path: &Path) -> Result<u128> {
        source_hash(&as_toml(&self.environment(library.units, path)?)?, &self.stitch, library)
    }

    /// Environment with the placed units.
    ///
    /// - `units`: the bundle's.
    /// - `path`: of the world file, for messages.
    ///
    /// # Errors
    /// As [`EnvironmentFile::expand`].
    pub fn environment(&self, units: &UnitSet, path: &Path) -> Result<Environment> {
        let Self { name, prefabs, place, .. } = self.clone();
        EnvironmentFile { name, units: PathBuf::new(), prefabs, place }.expand(units, path)
    }
}

/// A path relative to a folder; both are absolute. A path on another drive stays absolute.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let (path, folder) = (normalise_path(path), normalise_path(folder));
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return path;
    }
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    up.chain(path.components().skip(shared)).collect()
}

/// An absolute path without `..`.
fn normalise_path(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, c| {
        match c {
            Component::ParentDir => _ = plain.pop(),
            c => plain.push(c),
        }
        plain
    })
}

/// Data of a bundle's patches for stitching, decoded once.
#[derive(Clone, Debug)]
pub struct StitchKit {
    /// The bundle's unit objects.
    pub units: UnitSet,
    /// Their geometry.
    pub geometries: Vec<Arc<UnitGeometry>>,
}

impl StitchKit {
    /// Decodes an open bundle; `path` is for messages and for mesh files, which are relative to its folder.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a bundle without patches, [`BuildError::Config`] for units that cannot be read.
    pub fn new(tables: &Bundle, path: &Path) -> Result<Self> {
        if tables.patches().patches.is_empty() {
            let message = format!("{}: the bundle has no motion patches", path.display());
            let help = "Build it from a config with a table `[patches]`, such as data/playground.toml";
            return Err(stage_error(STAGE, message, help));
        }
        let units = UnitSet::parse(&tables.meta().units, path)?;
        let geometries =
            geometries(&units).map_err(|e| e.with_position(&TomlSource::new(&tables.meta().units, path)))?;
        Ok(Self { units, geometries })
    }

    /// Library for stitching.
    pub fn library<'a>(&'a self, tables: &'a Bundle) -> Library<'a> {
        let meta = tables.meta();
        Library {
            bundle: &meta.name,
            bundle_hash: tables.hash(),
            rate_hz: meta.rate_hz,
            names: &meta.patches,
            units: &self.units,
            frames: tables.frames(),
            rotation_code: tables.rotation_code(),
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
    tables: &Bundle,
    kit: &StitchKit,
    progress: &dyn Progress,
) -> Result<(WorldData, StitchReport)> {
    let environment = source.environment(&kit.units, path)?;
    let editor = Editor::new(tables.patches(), kit.library(tables), environment, &source.stitch, progress)?;
    Ok(editor.into_world())
}

/// Computes a world's path costs and writes it; it replaces an older one only when complete.
///
/// - `source`: its source file, which the world names.
/// - `patches`: the bundle's.
/// - returns its length (bytes).
///
/// # Errors
/// [`BuildError::Io`] where it cannot be written, [`BuildError::Stage`] for a world without a place for a character.
pub fn save(world: &mut WorldData, source: &Path, patches: &PatchTables, out: &Path) -> Result<u64> {
    let paths = WorldGraph::new(patches, &world.tables()).and_then(|graph| PathCosts::bake(&graph));
    let why = |e| stage_error(STAGE, format!("world {}: {e}", world.meta.name), "Place more units");
    let paths = paths.map_err(why)?;
    world.meta.source = seen_from(source, out)?;
    write_atomically(out, |mut w| world.write(&paths, &mut w))?;
    Ok(std::fs::metadata(out).map_err(|source| BuildError::Io { path: out.to_path_buf(), source })?.len())
}

/// Refuses to overwrite a world stitched from another file, as each file would lose its world.
///
/// # Errors
/// [`BuildError::Stage`] that names both files.
pub fn check_replaced(source: &Path, out: &Path) -> Result<()> {
    files::check_replaced(out, &WORLD_MAGIC, "a world")?;
    // A world that is damaged or of another version is useless, so it may be overwritten.
    let Ok(meta) = World::read_meta(out) else { return Ok(()) };
    if meta.source == seen_from(source, out)? {
        return Ok(());
    }
    let by = if meta.source.is_empty() { "no file" } else { meta.source.as_str() };
    let (out, source) = (out.display(), source.display());
    let message = format!("{out} was stitched from {by} (as seen from its folder), not from {source}");
    let help = "Give one of the two worlds another `name`, write this one elsewhere with `throng stitch --out`, or remove \
                the old one";
    Err(stage_error(STAGE, message, help))
}

/// A file relative to the folder of another one, with `/` between the parts.
fn seen_from(file: &Path, other: &Path) -> Result<String> {
    let real = |path: &Path| std::fs::canonicalize(path).or_else(|_| std::path::absolute(path));
    let folder = other.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let io = |source| BuildError::Io { path: file.to_path_buf(), source };
    let seen = relative(&real(file).map_err(io)?, &real(folder).map_err(io)?);
    Ok(seen.to_string_lossy().replace('\\', "/"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::UnitSolid;
    use glam::Vec3;
    use throng_core::Skeleton;
    use throng_geometry::TriangleMesh;

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
    fn a_world_that_is_saved_elsewhere_is_the_same_unit_by_unit() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.toml"), folder.path().join("more/b.toml"));
        std::fs::create_dir(folder.path().join("more")).unwrap();
        let text = "bundle = \"b.throng\"\nconfig = \"c.toml\"\n[stitch]\nobstacles = [\"wall\"]\n\
                    [[prefabs.pair]]\nunit = \"wall\"\nat = [0.1, 0, 2]\nrepeat = [2, 1, 1]\n\
                    step = [[3, 0, 0], [0, 0, 0], [0, 0, 0]]\n\
                    [[place]]\nunit = \"pair\"\nat = [1, 0, 0.7]\nheading_deg = 30\n";
        std::fs::write(&a, text).unwrap();
        let units = UnitSet::parse("[[units]]\nname = \"wall\"\n", Path::new("u.toml")).unwrap();
        let source = WorldSource::load(&a).unwrap();
        let before = source.environment(&units, &a).unwrap();
        source.with_environment(&before, &units).save(&b).unwrap();
        let saved = WorldSource::load(&b).unwrap();
        assert_eq!((saved.name.as_str(), saved.place.len(), &saved.stitch), ("b", 2, &source.stitch));
        assert_eq!(normalise_path(&saved.bundle), folder.path().join("b.throng"));
        assert!(saved.bundle.ends_with("../b.throng") && saved.config.is_some_and(|c| c.ends_with("../c.toml")));
        let saved = WorldSource::load(&b).unwrap();
        let after = saved.environment(&units, &b).unwrap();
        for (a, b) in before.units.iter().zip(&after.units) {
            assert!(a.placement.to_local(b.placement).with_wrapped_heading().is_moderate(1e-4), "{a:?} {b:?}");
        }
    }

    #[test]
    fn the_hash_tells_environment_settings_bundle_and_meshes_apart() {
        let units = UnitSet::parse("[[units]]\nname = \"wall\"\n", Path::new("u.toml")).unwrap();
        let mesh = |x| {
            let corners = vec![[Vec3::ZERO, Vec3::X * x, Vec3::Y]];
            let mut geometry = UnitGeometry::new(&units.units[0]).unwrap();
            geometry.solids = vec![UnitSolid::Mesh(TriangleMesh::new(corners).unwrap())];
            vec![Arc::new(geometry)]
        };
        let (one, other) = (mesh(1.0), mesh(2.0));
        let skeleton = Skeleton::default();
        let hash = |text: &str, bundle_hash, geometries: &[Arc<UnitGeometry>]| {
            let library = Library { bundle_hash, geometries, ..Library::without_motion(&units, &skeleton) };
            load(text).unwrap().hash(&library, Path::new("square.toml")).unwrap()
        };
        let text = "bundle = \"b.throng\"\n[[place]]\nunit = \"wall\"\nat = [0, 0, 0]\n";
        let base = hash(text, 1, &one);
        assert_eq!(base, hash(&text.replace("[0, 0, 0]", "[0.0, 0.0, 0.0]"), 1, &one), "spelling changes nothing");
        assert_ne!(base, hash(&text.replace("[0, 0, 0]", "[0, 0, 1]"), 1, &one));
        assert_ne!(base, hash(&format!("{text}[stitch]\nposition_m = 0.2\n"), 1, &one));
        assert_ne!(base, hash(text, 2, &one));
        assert_ne!(base, hash(text, 1, &other));
    }

    #[test]
    fn a_name_that_is_a_path_is_refused() {
        for name in ["../other", "a/b", "..", "/a"] {
            let error = load(&format!("name = \"{name}\"\nbundle = \"b.throng\"\nplace = []\n")).unwrap_err();
            assert!(error.contains("square.toml:1:1: name: expected the name of a file"), "{error}");
        }
    }

    #[test]
    fn an_unknown_key_names_its_line() {
        let error = load("bundle = \"b.throng\"\nplace = []\nstich = {}\n").unwrap_err();
        assert!(error.contains("square.toml:3") && error.contains("`stitch`"), "{error}");
    }
}
