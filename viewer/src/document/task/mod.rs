//! A task of limbs: its characters and things, and the motions planned for it.

mod worker;

pub use worker::Planning;

use crate::render::{Ray, SolidMesh};
use glam::{DVec3, Quat, Vec3};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use throng_core::base::text::TomlSource;
use throng_geometry::SolidShape;
use throng_planner::task::{ActorClip, Handle, Task, TaskOutcome, TaskScenery, TaskThing};
use throng_planner::{planner::Planners, rotation::Rigid};
use throng_precompute::plans::{self, PlanReport, TaskSources};
use throng_precompute::{Clip, config::BuildConfig, files::write_atomically, run::BuildContext};

/// Things are carried where they are farther than this from where they would be by themselves (m).
const CARRIED_M: f64 = 1e-4;

/// A task with the clips of its walkers, before anything was planned.
#[derive(Clone, Debug)]
pub struct StagedTask {
    /// With the times of everything.
    pub task: Task,
    /// One for each character.
    pub clips: Vec<ActorClip>,
    /// The clips, placed in the scene.
    pub placed: Vec<Clip>,
    /// Positions of all things over time.
    pub scenery: TaskScenery,
}

/// A motion that was planned.
#[derive(Clone, Debug)]
pub struct PlannedMotion {
    /// Seed of the motion.
    pub seed: u64,
    /// Result of the planner.
    pub outcome: TaskOutcome,
    /// Figures of the result.
    pub report: PlanReport,
    /// Distance from the most similar other motion; none for a single motion (rad).
    pub distance_rad: Option<f64>,
}

/// Motions that were planned at once, for one scene.
#[derive(Clone, Debug)]
struct PlannedMotions {
    staged: Arc<StagedTask>,
    all: Vec<PlannedMotion>,
}

/// A task and the motions planned for it.
#[derive(Debug)]
pub struct TaskDocument {
    /// The file.
    pub path: PathBuf,
    pub(super) sources: Arc<TaskSources>,
    /// Task as in the file, with later changes: walkers have no times yet.
    task: Task,
    /// Task with times and clips.
    staged: StagedTask,
    /// One mesh for each thing.
    pub meshes: Arc<[SolidMesh]>,
    motions: Option<PlannedMotions>,
    /// Motion that is shown; none shows the clip before planning.
    shown: Option<usize>,
    /// The plan under way.
    pub planning: Option<Planning>,
    /// State of the last plans, reused by the next ones.
    planners: Arc<Planners>,
    /// Grows with every change of the scene.
    revision: u64,
    /// That for which was planned.
    planned_revision: u64,
}

impl TaskDocument {
    /// The task with all changes; for walkers, with the times of the last plan.
    pub fn task(&self) -> &Task {
        let planned = self.motions.as_ref().filter(|_| !self.is_changed());
        planned.map_or(&self.staged.task, |m| &m.staged.task)
    }

    /// The motions that were planned, of which each has a clip for each character; none before the first plan.
    pub fn motions(&self) -> &[PlannedMotion] {
        self.motions.as_ref().map_or(&[], |m| &m.all)
    }

    /// Motion that is shown; none shows the clip before planning.
    pub fn shown(&self) -> Option<usize> {
        self.shown.filter(|i| *i < self.motions().len())
    }

    /// The motion that is shown.
    pub fn shown_motion(&self) -> Option<&PlannedMotion> {
        self.motions().get(self.shown()?)
    }

    /// Shows a motion, or the clip before planning.
    pub fn show(&mut self, motion: Option<usize>) {
        self.shown = motion.filter(|i| *i < self.motions().len());
    }

    /// True if the scene was changed since the last plan.
    pub fn is_changed(&self) -> bool {
        self.revision != self.planned_revision
    }

    /// Clips of all characters before planning, placed in the scene.
    pub fn clips_before(&self) -> &[Clip] {
        self.motions.as_ref().map_or(&self.staged.placed, |m| &m.staged.placed)
    }

    /// The clip of a character that is shown (character < number of characters).
    pub fn clip(&self, character: usize) -> &Clip {
        match self.shown_motion() {
            Some(motion) => &motion.outcome.clips[character][1],
            None => &self.clips_before()[character],
        }
    }

