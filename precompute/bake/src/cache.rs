//! Outputs of stages kept between builds, found again by a hash of everything they depend on.

mod folder;
#[cfg(feature = "object-store")]
mod objects;

use folder::FolderStorage;
use serde::{Serialize, de::DeserializeOwned};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::{fmt::Debug, time::SystemTime};
use throng_motion::error::{BuildError, Result, Warnings};
use xxhash_rust::xxh3::Xxh3;

/// Part of every key: the version and a hash of the sources (`build.rs`), as other code may make other outputs of the
/// same input.
const EPOCH: &str = concat!("throng ", env!("CARGO_PKG_VERSION"), " ", env!("THRONG_SOURCES"));
/// Largest cached output, and most memory that decoding one may take (bytes).
const LIMIT: usize = 8 << 30;

/// Prefix of the addresses of object stores.
const STORE: &str = "s3://";
/// Suffix of the names of bundles, in the cache as elsewhere.
const BUNDLE: &str = ".throng";

/// Hash of everything an output depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CacheKey(pub(crate) u128);

impl CacheKey {
    /// Key of a stage's output: its name, its config and the keys of all its inputs.
    ///
    /// # Errors
    /// [`BuildError::Format`] for a config that cannot be encoded.
    pub fn for_stage(stage: &str, inputs: &[Self], config: &impl Serialize) -> Result<Self> {
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

/// Storage of entries: bytes under names. An entry is complete unless it was damaged later, which [`Cache`] checks.
trait CacheStorage: Debug + Send + Sync {
    /// Reads the bytes of an entry; `None` if there is no such entry.
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>>;
    /// True if there is such an entry.
    fn has_entry(&self, name: &str) -> Result<bool>;
    /// Stores an entry atomically: other processes see all of it, or the previous one.
    fn write(&self, name: &str, bytes: Vec<u8>) -> Result<()>;
    /// Removes an entry; another process may already have removed it.
    fn remove(&self, name: &str) -> Result<()>;
    /// Lists all files that may be entries: name, length (bytes), time of last use.
    fn list(&self) -> Result<Vec<(String, u64, SystemTime)>>;
    /// Notes that an entry was used: now, or just after `last` if the clock has been set back since.
    fn touch(&self, name: &str, last: Option<SystemTime>);
    /// Removes partial entries left by killed processes; returns false if the storage itself frees space.
    fn tidy(&self) -> bool;
    /// Address of an entry, for messages; a file path if [`CacheStorage::is_folder`].
    fn address(&self, name: &str) -> PathBuf;
    /// True if entries are files.
    fn is_folder(&self) -> bool;
}

/// Cache of outputs in a folder or in an object store; may be disabled.
///
/// Several builds may use one cache at once: entries appear complete, and a build that finds an entry removed makes its
/// output again.
#[derive(Clone, Debug)]
pub struct Cache {
    storage: Option<Arc<dyn CacheStorage>>,
    limit_bytes: u64,
    /// First fault since faults were last taken.
    fault: Arc<Mutex<Option<BuildError>>>,
}

/// A cached output.
#[derive(Clone, Debug, PartialEq)]
pub struct CacheEntry {
    /// Its name in the folder, or in the store.
    pub name: String,
    /// Stage that made it.
    pub stage: String,
    /// Its length (bytes).
    pub bytes: u64,
    /// Time of last use. Never before that of an entry that was used earlier, even if the clock was set back. In an
    /// object store, the time of writing.
    pub used: SystemTime,
}

impl CacheEntry {
    /// Parses the name of an entry; `None` for a file that is no entry.
    fn new(name: String, bytes: u64, used: SystemTime) -> Option<Self> {
        let (stage, key) = name.strip_suffix(BUNDLE).unwrap_or(&name).rsplit_once('-')?;
        let ours = key.len() == 32 && key.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        let stage = stage.to_owned();
        ours.then_some(Self { stage, name, bytes, used })
    }
}

impl Cache {
    /// Default folder of a cache.
    pub const FOLDER: &str = ".throng-cache";
    /// Default limit of a cache (bytes).
    pub const LIMIT_BYTES: u64 = 5_000_000_000;

    fn new(storage: Option<Arc<dyn CacheStorage>>, limit_bytes: u64) -> Self {
        Self { storage, limit_bytes, fault: Arc::default() }
    }

    /// Keeps outputs at an address: `s3://BUCKET/PREFIX`, or a folder.
    ///
    /// - `limit_bytes`: most that a folder keeps; the limits of a bucket are set in the bucket itself.
    ///
    /// # Errors
    /// [`BuildError::Store`] where a store does not answer or refuses, or where this program is built without the
    /// feature `object-store`.
    pub fn at_address(address: &Path, limit_bytes: u64) -> Result<Self> {
        match address.to_str().filter(|a| a.starts_with(STORE)) {
            Some(address) => Self::in_store(address),
            None => Ok(Self::in_folder(address).limited(limit_bytes)),
        }
    }

    #[cfg(feature = "object-store")]
    fn in_store(address: &str) -> Result<Self> {
        Ok(Self::new(Some(Arc::new(objects::ObjectStorage::open(address)?)), LIMIT as u64))
    }

    #[cfg(not(feature = "object-store"))]
    fn in_store(address: &str) -> Result<Self> {
        let why = "this program knows no stores of objects; build it with `cargo build --release --features object-store`, \
                   or name a folder";
        Err(BuildError::Store { address: address.into(), why: why.into() })
    }

    /// Keeps outputs in a folder, which is created when first needed, up to [`Cache::LIMIT_BYTES`].
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self::new(Some(Arc::new(FolderStorage::new(folder.into()))), Self::LIMIT_BYTES)
    }

    /// A disabled cache, which keeps nothing.
    pub fn disabled() -> Self {
        Self::new(None, 0)
    }

    /// This cache with another limit, for which the least recently used entries are removed.
    pub fn limited(self, limit_bytes: u64) -> Self {
        Self { limit_bytes, ..self }
    }

    /// Path at which a bundle made to be run or viewed is kept; `None` if nothing is kept, or not in files. Counts as a
    /// use.
    pub fn bundle(&self, key: CacheKey) -> Option<PathBuf> {
        let storage = self.storage.as_ref().filter(|p| p.is_folder())?;
        let name = format!("{}{BUNDLE}", entry_name("bundle", key));
        let path = storage.address(&name);
        if path.is_file() {
            self.touch(&name);
        }
        Some(path)
    }

    /// All entries, least recently used first; none if the folder does not exist.
    ///
    /// # Errors
    /// [`BuildError::Io`] where the folder cannot be listed; [`BuildError::Store`].
    pub fn entries(&self) -> Result<Vec<CacheEntry>> {
        let Some(storage) = &self.storage else { return Ok(Vec::new()) };
        let listed = storage.list()?.into_iter();
        let mut entries: Vec<CacheEntry> =
            listed.filter_map(|(name, bytes, used)| CacheEntry::new(name, bytes, used)).collect();
        entries.sort_by(|a, b| a.used.cmp(&b.used).then_with(|| a.name.cmp(&b.name)));
        Ok(entries)
    }

    /// Removes all entries, and no other files; returns their number and total length (bytes).
    ///
    /// # Errors
    /// [`BuildError::Io`] or [`BuildError::Store`] names the first that cannot be removed.
    pub fn clear(&self) -> Result<(usize, u64)> {
        let entries = self.entries()?;
        if let Some(storage) = &self.storage {
            entries.iter().try_for_each(|e| storage.remove(&e.name))?;
        }
        Ok((entries.len(), entries.iter().map(|e| e.bytes).sum()))
    }

    /// True if the cache is enabled.
    pub(crate) fn is_on(&self) -> bool {
        self.storage.is_some()
    }

    /// True if there is an entry under a key, which is not checked for damage.
    pub(crate) fn has_entry(&self, stage: &str, key: CacheKey) -> bool {
        self.storage
            .as_ref()
            .is_some_and(|storage| self.note_fault(storage.has_entry(&entry_name(stage, key))).unwrap_or(false))
    }

    /// The output kept under a key. Damaged entries count as absent.
    pub fn load<T: DeserializeOwned>(&self, stage: &str, key: CacheKey) -> Option<T> {
        let (storage, name) = (self.storage.as_ref()?, entry_name(stage, key));
        let value = self.read_entry(&**storage, &name)?;
        self.touch(&name);
        Some(value)
    }

    /// Keeps an output. A cache that cannot be written is a warning, not an error.
    ///
    /// - returns whether it is kept.
    pub fn store(&self, stage: &str, key: CacheKey, value: &impl Serialize, warnings: &mut Warnings) -> bool {
        let Some(storage) = &self.storage else { return false };
        let name = entry_name(stage, key);
        let stored = self.write_entry(&**storage, &name, value).and_then(|()| {
            self.touch(&name);
            self.make_room(Some(&name))
        });
        let address = storage.address(&name);
        stored.map_err(|e| warnings.push(format!("{}: not cached: {e}", address.display()))).is_ok()
    }

    /// Loads the output of one of many files, or makes and stores it. Call [`Cache::finish_batch`] after the last of
    /// the files.
    ///
    /// - returns also whether it was loaded.
    ///
    /// # Errors
    /// Errors of `make`. A cache that cannot be written is not an error: see [`Cache::take_fault`].
    pub fn load_or_make<T: Serialize + DeserializeOwned, E>(
        &self,
        stage: &str,
        key: CacheKey,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<(T, bool), E> {
        let Some(storage) = &self.storage else { return Ok((make()?, false)) };
        let name = entry_name(stage, key);
        if let Some(value) = self.read_entry(&**storage, &name) {
            storage.touch(&name, None);
            return Ok((value, true));
        }
        let value = make()?;
        self.note_fault(self.write_entry(&**storage, &name, &value));
        Ok((value, false))
    }

    /// Frees space after a series of calls of [`Cache::load_or_make`].
    pub fn finish_batch(&self) {
        self.note_fault(self.make_room(None));
    }

    /// Takes the first fault since the last call. Outputs that could not be stored are made again by the next build.
    pub fn take_fault(&self) -> Option<BuildError> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Value of a result; `None` for an error, which is noted for [`Cache::take_fault`].
    fn note_fault<T>(&self, outcome: Result<T>) -> Option<T> {
        outcome.map_err(|e| _ = self.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(e)).ok()
    }

    /// Decodes the output in an entry; `None` if it is damaged.
    fn read_entry<T: DeserializeOwned>(&self, storage: &dyn CacheStorage, name: &str) -> Option<T> {
        let bytes = self.note_fault(storage.read(name))??;
        let (body, sum) = bytes.split_last_chunk::<16>()?;
        if checksum(name, body) != u128::from_le_bytes(*sum) {
            return None;
        }
        let config = bincode::config::standard().with_fixed_int_encoding().with_limit::<LIMIT>();
        let (value, used) = bincode::serde::decode_from_slice(body, config).ok()?;
        (used == body.len()).then_some(value)
    }

    fn write_entry(&self, storage: &dyn CacheStorage, name: &str, value: &impl Serialize) -> Result<()> {
        let config = bincode::config::standard().with_fixed_int_encoding();
        let mut bytes = bincode::serde::encode_to_vec(value, config).map_err(|e| BuildError::Format(e.to_string()))?;
        bytes.extend(checksum(name, &bytes).to_le_bytes());
        let most = self.limit_bytes.min(LIMIT as u64);
        if bytes.len() as u64 > most {
            let found = bytes.len();
            return Err(BuildError::Format(format!("it has {found} bytes, and the cache keeps {most} at most")));
        }
        storage.write(name, bytes)
    }

    /// Removes partial entries of killed processes, then the least recently used entries until the rest fits, sparing
    /// the one just written.
    fn make_room(&self, written: Option<&str>) -> Result<()> {
        let Some(storage) = self.storage.as_ref().filter(|p| p.tidy()) else { return Ok(()) };
        let entries = self.entries()?;
        let mut bytes: u64 = entries.iter().map(|e| e.bytes).sum();
        for e in entries.iter().filter(|e| Some(&*e.name) != written) {
            if bytes <= self.limit_bytes {
                break;
            }
            storage.remove(&e.name)?;
            bytes -= e.bytes;
        }
        Ok(())
    }

    /// Notes that an entry was used: now, or just after the entry used last if the clock has been set back since.
    fn touch(&self, name: &str) {
        let Some(storage) = self.storage.as_ref().filter(|p| p.is_folder()) else { return };
        let others = self.entries().unwrap_or_default();
        storage.touch(name, others.iter().rev().find(|e| e.name != name).map(|e| e.used));
    }
}

/// Checksum of an entry and its name, so that an entry stored under another name is invalid.
fn checksum(name: &str, body: &[u8]) -> u128 {
    CacheKey::hash([name.as_bytes(), body]).0
}

/// Name of the entry of a stage.
fn entry_name(stage: &str, key: CacheKey) -> String {
    format!("{stage}-{:032x}", key.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::time::Duration;

    #[test]
    fn finds_what_was_kept_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(dir.path().join("cache"));
        let key = CacheKey::for_stage("graph", &[], &1u32).unwrap();
        let mut warnings = Warnings::default();
        assert_eq!(cache.load::<Vec<f32>>("graph", key), None);
        cache.store("graph", key, &vec![1.0f32, 2.0], &mut warnings);
        assert_eq!(cache.load::<Vec<f32>>("graph", key), Some(vec![1.0, 2.0]));
        assert_eq!(cache.load::<Vec<f32>>("graph", CacheKey::for_stage("graph", &[], &2u32).unwrap()), None);
        assert_eq!(warnings, Warnings::default());

        let path_of = |key| path(&cache, key);
        let other = CacheKey::for_stage("graph", &[], &2u32).unwrap();
        std::fs::copy(path_of(key), path_of(other)).unwrap();
        assert_eq!(cache.load::<Vec<f32>>("graph", other), None, "it is whole, and another's");
        let path = path_of(key);
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[3] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(cache.load::<Vec<f32>>("graph", key), None);
    }

    /// The file of an output.
    fn path(cache: &Cache, key: CacheKey) -> PathBuf {
        cache.storage.as_ref().unwrap().address(&entry_name("graph", key))
    }

    fn key(n: u32) -> CacheKey {
        CacheKey::for_stage("graph", &[], &n).unwrap()
    }

    /// The length of an entry of 1000 bytes.
    const ENTRY: u64 = 1000 + 8 + 16;

    #[test]
    fn what_was_not_used_for_longest_makes_room() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(dir.path()).limited(3 * ENTRY);
        std::fs::write(dir.path().join("notes.txt"), [0; 9000]).unwrap();
        let mut warnings = Warnings::default();
        let mut store = |n: u32, length: usize| cache.store("graph", key(n), &vec![n as u8; length], &mut warnings);
        (0..3).for_each(|n| assert!(store(n, 1000)));
        assert!(cache.load::<Vec<u8>>("graph", key(0)).is_some(), "used again");
        store(3, 1000);
        let there = |n: u32| path(&cache, key(n)).exists();
        assert_eq!([0, 1, 2, 3].map(there), [true, false, true, true]);
        store(4, 1000);
        assert_eq!([0, 2, 3, 4].map(there), [true, false, true, true]);
        let entries = cache.entries().unwrap();
        assert_eq!(entries.iter().map(|e| e.bytes).collect::<Vec<_>>(), [ENTRY; 3]);
        assert!(entries.iter().all(|e| e.stage == "graph"));
        store(5, 4000);
        assert_eq!([0, 3, 4, 5].map(there), [true, true, true, false], "too long an entry puts nothing out");
        assert!(warnings.messages[0].contains("keeps 3072 at most"), "{warnings:?}");
        assert_eq!(cache.clear().unwrap(), (3, 3 * ENTRY));
        assert!(cache.entries().unwrap().is_empty() && dir.path().join("notes.txt").exists());
    }

    #[test]
    fn outputs_of_many_files_and_bundles_are_entries_like_others() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(dir.path()).limited(4 * ENTRY);
        let each = |n: u32| cache.load_or_make::<_, ()>("import", key(n), || Ok(vec![n as u8; 1000])).unwrap();
        for kept in [false, true] {
            for n in 0..3 {
                assert_eq!(each(n), (vec![n as u8; 1000], kept));
            }
        }
        assert_eq!(cache.load_or_make::<Vec<u8>, _>("import", key(9), || Err("bad")), Err("bad"));
        let bundle = cache.bundle(key(0)).unwrap();
        assert!(bundle.extension().is_some_and(|e| e == "throng") && !bundle.exists());
        std::fs::write(&bundle, [0; 2000]).unwrap();
        // What writes take for now may lie some milliseconds back.
        File::options().write(true).open(&bundle).unwrap().set_modified(SystemTime::now()).unwrap();
        assert_eq!(cache.entries().unwrap().iter().filter(|e| e.stage == "bundle").count(), 1);
        cache.finish_batch();
        let left: Vec<String> = cache.entries().unwrap().into_iter().map(|e| e.stage).collect();
        assert_eq!(left, ["import", "import", "bundle"], "what was used first made room");
        assert!(each(2).1 && each(1).1 && !each(0).1);
        assert_eq!(Cache::disabled().load_or_make::<_, ()>("import", key(1), || Ok(3)), Ok((3, false)));
        assert!(Cache::disabled().bundle(key(1)).is_none());
    }

