//! Motion as its file has it, before units and axes are found.

use super::{Scanner, archive};
use crate::error::{ImportError, Warnings};
use crate::raw::{RawClip, RawJoint, SourceFormat};
use glam::{DQuat, DVec3};
use std::path::Path;
use throng_base::text::shorten_message;

/// Joints a skeleton may have; more is a damaged file.
pub(crate) const MAX_JOINTS: usize = 4096;
/// Longest name of a joint or an animation (bytes).
pub(crate) const MAX_NAME: usize = 1024;

/// A clip in the units and axes of its file, with the file's own statements.
#[derive(Clone, Debug)]
pub struct SourceClip {
    /// The motion; lengths in the units of the file, axes as in the file.
    pub clip: RawClip,
    /// Length of a unit, where the file names it (m).
    pub declared_metres_per_unit: Option<f64>,
    /// Decisions while reading and their reasons, one sentence each.
    pub findings: Vec<String>,
    /// Oddities that are tolerable.
    pub warnings: Warnings,
}

/// An axis of a coordinate system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CoordinateAxis {
    X,
    Y,
    Z,
}

impl CoordinateAxis {
    /// The axis of a letter of any case.
    pub fn from_letter(letter: u8) -> Option<Self> {
        [Self::X, Self::Y, Self::Z].into_iter().find(|axis| b"xyz"[*axis as usize] == letter.to_ascii_lowercase())
    }

    /// Rotation about the axis (rad).
    pub fn rotation(self, angle: f64) -> DQuat {
        match self {
            Self::X => DQuat::from_rotation_x(angle),
            Self::Y => DQuat::from_rotation_y(angle),
            Self::Z => DQuat::from_rotation_z(angle),
        }
    }
}

/// Frames of a clip while they are read, one joint transform at a time.
pub(crate) struct FrameSink {
    pub joints: Vec<RawJoint>,
    pub translations: Vec<DVec3>,
    pub rotations: Vec<DQuat>,
    rest: Vec<DVec3>,
    clip_translations: Vec<glam::Vec3>,
    clip_rotations: Vec<glam::Quat>,
    budget: usize,
}

impl FrameSink {
    /// Keeps as many joint transforms as a text may make: most of them take several numbers of it.
    pub fn of_text(joints: Vec<RawJoint>, text: &Scanner) -> Self {
        let num_bytes = archive::counted_bytes(text.path, text.bytes.len());
        Self::new(joints, num_bytes.saturating_mul(2).saturating_add(1 << 20))
    }

    /// Number of joint transforms that a compressed file of `num_bytes` may make: in proportion to it.
    pub fn budget(num_bytes: usize) -> usize {
        num_bytes.saturating_mul(8).saturating_add(1 << 16)
    }

    /// Keeps at most `budget` joint transforms.
    pub fn new(joints: Vec<RawJoint>, budget: usize) -> Self {
        let rest: Vec<_> = joints.iter().map(|j| j.offset.as_dvec3()).collect();
        let (translations, rotations) = (rest.clone(), vec![DQuat::IDENTITY; rest.len()]);
        let (clip_translations, clip_rotations) = (Vec::new(), Vec::new());
        Self { translations, rotations, rest, joints, clip_translations, clip_rotations, budget }
    }

    /// Resets the pose under construction to rest.
    pub fn begin_frame(&mut self) {
        self.translations.copy_from_slice(&self.rest);
        self.rotations.fill(DQuat::IDENTITY);
    }

    /// Keeps the pose as the next frame; false where the file is too small to describe so much motion.
    #[must_use]
    pub fn end_frame(&mut self) -> bool {
        if self.clip_rotations.len() + self.joints.len() > self.budget {
            return false;
        }
        self.clip_translations.extend(self.translations.iter().map(|t| t.as_vec3()));
        self.clip_rotations.extend(self.rotations.iter().map(|r| r.normalize().as_quat()));
        true
    }

    /// Number of frames kept.
    pub fn num_frames(&self) -> usize {
        self.clip_rotations.len() / self.joints.len()
    }

    /// The clip of all frames kept.
    pub fn into_clip(self, path: &Path, format: SourceFormat, rate_hz: f64) -> RawClip {
        RawClip {
            name: path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned()),
            path: path.to_owned(),
            format,
            num_frames: self.num_frames(),
            joints: self.joints,
            rate_hz,
            translations: self.clip_translations,
            rotations: self.clip_rotations,
        }
    }
}

/// Most names that a warning lists.
const LISTED: usize = 3;

/// Warns of joints that share a name.
pub(crate) fn duplicate_names(joints: &[RawJoint], path: &Path) -> Warnings {
    let mut names: Vec<&str> = joints.iter().map(|j| j.name.as_str()).collect();
    names.sort_unstable();
    let mut twice: Vec<&str> = names.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0]).collect();
    twice.dedup();
    let mut warnings = Warnings::default();
    if !twice.is_empty() {
        let some: Vec<String> = twice.iter().take(LISTED).map(|n| format!("`{n}`")).collect();
        let more = if twice.len() > LISTED { format!(" and {} more", twice.len() - LISTED) } else { String::new() };
        let some = some.join(", ");
        warnings.push(format!("{}: more than one joint is called {some}{more}; the first counts.", path.display()));
    }
    warnings
}

/// An error about the content of a file.
pub(crate) fn content_error(path: &Path, message: impl Into<String>, help: &str) -> ImportError {
    ImportError::Content { path: path.to_owned(), message: shorten_message(message.into()), help: help.into() }
}
