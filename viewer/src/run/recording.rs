//! The record of a run: keyframes, inputs, figures and trails of the last minute.

use super::figures::StepFigures;
use super::simulation::{CrowdKeyframe, CrowdSimulation, RunInput};
use glam::Vec2;
use std::collections::VecDeque;
use std::ops::RangeInclusive;

/// Steps that can be gone back: one minute.
pub const RECORDED_STEPS: u32 = 3600;
/// Steps between two points of a trail.
pub const TRAIL_EVERY: u32 = 12;
/// Steps between two keyframes.
const KEYFRAME_EVERY: u32 = 60;

/// The record.
#[derive(Clone, Debug, Default)]
pub(super) struct CrowdRecording {
    /// Ascending by step; the first one is at or before the first step that can be shown.
    keyframes: VecDeque<CrowdKeyframe>,
    /// Inputs with the step that they precede, in order.
    inputs: VecDeque<(u32, RunInput)>,
    /// Figures of the steps from `first` on.
    figures: VecDeque<StepFigures>,
    first: u32,
    /// Planar positions of all characters at every [`TRAIL_EVERY`]th step.
    trails: VecDeque<(u32, Vec<Vec2>)>,
}

impl CrowdRecording {
    /// Recording of a run before its first step.
    pub fn new(start: CrowdKeyframe) -> Self {
        Self { keyframes: VecDeque::from([start]), ..Self::default() }
    }

    /// Steps that can be shown (a step has been taken).
    pub fn range(&self) -> RangeInclusive<u32> {
        self.first..=(self.first + self.figures.len() as u32).saturating_sub(1)
    }

    /// Inputs that take effect before a step.
    pub fn inputs(&self, step: u32) -> impl Iterator<Item = &RunInput> {
        let from = self.inputs.partition_point(|i| i.0 < step);
        self.inputs.range(from..).take_while(move |i| i.0 == step).map(|i| &i.1)
    }

    /// The last keyframe from which a step can be reached by taking at least one.
    pub fn keyframe_before(&self, step: u32) -> &CrowdKeyframe {
        let after = self.keyframes.partition_point(|k| k.around.step <= step);
        &self.keyframes[after.saturating_sub(1)]
    }

    /// Keeps a keyframe where one is due. Call it before the inputs of the step take effect: going back to the
    /// keyframe repeats them.
    pub fn keep_keyframe(&mut self, s: &CrowdSimulation) {
        let step = s.around.step;
        let is_new = self.keyframes.back().is_none_or(|k| k.around.step < step);
        if step.is_multiple_of(KEYFRAME_EVERY) && is_new {
            self.keyframes.push_back(s.keyframe());
        }
    }

    /// Keeps the figures of a new step, and drops steps older than a minute.
    pub fn keep_figures(&mut self, s: &CrowdSimulation, figures: StepFigures) {
        let step = s.around.step - 1;
        if step != self.first + self.figures.len() as u32 {
            return;
        }
        self.figures.push_back(figures);
        if step.is_multiple_of(TRAIL_EVERY) {
            let places = (0..s.config.characters).map(|c| s.characters.root(c)).map(|r| Vec2::new(r.x, r.z));
            self.trails.push_back((step, places.collect()));
        }
        if self.figures.len() as u32 > RECORDED_STEPS + KEYFRAME_EVERY {
            self.drop_oldest();
        }
    }

    /// Drops everything before the second keyframe.
    fn drop_oldest(&mut self) {
        let Some(first) = self.keyframes.get(1).map(|k| k.around.step) else { return };
        self.keyframes.pop_front();
        self.figures.drain(..(first - self.first) as usize);
        while self.inputs.pop_front_if(|i| i.0 < first).is_some() {}
        while self.trails.pop_front_if(|t| t.0 < first).is_some() {}
        self.first = first;
    }

    /// Drops everything from a step on, and puts an input before it.
    pub fn branch(&mut self, step: u32, input: RunInput) {
        self.keyframes.truncate(self.keyframes.partition_point(|k| k.around.step <= step).max(1));
        self.figures.truncate(step.saturating_sub(self.first) as usize);
        self.trails.truncate(self.trails.partition_point(|t| t.0 < step));
        self.inputs.truncate(self.inputs.partition_point(|i| i.0 <= step));
        // Of many drags of one target within a step only the last one counts.
        self.inputs.pop_back_if(|last| last.0 == step && input.replaces(&last.1));
        self.inputs.push_back((step, input));
    }

    /// Figures of a step.
    pub fn figures(&self, step: u32) -> Option<StepFigures> {
        self.figures.get(step.checked_sub(self.first)? as usize).copied()
    }

    /// All steps and their figures.
    pub fn history(&self) -> impl Iterator<Item = (u32, &StepFigures)> {
        (self.first..).zip(&self.figures)
    }

    /// Places of a character between two steps.
    pub fn trail(&self, character: usize, from: u32, to: u32) -> impl Iterator<Item = Vec2> {
        let first = self.trails.partition_point(|t| t.0 < from);
        let places = self.trails.range(first..).take_while(move |t| t.0 <= to);
        places.filter_map(move |t| t.1.get(character).copied())
    }

    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        let keyframes: usize = self.keyframes.iter().map(CrowdKeyframe::num_bytes).sum();
        let trails: usize = self.trails.iter().map(|t| size_of_val(t.1.as_slice())).sum();
        keyframes + trails + self.figures.len() * size_of::<StepFigures>()
    }
}