    #[test]
    fn a_clock_that_was_set_back_changes_no_order() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(dir.path());
        let mut warnings = Warnings::default();
        (0..3).for_each(|n| assert!(cache.store("graph", key(n), &n, &mut warnings)));
        let tomorrow = SystemTime::now() + Duration::from_secs(86400);
        File::open(path(&cache, key(1))).unwrap().set_modified(tomorrow).unwrap();
        assert!(cache.load::<u32>("graph", key(0)).is_some());
        let order: Vec<_> = cache.entries().unwrap().into_iter().map(|e| e.name).collect();
        assert_eq!(order, [2, 1, 0].map(|n| entry_name("graph", key(n))));
    }

    #[test]
    fn builds_at_the_same_time_do_not_break_each_other() {
        let dir = tempfile::tempdir().unwrap();
        std::thread::scope(|s| {
            for t in 0..4u32 {
                let cache = Cache::in_folder(dir.path()).limited(4 * ENTRY);
                s.spawn(move || {
                    for round in 0..60 {
                        let (n, mut warnings) = ((t + round) % 7, Warnings::default());
                        let value = vec![n as u8; 1000];
                        if let Some(found) = cache.load::<Vec<u8>>("graph", key(n)) {
                            assert_eq!(found, value);
                        }
                        cache.store("graph", key(n), &value, &mut warnings);
                        assert_eq!(warnings, Warnings::default());
                        if round % 20 == 0 {
                            cache.clear().unwrap();
                        }
                    }
                });
            }
        });
        assert!(Cache::in_folder(dir.path()).entries().unwrap().len() <= 7);
    }
}