    /// Clips with their characters.
    pub fn actors(&self) -> &[ActorClip] {
        &self.staged.clips
    }

    /// Frames of the longest clip, and rate (frames, Hz).
    pub fn frames(&self) -> (u32, f32) {
        let clips = self.clips_before();
        let most = clips.iter().map(Clip::num_frames).max().unwrap_or(1);
        (most as u32, clips.first().map_or(30.0, |c| c.rate_hz as f32))
    }

    /// Position of a thing in the motion that is shown (thing < number of things).
    pub fn place_of_thing(&self, thing: usize, time_s: f64) -> Rigid {
        let own = self.staged.scenery.paths[thing].place_at(time_s);
        let Some(motion) = self.shown_motion() else { return own };
        let [before, after] = motion.outcome.scenery.each_ref().map(|s| s.paths[thing].place_at(time_s));
        let is_carried = before.position.distance(after.position) > CARRIED_M
            || throng_planner::rotation::angle_between(before.rotation, after.rotation) > CARRIED_M;
        if is_carried { after } else { own }
    }

    /// Position of a movable thing or place, before a character takes it.
    pub fn place_of(&self, handle: Handle, time_s: f64) -> Option<Rigid> {
        self.staged.task.handle_place(handle, &self.staged.scenery, time_s)
    }

    /// Moves a thing or place by an offset (m).
    pub fn move_by(&mut self, handle: Handle, by: DVec3) {
        if !by.is_finite() {
            return;
        }
        self.task.move_by(handle, by, &self.staged.scenery);
        self.staged.task.move_by(handle, by, &self.staged.scenery);
        self.staged.scenery.move_by(&self.staged.task, handle, by);
        self.revision += 1;
    }

    /// The thing that a ray meets first, where it stands by itself, and where; places that things are brought to are met
    /// within a radius (m).
    pub fn pick(&self, ray: &Ray, time_s: f64, within_m: impl Fn(Vec3) -> f32) -> Option<(Handle, Vec3)> {
        let met = self.task.handles().into_iter().filter_map(|handle| {
            let at = self.place_of(handle, time_s)?;
            let (position, turn): (Vec3, Quat) = (at.position.as_vec3(), at.rotation.as_quat());
            let along = (position - ray.origin).dot(ray.direction);
            let near = along > 0.0 && ray.passes_within(position, within_m(position));
            let met = match handle {
                Handle::Thing(i) => self.meshes.get(i)?.intersect(ray, (position, turn)).or(near.then_some(along)),
                // A place yields to things that lie on it.
                Handle::Place(_) => near.then_some(along - within_m(position)),
            };
            Some((met?, handle))
        });
        let (distance, handle) = met.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((handle, ray.point_at(distance)))
    }

    /// Plans motions in the background; stops the plan under way.
    ///
    /// - `number`: number of motions that differ, as far as the seeds give them.
    /// - `seed`: in place of the task's.
    /// - `goes_on`: starts from the result of the last plans, after a small move; else the same seed gives the same
    ///   motion.
    pub fn plan(&mut self, number: u64, seed: Option<u64>, goes_on: bool) {
        self.cancel();
        self.planners = Arc::new(if goes_on { self.planners.for_next_run() } else { Planners::default() });
        let (sources, planners) = (Arc::clone(&self.sources), Arc::clone(&self.planners));
        let job = worker::PlanningJob { sources, task: self.task.clone(), number, seed, planners };
        self.planning = Some(Planning::begin(job, self.revision, self.task.num_steps()));
    }

    /// Stops the plan under way; the motions stay unchanged.
    pub fn cancel(&mut self) {
        self.planning.take().iter().for_each(Planning::cancel);
    }

    /// Adopts motions planned meanwhile.
    ///
    /// - `waits`: until the plan has ended.
    ///
    /// # Errors
    /// A message where nothing could be planned.
    pub fn adopt_plan(&mut self, waits: bool) -> Result<(), String> {
        let Some((revision, done)) = self.planning.as_ref().and_then(|p| p.poll(waits)) else { return Ok(()) };
        self.planning = None;
        let (staged, all) = done?;
        if revision == self.revision {
            self.staged = StagedTask::clone(&staged);
        }
        self.planned_revision = revision;
        self.shown = Some(self.shown.unwrap_or(0).min(all.len().saturating_sub(1)));
        self.motions = Some(PlannedMotions { staged, all });
        Ok(())
    }

