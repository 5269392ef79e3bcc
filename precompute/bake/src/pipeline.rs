//! The offline build, in reading order. One line = one stage = one module.

use crate::cache::{Cache, CacheKey};
use crate::graph::{MotionGraphConfig, TakenMotion};
pub use crate::motion::{Shard, ShardReport, bake_shard};
use crate::parts::{Attempts, RequiredParts, SkippedPart, is_of_motion};
use crate::patch::{self, PatchConfig, RawPatches, TileConfig};
use crate::policy::{BehaviourKind, PolicyBehaviourConfig, RawPolicy};
use crate::report::{self, BuildProducts, BuildReport};
use crate::share::{clip_owners, sort_by_owner};
use crate::stages::{MotionOutput, StageOutput, Stages, stage_error};
use crate::write::{self, BundleInputs};
use crate::{activities, cluster, examples, features, graph, make, policy, provenance, stops};
use crate::{config::BuildConfig, environment::UnitSet, examples::BlendSpaces, motion::MotionStages};
use glam::Vec3;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use throng_base::{Comm, SingleRank, thresholds::WALKING_MPS};
use throng_core::format::{ActivityMeta, MAGIC};
use throng_motion::annotate::{self, Sidecar, Sidecars};
use throng_motion::error::{BuildError, Result, Warnings};
use throng_motion::{ClipSet, FrameRange, Progress, files, resample, retarget};
use throng_motion::{import::ImportedClip, resample::ResampleConfig};

/// Bakes the files of a config into a bundle.
///
/// A stage with the config and inputs of an earlier build is read from the cache; pose groups are computed only for
/// patches, whose cells name them. The bundle replaces an older one only when complete. Equal files, config and version
/// give equal bytes at any number of threads.
///
/// # Errors
/// Error of the first failing stage; nothing is written then.
pub fn build(cfg: &BuildConfig, out: &Path, cache: &Cache, progress: &dyn Progress) -> Result<BuildReport> {
    build_shared(cfg, RequiredParts::All, out, cache, progress, &SingleRank)
}

/// Builds as [`build`] does, but leaves out and reports parts that the motion does not allow
/// ([`BuildReport::not_made`]): policies, blend spaces and patches, each by itself. Repeated motion is left out, too.
///
/// # Errors
/// If there is no motion at all, or files cannot be read or written.
pub fn build_possible(cfg: &BuildConfig, out: &Path, cache: &Cache, progress: &dyn Progress) -> Result<BuildReport> {
    build_shared(cfg, RequiredParts::Possible, out, cache, progress, &SingleRank)
}

/// Path at which a cache keeps a bundle of [`build_possible`] that is made to be run or viewed; `None` if nothing is
/// kept.
///
/// # Errors
/// As [`provenance::collect_provenance`].
pub fn kept_bundle(cfg: &BuildConfig, cache: &Cache) -> Result<Option<PathBuf>> {
    cfg.check()?;
    let key = CacheKey::for_stage("bundle", &[provenance::collect_provenance(cfg)?.key()?], cfg)?;
    Ok(cache.bundle(key))
}

