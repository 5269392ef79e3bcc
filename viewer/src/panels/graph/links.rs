//! Actions as links between states, and figures of a motion graph.

use eframe::egui::Ui;
use throng_core::{Bundle, graph::MotionGraph};

/// An action, by the state that may take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionLink {
    /// State that may take it.
    pub from: u32,
    /// Segment it plays.
    pub segment: u32,
    /// Difference of the frames at which the clip is left; 0 if the clip continues (rad).
    pub error: f32,
}

/// Actions by the state that they lead to.
#[derive(Clone, Debug, Default)]
pub struct ActionLinks {
    /// Actions that lead into each state, by the state that may take them (number of states).
    pub incoming: Vec<Vec<ActionLink>>,
    /// Actions that play each segment (number of segments).
    pub plays: Vec<u32>,
    /// The largest of them.
    pub max_plays: u32,
    /// The largest error of all actions (rad).
    pub max_error: f32,
}

impl ActionLinks {
    /// Goes through all actions of a graph.
    pub fn new(graph: &MotionGraph) -> Self {
        let mut incoming = vec![Vec::new(); graph.states.len()];
        let mut plays = vec![0; graph.segments.len()];
        for link in (0..graph.states.len() as u32).flat_map(|from| outgoing(graph, from)) {
            incoming[graph.segments[link.segment as usize].end as usize].push(link);
            plays[link.segment as usize] += 1;
        }
        let max_plays = plays.iter().copied().max().unwrap_or(0);
        let max_error = graph.action_errors.iter().copied().fold(0.0, f32::max);
        Self { incoming, plays, max_plays, max_error }
    }
}

/// Actions of a state, in order (state < number of states).
pub fn outgoing(graph: &MotionGraph, from: u32) -> impl Iterator<Item = ActionLink> {
    let first = graph.action_offsets[from as usize] as usize;
    let errors = &graph.action_errors[first..];
    graph.segments_of(from).iter().zip(errors).map(move |(&segment, &error)| ActionLink { from, segment, error })
}

/// The numbers of a motion graph: each as text, with its subject and a hint.
#[derive(Clone, Debug)]
pub struct GraphFacts([[String; 3]; 5]);

impl GraphFacts {
    /// Counts the contents of a bundle.
    pub fn new(tables: &Bundle) -> Self {
        let graph = tables.graph();
        let counts = || graph.action_offsets.windows(2).map(|w| (w[1] - w[0]) as f32);
        let frames: u64 = graph.segments.iter().map(|s| u64::from(s.num_frames)).sum();
        let per = |sum: f32, n: usize| sum / n.max(1) as f32;
        let standing = graph.states.iter().filter(|s| s.standing != 0).count();
        let segment_s = per(frames as f32, graph.segments.len()) / tables.meta().rate_hz as f32;
        let (least, most) = (counts().fold(f32::INFINITY, f32::min), counts().fold(0.0, f32::max));
        let mean = per(counts().sum(), graph.states.len());
        let (all, kept) = (tables.meta().frames_in, tables.meta().frames_kept);
        let share = 100.0 * kept as f64 / all.max(1) as f64;
        let of_states = format!("Frames at which a character may choose; {standing} of them standing.");
        let of_actions = format!("{least:.0} to {most:.0} a state, {mean:.1} on average.");
        let of_segments = format!("Motion between two choices, {segment_s:.2} s on average.");
        let of_frames = format!("{share:.0} % of the usable frames are played by some action.");
        Self([
            [graph.states.len().to_string(), "states".into(), of_states],
            [graph.action_segments.len().to_string(), "actions".into(), of_actions],
            [format!("{mean:.1}"), format!("a state, {most:.0} at most"), "Actions of a state: mean and most.".into()],
            [graph.segments.len().to_string(), "segments".into(), of_segments],
            [format!("{kept} of {all}"), "frames kept".into(), of_frames],
        ])
    }

    /// Shows them in a line.
    pub fn show(&self, ui: &mut Ui) {
        for [number, subject, hint] in &self.0 {
            let before = ui.spacing().item_spacing.x;
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.strong(number);
            ui.weak(subject).on_hover_text(hint);
            ui.spacing_mut().item_spacing.x = before;
            ui.add_space(6.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::golden;
    use super::*;

    #[test]
    fn actions_into_a_state_are_those_that_a_search_finds() {
        let b = golden();
        let graph = b.tables().graph();
        let links = ActionLinks::new(graph);
        let mut total = 0;
        for to in 0..graph.states.len() as u32 {
            let leads = |l: &ActionLink| graph.segments[l.segment as usize].end == to;
            let searched: Vec<ActionLink> =
                (0..graph.states.len() as u32).flat_map(|s| outgoing(graph, s)).filter(leads).collect();
            assert_eq!(links.incoming[to as usize], searched);
            total += searched.len();
        }
        assert_eq!(total, graph.action_segments.len());
        assert_eq!(links.plays.iter().sum::<u32>() as usize, total);
    }
}
