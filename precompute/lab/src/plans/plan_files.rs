//! Output files of a plan: clips, and the carried objects beside them.

use serde::Serialize;
use std::path::{Path, PathBuf};
use throng_motion::{error::Result, export, files};
use throng_planner::task::{ActorClip, Attachment, Task, TaskEvent, TaskOutcome};

/// Objects file of a clip.
#[derive(Serialize)]
struct ClipObjects<'a> {
    attachments: &'a [Attachment],
    events: &'a [TaskEvent],
}

/// A path in the same folder: the file's stem, followed by `end`.
fn sibling_path(out: &Path, end: &str) -> PathBuf {
    let stem = out.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    out.with_file_name(stem + end)
}

/// Writes the changed clips, the first one always, and the carried objects.
///
/// - `out`: file of the first character's clip; the others are written beside it, with the characters' names.
/// - `n`: number of the motion, from 0; it is part of the file names except for the first.
/// - returns the files written.
///
/// # Errors
/// If a file cannot be written; an existing file in its place stays as it was.
pub fn write_plan(task: &Task, clips: &[ActorClip], found: &TaskOutcome, out: &Path, n: usize) -> Result<Vec<PathBuf>> {
    // Numbered file names: CLIP.bvh, CLIP-2.bvh, ...
    let out = if n == 0 { out.to_path_buf() } else { sibling_path(out, &format!("-{}.bvh", n + 1)) };
    let mut written = Vec::new();
    for (i, [before, after]) in found.clips.iter().enumerate() {
        if i > 0 && before == after {
            continue;
        }
        let path = if i == 0 { out.clone() } else { sibling_path(&out, &format!(".{}.bvh", task.characters[i].name)) };
        let raw = export::to_raw(after, &clips[i].skeleton);
        files::write_atomically(&path, |w| export::bvh::write_clip(&raw, w))?;
        written.push(path);
    }
    let objects = ClipObjects { attachments: &found.attachments, events: &found.events };
    let path = sibling_path(&out, ".objects.json");
    if objects.attachments.is_empty() && objects.events.is_empty() {
        // The objects file of an earlier run does not belong to this clip.
        files::remove(&path)?;
    } else {
        files::write_atomically(&path, |w| {
            serde_json::to_writer_pretty(&mut *w, &objects)?;
            writeln!(w)
        })?;
        written.push(path);
    }
    Ok(written)
}
