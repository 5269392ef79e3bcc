//! Motion that stays out of a graph, and why.

use super::take::{MAX_NAMED_CLIPS, TakenFrames};
use super::{connect::GraphInputs, events::EventFrame};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_core::format::Gait;
use throng_motion::clip::{FrameId, runs_where};

/// Shortest stretch that counts (s).
const SHORTEST_S: f64 = 1.0;
/// Most events of a stretch, and of the graph, that are compared.
const MAX_COMPARED: [usize; 2] = [4, 2048];

/// Motion of one gait that no action plays, for one reason.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionApart {
    /// Its gait.
    pub gait: String,
    /// Its duration, mirrored copies not counted (s).
    pub seconds: f64,
    /// Its clips.
    pub clips: Vec<String>,
    /// Smallest distance of its frames from like moments of the graph (rad); `None` where it has no step and no stand.
    pub error: Option<f64>,
    /// `graph.max_error`, up to which motion is joined (rad).
    pub limit: f64,
}

impl std::fmt::Display for MotionApart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (seconds, gait, limit, num) = (self.seconds, &self.gait, self.limit, self.clips.len());
        let more = if num > MAX_NAMED_CLIPS { ", ..." } else { "" };
        let clips = self.clips[..num.min(MAX_NAMED_CLIPS)].join(", ");
        write!(f, "{gait} {seconds:.0} s of {num} clip(s) ({clips}{more}): ")?;
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

/// Motion that a graph takes and does not play, by gait and reason, the most first.
///
/// - `played`: for each frame, whether an action plays it.
pub(super) fn motion_apart(given: &GraphInputs<'_>, taken: &TakenFrames, played: &[bool]) -> Vec<MotionApart> {
    let GraphInputs { clips, config, events, rate_hz, .. } = *given;
    let of_graph: Vec<usize> = (0..events.len()).filter(|&i| played[events[i].frame.0 as usize]).collect();
    let of_graph: Vec<usize> = take_some(&of_graph, MAX_COMPARED[1]).copied().collect();
    let mut parts = BTreeMap::<(Gait, usize), MotionApart>::new();
    for ((clip, first), runs) in clips.clips.iter().zip(clips.frame_starts()).zip(&taken.runs) {
        let is_apart = |f: usize| !played[first as usize + f] && runs.iter().any(|run| run.contains(&f));
        for span in clip.classes.iter().filter(|_| !clip.mirrored && !clip.is_made()) {
            for stretch in runs_where(span.frames.start as usize..span.frames.end as usize, is_apart) {
                let seconds = stretch.len() as f64 / rate_hz;
                if seconds < SHORTEST_S {
                    continue;
                }
                let event = |f: usize| events.partition_point(|e| e.frame.0 < first + f as u32);
                let own: Vec<usize> = (event(stretch.start)..event(stretch.end)).collect();
                let own = take_some(&own, MAX_COMPARED[0]).filter_map(|&i| nearest(given, i, &of_graph));
                let error = own.min_by(f32::total_cmp).map(f64::from);
                let reason = error.map_or(0, |e| 1 + usize::from(e > config.max_error));
                let part = parts.entry((span.class.gait, reason)).or_insert_with(|| MotionApart {
                    gait: span.class.gait.name().to_owned(),
                    seconds: 0.0,
                    clips: Vec::new(),
                    error,
                    limit: config.max_error,
                });
                part.seconds += seconds;
                part.error = part.error.zip(error).map(|(a, b)| a.min(b));
                if part.clips.last() != Some(&clip.name) {
                    part.clips.push(clip.name.clone());
                }
            }
        }
    }
    let mut out: Vec<MotionApart> = parts.into_values().collect();
    out.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    out
}

/// About so many of a list, evenly.
fn take_some(all: &[usize], most: usize) -> impl Iterator<Item = &usize> {
    all.iter().step_by(all.len().div_ceil(most).max(1))
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
