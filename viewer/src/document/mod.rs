//! The open document: nothing, a bundle, a scene, a world of motion patches, a task of limbs, or a raw motion file.

mod background;
mod building;
mod clip;
mod crowd;
mod load;
mod obstacles;
mod outfit;
mod scene;
mod task;
mod watch;
pub mod world;

pub use background::Background;
pub use building::{BuildEnd, BuildLog, FinishedBuild, OngoingBuild, ShownBuild};
pub use clip::RawMotion;
pub use load::{Loader, may_be_made, path_list};
pub use outfit::UserOutfit;
pub use scene::{MAX_SCENE_CHARACTERS, SceneDocument, SceneDoor, SceneResumePoint, SceneSurroundings, SceneUnit};
pub use task::{PlannedMotion, Planning, TaskDocument};
pub use watch::{FileStamp, FileWatch};
pub use world::WorldDocument;

use crate::bundle::OpenBundle;
pub use crate::run::SceneChoice;
use crate::run::{BlendRun, PlayHead, PolicyChooser};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The open document.
#[derive(Default)]
pub enum OpenDocument {
    /// Nothing yet.
    #[default]
    Nothing,
    /// A bundle, and the crowd that runs on it.
    Bundle(Box<BundleDocument>),
    /// A motion file, and the clip that a build would make of it.
    Clip(Box<RawMotion>),
    /// A world of motion patches, and its inhabitants.
    World(Box<WorldDocument>),
    /// A scene: groups of characters with any source of motion.
    Scene(Box<SceneDocument>),
    /// A task of limbs, and the motions planned for it.
    Task(Box<TaskDocument>),
}

/// A bundle and the crowd that runs on it.
pub struct BundleDocument {
    /// The tables.
    pub bundle: Arc<OpenBundle>,
    /// The crowd; none if the bundle has no behaviour, with the reason.
    pub crowd: Result<SceneDocument, String>,
    /// A character walking in one of its blend spaces; none if it has no such space.
    pub blend: Option<BlendRun>,
}

impl BundleDocument {
    /// A document without a run: no character moves yet.
    pub fn without_run(bundle: OpenBundle) -> Self {
        Self { bundle: Arc::new(bundle), crowd: Err(String::new()), blend: None }
    }
}

impl OpenDocument {
    /// The file, where one is open.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Nothing => None,
            Self::Bundle(b) => Some(&b.bundle.path),
            Self::Clip(c) => Some(&c.path),
            Self::World(w) => Some(&w.path),
            Self::Scene(s) => Some(&s.path),
            Self::Task(t) => Some(&t.path),
        }
    }

    /// Play head of the run, if there is one; that of a blend belongs to [`BlendRun`].
    pub fn head(&self) -> Option<&PlayHead> {
        match self {
            Self::World(w) => Some(&w.run.reel.head),
            document => Some(&document.scene()?.run.head),
        }
    }

    /// Play head of the run, mutable.
    pub fn head_mut(&mut self) -> Option<&mut PlayHead> {
        match self {
            Self::World(w) => Some(&mut w.run.reel.head),
            document => Some(&mut document.scene_mut()?.run.head),
        }
    }

    /// Further files that the document depends on.
    pub fn more_files(&self) -> Vec<PathBuf> {
        match self {
            Self::World(w) => vec![w.bundle().path.clone()],
            Self::Scene(s) => s.more_files(),
            Self::Task(t) => t.sources.files.clone(),
            Self::Nothing | Self::Bundle(_) | Self::Clip(_) => Vec::new(),
        }
    }

    /// The bundle, where one is open.
    pub fn bundle(&self) -> Option<&OpenBundle> {
        match self {
            Self::Bundle(b) => Some(&b.bundle),
            Self::World(w) => Some(w.bundle()),
            Self::Scene(s) => s.bundle(),
            _ => None,
        }
    }

    /// A character of a scene that chooses by policies, and all that bears on its choices.
    pub fn chooser(&self, character: usize) -> Option<PolicyChooser<'_>> {
        self.scene()?.chooser(character)
    }

    /// The world, where one is open.
    pub fn world(&self) -> Option<&WorldDocument> {
        if let Self::World(w) = self { Some(w) } else { None }
    }

    /// The scene, where one is open, or the crowd of a bundle.
    pub fn scene(&self) -> Option<&SceneDocument> {
        match self {
            Self::Scene(s) => Some(s),
            Self::Bundle(b) => b.crowd.as_ref().ok(),
            _ => None,
        }
    }

    /// The scene, mutable.
    pub fn scene_mut(&mut self) -> Option<&mut SceneDocument> {
        match self {
            Self::Scene(s) => Some(s),
            Self::Bundle(b) => b.crowd.as_mut().ok(),
            _ => None,
        }
    }

    /// Settings of the run: of the scene, of the crowd of a bundle, or of the characters of a world.
    pub fn choice(&self) -> Option<SceneChoice> {
        if let Self::World(w) = self { Some(w.choice) } else { self.scene().map(|s| s.choice) }
    }

    /// The task, where one is open.
    pub fn task(&self) -> Option<&TaskDocument> {
        if let Self::Task(t) = self { Some(t) } else { None }
    }

    /// The bundle and the character in its blend space, if it has one.
    pub fn blend(&self) -> Option<(&OpenBundle, &BlendRun)> {
        let Self::Bundle(b) = self else { return None };
        Some((&b.bundle, b.blend.as_ref()?))
    }

    /// The bundle and the character in its blend space, mutable.
    pub fn blend_mut(&mut self) -> Option<(&OpenBundle, &mut BlendRun)> {
        let Self::Bundle(b) = self else { return None };
        Some((&b.bundle, b.blend.as_mut()?))
    }

    /// The raw motion, where a motion file is open.
    pub fn raw_motion(&self) -> Option<&RawMotion> {
        if let Self::Clip(c) = self { Some(c) } else { None }
    }
}