    /// Writes the task with the present positions of things and places: in its file, or beside it.
    ///
    /// # Errors
    /// A message where the file lists other things by now, where names of files would be seen from another folder, or where it cannot be
    /// written.
    pub fn save_task(&self, path: &Path) -> Result<(), String> {
        let folder = |of: &Path| of.parent().and_then(|f| f.join(".").canonicalize().ok());
        if folder(path) != folder(&self.path) {
            return Err(format!(
                "{}: expected a file in the folder of {}: names of motion and meshes are seen from there",
                path.display(),
                self.path.display()
            ));
        }
        let source = TomlSource::read(&self.path, "a task").map_err(|e| e.to_string())?;
        let text = self.task.write_back(&source).map_err(|e| e.to_string())?;
        write_atomically(path, |out| out.write_all(text.as_bytes())).map_err(|e| e.to_string())
    }

    /// Writes the motion that is shown, as `throng plan` does.
    ///
    /// - returns the files that were written.
    ///
    /// # Errors
    /// A message where there is none, where the check found faults in it, or where a file cannot be written.
    pub fn save(&self, path: &Path) -> Result<Vec<PathBuf>, String> {
        let (Some(motion), Some(motions)) = (self.shown_motion(), &self.motions) else {
            return Err("No planned motion is shown; plan one, and choose it in the list.".into());
        };
        if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("bvh")) {
            return Err(format!("{}: expected a name that ends with .bvh", path.display()));
        }
        if let Some(v) = motion.outcome.recheck.violations.first() {
            let (time_s, fault) = (v.time_s, &v.what);
            return Err(format!("Nothing was written: the check found at {time_s:.3} s: {fault}. Try another seed."));
        }
        let StagedTask { task, clips, .. } = &*motions.staged;
        plans::write_plan(task, clips, &motion.outcome, path, 0).map_err(|e| e.to_string())
    }
}

impl StagedTask {
    /// Lets the walkers of a task walk.
    fn walk_walkers(sources: &TaskSources, task: Task, seed: Option<u64>) -> Result<Self, String> {
        let (task, clips) = sources.stage_task(task, seed).map_err(|e| e.to_string())?;
        let (scenery, placed) = task.scenery(&clips).map_err(|e| e.to_string())?;
        Ok(Self { task, clips, placed, scenery })
    }
}

impl TaskDocument {
    /// Reads a task and its motion; nothing is planned yet.
    ///
    /// - `with`: how bundles of walkers are made where they are missing.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn open(path: &Path, with: &BuildContext<'_>) -> Result<Self, String> {
        let task = Task::read(path).map_err(|e| e.to_string())?;
        let config = BuildConfig::of_motion("", Vec::new()).map_err(|e| e.to_string())?;
        let named = |why: String| format!("{}: {why}", path.display());
        let sources = plans::load_sources(&task, &config, None, with).map_err(|e| named(e.to_string()))?;
        let staged = StagedTask::walk_walkers(&sources, task.clone(), None).map_err(named)?;
        let meshes = task.things.iter().map(mesh).collect();
        Ok(Self {
            path: path.to_path_buf(),
            sources: Arc::new(sources),
            task,
            staged,
            meshes,
            motions: None,
            shown: None,
            planning: None,
            planners: Arc::default(),
            revision: 1,
            planned_revision: 0,
        })
    }
}

/// All shapes of a thing, in its frame.
fn mesh(thing: &TaskThing) -> SolidMesh {
    let mut mesh = SolidMesh::default();
    for shape in &thing.shapes {
        match shape {
            SolidShape::Round { core, radius } => mesh.add_bar(core.a.as_vec3(), core.b.as_vec3(), *radius as f32),
            SolidShape::Cuboid { half } => mesh.add_box(Vec3::ZERO, Quat::IDENTITY, half.as_vec3()),
            SolidShape::Mesh(triangles) => triangles.corners().iter().for_each(|t| mesh.add_triangle(*t)),
        }
    }
    mesh
}
