//! Report of a build, for people and for machines.

use crate::examples::{BlendReport, BlendSpaces};
use crate::graph::{GraphReport, MinMeanMax};
pub use crate::stages::SourcePerformer;
pub use crate::stages::StageCost;
use crate::stages::{BuildTiming, MotionOutput};
use crate::stops::StopsReport;
use crate::write::{BundleInputs, WrittenBundle};
use crate::{activities::ActivityReport, policy::PolicyReport};
use crate::{cluster::PoseGroups, config::BuildConfig, make::MadeReport, parts::SkippedPart, patch::PatchReport};
use serde::Serialize;
use std::collections::BTreeMap;
use throng_core::format::FrameRow;
use throng_motion::annotate::hits::{HitPoint, HitReport};
use throng_motion::{Warnings, annotate::ContactSanity};

/// Report printed by `throng build --json`.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BuildReport {
    /// The database's name.
    pub name: String,
    /// Clips, mirrored copies included.
    pub clips: usize,
    /// Frame rate of the database (Hz).
    pub rate_hz: f64,
    /// Usable motion, mirrored copies not counted (min).
    pub minutes_in: f64,
    /// Usable frames of all clips.
    pub frames_in: usize,
    /// Frames that some action plays.
    pub frames_kept: usize,
    /// States of the motion graph.
    pub states: usize,
    /// Actions of all states.
    pub actions: usize,
    /// Time from the first file to the finished bundle (s).
    pub seconds_total: f64,
    /// Time of each stage that ran (s).
    pub stage_s: BTreeMap<&'static str, f64>,
    /// Cost of each of these stages in this process.
    #[serde(skip)]
    pub spent: BTreeMap<&'static str, StageCost>,
    /// Outputs that were read from the cache: `motion` stands for import to clips.
    pub cached: Vec<&'static str>,
    /// Pose groups of the frames; 0 in a build without patches, which are their only use.
    pub pose_groups: usize,
    /// Largest distance between two frames of one group (rad).
    pub max_group_diameter: f64,
    /// Upper bound of every group's diameter (rad).
    pub group_threshold: f64,
    /// Mean and extremes of the frames of a group.
    pub group_frames: MinMeanMax,
    /// Reports of the motion patches.
    pub patches: Vec<PatchReport>,
    /// Reports of the blend spaces.
    pub blend_spaces: Vec<BlendReport>,
    /// Activities of standing bodies.
    pub activities: Vec<ActivityReport>,
    /// Examples of all blend spaces.
    pub blend_examples: usize,
    /// Weight tables of all blend spaces (bytes).
    pub weight_table_bytes: u64,
    /// Largest error of a tabulated weight against the exact one, over all blend spaces.
    pub weight_table_max_error: f64,
    /// Reports of the policies.
    pub policies: Vec<PolicyReport>,
    /// Length of the bundle (bytes).
    pub bundle_bytes: u64,
    /// Bytes of a frame's pose.
    pub frame_bytes: usize,
    /// Error of joint positions by packed rotations, for the worst joint of each frame: 95th percentile of all frames
    /// (mm).
    pub joint_error_p95_mm: f32,
    /// Largest error of all frames (mm).
    pub joint_error_worst_mm: f32,
    /// Motion that was made, as the clips lack it.
    pub made: MadeReport,
    /// The motion graph's figures.
    pub graph: GraphReport,
    /// Times in which characters can stop; all 0 without a motion graph.
    pub stops: StopsReport,
    /// Foot contacts over all clips: shares and speeds, weighted by frames.
    pub contacts: ContactSanity,
    /// Effective hitting points of all clips, mirrored copies included.
    pub hits: HitReport,
    /// Frames left out, by reason.
    pub excluded_frames: BTreeMap<String, usize>,
    /// Parts of the config that the motion does not allow, in a build that may leave them out.
    pub not_made: Vec<SkippedPart>,
    /// Performers: files grouped by source skeleton.
    pub performers: Vec<SourcePerformer>,
    /// Files imported by an earlier build, if the stage `import` ran.
    pub files_kept: usize,
    /// Files with clips made by an earlier build, if the stage `clips` ran.
    pub clips_kept: usize,
    /// Skipped files, with the reason.
    pub skipped: Vec<String>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// All outputs of a build.
pub(crate) struct BuildProducts<'a> {
    pub motion: &'a MotionOutput,
    pub baked: BundleInputs<'a>,
    pub blends: &'a BlendSpaces,
    pub made: &'a MadeReport,
    pub graph: &'a GraphReport,
    pub stops: StopsReport,
    pub written: WrittenBundle,
    /// Contact sanity of each clip, from the rank with its poses.
    pub sanity: Vec<ContactSanity>,
}

