//! What is open: nothing, a bundle, or a raw motion file.

mod bundle;
mod clip;
mod load;
mod watch;

pub use bundle::Bundle;
pub use clip::RawMotion;
pub use load::{Loader, Opened};
pub use watch::{Stamp, Watch};

use crate::run::Run;
use std::path::Path;

/// What is open.
#[derive(Debug, Default)]
pub enum Document {
    /// Nothing yet.
    #[default]
    Nothing,
    /// A bundle, and the crowd that runs on it.
    Bundle(Box<BundleDocument>),
    /// A motion file as it is, and as a build would use it.
    Clip(Box<RawMotion>),
}

/// A bundle and the crowd that runs on it.
#[derive(Debug)]
pub struct BundleDocument {
    /// The tables.
    pub bundle: Bundle,
    /// The recorded run; none where the bundle has no behaviour, with the reason.
    pub run: Result<Run, String>,
}

impl Document {
    /// The file, where one is open.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Nothing => None,
            Self::Bundle(b) => Some(b.bundle.path()),
            Self::Clip(c) => Some(c.path()),
        }
    }

    /// The bundle, where one is open.
    pub fn bundle(&self) -> Option<&Bundle> {
        match self {
            Self::Bundle(b) => Some(&b.bundle),
            _ => None,
        }
    }

    /// The bundle and its run, where there is one.
    pub fn crowd(&self) -> Option<(&Bundle, &Run)> {
        match self {
            Self::Bundle(b) => Some((&b.bundle, b.run.as_ref().ok()?)),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn crowd_mut(&mut self) -> Option<(&Bundle, &mut Run)> {
        match self {
            Self::Bundle(b) => Some((&b.bundle, b.run.as_mut().ok()?)),
            _ => None,
        }
    }

    /// The raw motion, where a motion file is open.
    pub fn raw_motion(&self) -> Option<&RawMotion> {
        match self {
            Self::Clip(c) => Some(c),
            _ => None,
        }
    }
}
