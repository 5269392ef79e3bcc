//! Reading of files, with limits on their size and kind.

use crate::{Error, Result, error::ensure};
use std::fs::{File, Metadata};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Most bytes of a text that people write: scenes, settings, sidecars (16 MiB).
pub const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Most bytes of a file of motion or of a skeleton (2 GiB).
pub const MAX_MOTION_BYTES: u64 = 2 << 30;
/// Most bytes of a bundle or a world (64 GiB).
pub const MAX_BUNDLE_BYTES: u64 = 64 << 30;
/// Most bytes of a snapshot and of a file that keeps one (4 GiB).
pub const MAX_SNAPSHOT_BYTES: u64 = 4 << 30;

/// Opens a regular file, at most `max_bytes` long. Devices, pipes and folders are refused without waiting for them.
///
/// - `what`: what the file holds, with its article, for messages ("a scene").
///
/// # Errors
/// [`Error::Io`] with what the system says; [`Error::Format`] for what is no regular file or longer.
pub fn open_file(path: &Path, what: &str, max_bytes: u64) -> Result<(File, u64)> {
    let io = |source| Error::Io { path: path.to_path_buf(), source };
    let check_kind = |m: &Metadata| {
        let kind = if m.is_dir() { "a folder" } else { "a device or a pipe" };
        let why = || format!("is {kind}, expected {what} in a regular file");
        ensure(m.is_file(), || Error::Format { path: path.to_path_buf(), why: why() })
    };
    // Opening a pipe would wait for its writer, so its kind is checked before.
    check_kind(&std::fs::metadata(path).map_err(io)?)?;
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    check_kind(&metadata)?;
    check_size(path, what, metadata.len(), max_bytes)?;
    Ok((file, metadata.len()))
}

/// Reads a regular file, at most `max_bytes` long.
///
/// # Errors
/// As [`open_file`], also where memory is short.
pub fn read_file(path: &Path, what: &str, max_bytes: u64) -> Result<Vec<u8>> {
    let io = |source| Error::Io { path: path.to_path_buf(), source };
    let (file, length) = open_file(path, what, max_bytes)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize).map_err(|e| io(std::io::Error::new(ErrorKind::OutOfMemory, e)))?;
    // The file may grow while it is read.
    file.take(max_bytes + 1).read_to_end(&mut bytes).map_err(io)?;
    check_size(path, what, bytes.len() as u64, max_bytes)?;
    Ok(bytes)
}

fn check_size(path: &Path, what: &str, found: u64, max_bytes: u64) -> Result<()> {
    let [found_mb, max_mb] = [found, max_bytes].map(|bytes| bytes as f64 / 1e6);
    let why = || format!("has {found_mb:.1} MB, but {what} may have {max_mb:.0} MB at most; is this the right file?");
    ensure(found <= max_bytes, || Error::Format { path: path.to_path_buf(), why: why() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_up_to_the_limit_is_read_and_anything_else_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        std::fs::write(&path, [7; 10]).unwrap();
        assert_eq!(read_file(&path, "a scene", 10).unwrap(), [7; 10]);
        let why = |path: &Path, max| read_file(path, "a scene", max).unwrap_err().to_string();
        assert!(why(&path, 9).contains("a scene may have"), "{}", why(&path, 9));
        assert!(why(folder.path(), 9).contains("is a folder, expected a scene"));
        assert!(why(&folder.path().join("b"), 9).contains("cannot be read"));
        #[cfg(unix)]
        assert!(why(Path::new("/dev/zero"), 9).contains("is a device or a pipe"));
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_refused_without_waiting_for_its_writer() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        if made.is_ok_and(|s| s.success()) {
            assert!(read_file(&path, "a scene", 9).unwrap_err().to_string().contains("is a device or a pipe"));
        } else {
            eprintln!("skipped: there is no mkfifo");
        }
    }
}
