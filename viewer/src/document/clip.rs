//! A raw motion file: the source's own joints, and what a build would make of it.

use std::path::{Path, PathBuf};
use throng_precompute::ClipSet;
use throng_precompute::import::{ImportConfig, Imported};
use throng_precompute::inspect::{self, ClipReport, Inspected};

/// A motion file.
#[derive(Debug)]
pub struct RawMotion {
    path: PathBuf,
    /// The source's own joints.
    pub imported: Imported,
    /// The clip on the database skeleton, as a build would use it.
    pub clips: ClipSet,
    /// What import found.
    pub report: ClipReport,
}

impl RawMotion {
    /// Reads a motion file.
    ///
    /// # Errors
    /// A message that names the file and line or joint, and the way out.
    pub fn open(path: &Path) -> Result<Self, String> {
        let read = inspect::inspect_clip(path, &ImportConfig::default()).map_err(|e| e.to_string())?;
        let Inspected { imported, clips, report } = read;
        Ok(Self { path: path.to_path_buf(), imported, clips, report })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Length. [Unit: s]
    pub fn duration_s(&self) -> f64 {
        self.report.duration_s
    }
}
