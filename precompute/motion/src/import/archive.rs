//! Files in `.zip` archives, which are named as if the archive were a folder: `clips.zip/walk/slow.bvh`. An archive may lie in
//! another one, but no third one in that.

use super::{content_error, has_extension};
use crate::error::{ImportError, ensure};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::{borrow::Cow, fs::File, time::SystemTime};
use throng_base::file::{MAX_BUNDLE_BYTES, open_file};
use zip::ZipArchive;

/// Extension of archives.
pub const EXTENSION: &str = "zip";

/// The archive that a path leads into, and the file in it; `None` where it leads into none.
pub fn split(path: &Path) -> Option<(PathBuf, String)> {
    split_at(path, |a| has_extension(a, EXTENSION) && (a.is_file() || is_inner_archive(a)))
}

/// True for an archive in an archive on the disk.
fn is_inner_archive(path: &Path) -> bool {
    let is_outer = |a: &Path| has_extension(a, EXTENSION) && a.is_file();
    let holds = |(outer, member): (PathBuf, String)| open(&outer).is_ok_and(|z| z.index_for_name(&member).is_some());
    split_at(path, is_outer).is_some_and(holds)
}

/// The file that is used as a folder in a path, and the rest of the path behind it, with `/`.
pub(super) fn split_at(path: &Path, is_outer: impl Fn(&Path) -> bool) -> Option<(PathBuf, String)> {
    let outer = path.ancestors().skip(1).find(|a| is_outer(a))?;
    let parts = path.strip_prefix(outer).ok()?.components();
    let inner = parts.map(|c| c.as_os_str().to_string_lossy().into_owned()).collect::<Vec<_>>().join("/");
    Some((outer.to_path_buf(), inner))
}

/// True for a file, in a folder or in an archive.
pub fn is_file(path: &Path) -> bool {
    path.is_file()
        || split(path)
            .is_some_and(|(archive, member)| open(&archive).is_ok_and(|z| z.index_for_name(&member).is_some()))
}

/// Names of the files in an archive, in its order. Those that lead out of it, such as `/etc/x.bvh` or `../x.bvh`, are left out.
///
/// # Errors
/// [`ImportError`] for a file that is no such archive.
pub fn members(archive: &Path) -> Result<Vec<String>, ImportError> {
    let zip = open(archive)?;
    Ok(zip.file_names().flatten().filter(|n| is_within(n)).map(Cow::into_owned).collect())
}

/// True for the name of a file that stays within its archive, on any system.
fn is_within(member: &str) -> bool {
    member.split('/').all(|part| !matches!(part, "" | "." | "..") && !part.contains(['\\', ':', '\0']))
}

/// Reads a file, in a folder or in an archive, at most `max_bytes` long.
///
/// - `what`: contents of the file, with an article, for messages.
///
/// # Errors
/// [`ImportError`] naming the file.
pub fn read_file(path: &Path, what: &str, max_bytes: u64) -> Result<Vec<u8>, ImportError> {
    if split(path).is_none() {
        return throng_base::file::read_file(path, what, max_bytes).map_err(plain);
    }
    let mut bytes = Vec::new();
    copy_file(path, what, max_bytes, &mut bytes)?;
    Ok(bytes)
}

/// Length of a file by which limits on its contents are set (bytes). In an archive that is at most [`COUNTED_PER_PACKED`] times
/// its packed length, as zeros and spaces are packed to nearly nothing.
pub(super) fn counted_bytes(path: &Path, num_bytes: usize) -> usize {
    let packed =
        split(path).and_then(|(archive, member)| Some(open(&archive).ok()?.by_name(&member).ok()?.compressed_size()));
    let most = packed.map_or(u64::MAX, |packed| packed.saturating_mul(COUNTED_PER_PACKED).saturating_add(1 << 16));
    num_bytes.min(usize::try_from(most).unwrap_or(usize::MAX))
}

