//! Checked contents of `TASK.toml`.

use super::entries::{
    CharacterEntry, PaceEntry, PlannerEntry, ShapeEntry, TaskAction, TaskFile, ThingEntry, WalkEntry,
};
use super::{NameTable, TaskStep, mesh};
use crate::planner::{Budget, PlanConfig};
use crate::rotation::{Rigid, exp, rotation_about};
use crate::track::RigidPath as Motion;
use crate::{correct::CorrectConfig, linkage::Limb, refuse, smooth::SmoothConfig, stiff_mesh::StiffMesh};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use throng_base::{Error, error::ensure, text::TomlSource};
use throng_core::{Joint, Skeleton};
use throng_geometry::{Segment, SolidShape};
use throng_motion::{import::ImportConfig, wearer::SkinnedFigure};

pub use super::entries::ClipEntry;

const HELP: &str = "A task has `clip`, `[[characters]]`, `[[scene.obstacles]]`, `[[scene.objects]]`, `[[tasks]]` and \
                    `[planner]`; `throng schema --of task` lists every key.";
/// Largest distance of anything from the origin, or from what it is seen from (m).
pub(super) const MOST_M: f64 = 1e4;
/// Longest time that a character goes on, or a limb keeps its pose (s).
pub(super) const MOST_S: f64 = 600.0;
/// Most entries of a list.
pub(super) const MOST: usize = 1000;

/// A character of a task.
#[derive(Clone, Debug)]
pub struct TaskCharacter {
    /// Name in tasks and messages.
    pub name: String,
    /// Motion; the path of a file includes the task's folder.
    pub clip: ClipEntry,
    /// Offset and turn of its motion.
    pub placed: Rigid,
    /// Figure that it wears.
    pub body: Option<WornFigure>,
}

/// A figure with a skin that a character wears.
#[derive(Clone)]
pub struct WornFigure {
    /// Its file.
    pub path: PathBuf,
    /// Contents of the file.
    pub figure: Arc<SkinnedFigure>,
}

impl std::fmt::Debug for WornFigure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Body").field("path", &self.path).finish_non_exhaustive()
    }
}

impl WornFigure {
    fn read(path: &Path) -> Result<Self, String> {
        let figure = SkinnedFigure::open(path, &ImportConfig::default()).map_err(|e| e.to_string())?;
        StiffMesh::from_figure(&figure, &Skeleton::default()).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(Self { path: path.to_path_buf(), figure: Arc::new(figure) })
    }
}

/// An obstacle or an object.
#[derive(Clone, Debug)]
pub struct TaskThing {
    /// Name in tasks and messages.
    pub name: String,
    /// Shapes, all of them in its frame.
    pub shapes: Vec<SolidShape>,
    /// Place until it is taken.
    pub start: ThingStart,
    /// True where it can be taken.
    pub is_object: bool,
}

/// Place of a thing at first.
#[derive(Clone, Debug)]
pub enum ThingStart {
    /// Motion of its own.
    Path(Motion),
    /// Carried by a joint of a character.
    OnJoint {
        /// Index of the character.
        character: usize,
        /// Its joint.
        joint: Joint,
        /// The thing in the joint's frame.
        offset: Rigid,
    },
}

/// A task as read from a file.
#[derive(Clone, Debug)]
pub struct Task {
    /// Characters: first the one whose clip the task is about.
    pub characters: Vec<TaskCharacter>,
    /// Obstacles and objects.
    pub things: Vec<TaskThing>,
    /// Settings of plans; the rate of the budget is the clip's.
    pub config: CorrectConfig<'static>,
    /// Least distance of everything from things (m).
    pub clearance_m: f64,
    /// True turns heads to the targets of limbs.
    pub gaze: bool,
    /// True bends trunks where an arm does not reach otherwise.
    pub lean: bool,
    /// True keeps the weight over planted feet where trunks bend, and reports how far it is off them.
    pub balance: bool,
    pub(super) steps: Vec<TaskStep>,
}

