//! Formats that hold one character: a file for each.

use super::Take;
use crate::error::Result;
use crate::files::write_atomically;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a file for each actor who is ever present: `NAME-7.bvh` of number 7, or `NAME.bvh` where there is one.
///
/// - `write`: writes the actor of a number.
/// - returns the files.
///
/// # Errors
/// Errors of [`write_atomically`].
pub fn write_each_actor(
    take: &Take,
    out: &Path,
    write: impl Fn(usize, &mut dyn Write) -> io::Result<()>,
) -> Result<Vec<PathBuf>> {
    let there = (0..take.actors().len()).filter(|&a| !take.actors()[a].present_frames.is_empty());
    let file_of = |a: usize| match take.actors() {
        [_] => out.to_path_buf(),
        actors => {
            let stem = out.file_stem().unwrap_or_default().to_string_lossy();
            let extension = out.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
            out.with_file_name(format!("{stem}-{}{extension}", actors[a].number))
        }
    };
    there.map(|a| write_atomically(&file_of(a), |w| write(a, w)).map(|()| file_of(a))).collect()
}
