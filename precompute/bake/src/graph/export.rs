//! The graph as JSON, for external checks.

use serde::Serialize;
use std::io::{self, Write};
use throng_core::Bundle;

/// A state of the listing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StateRow {
    /// Number of the state, as actions name it.
    pub index: u32,
    /// Name of the clip its frame lies in.
    pub clip: String,
    /// Frame within that clip.
    pub frame: u32,
    /// True if the character stands.
    pub standing: bool,
}

/// A planar transform of the listing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DisplacementRow {
    /// To the left of the initial facing (m).
    pub x_m: f32,
    /// Forwards (m).
    pub z_m: f32,
    /// Rotation about the vertical, positive to the left (rad).
    pub heading_rad: f32,
}

/// An action of the listing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ActionRow {
    /// State it leaves.
    pub from: u32,
    /// State it ends in.
    pub to: u32,
    /// Frames played.
    pub frames: u32,
    /// Duration (s).
    pub duration_s: f64,
    /// Root at the end, in the frame of the beginning.
    pub displacement: DisplacementRow,
    /// Name of the clip played.
    pub clip: String,
    /// Frame of that clip which replaces the state's frame.
    pub start_frame: u32,
    /// Distance between the two frames; 0 if the clip continues (rad).
    pub error: f32,
}

/// A motion graph as rows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GraphRows {
    /// Frame rate (Hz).
    pub rate_hz: f64,
    /// States, by index.
    pub states: Vec<StateRow>,
    /// Actions, grouped by the state they leave, in the order of its choices.
    pub actions: Vec<ActionRow>,
}

/// The rows of a bundle's graph.
pub fn graph_rows(tables: &Bundle) -> GraphRows {
    let (graph, clips) = (tables.graph(), tables.clips());
    let rate_hz = tables.meta().rate_hz;
    let place = |frame: u32| {
        let clip = clips.partition_point(|c| c.first_frame <= frame) - 1;
        (tables.meta().clips[clip].name.clone(), frame - clips[clip].first_frame)
    };
    let mut rows = GraphRows { rate_hz, states: Vec::new(), actions: Vec::new() };
    for (from, state) in graph.states.iter().enumerate() {
        let (clip, frame) = place(state.frame);
        rows.states.push(StateRow { index: from as u32, clip, frame, standing: state.standing == 1 });
        for action in graph.action_offsets[from] as usize..graph.action_offsets[from + 1] as usize {
            let segment = &graph.segments[graph.action_segments[action] as usize];
            let (clip, start_frame) = place(segment.start);
            let d = segment.displacement();
            rows.actions.push(ActionRow {
                from: from as u32,
                to: segment.end,
                frames: segment.num_frames,
                duration_s: f64::from(segment.num_frames) / rate_hz,
                displacement: DisplacementRow { x_m: d.x, z_m: d.z, heading_rad: d.heading },
                clip,
                start_frame,
                error: graph.action_errors[action],
            });
        }
    }
    rows
}

/// Writes rows as one JSON object and a line end.
///
/// # Errors
/// Errors of the writer.
pub fn write_graph_json(rows: &GraphRows, mut out: impl Write) -> io::Result<()> {
    serde_json::to_writer(&mut out, rows)?;
    out.write_all(b"\n")
}
