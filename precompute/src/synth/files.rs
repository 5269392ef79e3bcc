//! Synthetic clips as ordinary BVH files, which the ordinary importer reads.

use crate::clip::{Clip, ClipSet};
use crate::error::BuildError;
use crate::files::write_atomically;
use crate::import::bvh_write;
use crate::retarget::to_raw;
use std::fs::create_dir_all;
use std::path::{Path, PathBuf};

/// Writes every clip as `NAME.bvh` into `folder`, which is made if it is not there.
///
/// - returns the files, in the order of the clips.
///
/// # Errors
/// [`BuildError::Io`] naming the file or folder that cannot be written.
pub fn save(set: &ClipSet, folder: &Path) -> Result<Vec<PathBuf>, BuildError> {
    create_dir_all(folder).map_err(|source| BuildError::Io { path: folder.to_owned(), source })?;
    let save_one = |clip: &Clip| {
        let path = folder.join(format!("{}.bvh", clip.name));
        let raw = to_raw(clip, &set.skeleton);
        write_atomically(&path, |out| bvh_write::write(&raw, out))?;
        Ok(path)
    };
    set.clips.iter().map(save_one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::{ImportConfig, read};
    use crate::progress::Silent;
    use crate::synth::{SynthConfig, walk};
    use throng_runtime::Joint;

    #[test]
    fn the_ordinary_importer_reads_back_what_was_saved() {
        let folder = tempfile::tempdir().unwrap();
        let set = walk(&SynthConfig { minutes: 0.5, clip_seconds: 15.0, ..SynthConfig::default() }).unwrap();
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
    fn names_the_place_that_cannot_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        std::fs::write(&taken, "").unwrap();
        let set = ClipSet { skeleton: throng_runtime::Skeleton::default(), clips: Vec::new() };
        assert!(save(&set, &taken).unwrap_err().to_string().contains("taken"));
    }
}
