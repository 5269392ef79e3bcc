//! A scene: its file, its bundles and worlds, and its run.

use super::obstacles::{DOOR_M, mesh_of};
use super::{background::Background, crowd, world::unit_mesh};
use crate::bundle::OpenBundle;
use crate::render::{Ray, SolidMesh, upright};
use crate::run::{PolicyChooser, SceneChoice, SceneRun};
use glam::{Quat, Vec2, Vec3};
use std::path::{Path, PathBuf};
use std::{collections::BTreeSet, sync::Arc};
use throng_core::base::file::{MAX_SNAPSHOT_BYTES, read_file};
use throng_core::{body::HeightField, patch::Placement};
use throng_crowd::Obstacle;
use throng_level::Level;
use throng_precompute::run::{BuildContext, ensure_scene, obstacle_in_world, policy_characters};
use throng_precompute::{config::BuildConfig, files::write_atomically, stitch::StitchKit};
use throng_simulation::{AnyCharacterGroup, CompiledScene, GroupMotion, Scene};

/// Most characters that a scene may be restarted with from the viewer.
pub const MAX_SCENE_CHARACTERS: usize = 100_000;

/// First line of a saved state.
const MAGIC: &str = "throng-viewer scene 1";
/// Distance of the corners of hills as they are drawn (m).
const HILL_STEP_M: f32 = 1.0;
/// Radius of the bars that show the walls of a level (m).
const KERB_M: f32 = 0.03;
/// Margin of drawn hills beyond the square that characters keep to (m).
const BEYOND_M: f32 = 6.0;

/// Resume point of a scene whose file is read again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneResumePoint {
    /// Settings in the file.
    said: SceneChoice,
    /// Settings of the run.
    choice: SceneChoice,
    /// The step that was shown.
    step: u32,
}

impl SceneResumePoint {
    /// Settings for a new version of the file: those chosen in the viewer, unless the file has changed them.
    fn merge_choice(&self, says: SceneChoice) -> SceneChoice {
        let (said, choice) = (self.said, self.choice);
        SceneChoice {
            characters: if says.characters == said.characters { choice.characters } else { says.characters },
            seed: if says.seed == said.seed { choice.seed } else { says.seed },
            engine: if says.engine == said.engine { choice.engine } else { says.engine },
        }
    }
}

/// Surroundings of the characters: obstacles, hills, units, doors and things.
#[derive(Clone, Debug, Default)]
pub struct SceneSurroundings {
    /// A mesh of all obstacles that stand, the light and the dark fields of hills, then every unit of each world.
    pub meshes: Arc<[SolidMesh]>,
    /// The ground is not level.
    pub has_hills: bool,
    /// Units of worlds: number of the mesh, and the unit.
    pub units: Vec<SceneUnit>,
    /// Obstacles, including moving ones.
    pub obstacles: Vec<Obstacle>,
    /// Agents move in the air.
    pub in_the_air: bool,
    /// Doors, in the order of the scene file.
    pub doors: Vec<SceneDoor>,
    /// Numbers of the meshes of things, in the order of the scene file.
    pub things: Vec<u32>,
}

/// A door, which is an obstacle while closed.
#[derive(Clone, Debug)]
pub struct SceneDoor {
    /// Number of the mesh.
    pub mesh: u32,
    /// Ends of the door (m).
    pub ends: [Vec3; 2],
}

/// A unit of a world where it stands.
#[derive(Clone, Debug)]
pub struct SceneUnit {
    /// Number of the mesh.
    pub mesh: u32,
    /// Name of the unit.
    pub name: String,
    /// True for a unit that is walked on.
    pub is_floor: bool,
    /// Placement in the world.
    pub placement: Placement,
}

/// A run that was started beside the one that is shown, or why it was not.
type StartedRun = Result<(SceneRun, SceneSurroundings), String>;

