//! `TASK.toml`.

use super::obj;
use crate::collide::EdgeCheck;
use crate::correct::CorrectConfig;
use crate::linkage::Limb;
use crate::planner::{Budget, PlanConfig};
use crate::problem::Solid;
use crate::rotation::{Rigid, exp};
use crate::shape::{Mesh, Segment, Shape};
use crate::track::Path as Motion;
use glam::DVec3;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use throng_base::Result;
use throng_base::file::{MAX_TEXT_BYTES, read_file};
use throng_base::text::{Source, did_you_mean};

const HELP: &str = "A task has `clip`, `[[scene.obstacles]]`, `[[tasks]]` and `[planner]`.";

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TaskFile {
    clip: PathBuf,
    #[serde(default)]
    scene: SceneEntry,
    tasks: Vec<TaskEntry>,
    #[serde(default)]
    planner: PlannerEntry,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneEntry {
    #[serde(default)]
    obstacles: Vec<ObstacleEntry>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObstacleEntry {
    name: String,
    shape: ShapeEntry,
    #[serde(default)]
    at: [f64; 3],
    #[serde(default)]
    turn_deg: [f64; 3],
    #[serde(default)]
    keys: Vec<KeyEntry>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum ShapeEntry {
    Ball { radius: f64 },
    Box { size: [f64; 3] },
    Capsule { from: [f64; 3], to: [f64; 3], radius: f64 },
    Mesh { file: PathBuf },
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyEntry {
    t_s: f64,
    at: [f64; 3],
    #[serde(default)]
    turn_deg: [f64; 3],
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GripEntry {
    at: [f64; 3],
    #[serde(default)]
    turn_deg: [f64; 3],
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TaskEntry {
    limb: Limb,
    #[serde(rename = "do")]
    deed: Deed,
    object: Option<String>,
    at_s: Option<f64>,
    window_s: Option<[f64; 2]>,
    #[serde(default)]
    grips: Vec<GripEntry>,
}

/// What a limb has to do.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(super) enum Deed {
    /// Give way where it collides.
    Correct,
    /// Touch an object and come back.
    Touch,
    /// Take an object along.
    Grab,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct PlannerEntry {
    seed: u64,
    draws: u32,
    budget_s: Option<f64>,
    epsilon_m: f64,
    resolution_rad: Option<f64>,
    clearance_m: f64,
    straighten: u32,
    round_s: f64,
    blend_s: f64,
}

impl Default for PlannerEntry {
    fn default() -> Self {
        let (plan, budget) = (PlanConfig::default(), CorrectConfig::default().budget);
        Self {
            seed: budget.seed,
            draws: budget.draws,
            budget_s: None,
            epsilon_m: plan.search.epsilon_m,
            resolution_rad: None,
            clearance_m: 0.005,
            straighten: plan.smooth.straighten,
            round_s: plan.smooth.round_s,
            blend_s: plan.smooth.blend_s,
        }
    }
}

/// A task that was read: obstacles as solids, tasks in their order.
#[derive(Clone, Debug)]
pub struct Task {
    /// The clip to change, from the file's folder.
    pub clip: PathBuf,
    /// What is around.
    pub solids: Vec<Solid>,
    /// How plans are made; the rate of the budget is the clip's.
    pub config: CorrectConfig<'static>,
    /// How far everything stays from solids (m).
    pub clearance_m: f64,
    pub(super) steps: Vec<Step>,
}

/// One thing to do.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub limb: Limb,
    pub deed: Deed,
    /// Which solid.
    pub object: Option<usize>,
    pub times_s: [f64; 3],
    pub grips: Vec<Rigid>,
}

impl Task {
    /// Reads a task; the meshes that it names, too.
    ///
    /// # Errors
    /// With file and line: faults of TOML, unknown names, numbers that are not finite, meshes that are none.
    pub fn read(path: &Path) -> Result<Self> {
        Self::of(&Source::read(path, "a task")?)
    }

    /// Reads a task from its text; meshes and the clip are looked for beside `path`.
    ///
    /// # Errors
    /// As [`Task::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        Self::of(&Source::new(text, path))
    }

    fn of(source: &Source) -> Result<Self> {
        let file: TaskFile = source.parse(HELP)?;
        let folder = source.path().parent().unwrap_or(Path::new(""));
        let mut solids: Vec<Solid> = Vec::new();
        for (i, o) in file.scene.obstacles.iter().enumerate() {
            let key = format!("scene.obstacles[{i}]");
            if solids.iter().any(|s| s.name == o.name) {
                return Err(source.at(&key, format!("there are two obstacles `{}`; rename one of them", o.name)));
            }
            solids.push(o.solid(folder).map_err(|why| source.at(&key, format!("`{}`: {why}", o.name)))?);
        }
        let step = |(i, t): (usize, &TaskEntry)| t.step(&solids).map_err(|why| source.at(&format!("tasks[{i}]"), why));
        let steps = file.tasks.iter().enumerate().map(step).collect::<Result<_>>()?;
        let config = file.planner.config().map_err(|(key, why)| source.at(&format!("planner.{key}"), why))?;
        let clearance_m = file.planner.clearance_m;
        Ok(Self { clip: folder.join(&file.clip), solids, config, clearance_m, steps })
    }
}

fn placed(at: [f64; 3], turn_deg: [f64; 3]) -> Rigid {
    Rigid { position: DVec3::from(at), rotation: exp(DVec3::from(turn_deg) * (std::f64::consts::PI / 180.0)) }
}

impl ObstacleEntry {
    fn solid(&self, folder: &Path) -> std::result::Result<Solid, String> {
        let shape = match &self.shape {
            ShapeEntry::Ball { radius } => Shape::ball(*radius),
            ShapeEntry::Box { size } => Shape::cuboid(DVec3::from(*size)),
            ShapeEntry::Capsule { from, to, radius } => {
                Shape::Round { core: Segment::new(DVec3::from(*from), DVec3::from(*to)), radius: *radius }
            }
            ShapeEntry::Mesh { file } => mesh(&folder.join(file))?,
        };
        if !shape.is_valid() {
            return Err("expected finite numbers and positive sizes".into());
        }
        let path = if self.keys.is_empty() {
            Motion::Still(placed(self.at, self.turn_deg))
        } else {
            let keys: Vec<(f64, Rigid)> = self.keys.iter().map(|k| (k.t_s, placed(k.at, k.turn_deg))).collect();
            Motion::keys(&keys)
        };
        if !path.is_valid(0.0, 0.0) {
            return Err("expected finite places, and keys whose times ascend".into());
        }
        Ok(Solid { name: self.name.clone(), shape, path })
    }
}

fn mesh(path: &Path) -> std::result::Result<Shape, String> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
        return Err(format!("{}: expected a mesh as OBJ; export it as that", path.display()));
    }
    let bytes = read_file(path, "a mesh", MAX_TEXT_BYTES).map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&bytes);
    let triangles = obj::triangles(&text).map_err(|(line, why)| format!("{}:{line}: {why}", path.display()))?;
    let mesh = Mesh::new(triangles).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(Shape::Mesh(Arc::new(mesh)))
}

impl TaskEntry {
    fn step(&self, solids: &[Solid]) -> std::result::Result<Step, String> {
        let find = |name: &String| {
            let unknown = || {
                let meant = did_you_mean(name, solids.iter().map(|s| s.name.as_str()));
                format!("there is no object `{name}` among the obstacles.{meant}")
            };
            solids.iter().position(|s| s.name == *name).ok_or_else(unknown)
        };
        let object = self.object.as_ref().map(find).transpose()?;
        let grips: Vec<Rigid> = self.grips.iter().map(|g| placed(g.at, g.turn_deg)).collect();
        if grips.iter().any(|g| !g.is_valid()) {
            return Err("grips: expected finite numbers".into());
        }
        let times_s = match (self.deed, self.at_s, self.window_s) {
            (Deed::Correct, None, None) if object.is_none() && grips.is_empty() => [0.0; 3],
            (Deed::Correct, ..) => {
                return Err("`correct` needs nothing but `limb`: it finds collisions by itself".into());
            }
            (_, Some(at_s), Some([from, to])) if from < at_s && at_s < to => [from, at_s, to],
            (_, Some(_), Some(_)) => return Err("expected `at_s` within `window_s`".into()),
            _ => return Err("expected `at_s` and `window_s`, from when to when the limb leaves the clip".into()),
        };
        if self.deed != Deed::Correct && (object.is_none() || grips.is_empty()) {
            return Err("expected `object` and `grips`, where the hand is as seen from the object".into());
        }
        Ok(Step { limb: self.limb, deed: self.deed, object, times_s, grips })
    }
}

impl PlannerEntry {
    fn config(&self) -> std::result::Result<CorrectConfig<'static>, (&'static str, String)> {
        let ranges = [
            ("budget_s", self.budget_s.unwrap_or(1.0), 0.0, 3600.0),
            ("epsilon_m", self.epsilon_m, 0.01, 10.0),
            ("resolution_rad", self.resolution_rad.unwrap_or(0.1), 1e-4, 1.0),
            ("clearance_m", self.clearance_m, 0.0, 0.5),
            ("round_s", self.round_s, 0.0, 10.0),
            ("blend_s", self.blend_s, 0.0, 10.0),
        ];
        for (key, value, least, most) in ranges {
            if !(least..=most).contains(&value) {
                return Err((key, format!("expected {least} to {most}, found {value}")));
            }
        }
        let mut config = CorrectConfig::default();
        config.budget = Budget { draws: self.draws, seconds: self.budget_s, seed: self.seed, ..config.budget };
        config.plan.search.epsilon_m = self.epsilon_m;
        if let Some(resolution_rad) = self.resolution_rad {
            config.plan.search.edge = EdgeCheck::Bisection { resolution_rad };
        }
        config.plan.smooth.straighten = self.straighten;
        config.plan.smooth.round_s = self.round_s;
        config.plan.smooth.blend_s = self.blend_s;
        Ok(config)
    }
}