impl Task {
    /// Reads a task, and the meshes that it names.
    ///
    /// # Errors
    /// Errors with file and line: faults of TOML, unknown names, numbers that are not finite, invalid meshes.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_source(&TomlSource::read(path, "a task")?)
    }

    /// Reads a task from its text; meshes and clips are looked for beside `path`.
    ///
    /// # Errors
    /// As [`Task::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, Error> {
        Self::from_source(&TomlSource::new(text, path))
    }

    /// The schema of task files.
    pub fn json_schema() -> schemars::Schema {
        schemars::schema_for!(TaskFile)
    }

    /// Number of steps.
    pub fn num_steps(&self) -> usize {
        self.steps.len()
    }

    /// Names of the steps.
    pub fn step_names(&self) -> impl Iterator<Item = &str> {
        self.steps.iter().map(|s| s.name.as_str())
    }

    /// Time at which each step reaches its target; none for corrections, and before the character has walked there (s).
    pub fn times_s(&self) -> Vec<Option<f64>> {
        let one = |s: &TaskStep| (s.action != TaskAction::Correct && s.is_timed()).then_some(s.times_s[1]);
        self.steps.iter().map(one).collect()
    }

    /// Character and limb of each step that has a time, with the window in which the limb moves to its target (s).
    pub fn reach_windows(&self) -> impl Iterator<Item = (usize, Limb, [f64; 2])> + '_ {
        let timed = self.steps.iter().filter(|s| s.action != TaskAction::Correct && s.is_timed());
        timed.map(|s| (s.character, s.limb, [s.times_s[0], s.times_s[1]]))
    }

    fn from_source(source: &TomlSource) -> Result<Self, Error> {
        let file: TaskFile = source.parse(HELP)?;
        let folder = source.path().parent().unwrap_or(Path::new(""));
        let numbers = [
            ("characters", file.characters.len()),
            ("scene.obstacles", file.scene.obstacles.len()),
            ("scene.objects", file.scene.objects.len()),
            ("tasks", file.tasks.len()),
        ];
        if let Some((key, n)) = numbers.into_iter().find(|(_, n)| *n > MOST) {
            return Err(source.error_at_key(key, format!("expected {MOST} at most, found {n}")));
        }
        let clip = resolve_clip(&file.clip, folder).map_err(|why| source.error_at_key("clip", why))?;
        let mut names = vec![file.name.clone()];
        let body = file.body.as_ref().map(|b| WornFigure::read(&folder.join(b))).transpose();
        let body = body.map_err(|why| source.error_at_key("body", why))?;
        let mut characters = vec![TaskCharacter { name: file.name.clone(), clip, placed: Rigid::IDENTITY, body }];
        for (i, c) in file.characters.iter().enumerate() {
            let key = format!("characters[{i}]");
            let character = new_name(&mut names, &c.name).and_then(|()| c.character(folder));
            characters.push(character.map_err(|why| source.error_at_key(&key, why))?);
        }
        let mut things: Vec<TaskThing> = Vec::new();
        let lists = [("obstacles", &file.scene.obstacles, false), ("objects", &file.scene.objects, true)];
        for (list, entries, is_object) in lists {
            for (i, o) in entries.iter().enumerate() {
                let key = format!("scene.{list}[{i}]");
                new_name(&mut names, &o.name).map_err(|why| source.error_at_key(&key, why))?;
                let thing = o.thing(folder, &characters, is_object);
                things.push(thing.map_err(|why| source.error_at_key(&key, format!("`{}`: {why}", o.name)))?);
            }
        }
        let steps = NameTable { characters: &characters, things: &things }.steps(&file.tasks);
        let steps = steps.map_err(|(i, why)| source.error_at_key(&format!("tasks[{i}]"), why))?;
        let config = file.planner.config().map_err(|(key, why)| source.error_at_key(&format!("planner.{key}"), why))?;
        let PlannerEntry { clearance_m, gaze, lean, balance, .. } = file.planner;
        Ok(Self { characters, things, config, clearance_m, gaze, lean, balance, steps })
    }
}

fn new_name(names: &mut Vec<String>, name: &str) -> Result<(), String> {
    let is_other = name.is_empty() || name.contains(['.', '/', '\\']) || Joint::from_name(name).is_some();
    refuse(is_other, format_args!("expected a name without `.` and `/` that no joint has, found `{name}`"))?;
    refuse(names.iter().any(|n| n == name), format_args!("there are two of `{name}`; rename one of them"))?;
    names.push(name.into());
    Ok(())
}

