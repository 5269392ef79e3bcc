//! Choice of the files to read: folders, patterns and archives become sorted lists, and an AMC file finds its skeleton.

use super::{archive, content_error, gltf};
use crate::ImportError;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use throng_base::file::MAX_MOTION_BYTES;

/// Extensions of motion files. Help texts, the viewer and tests repeat them; files that a format reads beside its own belong in
/// `read_along`, which caches trust.
pub const EXTENSIONS: [&str; 6] = ["bvh", "amc", "npz", "glb", "gltf", "fbx"];
/// These extensions in words.
pub const FORMATS: &str = ".bvh, .amc, .npz, .glb, .gltf or .fbx";
/// True where this program reads FBX.
pub const READS_FBX: bool = cfg!(feature = "fbx");
/// Extensions of files that may hold several clips.
const MULTI_CLIP_EXTENSIONS: [&str; 4] = ["bvh", "fbx", "glb", "gltf"];
/// Most levels of folders that are searched; more is a loop.
const MAX_DEPTH: usize = 64;
/// Stands for any number of folders in a pattern.
const ANY_FOLDERS: &str = "**";

/// A motion file, and the name that its clip gets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MotionFile {
    /// The file; one in an archive has a path as if the archive were a folder, a clip of several as if their file were.
    pub path: PathBuf,
    /// Its path without extension as seen from the folder, archive or pattern that was given, with `/`.
    pub name: String,
}

impl MotionFile {
    /// Name of a clip that was read from the file.
    pub fn clip_name(&self, clip: &Path) -> String {
        match clip.strip_prefix(&self.path) {
            Ok(within) if !within.as_os_str().is_empty() => format!("{}/{}", self.name, slashed(within)),
            _ => self.name.clone(),
        }
    }
}

/// The file that holds a clip of several, and the clip's name in it: `dances.glb/Run` is `Run` in `dances.glb`. `None` for the
/// path of a file.
pub fn clip_in_file(path: &Path) -> Option<(PathBuf, String)> {
    archive::split_at(path, |p| may_hold_several(p) && archive::is_file(p))
}

pub(super) fn may_hold_several(path: &Path) -> bool {
    MULTI_CLIP_EXTENSIONS.iter().any(|e| has_extension(path, e))
}

/// True where a file's name ends with an extension, in letters of either case.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// True for the name of a motion file.
pub fn is_motion(path: &Path) -> bool {
    EXTENSIONS.iter().any(|e| has_extension(path, e))
}

/// The paths of [`find_motion_files`].
///
/// # Errors
/// As [`find_motion_files`].
pub fn expand(paths: &[PathBuf]) -> Result<Vec<PathBuf>, ImportError> {
    Ok(find_motion_files(paths)?.into_iter().map(|f| f.path).collect())
}

/// The motion files of files, folders, `.zip` archives and patterns.
///
/// Folders and archives are searched to any depth; archives in folders, too. In a pattern `*` stands for any text within
/// a name, and `**` for any number of folders. The result is sorted by path and names each file once. Other files, and
/// files and folders whose names begin with a dot, are passed over; a file that is named itself is kept whatever its
/// extension, so that reading it says what is wrong.
///
/// # Errors
/// [`ImportError::Io`] for a path that does not exist, [`ImportError::Content`] for one that yields no file.
pub fn find_motion_files(paths: &[PathBuf]) -> Result<Vec<MotionFile>, ImportError> {
    let mut files = Vec::new();
    for path in paths {
        let (base, found) = find_under_path(path)?;
        if found.is_empty() {
            let help =
                format!("Name a folder, an archive (.zip), a file or a pattern with `*` that holds {FORMATS} files");
            return Err(content_error(path, "no motion file is there", &help));
        }
        files.extend(found.into_iter().map(|path| MotionFile { name: clip_name_of(&path, &base), path }));
    }
    files.sort_by(|a: &MotionFile, b| a.path.cmp(&b.path));
    files.dedup_by(|a, b| a.path == b.path);
    Ok(files)
}

