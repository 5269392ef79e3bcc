//! From files, or synthetic motion, to annotated clips of one skeleton: file by file, except for what files share.

mod shard;
mod streamed;

pub use shard::{Shard, ShardReport, bake_shard};

use crate::cache::{Cache, CacheKey};
use crate::provenance::{self, FileKeys, Provenance};
use crate::stages::{MotionOutput, SourcePerformer, Stages};
use crate::{config::BuildConfig, environment::UnitSet, parts::RequiredParts, patch};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use streamed::StreamedMotion;
use throng_base::Comm;
use throng_motion::annotate::classes::NameHints;
use throng_motion::annotate::{self, Sidecars, hits};
use throng_motion::import::{self, ClipsResult, ImportedClip, ImportedSet, MotionFile};
use throng_motion::{BuildError, Clip, ClipSet, Progress, Result, Warnings, mirror, resample, retarget};
use throng_synth as synth;

/// The stages from files to clips.
#[derive(Clone, Copy)]
pub(crate) struct MotionStages<'a> {
    pub cfg: &'a BuildConfig,
    pub parts: RequiredParts,
    pub from: &'a Provenance,
    pub s: &'a Stages<'a>,
}

/// Imported files, with measurements that they share.
struct ReadMotion<'a> {
    /// Imported clips, without motion if it is streamed.
    raw: Vec<ImportedClip>,
    maker: ClipMaker<'a>,
    /// Files that were skipped; this and the following fields are those of [`MotionOutput`].
    skipped: Vec<String>,
    performers: Vec<SourcePerformer>,
    files_kept: usize,
    warnings: Warnings,
}

impl<'a> MotionStages<'a> {
    /// Clips of a build, with their surroundings.
    ///
    /// # Errors
    /// As the stages from import to annotate; of several bad clips, the first is named.
    pub(crate) fn collect(&self, units: Option<&UnitSet>) -> Result<MotionOutput> {
        let Self { cfg, from, s, .. } = *self;
        self.bake_together()?;
        let ReadMotion { raw, maker, skipped, performers, files_kept, warnings } =
            self.read_all(self.streams_motion())?;
        let (mut clips, clips_kept) = s.run("clips", |p| maker.clips(raw, self.shares_poses().then_some(s.comm), p))?;
        if let Some(units) = units {
            s.run("embed", |_| patch::embed(&mut clips, &cfg.patches, units, &cfg.annotate.contacts))?;
        }
        provenance::check_unchanged(from, cfg)?;
        Ok(MotionOutput { clips, skipped, performers, files_kept, clips_kept, warnings })
    }

    /// True if several processes stream the motion of files from the cache, so that none needs memory for all of it.
    fn streams_motion(&self) -> bool {
        self.s.comm.num_ranks() > 1 && self.s.cache.is_on() && self.cfg.synth.is_none()
    }

    /// True if each of several processes keeps only the poses of its share of the clips. Blend spaces, activities and
    /// patches need the poses of all.
    pub(crate) fn shares_poses(&self) -> bool {
        let cfg = self.cfg;
        self.streams_motion() && cfg.patches.units.is_none() && cfg.blend.is_empty() && cfg.activities.is_empty()
    }

