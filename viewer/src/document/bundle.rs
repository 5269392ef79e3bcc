//! An open bundle with the views that a run needs.

use self_cell::self_cell;
use std::fmt;
use std::path::{Path, PathBuf};
use throng_runtime::blend::{BlendError, BlendSpace};
use throng_runtime::format::{AlignedBytes, BlendMeta, ClipMeta, ClipRecord};
use throng_runtime::troupe::Repertoire;
use throng_runtime::{Planar, Tables};

/// What is asked while something runs.
struct Asked<'a> {
    repertoire: Repertoire<'a>,
    blends: Vec<BlendSpace<'a>>,
}

self_cell!(
    struct Views {
        owner: Tables,
        #[covariant]
        dependent: Asked,
    }
);

/// An open bundle.
pub struct Bundle {
    path: PathBuf,
    views: Views,
}

impl fmt::Debug for Bundle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bundle").field("path", &self.path).finish_non_exhaustive()
    }
}

impl Bundle {
    /// Reads and checks a bundle.
    ///
    /// It is read, not mapped: whatever is written over the file while it is shown cannot reach what is shown.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn open(path: &Path) -> Result<Self, String> {
        let fail = |e: &dyn fmt::Display| format!("{}: {e}", path.display());
        let bytes = std::fs::read(path).map_err(|e| fail(&format!("{e}. Check the path and its permissions")))?;
        let tables = Tables::from_bytes(AlignedBytes::from_slice(&bytes)).map_err(|e| fail(&e))?;
        let views = Views::try_new(tables, |t| {
            let blends = (0..t.blends().spaces.len()).map(|space| BlendSpace::new(t.blends(), space));
            Ok(Asked { repertoire: Repertoire::new(t), blends: blends.collect::<Result<_, _>>()? })
        });
        let views = views.map_err(|e: BlendError| fail(&e))?;
        Ok(Self { path: path.to_path_buf(), views })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The tables.
    pub fn tables(&self) -> &Tables {
        self.views.borrow_owner()
    }

    /// What a step reads of them.
    pub fn repertoire(&self) -> &Repertoire<'_> {
        &self.views.borrow_dependent().repertoire
    }

    /// The blend spaces.
    pub fn blends(&self) -> &[BlendSpace<'_>] {
        &self.views.borrow_dependent().blends
    }

    /// A blend space.
    ///
    /// # Errors
    /// [`BlendError::Index`] for one that does not exist.
    pub fn blend(&self, number: usize) -> Result<&BlendSpace<'_>, BlendError> {
        let limit = self.blends().len();
        self.blends().get(number).ok_or(BlendError::Index { what: "blend space", got: number, limit })
    }

    /// Names of a blend space, its axes and its examples. [Limit: number < number of spaces]
    pub fn blend_meta(&self, number: usize) -> &BlendMeta {
        &self.tables().meta().blends[number]
    }

    /// Frames a second of the database. [Unit: Hz]
    pub fn rate_hz(&self) -> f32 {
        self.tables().meta().rate_hz as f32
    }

    /// Records and descriptions of the clips.
    pub fn clips(&self) -> impl ExactSizeIterator<Item = (&ClipRecord, &ClipMeta)> {
        self.tables().clips().iter().zip(&self.tables().meta().clips)
    }

    /// Number of the clip that a frame row lies in. [Limit: row < number of frames]
    pub fn clip_of(&self, row: u32) -> usize {
        self.tables().clips().partition_point(|c| c.first_frame <= row).saturating_sub(1)
    }

    /// Name of a clip; empty where there is no such clip.
    pub fn clip_name(&self, clip: usize) -> &str {
        self.tables().meta().clips.get(clip).map_or("", |c| &c.name)
    }

    /// Planar root of a frame row within its clip. [Limit: row < number of frames]
    pub fn planar(&self, row: u32) -> Planar {
        let [x, z, heading] = self.tables().frames()[row as usize].planar;
        Planar::new(x, z, heading)
    }

    /// What a segment plays, for people: clip and frames within it. [Limit: segment < number of segments]
    pub fn describe_segment(&self, segment: u32) -> String {
        let s = &self.tables().graph().segments[segment as usize];
        let first = self.tables().clips()[s.clip as usize].first_frame;
        let from = s.start - first;
        format!("{} {}–{}", self.clip_name(s.clip as usize), from, from + s.num_frames)
    }
}
