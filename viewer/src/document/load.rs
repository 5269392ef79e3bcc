//! Opens files away from the window's thread.

use super::{Bundle, CrowdDocument, RawMotion, SceneFile, Stamp, WalkersDocument, WorldDocument};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use throng_precompute::scene::Scene;

/// A file as it was read.
#[derive(Debug)]
pub enum Opened {
    /// A bundle.
    Bundle(Box<Bundle>),
    /// A scene and its bundle.
    Scene(Box<SceneFile>, Box<Bundle>),
    /// A motion file.
    Clip(Box<RawMotion>),
    /// A world of motion patches, or a scene in one.
    World(Box<WorldDocument>),
    /// A scene of walkers.
    Walkers(Box<WalkersDocument>),
    /// A scene of a crowd.
    CrowdScene(Box<CrowdDocument>),
}

impl Opened {
    /// Reads a file: `.bvh` and `.amc` as motion, `.toml` as a scene or a world, anything else as a bundle.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn read(path: &Path) -> Result<Self, String> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("bvh" | "amc") => Ok(Self::Clip(Box::new(RawMotion::open(path)?))),
            _ if WorldDocument::is_one(path) => Ok(Self::World(Box::new(WorldDocument::open(path)?))),
            _ if WalkersDocument::is_one(path) => Ok(Self::Walkers(Box::new(WalkersDocument::open(path)?))),
            _ if CrowdDocument::is_one(path) => Ok(Self::CrowdScene(Box::new(CrowdDocument::open(path)?))),
            _ if Scene::is_scene(path) => {
                let (scene, bundle) = SceneFile::open(path)?;
                Ok(Self::Scene(Box::new(scene), Box::new(bundle)))
            }
            _ => Ok(Self::Bundle(Box::new(Bundle::open(path)?))),
        }
    }

    /// Files that it was read from, beside the one that was asked for.
    pub fn more_files(&self) -> Option<&Path> {
        match self {
            Self::Scene(_, bundle) => Some(bundle.path()),
            Self::World(world) => Some(world.bundle().path()),
            Self::Walkers(walkers) => Some(walkers.bundle().path()),
            Self::CrowdScene(crowd) => crowd.bundle().map(Bundle::path),
            _ => None,
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
    running: Option<(PathBuf, Receiver<Loaded>)>,
}

impl Loader {
    /// Starts to read a file. `wake` is called when it is done.
    pub fn start(&mut self, path: &Path, wake: impl FnOnce() + Send + 'static) {
        let (send, receive) = channel();
        let owned = path.to_path_buf();
        self.running = Some((owned.clone(), receive));
        std::thread::spawn(move || {
            let before = Stamp::of(&owned);
            let result = Opened::read(&owned);
            let stamp = Stamp::with(before, result.as_ref().ok().and_then(Opened::more_files));
            // Nobody listens where another file was asked for meanwhile.
            if send.send(Loaded { path: owned, stamp, result }).is_ok() {
                wake();
            }
        });
    }

    /// The file that is being read.
    pub fn path(&self) -> Option<&Path> {
        self.running.as_ref().map(|r| r.0.as_path())
    }

    /// What has been read since the last call.
    pub fn poll(&mut self) -> Option<Loaded> {
        let (path, receive) = self.running.as_ref()?;
        let loaded = match receive.try_recv() {
            Ok(loaded) => loaded,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                let result = Err(format!("{}: reading it failed unexpectedly", path.display()));
                Loaded { path: path.clone(), stamp: None, result }
            }
        };
        self.running = None;
        Some(loaded)
    }
}
