//! Evading a blow: the opponent's motion is part of the state.
//!
//! The boxers of Lee and Lee (2004) train against a standing target; their discussion asks for policies learned from
//! sparring. Here the opponent's motion is reduced to the place of the coming blow and the time left until then, which
//! are the axes of a space-time grid.

use super::super::config::{KernelConfig, PolicyBehaviourConfig, RewardForm};
use super::{super::model::SegmentMotion, BehaviourSpec, PolicyBehaviour, joint_named};
use crate::share::{clip_owners, sort_by_owner};
use crate::{graph::RawMotionGraph, stages::stage_error};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::{Comm, maths::quantile};
use throng_core::Joint;
use throng_core::policy::{PATH_POINTS, PathRecord, RegionRecord, Reward, RewardRecord, SegmentRecord};
use throng_motion::{BuildError, ClipSet, Result};

/// Behaviour of being away from the place where a blow lands, at that moment.
///
/// The reward of an action is `gain * discount^t * kernel(distance)` if the blow lands during it, at time t, with the
/// distance of the guarded point from the blow's place; a negative gain makes being hit a loss. Values without a coming
/// blow are 0, so that the behaviour adds nothing to others then.
#[derive(Clone, Debug)]
pub struct Evade {
    config: PolicyBehaviourConfig,
    /// Properties, without the name.
    spec: BehaviourSpec<'static>,
    paths: Vec<PathRecord>,
}

impl Evade {
    /// # Errors
    /// [`BuildError::Key`] names the key that is out of its range.
    pub fn new(c: &PolicyBehaviourConfig, clips: &ClipSet, graph: &RawMotionGraph, comm: &dyn Comm) -> Result<Self> {
        c.check()?;
        if c.reward.is_some_and(|r| r != RewardForm::Max) {
            return Err(BuildError::key("reward", "the kind `evade` has `max` alone: one blow lands at one moment"));
        }
        let joint = joint_named("point", &c.point, "`head`, `upper_chest`")?;
        let rate_hz = clips.clips.first().map_or(30.0, |c| c.rate_hz);
        let paths = joint_paths(clips, graph, joint, comm)?;
        // Median height of the point at the starts of segments (m).
        let median = || quantile(paths.iter().map(|p| p.points[0][1]), [1, 2]).map_or(1.5, f64::from);
        let height = c.height.unwrap_or_else(median);
        let grid = c.grid.make_space_time()?;
        let r = grid.record();
        let horizon = r.height_spacing * (r.num_heights - 1) as f32;
        let default =
            RegionRecord { distance: [0.0, grid.radius()], height: [0.0, horizon], ..RegionRecord::EVERYWHERE };
        let (reward, costs) = c.make_reward(RewardForm::Max, KernelConfig::Exponential, 0.2, -1.0)?;
        let reward = RewardRecord { height: height as f32, ..*reward.record() };
        let region = c.region.make_region(true, default)?;
        let reward = Reward::new(reward).map_err(|e| BuildError::key("height", e))?;
        let spec = BehaviourSpec { region, costs, ..BehaviourSpec::new("", grid, reward, c.discount_at(rate_hz)) };
        Ok(Self { config: c.clone(), spec, paths })
    }
}

/// Path of a joint over every segment (num_segments).
fn joint_paths(clips: &ClipSet, graph: &RawMotionGraph, joint: Joint, comm: &dyn Comm) -> Result<Vec<PathRecord>> {
    let starts = clips.frame_starts();
    // To the middle of the head.
    let offset = if joint == Joint::Head { 0.5 * clips.skeleton.tips[0] } else { Vec3::ZERO };
    let clip_of = |s: &crate::graph::GraphSegment| starts.partition_point(|&f| f <= s.start.0) - 1;
    let path = |n: usize| {
        let s = &graph.segments[n];
        let clip = clip_of(s);
        let first = (s.start.0 - starts[clip]) as usize;
        let clip = &clips.clips[clip];
        let to_start = clip.planar(first).inverse();
        let at = |frame: usize| {
            let (p, r) = clip.joint_transforms(&clips.skeleton, frame)[joint.index()];
            to_start.translation() + to_start.rotation() * (p + r * offset)
        };
        let points = std::array::from_fn(|k| {
            let t = k as f32 * s.num_frames as f32 / (PATH_POINTS - 1) as f32;
            let low = (t as usize).min(s.num_frames as usize - 1);
            at(first + low).lerp(at(first + low + 1), t - low as f32).to_array()
        });
        PathRecord { points, duration_s: s.num_frames as f32 / clip.rate_hz as f32 }
    };
    let of_clips = clip_owners(clips, comm.num_ranks());
    let of_segments: Vec<usize> = graph.segments.iter().map(|s| of_clips[clip_of(s)]).collect();
    let sent: Vec<SentPath> = sort_by_owner(comm, &of_segments, |n| SentPath(path(n)))?;
    Ok(sent.into_iter().map(|s| s.0).collect())
}

/// A path, serialized between ranks.
#[derive(Serialize, Deserialize)]
struct SentPath(#[serde(with = "throng_motion::pod::one")] PathRecord);

impl PolicyBehaviour for Evade {
    fn spec(&self) -> BehaviourSpec<'_> {
        BehaviourSpec { name: &self.config.name, ..self.spec }
    }

    fn sample(&self, _: usize, _: &SegmentMotion, _: &mut SegmentRecord) {}

    fn paths(&self) -> &[PathRecord] {
        &self.paths
    }

    fn check_values(&self, values: &[f32]) -> Result<()> {
        if values.iter().any(|&v| v != 0.0) {
            return Ok(());
        }
        let (name, point) = (&self.config.name, &self.config.point);
        let message = format!("behaviour \"{name}\": no blow in its grid ever comes near `{point}`");
        Err(stage_error("policy", message, "Raise `scale`, or set `height` to where blows land."))
    }
}