/// A scene of groups that is open.
pub struct SceneDocument {
    /// The file.
    pub path: PathBuf,
    /// The scene as read from the file.
    pub scene: Scene,
    /// Settings of the present run.
    pub choice: SceneChoice,
    /// The characters and their record.
    pub run: SceneRun,
    /// Surroundings of the characters.
    pub surroundings: SceneSurroundings,
    /// Bundle of the first group that has one.
    bundle: Option<Arc<OpenBundle>>,
    /// True for the crowd of a bundle, whose scene is in no file.
    pub is_crowd: bool,
    /// A new run that is prepared, and its settings.
    restart: Option<(SceneChoice, Background<StartedRun>)>,
    /// Number of restarts.
    pub num_runs: u32,
}

impl SceneSurroundings {
    /// Nearest point at which a ray hits a unit of a world (m).
    pub fn intersect_units(&self, ray: &Ray) -> Option<Vec3> {
        let met =
            self.units.iter().filter_map(|u| self.meshes.get(u.mesh as usize)?.intersect(ray, upright(u.placement)));
        met.min_by(f32::total_cmp).map(|distance| ray.point_at(distance))
    }
}

impl SceneDocument {
    /// Reads a scene, makes the bundles and worlds that are missing, and puts all characters in place.
    ///
    /// # Errors
    /// A message that names the file, the line or key, or what could not be made, and the way out.
    pub fn open(path: &Path, with: &BuildContext<'_>) -> Result<Self, String> {
        let scene = Scene::load(path).map_err(|e| match BuildConfig::load(path) {
            Ok(_) => format!(
                "{}: this is the config of a build, not a scene; open the bundle that `throng build` makes of it",
                path.display()
            ),
            Err(_) => e.to_string(),
        })?;
        Self::start(scene, path, with)
    }

    /// Puts the characters of a scene in place, and makes what is missing, as [`Self::open`].
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn start(scene: Scene, path: &Path, with: &BuildContext<'_>) -> Result<Self, String> {
        let fail = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        ensure_scene(&scene, with).map_err(|e| fail(&e))?;
        let (run, surroundings) = start_run(&scene, None, None)?;
        let compiled = run.simulation().compiled();
        let with_bundle = (0..scene.groups.len()).find(|&g| compiled.find_bundle(g).is_some());
        let bundle = with_bundle.and_then(|g| scene.bundle_of(g).0).map(OpenBundle::open).transpose()?.map(Arc::new);
        let choice = SceneChoice::from_scene(&scene);
        let path = path.to_path_buf();
        Ok(Self { path, scene, choice, run, surroundings, bundle, is_crowd: false, restart: None, num_runs: 0 })
    }

    /// The crowd of a bundle: characters on a plain, each on the way to a target of its own that moves on.
    ///
    /// # Errors
    /// A message where the bundle has no behaviour, its tables do not fit together, or there is no room.
    pub fn crowd_of(bundle: &Arc<OpenBundle>, choice: SceneChoice) -> Result<Self, String> {
        let scene = scene_with_choice(&crowd::scene_of(bundle)?, choice)?;
        let (run, surroundings) = start_run(&scene, Some(bundle), None)?;
        let (path, bundle) = (bundle.path.clone(), Some(Arc::clone(bundle)));
        Ok(Self { path, scene, choice, run, surroundings, bundle, is_crowd: true, restart: None, num_runs: 0 })
    }

    /// The bundle of a crowd; none for a scene in a file, which names its own.
    fn crowd_bundle(&self) -> Option<&Arc<OpenBundle>> {
        self.bundle.as_ref().filter(|_| self.is_crowd)
    }

    /// Present point of the run, to resume it with a later version of the file.
    pub fn resume_point(&self) -> SceneResumePoint {
        let (said, step) = (SceneChoice::from_scene(&self.scene), self.run.head.shown_step());
        SceneResumePoint { said, choice: self.choice, step }
    }

    /// Resumes at the point of an older version of the same file: with its settings, at its time.
    ///
    /// - `is_stopped`: asked before every step.
    ///
    /// # Errors
    /// A message that names the file and why it cannot come so far.
    pub fn resume(&mut self, from: &SceneResumePoint, is_stopped: impl Fn() -> bool) -> Result<(), String> {
        let choice = from.merge_choice(self.choice);
        if choice != self.choice {
            let scene = scene_with_choice(&self.scene, choice)?;
            (self.run, self.surroundings) = start_run(&scene, self.crowd_bundle(), None)?;
            self.choice = choice;
        }
        while self.run.head.shown_step() < from.step {
            let at_s = self.run.simulation().time_s();
            if is_stopped() {
                return Err(format!("{}: reading it again was stopped at {at_s:.1} s", self.path.display()));
            }
            self.run.step().map_err(|e| format!("{}: after {at_s:.1} s: {e}", self.path.display()))?;
        }
        Ok(())
    }

