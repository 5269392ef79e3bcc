//! The offline build, in reading order. One line = one stage = one module.

use crate::cache::{Cache, Key};
use crate::clip::ClipSet;
use crate::cluster::PoseGroups;
use crate::config::BuildConfig;
use crate::environment::{self, UnitSet};
use crate::error::{BuildError, Warnings};
use crate::examples::BlendSpaces;
use crate::import::Imported;
use crate::patch::{self, Patches};
use crate::progress::Progress;
use crate::provenance::{self, Provenance};
use crate::report::{self, BuildReport};
use crate::resample::ResampleConfig;
use crate::stages::{Motion, Stages};
use crate::write::{self, Baked};
use crate::{annotate, cluster, examples, features, files, graph, import, policy, resample, retarget, synth};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::collections::BTreeMap;
use std::path::Path;

/// Bakes the files of a config into a bundle.
///
/// Stages whose input and config are those of an earlier build are read from the cache. The bundle takes its
/// place only when it is whole. The same files, config and version give the same bytes at any number of threads.
///
/// # Errors
/// What the first failing stage says; nothing is written then.
pub fn build(cfg: &BuildConfig, out: &Path, cache: &Cache, progress: &dyn Progress) -> Result<BuildReport, BuildError> {
    files::check_target(out)?;
    let mut s = Stages::new(cache, progress);
    let from: Provenance = s.run("hash", |_| provenance::collect(cfg))?;

    let units = cfg.patches.units.as_ref().map(|path| UnitSet::load(path)).transpose()?;

    let key = Key::root().then("import", &(&from.sources, &cfg.import, &cfg.clips))?;
    let key = key.then(
        "motion",
        &(&cfg.retarget, &cfg.resample, &cfg.annotate, &cfg.patches.environments, &cfg.patches.touch),
    )?;
    let motion: Motion = s.cached("motion", key, |s| {
        let (raw, sidecars) = s.run("import", |p| match &cfg.synth {
            Some(synth) => synth::input(synth, cfg.resample.rate_hz, &cfg.import),
            None => Ok((import::read(&cfg.inputs, &cfg.import, p)?, BTreeMap::new())),
        })?;
        let sidecars = sidecars.into_iter().chain(cfg.clips.clone()).collect();
        let mut warnings = report::of_import(&raw);
        let clips = s.run("retarget", |_| retarget::onto(&raw.clips, &cfg.retarget, &mut warnings))?;
        let clips = s.run("resample", |_| resample::resample(&clips, &cfg.resample))?;
        let marks = annotate::Sidecars::collect(&raw, &clips, &sidecars)?;
        let clips = s.run("annotate", |_| annotate::annotate(&clips, &cfg.annotate, &marks))?;
        let clips = match &units {
            Some(units) => s.run("embed", |_| embed(clips, cfg, units))?,
            None => clips,
        };
        Ok(Motion { clips, skipped: report::of_skipped(&raw), warnings })
    })?;

    let blend_key = key.then("examples", &cfg.blend)?;
    let blends: BlendSpaces =
        s.cached("examples", blend_key, |s| s.run("examples", |p| examples::fit(&motion.clips, &cfg.blend, p)))?;

    let cluster_key = key.then("cluster", &(&cfg.features, &cfg.cluster))?;
    let groups: PoseGroups = s.cached("cluster", cluster_key, |s| {
        let features = s.run("features", |_| features::extract(&motion.clips, &cfg.features))?;
        s.run("cluster", |p| cluster::group(&motion.clips, &features, &cfg.cluster, p))
    })?;

    let patch_key = cluster_key.then("patch", &cfg.patches)?;
    let patches: Patches = s.cached("patch", patch_key, |s| match &units {
        Some(units) => s.run("patch", |p| {
            let scenes = environment::scenes(&motion.clips.clips, &cfg.patches, units)?;
            let settings = scenes.settings(&motion.clips, &cfg.patches.touch);
            patch::build(&motion.clips, &groups, &settings, &cfg.patches, units, p)
        }),
        None => Ok(Patches::default()),
    })?;

    let key = key.then("graph", &(&cfg.features, &cfg.graph))?;
    let (graph, graph_report) = s.cached("graph", key, |s| {
        let features = s.run("features", |_| features::extract(&motion.clips, &cfg.features))?;
        s.run("graph", |p| graph::connect(&motion.clips, &features, &cfg.graph, p))
    })?;

    let key = key.then("policy", &(&cfg.policy, &cfg.behaviours, cfg.seed))?;
    let policies = s.cached("policy", key, |s| {
        s.run("policy", |p| {
            let mut rng = Pcg64::seed_from_u64(cfg.seed);
            policy::solve(&motion.clips, &graph, &cfg.behaviours, &cfg.policy, &mut rng, p)
        })
    })?;

    let meta = from.meta(cfg, &graph_report)?;
    let baked = Baked {
        clips: &motion.clips,
        graph: &graph,
        policies: &policies.policies,
        groups: Some(&groups),
        patches: Some(&patches),
        blends: &blends.spaces,
        meta: &meta,
    };
    let bundle_bytes = s.run("write", |_| write::bundle(&baked, out))?;
    let warnings = [&motion.warnings, &blends.warnings, &s.warnings].map(|w| w.messages.clone()).concat();
    let warnings = Warnings { messages: warnings };
    Ok(report::of_build(
        cfg,
        &motion,
        &groups,
        &patches,
        &blends.report,
        graph_report,
        &policies.policies,
        bundle_bytes,
        warnings,
        s.finish(),
    ))
}

/// Contacts with what the clips were captured in.
fn embed(mut clips: ClipSet, cfg: &BuildConfig, units: &UnitSet) -> Result<ClipSet, BuildError> {
    environment::embed(&mut clips, &cfg.patches, units, &cfg.annotate.contacts)?;
    Ok(clips)
}

/// What a build makes of one clip before the motion graph: the same stages with default settings, no mirrored copy.
///
/// # Errors
/// As the retarget, resample and annotate stages.
pub fn single(raw: &Imported, warnings: &mut Warnings) -> Result<ClipSet, BuildError> {
    let clips = retarget::onto(std::slice::from_ref(raw), &Default::default(), warnings)?;
    let clips = resample::resample(&clips, &ResampleConfig { mirror: false, ..ResampleConfig::default() })?;
    annotate::annotate(&clips, &Default::default(), &Default::default())
}
