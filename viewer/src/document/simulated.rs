//! A scene of groups, whatever moves them: its file, its bundles and worlds, and its run.

use super::obstacles::mesh_of;
use super::world::unit_mesh;
use crate::bundle::OpenBundle;
use crate::render::SolidMesh;
use crate::run::SceneRun;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use throng_precompute::cache::Cache;
use throng_precompute::progress::Progress;
use throng_precompute::run::{Cached, SeenObstacle, ensure, seen_obstacle};
use throng_precompute::stitch::Kit;
use throng_runtime::patch::Placement;
use throng_runtime::simulation::{CompiledScene, GroupCast, Scene};

/// Most characters that a scene may be restarted with from the viewer.
pub const MAX_CHARACTERS: usize = 100_000;

/// What of a scene can be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneChoice {
    /// Number of characters and agents of all groups.
    pub characters: usize,
    /// Seed of places, paths and choices.
    pub seed: u64,
}

/// What stands around the characters.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    /// A mesh of all obstacles that stand, then one of every unit of each world.
    pub meshes: Arc<[SolidMesh]>,
    /// Units of worlds: number of the mesh, and the unit.
    pub units: Vec<StandingUnit>,
    /// Obstacles, also those that move.
    pub obstacles: Vec<SeenObstacle>,
    /// Agents move in the air.
    pub in_the_air: bool,
}

/// A unit of a world where it stands.
#[derive(Clone, Debug)]
pub struct StandingUnit {
    /// Number of its mesh.
    pub mesh: u32,
    /// Its name.
    pub name: String,
    /// It is walked on.
    pub is_floor: bool,
    /// Where it stands.
    pub placement: Placement,
}

/// A run that is made on a thread of its own.
#[derive(Debug)]
struct Restart {
    choice: SceneChoice,
    made: Receiver<Result<(SceneRun, Standing), String>>,
}

/// A scene of groups that is open.
#[derive(Debug)]
pub struct SceneDocument {
    path: PathBuf,
    scene: Scene,
    choice: SceneChoice,
    run: SceneRun,
    standing: Standing,
    /// That of the first group that has one.
    bundle: Option<OpenBundle>,
    restart: Option<Restart>,
}