/// Builds with several processes, each of which calls this with equal arguments and sees the same files. They share the
/// work on single files, if there is a cache, the search for similar frames, pose groups and policies; each does the
/// rest for itself. The first one writes the bundle, which equals that of [`build`] byte by byte.
///
/// - returns the report of this process; only that of the first one describes the bundle.
///
/// # Errors
/// As [`build`]; [`throng_base::Error::Rank`] if another process has ended.
pub fn build_shared(
    cfg: &BuildConfig,
    parts: RequiredParts,
    out: &Path,
    cache: &Cache,
    progress: &dyn Progress,
    comm: &dyn Comm,
) -> Result<BuildReport> {
    cfg.check()?;
    files::check_replaced(out, &MAGIC, "a bundle")?;
    let s = Stages::new(cache, progress, comm);
    let units = cfg.patches.units.as_deref().map(UnitSet::load).transpose()?;

    let from = s.run("hash", |_| provenance::collect_provenance(cfg))?;
    let motion_cfg = (cfg.motion_config(), parts == RequiredParts::Possible);
    let stages = MotionStages { cfg, parts, from: &from, s: &s };
    let collect = || stages.collect(units.as_ref());
    let mut motion = match stages.shares_poses() {
        // No process has all the motion.
        true => StageOutput { key: CacheKey::for_stage("motion", &[from.key()?], &motion_cfg)?, value: collect()? },
        false => s.run_group("motion", &[from.key()?], &motion_cfg, collect)?,
    };
    let mut made = make::MadeMotion::default();
    if makes_motion(cfg, &motion.clips) {
        let (clips, mirror) = (&motion.clips, cfg.resample.mirror);
        made = s.run("stands", |_| make::make_stands(clips, mirror, comm))?;
        if !made.clips.is_empty() {
            motion.key = CacheKey::for_stage("stands", &[motion.key], &mirror)?;
            motion.value.clips.clips.append(&mut made.clips);
        }
    }
    // What is made joins more, and nearer, than farther transitions do.
    let captured = motion.key;
    let near = MotionGraphConfig { join_error: cfg.graph.max_error, ..graph_config(cfg) };
    let mut connected = match connect(&near, cfg, &motion, &s) {
        Err(e) if !is_of_motion(&e) => return Err(e),
        connected => connected,
    };
    if let Some(lacks) = missing_motion(cfg, &motion.clips, connected.as_ref().ok()) {
        let (clips, mirror, graph_cfg) = (&motion.clips, cfg.resample.mirror, graph_config(cfg));
        let settings = (&lacks, &graph_cfg, mirror);
        let output =
            s.stage("make", &[motion.key], &settings, |_| make::make_missing(clips, &lacks, &graph_cfg, mirror, comm))?;
        if !output.clips.is_empty() {
            motion.key = output.key;
            made.append(output.value);
            motion.value.clips.clips.append(&mut made.clips);
        }
    }
    let is_apart =
        connected.as_ref().is_ok_and(|c| !c.1.apart.is_empty() && cfg.graph.join_error > cfg.graph.max_error);
    if motion.key != captured || is_apart {
        connected = connect(&graph_config(cfg), cfg, &motion, &s);
    }
    let clips = &motion.clips;
    let features_key = CacheKey::for_stage("features", &[motion.key], &cfg.features)?;
    let mut baker = PartBaker { cfg, motion: &motion, s: &s, attempts: Attempts::new(parts) };
    let blends = baker.blend_spaces()?;
    let activities = baker.activities()?;
    let baked_patches = match &units {
        Some(units) => {
            let groups = s.stage("cluster", &[features_key], &cfg.cluster, |p| {
                let features = s.run("features", |_| features::extract(clips, &cfg.features))?;
                cluster::group(clips, &features, &cfg.cluster, p, comm)
            })?;
            baker.patches(&groups, units)?.map(|patches| (groups, patches))
        }
        None => None,
    };
    let (connected, graph_key) = match baker.attempts.accept("policies", connected)? {
        Some(connected) => (connected.value, connected.key),
        None => (graph::empty_graph(clips, &cfg.graph)?, features_key),
    };
    let (graph, graph_report) = &connected;
    let (stops, stops_report) = s.run("stops", |_| stops::find_stops(clips, graph, comm))?;
    let policies = baker.policies(graph, graph_key)?;

    let (groups, patches) = baked_patches.as_ref().map(|(g, p)| (&**g, &**p)).unzip();
    if graph.states.is_empty() && blends.spaces.is_empty() && patches.is_none() {
        return Err(nothing_to_play_error(&baker.attempts, &motion));
    }
    let meta = from.meta(cfg, graph_report)?;
    let baked = BundleInputs {
        clips,
        graph,
        stops: &stops,
        policies: &policies,
        groups,
        patches,
        blends: &blends.spaces,
        activities: &activities,
        meta: &meta,
    };
    let (written, sanity) = s.run("write", |_| {
        let sanity = sort_by_owner(comm, &clip_owners(clips, comm.num_ranks()), |c| {
            annotate::contact_sanity(&clips.clips[c], &clips.skeleton)
        })?;
        Ok((write::bundle(&baked, out, comm)?, sanity))
    })?;
    let (graph, stops) = (graph_report, stops_report);
    let built =
        BuildProducts { motion: &motion, baked, blends: &blends, made: &made.report, graph, stops, written, sanity };
    let not_made = baker.attempts.not_made;
    let (timing, warnings) = s.finish();
    Ok(BuildReport { not_made, ..report::build_report(cfg, &built, timing, warnings) })
}

