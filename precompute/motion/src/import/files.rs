//! Which files to read: folders and patterns become sorted lists, and an AMC file finds its skeleton.

use super::source::content_error;
use crate::ImportError;
use std::path::{Path, PathBuf};

/// Files that hold motion.
const EXTENSIONS: [&str; 2] = ["bvh", "amc"];

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// The motion files of files, folders (not their subfolders) and patterns with `*` in the last part.
///
/// The result is sorted and names each file once. Other files in a folder are passed over; a file that is named
/// itself is kept whatever its extension, so that reading it says what is wrong.
///
/// # Errors
/// [`ImportError::Io`] for a path that does not exist, [`ImportError::Content`] for one that yields no file.
pub fn expand(paths: &[PathBuf]) -> Result<Vec<PathBuf>, ImportError> {
    let mut files = Vec::new();
    for path in paths {
        let pattern = path.file_name().map(|n| n.to_string_lossy().into_owned()).filter(|n| n.contains('*'));
        let found = match pattern {
            Some(pattern) => list(path.parent().unwrap_or(Path::new("")), |name| matches(&pattern, name))?,
            None if path.is_dir() => list(path, |_| true)?,
            None => {
                std::fs::metadata(path).map_err(|source| ImportError::Io { path: path.clone(), source })?;
                vec![path.clone()]
            }
        };
        if found.is_empty() {
            let help = "Name a folder, file or pattern with `*` that holds .bvh or .amc files";
            return Err(content_error(path, "no motion file is there", help));
        }
        files.extend(found);
    }
    files.sort();
    files.dedup();
    Ok(files)
}

fn list(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>, ImportError> {
    let mut files = entries(folder)?;
    files.retain(|p| {
        let name = p.file_name().map(|n| n.to_string_lossy()).unwrap_or_default();
        EXTENSIONS.iter().any(|e| has_extension(p, e)) && wanted(&name)
    });
    Ok(files)
}

/// The files of a folder, sorted.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let shown = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let failed = |source| ImportError::Io { path: shown.to_owned(), source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(shown).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        let path = folder.join(name);
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// True where `name` is `pattern` with every `*` replaced by some text, which may be empty.
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

/// The skeleton of an AMC file: the only ASF file in its folder, or the one whose stem its own starts with.
///
/// # Errors
/// [`ImportError::Content`] where there is none or the choice is not clear, naming the candidates.
pub fn find_asf(amc: &Path) -> Result<PathBuf, ImportError> {
    let mut found = entries(amc.parent().unwrap_or(Path::new("")))?;
    found.retain(|p| has_extension(p, "asf"));
    let stem = |p: &Path| p.file_stem().map(|s| s.to_string_lossy().to_lowercase()).unwrap_or_default();
    let own = stem(amc);
    let by_stem = found.iter().filter(|p| own.starts_with(&stem(p))).max_by_key(|p| stem(p).len());
    match (by_stem, found.as_slice()) {
        (Some(path), _) => Ok(path.clone()),
        (None, [only]) => Ok(only.clone()),
        (None, []) => Err(content_error(
            amc,
            "there is no ASF file beside it",
            "Put its skeleton there, or name it with `asf` in the config",
        )),
        (None, several) => {
            let names: Vec<_> = several.iter().map(|p| p.display().to_string()).collect();
            let message = format!("several ASF files may be its skeleton: {}", names.join(", "));
            Err(content_error(amc, message, "Name the right one with `asf` in the config"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_for_any_text() {
        for (pattern, name, hit) in [
            ("walk*.bvh", "walk_1.bvh", true),
            ("*walk*.bvh", "a_walk_1.bvh", true),
            ("*walk*.bvh", "walk.bvh", true),
            ("walk*.bvh", "run.bvh", false),
            ("ab*ba", "aba", false),
            ("*", "x", true),
            ("a*b*c", "abbc", true),
            ("a*b*c", "acb", false),
            ("a.bvh", "a.bvh", true),
        ] {
            assert_eq!(matches(pattern, name), hit, "{pattern} {name}");
        }
    }

    #[test]
    fn a_skeleton_is_chosen_by_stem_and_else_refused_with_the_candidates() {
        let dir = tempfile::tempdir().unwrap();
        let put = |name: &str| std::fs::write(dir.path().join(name), "").unwrap();
        let amc = dir.path().join("02_01.amc");
        assert!(find_asf(&amc).unwrap_err().to_string().contains("no ASF file"));
        put("x.asf");
        assert!(find_asf(&amc).unwrap().ends_with("x.asf"));
        put("02.asf");
        assert!(find_asf(&amc).unwrap().ends_with("02.asf"));
        let e = find_asf(&dir.path().join("walk.amc")).unwrap_err().to_string();
        assert!(e.contains("02.asf") && e.contains("x.asf") && e.contains("`asf` in the config"), "{e}");
    }

    #[test]
    fn folders_give_their_motion_files_sorted() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["b.BVH", "a.amc", "a.asf", "c.txt"] {
            std::fs::write(dir.path().join(name), "").unwrap();
        }
        let names = |p: &Path| {
            let files = expand(&[p.to_owned(), dir.path().join("a.amc")]).unwrap();
            files.iter().map(|f| f.file_name().unwrap().to_string_lossy().into_owned()).collect::<Vec<_>>()
        };
        assert_eq!(names(dir.path()), ["a.amc", "b.BVH"]);
        assert_eq!(names(&dir.path().join("*.BVH")), ["a.amc", "b.BVH"]);
        assert!(expand(&[dir.path().join("z*")]).is_err());
    }
}
