//! The editor that stitches a world, and the world that is walked.

use crate::bundle::OpenBundle;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use throng_precompute::stitch::{Editor, StitchConfig, StitchKit};
use throng_precompute::{environment::Environment, progress::Silent};
use throng_world::{World, WorldData};

/// Work for the thread of an editor.
type EditorRequest = Box<dyn FnOnce(&mut Editor<'_>) + Send>;

/// The editor of a world on its own thread, which ends with this value, and the bundle of its patches.
///
/// An editor borrows from the bundle; the thread holds both.
pub(super) struct EditorThread {
    pub bundle: Arc<OpenBundle>,
    pub kit: Arc<StitchKit>,
    requests: Sender<EditorRequest>,
}

impl EditorThread {
    /// Stitches a world.
    ///
    /// # Errors
    /// A message that names the units that do not go together, and the way out.
    pub fn new(
        bundle: Arc<OpenBundle>,
        kit: Arc<StitchKit>,
        environment: Environment,
        config: &StitchConfig,
    ) -> Result<Self, String> {
        let ((requests, received), (send, made)) = (channel::<EditorRequest>(), channel());
        let (own_bundle, own_kit, config) = (Arc::clone(&bundle), Arc::clone(&kit), config.clone());
        std::thread::spawn(move || {
            let tables = own_bundle.tables();
            let editor = Editor::new(tables.patches(), own_kit.library(tables), environment, &config, &Silent);
            // The receiver waits for the result.
            let Ok(mut editor) = editor.map_err(|e| send.send(Err(e.to_string()))) else { return };
            _ = send.send(Ok(()));
            received.iter().for_each(|request| request(&mut editor));
        });
        made.recv().unwrap_or_else(|_| Err("stitching the world ended unexpectedly".into()))?;
        Ok(Self { bundle, kit, requests })
    }

    /// Runs work on the editor and returns its result; none if the editor has ended unexpectedly.
    pub fn run<T: Send + 'static>(&self, work: impl FnOnce(&mut Editor<'_>) -> T + Send + 'static) -> Option<T> {
        let (send, receive) = channel();
        let request: EditorRequest = Box::new(move |editor| _ = send.send(work(editor)));
        self.requests.send(request).ok()?;
        receive.recv().ok()
    }
}

/// A stitched world and its bundle.
pub(super) struct WalkableWorld {
    pub bundle: Arc<OpenBundle>,
    pub world: World,
}

impl WalkableWorld {
    /// # Errors
    /// A message where the world cannot be walked.
    pub fn new(bundle: Arc<OpenBundle>, world: &WorldData) -> Result<Self, String> {
        let world = World::from_data(world, bundle.tables()).map_err(|e| e.to_string())?;
        Ok(Self { bundle, world })
    }
}