    /// Reads all files, and measures what they share.
    ///
    /// - `lends`: true if the motion of a file stays in the cache and is streamed.
    fn read_all(&self, lends: bool) -> Result<ReadMotion<'a>> {
        let Self { cfg, parts, from, s } = *self;
        let files = from.file_keys(&cfg.import);
        let streamed = lends.then(|| StreamedMotion::new(from.file_keys(&cfg.import), s.cache));
        let ((mut raw, files_kept), sidecars) = s.run("import", |p| match &cfg.synth {
            Some(synth) => synth::input(synth, cfg.resample.rate_hz, &cfg.import).map(|(set, marks)| ((set, 0), marks)),
            None => Ok((self.read_files(&files, streamed.as_ref(), p)?, BTreeMap::new())),
        })?;
        let names: Vec<&str> = raw.clips.iter().map(|c| c.clip.name.as_str()).collect();
        cfg.select.check(&names)?;
        raw.clips.retain(|c| cfg.select.takes(&c.clip.name));
        let mut warnings = Warnings::default();
        let mut skipped: Vec<String> = raw.skipped.iter().map(ToString::to_string).collect();
        let repeated = self.report_repeated(&mut raw, streamed.as_ref())?;
        let reported = if parts == RequiredParts::Possible { &mut skipped } else { &mut warnings.messages };
        reported.extend(repeated);
        warnings.messages.extend(raw.clips.iter().flat_map(ImportedClip::own_warnings).map(str::to_owned));
        warnings.messages.extend(import::skeleton_warnings(&raw.clips));
        resample::check_length(raw.clips.iter().map(|c| c.clip.num_frames as f64 / c.clip.rate_hz), &cfg.resample)?;
        let keys: Vec<Option<CacheKey>> = match &cfg.synth {
            Some(_) => vec![None; raw.clips.len()],
            None => raw.clips.iter().map(|c| files.key_of(&c.clip.path).map(Some)).collect::<Result<_, _>>()?,
        };
        let plan =
            s.run("retarget", |_| self.measure_performers(&raw.clips, streamed.as_ref(), &keys, &mut warnings))?;
        let performer = |indices: Vec<usize>| SourcePerformer {
            height_m: raw.clips[indices[0]].height,
            clips: indices.iter().map(|&i| plan.names[i].clone()).collect(),
        };
        let performers = retarget::performers(&raw.clips).into_iter().map(performer).collect();
        let sidecars = sidecars.into_iter().chain(cfg.clips.clone()).collect();
        let marks = Sidecars::collect(&raw, &plan.names, &sidecars)?;
        let sources = raw.clips.iter().map(|c| from.seen_from_base(&c.clip.path).display().to_string()).collect();
        let maker = ClipMaker { cfg, plan, marks, keys, sources, cache: s.cache, streamed };
        Ok(ReadMotion { raw: raw.clips, maker, skipped, performers, files_kept, warnings })
    }

    /// Reads files, or loads them from the cache, file by file.
    ///
    /// - `streamed`: receives the motion of each file after reading; `None` to keep it in memory.
    /// - returns also the number of files loaded from the cache.
    fn read_files(
        &self,
        keys: &FileKeys<'_>,
        streamed: Option<&StreamedMotion<'_>>,
        p: &dyn Progress,
    ) -> Result<(ImportedSet, usize)> {
        let (kept, cache) = (AtomicUsize::new(0), self.s.cache);
        let reader = |file: &MotionFile, read: &dyn Fn() -> ClipsResult| {
            let Ok(key) = keys.key_of(&file.path) else { return read() };
            let (mut imported, was_kept) = cache.load_or_make("import", key, || keys.read_file(&file.path, read))?;
            kept.fetch_add(usize::from(was_kept), Ordering::Relaxed);
            streamed.into_iter().for_each(|streamed| streamed.release_motion(file, key, &mut imported));
            Ok(imported)
        };
        let set = import::read_by(&reader, &self.cfg.inputs, &self.cfg.import, p)?.require_clips()?;
        cache.finish_batch();
        Ok((set, kept.into_inner()))
    }

    /// Reports clips that repeat the motion of others; if only possible parts are made, they are dropped.
    fn report_repeated(&self, raw: &mut ImportedSet, streamed: Option<&StreamedMotion<'_>>) -> Result<Vec<String>> {
        let repeated = streamed.map_or_else(|| Ok(raw.repeated()), |streamed| streamed.repeated_clips(&raw.clips))?;
        let path = |i: usize| raw.clips[i].clip.path.display();
        let end = if self.parts == RequiredParts::Possible { "; it is left out" } else { "" };
        let messages =
            repeated.iter().map(|&[first, i]| format!("{}: the same motion as {}{end}", path(i), path(first)));
        let messages = messages.collect();
        if self.parts == RequiredParts::Possible {
            let mut place = 0..;
            raw.clips.retain(|_| place.next().is_none_or(|i: usize| repeated.iter().all(|[_, later]| *later != i)));
        }
        Ok(messages)
    }

    /// Measures the performers and their floors.
    fn measure_performers(
        &self,
        clips: &[ImportedClip],
        streamed: Option<&StreamedMotion<'_>>,
        keys: &[Option<CacheKey>],
        warnings: &mut Warnings,
    ) -> Result<retarget::RetargetPlan> {
        let sources: Vec<retarget::RetargetSource> = clips.iter().map(retarget::RetargetSource::from).collect();
        let provider: Box<retarget::ClipProvider<'_>> = match streamed {
            Some(streamed) => Box::new(|places, look| streamed.with_motion(clips, places, look)),
            None => retarget::provide_from_memory(&sources),
        };
        let mut plan = retarget::RetargetPlan::new(&sources, &*provider, &self.cfg.retarget, warnings)?;
        if self.cfg.resample.mirror {
            retarget::rename_mirror_clashes(&mut plan.names, warnings);
        }
        for p in 0..plan.performers.len() {
            let measured = &plan.performers[p].measured_clips;
            let find = || plan.find_floor(p, &*provider);
            let floor = match measured.iter().map(|&i| keys[i]).collect::<Option<Vec<CacheKey>>>() {
                Some(keys) => {
                    let key = CacheKey::for_stage("floor", &keys, &plan.basis(measured[0]))?;
                    self.s.cache.load_or_make("floor", key, find)?.0
                }
                None => find()?,
            };
            plan.set_floor(p, floor, &*provider)?;
        }
        Ok(plan)
    }
}

