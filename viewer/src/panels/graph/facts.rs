//! The numbers of a motion graph, as Lee and Lee (2004), section 6 reports them.

use eframe::egui::{RichText, Ui};
use throng_core::Bundle;

/// The numbers of a motion graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GraphFacts {
    states: usize,
    standing: usize,
    actions: usize,
    segments: usize,
    segment_s: f32,
    actions_per_state: [f32; 3],
    frames: [u64; 2],
}

impl GraphFacts {
    /// Counts the contents of a bundle.
    pub fn new(tables: &Bundle) -> Self {
        let graph = tables.graph();
        let counts = || graph.action_offsets.windows(2).map(|w| (w[1] - w[0]) as f32);
        let frames: u64 = graph.segments.iter().map(|s| u64::from(s.num_frames)).sum();
        let per = |sum: f32, n: usize| sum / n.max(1) as f32;
        Self {
            states: graph.states.len(),
            standing: graph.states.iter().filter(|s| s.standing != 0).count(),
            actions: graph.action_segments.len(),
            segments: graph.segments.len(),
            segment_s: per(frames as f32, graph.segments.len()) / tables.meta().rate_hz as f32,
            actions_per_state: [
                counts().fold(f32::INFINITY, f32::min),
                per(counts().sum(), graph.states.len()),
                counts().fold(0.0, f32::max),
            ],
            frames: [tables.meta().frames_in, tables.meta().frames_kept],
        }
    }

    /// Shows them in a line.
    pub fn show(&self, ui: &mut Ui) {
        let [least, mean, most] = self.actions_per_state;
        let [all, kept] = self.frames;
        let share = 100.0 * kept as f64 / all.max(1) as f64;
        let mut fact = |number: String, what: &str, hint: String| {
            let before = ui.spacing().item_spacing.x;
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.label(RichText::new(number).strong());
            ui.label(RichText::new(what).weak()).on_hover_text(hint);
            ui.spacing_mut().item_spacing.x = before;
            ui.add_space(6.0);
        };
        fact(
            self.states.to_string(),
            "states",
            format!("Frames at which a character may choose; {} of them standing.", self.standing),
        );
        fact(self.actions.to_string(), "actions", format!("{least:.0} to {most:.0} a state, {mean:.1} on average."));
        fact(format!("{mean:.1}"), &format!("a state, {most:.0} at most"), "Actions of a state: mean and most.".into());
        fact(
            self.segments.to_string(),
            "segments",
            format!("Motion between two choices, {:.2} s on average.", self.segment_s),
        );
        fact(
            format!("{kept} of {all}"),
            "frames kept",
            format!("{share:.0} % of the usable frames are played by some action."),
        );
    }
}