    /// Settings of the run in preparation.
    pub fn restarting(&self) -> Option<SceneChoice> {
        self.restart.as_ref().map(|r| r.0)
    }

    /// The bundle of the first group that has one.
    pub fn bundle(&self) -> Option<&OpenBundle> {
        self.bundle.as_deref()
    }

    /// Bundles, worlds and world files of the scene that exist, each once.
    pub fn more_files(&self) -> Vec<PathBuf> {
        let groups = self.scene.groups.iter().enumerate().filter(|(_, g)| g.motion != GroupMotion::None);
        let files = groups.flat_map(|(g, group)| {
            let (world, source) = self.scene.world_of(g);
            let of_world = [world, source].into_iter().filter(move |_| group.motion == GroupMotion::Patches);
            of_world.chain([self.scene.bundle_of(g).0]).flatten().filter(|f| f.exists()).map(Path::to_path_buf)
        });
        files.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// A character that chooses by policies of the bundle, with all data of its choices; none for any other.
    pub fn chooser(&self, who: usize) -> Option<PolicyChooser<'_>> {
        let simulation = self.run.simulation();
        let group = simulation.groups().iter().find(|g| g.characters.contains(&who))?;
        let bundle = self.bundle()?;
        if simulation.compiled().find_bundle(group.number)?.hash() != bundle.tables().hash() {
            return None;
        }
        let (goals, _, choice, number) = self.run.recorded_choice(who)?;
        let character_group = simulation.locate(who).0;
        let characters = policy_characters(character_group)?.characters();
        let bouts = if let AnyCharacterGroup::Sparring(s) = character_group { Some(s.sparring()) } else { None };
        let threat = bouts.and_then(|s| s.threats().get(number).copied());
        let (target, now) = (simulation.target(who)?, self.run.head.shown_step());
        let temperature = simulation.scene().groups[group.number].temperature as f32;
        Some(PolicyChooser { bundle, characters, number, goals, choice, target, threat, temperature, now })
    }

    /// Names and weights of the behaviours of a character's group; none for a character that does not choose.
    pub fn weights(&self, who: usize) -> Option<(Vec<&str>, &[f32])> {
        let (_, weights, _, _) = self.run.recorded_choice(who)?;
        let group = self.run.simulation().groups().iter().find(|g| g.characters.contains(&who))?;
        let behaviours = &self.scene.groups[group.number].behaviours;
        Some((behaviours.iter().map(|b| b.name.as_str()).collect(), weights))
    }

    /// Restarts on its own thread; [`SceneDocument::adopt_restart`] adopts the finished run. A new request replaces the old
    /// one.
    ///
    /// - `kept`: the state to begin with, which [`throng_simulation::Simulation::snapshot`] gave.
    /// - `wake`: called when the run is ready.
    ///
    /// # Errors
    /// A message where numbers are out of range; nothing has changed then.
    pub fn restart(
        &mut self,
        choice: SceneChoice,
        kept: Option<Vec<u8>>,
        wake: impl FnOnce() + Send + 'static,
    ) -> Result<(), String> {
        let scene = scene_with_choice(&self.scene, choice)?;
        let bundle = self.crowd_bundle().cloned();
        let run = move || start_run(&scene, bundle.as_ref(), kept.as_deref());
        self.restart = Some((choice, Background::start(run, wake)));
        Ok(())
    }

    /// Takes in a run that has been made since the last call; true where one has.
    ///
    /// - `waits`: blocks until the run in preparation is ready.
    ///
    /// # Errors
    /// A message where it could not be made; the old one continues.
    pub fn adopt_restart(&mut self, waits: bool) -> Result<bool, String> {
        let lost = || Err("restarting failed unexpectedly".to_owned());
        let poll = |(choice, run): &(_, Background<_>)| Some((*choice, run.poll(waits, lost)?));
        let Some((choice, made)) = self.restart.as_ref().and_then(poll) else { return Ok(false) };
        self.restart = None;
        let (run, standing) = made?;
        let old = std::mem::replace(&mut self.run, run);
        self.run.head.play_like(&old.head);
        (self.choice, self.surroundings) = (choice, standing);
        self.num_runs += 1;
        Ok(true)
    }

