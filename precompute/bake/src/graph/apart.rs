//! Motion that stays out of a graph, and why.

use super::connect::GraphInputs;
use super::events::EventFrame;
use super::take::{MAX_NAMED_CLIPS, TakenFrames};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_motion::clip::{FrameId, FrameRange, runs_where};

/// Shortest stretch that counts (s).
const SHORTEST_S: f64 = 1.0;
/// Most events of a stretch, and of the graph, that are compared.
const MAX_COMPARED: [usize; 2] = [8, 4096];

/// Motion of one gait that no action plays, for one reason.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionApart {
    /// Its gait.
    pub gait: String,
    /// Its duration, mirrored copies not counted (s).
    pub seconds: f64,
    /// Number of its clips.
    pub num_clips: usize,
    /// A few clips with most of it.
    pub clips: Vec<String>,
    /// Smallest distance of its frames from like moments of the graph (rad); `None` where it has no step and no stand.
    pub error: Option<f64>,
    /// `graph.max_error`, up to which motion is joined (rad).
    pub limit: f64,
}

impl std::fmt::Display for MotionApart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let more = if self.num_clips > self.clips.len() { ", ..." } else { "" };
        let (seconds, gait, clips, limit) = (self.seconds, &self.gait, self.clips.join(", "), self.limit);
        write!(f, "{gait} {seconds:.0} s of {} clip(s) ({clips}{more}): ", self.num_clips)?;
        match self.error {
            None => write!(f, "it has no step and no stand at which to change"),
            Some(e) if e > limit => write!(f, "{e:.2} rad from the rest at best, `graph.max_error` is {limit}"),
            Some(e) => write!(
                f,
                "near the rest ({e:.2} of {limit} rad), but it ends, or goes on for `graph.max_action_s`, before a way back"
            ),
        }
    }
}

/// What is known of a part: its time in each clip, and its distance from the graph.
#[derive(Default)]
struct ApartSum<'a> {
    clips: BTreeMap<&'a str, f64>,
    error: Option<f32>,
}

/// Motion that a graph takes and does not play, by gait and reason, the most first.
///
/// - `played`: for each frame, whether an action plays it.
pub(super) fn motion_apart(given: &GraphInputs<'_>, taken: &TakenFrames, played: &[bool]) -> Vec<MotionApart> {
    let GraphInputs { clips, config, events, rate_hz, .. } = *given;
    let of_graph: Vec<usize> = (0..events.len()).filter(|&i| played[events[i].frame.0 as usize]).collect();
    let every = of_graph.len().div_ceil(MAX_COMPARED[1]).max(1);
    let of_graph: Vec<usize> = of_graph.into_iter().step_by(every).collect();
    let limit = config.max_error as f32;
    let mut parts = BTreeMap::<(&str, usize), ApartSum<'_>>::new();
    for ((clip, first), runs) in clips.clips.iter().zip(clips.frame_starts()).zip(&taken.runs) {
        if clip.mirrored || clip.is_made() {
            continue;
        }
        let is_apart = |f: usize| !played[first as usize + f];
        for run in runs.iter().flat_map(|run| runs_where(run.clone(), is_apart)) {
            let gait = |f: usize| clip.class_at(f).map_or("motion", |c| c.gait.name());
            for stretch in split_by(run, gait).into_iter().filter(|s| s.len() as f64 >= SHORTEST_S * rate_hz) {
                let frames = first + stretch.start as u32..first + stretch.end as u32;
                let own = events.partition_point(|e| e.frame.0 < frames.start)
                    ..events.partition_point(|e| e.frame.0 < frames.end);
                let every = own.len().div_ceil(MAX_COMPARED[0]).max(1);
                let error = own.step_by(every).filter_map(|i| nearest(given, i, &of_graph)).min_by(f32::total_cmp);
                let reason = error.map_or(0, |e| 1 + usize::from(e > limit));
                let part = parts.entry((gait(stretch.start), reason)).or_default();
                *part.clips.entry(&clip.name).or_default() += stretch.len() as f64 / rate_hz;
                part.error = error.into_iter().chain(part.error).min_by(f32::total_cmp);
            }
        }
    }
    let told = |((gait, _), ApartSum { clips, error }): ((&str, usize), ApartSum<'_>)| {
        let (seconds, num_clips) = (clips.values().sum(), clips.len());
        let mut most: Vec<(&str, f64)> = clips.into_iter().collect();
        most.sort_by(|a, b| b.1.total_cmp(&a.1));
        let clips = most.iter().take(MAX_NAMED_CLIPS).map(|(name, _)| (*name).to_owned()).collect();
        let (error, limit) = (error.map(f64::from), config.max_error);
        MotionApart { gait: gait.to_owned(), seconds, num_clips, clips, error, limit }
    };
    let mut out: Vec<MotionApart> = parts.into_iter().map(told).collect();
    out.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    out
}

/// Runs of frames of one value within a run.
fn split_by<T: PartialEq>(run: FrameRange, value: impl Fn(usize) -> T) -> Vec<FrameRange> {
    let mut out: Vec<FrameRange> = Vec::new();
    for f in run {
        match out.last_mut() {
            Some(part) if value(part.start) == value(f) => part.end = f + 1,
            _ => out.push(f..f + 1),
        }
    }
    out
}

/// Distance of an event from the nearest one of the same kind among others (rad).
fn nearest(given: &GraphInputs<'_>, event: usize, others: &[usize]) -> Option<f32> {
    let of = |i: usize| -> &EventFrame { &given.events[i] };
    let mut best = f32::INFINITY;
    for &i in others.iter().filter(|&&i| of(i).kind == of(event).kind) {
        let [a, b] = [event, i].map(|k| FrameId(k as u32));
        best = given.features.squared_distance_within(a, b, best).unwrap_or(best);
    }
    best.is_finite().then(|| best.sqrt())
}
