//! Costs of actions beside their transitions: travel against the front, gestures, changes of manner.

use super::{ActionModel, BehaviourSpec};
use crate::graph::RawMotionGraph;
use glam::Vec2;
use throng_base::thresholds::WALKING_MPS;
use throng_core::format::{Gait, MADE_TAG, MotionClass};
use throng_motion::clip::{Clip, ClipSet};

/// What an action shows: backwards, sideways, gesturing, carrying (s), transitions to another manner, transitions
/// within standing (0 or 1), made motion, and running (s).
pub type ActionTraits = [f32; 8];

/// Half of the time over which travel and front are measured (s).
const HALF_S: f64 = 0.25;
/// Cosines of the angles between travel and front from which travel is sideways, and backwards: 45 and 120 degrees.
const OFF_FRONT: [f32; 2] = [std::f32::consts::FRAC_1_SQRT_2, -0.5];
/// Share of made motion that counts where nobody goes anywhere: without small steps people would stay short of targets.
const MADE_ON_THE_SPOT: f32 = 0.1;

/// Captured walking from which on running counts (s).
const WALKS_S: f64 = 10.0;

/// Share of a change of manner that counts where people keep neither of the two.
const WITHIN_KEPT: f32 = 0.0625;

/// What every action shows.
pub(super) fn action_traits(clips: &ClipSet, graph: &RawMotionGraph) -> Vec<ActionTraits> {
    let starts = clips.frame_starts();
    let at = |frame: u32| {
        let clip = starts.partition_point(|&s| s <= frame) - 1;
        (clip, (frame - starts[clip]) as usize)
    };
    let class = |frame: u32| clips.clips[at(frame).0].class_at(at(frame).1);
    let of_frames: Vec<Vec<[f32; 6]>> = clips.clips.iter().map(frame_traits).collect();
    let of_segments = graph.segments.iter().map(|s| {
        let ((clip, first), n) = (at(s.start.0), s.num_frames as usize);
        let mut sums = [0.0; 6];
        for frame in &of_frames[clip][first..first + n] {
            sums.iter_mut().zip(frame).for_each(|(sum, share)| *sum += share / clips.clips[clip].rate_hz as f32);
        }
        (sums, (first..=first + n).all(|f| clips.clips[clip].class_at(f).is_some_and(is_stand)))
    });
    let mut of_segments: Vec<([f32; 6], bool)> = of_segments.collect();
    let walking_s = graph.segments.iter().zip(&of_segments).map(|(s, (traits, _))| {
        let walks = class(s.start.0 + s.num_frames / 2).is_some_and(|c| c.gait == Gait::Walk) && traits[4] == 0.0;
        f64::from(u32::from(walks) * s.num_frames) / clips.clips[at(s.start.0).0].rate_hz
    });
    if walking_s.sum::<f64>() < WALKS_S {
        of_segments.iter_mut().for_each(|(traits, _)| traits[5] = 0.0);
    }
    let mut out = Vec::with_capacity(graph.actions.len());
    for (state, pair) in graph.states.iter().zip(graph.action_offsets.windows(2)) {
        for action in &graph.actions[pair[0] as usize..pair[1] as usize] {
            let segment = action.segment.0 as usize;
            let ([backwards, sideways, gesture, carrying, made, running], is_standing) = of_segments[segment];
            let entered = graph.segments[segment].start;
            let (mut manner, mut standing) = (0.0, 0.0);
            if let (false, Some(from), Some(to)) = (entered == *state, class(state.0), class(entered.0)) {
                let [kept, other] = [from, to].map(|class| graph.manners.kept_in(&class.manner));
                manner = if kept != other { 1.0 } else { WITHIN_KEPT * f32::from(from.manner != to.manner) };
                standing = f32::from(is_stand(from) && is_standing);
            }
            out.push([backwards, sideways, gesture, carrying, manner, standing, made, running]);
        }
    }
    out
}

fn is_stand(class: &MotionClass) -> bool {
    class.gait == Gait::Stand
}

