//! Writes files so that a half-written one is never visible.
//!
//! A file is written under a temporary name in its folder, and renamed when it is whole. While it is written it is
//! locked: the system takes the lock from a process that ends, however it ends. So the next one that writes in that
//! folder knows what killed processes left there, whatever clocks and process numbers say, and removes it.

use crate::error::{BuildError, Result, ensure};
use std::fs::{File, TryLockError};
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Names of temporary files begin with this.
const PREFIX: &str = ".throng-";
/// And end with this.
const SUFFIX: &str = ".tmp";
/// Number of random letters between the two.
const RANDOM: usize = 8;
/// Most links that lead from one to another before the file.
const MAX_LINKS: usize = 40;

/// Writes a file through a temporary one in the same folder, which takes its name when all of it is on the disk. A
/// symbolic link stays, and the file that it leads to is written.
///
/// # Errors
/// [`BuildError::Io`] names the file; what stood there before stays as it was.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    if let Ok(real) = resolve_links(path) {
        remove_leftovers(folder_of(&real));
    }
    let done = replace(path, write, |file| file.sync_all())?;
    // The name is on the disk when the folder is. Not every file system can be asked for that.
    const NOT_ASKED: [ErrorKind; 3] = [ErrorKind::InvalidInput, ErrorKind::Unsupported, ErrorKind::PermissionDenied];
    match sync_folder(folder_of(&done)) {
        Err(source) if !NOT_ASKED.contains(&source.kind()) => Err(BuildError::Io { path: path.to_path_buf(), source }),
        _ => Ok(()),
    }
}

/// Writes as [`write_atomically`] does, without waiting for the disk and without a search for the remains of killed processes:
/// for many files that are checked when they are read, and can be made again.
///
/// # Errors
/// Errors of [`write_atomically`].
pub fn write_quickly(path: &Path, write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    replace(path, write, |_| Ok(())).map(|_| ())
}

/// - returns the file that was written: the target of links.
fn replace(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    finish: impl FnOnce(&File) -> std::io::Result<()>,
) -> Result<PathBuf> {
    check_target(path)?;
    let io = |source| BuildError::Io { path: path.to_path_buf(), source };
    let real = resolve_links(path).map_err(io)?;
    let folder = folder_of(&real);
    let mut file = temporary(folder).map_err(|e| io(without_file(folder, &e)))?;
    {
        let mut buffered = BufWriter::new(file.as_file_mut());
        write(&mut buffered).map_err(io)?;
        buffered.flush().map_err(io)?;
    }
    // Whoever may not read the file that is replaced may not read the new one.
    if let Ok(old) = std::fs::metadata(&real) {
        file.as_file().set_permissions(old.permissions()).map_err(io)?;
    }
    finish(file.as_file()).map_err(io)?;
    file.persist(&real).map_err(|e| io(e.error))?;
    Ok(real)
}

/// The error of a folder that takes no file: with the system's message, without the temporary name.
fn without_file(folder: &Path, e: &std::io::Error) -> std::io::Error {
    let plain = e
        .raw_os_error()
        .map_or_else(|| e.kind().to_string(), |code| std::io::Error::from_raw_os_error(code).to_string());
    std::io::Error::new(e.kind(), format!("the folder {} takes no file: {plain}", folder.display()))
}

/// A new file that is locked, with the permissions that new files have (the umask).
fn temporary(folder: &Path) -> std::io::Result<NamedTempFile> {
    loop {
        let file = new_file(folder)?;
        match file.as_file().try_lock() {
            // Another process may have taken it for a leftover, before it was locked.
            Ok(()) if !file.path().exists() => {}
            Err(TryLockError::WouldBlock) => {}
            // Some file systems have no locks; there, nothing is removed either.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(file),
        }
    }
}

fn new_file(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX).rand_bytes(RANDOM);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Removes temporary files that no process writes any more.
pub fn remove_leftovers(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten().filter(|e| is_temporary(&e.file_name().to_string_lossy())) {
        let path = entry.path();
        if !entry.file_type().is_ok_and(|t| t.is_file()) {
            continue;
        }
        if let Ok(file) = File::open(&path)
            && file.try_lock().is_ok()
        {
            _ = std::fs::remove_file(&path);
        }
    }
}

