//! Opens worlds, and scenes in worlds; the world is stitched in memory.

use super::WorldDocument;
use super::orders::Made;
use super::views::{Ground, Workshop};
use crate::bundle::OpenBundle;
use crate::render::SolidMesh;
use crate::run::WorldRun;
use std::path::Path;
use std::sync::Arc;
use throng_precompute::environment::{PlacedGeometry, Solid, UnitGeometry};
use throng_precompute::progress::Progress;
use throng_precompute::scene::world::{SharedWish, WishConfig, WorldScene};
use throng_precompute::stitch::{Kit, WorldSource};
use throng_runtime::world::inhabitants::scatter;

/// Number of characters that roam in a world without a scene.
const ROAMERS: usize = 20;

impl WorldDocument {
    /// True for the file of a world, or of a scene in one.
    pub fn is_one(path: &Path) -> bool {
        WorldSource::is_one(path) || WorldScene::is_one(path)
    }

    /// Reads a world file, or the file of a scene in a world, and stitches the world.
    ///
    /// # Errors
    /// A message that names the file and line or key, why the bundle cannot be opened, or the units that do not go
    /// together, and the way out.
    pub fn open(path: &Path, progress: &dyn Progress) -> Result<Self, String> {
        let is_scene = WorldScene::is_one(path);
        let scene = is_scene.then(|| WorldScene::load(path)).transpose().map_err(|e| e.to_string())?;
        let world_path = scene.as_ref().map_or(path, |s| s.world.as_path()).to_path_buf();
        let source = WorldSource::load(&world_path).map_err(|e| e.to_string())?;
        let config = source.config.as_deref();
        let bundle = Arc::new(OpenBundle::open_or_build(&world_path, &source.bundle, config, progress)?);
        let kit = Arc::new(Kit::new(bundle.tables(), &source.bundle).map_err(|e| e.to_string())?);
        let environment = source.environment(&kit.units, &world_path).map_err(|e| e.to_string())?;
        let geometry = PlacedGeometry::new(&environment, &kit.geometries);
        let meshes = kit.geometries.iter().map(|g| unit_mesh(g)).collect();
        let workshop = Workshop::new(Arc::clone(&bundle), Arc::clone(&kit), environment.clone(), &source.stitch)
            .map_err(|e| format!("{}: {e}", world_path.display()))?;
        let stitched = workshop.with(|editor| (editor.world().clone(), editor.report().clone()));
        let (world, report) = stitched.ok_or("stitching the world ended unexpectedly")?;
        let ground = Arc::new(Ground::new(bundle, world)?);
        let mut scene = scene.unwrap_or_else(|| roaming(&source, &world_path));
        let run = populate_as_told(&mut scene, &ground, is_scene)?;
        Ok(Self {
            path: path.to_path_buf(),
            source,
            scene,
            is_scene,
            kit,
            workshop: Some(workshop),
            ground,
            environment,
            geometry,
            report,
            meshes,
            run,
            made: Made::default(),
            working: None,
            edited: None,
            refused: None,
            revision: 0,
        })
    }
}

/// A scene in which all characters roam.
fn roaming(source: &WorldSource, world: &Path) -> WorldScene {
    let wish = WishConfig::Roam { seconds: [20.0, 40.0] };
    WorldScene {
        name: source.name.clone(),
        world: world.to_path_buf(),
        characters: ROAMERS,
        seed: 1,
        wishes: vec![SharedWish { share: 1.0, wish }],
        picture: Default::default(),
    }
}

/// Characters of a scene as it says; of a world without a scene, as many as there is room for.
fn populate_as_told(scene: &mut WorldScene, ground: &Ground, is_scene: bool) -> Result<WorldRun, String> {
    if !is_scene {
        return populate(scene, ground);
    }
    let bundle = ground.bundle();
    let life = scene.live(bundle.tables(), bundle.motion_set(), ground.graph()).map_err(|e| e.to_string())?;
    WorldRun::new(life, bundle, ground.graph()).map_err(|e| e.to_string())
}

/// As many characters as are asked for and there is room for.
pub(super) fn populate(scene: &mut WorldScene, ground: &Ground) -> Result<WorldRun, String> {
    let (bundle, graph) = (ground.bundle(), ground.graph());
    let starts = scatter(graph, scene.characters, scene.seed);
    scene.characters = starts.len();
    let life = scene.live_at(bundle.tables(), bundle.motion_set(), graph, &starts).map_err(|e| e.to_string())?;
    WorldRun::new(life, bundle, graph).map_err(|e| e.to_string())
}

/// Triangles of a unit.
pub fn unit_mesh(geometry: &UnitGeometry) -> SolidMesh {
    let mut mesh = SolidMesh::default();
    for solid in &geometry.solids {
        match solid {
            Solid::Box { centre, rotation, half } => mesh.add_box(*centre, *rotation, *half),
            Solid::Bar { from, to, radius } => mesh.add_bar(*from, *to, *radius),
            Solid::Mesh(triangles) => triangles.corners().iter().for_each(|t| mesh.add_triangle(*t)),
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_precompute::progress::Silent;

    fn refused(name: &str, text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        assert!(WorldDocument::is_one(&path));
        WorldDocument::open(&path, &Silent).map(|_| ()).unwrap_err()
    }

    #[test]
    fn a_world_whose_bundle_cannot_be_opened_is_refused_with_the_way_out() {
        let place = "[[place]]\nunit = \"ground\"\nat = [0, 0, 0]\n";
        let e = refused("square.toml", &format!("bundle = \"no.throng\"\nconfig = \"tiles.toml\"\n{place}"));
        assert!(e.contains("square.toml") && e.contains("no.throng") && e.contains("tiles.toml"), "{e}");
        let e = refused("square.toml", &format!("bundle = \"no.throng\"\n{place}"));
        assert!(e.contains("no.throng is missing") && e.contains("`bundle`"), "{e}");
        let e = refused(
            "scene.toml",
            "bundle = \"a.throng\"\n[[groups]]\nmotion = \"patches\"\ncount = 3\nworld = \"a.world\"\nworld_config = \"nowhere.toml\"\n",
        );
        assert!(e.contains("nowhere.toml"), "{e}");
    }
}