/// The motion graph of some motion.
fn connect(
    graph_cfg: &MotionGraphConfig,
    cfg: &BuildConfig,
    motion: &StageOutput<MotionOutput>,
    s: &Stages<'_>,
) -> Result<StageOutput<Connected>> {
    let key = CacheKey::for_stage("features", &[motion.key], &cfg.features)?;
    s.stage("graph", &[key], graph_cfg, |p| match graph_cfg.enabled {
        true => graph::connect(&motion.clips, &cfg.features, graph_cfg, p, s.comm),
        false => graph::empty_graph(&motion.clips, graph_cfg),
    })
}

/// Settings of the motion graph, with the motion that chosen clips and behaviours need.
fn graph_config(cfg: &BuildConfig) -> MotionGraphConfig {
    let mut graph_cfg = cfg.graph.clone();
    if !cfg.select.wanted.is_empty() {
        graph_cfg.take = TakenMotion::ALL.into();
    } else if cfg.behaviours.iter().any(|b| b.kind != BehaviourKind::Approach) {
        graph_cfg.take.push(TakenMotion::Blows);
    }
    graph_cfg
}

/// A motion graph and its figures.
type Connected = (graph::RawMotionGraph, graph::GraphReport);

/// What the motion of each manner lacks that the behaviours of a config need; `None` if nothing is to be made.
fn missing_motion(
    cfg: &BuildConfig,
    clips: &ClipSet,
    connected: Option<&StageOutput<Connected>>,
) -> Option<BTreeMap<String, make::Lacks>> {
    let lacks = make::Lacks::of_manners(clips, connected.map(|c| (&c.0, &*c.1.apart)));
    (makes_motion(cfg, clips) && !lacks.is_empty()).then_some(lacks)
}

/// True if motion is made where it lacks.
fn makes_motion(cfg: &BuildConfig, clips: &ClipSet) -> bool {
    // Fighters that bring their fists to a target are no walkers.
    let usual = PolicyBehaviourConfig::default().centre;
    let goes = cfg.behaviours.iter().any(|b| b.kind == BehaviourKind::Approach && b.centre == usual);
    goes && cfg.graph.enabled && cfg.graph.make == graph::MakeMotion::Missing && shows_walking(clips)
}

/// Error of a build that has nothing to play.
fn nothing_to_play_error(attempts: &Attempts, motion: &MotionOutput) -> BuildError {
    let parts: Vec<String> = attempts.not_made.iter().map(|n| format!("no {}: {}", n.part, n.why)).collect();
    let (message, help) = match parts.is_empty() {
        true => (
            "neither policies nor blend spaces nor motion patches are asked for, so that there is nothing to play"
                .into(),
            "Name `behaviours`, `[blend.NAME]` or `[patches]` in the config, or build the motion without a config",
        ),
        false => {
            // The report with these warnings is not made.
            let warning = motion.warnings.messages.iter().take(1).map(|w| format!("; {}", w.trim_end_matches('.')));
            let there_is = describe_motion(&motion.clips) + &warning.collect::<String>();
            let parts = parts.join("; ");
            (format!("nothing can be made of this motion: {there_is}; {parts}"), "`throng inspect` says more")
        }
    };
    stage_error("build", message, help)
}

