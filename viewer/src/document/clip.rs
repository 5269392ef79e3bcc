//! A raw motion file: the joints of the source, and the clip that a build would make of them.

use glam::Vec3;
use std::path::{Path, PathBuf};
use throng_precompute::inspect::{self, ClipReport, InspectedClip};
use throng_precompute::{ClipSet, config::BuildConfig, import::ImportedClip};

/// A motion file.
#[derive(Debug)]
pub struct RawMotion {
    /// The file.
    pub path: PathBuf,
    /// The source's own joints.
    pub imported: ImportedClip,
    /// The clip on the database skeleton, as a build would use it.
    pub clips: ClipSet,
    /// Report of the import.
    pub report: ClipReport,
}

impl RawMotion {
    /// Reads a motion file.
    ///
    /// # Errors
    /// A message that names the file and line or joint, and the way out.
    pub fn open(path: &Path) -> Result<Self, String> {
        let InspectedClip { imported, clips, report } =
            inspect::inspect_clip(path, &BuildConfig::default()).map_err(|e| e.to_string())?;
        Ok(Self { path: path.to_path_buf(), imported, clips, report })
    }

    /// Frame of the clip of a build at a frame of the source.
    pub fn clip_frame(&self, source_frame: f32) -> usize {
        let Some(clip) = self.clips.clips.first() else { return 0 };
        let seconds = f64::from(source_frame) / self.imported.clip.rate_hz;
        ((seconds * clip.rate_hz).round() as usize).min(clip.num_frames().saturating_sub(1))
    }

    /// Position on the ground of the built body at a frame of the source (m).
    pub fn place(&self, source_frame: f32) -> Option<Vec3> {
        let clip = self.clips.clips.first()?;
        Some(clip.root_positions[self.clip_frame(source_frame)].with_y(0.0))
    }
}
