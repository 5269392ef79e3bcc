//! Streamed motion, which stays in the cache: a file's is read again when needed, and dropped afterwards.

use crate::cache::{Cache, Key};
use crate::provenance::FileKeys;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use throng_motion::error::BuildError;
use throng_motion::import::{self, Imported, MotionFile};
use throng_motion::retarget::Source;

/// Index of motion that stays in the cache.
pub(super) struct Lent<'a> {
    keys: FileKeys<'a>,
    cache: &'a Cache,
    /// Locations by path of the clip.
    clips: Mutex<BTreeMap<PathBuf, Whereabouts>>,
}

/// Location of the motion of a clip.
#[derive(Clone)]
struct Whereabouts {
    /// File of the clip, and its key.
    file: PathBuf,
    key: Key,
    /// Number of the clip in the file.
    number: usize,
    /// Hash of the motion.
    hash: u64,
}

impl<'a> Lent<'a> {
    pub(super) fn new(keys: FileKeys<'a>, cache: &'a Cache) -> Self {
        Self { keys, cache, clips: Mutex::default() }
    }

    /// Takes the motion out of the clips of a file after reading.
    pub(super) fn take_back(&self, file: &MotionFile, key: Key, clips: &mut [Imported]) {
        for (number, one) in clips.iter_mut().enumerate() {
            let hash = one.clip.motion_hash();
            one.clip.forget_motion();
            let at = Whereabouts { file: file.path.clone(), key, number, hash };
            self.clips.lock().unwrap_or_else(PoisonError::into_inner).insert(one.clip.path.clone(), at);
        }
    }

    fn at(&self, clip: &Imported) -> Option<Whereabouts> {
        self.clips.lock().unwrap_or_else(PoisonError::into_inner).get(&clip.clip.path).cloned()
    }

    /// Loads a clip with its motion.
    ///
    /// # Errors
    /// As [`import::read_clips`] if the cache has dropped it.
    pub(super) fn whole(&self, clip: &Imported) -> Result<Imported, BuildError> {
        let lost =
            || BuildError::Format(format!("{}: changed while it was read; start again", clip.clip.path.display()));
        let Whereabouts { file, key, number, .. } = self.at(clip).ok_or_else(lost)?;
        let read = || self.keys.read(&file, || import::read_clips(&file, self.keys.config));
        let (clips, _) = self.cache.each("import", key, read)?;
        clips.into_iter().nth(number).ok_or_else(lost)
    }

    /// See [`throng_motion::retarget::Lender`].
    ///
    /// # Errors
    /// As [`Lent::whole`].
    pub(super) fn lend(
        &self,
        clips: &[Imported],
        places: &[usize],
        look: &mut dyn FnMut(&[Source]),
    ) -> Result<(), BuildError> {
        let whole = places.iter().map(|&i| self.whole(&clips[i])).collect::<Result<Vec<_>, _>>()?;
        look(&whole.iter().map(Source::from).collect::<Vec<_>>());
        Ok(())
    }

    /// Pairs of clips that repeat each other's motion, as in [`import::ImportedSet::repeated`].
    ///
    /// # Errors
    /// As [`Lent::whole`].
    pub(super) fn repeated(&self, clips: &[Imported]) -> Result<Vec<[usize; 2]>, BuildError> {
        let hashes: Vec<u64> = clips.iter().map(|c| self.at(c).map_or(0, |at| at.hash)).collect();
        let same = |i: usize, j: usize| {
            Ok::<_, BuildError>(self.whole(&clips[i])?.clip.has_motion_of(&self.whole(&clips[j])?.clip))
        };
        import::repeated(&hashes, same)
    }
}
