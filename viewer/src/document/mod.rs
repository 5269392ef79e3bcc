//! What is open: nothing, a bundle, a scene on a bundle, a world of motion patches, a scene of walkers or of a crowd, or a
//! raw motion file.

mod bundle;
mod clip;
mod crowd;
mod load;
mod scene;
mod walkers;
mod watch;
pub mod world;

pub use bundle::Bundle;
pub use clip::RawMotion;
pub use crowd::{CrowdChoice, CrowdDocument, MAX_MEMBERS};
pub use load::{Loader, Opened};
pub use scene::SceneFile;
pub use walkers::WalkersDocument;
pub use watch::{Stamp, Watch};
pub use world::WorldDocument;

use crate::run::{BlendRun, Run};
use std::path::{Path, PathBuf};

/// What is open.
#[derive(Debug, Default)]
pub enum Document {
    /// Nothing yet.
    #[default]
    Nothing,
    /// A bundle, and the crowd or the scene that runs on it.
    Bundle(Box<BundleDocument>),
    /// A motion file as it is, and as a build would use it.
    Clip(Box<RawMotion>),
    /// A world of motion patches, and who lives there.
    World(Box<WorldDocument>),
    /// A scene of walkers.
    Walkers(Box<WalkersDocument>),
    /// A scene of a crowd that acts at its own events.
    CrowdScene(Box<CrowdDocument>),
}

/// A bundle and the crowd or the scene that runs on it.
#[derive(Debug)]
pub struct BundleDocument {
    /// The tables.
    pub bundle: Bundle,
    /// The recorded run; none where the bundle has no behaviour, with the reason.
    pub run: Result<Run, String>,
    /// Somebody who walks in one of its blend spaces; none where it has no such space.
    pub blend: Option<BlendRun>,
    /// The scene that was opened; none where the bundle itself was.
    pub scene: Option<SceneFile>,
}

impl Document {
    /// The file, where one is open.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Nothing => None,
            Self::Bundle(b) => Some(b.scene.as_ref().map_or(b.bundle.path(), |s| &s.path)),
            Self::Clip(c) => Some(c.path()),
            Self::World(w) => Some(w.path()),
            Self::Walkers(w) => Some(w.path()),
            Self::CrowdScene(c) => Some(c.path()),
        }
    }

    /// All files that it is made of.
    pub fn files(&self) -> Vec<PathBuf> {
        let scene_bundle = match self {
            Self::Bundle(b) if b.scene.is_some() => Some(b.bundle.path()),
            Self::World(w) => Some(w.bundle().path()),
            Self::Walkers(w) => Some(w.bundle().path()),
            Self::CrowdScene(c) => c.bundle().map(Bundle::path),
            _ => None,
        };
        self.path().into_iter().chain(scene_bundle).map(Path::to_path_buf).collect()
    }

    /// The scene, where one is open.
    pub fn scene(&self) -> Option<&SceneFile> {
        match self {
            Self::Bundle(b) => b.scene.as_ref(),
            _ => None,
        }
    }

    /// Why the scene that is open cannot be run.
    pub fn scene_fault(&self) -> Option<&str> {
        match self {
            Self::Bundle(b) if b.scene.is_some() => b.run.as_ref().err().map(String::as_str),
            _ => None,
        }
    }

    /// The bundle, where one is open.
    pub fn bundle(&self) -> Option<&Bundle> {
        match self {
            Self::Bundle(b) => Some(&b.bundle),
            Self::World(w) => Some(w.bundle()),
            Self::Walkers(w) => Some(w.bundle()),
            Self::CrowdScene(c) => c.bundle(),
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

    /// The world, where one is open.
    pub fn world(&self) -> Option<&WorldDocument> {
        match self {
            Self::World(w) => Some(w),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn world_mut(&mut self) -> Option<&mut WorldDocument> {
        match self {
            Self::World(w) => Some(w),
            _ => None,
        }
    }

    /// The scene of walkers, where one is open.
    pub fn walkers(&self) -> Option<&WalkersDocument> {
        match self {
            Self::Walkers(w) => Some(w),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn walkers_mut(&mut self) -> Option<&mut WalkersDocument> {
        match self {
            Self::Walkers(w) => Some(w),
            _ => None,
        }
    }

    /// The scene of a crowd, where one is open.
    pub fn crowd_scene(&self) -> Option<&CrowdDocument> {
        match self {
            Self::CrowdScene(c) => Some(c),
            _ => None,
        }
    }

    /// The bundle and who walks in its blend spaces, where it has any.
    pub fn blend(&self) -> Option<(&Bundle, &BlendRun)> {
        match self {
            Self::Bundle(b) => Some((&b.bundle, b.blend.as_ref()?)),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn blend_mut(&mut self) -> Option<(&Bundle, &mut BlendRun)> {
        match self {
            Self::Bundle(b) => Some((&b.bundle, b.blend.as_mut()?)),
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
