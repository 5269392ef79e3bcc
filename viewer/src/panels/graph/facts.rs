//! The numbers of a motion graph, as Lee and Lee (2004), section 6 reports them.

use eframe::egui::Ui;
use throng_core::Bundle;

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
