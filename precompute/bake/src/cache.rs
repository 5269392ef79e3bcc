//! Outputs of stages kept between builds, found again by a hash of everything they depend on.

use serde::{Serialize, de::DeserializeOwned};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use throng_base::file::read_file;
use throng_motion::error::{BuildError, Warnings};
use throng_motion::files::{remove_left, write_quickly};
use xxhash_rust::xxh3::Xxh3;

/// Part of every key: the version and a hash of the sources (`build.rs`), as other code may make something else of the
/// same input.
const EPOCH: &str = concat!("throng ", env!("CARGO_PKG_VERSION"), " ", env!("THRONG_SOURCES"));
/// Most bytes of a cached output, and most that it may ask for while it is decoded.
const LIMIT: usize = 8 << 30;

/// What names of bundles end with, in the cache as elsewhere.
const BUNDLE: &str = ".throng";

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

    /// The hash as a number.
    pub(crate) fn number(self) -> u128 {
        self.0
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
///
/// Several builds may use one folder at once: entries are written under another name first, and whoever finds one gone
/// makes it anew.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: Option<PathBuf>,
    limit_bytes: u64,
}

/// An output in a cache's folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The file.
    pub path: PathBuf,
    /// Stage that made it.
    pub stage: String,
    /// Its length (bytes).
    pub bytes: u64,
    /// When it was last read or written. Never before an entry that was used earlier, even where the clock was set back.
    pub used: SystemTime,
}

impl Cache {
    /// The folder that keeps the outputs of stages where nothing else is said.
    pub const FOLDER: &str = ".throng-cache";
    /// Bytes that a cache keeps at most unless something else is said.
    pub const LIMIT_BYTES: u64 = 5_000_000_000;

    /// Reads a size that a disk may have (GB, 0 to 1 000 000).
    ///
    /// # Errors
    /// What was expected and what was found.
    pub fn parse_gb(text: &str) -> Result<f64, String> {
        let number = text.parse::<f64>().ok().filter(|gb| (0.0..=1e6).contains(gb));
        number.ok_or_else(|| format!("expected 0 to 1000000 (GB), found `{text}`"))
    }

