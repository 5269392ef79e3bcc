//! Notices when the open file changes on disk.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Interval between two checks of a file.
const EVERY: Duration = Duration::from_millis(500);

/// Stamp of a version of a file: modification time and length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileStamp {
    modified: SystemTime,
    len: u64,
}

impl FileStamp {
    /// Stamp of the present file; none if there is no file.
    pub fn read(path: &Path) -> Option<Self> {
        let meta = std::fs::metadata(path).ok()?;
        Some(Self { modified: meta.modified().ok()?, len: meta.len() })
    }

    /// Combined stamp of several files: differs if any of them has changed.
    pub fn combined(first: Option<Self>, more: &[PathBuf]) -> Option<Self> {
        more.iter().try_fold(first?, |a, path| {
            let b = Self::read(path)?;
            Some(Self { modified: a.modified.max(b.modified), len: a.len.wrapping_add(b.len) })
        })
    }
}

/// Checks a file at intervals.
///
/// A version is reported once, after two checks in a row have seen it, so that a file that is still being written is
/// not read.
#[derive(Debug)]
pub struct FileWatch {
    reported: Option<FileStamp>,
    seen: Option<FileStamp>,
    checked: Instant,
}

impl FileWatch {
    /// Watches from a version on that is known already.
    pub fn starting_at(stamp: Option<FileStamp>) -> Self {
        Self { reported: stamp, seen: stamp, checked: Instant::now() }
    }

    /// True once for every new version of a file, or of the files that belong to it.
    pub fn has_changed(&mut self, path: &Path, more: &[PathBuf]) -> bool {
        if self.checked.elapsed() < EVERY {
            return false;
        }
        self.checked = Instant::now();
        self.observe(FileStamp::combined(FileStamp::read(path), more))
    }

    fn observe(&mut self, now: Option<FileStamp>) -> bool {
        let settled = now.is_some() && now == self.seen && now != self.reported;
        self.seen = now;
        if settled {
            self.reported = now;
        }
        settled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(len: u64) -> Option<FileStamp> {
        Some(FileStamp { modified: SystemTime::UNIX_EPOCH, len })
    }

    #[test]
    fn a_new_version_is_reported_once_and_only_when_it_has_settled() {
        let mut watch = FileWatch::starting_at(stamp(1));
        let seen = [stamp(1), stamp(2), stamp(3), stamp(3), stamp(3), None, stamp(3), stamp(3), stamp(4), stamp(4)];
        let reports = seen.map(|s| watch.observe(s));
        assert_eq!(reports, [false, false, false, true, false, false, false, false, false, true]);
    }
}
