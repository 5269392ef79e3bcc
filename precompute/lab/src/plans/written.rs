//! What a plan writes: clips, and who carried what beside them.

use serde::Serialize;
use std::path::{Path, PathBuf};
use throng_motion::error::BuildError;
use throng_motion::{Clip, export, files};
use throng_planner::task::{ActorClip, Attachment, Event, Task, TaskOutcome};

/// What stands beside a clip.
#[derive(Serialize)]
struct Objects<'a> {
    attachments: &'a [Attachment],
    events: &'a [Event],
}

/// CLIP.bvh, CLIP-2.bvh, ...
fn numbered(out: &Path, i: usize) -> PathBuf {
    match i {
        0 => out.to_path_buf(),
        _ => beside(out, &format!("-{}.bvh", i + 1)),
    }
}

/// A file beside another one: its name with another end.
fn beside(out: &Path, end: &str) -> PathBuf {
    let stem = out.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    out.with_file_name(stem + end)
}

/// Writes the clips that changed, the first one always, and what was carried.
///
/// - `out`: the first character's clip; the others' stand beside it, with their names.
/// - `number`: of the motion, from 0: further ones have it in their names.
/// - returns what was written.
///
/// # Errors
/// Where a file cannot be written; what stood in its place stays as it was.
pub fn write(
    task: &Task,
    clips: &[ActorClip],
    outcome: &TaskOutcome,
    out: &Path,
    number: usize,
) -> Result<Vec<PathBuf>, BuildError> {
    let (out, mut written) = (numbered(out, number), Vec::new());
    for (i, [before, after]) in outcome.clips.iter().enumerate() {
        if i > 0 && before == after {
            continue;
        }
        let path = if i == 0 { out.clone() } else { beside(&out, &format!(".{}.bvh", task.characters[i].name)) };
        save(after, &clips[i], &path)?;
        written.push(path);
    }
    let objects = Objects { attachments: &outcome.attachments, events: &outcome.events };
    let path = beside(&out, ".objects.json");
    if objects.attachments.is_empty() && objects.events.is_empty() {
        // That of an earlier run is not of this clip.
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

fn save(clip: &Clip, actor: &ActorClip, path: &Path) -> Result<(), BuildError> {
    let raw = export::to_raw(clip, &actor.skeleton);
    files::write_atomically(path, |w| export::bvh::write(&raw, w))
}