/// The files of one path, and the folder that their names are relative to.
fn find_under_path(path: &Path) -> Result<(PathBuf, Vec<PathBuf>), ImportError> {
    let parent = |of: &Path| of.parent().unwrap_or(Path::new("")).to_path_buf();
    let mut search = FileSearch::default();
    // A file may have a star in its name.
    if path.to_string_lossy().contains('*') && !path.exists() {
        let parts: Vec<Component> = path.components().collect();
        let has_star = |c: &Component| c.as_os_str().to_string_lossy().contains('*');
        let first = parts.iter().position(has_star).unwrap_or(parts.len());
        let base: PathBuf = parts[..first].iter().collect();
        let mut pattern: Vec<String> =
            parts[first..].iter().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
        // Several in a row are no more than one.
        pattern.dedup_by(|a, b| a == b && a == ANY_FOLDERS);
        search.find_matching(&base, &pattern, 0)?;
        return Ok((base, search.found));
    }
    if path.is_dir() {
        search.find_in_folder(path, 0)?;
        return Ok((path.to_path_buf(), search.found));
    }
    if has_extension(path, archive::EXTENSION) && archive::is_file(path) {
        return Ok((path.to_path_buf(), motion_in(path)?));
    }
    if let Some((file, _)) = clip_in_file(path) {
        return Ok((parent(&file), vec![path.to_path_buf()]));
    }
    if !archive::is_file(path) {
        std::fs::metadata(path).map_err(|source| ImportError::Io { path: path.to_path_buf(), source })?;
    }
    Ok((parent(path), vec![path.to_path_buf()]))
}

/// Name of a clip.
fn clip_name_of(path: &Path, base: &Path) -> String {
    let within = |path: &Path| slashed(&path.strip_prefix(base).unwrap_or(path).with_extension(""));
    clip_in_file(path).map_or_else(|| within(path), |(file, clip)| format!("{}/{clip}", within(&file)))
}

/// A path with `/` between its parts.
fn slashed(path: &Path) -> String {
    let parts = path.components().map(|c| c.as_os_str().to_string_lossy().into_owned());
    parts.collect::<Vec<_>>().join("/")
}

/// The motion files of an archive and of those in it, as if they were folders; archives in those are listed themselves.
fn motion_in(path: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let is_seen = |member: &String| !member.split('/').any(is_hidden);
    let mut found = Vec::new();
    for member in archive::members(path)?.into_iter().filter(is_seen).map(|m| path.join(m)) {
        let is_archive = has_extension(&member, archive::EXTENSION);
        if is_archive && path.is_file() {
            // Reading one that is damaged, or lies too deep, reports it.
            found.extend(motion_in(&member).unwrap_or_else(|_| vec![member]));
        } else if is_archive || is_motion(&member) {
            found.push(member);
        }
    }
    Ok(found)
}

/// Names that systems and programs reserve for themselves.
fn is_hidden(name: &str) -> bool {
    name.starts_with('.') || name == "__MACOSX"
}

/// A search under way.
#[derive(Default)]
struct FileSearch {
    found: Vec<PathBuf>,
    /// Folders that were searched, with links resolved, as links may lead back.
    searched: BTreeSet<PathBuf>,
    /// Folders that were matched, each with the number of parts of the pattern that were left: several `**` lead to a folder with
    /// the same parts left in many ways.
    matched: BTreeSet<(PathBuf, usize)>,
}

impl FileSearch {
    /// Finds every motion file of a folder.
    fn find_in_folder(&mut self, folder: &Path, depth: usize) -> Result<(), ImportError> {
        let real = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
        if depth > MAX_DEPTH || !self.searched.insert(real) {
            return Ok(());
        }
        for path in visible_entries(folder)? {
            if path.is_dir() {
                self.find_in_folder(&path, depth + 1)?;
            } else {
                self.keep_file(path);
            }
        }
        Ok(())
    }

    /// Keeps a motion file, or those of an archive.
    fn keep_file(&mut self, path: PathBuf) {
        if has_extension(&path, archive::EXTENSION) && path.is_file() {
            match motion_in(&path) {
                Ok(all) => self.found.extend(all),
                // Reading the archive later reports the fault; the other files are not affected.
                Err(_) => self.found.push(path),
            }
        } else if is_motion(&path) && path.is_file() {
            self.found.push(path);
        }
    }

    /// Finds the files that match a pattern, part by part.
    fn find_matching(&mut self, folder: &Path, pattern: &[String], depth: usize) -> Result<(), ImportError> {
        let Some((part, rest)) = pattern.split_first() else { return Ok(()) };
        if !self.matched.insert((folder.to_owned(), pattern.len())) {
            return Ok(());
        }
        if part == ANY_FOLDERS && rest.is_empty() {
            return self.find_in_folder(folder, depth);
        }
        if part == ANY_FOLDERS {
            self.find_matching(folder, rest, depth)?;
        }
        for path in visible_entries(folder)? {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            let enters = path.is_dir() && depth < MAX_DEPTH;
            if part == ANY_FOLDERS {
                // Links may lead back: they are not followed over any number of folders.
                if enters && !path.is_symlink() {
                    self.find_matching(&path, pattern, depth + 1)?;
                }
            } else if matches(part, &name) {
                match rest {
                    [] if path.is_dir() => {}
                    [] => self.keep_file(path),
                    _ if enters => self.find_matching(&path, rest, depth + 1)?,
                    _ => {}
                }
            }
        }
        Ok(())
    }
}

