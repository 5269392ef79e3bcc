//! Writing files so that half of one is never seen.

use crate::error::BuildError;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes a file through a temporary one in the same folder, which takes its name when all is written.
///
/// # Errors
/// [`BuildError::Io`] names the file; what stood there before stays as it was.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), BuildError> {
    check_target(path)?;
    let io = |source| BuildError::Io { path: path.to_path_buf(), source };
    let folder = folder_of(path);
    let mut file = tempfile::Builder::new().prefix(".throng-").tempfile_in(folder).map_err(io)?;
    {
        let mut buffered = BufWriter::new(file.as_file_mut());
        write(&mut buffered).map_err(io)?;
        buffered.flush().map_err(io)?;
    }
    make_readable(file.as_file()).map_err(io)?;
    file.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// Checks that a file may stand at a path, so that long work need not be done in vain.
///
/// # Errors
/// [`BuildError::Io`] where the path is a folder or a device, or its folder is not there.
pub fn check_target(path: &Path) -> Result<(), BuildError> {
    let fail =
        |kind, what: String| Err(BuildError::Io { path: path.to_path_buf(), source: std::io::Error::new(kind, what) });
    let folder = folder_of(path);
    if path.is_dir() {
        return fail(std::io::ErrorKind::IsADirectory, "expected a file to write, found a folder".into());
    }
    // The file takes the place of what was there: that must not be a device or a pipe.
    if path.exists() && !path.is_file() {
        return fail(std::io::ErrorKind::InvalidInput, "expected a file to write, found a device or a pipe".into());
    }
    if !folder.is_dir() {
        return fail(std::io::ErrorKind::NotFound, format!("there is no folder {}", folder.display()));
    }
    Ok(())
}

/// The folder a file lies in.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// Temporary files are private; the finished one has the usual permissions.
#[cfg(unix)]
fn make_readable(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_and_a_place_without_one_take_no_file() {
        let dir = tempfile::tempdir().unwrap();
        let nowhere = dir.path().join("nowhere");
        assert!(check_target(&dir.path().join("a")).is_ok());
        assert!(check_target(dir.path()).unwrap_err().to_string().contains("found a folder"));
        let e = check_target(&nowhere.join("a")).unwrap_err().to_string();
        assert!(e.contains(&format!("there is no folder {}", nowhere.display())), "{e}");
    }

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        write_atomically(&path, |w| w.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |w| {
            w.write_all(b"ne")?;
            Err(std::io::Error::other("full"))
        });
        assert!(failed.unwrap_err().to_string().contains("full"));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_not_replaced() {
        for device in ["/dev/null", "/dev/zero"] {
            let error = check_target(Path::new(device)).unwrap_err().to_string();
            assert!(error.contains(device) && error.contains("device"), "{error}");
        }
    }
}
