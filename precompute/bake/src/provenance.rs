//! Files that a build depends on, with their hashes.

use crate::cache::{CacheKey, content_hash};
use crate::environment::{UnitSet, UnitShape, buffer_files};
use crate::{config::BuildConfig, graph::GraphReport};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use throng_core::format::{Meta, SourceMeta};
use throng_motion::error::{ImportError, Result};
use throng_motion::import::{self, ClipsResult, ImportConfig, archive};
use throng_synth::SynthInput;
use xxhash_rust::xxh3::Xxh3;

/// Files of a build: motion, skeletons, sidecars, profiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// Files, sorted by path.
    pub sources: Vec<SourceMeta>,
    /// Files that are read along with each motion file.
    along: BTreeMap<PathBuf, Vec<PathBuf>>,
    /// Common folder of all files that the config names: a bundle stores paths relative to it, so that it does not
    /// depend on where it was made.
    base: PathBuf,
}

/// Inputs of the keys of single motion files.
pub struct FileKeys<'a> {
    pub(crate) config: &'a ImportConfig,
    /// Skeleton and profiles that the config names.
    given: Vec<&'a SourceMeta>,
    files: BTreeMap<&'a Path, &'a SourceMeta>,
    along: &'a BTreeMap<PathBuf, Vec<PathBuf>>,
}

impl FileKeys<'_> {
    /// Key of an imported motion file: of the file, the files read along with it, and the profiles.
    ///
    /// # Errors
    /// Never in practice, as [`Provenance::key`].
    pub fn key_of(&self, file: &Path) -> Result<CacheKey> {
        let name = file.as_os_str().as_encoded_bytes();
        let read: Vec<_> = self.read_with(file).map(|path| self.files.get(&*path)).collect();
        CacheKey::for_stage("file", &[], &(name, read, &self.given, self.config, import::READS_FBX))
    }

    /// A file, and the files read along with it.
    fn read_with(&self, file: &Path) -> impl Iterator<Item = PathBuf> {
        let whole = import::clip_in_file(file).map_or(file.to_path_buf(), |(whole, _)| whole);
        let along = self.along.get(&whole).into_iter().flatten().cloned();
        std::iter::once(whole.clone()).chain(along)
    }

    /// Reads a motion file, checking that it still matches its key.
    ///
    /// # Errors
    /// Errors of `import`; [`ImportError::Changed`] for a file that differs from its hash.
    pub fn read_file(&self, file: &Path, import: impl FnOnce() -> ClipsResult) -> ClipsResult {
        let clips = import();
        let given = self.given.iter().map(|s| PathBuf::from(&s.path));
        let is_same = |path: &Path, was: &SourceMeta| hash(path).is_ok_and(|now| now == *was);
        let changed = |path: &PathBuf| self.files.get(&**path).is_some_and(|was| !is_same(path, was));
        self.read_with(file).chain(given).find(changed).map_or(clips, |path| Err(ImportError::Changed { path }))
    }
}

/// Checks that no file has changed, as some stages read files again.
///
/// # Errors
/// As [`collect_provenance`]; [`ImportError::Changed`] names the first changed file.
pub fn check_unchanged(from: &Provenance, config: &BuildConfig) -> Result<()> {
    let now = collect_provenance(config)?;
    let both = from.sources.iter().map(Some).chain([None]).zip(now.sources.iter().map(Some).chain([None]));
    match both.into_iter().find(|(was, is)| was != is) {
        None => Ok(()),
        Some((was, is)) => {
            let path = was.or(is).map(|s| PathBuf::from(&s.path)).unwrap_or_default();
            Err(ImportError::Changed { path }.into())
        }
    }
}

/// Finds and hashes every file that the motion stages read; synthetic motion is identified by its settings.
///
/// # Errors
/// [`throng_motion::error::BuildError::Import`] for a path that yields no file,
/// [`throng_motion::error::BuildError::Io`] for a file that cannot be read.
pub fn collect_provenance(config: &BuildConfig) -> Result<Provenance> {
    let cfg = &config.import;
    let file_of = |path: PathBuf| import::clip_in_file(&path).map_or(path, |(file, _)| file);
    let motion: BTreeSet<PathBuf> = import::expand(&config.inputs)?.into_iter().map(file_of).collect();
    let mut along = BTreeMap::new();
    let mut all: BTreeSet<PathBuf> = motion.iter().cloned().chain(cfg.profiles.iter().cloned()).collect();
    all.extend(cfg.asf.clone());
    all.extend(surrounding_files(config)?);
    for path in &motion {
        all.extend(Some(path.with_extension("toml")).filter(|p| archive::is_file(p)));
        let others = import::read_along(path, cfg.asf.as_deref());
        all.extend(others.iter().cloned());
        along.insert(path.clone(), others);
    }
    let mut sources: Vec<SourceMeta> = all.into_par_iter().map(|p| hash(&p)).collect::<Result<_, _>>()?;
    sources.extend(
        config.synth.iter().flat_map(SynthInput::with_others).map(|s| synthetic_source(s, config.resample.rate_hz)),
    );
    let named: Vec<&PathBuf> = config.paths().collect();
    let base = named.iter().map(|p| folder_of(p)).reduce(|a, b| shared_files(&a, &b)).unwrap_or_default();
    Ok(Provenance { sources, along, base })
}

/// Folder of a path, or of the first component with a star.
fn folder_of(path: &Path) -> PathBuf {
    let is_plain = |c: &Component<'_>| !c.as_os_str().to_string_lossy().contains('*');
    let plain: PathBuf = path.components().take_while(is_plain).collect();
    if plain == path { path.parent().unwrap_or(Path::new("")).to_path_buf() } else { plain }
}

/// Common folder of two folders.
fn shared_files(a: &Path, b: &Path) -> PathBuf {
    a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}