    /// Writes the state at the step shown.
    ///
    /// # Errors
    /// A message that names the file and the reason.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        let choice = serde_json::to_string(&self.choice).map_err(|e| e.to_string())?;
        let state = self.run.simulation().snapshot();
        write_atomically(path, |out| {
            writeln!(out, "{MAGIC}\n{choice}")?;
            out.write_all(&state)
        })
        .map_err(|e| e.to_string())
    }

    /// Goes on from a state that was written; as [`SceneDocument::restart`].
    ///
    /// # Errors
    /// A message that names the file and what is wrong with it.
    pub fn restore(&mut self, path: &Path, wake: impl FnOnce() + Send + 'static) -> Result<(), String> {
        let name = path.display();
        let bytes = read_file(path, "a saved state", MAX_SNAPSHOT_BYTES).map_err(|e| e.to_string())?;
        let mut parts = bytes.splitn(3, |&b| b == b'\n');
        let (magic, choice, state) = (parts.next(), parts.next(), parts.next());
        let wrong = || format!("{name}: this is not a saved state of a scene; the panel Control saves them");
        let (Some(choice), Some(state)) = (choice.filter(|_| magic == Some(MAGIC.as_bytes())), state) else {
            return Err(wrong());
        };
        let choice = serde_json::from_slice(choice).map_err(|_| wrong())?;
        self.restart(choice, Some(state.to_vec()), wake).map_err(|e| format!("{name}: {e}"))
    }
}

/// A scene with other settings.
fn scene_with_choice(scene: &Scene, choice: SceneChoice) -> Result<Scene, String> {
    if !(1..=MAX_SCENE_CHARACTERS).contains(&choice.characters) {
        return Err(format!("expected 1 to {MAX_SCENE_CHARACTERS} characters, found {}", choice.characters));
    }
    let is_as_large = choice.characters == scene.num_characters();
    let mut scene = if is_as_large { scene.clone() } else { scene.resized(choice.characters) };
    (scene.seed, scene.agents.engine) = (choice.seed, choice.engine);
    scene.check().map_err(|e| e.to_string())?;
    Ok(scene)
}

/// Starts a run of a scene.
///
/// - `crowd`: bundle of a crowd, whose characters start farther apart where they have no room.
/// - `kept`: the state to begin with.
fn start_run(scene: &Scene, crowd: Option<&Arc<OpenBundle>>, kept: Option<&[u8]>) -> StartedRun {
    let run = match crowd {
        Some(bundle) => crowd::start_run(scene, bundle, kept),
        None => scene.open().and_then(|compiled| SceneRun::new(&compiled, kept, false)),
    };
    let run = run.map_err(|e| e.to_string())?;
    let standing = build_surroundings(run.simulation().compiled(), &run)?;
    Ok((run, standing))
}