    /// Keeps outputs in a folder, which is made when it is first needed, up to [`Cache::LIMIT_BYTES`].
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self { folder: Some(folder.into()), limit_bytes: Self::LIMIT_BYTES }
    }

    /// Keeps nothing.
    pub fn none() -> Self {
        Self { folder: None, limit_bytes: 0 }
    }

    /// The same with another limit: what was not used for longest makes room.
    pub fn limited(self, limit_bytes: u64) -> Self {
        Self { limit_bytes, ..self }
    }

    fn path(&self, stage: &str, key: Key) -> Option<PathBuf> {
        self.folder.as_ref().map(|f| f.join(format!("{stage}-{:032x}", key.0)))
    }

    /// Where a bundle is kept that was made to be run or seen; none where nothing is kept. Asking is using it.
    pub fn bundle(&self, key: Key) -> Option<PathBuf> {
        let path = self.path("bundle", key)?;
        let path = path.with_file_name(format!("{}{BUNDLE}", path.file_name()?.to_string_lossy()));
        if path.is_file() {
            self.touch(&path);
        }
        Some(path)
    }

    /// All entries, those first that were not used for longest. A folder that is not there has none.
    ///
    /// # Errors
    /// [`BuildError::Io`] where the folder cannot be listed.
    pub fn entries(&self) -> Result<Vec<Entry>, BuildError> {
        let Some(folder) = &self.folder else { return Ok(Vec::new()) };
        let listed = match std::fs::read_dir(folder) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            listed => listed.map_err(|source| BuildError::Io { path: folder.clone(), source })?,
        };
        // Other processes may remove entries meanwhile.
        let entry = |e: std::fs::DirEntry| {
            let (name, metadata) = (e.file_name().into_string().ok()?, e.metadata().ok()?);
            let (stage, key) = name.strip_suffix(BUNDLE).unwrap_or(&name).rsplit_once('-')?;
            let ours = key.len() == 32 && key.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
            let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            let entry = Entry { path: e.path(), stage: stage.to_owned(), bytes: metadata.len(), used };
            (ours && metadata.is_file()).then_some(entry)
        };
        let mut entries: Vec<Entry> = listed.flatten().filter_map(entry).collect();
        entries.sort_by(|a, b| a.used.cmp(&b.used).then_with(|| a.path.cmp(&b.path)));
        Ok(entries)
    }

    /// Removes every entry, and nothing else; returns how many, and their length (bytes).
    ///
    /// # Errors
    /// [`BuildError::Io`] names the first that cannot be removed.
    pub fn clear(&self) -> Result<(usize, u64), BuildError> {
        let entries = self.entries()?;
        entries.iter().try_for_each(|e| remove(&e.path))?;
        Ok((entries.len(), entries.iter().map(|e| e.bytes).sum()))
    }

    /// True where anything is kept at all.
    pub(crate) fn is_on(&self) -> bool {
        self.folder.is_some()
    }

    /// True where something is kept under a key; whether it is whole is not looked at.
    pub(crate) fn has(&self, stage: &str, key: Key) -> bool {
        self.path(stage, key).is_some_and(|path| path.is_file())
    }

    /// The output kept under a key. Damaged entries count as absent.
    pub fn load<T: DeserializeOwned>(&self, stage: &str, key: Key) -> Option<T> {
        let path = self.path(stage, key)?;
        let value = read(&path)?;
        self.touch(&path);
        Some(value)
    }

    /// Keeps an output. A cache that cannot be written is a warning, not an error.
    ///
    /// - returns whether it is kept.
    pub fn store(&self, stage: &str, key: Key, value: &impl Serialize, warnings: &mut Warnings) -> bool {
        let Some(path) = self.path(stage, key) else { return false };
        let stored = self.write(&path, value).and_then(|()| {
            self.touch(&path);
            self.make_room(Some(&path))
        });
        match stored {
            Ok(()) => true,
            Err(e) => {
                warnings.push(format!("{}: not cached: {e}", path.display()));
                false
            }
        }
    }

    /// What is kept of one of many files, or what `make` makes of it, which is then kept. [`Cache::settle`] is to follow
    /// when all of them were asked for.
    ///
    /// - returns whether it was kept before, too.
    ///
    /// # Errors
    /// Those of `make`; a cache that cannot be written is none.
    pub fn each<T: Serialize + DeserializeOwned, E>(
        &self,
        stage: &str,
        key: Key,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<(T, bool), E> {
        let Some(path) = self.path(stage, key) else { return Ok((make()?, false)) };
        if let Some(value) = read(&path) {
            use_now(&path, None);
            return Ok((value, true));
        }
        let value = make()?;
        // Without it, the file is read again next time.
        _ = self.write(&path, &value);
        Ok((value, false))
    }

    /// Makes room after [`Cache::each`] was asked for many files.
    pub fn settle(&self) {
        // What is not removed now is when the next output is kept.
        _ = self.make_room(None);
    }

    fn write(&self, path: &Path, value: &impl Serialize) -> Result<(), BuildError> {
        let config = bincode::config::standard().with_fixed_int_encoding();
        let body = bincode::serde::encode_to_vec(value, config).map_err(|e| BuildError::Format(e.to_string()))?;
        let bytes = body.len() as u64 + 16;
        let most = self.limit_bytes.min(LIMIT as u64);
        if bytes > most {
            return Err(BuildError::Format(format!("it has {bytes} bytes, and the cache keeps {most} at most")));
        }
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|source| BuildError::Io { path: folder.to_path_buf(), source })?;
        }
        write_quickly(path, |w| {
            w.write_all(&body)?;
            w.write_all(&content_hash(&body).to_le_bytes())
        })
    }

    /// Removes what killed processes left, and what was not used for longest until all fits, but not the entry that was just
    /// written.
    fn make_room(&self, written: Option<&Path>) -> Result<(), BuildError> {
        self.folder.iter().for_each(|folder| remove_left(folder));
        let entries = self.entries()?;
        let mut bytes: u64 = entries.iter().map(|e| e.bytes).sum();
        for e in entries.iter().filter(|e| Some(&*e.path) != written) {
            if bytes <= self.limit_bytes {
                break;
            }
            remove(&e.path)?;
            bytes -= e.bytes;
        }
        Ok(())
    }

    /// Notes that an entry was used: now, or just after the one used last where the clock was set back since.
    fn touch(&self, path: &Path) {
        let others = self.entries().unwrap_or_default();
        let last = others.iter().rev().find(|e| e.path != path).map(|e| e.used + Duration::from_micros(1));
        use_now(path, last);
    }
}

