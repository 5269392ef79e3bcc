//! Collapses event frames with a single outgoing edge into segments between states.

use super::events::{EventFrame, EventFrameKind};
use super::matches::{TransitionLink, displacement};
use super::{GraphAction, GraphSegment, RawMotionGraph, SegmentId, StateId, component::EventGraph};
use throng_motion::clip::{ClipSet, FrameId};

/// Choices of an event: the event whose motion follows (itself if the clip continues), and the error.
fn list_choices(graph: &EventGraph, alive: &[bool], i: usize) -> Vec<TransitionLink> {
    let on = graph.has_live_successor(i, alive).then_some(TransitionLink::new(i, 0.0));
    on.into_iter().chain(graph.live_links(i, alive).copied()).collect()
}

/// Mean number of actions of the states that [`collapse`] would return.
pub(super) fn branching(graph: &EventGraph, alive: &[bool]) -> f64 {
    let paths = (0..alive.len()).filter(|&i| alive[i]).map(|i| list_choices(graph, alive, i).len()).filter(|&n| n > 1);
    let (states, actions) = paths.fold((0, 0), |(states, actions), n| (states + 1, actions + n));
    actions as f64 / f64::from(states.max(1))
}

/// The states, actions and segments of a component.
///
/// - `alive`: a component of [`super::component::largest_component`]: an event with a single outgoing edge continues in
///   its own clip, so every segment lies in one clip.
///
/// # Panics
/// If `alive` is no such component.
pub(super) fn collapse(graph: &EventGraph, alive: &[bool], events: &[EventFrame], clips: &ClipSet) -> RawMotionGraph {
    let paths: Vec<Vec<TransitionLink>> =
        (0..alive.len()).map(|i| if alive[i] { list_choices(graph, alive, i) } else { Vec::new() }).collect();
    let is_state = |i: usize| paths[i].len() > 1;
    let state_events: Vec<usize> = (0..alive.len()).filter(|&i| is_state(i)).collect();
    let mut starts: Vec<usize> = state_events.iter().flat_map(|&i| paths[i].iter().map(|l| l.event())).collect();
    starts.sort_unstable();
    starts.dedup();

    let frame_starts = clips.frame_starts();
    let index_of = |sorted: &[usize], x: usize| sorted.binary_search(&x).map_or(u32::MAX, |k| k as u32);
    let segment = |&start: &usize| {
        let end = std::iter::successors(graph.next[start], |&e| graph.next[e])
            .find(|&e| is_state(e))
            .expect("an event of a component that is no state goes on in its clip");
        let (from, to) = (events[start].frame, events[end].frame);
        GraphSegment {
            start: from,
            num_frames: to.0 - from.0,
            end: StateId(index_of(&state_events, end)),
            displacement: displacement(clips, &frame_starts, events[start].clip, from, to),
        }
    };
    let segments = starts.iter().map(segment).collect();
    let mut actions = Vec::new();
    let mut action_offsets = vec![0];
    for &i in &state_events {
        let action =
            |l: &TransitionLink| GraphAction { segment: SegmentId(index_of(&starts, l.event())), error: l.error };
        let mut of_state: Vec<GraphAction> = paths[i].iter().map(action).collect();
        of_state.sort_unstable_by(|a, b| a.error.total_cmp(&b.error).then(a.segment.cmp(&b.segment)));
        actions.extend(of_state);
        action_offsets.push(actions.len() as u32);
    }
    let states: Vec<FrameId> = state_events.iter().map(|&i| events[i].frame).collect();
    let standing = places_to_stand(&state_events.iter().map(|&i| &events[i]).collect::<Vec<_>>());
    RawMotionGraph { states, standing, segments, action_offsets, actions, ..RawMotionGraph::default() }
}

/// For each state, true if a character may stand there for long: states at rest, or all standing states if every one of
/// them holds an arm out.
fn places_to_stand(states: &[&EventFrame]) -> Vec<bool> {
    let any_rests = states.iter().any(|e| e.is_rest);
    states.iter().map(|e| if any_rests { e.is_rest } else { e.kind == EventFrameKind::Standing }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_always_holds_an_arm_out_may_stand_so() {
        let event = |kind, is_rest| EventFrame {
            frame: FrameId(0),
            clip: 0,
            kind,
            run: 0,
            standing_run: None,
            is_rest,
            run_end: FrameId(1),
        };
        let (walks, gesture, rest) = (
            event(EventFrameKind::LeavesBoth, false),
            event(EventFrameKind::Standing, false),
            event(EventFrameKind::Standing, true),
        );
        assert_eq!(places_to_stand(&[&walks, &gesture, &rest]), [false, false, true]);
        assert_eq!(places_to_stand(&[&walks, &gesture]), [false, true]);
    }
}
