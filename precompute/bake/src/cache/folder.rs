//! Entries as files of a folder.

use super::{CacheStorage, LIMIT};
use std::fs::{DirEntry, File};
use std::time::{Duration, SystemTime};
use std::{io::ErrorKind, path::PathBuf};
use throng_base::file::read_file;
use throng_motion::files::{remove_leftovers, write_quickly};
use throng_motion::{BuildError, Result};

/// A folder that holds entries, created when first needed.
#[derive(Debug)]
pub(super) struct FolderStorage {
    at: PathBuf,
}

impl FolderStorage {
    pub(super) fn new(at: PathBuf) -> Self {
        Self { at }
    }

    fn io(&self, name: &str) -> impl FnOnce(std::io::Error) -> BuildError {
        let path = self.at.join(name);
        move |source| BuildError::Io { path, source }
    }
}

impl CacheStorage for FolderStorage {
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>> {
        // A fault in reading is reported when writing fails too.
        Ok(read_file(&self.at.join(name), "a cached output", LIMIT as u64).ok())
    }

    fn has_entry(&self, name: &str) -> Result<bool> {
        Ok(self.at.join(name).is_file())
    }

    fn write(&self, name: &str, bytes: Vec<u8>) -> Result<()> {
        std::fs::create_dir_all(&self.at).map_err(self.io(""))?;
        write_quickly(&self.at.join(name), |w| w.write_all(&bytes))
    }

    fn remove(&self, name: &str) -> Result<()> {
        match std::fs::remove_file(self.at.join(name)) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(self.io(name)(e)),
            _ => Ok(()),
        }
    }

    fn list(&self) -> Result<Vec<(String, u64, SystemTime)>> {
        let listed = match std::fs::read_dir(&self.at) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            listed => listed.map_err(self.io(""))?,
        };
        // Other processes may remove files meanwhile.
        let file = |e: DirEntry| {
            let (name, metadata) = (e.file_name().into_string().ok()?, e.metadata().ok()?);
            let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            metadata.is_file().then_some((name, metadata.len(), used))
        };
        Ok(listed.flatten().filter_map(file).collect())
    }

    fn touch(&self, name: &str, last: Option<SystemTime>) {
        let now = SystemTime::now();
        let used = last.map_or(now, |last| now.max(last + Duration::from_micros(1)));
        // A failure, as in a read-only folder, loses only the order of use.
        _ = File::open(self.at.join(name)).and_then(|f| f.set_modified(used));
    }

    fn tidy(&self) -> bool {
        remove_leftovers(&self.at);
        true
    }

    fn address(&self, name: &str) -> PathBuf {
        self.at.join(name)
    }

    fn is_folder(&self) -> bool {
        true
    }
}