/// Notes that an entry was used now, or at a later time.
fn use_now(path: &Path, later: Option<SystemTime>) {
    let now = SystemTime::now();
    // The order is all that is lost where this fails, as in a folder that may only be read.
    _ = File::open(path).and_then(|f| f.set_modified(later.map_or(now, |l| l.max(now))));
}

/// The output in a file, where it is whole.
fn read<T: DeserializeOwned>(path: &Path) -> Option<T> {
    let bytes = read_file(path, "a cached output", LIMIT as u64).ok()?;
    let (body, sum) = bytes.split_last_chunk::<16>()?;
    if content_hash(body) != u128::from_le_bytes(*sum) {
        return None;
    }
    let config = bincode::config::standard().with_fixed_int_encoding().with_limit::<LIMIT>();
    let (value, used) = bincode::serde::decode_from_slice(body, config).ok()?;
    (used == body.len()).then_some(value)
}

/// Removes a file, unless another process was faster.
fn remove(path: &Path) -> Result<(), BuildError> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(BuildError::Io { path: path.to_path_buf(), source })
        }
        _ => Ok(()),
    }
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

    fn key(n: u32) -> Key {
        Key::of("graph", &[], &n).unwrap()
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
        let there = |n: u32| cache.path("graph", key(n)).unwrap().exists();
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
        let each = |n: u32| cache.each::<_, ()>("import", key(n), || Ok(vec![n as u8; 1000])).unwrap();
        for kept in [false, true] {
            for n in 0..3 {
                assert_eq!(each(n), (vec![n as u8; 1000], kept));
            }
        }
        assert_eq!(cache.each::<Vec<u8>, _>("import", key(9), || Err("bad")), Err("bad"));
        let bundle = cache.bundle(key(0)).unwrap();
        assert!(bundle.extension().is_some_and(|e| e == "throng") && !bundle.exists());
        std::fs::write(&bundle, [0; 2000]).unwrap();
        // What writes take for now may lie some milliseconds back.
        File::options().write(true).open(&bundle).unwrap().set_modified(SystemTime::now()).unwrap();
        assert_eq!(cache.entries().unwrap().iter().filter(|e| e.stage == "bundle").count(), 1);
        cache.settle();
        let left: Vec<String> = cache.entries().unwrap().into_iter().map(|e| e.stage).collect();
        assert_eq!(left, ["import", "import", "bundle"], "what was used first made room");
        assert!(each(2).1 && each(1).1 && !each(0).1);
        assert_eq!(Cache::none().each::<_, ()>("import", key(1), || Ok(3)), Ok((3, false)));
        assert!(Cache::none().bundle(key(1)).is_none());
    }

    #[test]
    fn a_clock_that_was_set_back_changes_no_order() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(dir.path());
        let mut warnings = Warnings::default();
        (0..3).for_each(|n| assert!(cache.store("graph", key(n), &n, &mut warnings)));
        let tomorrow = SystemTime::now() + Duration::from_secs(86400);
        File::open(cache.path("graph", key(1)).unwrap()).unwrap().set_modified(tomorrow).unwrap();
        assert!(cache.load::<u32>("graph", key(0)).is_some());
        let order: Vec<_> = cache.entries().unwrap().into_iter().map(|e| e.path).collect();
        assert_eq!(order, [2, 1, 0].map(|n| cache.path("graph", key(n)).unwrap()));
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