/// Reads a file as [`read_file`] does, to a writer.
///
/// # Errors
/// Errors of [`read_file`].
pub fn copy_file(path: &Path, what: &str, max_bytes: u64, out: &mut dyn Write) -> Result<(), ImportError> {
    let failed = |source| ImportError::Io { path: path.to_path_buf(), source };
    let Some((archive, member)) = split(path) else {
        let (file, _) = open_file(path, what, max_bytes).map_err(plain)?;
        // The file may grow while it is read.
        return std::io::copy(&mut file.take(max_bytes), out).map(|_| ()).map_err(failed);
    };
    // The length that an archive names need not be true. Motion is packed to about a tenth, numbers that repeat to a hundredth.
    let limits = PackedLimits { max_bytes, a_byte: MOST_PACKED, free: 64 << 20 };
    copy_member(open(&archive)?, &member, path, what, limits, out)
}

/// Most bytes that a file of an archive may have.
struct PackedLimits {
    max_bytes: u64,
    /// For each byte that it takes in the archive.
    a_byte: u64,
    /// Beyond these (bytes).
    free: u64,
}

/// Writes a file of an archive.
fn copy_member(
    mut zip: ZipArchive<SharedArchive>,
    member: &str,
    path: &Path,
    what: &str,
    limits: PackedLimits,
    out: &mut dyn Write,
) -> Result<(), ImportError> {
    let found = zip.by_name(member).map_err(|e| {
        let help = "Write the archive anew, with ordinary compression and without a password";
        content_error(path, format!("it cannot be read from its archive: {e}"), help)
    })?;
    let packed = found.compressed_size();
    let most = limits.max_bytes.min(packed.saturating_mul(limits.a_byte).saturating_add(limits.free));
    let failed = |source| ImportError::Io { path: path.to_path_buf(), source };
    let copied = std::io::copy(&mut found.take(most + 1), out).map_err(failed)?;
    if copied > most {
        let mb = |bytes: u64| bytes as f64 / 1e6;
        let message = format!(
            "{:.1} MB in the archive become more than the {:.0} MB that {what} of that length may have",
            mb(packed),
            mb(most)
        );
        return Err(content_error(path, message, "Check that it is the right file, or unpack it"));
    }
    Ok(())
}

/// An archive that several readers share.
#[derive(Clone)]
struct SharedArchive {
    bytes: ArchiveBytes,
    length: u64,
    at: u64,
}

/// The bytes of an archive: in a file, or in memory where it lies in another archive.
#[derive(Clone)]
enum ArchiveBytes {
    File(Arc<File>),
    Memory(Arc<[u8]>),
}

impl Read for SharedArchive {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let read = match &self.bytes {
            ArchiveBytes::Memory(bytes) => bytes.get(self.at as usize..).unwrap_or_default().read(out)?,
            #[cfg(unix)]
            ArchiveBytes::File(file) => std::os::unix::fs::FileExt::read_at(&**file, out, self.at)?,
            #[cfg(windows)]
            ArchiveBytes::File(file) => std::os::windows::fs::FileExt::seek_read(&**file, out, self.at)?,
            #[cfg(not(any(unix, windows)))]
            ArchiveBytes::File(file) => {
                (&**file).seek(SeekFrom::Start(self.at))?;
                (&**file).read(out)?
            }
        };
        self.at += read as u64;
        Ok(read)
    }
}

impl Seek for SharedArchive {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
        };
        self.at = at.ok_or(ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}

/// The archive that was opened last. A build looks at all files of one, and would read its whole list each time.
struct LastArchive {
    path: PathBuf,
    /// Length of the file: another one may have its place by now.
    length: u64,
    written: Option<SystemTime>,
    /// The last bytes, where the list is.
    tail: Vec<u8>,
    zip: ZipArchive<SharedArchive>,
}