fn resolve_clip(entry: &ClipEntry, folder: &Path) -> Result<ClipEntry, String> {
    let kinds = [entry.file.is_some(), entry.synth.is_some(), entry.walk.is_some()];
    let is_none = kinds.iter().filter(|k| **k).count() != 1 || (entry.clip.is_some() && entry.synth.is_none());
    refuse(is_none, format_args!("expected `file`, or `synth` with or without `clip`, or `walk`"))?;
    if let Some(walk) = &entry.walk {
        return resolve_walk(entry, walk, folder);
    }
    let (from_s, to_s) = (entry.from_s, entry.to_s.unwrap_or(f64::INFINITY));
    let is_part = from_s >= 0.0 && from_s < to_s;
    refuse(!is_part, format_args!("expected 0 <= from_s < to_s, found {from_s} and {to_s}"))?;
    let file: Option<PathBuf> = entry.file.as_ref().map(|f| folder.join(f));
    Ok(ClipEntry { file, ..entry.clone() })
}

fn resolve_walk(entry: &ClipEntry, walk: &WalkEntry, folder: &Path) -> Result<ClipEntry, String> {
    let is_part = entry.from_s != 0.0 || entry.to_s.is_some();
    refuse(is_part, format_args!("`walk` goes on until everything is done: expected no `from_s` and no `to_s`"))?;
    let is_place = walk.from.iter().all(|c| c.abs() < MOST_M) && walk.heading_deg.abs() < 1e6;
    refuse(!is_place, format_args!("walk: expected `from` within {MOST_M} m and a finite `heading_deg`"))?;
    let speed = walk.speed_mps;
    refuse(!(0.3..=4.0).contains(&speed), format_args!("walk: speed_mps: expected 0.3 to 4, found {speed}"))?;
    not_many("walk: pace", walk.pace.len())?;
    let ascend = walk.pace.first().is_none_or(|p| p.t_s == 0.0) && walk.pace.windows(2).all(|w| w[0].t_s < w[1].t_s);
    let is_possible = |p: &PaceEntry| p.t_s <= MOST_S && (0.0..=8.0).contains(&p.speed_mps);
    let is_pace = ascend && walk.pace.len() != 1 && walk.pace.iter().all(is_possible);
    let expected = "two times at least, ascending from 0";
    refuse(!is_pace, format_args!("walk: pace: expected {expected} to {MOST_S} s at most, and speeds of 0 to 8 m/s"))?;
    let (bundle, config) = (folder.join(&walk.bundle), walk.config.as_ref().map(|c| folder.join(c)));
    let walk = WalkEntry { bundle, config, ..walk.clone() };
    Ok(ClipEntry { walk: Some(walk), ..entry.clone() })
}

/// Refuses a list that is too long.
pub(super) fn not_many(list: &str, len: usize) -> Result<(), String> {
    refuse(len > MOST, format_args!("{list}: expected {MOST} at most, found {len}"))
}

/// True for a position that is finite and within [`MOST_M`].
pub(super) fn is_within_scene(at: &Rigid) -> bool {
    at.is_valid() && at.position.abs().max_element() <= MOST_M
}

pub(super) fn rigid_of_entry(at: [f64; 3], turn_deg: [f64; 3]) -> Rigid {
    Rigid { position: DVec3::from(at), rotation: exp(DVec3::from(turn_deg) * (std::f64::consts::PI / 180.0)) }
}

impl CharacterEntry {
    fn character(&self, folder: &Path) -> Result<TaskCharacter, String> {
        let rotation = rotation_about(DVec3::Y, self.heading_deg.to_radians());
        let placed = Rigid { position: DVec3::from(self.at), rotation };
        refuse(!is_within_scene(&placed), format_args!("expected a finite `heading_deg`, and `at` within {MOST_M} m"))?;
        let body = self.body.as_ref().map(|b| WornFigure::read(&folder.join(b))).transpose()?;
        Ok(TaskCharacter { name: self.name.clone(), clip: resolve_clip(&self.clip, folder)?, placed, body })
    }
}

/// Character and joint of `CHARACTER.JOINT`.
pub(super) fn joint_of(name: &str, characters: &[TaskCharacter]) -> Result<(usize, Joint), String> {
    let wrong = || {
        let known: Vec<&str> = characters.iter().map(|c| c.name.as_str()).collect();
        let (first, all) = (known[0], known.join(", "));
        format!("expected CHARACTER.JOINT, such as `{first}.right_hand`, found `{name}`; characters are {all}")
    };
    let (who, joint) = name.rsplit_once('.').ok_or_else(wrong)?;
    let who = characters.iter().position(|c| c.name == who).ok_or_else(wrong)?;
    Ok((who, Joint::from_name(joint).ok_or_else(wrong)?))
}