/// Describes insufficient motion: how much there is, what is left out, and whether it shows walking.
fn describe_motion(clips: &ClipSet) -> String {
    let (mut all_s, mut usable_s) = (0.0, 0.0);
    let mut left_out = BTreeMap::<String, f64>::new();
    for clip in clips.clips.iter().filter(|c| !c.mirrored) {
        let seconds = |frames: usize| frames as f64 / clip.rate_hz;
        all_s += seconds(clip.num_frames());
        usable_s += clip.usable_ranges().into_iter().map(|r| seconds(r.len())).sum::<f64>();
        for e in &clip.excluded {
            *left_out.entry(e.reason.to_string()).or_default() += seconds(e.range.len());
        }
    }
    let left_out: Vec<String> = left_out.iter().map(|(why, s)| format!("{why} {s:.1} s")).collect();
    let left_out = if left_out.is_empty() { String::new() } else { format!(" (left out: {})", left_out.join(", ")) };
    let what = match shows_walking(clips) {
        true => "somebody walks in it, but too little or too seldom",
        false => "nobody walks in it: add walks that start, turn and stop, with root motion",
    };
    format!("it has {all_s:.1} s, of which {usable_s:.1} s can be used{left_out}, and {what}")
}

/// True if the motion shows walking.
fn shows_walking(clips: &ClipSet) -> bool {
    /// Shortest motion that shows walking (s).
    const SHORTEST_S: f32 = 0.2;
    clips.clips.iter().filter(|c| !c.mirrored).any(|clip| {
        let second = clip.rate_hz.round().max(1.0) as usize;
        let goes = |w: &[Vec3]| {
            let seconds = (w.len() - 1) as f32 / clip.rate_hz as f32;
            seconds > SHORTEST_S && (w[w.len() - 1] - w[0]).with_y(0.0).length() > WALKING_MPS * seconds
        };
        // A shorter clip is taken as a whole.
        let window = |r: &FrameRange| r.len().min(second + 1).max(1);
        clip.usable_ranges().into_iter().any(|r| clip.root_positions[r.clone()].windows(window(&r)).any(goes))
    })
}

/// Parts of a bundle that the motion may not allow.
struct PartBaker<'a> {
    cfg: &'a BuildConfig,
    motion: &'a StageOutput<MotionOutput>,
    s: &'a Stages<'a>,
    attempts: Attempts,
}

