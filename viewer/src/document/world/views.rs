//! What of a world borrows from its bundle: the editor that stitches it, and the graph that is walked.

use super::super::Bundle;
use self_cell::self_cell;
use std::sync::Arc;
use throng_precompute::environment::Environment;
use throng_precompute::progress::Silent;
use throng_precompute::stitch::{Editor, Kit, StitchConfig};
use throng_runtime::world::{WorldData, WorldGraph};

type Tool<'a> = Editor<'a>;

/// What an editor works with.
struct Parts {
    bundle: Arc<Bundle>,
    kit: Arc<Kit>,
}

self_cell!(
    struct EditorCell {
        owner: Parts,
        #[not_covariant]
        dependent: Tool,
    }
);

/// The editor of a world, with the bundle whose patches it lays.
pub(super) struct Workshop(EditorCell);

impl Workshop {
    /// Stitches a world.
    ///
    /// # Errors
    /// A message that names the units that do not go together, and the way out.
    pub fn new(
        bundle: Arc<Bundle>,
        kit: Arc<Kit>,
        environment: Environment,
        config: &StitchConfig,
    ) -> Result<Self, String> {
        let cell = EditorCell::try_new(Parts { bundle, kit }, |parts| {
            let tables = parts.bundle.tables();
            Editor::new(tables.patches(), parts.kit.library(tables), environment, config, &Silent)
        });
        cell.map(Self).map_err(|e| e.to_string())
    }

    /// The bundle's units.
    pub fn kit(&self) -> &Kit {
        &self.0.borrow_owner().kit
    }

    pub fn shared_bundle(&self) -> Arc<Bundle> {
        Arc::clone(&self.0.borrow_owner().bundle)
    }

    /// Looks at the editor.
    pub fn with<T>(&self, look: impl for<'a> FnOnce(&Editor<'a>) -> T) -> T {
        self.0.with_dependent(|_, editor| look(editor))
    }

    /// Changes the world.
    pub fn change<T>(&mut self, change: impl for<'a> FnOnce(&mut Editor<'a>) -> T) -> T {
        self.0.with_dependent_mut(|_, editor| change(editor))
    }
}

/// What a graph is made over.
struct Land {
    bundle: Arc<Bundle>,
    world: WorldData,
}

self_cell!(
    struct GraphCell {
        owner: Land,
        #[covariant]
        dependent: WorldGraph,
    }
);

/// A stitched world with the graph over it.
pub(super) struct Ground(GraphCell);

impl Ground {
    /// # Errors
    /// A message where the world cannot be walked.
    pub fn new(bundle: Arc<Bundle>, world: WorldData) -> Result<Self, String> {
        let land = Land { bundle, world };
        let cell = GraphCell::try_new(land, |land| WorldGraph::new(land.bundle.tables().patches(), land.world.view()));
        cell.map(Self).map_err(|e| e.to_string())
    }

    pub fn bundle(&self) -> &Bundle {
        &self.0.borrow_owner().bundle
    }

    pub fn graph(&self) -> &WorldGraph<'_> {
        self.0.borrow_dependent()
    }
}