/// Files and folders in a folder that are not hidden, sorted.
fn visible_entries(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let mut all = folder_entries(folder)?;
    all.retain(|p| !p.file_name().is_some_and(|n| is_hidden(&n.to_string_lossy())));
    Ok(all)
}

/// Contents of a folder, or of the same place in an archive, sorted.
fn folder_entries(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    if let Some((archive, within)) = archive::split(&folder.join("x")) {
        let within = within.strip_suffix('x').unwrap_or_default().to_owned();
        let beside = |m: &String| m.strip_prefix(&within).is_some_and(|name| !name.contains('/'));
        let mut members: Vec<PathBuf> =
            archive::members(&archive)?.into_iter().filter(beside).map(|m| archive.join(m)).collect();
        members.sort();
        return Ok(members);
    }
    let shown = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let failed = |source| ImportError::Io { path: shown.to_owned(), source };
    let entries = std::fs::read_dir(shown).map_err(failed)?;
    let names = entries.map(|entry| entry.map(|e| folder.join(e.file_name())));
    let mut found = names.collect::<Result<Vec<_>, _>>().map_err(failed)?;
    found.sort();
    Ok(found)
}

/// True where `clip_name_of` is `pattern` with every `*` replaced by some text, which may be empty.
pub fn matches(pattern: &str, name: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else { return pattern == name };
    let Some(mut name) = name.strip_prefix(first) else { return false };
    let (middle, last) = rest.rsplit_once('*').unwrap_or(("", rest));
    for part in middle.split('*') {
        match name.find(part) {
            Some(at) => name = &name[at + part.len()..],
            None => return false,
        }
    }
    name.ends_with(last)
}

/// The other files that are read with a motion file: the skeleton of an AMC file, the numbers of a glTF file.
///
/// - `asf`: the skeleton of all AMC files, where it is given.
pub fn read_along(path: &Path, asf: Option<&Path>) -> Vec<PathBuf> {
    let is = |extension: &str| has_extension(path, extension);
    let mut all = match asf {
        None if is("amc") => find_asf(path).into_iter().collect(),
        _ if is("gltf") || is("glb") => {
            let bytes = archive::read_file(path, "motion", MAX_MOTION_BYTES);
            bytes.and_then(|bytes| gltf::buffer_files(&bytes, path)).unwrap_or_default()
        }
        _ => Vec::new(),
    };
    // A missing file is reported where the motion file is read.
    all.retain(|p| archive::is_file(p));
    all
}

/// The skeleton of an AMC file: the only ASF file in its folder, or the one whose stem its own starts with.
///
/// # Errors
/// [`ImportError::Content`] where there is none or the choice is not clear, naming the candidates.
pub fn find_asf(amc: &Path) -> Result<PathBuf, ImportError> {
    let mut found = folder_entries(amc.parent().unwrap_or(Path::new("")))?;
    found.retain(|p| has_extension(p, "asf") && archive::is_file(p));
    let stem = |p: &Path| p.file_stem().map(|s| s.to_string_lossy().to_lowercase()).unwrap_or_default();
    let own = stem(amc);
    let by_stem = found.iter().filter(|p| own.starts_with(&stem(p))).max_by_key(|p| stem(p).len());
    match (by_stem, found.as_slice()) {
        (Some(path), _) => Ok(path.clone()),
        (None, [only]) => Ok(only.clone()),
        (None, []) => {
            let help = "Put its skeleton there, or name it with `asf` in the config";
            Err(content_error(amc, "there is no ASF file beside it", help))
        }
        (None, several) => {
            let names: Vec<_> = several.iter().map(|p| p.display().to_string()).collect();
            let message = format!("several ASF files may be its skeleton: {}", names.join(", "));
            let help = "Begin its name with that of its skeleton, or put the two in a folder of their own";
            Err(content_error(amc, message, help))
        }
    }
}

#[cfg(test)]
mod tests;