impl PartBaker<'_> {
    /// Motion patches of the environments in which clips were captured, and of tiles; tiles that cannot be made are
    /// left out if they may be missing.
    fn patches(
        &mut self,
        groups: &StageOutput<cluster::PoseGroups>,
        units: &UnitSet,
    ) -> Result<Option<StageOutput<RawPatches>>> {
        let (cfg, clips) = (&self.cfg.patches, &self.motion.clips);
        let with_tiles = |tiles: Vec<TileConfig>| {
            let cfg = PatchConfig { tiles, ..cfg.clone() };
            self.s.stage("patch", &[groups.key], &cfg, |p| {
                let settings = patch::scenes(&clips.clips, &cfg, units)?.settings(clips, &cfg.touch);
                patch::build(clips, groups, &settings, &cfg, units, p)
            })
        };
        if self.attempts.parts == RequiredParts::All || cfg.tiles.len() < 2 {
            return self.attempts.accept("motion patches", with_tiles(cfg.tiles.clone()));
        }
        let mut possible = Vec::new();
        for tile in &cfg.tiles {
            let alone = with_tiles(vec![tile.clone()]);
            possible.extend(self.attempts.accept(format!("tile {}", tile.unit), alone)?.map(|_| tile.clone()));
        }
        if possible.is_empty() && cfg.environments.is_empty() {
            return Ok(None);
        }
        self.attempts.accept("motion patches", with_tiles(possible))
    }

    /// Blend spaces.
    fn blend_spaces(&mut self) -> Result<BlendSpaces> {
        let mut all = BlendSpaces::default();
        let tables: Vec<_> = self.cfg.blend.iter().map(|(name, table)| (name.clone(), table.clone())).collect();
        for some in self.attempts.units_of_work(&tables) {
            let (tables, motion) = (some.iter().cloned().collect(), self.motion);
            let fitted = self.s.stage("examples", &[motion.key], &tables, |p| examples::fit(&motion.clips, &tables, p));
            if let Some(fitted) = self.attempts.accept(format!("blend space {}", some[0].0), fitted)? {
                let BlendSpaces { spaces, report, not_made, warnings } = fitted.value;
                let skipped = |(name, why)| SkippedPart { part: format!("blend space {name}"), why };
                self.attempts.not_made.extend(not_made.into_iter().map(skipped));
                all.spaces.extend(spaces);
                all.report.extend(report);
                all.warnings.messages.extend(warnings.messages);
            }
        }
        Ok(all)
    }

    /// Activities.
    fn activities(&mut self) -> Result<Vec<ActivityMeta>> {
        let tables: Vec<_> = self.cfg.activities.iter().map(|(tag, table)| (tag.clone(), table.clone())).collect();
        let mut all = Vec::new();
        for some in self.attempts.units_of_work(&tables) {
            let found = activities::find_activities(&self.motion.clips, &some.iter().cloned().collect());
            all.extend(self.attempts.accept(format!("activity {}", some[0].0), found)?.unwrap_or_default());
        }
        Ok(all)
    }

    /// Policies over a motion graph with a key.
    fn policies(&mut self, graph: &graph::RawMotionGraph, key: CacheKey) -> Result<Vec<RawPolicy>> {
        let (mut all, cfg, clips, s) = (Vec::new(), self.cfg, &self.motion.clips, self.s);
        if graph.states.is_empty() {
            return Ok(all);
        }
        let stays = |b: &PolicyBehaviourConfig| b.kind == BehaviourKind::Approach && !shows_walking(clips);
        for some in self.attempts.units_of_work(&cfg.behaviours) {
            let part = format!("policy {}", some[0].name);
            if self.attempts.parts == RequiredParts::Possible && some.iter().any(stays) {
                let why = "nobody walks in this motion, so that characters would stay where they are. Add walks that start, turn \
                           and stop, with root motion";
                self.attempts.accept::<()>(part, Err(BuildError::Config { message: why.into() }))?;
                continue;
            }
            let solved = s.stage("policy", &[key], &(&cfg.policy, some, cfg.seed), |p| {
                policy::solve(clips, graph, some, &cfg.policy, &mut Pcg64::seed_from_u64(cfg.seed), p, s.comm)
            });
            all.extend(self.attempts.accept(part, solved)?.into_iter().flat_map(|solved| solved.value.policies));
        }
        Ok(all)
    }
}

/// Processes clips as a build does before the motion graph, without mirrored copies, sidecars and surroundings; classes that
/// the config names hold.
///
/// # Errors
/// As the retarget, resample and annotate stages.
pub fn clips_of(raw: &[ImportedClip], cfg: &BuildConfig, warnings: &mut Warnings) -> Result<ClipSet> {
    let clips = retarget::retarget_clips(raw, &cfg.retarget, warnings)?;
    let clips = resample::resample(&clips, &ResampleConfig { mirror: false, ..cfg.resample.clone() })?;
    let mut marks = Sidecars::default();
    for clip in &clips.clips {
        let Some(class) = cfg.clips.get(&clip.name).and_then(|s| s.class.clone()) else { continue };
        marks.insert(&clip.name, Sidecar { class: Some(class), ..Sidecar::default() }, clip.rate_hz, None)?;
    }
    annotate::annotate(&clips, &cfg.annotate, &marks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::{NUM_JOINTS, Skeleton};
    use throng_motion::clip::Clip;

    #[test]
    fn who_walks_for_less_than_a_second_walks() {
        let set = |frames: usize, by: f32| {
            let roots = (0..frames).map(|f| Vec3::new(by * f as f32 / 30.0, 0.9, 0.0)).collect();
            let rotations = vec![glam::Quat::IDENTITY; frames * NUM_JOINTS];
            ClipSet { skeleton: Skeleton::default(), clips: vec![Clip::new("a", 30.0, roots, rotations)] }
        };
        for frames in [15, 31, 90] {
            assert!(shows_walking(&set(frames, 1.2)) && !shows_walking(&set(frames, 0.1)), "{frames} frames");
        }
        assert!(!shows_walking(&set(1, 1.2)) && !shows_walking(&set(4, 1.2)));
        assert!(describe_motion(&set(15, 1.2)).contains("somebody walks in it"));
    }
}
