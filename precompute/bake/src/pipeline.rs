//! The offline build, in reading order. One line = one stage = one module.

use crate::cache::Cache;
use crate::config::BuildConfig;
use crate::environment::UnitSet;
use crate::patch::{self, Patches};
use crate::report::{self, BuildReport, Built};
use crate::stages::{Motion, Stages};
use crate::write::{self, Baked};
use crate::{cluster, examples, features, graph, policy, provenance};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::collections::BTreeMap;
use std::path::Path;
use throng_motion::clip::ClipSet;
use throng_motion::error::{BuildError, Warnings};
use throng_motion::import::{Imported, ImportedSet};
use throng_motion::progress::Progress;
use throng_motion::resample::ResampleConfig;
use throng_motion::{annotate, files, import, resample, retarget};
use throng_synth as synth;

/// Bakes the files of a config into a bundle.
///
/// A stage whose config and inputs are those of an earlier build is read from the cache; pose groups are found only
/// where there are patches, whose cells name them. The bundle takes its place only when it is whole. The same files,
/// config and version give the same bytes at any number of threads.
///
/// # Errors
/// What the first failing stage says; nothing is written then.
pub fn build(cfg: &BuildConfig, out: &Path, cache: &Cache, progress: &dyn Progress) -> Result<BuildReport, BuildError> {
    cfg.check()?;
    files::check_target(out)?;
    let s = Stages::new(cache, progress);
    let units = cfg.patches.units.as_deref().map(UnitSet::load).transpose()?;

    let from = s.run("hash", |_| provenance::collect(cfg))?;
    let motion = s.several("motion", &[from.key()?], &cfg.motion(), || motion(cfg, units.as_ref(), &s))?;
    let clips = &motion.clips;
    let features = s.on_demand("features", &[motion.key], &cfg.features, || features::extract(clips, &cfg.features))?;
    let blends = s.stage("examples", &[motion.key], &cfg.blend, |p| examples::fit(clips, &cfg.blend, p))?;
    let baked_patches = match &units {
        Some(units) => {
            let groups = s.stage("cluster", &[features.key], &cfg.cluster, |p| {
                cluster::group(clips, features.get()?, &cfg.cluster, p)
            })?;
            let patches = s.stage("patch", &[groups.key], &cfg.patches, |p| patches(clips, &groups, cfg, units, p))?;
            Some((groups, patches))
        }
        None => None,
    };
    let connected = s.stage("graph", &[features.key], &cfg.graph, |p| match cfg.graph.enabled {
        true => graph::connect(clips, features.get()?, &cfg.graph, p),
        false => graph::none(clips, &cfg.graph),
    })?;
    let (graph, graph_report) = &*connected;
    let policies = s.stage("policy", &[connected.key], &(&cfg.policy, &cfg.behaviours, cfg.seed), |p| {
        policy::solve(clips, graph, &cfg.behaviours, &cfg.policy, &mut Pcg64::seed_from_u64(cfg.seed), p)
    })?;

    let (groups, patches) = baked_patches.as_ref().map(|(g, p)| (&**g, &**p)).unzip();
    let (policies, meta) = (&policies.policies, from.meta(cfg, graph_report)?);
    let baked = Baked { clips, graph, policies, groups, patches, blends: &blends.spaces, meta: &meta };
    let bundle_bytes = s.run("write", |_| write::bundle(&baked, out))?;
    let built = Built { motion: &motion, baked, blends: &blends, graph: graph_report, bundle_bytes };
    drop(features);
    let (timing, warnings) = s.finish();
    Ok(report::of_build(cfg, &built, timing, warnings))
}

/// Files, or motion made by rule, to annotated clips of one skeleton.
fn motion(cfg: &BuildConfig, units: Option<&UnitSet>, s: &Stages<'_>) -> Result<Motion, BuildError> {
    let (raw, sidecars) = s.run("import", |p| match &cfg.synth {
        Some(synth) => synth::input(synth, cfg.resample.rate_hz, &cfg.import),
        None => Ok((import::read(&cfg.inputs, &cfg.import, p)?, BTreeMap::new())),
    })?;
    let ImportedSet { clips: imported, skipped } = &raw;
    let messages = imported.iter().flat_map(|c| c.warnings.messages.iter().cloned()).collect();
    let mut warnings = Warnings { messages };
    let clips = s.run("retarget", |_| retarget::onto(imported, &cfg.retarget, &mut warnings))?;
    let clips = s.run("resample", |_| resample::resample(&clips, &cfg.resample))?;
    let sidecars = sidecars.into_iter().chain(cfg.clips.clone()).collect();
    let marks = annotate::Sidecars::collect(&raw, &clips, &sidecars)?;
    let mut clips = s.run("annotate", |_| annotate::annotate(&clips, &cfg.annotate, &marks))?;
    if let Some(units) = units {
        s.run("embed", |_| patch::embed(&mut clips, &cfg.patches, units, &cfg.annotate.contacts))?;
    }
    Ok(Motion { clips, skipped: skipped.iter().map(ToString::to_string).collect(), warnings })
}

/// Motion patches of the environments in which clips were captured, and of tiles.
fn patches(
    clips: &ClipSet,
    groups: &cluster::PoseGroups,
    cfg: &BuildConfig,
    units: &UnitSet,
    progress: &dyn Progress,
) -> Result<Patches, BuildError> {
    let scenes = patch::scenes(&clips.clips, &cfg.patches, units)?;
    let settings = scenes.settings(clips, &cfg.patches.touch);
    patch::build(clips, groups, &settings, &cfg.patches, units, progress)
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