/// Converter of files to clips.
struct ClipMaker<'a> {
    cfg: &'a BuildConfig,
    plan: retarget::RetargetPlan,
    marks: Sidecars,
    /// Keys of all files; `None` for synthetic motion.
    keys: Vec<Option<CacheKey>>,
    /// Path of every file, as the bundle keeps it.
    sources: Vec<String>,
    cache: &'a Cache,
    /// Source of streamed motion, for files imported without it.
    streamed: Option<StreamedMotion<'a>>,
}

impl ClipMaker<'_> {
    /// Clips of all files, mirrored copies after their originals; the motion of a file is dropped once its clips are
    /// made.
    ///
    /// - `comm`: processes each of which keeps the poses of its share only; `None` to keep all here.
    /// - returns also the number of files with cached clips.
    fn clips(&self, raw: Vec<ImportedClip>, comm: Option<&dyn Comm>, p: &dyn Progress) -> Result<(ClipSet, usize)> {
        p.begin("clips", raw.len() as u64, "files");
        // The distribution of `owners`.
        let own = comm.map(|comm| comm.own_range(raw.len()));
        let of_file = |(i, raw): (usize, ImportedClip)| {
            p.check()?;
            let mut made = self.clips_of_file(i, &raw);
            if own.as_ref().is_some_and(|own| !own.contains(&i)) {
                made.iter_mut().flat_map(|(clips, _)| clips).for_each(Clip::forget_poses);
            }
            p.advance(1);
            made
        };
        let all: Vec<Result<(Vec<Clip>, bool)>> = raw.into_par_iter().enumerate().map(of_file).collect();
        p.end();
        self.cache.finish_batch();
        let (mut clips, mut num_kept) = (Vec::with_capacity(2 * all.len()), 0);
        for made in all {
            let (of_file, kept) = made?;
            clips.extend(of_file);
            num_kept += usize::from(kept);
        }
        hits::set_forces(&mut clips);
        Ok((ClipSet { skeleton: self.plan.skeleton.clone(), clips }, num_kept))
    }

    /// Clips of one file, and whether they were cached. The force of blows is relative to that of other files.
    fn clips_of_file(&self, i: usize, raw: &ImportedClip) -> Result<(Vec<Clip>, bool)> {
        let (cfg, name) = (self.cfg, &self.plan.names[i]);
        let marks = self.marks.for_clip(name);
        let make = || {
            let whole = self.streamed.as_ref().map(|streamed| streamed.load_clip(raw)).transpose()?;
            let raw = whole.as_ref().unwrap_or(raw);
            let retargeted =
                ClipSet { skeleton: self.plan.skeleton.clone(), clips: vec![self.plan.retarget_clip(i, raw)] };
            let resampled = resample::resample(&retargeted, &cfg.resample)?;
            Ok::<_, BuildError>(annotate::annotate(&resampled, &cfg.annotate, &marks)?.clips)
        };
        let Some(key) = self.keys[i] else { return Ok((make()?, false)) };
        let hints = NameHints::new(name, &raw.clip.path.display().to_string());
        let settings = (self.plan.basis(i), &cfg.resample, &cfg.annotate, &marks, hints);
        let (mut clips, kept) =
            self.cache.load_or_make("clips", CacheKey::for_stage("clips", &[key], &settings)?, make)?;
        for clip in &mut clips {
            // Other files may have changed how many folders make names unique.
            clip.source.clone_from(&self.sources[i]);
            clip.name = if clip.mirrored { format!("{name}{}", mirror::SUFFIX) } else { name.clone() };
        }
        Ok((clips, kept))
    }
}
