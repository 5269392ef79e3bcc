//! Streamed motion, which stays in the cache: a file's is read again when needed, and dropped afterwards.

use crate::cache::{Cache, CacheKey};
use crate::provenance::FileKeys;
use std::sync::{Mutex, PoisonError};
use std::{collections::BTreeMap, path::PathBuf};
use throng_motion::import::{self, ImportedClip, MotionFile};
use throng_motion::{BuildError, Result, retarget::RetargetSource};

/// Index of motion that stays in the cache.
pub(super) struct StreamedMotion<'a> {
    keys: FileKeys<'a>,
    cache: &'a Cache,
    /// Locations by path of the clip.
    clips: Mutex<BTreeMap<PathBuf, MotionLocation>>,
}

/// Location of the motion of a clip.
#[derive(Clone)]
struct MotionLocation {
    /// File of the clip, and its key.
    file: PathBuf,
    key: CacheKey,
    /// Number of the clip in the file.
    number: usize,
    /// Hash of the motion.
    hash: u64,
}

impl<'a> StreamedMotion<'a> {
    pub(super) fn new(keys: FileKeys<'a>, cache: &'a Cache) -> Self {
        Self { keys, cache, clips: Mutex::default() }
    }

    /// Takes the motion out of the clips of a file after reading.
    pub(super) fn release_motion(&self, file: &MotionFile, key: CacheKey, clips: &mut [ImportedClip]) {
        for (number, one) in clips.iter_mut().enumerate() {
            let hash = one.clip.motion_hash();
            (one.clip.translations, one.clip.rotations) = (Vec::new(), Vec::new());
            let at = MotionLocation { file: file.path.clone(), key, number, hash };
            self.clips.lock().unwrap_or_else(PoisonError::into_inner).insert(one.clip.path.clone(), at);
        }
    }

    fn location_of(&self, clip: &ImportedClip) -> Option<MotionLocation> {
        self.clips.lock().unwrap_or_else(PoisonError::into_inner).get(&clip.clip.path).cloned()
    }

    /// Loads a clip with its motion.
    ///
    /// # Errors
    /// As [`import::read_clips`] if the cache has dropped it.
    pub(super) fn load_clip(&self, clip: &ImportedClip) -> Result<ImportedClip> {
        let lost =
            || BuildError::Format(format!("{}: changed while it was read; start again", clip.clip.path.display()));
        let MotionLocation { file, key, number, .. } = self.location_of(clip).ok_or_else(lost)?;
        let read = || self.keys.read_file(&file, || import::read_clips(&file, self.keys.config));
        let (clips, _) = self.cache.load_or_make("import", key, read)?;
        clips.into_iter().nth(number).ok_or_else(lost)
    }

    /// See [`throng_motion::retarget::ClipProvider`].
    ///
    /// # Errors
    /// As [`StreamedMotion::load_clip`].
    pub(super) fn with_motion(
        &self,
        clips: &[ImportedClip],
        places: &[usize],
        measure: &mut dyn FnMut(&[RetargetSource]),
    ) -> Result<()> {
        let whole = places.iter().map(|&i| self.load_clip(&clips[i])).collect::<Result<Vec<_>, _>>()?;
        measure(&whole.iter().map(RetargetSource::from).collect::<Vec<_>>());
        Ok(())
    }

    /// Pairs of clips that repeat each other's motion, as in [`import::ImportedSet::repeated`].
    ///
    /// # Errors
    /// As [`StreamedMotion::load_clip`].
    pub(super) fn repeated_clips(&self, clips: &[ImportedClip]) -> Result<Vec<[usize; 2]>> {
        let hashes: Vec<u64> = clips.iter().map(|c| self.location_of(c).map_or(0, |at| at.hash)).collect();
        let same = |i: usize, j: usize| {
            Ok::<_, BuildError>(self.load_clip(&clips[i])?.clip.has_motion_of(&self.load_clip(&clips[j])?.clip))
        };
        import::repeated(&hashes, same)
    }
}