/// Shares of every frame that go backwards, go sideways, gesture, carry, are made, and run.
fn frame_traits(clip: &Clip) -> Vec<[f32; 6]> {
    let (n, half) = (clip.num_frames(), ((HALF_S * clip.rate_hz).round() as usize).max(1));
    let roots: Vec<_> = (0..n).map(|f| clip.planar(f)).collect();
    let is_made = |f: usize| clip.tags.iter().any(|t| t.name == MADE_TAG && t.range.contains(&f));
    let of_frame = |f: usize| {
        let (from, to) = (f.saturating_sub(half), (f + half).min(n - 1));
        let way = Vec2::new(roots[to].x - roots[from].x, roots[to].z - roots[from].z);
        let front: Vec2 = roots[from..=to].iter().map(|r| Vec2::new(r.heading.sin(), r.heading.cos())).sum();
        let goes = way.length() * clip.rate_hz as f32 > WALKING_MPS * (to - from) as f32;
        let ahead = way.normalize_or_zero().dot(front.normalize_or_zero());
        let class = clip.class_at(f);
        let gestures = |c: &MotionClass| c.gait == Gait::Other || is_stand(c) && !c.neutral;
        [
            f32::from(goes && ahead < OFF_FRONT[1]),
            f32::from(goes && (OFF_FRONT[1]..OFF_FRONT[0]).contains(&ahead)),
            f32::from(class.is_some_and(gestures)),
            f32::from(class.is_some_and(|c| c.carrying)),
            if is_made(f) { if goes { 1.0 } else { MADE_ON_THE_SPOT } } else { 0.0 },
            f32::from(class.is_some_and(|c| c.gait == Gait::Run)),
        ]
    };
    (0..n).map(of_frame).collect()
}

