//! Opens worlds, which are stitched in memory.

use super::WorldDocument;
use super::orders::EditHistory;
use super::views::{EditorThread, WalkableWorld};
use crate::bundle::OpenBundle;
use crate::render::SolidMesh;
use crate::run::{SceneChoice, WorldRun};
use std::path::Path;
use std::sync::Arc;
use throng_precompute::environment::{PlacedGeometry, UnitGeometry};
use throng_precompute::run::{BuildContext, ensure_bundle};
use throng_precompute::stitch::{StitchKit, WorldSource};
use throng_world::inhabitants::scatter_rest_nodes;

/// Number of characters that roam in a world.
const ROAMERS: usize = 20;

impl WorldDocument {
    /// Reads a world file and stitches the world; some characters roam in it.
    ///
    /// # Errors
    /// A message that names the file and line or key, why the bundle cannot be opened, or the units that do not go
    /// together, and the way out.
    pub fn open(path: &Path, with: &BuildContext<'_>) -> Result<Self, String> {
        let source = WorldSource::load(path).map_err(|e| e.to_string())?;
        let fail = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        ensure_bundle(&source.bundle, source.config.as_deref(), with).map_err(|e| fail(&e))?;
        let bundle = Arc::new(OpenBundle::open(&source.bundle).map_err(|e| fail(&format!("its bundle: {e}")))?);
        let kit = Arc::new(StitchKit::new(bundle.tables(), &source.bundle).map_err(|e| e.to_string())?);
        let environment = source.environment(&kit.units, path).map_err(|e| e.to_string())?;
        let geometry = PlacedGeometry::new(&environment, &kit.geometries);
        let meshes = kit.geometries.iter().map(|g| unit_mesh(g)).collect();
        let workshop = EditorThread::new(Arc::clone(&bundle), Arc::clone(&kit), environment.clone(), &source.stitch)
            .map_err(|e| fail(&e))?;
        let stitched = workshop.run(|editor| (editor.world().clone(), editor.report().clone()));
        let (world, report) = stitched.ok_or("stitching the world ended unexpectedly")?;
        let ground = Arc::new(WalkableWorld::new(bundle, &world)?);
        let mut choice = SceneChoice { characters: ROAMERS, ..SceneChoice::default() };
        let run = populate(&mut choice, &ground)?;
        Ok(Self {
            path: path.to_path_buf(),
            source,
            choice,
            kit,
            workshop: Some(workshop),
            walkable: ground,
            environment,
            geometry,
            report,
            meshes,
            run,
            made: EditHistory::default(),
            working: None,
            edited: None,
            refused: None,
            revision: 0,
        })
    }
}

/// Places the requested number of characters, as far as there is room.
pub(super) fn populate(choice: &mut SceneChoice, ground: &WalkableWorld) -> Result<WorldRun, String> {
    let starts = scatter_rest_nodes(ground.world.graph(), choice.characters, choice.seed);
    choice.characters = starts.len();
    WorldRun::new(&ground.world, choice.seed, &starts).map_err(|e| e.to_string())
}

/// Triangles of a unit.
pub fn unit_mesh(geometry: &UnitGeometry) -> SolidMesh {
    let mut mesh = SolidMesh::default();
    geometry.solids.iter().for_each(|solid| mesh.add_solid(solid));
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::quietly;

    fn refused(name: &str, text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        assert!(WorldSource::is_one(&path));
        quietly(|with| WorldDocument::open(&path, with)).map(|_| ()).unwrap_err()
    }

    #[test]
    fn a_world_whose_bundle_cannot_be_opened_is_refused_with_the_way_out() {
        let place = "[[place]]\nunit = \"ground\"\nat = [0, 0, 0]\n";
        let e = refused("square.toml", &format!("bundle = \"no.throng\"\nconfig = \"tiles.toml\"\n{place}"));
        assert!(e.contains("square.toml") && e.contains("no.throng") && e.contains("tiles.toml"), "{e}");
        let e = refused("square.toml", &format!("bundle = \"no.throng\"\n{place}"));
        assert!(e.contains("no.throng: there is no such bundle") && e.contains("`throng build`"), "{e}");
    }
}
