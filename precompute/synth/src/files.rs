//! Synthetic clips as ordinary BVH files with sidecars, which the ordinary importer reads.

use std::path::{Path, PathBuf};
use std::{fs::create_dir_all, io::Error};
use throng_motion::annotate::sidecar::{Sidecar, SidecarTag, TimeUnit};
use throng_motion::clip::{Clip, ClipSet, ClipTag};
use throng_motion::error::{BuildError, Result};
use throng_motion::export::{self, to_raw};
use throng_motion::files::{remove, write_atomically};

/// Writes every clip as `NAME.bvh` into `folder`, which is created if missing, and its tags, if any, as the sidecar
/// `NAME.toml`.
///
/// - returns the BVH files, in the order of the clips.
///
/// # Errors
/// [`BuildError::Io`] naming the file or folder that cannot be written.
pub fn save(set: &ClipSet, folder: &Path) -> Result<Vec<PathBuf>> {
    create_dir_all(folder).map_err(|source| BuildError::Io { path: folder.to_owned(), source })?;
    let save_one = |clip: &Clip| {
        let path = folder.join(format!("{}.bvh", clip.name));
        let raw = to_raw(clip, &set.skeleton);
        write_atomically(&path, |out| export::bvh::write_clip(&raw, out))?;
        save_tags(clip, &path.with_extension("toml"))?;
        Ok(path)
    };
    set.clips.iter().map(save_one).collect()
}

/// Writes the tags of a clip as a sidecar.
fn save_tags(clip: &Clip, path: &Path) -> Result<()> {
    // Removes an outdated sidecar of an earlier clip of this name.
    let Some(sidecar) = sidecar(clip) else { return remove(path) };
    write_atomically(path, |out| {
        let text = toml::to_string(&sidecar).map_err(Error::other)?;
        out.write_all(text.as_bytes())
    })
}

/// Sidecar with a clip's tags; `None` for a clip without tags.
pub(super) fn sidecar(clip: &Clip) -> Option<Sidecar> {
    let tag = |t: &ClipTag| SidecarTag { name: t.name.clone(), start: t.range.start as f64, end: t.range.end as f64 };
    let tags: Vec<_> = clip.tags.iter().map(tag).collect();
    (!tags.is_empty()).then(|| Sidecar { unit: TimeUnit::Frames, tags, ..Sidecar::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SynthConfig, SynthSet, make_set};
    use std::collections::BTreeMap;
    use throng_core::Joint;
    use throng_motion::annotate::{AnnotateConfig, Sidecars, annotate};
    use throng_motion::import::{ImportConfig, read};
    use throng_motion::progress::Silent;

    #[test]
    fn the_ordinary_importer_reads_back_what_was_saved() {
        let folder = tempfile::tempdir().unwrap();
        let set = make_set(SynthSet::Walk, &SynthConfig { minutes: 0.5, clip_seconds: 15.0, ..SynthConfig::default() })
            .unwrap();
        let files = save(&set, &folder.path().join("walk")).unwrap();
        let config = ImportConfig { strict: true, ..ImportConfig::default() };
        let imported = read(&[folder.path().join("walk")], &config, &Silent).unwrap();
        assert_eq!(imported.clips.len(), files.len());
        for (read, made) in imported.clips.iter().zip(&set.clips) {
            assert!(read.warnings.messages.is_empty(), "{:?}", read.warnings);
            assert_eq!((read.clip.name.as_str(), read.clip.num_frames), (made.name.as_str(), made.num_frames()));
            assert!((read.metres_per_unit - 0.01).abs() < 1e-9 && read.facing.abs() < 1e-3);
            for frame in (0..made.num_frames()).step_by(40) {
                let (world, wanted) = (read.clip.world(frame), made.joint_positions(&set.skeleton, frame));
                for joint in Joint::ALL {
                    let source = read.roles.get(joint).expect("every joint has a role");
                    assert!((world[source].0 - wanted[joint.index()]).length() < 1e-3, "{}", joint.name());
                }
            }
        }
    }

    #[test]
    fn tags_come_back_by_the_sidecar() {
        let folder = tempfile::tempdir().unwrap();
        let set = make_set(SynthSet::Boxing, &SynthConfig { minutes: 0.2, ..SynthConfig::default() }).unwrap();
        let files = save(&set, folder.path()).unwrap();
        let raw = read(&files, &ImportConfig::default(), &Silent).unwrap();
        let bare = set.clips.iter().map(|c| Clip { tags: Vec::new(), ..c.clone() }).collect();
        let bare = ClipSet { skeleton: set.skeleton.clone(), clips: bare };
        let names: Vec<String> = bare.clips.iter().map(|c| c.name.clone()).collect();
        let marks = Sidecars::collect(&raw, &names, &BTreeMap::new()).unwrap();
        let annotated = annotate(&bare, &AnnotateConfig::default(), &marks).unwrap();
        assert!(set.clips[0].tags.len() > 10);
        assert_eq!(annotated.clips[0].tags, set.clips[0].tags);
    }

    #[test]
    fn names_the_place_that_cannot_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        std::fs::write(&taken, "").unwrap();
        let set = ClipSet { skeleton: throng_core::Skeleton::default(), clips: Vec::new() };
        assert!(save(&set, &taken).unwrap_err().to_string().contains("taken"));
    }
}