/// Most bytes that a file of an archive may have for each byte that it takes there, beyond 64 MiB.
const MOST_PACKED: u64 = 200;
/// Bytes of a file that count for each byte that it takes in an archive, beyond 64 KiB. Motion is packed to about a tenth.
const COUNTED_PER_PACKED: u64 = 32;
/// Most bytes of an archive in another one for each byte that it takes there, beyond 1 MiB: it is packed already.
const MOST_PACKED_TWICE: u64 = 4;
/// Longest archive in another one (bytes): it is held in memory.
const MAX_INNER_BYTES: u64 = 1 << 30;
/// Length of the end of an archive that is compared (bytes).
const TAIL: u64 = 32 << 10;
/// Most files of an archive.
const MAX_MEMBERS: usize = 100_000;

fn open(archive: &Path) -> Result<ZipArchive<SharedArchive>, ImportError> {
    static LAST: Mutex<Option<LastArchive>> = Mutex::new(None);
    static LAST_INNER: Mutex<Option<LastArchive>> = Mutex::new(None);
    let is_outer = |a: &Path| has_extension(a, EXTENSION) && a.is_file();
    let inner = (!archive.is_file()).then(|| split_at(archive, is_outer)).flatten();
    let on_disk = inner.as_ref().map_or(archive, |(outer, _)| outer);
    let (file, length) = open_file(on_disk, "an archive", MAX_BUNDLE_BYTES).map_err(plain)?;
    let written = file.metadata().and_then(|m| m.modified()).ok();
    let mut tail = Vec::new();
    let bytes = ArchiveBytes::File(Arc::new(file));
    let mut shared = SharedArchive { bytes, length, at: length.saturating_sub(TAIL) };
    let read = shared.clone().take(TAIL).read_to_end(&mut tail);
    read.map_err(|source| ImportError::Io { path: archive.to_path_buf(), source })?;
    let last = if inner.is_some() { &LAST_INNER } else { &LAST };
    let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
    let is_same = |l: &&LastArchive| l.path == archive && l.length == length && l.written == written && l.tail == tail;
    if let Some(last) = last.as_ref().filter(is_same) {
        return Ok(last.zip.clone());
    }
    if let Some((outer, member)) = &inner {
        let mut bytes = Vec::new();
        let limits = PackedLimits { max_bytes: MAX_INNER_BYTES, a_byte: MOST_PACKED_TWICE, free: 1 << 20 };
        copy_member(open(outer)?, member, archive, "an archive", limits, &mut bytes)?;
        shared = SharedArchive { length: bytes.len() as u64, at: 0, bytes: ArchiveBytes::Memory(bytes.into()) };
    }
    let zip = check_archive(archive, shared)?;
    *last = Some(LastArchive { path: archive.to_path_buf(), length, written, tail, zip: zip.clone() });
    Ok(zip)
}

/// Reads the list of an archive, and checks it.
fn check_archive(archive: &Path, file: SharedArchive) -> Result<ZipArchive<SharedArchive>, ImportError> {
    let mut zip = ZipArchive::new(file).map_err(|e| {
        let help = "Unpack it, or write it anew as an ordinary .zip archive";
        content_error(archive, format!("it is no archive that can be read: {e}"), help)
    })?;
    let message = || format!("it has {} files, expected {MAX_MEMBERS} at most", zip.len());
    ensure(zip.len() <= MAX_MEMBERS, || content_error(archive, message(), "Unpack it, or split it"))?;
    // A short archive could name one long file thousands of times.
    let mut ranges: Vec<[u64; 2]> = Vec::with_capacity(zip.len());
    for i in 0..zip.len() {
        let Ok(member) = zip.by_index_raw(i) else { continue };
        let (begin, length) = (member.data_start().unwrap_or(0), member.compressed_size());
        ranges.extend((length > 0).then(|| [begin, begin.saturating_add(length)]));
    }
    ranges.sort_unstable();
    if ranges.windows(2).any(|w| w[0][1] > w[1][0]) {
        let message = "two of its files lie in the same place".to_owned();
        return Err(content_error(archive, message, "Unpack it, or write it anew as an ordinary .zip archive"));
    }
    Ok(zip)
}

fn plain(e: throng_base::Error) -> ImportError {
    match e {
        throng_base::Error::Io { path, source } => ImportError::Io { path, source },
        e => e.into(),
    }
}