impl SceneDocument {
    /// Reads a scene, makes the bundles and worlds that are missing, and puts all characters in place.
    ///
    /// # Errors
    /// A message that names the file, the line or key, or what could not be made, and the way out.
    pub fn open(path: &Path, scene: Scene, progress: &dyn Progress) -> Result<Self, String> {
        let fail = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let cache = Cache::in_folder(crate::bundle::CACHE_FOLDER);
        ensure(&scene, &Cached { cache: &cache, progress, tell: &|_| {} }).map_err(|e| fail(&e))?;
        let compiled = scene.open().map_err(|e| e.to_string())?;
        let (run, standing) = begin(&compiled)?;
        let with_bundle = (0..scene.groups.len()).find(|&g| compiled.bundle(g).is_ok());
        let bundle = with_bundle.and_then(|g| scene.bundle_of(g).0).map(OpenBundle::open).transpose()?;
        let choice = SceneChoice { characters: scene.num_characters(), seed: scene.seed };
        Ok(Self { path: path.to_path_buf(), scene, choice, run, standing, bundle, restart: None })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it says.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What runs now.
    pub fn choice(&self) -> SceneChoice {
        self.choice
    }

    /// What is being made, and will run then.
    pub fn restarting(&self) -> Option<SceneChoice> {
        self.restart.as_ref().map(|r| r.choice)
    }

    /// The bundle of the first group that has one.
    pub fn bundle(&self) -> Option<&OpenBundle> {
        self.bundle.as_ref()
    }

    /// The characters and their record.
    pub fn run(&self) -> &SceneRun {
        &self.run
    }

    /// The same, to be played, stopped and rewound.
    pub fn run_mut(&mut self) -> &mut SceneRun {
        &mut self.run
    }

    /// What stands around the characters.
    pub fn standing(&self) -> &Standing {
        &self.standing
    }

    /// Restarts on a thread of its own; [`SceneDocument::take_in`] takes the run in when it is made. A new request replaces
    /// an old one.
    ///
    /// - `wake`: called when it is made.
    ///
    /// # Errors
    /// A message where numbers are out of range; nothing has changed then.
    pub fn restart(&mut self, choice: SceneChoice, wake: impl FnOnce() + Send + 'static) -> Result<(), String> {
        if !(1..=MAX_CHARACTERS).contains(&choice.characters) {
            return Err(format!("expected 1 to {MAX_CHARACTERS} characters, found {}", choice.characters));
        }
        let mut scene = match choice.characters == self.scene.num_characters() {
            true => self.scene.clone(),
            false => self.scene.resized(choice.characters),
        };
        scene.seed = choice.seed;
        scene.check().map_err(|e| e.to_string())?;
        let (send, made) = channel();
        self.restart = Some(Restart { choice, made });
        std::thread::spawn(move || {
            let run = scene.open().map_err(|e| e.to_string()).and_then(|compiled| begin(&compiled));
            // The receiver is gone if another restart was asked for meanwhile.
            if send.send(run).is_ok() {
                wake();
            }
        });
        Ok(())
    }

    /// Takes in a run that has been made since the last call; true where one has.
    ///
    /// - `waits`: until it is made, where one is being made.
    ///
    /// # Errors
    /// A message where it could not be made; the old one continues.
    pub fn take_in(&mut self, waits: bool) -> Result<bool, String> {
        let Some(restart) = &self.restart else { return Ok(false) };
        let made = match waits {
            true => restart.made.recv().map_err(|_| TryRecvError::Disconnected),
            false => restart.made.try_recv(),
        };
        let made = match made {
            Err(TryRecvError::Empty) => return Ok(false),
            Err(TryRecvError::Disconnected) => Err("restarting failed unexpectedly".to_owned()),
            Ok(made) => made,
        };
        let choice = restart.choice;
        self.restart = None;
        let (run, standing) = made?;
        let old = std::mem::replace(&mut self.run, run);
        self.run.head.play_like(&old.head);
        (self.choice, self.standing) = (choice, standing);
        Ok(true)
    }
}

fn begin(compiled: &CompiledScene) -> Result<(SceneRun, Standing), String> {
    let run = SceneRun::new(compiled).map_err(|e| e.to_string())?;
    let standing = standing(compiled, &run)?;
    Ok((run, standing))
}

/// Obstacles of the agents, and the units of all worlds.
fn standing(compiled: &CompiledScene, run: &SceneRun) -> Result<Standing, String> {
    let mut out = Standing::default();
    for cast in run.simulation().casts() {
        match cast {
            GroupCast::Ground(agents) => {
                out.obstacles = agents.layout().setup.obstacles.iter().filter_map(seen_obstacle).collect()
            }
            GroupCast::Air(agents) => {
                out.obstacles = agents.layout().setup.obstacles.iter().filter_map(seen_obstacle).collect();
                out.in_the_air = true;
            }
            _ => {}
        }
    }
    let mut meshes = vec![mesh_of(&out.obstacles, out.in_the_air)];
    let mut seen: Vec<&Path> = Vec::new();
    for g in 0..compiled.scene().groups.len() {
        let (Some(world), (Some(bundle_path), _)) = (compiled.world(g), compiled.scene().bundle_of(g)) else {
            continue;
        };
        if seen.contains(&world.path.as_path()) {
            continue;
        }
        seen.push(&world.path);
        let bundle = compiled.bundle(g).map_err(|e| e.to_string())?;
        let kit = Kit::new(bundle, bundle_path).map_err(|e| e.to_string())?;
        let first = meshes.len() as u32;
        meshes.extend(kit.geometries.iter().map(|g| unit_mesh(g)));
        out.units.extend(world.world.view().units.iter().map(|u| {
            let unit = &kit.units.units[u.unit as usize];
            let (mesh, name) = (first + u.unit, unit.name.clone());
            StandingUnit { mesh, name, is_floor: unit.floor, placement: u.placement }
        }));
    }
    out.meshes = meshes.into();
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::boxing::Boxing;
    use throng_precompute::progress::Silent;

    const GROUPS: &str = r#"
bundle = "boxing.throng"
[[groups]]
name = "boxers"
motion = "sparring"
count = 4
place = { grid = { centre = [20.0, 0.0], distance_m = 1.2 } }
behaviours = [{ name = "approach" }, { name = "throw-punches", weight = 2.0 }]
[[groups]]
name = "crossing"
motion = "none"
count = 6
place = { block = { from = [-6.0, -2.0], to = [-3.0, 2.0] } }
goal = { shift = { by = [8.0, 0.0] } }
at_end = "leave"
[[environment.obstacles]]
disc = { centre = [0.0, 0.0], radius_m = 0.5 }
"#;

    fn open(folder: &Path, text: &str) -> Result<SceneDocument, String> {
        let path = folder.join("both.toml");
        std::fs::write(&path, text).unwrap();
        SceneDocument::open(&path, Scene::load(&path).map_err(|e| e.to_string())?, &Silent)
    }

    /// Places of all characters and joints of all bodies, as bits.
    fn seen(document: &SceneDocument) -> Vec<u32> {
        let (run, all) = (document.run(), 0..document.run().simulation().num_characters());
        let joints = |who| run.simulation().joint_positions(who).into_iter().flatten();
        let points = all.flat_map(|who| run.place(who).into_iter().chain(joints(who)));
        points.flat_map(|p| p.to_array()).map(f32::to_bits).collect()
    }

    #[test]
    fn groups_of_all_kinds_are_played_rewound_and_restarted() {
        let boxing = Boxing::new();
        let folder = boxing.bundle().parent().unwrap().to_path_buf();
        let mut document = open(&folder, GROUPS).unwrap();
        assert!(document.bundle().is_some() && document.standing().obstacles.len() == 1);
        let mut frames = vec![seen(&document)];
        for _ in 0..200 {
            document.run_mut().step().unwrap();
            frames.push(seen(&document));
        }
        assert!(frames[0] != frames[200] && document.run().trail(5, 1.0).count() > 8);
        for step in [199, 60, 59, 130, 0, 200] {
            document.run_mut().seek(step).unwrap();
            assert_eq!(document.run().head.now(), step);
            assert!(seen(&document) == frames[step as usize], "step {step} looks as it did");
        }
        document.run_mut().seek(150).unwrap();
        let now_s = document.run().simulation().time_s();
        assert!((now_s - 2.5).abs() < 1e-9 && document.run().events().all(|e| e.time_s <= now_s));
        let choice = SceneChoice { characters: 20, seed: 9 };
        document.restart(choice, || {}).unwrap();
        assert_eq!(document.restarting(), Some(choice));
        assert!(document.take_in(true).unwrap());
        assert_eq!((document.choice(), document.run().simulation().num_characters()), (choice, 20));
        assert_eq!(document.run().head.now(), 0);
        assert!(document.restart(SceneChoice { characters: 0, ..choice }, || {}).unwrap_err().contains("1 to 100000"));
        std::fs::remove_file(boxing.bundle()).unwrap();
        let e = open(&folder, GROUPS).map(|_| ()).unwrap_err();
        assert!(e.contains("both.toml") && e.contains("boxing.throng"), "{e}");
    }
}
