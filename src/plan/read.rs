//! The clips of a task: files and synthetic motion.

use crate::args::CacheArgs;
use std::error::Error;
use throng_planner::task::{ActorClip, ClipEntry, Source, Task, WalkEntry, Walked};
use throng_precompute::config::BuildConfig;
use throng_precompute::import::{self, Imported};
use throng_precompute::synth::{SynthConfig, SynthSet, make};
use throng_precompute::{Clip, ClipSet, Warnings, pipeline};
use throng_runtime::NUM_JOINTS;
use throng_runtime::base::text::did_you_mean;
use throng_runtime::blend::{BlendSpace, axis};

/// One clip for each character, on the database skeleton, and the task with the times of those who walk.
///
/// - `main`: in place of the file's clip of the first character.
/// - `cache`: with which bundles of walkers are built where they are missing; without it they have to be there.
/// - `seed`: in place of the task's.
pub fn staged(
    task: Task,
    config: &BuildConfig,
    main: Option<ActorClip>,
    cache: Option<&CacheArgs>,
    seed: Option<u64>,
) -> Result<(Task, Vec<ActorClip>), Box<dyn Error>> {
    let mut given = main;
    let (mut clips, mut spaces) = (Vec::new(), Vec::new());
    for c in &task.characters {
        let named = |e: Box<dyn Error>| -> Box<dyn Error> { format!("`{}`: {e}", c.name).into() };
        let (clip, space) = match (given.take(), &c.clip.walk) {
            (Some(clip), _) => (Some(clip), None),
            (None, Some(walk)) => (None, Some(blend_space(walk, cache).map_err(named)?)),
            (None, None) => (Some(clip(&c.clip, config).map_err(named)?), None),
        };
        clips.push(clip);
        spaces.push(space);
    }
    if spaces.iter().all(Option::is_none) {
        return Ok((task, clips.into_iter().flatten().collect()));
    }
    let pairs = clips.into_iter().zip(&spaces);
    let sources: Vec<Source<'_>> =
        pairs.filter_map(|(c, s)| c.map(Source::Clip).or(s.as_ref().map(Source::Walks))).collect();
    let Walked { task, clips } = task.walked(&sources, config.resample.rate_hz, seed)?;
    Ok((task, clips))
}

fn blend_space(walk: &WalkEntry, cache: Option<&CacheArgs>) -> Result<BlendSpace, Box<dyn Error>> {
    if let Some(cache) = cache {
        crate::run::make_bundle(&walk.bundle, walk.config.as_deref(), cache)?;
    }
    let bundle = crate::args::open(&walk.bundle)?;
    let names = &bundle.blends().names;
    let Some(name) = walk.space.as_ref().or(names.first()) else {
        let path = walk.bundle.display();
        return Err(format!("{path} has no blend spaces; build one (docs/blending.md)").into());
    };
    let space = bundle.blend(name)?;
    if space.axes().first().is_none_or(|a| a.kind != axis::SPEED) {
        return Err(format!("`{name}` cannot walk here: expected a blend space whose first axis is speed").into());
    }
    Ok(space)
}

fn clip(entry: &ClipEntry, config: &BuildConfig) -> Result<ActorClip, Box<dyn Error>> {
    let whole = match (&entry.file, &entry.synth) {
        (Some(file), _) => file_clip(file, config)?,
        (None, Some(set)) => synthetic(set, entry.clip.as_deref(), config.resample.rate_hz)?,
        (None, None) => return Err("expected a clip".into()),
    };
    cut(whole, entry.from_s, entry.to_s)
}

/// A motion file as a build takes it: retargeted, at the database rate, with contacts.
pub fn file_clip(file: &std::path::Path, config: &BuildConfig) -> Result<ActorClip, Box<dyn Error>> {
    let raw: Imported = import::read_clip(file, &config.import)?;
    let mut warnings = Warnings::default();
    let set = pipeline::clips_of(&[raw], config, &mut warnings)?;
    crate::output::warnings(&[], &warnings.messages);
    let ClipSet { mut clips, skeleton, .. } = set;
    let clip = clips.pop().ok_or("expected one clip, found none")?;
    Ok(ActorClip { clip, skeleton })
}

fn synthetic(set: &str, name: Option<&str>, rate_hz: f64) -> Result<ActorClip, Box<dyn Error>> {
    let set = SynthSet::from_name(set)?;
    let made = make(set, &SynthConfig { rate_hz, ..SynthConfig::for_set(set) })?;
    let names = || made.clips.iter().map(|c| c.name.as_str());
    let found = name.map_or(Some(0), |n| names().position(|c| c == n));
    let Some(i) = found else {
        let (name, meant) = (name.unwrap_or_default(), did_you_mean(name.unwrap_or_default(), names()));
        let some: Vec<&str> = names().take(4).collect();
        return Err(
            format!("the set `{}` has no clip `{name}`, but such as {}.{meant}", set.name(), some.join(", ")).into()
        );
    };
    Ok(ActorClip { clip: made.clips[i].clone(), skeleton: made.skeleton })
}

/// The part of a clip from one time to another.
fn cut(whole: ActorClip, from_s: f64, to_s: Option<f64>) -> Result<ActorClip, Box<dyn Error>> {
    let ActorClip { clip, skeleton } = whole;
    let end_s = clip.num_frames().saturating_sub(1) as f64 / clip.rate_hz;
    let [first, last] = [from_s, to_s.unwrap_or(end_s)].map(|t| (t * clip.rate_hz).round());
    if last / clip.rate_hz > end_s + 1e-6 || first >= last {
        return Err(format!("expected a part of the clip's 0 to {end_s:.2} s, found {from_s} to {:?} s", to_s).into());
    }
    let (first, last) = (first as usize, last as usize);
    if (first, last + 1) == (0, clip.num_frames()) {
        return Ok(ActorClip { clip, skeleton });
    }
    let roots = clip.root_positions[first..=last].to_vec();
    let mut part = Clip::new(
        &clip.name,
        clip.rate_hz,
        roots,
        clip.rotations[first * NUM_JOINTS..(last + 1) * NUM_JOINTS].to_vec(),
    );
    part.contacts = clip.contacts.get(first..=last).map_or_else(Vec::new, <[_]>::to_vec);
    part.source.clone_from(&clip.source);
    Ok(ActorClip { clip: part, skeleton })
}