impl ThingEntry {
    fn thing(&self, folder: &Path, characters: &[TaskCharacter], is_object: bool) -> Result<TaskThing, String> {
        let entries: Vec<&ShapeEntry> = self.shape.iter().chain(&self.shapes).collect();
        refuse(!(1..=MOST).contains(&entries.len()), format_args!("expected `shape`, or 1 to {MOST} `shapes`"))?;
        let shapes: Vec<SolidShape> = entries.iter().map(|s| s.shape(folder)).collect::<Result<_, _>>()?;
        refuse(!shapes.iter().all(SolidShape::is_valid), format_args!("expected finite numbers and positive sizes"))?;
        let here = rigid_of_entry(self.at, self.turn_deg);
        let keys: Vec<(f64, Rigid)> = self.keys.iter().map(|k| (k.t_s, rigid_of_entry(k.at, k.turn_deg))).collect();
        let start = match (&self.attached_to, keys.is_empty()) {
            (Some(_), _) if !is_object => return Err("obstacles are attached to nothing; list it in `objects`".into()),
            (Some(_), false) => return Err("expected `keys` or `attached_to`, found both".into()),
            (Some(name), true) => {
                let (character, joint) = joint_of(name, characters)?;
                ThingStart::OnJoint { character, joint, offset: here }
            }
            (None, false) => ThingStart::Path(Motion::from_keys(&keys)),
            (None, true) => ThingStart::Path(Motion::Still(here)),
        };
        let ascends = if let ThingStart::Path(path) = &start { path.is_valid() } else { true };
        let is_valid = ascends && is_within_scene(&here) && keys.iter().all(|(_, at)| is_within_scene(at));
        refuse(!is_valid, format_args!("expected finite places within {MOST_M} m, and keys whose times ascend"))?;
        Ok(TaskThing { name: self.name.clone(), shapes, start, is_object })
    }
}

impl ShapeEntry {
    fn shape(&self, folder: &Path) -> Result<SolidShape, String> {
        Ok(match self {
            Self::Ball { radius, at } => {
                SolidShape::Round { core: Segment::new(DVec3::from(*at), DVec3::from(*at)), radius: *radius }
            }
            Self::Box { size } => SolidShape::cuboid(DVec3::from(*size)),
            Self::Capsule { from, to, radius } => {
                SolidShape::Round { core: Segment::new(DVec3::from(*from), DVec3::from(*to)), radius: *radius }
            }
            Self::Mesh { file, unit_m, open } => mesh::read_mesh(&folder.join(file), *unit_m, *open)?,
        })
    }
}

impl Default for PlannerEntry {
    fn default() -> Self {
        let (plan, correct) = (PlanConfig::default(), CorrectConfig::default());
        Self {
            seed: correct.budget.seed,
            draws: correct.budget.draws,
            budget_s: None,
            epsilon_m: plan.search.epsilon_m,
            clearance_m: 0.005,
            straighten: plan.smooth.straighten,
            round_s: plan.smooth.round_s,
            blend_s: plan.smooth.blend_s,
            gaze: false,
            lean: false,
            balance: false,
            margin_s: correct.margin_s,
        }
    }
}

impl PlannerEntry {
    fn config(&self) -> Result<CorrectConfig<'static>, (&'static str, String)> {
        let ranges = [
            ("draws", f64::from(self.draws), 0.0, 1e6),
            ("budget_s", self.budget_s.unwrap_or(1.0), 0.0, 3600.0),
            ("epsilon_m", self.epsilon_m, 0.01, 10.0),
            ("clearance_m", self.clearance_m, 0.0, 0.5),
            ("straighten", f64::from(self.straighten), 0.0, 1e4),
            ("round_s", self.round_s, 0.0, 10.0),
            ("blend_s", self.blend_s, 0.0, 10.0),
            ("margin_s", self.margin_s, 0.03, 10.0),
        ];
        for (key, value, least, most) in ranges {
            let why = || format!("planner.{key}: expected {least} to {most}, found {value}");
            ensure((least..=most).contains(&value), || (key, why()))?;
        }
        let mut config = CorrectConfig::default();
        config.budget = Budget { draws: self.draws, seconds: self.budget_s, seed: self.seed, ..config.budget };
        config.plan.search.epsilon_m = self.epsilon_m;
        config.plan.smooth = SmoothConfig { straighten: self.straighten, round_s: self.round_s, blend_s: self.blend_s };
        config.margin_s = self.margin_s;
        config.margin_most_s = config.margin_most_s.max(self.margin_s);
        Ok(config)
    }
}