fn is_temporary(name: &str) -> bool {
    let random = name.strip_prefix(PREFIX).and_then(|n| n.strip_suffix(SUFFIX));
    random.is_some_and(|r| r.len() == RANDOM && r.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// The target of symbolic links; it need not exist.
fn resolve_links(path: &Path) -> std::io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        if !path.symlink_metadata().is_ok_and(|m| m.is_symlink()) {
            return Ok(path);
        }
        path = folder_of(&path).join(std::fs::read_link(&path)?);
    }
    Err(std::io::Error::other(format!("it leads through more than {MAX_LINKS} links")))
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> std::io::Result<()> {
    File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> std::io::Result<()> {
    Ok(())
}

/// Removes a file, where there is one.
///
/// # Errors
/// [`BuildError::Io`] names the file.
pub fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(BuildError::Io { path: path.to_path_buf(), source }),
        _ => Ok(()),
    }
}

/// Checks that a file may stand at a path, so that long work need not be done in vain.
///
/// # Errors
/// [`BuildError::Io`] where the path is a folder or a device, or its folder is not there or takes no file.
pub fn check_target(path: &Path) -> Result<()> {
    let io = |source| BuildError::Io { path: path.to_path_buf(), source };
    let fail = |kind, what: String| Err(io(std::io::Error::new(kind, what)));
    // The file takes the place of what was there: that must not be a device or a pipe. Asked once, as others may remove it
    // meanwhile.
    match std::fs::metadata(path) {
        Ok(m) if m.is_dir() => return fail(ErrorKind::IsADirectory, "expected a file to write, found a folder".into()),
        Ok(m) if !m.is_file() => {
            return fail(ErrorKind::InvalidInput, "expected a file to write, found a device or a pipe".into());
        }
        _ => {}
    }
    let real = resolve_links(path).map_err(io)?;
    let folder = folder_of(&real);
    if !folder.is_dir() {
        return fail(ErrorKind::NotFound, format!("there is no folder {}", folder.display()));
    }
    new_file(folder).map(|_| ()).map_err(|e| io(without_file(folder, &e)))
}

/// Checks as [`check_target`] does each of several files to write; none may be a file that is read, or another one of them.
///
/// # Errors
/// As [`check_target`]; [`BuildError::Config`] naming a file that is meant twice.
pub fn check_targets<'a>(
    out: impl IntoIterator<Item = &'a PathBuf>,
    read: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<()> {
    let real = |path: &PathBuf| std::fs::canonicalize(path).or_else(|_| std::path::absolute(path));
    let mut taken: Vec<PathBuf> = read.into_iter().filter_map(|path| real(path).ok()).collect();
    for path in out {
        check_target(path)?;
        let file = real(path).map_err(|source| BuildError::Io { path: path.clone(), source })?;
        let why = "it is to be written, and is read or written by the same command. Write elsewhere";
        ensure(!taken.contains(&file), || BuildError::Config { message: format!("{}: {why}", path.display()) })?;
        taken.push(file);
    }
    Ok(())
}

/// Checks as [`check_target`] does; a file at the path has to be of the same kind, too, or empty, so that no config and no
/// motion file is overwritten.
///
/// - `magic`: first bytes of files of the kind; `what`: the kind, with its article.
///
/// # Errors
/// Errors of [`check_target`]; [`BuildError::Config`] where a file of another kind is at the path.
pub fn check_replaced(path: &Path, magic: &[u8], what: &str) -> Result<()> {
    check_target(path)?;
    let mut found = Vec::new();
    let read = File::open(path).and_then(|file| file.take(magic.len() as u64).read_to_end(&mut found));
    let why = format!("it is there and is not {what}. Remove it, or write elsewhere");
    let is_kind = read.is_err() || found.is_empty() || found == magic;
    ensure(is_kind, || BuildError::Config { message: format!("{}: {why}", path.display()) })
}

