//! Synthetic clips as ordinary BVH files, which the ordinary importer reads.

use super::raw::to_raw;
use crate::clip::ClipSet;
use crate::error::BuildError;
use crate::import::bvh_write;
use std::fs::{File, create_dir_all};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes every clip as `NAME.bvh` into `folder`, which is made if it is not there.
///
/// - returns the files, in the order of the clips.
///
/// # Errors
/// [`BuildError::Io`] naming the file or folder that cannot be written.
pub fn save(set: &ClipSet, folder: &Path) -> Result<Vec<PathBuf>, BuildError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| BuildError::Io { path, source }
    };
    create_dir_all(folder).map_err(failed(folder))?;
    let mut files = Vec::with_capacity(set.clips.len());
    for clip in &set.clips {
        let path = folder.join(format!("{}.bvh", clip.name));
        let mut out = BufWriter::new(File::create(&path).map_err(failed(&path))?);
        bvh_write::write(&to_raw(clip, &set.skeleton), &mut out).map_err(failed(&path))?;
        out.flush().map_err(failed(&path))?;
        files.push(path);
    }
    Ok(files)
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