/// Obstacles of the agents, and the units of all worlds.
fn build_surroundings(compiled: &CompiledScene, run: &SceneRun) -> Result<SceneSurroundings, String> {
    let mut out = SceneSurroundings::default();
    let mut hills: [SolidMesh; 2] = Default::default();
    let mut doors = Vec::new();
    for character_group in run.simulation().character_groups() {
        match character_group {
            AnyCharacterGroup::Travel(people) if people.layout().setup.streets.is_some() => {
                let (walls, all) = people.layout().walls_and_doors();
                out.obstacles = walls.iter().map(obstacle_in_world).collect();
                doors = all.iter().map(obstacle_in_world).collect();
            }
            AnyCharacterGroup::Ground(agents) => {
                let (walls, all) = agents.layout().walls_and_doors();
                out.obstacles = walls.iter().map(obstacle_in_world).collect();
                doors = all.iter().map(obstacle_in_world).collect();
            }
            AnyCharacterGroup::Air(agents) => {
                out.obstacles = agents.layout().setup.obstacles.iter().map(obstacle_in_world).collect();
                out.in_the_air = true;
            }
            _ => {}
        }
    }
    for group in run.simulation().groups() {
        let paths = compiled.scene().groups[group.number].paths.as_ref();
        if let (Some(paths), AnyCharacterGroup::Paths(wanderers)) =
            (paths, &run.simulation().character_groups()[group.character_group])
            && !wanderers.ground().is_flat()
        {
            out.has_hills = true;
            add_fields(&mut hills, wanderers.ground(), paths.centre.into(), 0.5 * paths.area_m + BEYOND_M);
        }
    }
    // Obstacles in the air have no heights.
    let heights = compiled.scene().environment.heights_m().chain(std::iter::repeat(DOOR_M));
    let mut meshes = vec![mesh_of(out.obstacles.iter().zip(heights), out.in_the_air)];
    if let Some(level) = compiled.scene().level.as_ref().filter(|level| level.all_floors) {
        let level = Level::open(&level.file).map_err(|e| e.to_string())?;
        let polygons = 0..level.num_polygons() as u32;
        polygons.flat_map(|p| level.triangles(p)).for_each(|t| hills[0].add_triangle(t.map(Vec3::from)));
        level.walls().iter().for_each(|w| meshes[0].add_bar(w.from.into(), w.to.into(), KERB_M));
        out.has_hills = true;
    }
    meshes.extend(hills);
    let mut seen: BTreeSet<&Path> = BTreeSet::new();
    for g in 0..compiled.scene().groups.len() {
        let (Some(world), (Some(bundle_path), _)) = (compiled.world(g), compiled.scene().bundle_of(g)) else {
            continue;
        };
        if !seen.insert(&world.path) {
            continue;
        }
        let bundle = compiled.bundle(g).map_err(|e| e.to_string())?;
        let kit = StitchKit::new(bundle, bundle_path).map_err(|e| e.to_string())?;
        let first = meshes.len() as u32;
        meshes.extend(kit.geometries.iter().map(|g| unit_mesh(g)));
        for u in world.world.view().units.iter() {
            let Some(unit) = kit.units.units.get(u.unit as usize) else {
                let (name, number, most) = (world.path.display(), u.unit, kit.units.units.len());
                let what = format!("{name}: it has unit number {number}, but {most} unit(s) are known");
                return Err(format!("{what}. Stitch it again with `throng stitch`"));
            };
            let (mesh, name) = (first + u.unit, unit.name.clone());
            out.units.push(SceneUnit { mesh, name, is_floor: unit.floor, placement: u.placement });
        }
    }
    for door in doors {
        if let Obstacle::Wall { from, to, .. } = door {
            out.doors.push(SceneDoor { mesh: meshes.len() as u32, ends: [from, to] });
            meshes.push(mesh_of([(&door, DOOR_M)], false));
        }
    }
    for thing in run.simulation().things() {
        out.things.push(meshes.len() as u32);
        let mut mesh = SolidMesh::default();
        mesh.add_box(Vec3::ZERO, Quat::IDENTITY, 0.5 * thing.size);
        meshes.push(mesh);
    }
    out.meshes = meshes.into();
    Ok(out)
}

/// Triangles of the ground, as the light and the dark fields of a chequered pattern that shows slopes.
///
/// - `centre`, `half`: of the square that is drawn, and half its side (m).
fn add_fields(fields: &mut [SolidMesh; 2], ground: &HeightField, centre: Vec2, half: f32) {
    let n = (2.0 * half / HILL_STEP_M).ceil() as usize;
    let corner = |i: usize, k: usize| {
        let at = centre + Vec2::new(i as f32, k as f32) * (2.0 * half / n as f32) - half;
        Vec3::new(at.x, ground.ground_at(at, 0.0).height, at.y)
    };
    for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
        let [a, b, c, d] = [corner(i, k), corner(i, k + 1), corner(i + 1, k + 1), corner(i + 1, k)];
        let field = &mut fields[(i + k) % 2];
        field.add_triangle([a, b, c]);
        field.add_triangle([a, c, d]);
    }
}

#[cfg(test)]
mod tests;
