//! Files in `.zip` archives, which are named as if the archive were a folder: `clips.zip/walk/slow.bvh`.

use super::files::has_extension;
use super::source::content_error;
use crate::ImportError;
use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use throng_base::file::{MAX_BUNDLE_BYTES, open_file};
use zip::ZipArchive;

/// What names of archives end with.
pub const EXTENSION: &str = "zip";

/// The archive that a path leads into, and the file in it; nothing where it leads into none.
pub fn split(path: &Path) -> Option<(PathBuf, String)> {
    split_at(path, |a| has_extension(a, EXTENSION) && a.is_file())
}

/// The file that stands as a folder in a path, and what is named in it, with `/`.
pub(super) fn split_at(path: &Path, is_outer: impl Fn(&Path) -> bool) -> Option<(PathBuf, String)> {
    let outer = path.ancestors().skip(1).find(|a| is_outer(a))?;
    let parts = path.strip_prefix(outer).ok()?.components();
    let inner = parts.map(|c| c.as_os_str().to_string_lossy().into_owned()).collect::<Vec<_>>().join("/");
    Some((outer.to_path_buf(), inner))
}

/// True for a file, in a folder or in an archive.
pub fn is_file(path: &Path) -> bool {
    path.is_file()
        || split(path).is_some_and(|(archive, member)| members(&archive).is_ok_and(|all| all.contains(&member)))
}

/// Names of the files in an archive, in its order.
///
/// # Errors
/// [`ImportError`] for a file that is no such archive.
pub fn members(archive: &Path) -> Result<Vec<String>, ImportError> {
    let zip = open(archive)?;
    Ok(zip.file_names().flatten().filter(|n| !n.ends_with('/')).map(Cow::into_owned).collect())
}

/// Reads a file, in a folder or in an archive, at most `max_bytes` long.
///
/// - `what`: what the file holds, with its article, for messages.
///
/// # Errors
/// [`ImportError`] naming the file.
pub fn read_file(path: &Path, what: &str, max_bytes: u64) -> Result<Vec<u8>, ImportError> {
    let Some((archive, member)) = split(path) else {
        return throng_base::file::read_file(path, what, max_bytes).map_err(plain);
    };
    let mut zip = open(&archive)?;
    let found = zip.by_name(&member).map_err(|e| {
        let help = "Write the archive anew, with ordinary compression and without a password";
        content_error(path, format!("it cannot be read from its archive: {e}"), help)
    })?;
    let mut bytes = Vec::new();
    // What an archive says of lengths need not be true.
    let read = found.take(max_bytes + 1).read_to_end(&mut bytes);
    read.map_err(|source| ImportError::Io { path: path.to_path_buf(), source })?;
    if bytes.len() as u64 > max_bytes {
        let message = format!("it has more than the {:.0} MB that {what} may have", max_bytes as f64 / 1e6);
        return Err(content_error(path, message, "Check that it is the right file"));
    }
    Ok(bytes)
}

fn open(archive: &Path) -> Result<ZipArchive<BufReader<File>>, ImportError> {
    let (file, _) = open_file(archive, "an archive", MAX_BUNDLE_BYTES).map_err(plain)?;
    ZipArchive::new(BufReader::new(file)).map_err(|e| {
        let help = "Unpack it, or write it anew as an ordinary .zip archive";
        content_error(archive, format!("it is no archive that can be read: {e}"), help)
    })
}

fn plain(e: throng_base::Error) -> ImportError {
    match e {
        throng_base::Error::Io { path, source } => ImportError::Io { path, source },
        e => e.into(),
    }
}
