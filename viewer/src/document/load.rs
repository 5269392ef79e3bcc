//! Opens files away from the window's thread.

use super::notice::BuildNotice;
use super::{RawMotion, SceneDocument, Stamp, WorldDocument};
use crate::bundle::OpenBundle;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use throng_precompute::import;
use throng_precompute::progress::Progress;

/// A file as it was read.
#[derive(Debug)]
pub enum Opened {
    /// A bundle.
    Bundle(Box<OpenBundle>),
    /// A motion file.
    Clip(Box<RawMotion>),
    /// A world of motion patches.
    World(Box<WorldDocument>),
    /// A scene.
    Scene(Box<SceneDocument>),
}

impl Opened {
    /// Reads a file: motion by its extension (`.bvh` and others), `.toml` as a scene or a world, anything else as a bundle.
    ///
    /// - `progress`: of building a bundle that is missing.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn read(path: &Path, progress: &dyn Progress) -> Result<Self, String> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        Ok(match extension.as_deref() {
            _ if import::is_motion(path) => Self::Clip(Box::new(RawMotion::open(path)?)),
            Some("toml") if WorldDocument::is_one(path) => Self::World(Box::new(WorldDocument::open(path, progress)?)),
            Some("toml") => Self::Scene(Box::new(SceneDocument::open(path, progress)?)),
            _ => Self::Bundle(Box::new(OpenBundle::open(path)?)),
        })
    }

    /// Files that it was read from, beside the one that was asked for.
    pub fn more_files(&self) -> Vec<PathBuf> {
        match self {
            Self::World(world) => vec![world.bundle().path().to_path_buf()],
            Self::Scene(scene) => scene.more_files(),
            Self::Bundle(_) | Self::Clip(_) => Vec::new(),
        }
    }
}

/// A file that has been read, or why it could not be.
#[derive(Debug)]
pub struct Loaded {
    /// The file.
    pub path: PathBuf,
    /// The version that was read.
    pub stamp: Option<Stamp>,
    /// What it holds.
    pub result: Result<Opened, String>,
}

/// Reads one file at a time on a thread of its own; a new request replaces an old one.
#[derive(Debug, Default)]
pub struct Loader {
    running: Option<(PathBuf, Receiver<Loaded>, BuildNotice)>,
}

impl Loader {
    /// Starts to read a file. `wake` is called when it is done.
    pub fn start(&mut self, path: &Path, wake: impl FnOnce() + Send + 'static) {
        let (send, receive) = channel();
        let owned = path.to_path_buf();
        let notice = BuildNotice::default();
        self.running = Some((owned.clone(), receive, notice.clone()));
        std::thread::spawn(move || {
            let before = Stamp::of(&owned);
            let result = Opened::read(&owned, &notice);
            let more = result.as_ref().map_or(Vec::new(), Opened::more_files);
            let stamp = Stamp::with(before, &more);
            // The receiver is gone if another file was asked for meanwhile.
            if send.send(Loaded { path: owned, stamp, result }).is_ok() {
                wake();
            }
        });
    }

    /// The file that is being read.
    pub fn path(&self) -> Option<&Path> {
        self.running.as_ref().map(|r| r.0.as_path())
    }

    /// What is built for it at the moment; none while it is only read.
    pub fn notice(&self) -> Option<String> {
        self.running.as_ref()?.2.text()
    }

    /// What has been read since the last call.
    pub fn poll(&mut self) -> Option<Loaded> {
        let (path, receive, _) = self.running.as_ref()?;
        let loaded = match receive.try_recv() {
            Ok(loaded) => loaded,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                let result = Err(format!("{}: reading the file failed unexpectedly", path.display()));
                Loaded { path: path.clone(), stamp: None, result }
            }
        };
        self.running = None;
        Some(loaded)
    }
}
