//! The actions from a frame: those of its state, or of the next state.

use super::track::{StateMark, TimelineTrack};
use crate::bundle::OpenBundle;
use crate::panels::graph::links::{ActionLink, outgoing};
use crate::panels::words::side;
use throng_core::Planar;

/// An action of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutgoingAction {
    /// Segment that is played.
    pub segment: u32,
    /// Clip it lies in.
    pub clip: usize,
    /// First frame within that clip.
    pub start: u32,
    /// Frames played.
    pub num_frames: u32,
    /// Displacement from its start.
    pub displacement: Planar,
    /// Difference between the frame that is left and the segment's first frame.
    pub error: f32,
    /// The clip simply goes on.
    pub continues: bool,
}

/// A state and its actions.
#[derive(Clone, Debug, PartialEq)]
pub struct OutgoingActions {
    /// The state.
    pub from: StateMark,
    /// Actions of the state, the one that continues the clip first, then by error.
    pub actions: Vec<OutgoingAction>,
}

impl OutgoingActions {
    /// The actions from a frame; none if no state of the clip follows.
    ///
    /// - `clip`: the clip that `track` shows.
    pub fn from_frame(bundle: &OpenBundle, clip: usize, track: &TimelineTrack, frame: u32) -> Option<Self> {
        let from = track.state_from(frame)?;
        let tables = bundle.tables();
        let graph = tables.graph();
        let action = |link: ActionLink| {
            let s = &graph.segments[link.segment as usize];
            let start = s.start - tables.clips()[s.clip as usize].first_frame;
            OutgoingAction {
                segment: link.segment,
                clip: s.clip as usize,
                start,
                num_frames: s.num_frames,
                displacement: s.displacement(),
                error: link.error,
                continues: s.clip as usize == clip && start == from.frame,
            }
        };
        let mut actions: Vec<OutgoingAction> = outgoing(graph, from.state).map(action).collect();
        actions.sort_by(|a, b| b.continues.cmp(&a.continues).then(a.error.total_cmp(&b.error)));
        Some(Self { from, actions })
    }
}

/// Text of a displacement: metres ahead, metres to the side, the turn. Negligible parts are empty.
pub fn displacement_texts(d: Planar) -> [String; 3] {
    let turn = d.heading.to_degrees();
    [
        if d.z.abs() < 0.05 { String::new() } else { format!("{:.1} m", d.z) },
        if d.x.abs() < 0.05 { String::new() } else { format!("{:.1} m {}", d.x.abs(), side(d.x)) },
        if turn.abs() < 0.5 { String::new() } else { format!("{:.0}° {}", turn.abs(), side(turn)) },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::golden;

    #[test]
    fn actions_equal_those_of_a_full_search() {
        let bundle = golden();
        let (tables, graph) = (bundle.tables(), bundle.tables().graph());
        let mut found = 0;
        for (clip, record) in tables.clips().iter().enumerate() {
            let track = TimelineTrack::from_bundle(&bundle, clip).unwrap();
            let rows = record.first_frame..record.first_frame + record.num_frames;
            for frame in 0..record.num_frames {
                let after = |s: &usize| {
                    let row = graph.states[*s].frame;
                    rows.contains(&row) && row >= rows.start + frame
                };
                let state = (0..graph.states.len()).filter(after).min_by_key(|s| graph.states[*s].frame);
                let out = OutgoingActions::from_frame(&bundle, clip, &track, frame);
                assert_eq!(out.as_ref().map(|o| o.from.state as usize), state);
                let Some((out, state)) = out.zip(state) else { continue };
                let actions = graph.action_offsets[state] as usize..graph.action_offsets[state + 1] as usize;
                let mut expected: Vec<_> =
                    actions.map(|a| (graph.action_segments[a], graph.action_errors[a].to_bits())).collect();
                let mut got: Vec<_> = out.actions.iter().map(|w| (w.segment, w.error.to_bits())).collect();
                expected.sort_unstable();
                got.sort_unstable();
                assert_eq!(got, expected);
                assert!(out.actions.iter().skip(1).is_sorted_by(|a, b| a.error <= b.error));
                assert!(out.actions.iter().filter(|w| w.continues).all(|w| w.error == 0.0));
                found += out.actions.len();
            }
        }
        assert!(found > 100, "{found}");
    }

    #[test]
    fn displacements_are_said_in_directions() {
        assert_eq!(displacement_texts(Planar::new(0.0, 0.0, 0.0)), ["", "", ""]);
        assert_eq!(displacement_texts(Planar::new(0.2, 1.0, 0.5)), ["1.0 m", "0.2 m left", "29° left"]);
        assert_eq!(displacement_texts(Planar::new(-0.2, -1.0, -0.5)), ["-1.0 m", "0.2 m right", "29° right"]);
    }
}