/// Assembles the report; `odd` holds warnings about the build itself.
pub(crate) fn build_report(
    cfg: &BuildConfig,
    built: &BuildProducts<'_>,
    timing: BuildTiming,
    odd: Warnings,
) -> BuildReport {
    let BuildProducts { motion, baked, blends, made, graph, stops, written, ref sanity } = *built;
    let (blends, blend_warnings) = (&blends.report, &blends.warnings);
    let mut warnings = [&motion.warnings, blend_warnings, &odd].map(|w| w.messages.clone()).concat();
    // A config that keeps captured heights has terrain.
    warnings.extend(far_from_ground(motion, sanity).filter(|_| cfg.retarget.align_ground));
    warnings.extend(baked.policies.iter().filter_map(|p| p.report.promise.warning.clone()));
    let groups = baked.groups.cloned().unwrap_or_default();
    let mut spent = BTreeMap::<_, StageCost>::new();
    for &(name, of) in &timing.stages {
        spent.entry(name).and_modify(|all| *all = all.plus(of)).or_insert(of);
    }
    let mut excluded_frames = BTreeMap::new();
    for e in motion.clips.clips.iter().flat_map(|c| &c.excluded) {
        *excluded_frames.entry(e.reason.to_string()).or_insert(0) += e.range.len();
    }
    let originals = motion.clips.clips.iter().filter(|c| !c.mirrored && !c.is_made());
    let originals: usize = originals.flat_map(|c| c.usable_ranges()).map(|range| range.len()).sum();
    BuildReport {
        name: cfg.name.clone(),
        clips: motion.clips.clips.len(),
        rate_hz: cfg.resample.rate_hz,
        minutes_in: originals as f64 / cfg.resample.rate_hz / 60.0,
        frames_in: graph.frames_in,
        frames_kept: graph.frames_kept,
        states: graph.states,
        actions: graph.actions,
        seconds_total: timing.seconds_total,
        stage_s: spent.iter().map(|(name, of)| (*name, of.wall_s)).collect(),
        spent,
        cached: timing.cached,
        pose_groups: groups.num_groups(),
        max_group_diameter: f64::from(groups.max_diameter),
        group_threshold: f64::from(groups.threshold),
        group_frames: group_frames(&groups),
        patches: baked.patches.map_or_else(Vec::new, |p| p.report.clone()),
        blend_spaces: blends.to_vec(),
        activities: baked.activities.iter().map(|a| ActivityReport::from_meta(a, cfg.resample.rate_hz)).collect(),
        blend_examples: blends.iter().map(|b| b.examples.len()).sum(),
        weight_table_bytes: blends.iter().map(|b| b.weight_table_bytes).sum(),
        weight_table_max_error: blends.iter().map(|b| b.weight_table_max_error).fold(0.0, f64::max),
        policies: baked.policies.iter().map(|p| p.report.clone()).collect(),
        bundle_bytes: written.bytes,
        frame_bytes: size_of::<FrameRow>(),
        joint_error_p95_mm: written.joint_error_mm[0],
        joint_error_worst_mm: written.joint_error_mm[1],
        made: made.clone(),
        graph: graph.clone(),
        stops,
        contacts: contacts(motion, sanity),
        hits: HitReport::new(&HitPoint::from_clip_set(&motion.clips)),
        excluded_frames,
        not_made: Vec::new(),
        performers: motion.performers.clone(),
        files_kept: motion.files_kept,
        clips_kept: motion.clips_kept,
        skipped: motion.skipped.clone(),
        warnings,
    }
}

impl BuildReport {
    /// Summary of the outputs, such as `policies approach; blend spaces ahead`.
    pub fn summary(&self) -> String {
        let policies: Vec<&str> = self.policies.iter().map(|p| &*p.name).collect();
        let spaces: Vec<&str> = self.blend_spaces.iter().map(|b| &*b.name).collect();
        let patches: Vec<&str> = self.patches.iter().map(|p| &*p.name).collect();
        let list = |what: &str, names: Vec<&str>| (!names.is_empty()).then(|| format!("{what} {}", names.join(", ")));
        let mut activities: Vec<&str> = self.activities.iter().map(|a| &*a.tag).collect();
        activities.dedup();
        let all = [
            list("policies", policies),
            list("blend spaces", spaces),
            list("motion patches", patches),
            list("activities", activities),
        ];
        let all: Vec<String> = all.into_iter().flatten().collect();
        if all.is_empty() { "clips alone".into() } else { all.join("; ") }
    }
}

/// Mean and extremes of the number of frames of the groups.
fn group_frames(groups: &PoseGroups) -> MinMeanMax {
    let mut frames = vec![0u32; groups.num_groups()];
    groups.groups.iter().filter(|g| **g != PoseGroups::NO_GROUP).for_each(|&g| frames[g as usize] += 1);
    MinMeanMax::from_values(frames.into_iter().map(f64::from))
}

/// Warning about the clip whose standing feet are farthest from the ground, with the number of other such clips.
fn far_from_ground(motion: &MotionOutput, of_clips: &[ContactSanity]) -> Option<String> {
    let originals = motion.clips.clips.iter().zip(of_clips).filter(|(c, _)| !c.mirrored);
    let far: Vec<_> = originals.filter_map(|(c, s)| Some((c, s.stance.p95_cm, s.stance.advice()?))).collect();
    let (clip, _, advice) = far.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let more = match far.len() {
        1 => String::new(),
        n => format!(", farthest of {n} clips whose feet are off the ground"),
    };
    Some(format!("{}{more}: {advice}. `throng inspect` has all of them.", clip.name))
}

/// Mean contact sanity of all originals, weighted by frames; 95th percentiles and distances are the largest of any
/// clip.
fn contacts(motion: &MotionOutput, of_clips: &[ContactSanity]) -> ContactSanity {
    let (mut sum, mut frames) = (ContactSanity::default(), 0.0f32);
    for (c, s) in motion.clips.clips.iter().zip(of_clips).filter(|(c, _)| !c.mirrored) {
        let n = c.num_frames() as f32;
        sum.left_share += n * s.left_share;
        sum.right_share += n * s.right_share;
        sum.mean_speed_mps += n * s.mean_speed_mps;
        sum.p95_speed_mps = sum.p95_speed_mps.max(s.p95_speed_mps);
        sum.stance = sum.stance.worse_of(s.stance);
        frames += n;
    }
    let share = |v: f32| v / frames.max(1.0);
    ContactSanity {
        left_share: share(sum.left_share),
        right_share: share(sum.right_share),
        mean_speed_mps: share(sum.mean_speed_mps),
        ..sum
    }
}
