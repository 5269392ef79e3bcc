//! What is open: nothing, a bundle, a scene on a bundle, a world of motion patches, a scene of walkers or of a crowd, or a
//! raw motion file.

mod clip;
mod crowd;
mod load;
mod notice;
mod obstacles;
mod scene;
mod simulated;
mod walkers;
mod watch;
pub mod world;

pub use clip::RawMotion;
pub use crowd::{CrowdChoice, CrowdDocument, MAX_MEMBERS};
pub use load::{Loader, Opened};
pub use scene::SceneFile;
pub use simulated::{MAX_CHARACTERS, SceneChoice, SceneDocument, Standing, StandingUnit};
pub use walkers::WalkersDocument;
pub use watch::{Stamp, Watch};
pub use world::WorldDocument;

use crate::bundle::OpenBundle;
use crate::run::{BlendRun, Head, Run};
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
    /// A world of motion patches, and its inhabitants.
    World(Box<WorldDocument>),
    /// A scene of walkers.
    Walkers(Box<WalkersDocument>),
    /// A scene of a crowd that acts at its own events.
    CrowdScene(Box<CrowdDocument>),
    /// A scene of groups, whatever moves them.
    Scene(Box<SceneDocument>),
}

/// A bundle and the crowd or the scene that runs on it.
#[derive(Debug)]
pub struct BundleDocument {
    /// The tables.
    pub bundle: OpenBundle,
    /// The recorded run; none if the bundle has no behaviour, with the reason.
    pub run: Result<Run, String>,
    /// A character walking in one of its blend spaces; none if it has no such space.
    pub blend: Option<BlendRun>,
    /// The scene that was opened; none if the bundle itself was.
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
            Self::Scene(s) => Some(s.path()),
        }
    }

    /// Play head of its run, where something runs; that of a blend is [`BlendRun`]'s own.
    pub fn head(&self) -> Option<&Head> {
        match self {
            Self::Nothing | Self::Clip(_) => None,
            Self::Bundle(b) => Some(&b.run.as_ref().ok()?.head),
            Self::World(w) => Some(&w.run().reel.head),
            Self::Walkers(w) => Some(&w.run().reel.head),
            Self::CrowdScene(c) => Some(&c.run().reel.head),
            Self::Scene(s) => Some(&s.run().head),
        }
    }

    /// The same, to be changed.
    pub fn head_mut(&mut self) -> Option<&mut Head> {
        match self {
            Self::Nothing | Self::Clip(_) => None,
            Self::Bundle(b) => Some(&mut b.run.as_mut().ok()?.head),
            Self::World(w) => Some(&mut w.run_mut().reel.head),
            Self::Walkers(w) => Some(&mut w.run_mut().reel.head),
            Self::CrowdScene(c) => Some(&mut c.run_mut().reel.head),
            Self::Scene(s) => Some(&mut s.run_mut().head),
        }
    }

    /// All files that it is made of.
    pub fn files(&self) -> Vec<PathBuf> {
        let scene_bundle = match self {
            Self::Bundle(b) if b.scene.is_some() => Some(b.bundle.path()),
            Self::World(w) => Some(w.bundle().path()),
            Self::Walkers(w) => Some(w.bundle().path()),
            Self::CrowdScene(c) => c.bundle().map(OpenBundle::path),
            Self::Scene(s) => s.bundle().map(OpenBundle::path),
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
    pub fn bundle(&self) -> Option<&OpenBundle> {
        match self {
            Self::Bundle(b) => Some(&b.bundle),
            Self::World(w) => Some(w.bundle()),
            Self::Walkers(w) => Some(w.bundle()),
            Self::CrowdScene(c) => c.bundle(),
            Self::Scene(s) => s.bundle(),
            _ => None,
        }
    }

    /// The bundle and its run, where there is one.
    pub fn crowd(&self) -> Option<(&OpenBundle, &Run)> {
        match self {
            Self::Bundle(b) => Some((&b.bundle, b.run.as_ref().ok()?)),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn crowd_mut(&mut self) -> Option<(&OpenBundle, &mut Run)> {
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

    /// The scene of groups, where one is open.
    pub fn simulated(&self) -> Option<&SceneDocument> {
        match self {
            Self::Scene(s) => Some(s),
            _ => None,
        }
    }

    /// The bundle and the character in its blend space, if it has one.
    pub fn blend(&self) -> Option<(&OpenBundle, &BlendRun)> {
        match self {
            Self::Bundle(b) => Some((&b.bundle, b.blend.as_ref()?)),
            _ => None,
        }
    }

    /// The same, to be changed.
    pub fn blend_mut(&mut self) -> Option<(&OpenBundle, &mut BlendRun)> {
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
