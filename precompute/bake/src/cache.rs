//! Outputs of stages kept between builds, found again by a hash of everything they depend on.

use serde::{Serialize, de::DeserializeOwned};
use std::path::{Path, PathBuf};
use throng_motion::error::{BuildError, Warnings};
use throng_motion::files::write_atomically;
use xxhash_rust::xxh3::Xxh3;

/// Part of every key: the version and a hash of the sources (`build.rs`), as other code may make something else of the
/// same input.
const EPOCH: &str = concat!("throng ", env!("CARGO_PKG_VERSION"), " ", env!("THRONG_SOURCES"));
/// Most bytes a cached output may ask for while it is decoded.
const LIMIT: usize = 8 << 30;

/// Hash of everything an output depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(u128);

impl Key {
    /// The key of a stage's output: its name, its config and the keys of all else it is made of.
    ///
    /// # Errors
    /// [`BuildError::Format`] for a config that cannot be encoded.
    pub fn of(stage: &str, inputs: &[Self], config: &impl Serialize) -> Result<Self, BuildError> {
        let config = bincode::serde::encode_to_vec(config, bincode::config::standard())
            .map_err(|e| BuildError::Format(format!("the config of stage {stage} cannot be encoded: {e}")))?;
        let inputs: Vec<u8> = inputs.iter().flat_map(|k| k.0.to_le_bytes()).collect();
        Ok(Self::hash([EPOCH.as_bytes(), stage.as_bytes(), &inputs, &config]))
    }

    fn hash<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut h = Xxh3::new();
        for p in parts {
            h.update(&(p.len() as u64).to_le_bytes());
            h.update(p);
        }
        Self(h.digest128())
    }
}

/// Hash of a file's content.
pub fn content_hash(bytes: &[u8]) -> u128 {
    xxhash_rust::xxh3::xxh3_128(bytes)
}

/// A folder of outputs, or none.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: Option<PathBuf>,
}

impl Cache {
    /// Keeps outputs in a folder, which is made when it is first needed.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self { folder: Some(folder.into()) }
    }

    /// Keeps nothing.
    pub fn none() -> Self {
        Self { folder: None }
    }

    fn path(&self, stage: &str, key: Key) -> Option<PathBuf> {
        self.folder.as_ref().map(|f| f.join(format!("{stage}-{:032x}", key.0)))
    }

    /// The output kept under a key. Damaged entries count as absent.
    pub fn load<T: DeserializeOwned>(&self, stage: &str, key: Key) -> Option<T> {
        let bytes = std::fs::read(self.path(stage, key)?).ok()?;
        let (body, sum) = bytes.split_last_chunk::<16>()?;
        if content_hash(body) != u128::from_le_bytes(*sum) {
            return None;
        }
        let config = bincode::config::standard().with_fixed_int_encoding().with_limit::<LIMIT>();
        let (value, used) = bincode::serde::decode_from_slice(body, config).ok()?;
        (used == body.len()).then_some(value)
    }

    /// Keeps an output. A cache that cannot be written is a warning, not an error.
    pub fn store(&self, stage: &str, key: Key, value: &impl Serialize, warnings: &mut Warnings) {
        let Some(path) = self.path(stage, key) else { return };
        if let Err(e) = try_store(&path, value) {
            warnings.push(format!("{}: not cached: {e}", path.display()));
        }
    }
}

fn try_store(path: &Path, value: &impl Serialize) -> Result<(), BuildError> {
    let config = bincode::config::standard().with_fixed_int_encoding();
    let body = bincode::serde::encode_to_vec(value, config).map_err(|e| BuildError::Format(e.to_string()))?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|source| BuildError::Io { path: folder.to_path_buf(), source })?;
    }
    write_atomically(path, |w| {
        w.write_all(&body)?;
        w.write_all(&content_hash(&body).to_le_bytes())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_was_kept_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(dir.path().join("cache"));
        let key = Key::of("graph", &[], &1u32).unwrap();
        let mut warnings = Warnings::default();
        assert_eq!(cache.load::<Vec<f32>>("graph", key), None);
        cache.store("graph", key, &vec![1.0f32, 2.0], &mut warnings);
        assert_eq!(cache.load::<Vec<f32>>("graph", key), Some(vec![1.0, 2.0]));
        assert_eq!(cache.load::<Vec<f32>>("graph", Key::of("graph", &[], &2u32).unwrap()), None);
        assert_eq!(warnings, Warnings::default());

        let path = cache.path("graph", key).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[3] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(cache.load::<Vec<f32>>("graph", key), None);
    }
}