/// Distance of each action that costs as much as its transition and its traits together; empty where traits cost nothing.
pub(super) fn own_errors(model: &ActionModel, spec: &BehaviourSpec<'_>) -> Vec<f32> {
    if spec.reward.record().own_errors == 0 {
        return Vec::new();
    }
    let (transition, costs) = (spec.costs.transition, spec.costs.traits);
    let own = |(action, &error): (usize, &f32)| {
        let traits = model.action_traits.get(action).copied().unwrap_or_default();
        let extra: f64 = traits.iter().zip(costs).map(|(&amount, cost)| f64::from(amount) * cost).sum();
        (transition * f64::from(error).powi(2) + extra).sqrt() as f32
    };
    model.action_errors.iter().enumerate().map(own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{GraphAction, GraphSegment, SegmentId, StateId};
    use glam::{Quat, Vec3};
    use throng_core::format::ClassSpan;
    use throng_core::{NUM_JOINTS, Planar, Skeleton};
    use throng_motion::clip::{ClipTag, FrameId};

    /// A clip at 30 Hz that goes `way` in every frame, facing +Z, of one class.
    fn clip(name: &str, num_frames: usize, way: Vec3, class: MotionClass) -> Clip {
        let places = (0..num_frames).map(|f| Vec3::Y + way * f as f32).collect();
        let mut clip = Clip::new(name, 30.0, places, vec![Quat::IDENTITY; num_frames * NUM_JOINTS]);
        clip.classes = vec![ClassSpan { frames: 0..num_frames as u32, class, ..ClassSpan::default() }];
        clip
    }

    #[test]
    fn travel_against_the_front_gestures_and_changes_are_found() {
        let class =
            |gait, neutral, manner: &str| MotionClass { gait, neutral, manner: manner.into(), ..Default::default() };
        let ahead = clip("ahead", 31, 0.04 * Vec3::Z, class(Gait::Walk, false, "sad"));
        let back = clip("back", 31, -0.04 * Vec3::Z, class(Gait::Backwards, false, "sad"));
        let side = clip("side", 31, 0.04 * Vec3::X, class(Gait::Strafe, false, "angry"));
        let mut rest = clip("rest", 31, Vec3::ZERO, class(Gait::Stand, true, "sad"));
        rest.tags = vec![ClipTag { name: MADE_TAG.into(), range: 0..15 }];
        let bow = clip("bow", 31, Vec3::ZERO, class(Gait::Stand, false, "sad"));
        let clips = ClipSet { skeleton: Skeleton::default(), clips: vec![ahead, back, side, rest, bow] };
        // A state at the begin and at the end of each clip; the last ones of `ahead` and `rest` lead to every clip.
        let states: Vec<FrameId> = (0..5).flat_map(|c| [FrameId(31 * c), FrameId(31 * c + 30)]).collect();
        let segment = |c: u32| GraphSegment {
            start: FrameId(31 * c),
            num_frames: 30,
            end: StateId(2 * c + 1),
            displacement: Planar::IDENTITY,
        };
        let action = |c: u32| GraphAction { segment: SegmentId(c), error: 0.1 };
        let mut graph = RawMotionGraph { segments: (0..5).map(segment).collect(), states, ..Default::default() };
        for state in 0..10 {
            graph.action_offsets.push(graph.actions.len() as u32);
            let leads_on = state == 1 || state == 7;
            graph.actions.extend(if leads_on { 0..5 } else { state / 2..state / 2 + 1 }.map(action));
        }
        graph.action_offsets.push(graph.actions.len() as u32);
        let traits = action_traits(&clips, &graph);
        let of = |state: usize| {
            let range = graph.action_offsets[state] as usize..graph.action_offsets[state + 1] as usize;
            traits[range].iter().map(|t| t.map(|v| (v * 100.0).round() as i32)).collect::<Vec<_>>()
        };
        assert_eq!(of(0), [[0; 8]], "a clip that goes on");
        let (back, side, bow) = ([100, 0, 0, 0, 0, 0, 0, 0], [0, 100, 0, 0, 100, 0, 0, 0], [0, 0, 100, 0, 0, 0, 0, 0]);
        assert_eq!(of(1), [[0; 8], back, side, [0, 0, 0, 0, 0, 0, 5, 0], bow]);
        let from_standing = [[0; 8], back, side, [0, 0, 0, 0, 0, 100, 5, 0], [0, 0, 100, 0, 0, 100, 0, 0]];
        assert_eq!(of(7), from_standing);
    }

    #[test]
    fn running_counts_where_people_can_walk() {
        let of = |gait| MotionClass { gait, ..MotionClass::default() };
        for (seconds, is_made, share) in [(9, false, 0.0), (11, false, 1.0), (11, true, 0.0)] {
            let mut walk = clip("walk", 30 * seconds + 1, 0.04 * Vec3::Z, of(Gait::Walk));
            walk.tags = vec![ClipTag { name: MADE_TAG.into(), range: 0..30 * usize::from(is_made) * seconds }];
            let run = clip("run", 31, 0.1 * Vec3::Z, of(Gait::Run));
            let clips = ClipSet { skeleton: Skeleton::default(), clips: vec![walk, run] };
            let (end, displacement) = (30 * seconds as u32, Planar::IDENTITY);
            let segment = |(start, num_frames, end)| GraphSegment {
                start: FrameId(start),
                num_frames,
                end: StateId(end),
                displacement,
            };
            let graph = RawMotionGraph {
                states: vec![FrameId(end), FrameId(end + 31)],
                segments: [(0, end, 0), (end + 1, 30, 1)].map(segment).to_vec(),
                actions: [0, 1].map(|s| GraphAction { segment: SegmentId(s), error: 0.0 }).to_vec(),
                action_offsets: vec![0, 2, 2],
                ..RawMotionGraph::default()
            };
            let traits = action_traits(&clips, &graph);
            assert!(traits[0][..6] == [0.0; 6] && traits[0][7] == 0.0, "walking costs nothing");
            assert!((traits[1][7] - share).abs() < 0.01 && traits[1][..7] == [0.0; 7], "{seconds} s: {:?}", traits[1]);
        }
    }
}
