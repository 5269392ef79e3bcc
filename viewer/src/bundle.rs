//! An open bundle with the views that a run needs.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use throng_core::characters::{MotionSet, SampleJob};
use throng_core::format::{BlendMeta, ClipMeta, ClipRecord, MADE_TAG};
use throng_core::{Bundle, Error, FormatError, Mat3x4, NUM_JOINTS, Planar, blend::BlendSpace};

/// An open bundle.
#[derive(Debug)]
pub struct OpenBundle {
    /// The file.
    pub path: PathBuf,
    tables: Bundle,
    /// Views of the tables that a step of the simulation reads.
    pub motion_set: MotionSet,
    /// The blend spaces.
    pub blends: Vec<BlendSpace>,
    rows: OnceLock<Arc<[Mat3x4]>>,
}

impl OpenBundle {
    /// Reads and checks a bundle.
    ///
    /// The file is read, not mapped: overwriting it while it is open does not change what is shown.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn open(path: &Path) -> Result<Self, String> {
        let fail = |e: &dyn fmt::Display| format!("{}: {e}", path.display());
        let tables = Bundle::open(path).map_err(|e| match e {
            FormatError::Io { .. } => e.to_string(),
            e => fail(&e),
        })?;
        let blends = (0..tables.blends().spaces.len()).map(|space| BlendSpace::new(tables.blends(), space));
        let blends = blends.collect::<Result<_, _>>().map_err(|e| fail(&e))?;
        let (path, motion_set) = (path.to_path_buf(), MotionSet::new(&tables));
        Ok(Self { path, motion_set, blends, tables, rows: OnceLock::new() })
    }

    /// The tables.
    pub fn tables(&self) -> &Bundle {
        &self.tables
    }

    /// Poses of all frame rows, made when they are first asked for: joints in model space (rows * NUM_JOINTS).
    pub fn row_poses(&self) -> &Arc<[Mat3x4]> {
        self.rows.get_or_init(|| {
            let rows: Vec<u32> = (0..self.tables.frames().len() as u32).collect();
            self.sample_rows(&rows).unwrap_or_default().into()
        })
    }

    /// Poses of frame rows, from their planar roots (number of rows * NUM_JOINTS); none if a row does not exist.
    pub fn sample_rows(&self, rows: &[u32]) -> Option<Vec<Mat3x4>> {
        let mut matrices = vec![Mat3x4::default(); rows.len() * NUM_JOINTS];
        let (motion_set, ratios) = (&self.motion_set, &vec![0.0; rows.len()]);
        SampleJob { motion_set, frames: rows, ratios, matrices: &mut matrices }.run().ok()?;
        Some(matrices)
    }

    /// A blend space.
    ///
    /// # Errors
    /// [`Error::Index`] for one that does not exist.
    pub fn blend(&self, number: usize) -> Result<&BlendSpace, Error> {
        let limit = self.blends.len();
        self.blends.get(number).ok_or(Error::Index { what: "blend space", who: None, got: number, limit })
    }

    /// Names of a blend space, its axes and its examples (number < number of spaces).
    pub fn blend_meta(&self, number: usize) -> &BlendMeta {
        &self.tables().meta().blends[number]
    }

    /// Frames a second of the database (Hz).
    pub fn rate_hz(&self) -> f32 {
        self.tables().meta().rate_hz as f32
    }

    /// Records and descriptions of the clips.
    pub fn clips(&self) -> impl ExactSizeIterator<Item = (&ClipRecord, &ClipMeta)> {
        self.tables().clips().iter().zip(&self.tables().meta().clips)
    }

    /// Number of the clip that a frame row lies in (row < number of frames).
    pub fn clip_of(&self, row: u32) -> usize {
        self.tables().clips().partition_point(|c| c.first_frame <= row).saturating_sub(1)
    }

    /// Name of a clip; empty if there is no such clip.
    pub fn clip_name(&self, clip: usize) -> &str {
        self.tables().meta().clips.get(clip).map_or("", |c| &c.name)
    }

    /// True for a frame row that a build has made, and nobody has captured (row < number of frames).
    pub fn is_made(&self, row: u32) -> bool {
        let clip = self.clip_of(row);
        let frame = row - self.tables().clips()[clip].first_frame;
        let mut tags = self.tables().meta().clips[clip].tags.iter();
        tags.any(|(name, from, to)| name == MADE_TAG && (*from..*to).contains(&frame))
    }

    /// Planar root of a frame row within its clip (row < number of frames).
    pub fn planar(&self, row: u32) -> Planar {
        let [x, z, heading] = self.tables().frames()[row as usize].planar;
        Planar::new(x, z, heading)
    }

    /// Clip and frames that a segment plays, as text (segment < number of segments).
    pub fn describe_segment(&self, segment: u32) -> String {
        let s = &self.tables().graph().segments[segment as usize];
        let first = self.tables().clips()[s.clip as usize].first_frame;
        let from = s.start - first;
        format!("{} {}–{}", self.clip_name(s.clip as usize), from, from + s.num_frames)
    }
}
