//! Which files a build depends on, and what they hold.

use crate::cache::{Key, content_hash};
use crate::config::BuildConfig;
use crate::environment::{Shape, UnitSet};
use crate::graph::GraphReport;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use throng_base::file::{MAX_MOTION_BYTES, read_file};
use throng_core::format::{Meta, SourceMeta};
use throng_motion::error::BuildError;
use throng_motion::import;
use throng_synth::SynthInput;

/// The files of a build: motion, skeletons, sidecars, profiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// Sorted by path.
    pub sources: Vec<SourceMeta>,
}

/// Finds and hashes every file that the motion stages read; synthetic motion is named by what it is made by.
///
/// # Errors
/// [`BuildError::Import`] for a path that yields no file, [`BuildError::Io`] for a file that cannot be read.
pub fn collect(config: &BuildConfig) -> Result<Provenance, BuildError> {
    let cfg = &config.import;
    let motion = import::expand(&config.inputs)?;
    let mut all: BTreeSet<PathBuf> = motion.iter().cloned().chain(cfg.profiles.iter().cloned()).collect();
    all.extend(cfg.asf.clone());
    all.extend(surroundings(config)?);
    for path in &motion {
        all.extend(Some(path.with_extension("toml")).filter(|p| p.is_file()));
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("amc")) && cfg.asf.is_none() {
            all.extend(import::find_asf(path).ok());
        }
    }
    let mut sources: Vec<SourceMeta> = all.into_par_iter().map(|p| hash(&p)).collect::<Result<_, _>>()?;
    sources.extend(config.synth.iter().flat_map(SynthInput::all).map(|s| made(s, config.resample.rate_hz)));
    Ok(Provenance { sources })
}

/// Unit objects, what they are drawn with, and the environments of clips.
fn surroundings(config: &BuildConfig) -> Result<Vec<PathBuf>, BuildError> {
    let Some(path) = &config.patches.units else {
        return Ok(Vec::new());
    };
    let units = UnitSet::load(path)?;
    let meshes = units.units.iter().flat_map(|u| &u.shapes).filter_map(|s| match s {
        Shape::Mesh { file } => Some(file.clone()),
        _ => None,
    });
    let environments = config.patches.environments.iter().map(|e| e.file.clone());
    Ok(std::iter::once(path.clone()).chain(meshes).chain(environments).collect())
}

/// Synthetic motion: what it is made by stands for its content.
fn made(synth: &SynthInput, rate_hz: f64) -> SourceMeta {
    let (name, how) = (synth.set.name(), synth.config(rate_hz));
    let path = format!("synthetic {name}, {} min, seed {}", how.minutes, how.seed);
    SourceMeta { hash: content_hash(format!("{how:?}").as_bytes()), path, bytes: 0 }
}

fn hash(path: &Path) -> Result<SourceMeta, BuildError> {
    let bytes = read_file(path, "motion", MAX_MOTION_BYTES).map_err(|e| match e {
        throng_base::Error::Io { path, source } => BuildError::Io { path, source },
        e => BuildError::Config { message: e.to_string() },
    })?;
    Ok(SourceMeta { path: path.display().to_string(), bytes: bytes.len() as u64, hash: content_hash(&bytes) })
}

impl Provenance {
    /// The key of the files and of what they hold.
    ///
    /// # Errors
    /// Never in practice: paths and numbers can be encoded.
    pub fn key(&self) -> Result<Key, BuildError> {
        Key::of("sources", &[], &self.sources)
    }

    /// What the bundle says of itself; clips and behaviours are filled in when it is written.
    ///
    /// # Errors
    /// [`BuildError::Config`] where the config cannot be written as TOML.
    pub fn meta(&self, cfg: &BuildConfig, graph: &GraphReport) -> Result<Meta, BuildError> {
        Ok(Meta {
            name: cfg.name.clone(),
            generator: concat!("throng ", env!("CARGO_PKG_VERSION")).into(),
            rate_hz: cfg.resample.rate_hz,
            config: cfg.to_toml()?,
            sources: self.sources.clone(),
            frames_in: graph.frames_in as u64,
            frames_kept: graph.frames_kept as u64,
            ..Meta::default()
        })
    }
}