/// The folder a file lies in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn no_file_is_meant_twice() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::write(at("walk.bvh"), "x").unwrap();
        let (walk, again) = (at("walk.bvh"), at("sub/../walk.bvh"));
        std::fs::create_dir(at("sub")).unwrap();
        let [new, other] = ["a.png", "b.png"].map(at);
        assert!(check_targets([&new, &other], [&walk, &at("absent.bvh")]).is_ok());
        for (out, read) in [(vec![&again], vec![&walk]), (vec![&walk], vec![&again]), (vec![&new, &new], vec![])] {
            let e = check_targets(out.iter().copied(), read).unwrap_err().to_string();
            assert!(e.contains("written") && e.contains("Write elsewhere"), "{e}");
        }
    }

    #[test]
    fn a_folder_and_a_place_without_one_take_no_file() {
        let dir = tempfile::tempdir().unwrap();
        let nowhere = dir.path().join("nowhere");
        assert!(check_target(&dir.path().join("a")).is_ok());
        assert!(names(dir.path()).is_empty(), "a check leaves nothing");
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
            Err(ErrorKind::StorageFull.into())
        });
        let e = failed.unwrap_err().to_string();
        assert!(e.contains("no storage space") && e.ends_with("Free some space, or write elsewhere."), "{e}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(dir.path()), ["a"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_others_may_not_read_stays_so() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        let mode = || std::fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        write_atomically(&path, |w| w.write_all(b"old")).unwrap();
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).unwrap();
        write_atomically(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!((mode(), std::fs::read(&path).unwrap()), (0o600, b"new".to_vec()));
    }

    #[test]
    fn what_killed_runs_left_is_removed_and_what_is_being_written_is_not() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str| std::fs::write(dir.path().join(name), "half").unwrap();
        // The first is ours and not locked: as a killed process leaves it. The others are not ours.
        let others = [".throng-abc.tmp", ".throng-abcd1234", "a.tmp", "throng-abcd1234.tmp"];
        others.iter().for_each(|n| write(n));
        write(".throng-abcd1234.tmp");
        let path = dir.path().join("b");
        write_atomically(&dir.path().join("a"), |w| {
            // Another one, while this is open.
            write_atomically(&path, |w| w.write_all(b"b")).unwrap();
            w.write_all(b"a")
        })
        .unwrap();
        let mut expected = [&["a", "b"][..], &others].concat();
        expected.sort_unstable();
        assert_eq!(names(dir.path()), expected);
        assert_eq!(std::fs::read(dir.path().join("a")).unwrap(), b"a");
    }

    #[test]
    fn many_writers_of_one_file_leave_one_whole_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::thread::scope(|s| {
            for t in 0..4u8 {
                let path = &path;
                s.spawn(move || {
                    (0..50).for_each(|_| write_quickly(path, |w| w.write_all(&[t; 1000])).expect("written"));
                });
            }
        });
        let found = std::fs::read(&path).unwrap();
        assert!(found.len() == 1000 && found.iter().all(|b| *b == found[0]));
        assert_eq!(names(dir.path()), ["a"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_what_it_leads_to_is_written() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir(at("deep")).unwrap();
        std::os::unix::fs::symlink("deep/real", at("link")).unwrap();
        for text in ["one", "two"] {
            write_atomically(&at("link"), |w| w.write_all(text.as_bytes())).unwrap();
            assert_eq!(std::fs::read_to_string(at("deep/real")).unwrap(), text);
            assert!(at("link").symlink_metadata().unwrap().is_symlink());
        }
        std::os::unix::fs::symlink("round", at("round")).unwrap();
        let e = write_atomically(&at("round"), |_| Ok(())).unwrap_err().to_string();
        assert!(e.contains("more than 40 links"), "{e}");
    }

    #[cfg(unix)]
    #[test]
    fn a_file_has_the_permissions_of_new_files() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let mode = |name: &str| std::fs::metadata(dir.path().join(name)).unwrap().permissions().mode();
        std::fs::write(dir.path().join("plain"), "").unwrap();
        write_atomically(&dir.path().join("a"), |_| Ok(())).unwrap();
        assert_eq!(mode("a"), mode("plain"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_folder_that_takes_no_file_is_named() {
        // Nobody, not even root, makes files there.
        for e in [check_target(Path::new("/proc/self/a")), write_atomically(Path::new("/proc/self/a"), |_| Ok(()))] {
            let e = e.unwrap_err().to_string();
            assert!(e.starts_with("/proc/self/a: the folder /proc/self takes no file: "), "{e}");
            assert!(!e.contains(".throng-"), "{e}");
        }
    }

    #[test]
    fn another_kind_of_file_is_not_replaced() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str, bytes: &[u8]| {
            let path = dir.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            check_replaced(&path, b"THRONG", "a bundle")
        };
        assert!(check_replaced(&dir.path().join("new"), b"THRONG", "a bundle").is_ok());
        assert!(at("old", b"THRONG 3").is_ok() && at("empty", b"").is_ok());
        for text in [&b"name = \"a\""[..], b"THR"] {
            let e = at("a.toml", text).unwrap_err().to_string();
            assert!(e.contains("a.toml: it is there and is not a bundle"), "{e}");
        }
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
