//! Motion of a task's characters: files, synthetic motion, and bundles of walkers.

use super::config_error;
use crate::run::{BuildContext, News, ensure_bundle};
use std::path::{Path, PathBuf};
use throng_bake::{config::BuildConfig, pipeline};
use throng_core::blend::{BlendSpace, axis};
use throng_core::{Bundle, FormatError, NUM_JOINTS, base::text::did_you_mean};
use throng_motion::error::{BuildError, Result, ensure};
use throng_motion::import::{self, ImportedClip};
use throng_motion::{Clip, ClipSet, Warnings};
use throng_planner::task::{ActorClip, ActorSource, ClipEntry, Task, WalkEntry, WalkError, WalkedTask};
use throng_synth::{SynthConfig, SynthSet, make_set};

/// Motion of every character, loaded once.
#[derive(Clone, Debug)]
pub struct TaskSources {
    motions: Vec<ActorSource>,
    rate_hz: f64,
    /// Files that the motion was read from.
    pub files: Vec<PathBuf>,
}

impl TaskSources {
    /// One clip for each character, on the database skeleton, and the task with the times of its walks.
    ///
    /// - `seed`: replaces the task's.
    ///
    /// # Errors
    /// [`WalkError`].
    pub fn stage_task(&self, task: Task, seed: Option<u64>) -> Result<(Task, Vec<ActorClip>), WalkError> {
        let clip = |r: &ActorSource| if let ActorSource::Clip(clip) = r { Some(clip.clone()) } else { None };
        let clips: Vec<ActorClip> = self.motions.iter().filter_map(clip).collect();
        if clips.len() == self.motions.len() {
            return Ok((task, clips));
        }
        let WalkedTask { task, clips } = task.plan_walks(&self.motions, self.rate_hz, seed)?;
        Ok((task, clips))
    }
}

/// Loads the motion of a task.
///
/// - `main`: replaces the first character's clip.
/// - `with`: cache and progress for building missing bundles of walkers.
///
/// # Errors
/// The character, and the fault of its motion.
pub fn load_sources(
    task: &Task,
    config: &BuildConfig,
    main: Option<ActorClip>,
    with: &BuildContext<'_>,
) -> Result<TaskSources> {
    let (mut given, mut files) = (main, Vec::new());
    let mut of_each = Vec::new();
    for c in &task.characters {
        let named = |e: BuildError| config_error(format!("`{}`: {e}", c.name));
        of_each.push(match (given.take(), &c.clip.walk) {
            (Some(clip), _) => ActorSource::Clip(clip),
            (None, Some(walk)) => {
                files.push(walk.bundle.clone());
                ActorSource::Walks(blend_space(walk, with).map_err(named)?)
            }
            (None, None) => {
                files.extend(c.clip.file.clone().filter(|f| f.is_file()));
                ActorSource::Clip(task_clip(&c.clip, config, with).map_err(named)?)
            }
        });
    }
    Ok(TaskSources { motions: of_each, rate_hz: config.resample.rate_hz, files })
}

fn blend_space(walk: &WalkEntry, with: &BuildContext<'_>) -> Result<BlendSpace> {
    ensure_bundle(&walk.bundle, walk.config.as_deref(), with)?;
    let path = walk.bundle.display();
    let wrong = |e: FormatError| match e {
        FormatError::Io { .. } => BuildError::Format(e.to_string()),
        e => BuildError::Format(format!("{path}: {e}")),
    };
    let bundle = Bundle::open(&walk.bundle).map_err(wrong)?;
    let names = &bundle.blends().names;
    let Some(name) = walk.space.as_ref().or(names.first()) else {
        return Err(config_error(format!("{path} has no blend spaces; build one (docs/blending.md)")));
    };
    let space = bundle.blend(name).map_err(|e| config_error(format!("{path}: {e}")))?;
    let why = || format!("`{name}` cannot walk here: expected a blend space whose first axis is speed");
    ensure(space.axes().first().is_some_and(|a| a.kind == axis::SPEED), || config_error(why()))?;
    Ok(space)
}

fn task_clip(entry: &ClipEntry, config: &BuildConfig, with: &BuildContext<'_>) -> Result<ActorClip> {
    let whole = match (&entry.file, &entry.synth) {
        (Some(file), _) => file_clip(file, config, with.report_news)?,
        (None, Some(set)) => synthetic_clip(set, entry.clip.as_deref(), config.resample.rate_hz)?,
        (None, None) => return Err(config_error("expected a clip")),
    };
    cut_clip(whole, entry.from_s, entry.to_s)
}

/// Loads a motion file as a build does: retargeted, at the database rate, with contacts.
///
/// - `tell`: receives warnings.
///
/// # Errors
/// The file, and the place in it.
pub fn file_clip(file: &Path, config: &BuildConfig, tell: &dyn Fn(News)) -> Result<ActorClip> {
    let raw: ImportedClip = import::read_clip(file, &config.import)?;
    let mut warnings = Warnings::default();
    let set = pipeline::clips_of(&[raw], config, &mut warnings)?;
    warnings.messages.into_iter().map(News::Warning).for_each(tell);
    let ClipSet { mut clips, skeleton, .. } = set;
    let clip = clips.pop().ok_or_else(|| config_error("expected one clip, found none"))?;
    Ok(ActorClip { clip, skeleton })
}

fn synthetic_clip(set: &str, name: Option<&str>, rate_hz: f64) -> Result<ActorClip> {
    let set = SynthSet::from_name(set)?;
    let made = make_set(set, &SynthConfig { rate_hz, ..SynthConfig::for_set(set) })?;
    let names = || made.clips.iter().map(|c| c.name.as_str());
    let found = name.map_or(Some(0), |n| names().position(|c| c == n));
    let Some(i) = found else {
        let (set, name) = (set.name(), name.unwrap_or_default());
        let (some, meant) = (names().take(4).collect::<Vec<_>>().join(", "), did_you_mean(name, names()));
        return Err(config_error(format!("the set `{set}` has no clip `{name}`, but such as {some}.{meant}")));
    };
    Ok(ActorClip { clip: made.clips[i].clone(), skeleton: made.skeleton })
}

/// Cuts a clip to the part from one time to another (s).
fn cut_clip(whole: ActorClip, from_s: f64, to_s: Option<f64>) -> Result<ActorClip> {
    let ActorClip { clip, skeleton } = whole;
    let end_s = clip.num_frames().saturating_sub(1) as f64 / clip.rate_hz;
    let [first, last] = [from_s, to_s.unwrap_or(end_s)].map(|t| (t * clip.rate_hz).round());
    let why = || format!("expected a part of the clip's 0 to {end_s:.2} s, found {from_s} to {to_s:?} s");
    ensure(!(last / clip.rate_hz > end_s + 1e-6 || first >= last), || config_error(why()))?;
    let (first, last) = (first as usize, last as usize);
    if (first, last + 1) == (0, clip.num_frames()) {
        return Ok(ActorClip { clip, skeleton });
    }
    let roots = clip.root_positions[first..=last].to_vec();
    let rotations = clip.rotations[first * NUM_JOINTS..(last + 1) * NUM_JOINTS].to_vec();
    let mut part = Clip::new(&clip.name, clip.rate_hz, roots, rotations);
    part.contacts = clip.contacts.get(first..=last).map_or_else(Vec::new, <[_]>::to_vec);
    part.source.clone_from(&clip.source);
    Ok(ActorClip { clip: part, skeleton })
}
