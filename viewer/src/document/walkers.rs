//! A scene of walkers and the bundle whose blend spaces they are made of.

use crate::bundle::OpenBundle;
use crate::render::SolidMesh;
use crate::run::WalkRun;
use glam::{Vec2, Vec3};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use throng_precompute::progress::Progress;
use throng_precompute::scene::walkers::{Walk, WalkersScene};
use throng_runtime::Skeleton;
use throng_runtime::blend::HeightField;
use throng_runtime::blend::walkers::WalkersConfig;

/// Distance of the corners of hills as they are drawn (m).
const HILL_STEP_M: f32 = 1.0;
/// Hills are drawn so far beyond the square that characters keep to (m).
const BEYOND_M: f32 = 6.0;

/// A scene of walkers that is open.
pub struct WalkersDocument {
    path: PathBuf,
    scene: WalkersScene,
    bundle: Arc<OpenBundle>,
    walk: Walk,
    bodies: Vec<Skeleton>,
    hills: Arc<[SolidMesh]>,
    run: WalkRun,
}

impl fmt::Debug for WalkersDocument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("WalkersDocument").field("path", &self.path).field("scene", &self.scene).finish_non_exhaustive()
    }
}

impl WalkersDocument {
    /// True for a file that is a scene of walkers.
    pub fn is_one(path: &Path) -> bool {
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) && WalkersScene::is_one(path)
    }

    /// Reads a scene and opens its bundle, or builds it.
    ///
    /// # Errors
    /// A message that names the file and key, why the bundle cannot be opened, or what does not fit, and the way out.
    pub fn open(path: &Path, progress: &dyn Progress) -> Result<Self, String> {
        let scene = WalkersScene::load(path).map_err(|e| e.to_string())?;
        let bundle = OpenBundle::open_or_build(path, &scene.bundle, scene.config.as_deref(), progress)?;
        Self::with(path, scene, Arc::new(bundle)).map_err(|e| format!("{}: {e}", path.display()))
    }

    fn with(path: &Path, scene: WalkersScene, bundle: Arc<OpenBundle>) -> Result<Self, String> {
        let say = |e: throng_precompute::BuildError| e.to_string();
        let mut walk = scene.walk(bundle.tables(), WalkersConfig::default()).map_err(say)?;
        let run = WalkRun::new(&mut walk).map_err(say)?;
        let bodies = scene.bodies.make(bundle.tables().skeleton(), scene.seed);
        let ground = walk.ground().clone();
        let hills = if ground.is_flat() { Vec::new() } else { hills(&ground, &scene).to_vec() };
        Ok(Self { path: path.to_path_buf(), scene, bundle, walk, bodies, hills: hills.into(), run })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it says.
    pub fn scene(&self) -> &WalkersScene {
        &self.scene
    }

    /// The bundle.
    pub fn bundle(&self) -> &OpenBundle {
        &self.bundle
    }

    /// The recorded run.
    pub fn run(&self) -> &WalkRun {
        &self.run
    }

    /// The same, to be played, stopped and rewound.
    pub fn run_mut(&mut self) -> &mut WalkRun {
        &mut self.run
    }

    /// Body of a character.
    pub fn body(&self, character: usize) -> &Skeleton {
        // The scene gives bodies out in turn.
        &self.bodies[character % self.bodies.len()]
    }

    /// Meshes of the ground, the light and the dark fields of a chequered board; none if it is level.
    pub fn hills(&self) -> &Arc<[SolidMesh]> {
        &self.hills
    }

    /// One step forward.
    ///
    /// # Errors
    /// A message where the step cannot be taken.
    pub fn step(&mut self) -> Result<(), String> {
        self.run.step(&mut self.walk).map_err(|e| e.to_string())
    }

    /// Restarts with that many characters and a seed.
    ///
    /// # Errors
    /// A message where numbers are out of range; nothing has changed then.
    pub fn populate(&mut self, characters: usize, seed: u64) -> Result<(), String> {
        let scene = WalkersScene { characters, seed, ..self.scene.clone() };
        scene.check(&self.path).map_err(|e| e.to_string())?;
        let head = self.run.reel.head;
        *self = Self::with(&self.path, scene, Arc::clone(&self.bundle))?;
        self.run.reel.head.play_like(&head);
        Ok(())
    }
}

/// Triangles of the ground below a scene, on which slopes are seen by the fields of a chequered board.
fn hills(ground: &HeightField, scene: &WalkersScene) -> [SolidMesh; 2] {
    let half = 0.5 * scene.paths.area_m + BEYOND_M;
    let n = (2.0 * half / HILL_STEP_M).ceil() as usize;
    let corner = |i: usize, k: usize| {
        let at = Vec2::new(i as f32, k as f32) * (2.0 * half / n as f32) - half;
        Vec3::new(at.x, ground.at(at).height, at.y)
    };
    let mut fields: [SolidMesh; 2] = Default::default();
    for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
        let [a, b, c, d] = [corner(i, k), corner(i, k + 1), corner(i + 1, k + 1), corner(i + 1, k)];
        let field = &mut fields[(i + k) % 2];
        field.add_triangle([a, b, c]);
        field.add_triangle([a, c, d]);
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paces::Paces;
    use throng_precompute::progress::Silent;
    use throng_runtime::NUM_JOINTS;

    #[test]
    fn a_scene_of_walkers_steps_rewinds_and_restarts() {
        let paces = Paces::new();
        let mut walkers = WalkersDocument::open(&paces.scene(7, 0.5), &Silent).unwrap();
        (0..90).for_each(|_| walkers.step().unwrap());
        let seen = walkers.run().moment().clone();
        assert_eq!((walkers.run().num_characters(), seen.poses.len()), (7, 7 * NUM_JOINTS));
        walkers.run_mut().reel.head.seek(10);
        assert!(walkers.run().moment().roots != seen.roots);
        (0..80).for_each(|_| walkers.step().unwrap());
        assert!(walkers.run().moment().poses == seen.poses && walkers.run().reel.head.now() == 90);
        assert!(walkers.run().trail(2, 1.0).count() > 8);
        assert!(walkers.hills().len() == 2 && walkers.body(0) != walkers.body(1));
        walkers.populate(3, 9).unwrap();
        assert_eq!((walkers.run().num_characters(), walkers.run().reel.head.now()), (3, 0));
        assert!(walkers.populate(0, 1).unwrap_err().contains("characters"));
    }

    #[test]
    fn missing_files_are_named_with_the_way_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("parade.toml");
        let open = |text: &str| {
            std::fs::write(&path, text).unwrap();
            assert!(WalkersDocument::is_one(&path));
            WalkersDocument::open(&path, &Silent).map(|_| ()).unwrap_err()
        };
        let scene = "[[groups]]\nmotion = \"blend\"\nspaces = [\"ahead\"]\ncount = 2\npaths = {}\n";
        let e = open(&format!("bundle = \"no.throng\"\nconfig = \"gaits.toml\"\n{scene}"));
        assert!(e.contains("parade.toml") && e.contains("no.throng") && e.contains("gaits.toml"), "{e}");
        let paces = Paces::new();
        let e = open(&format!("bundle = {:?}\n{scene}", paces.bundle()));
        assert!(e.contains("`ahead`") && e.contains("paces"), "{e}");
    }
}