/// Files of unit objects, with their meshes, and of the environments of clips.
fn surrounding_files(config: &BuildConfig) -> Result<Vec<PathBuf>> {
    let Some(path) = &config.patches.units else { return Ok(Vec::new()) };
    let units = UnitSet::load(path)?;
    let mut all = vec![path.clone()];
    all.extend(config.patches.environments.iter().map(|e| e.file.clone()));
    for shape in units.units.iter().flat_map(|u| &u.shapes) {
        if let UnitShape::Mesh { file } = shape
            && !all.contains(file)
        {
            all.extend(buffer_files(file)?);
            all.push(file.clone());
        }
    }
    Ok(all)
}

/// Source entry of synthetic motion, whose settings stand for its content.
fn synthetic_source(synth: &SynthInput, rate_hz: f64) -> SourceMeta {
    let (name, how) = (synth.set.name(), synth.config(rate_hz));
    let path = format!("synthetic {name}, {} min, seed {}", how.minutes, how.seed);
    SourceMeta { hash: content_hash(format!("{how:?}").as_bytes()), path, bytes: 0 }
}

fn hash(path: &Path) -> Result<SourceMeta> {
    let mut counted = CountingHasher { hash: Xxh3::new(), bytes: 0 };
    archive::copy_file(path, "a file of a build", import::MAX_MOTION_BYTES, &mut counted)?;
    Ok(SourceMeta { path: path.display().to_string(), bytes: counted.bytes, hash: counted.hash.digest128() })
}

/// Writer that hashes its input, as [`content_hash`] does.
struct CountingHasher {
    hash: Xxh3,
    bytes: u64,
}

impl Write for CountingHasher {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.hash.update(bytes);
        self.bytes += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Provenance {
    /// Key of the files and their contents.
    ///
    /// # Errors
    /// Never in practice: paths and numbers can be encoded.
    pub fn key(&self) -> Result<CacheKey> {
        CacheKey::for_stage("sources", &[], &self.sources)
    }

    /// Keys of single imported files.
    pub fn file_keys<'a>(&'a self, config: &'a ImportConfig) -> FileKeys<'a> {
        let is_given = |path: &Path| config.asf.iter().chain(&config.profiles).any(|p| p == path);
        let files: BTreeMap<_, _> = self.sources.iter().map(|s| (Path::new(&s.path), s)).collect();
        let given = self.sources.iter().filter(|s| is_given(Path::new(&s.path))).collect();
        FileKeys { config, given, files, along: &self.along }
    }

    /// A path as stored in the bundle.
    pub fn seen_from_base(&self, path: &Path) -> PathBuf {
        path.strip_prefix(&self.base).ok().filter(|p| !p.as_os_str().is_empty()).unwrap_or(path).to_path_buf()
    }

    /// Metadata of the bundle; clips and behaviours are added when it is written.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Config`] if the config cannot be written as TOML.
    pub fn meta(&self, cfg: &BuildConfig, graph: &GraphReport) -> Result<Meta> {
        let mut cfg = cfg.clone();
        cfg.paths_mut().for_each(|path| *path = self.seen_from_base(path));
        let seen = |s: &SourceMeta| SourceMeta {
            path: self.seen_from_base(Path::new(&s.path)).display().to_string(),
            ..s.clone()
        };
        Ok(Meta {
            name: cfg.name.clone(),
            generator: concat!("throng ", env!("CARGO_PKG_VERSION")).into(),
            rate_hz: cfg.resample.rate_hz,
            config: cfg.to_toml()?,
            sources: self.sources.iter().map(seen).collect(),
            frames_in: graph.frames_in as u64,
            frames_kept: graph.frames_kept as u64,
            ..Meta::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_hashed_as_its_content_and_a_device_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bvh");
        let bytes: Vec<u8> = (0..100_000u64).map(|i| ((i * i) >> 3) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        let of = hash(&path).unwrap();
        assert_eq!((of.bytes, of.hash), (100_000, content_hash(&bytes)));
        #[cfg(unix)]
        assert!(hash(Path::new("/dev/zero")).unwrap_err().to_string().contains("is a device or a pipe"));
    }

    #[test]
    fn what_motion_keeps_in_other_files_counts() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("m.gltf"), r#"{"buffers":[{"uri":"m.bin"},{"uri":"gone.bin"}]}"#).unwrap();
        let config = BuildConfig { inputs: vec![folder.path().to_path_buf()], ..BuildConfig::default() };
        let keys = |content: &[u8]| {
            std::fs::write(at("m.bin"), content).unwrap();
            let found = collect_provenance(&config).unwrap();
            assert_eq!(found.sources.len(), 2);
            // A clip of several is as its file is.
            [at("m.gltf"), at("m.gltf/Run")].map(|p| found.file_keys(&config.import).key_of(&p).unwrap())
        };
        let (first, second) = (keys(&[1]), keys(&[2]));
        assert!(first[0] != second[0] && first[1] != second[1]);
        assert_eq!(keys(&[1]), first);
    }

    #[test]
    fn what_meshes_keep_in_other_files_counts() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("m.gltf"), r#"{"buffers":[{"uri":"m.bin"}]}"#).unwrap();
        std::fs::write(at("m.bin"), [1]).unwrap();
        let shape = "{ mesh = { file = \"m.gltf\" } }";
        std::fs::write(at("u.toml"), format!("[[units]]\nname = \"a\"\nshapes = [{shape}, {shape}]\n")).unwrap();
        let mut config = BuildConfig::default();
        config.patches.units = Some(at("u.toml"));
        let found = surrounding_files(&config).unwrap();
        assert_eq!(found, [at("u.toml"), at("m.bin"), at("m.gltf")]);
    }
}
