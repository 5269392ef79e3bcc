//! Times that landmarks may have: the frames of the result, so that what is proved between landmarks holds between frames.

/// Evenly spaced times from the start to the goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimeGrid {
    pub start_s: f64,
    pub goal_s: f64,
    /// Number of intervals (> 0).
    pub steps: usize,
}

impl TimeGrid {
    /// A grid of at least `rate_hz` times a second; exactly so where the goal is whole frames away.
    pub fn new(start_s: f64, goal_s: f64, rate_hz: f64) -> Self {
        let frames = (goal_s - start_s) * rate_hz;
        // A goal that is on a frame but for rounding counts as on it.
        let steps = if (frames - frames.round()).abs() < 1e-6 { frames.round() } else { frames.ceil() };
        Self { start_s, goal_s, steps: (steps as usize).max(1) }
    }

    /// Time between frames (s).
    pub fn step_s(&self) -> f64 {
        (self.goal_s - self.start_s) / self.steps as f64
    }

    /// Time of a frame (s).
    pub fn time_at(&self, frame: usize) -> f64 {
        if frame >= self.steps { self.goal_s } else { self.start_s + frame as f64 * self.step_s() }
    }

    /// The nearest frame to a time.
    pub fn nearest_frame(&self, time_s: f64) -> usize {
        ((time_s - self.start_s) / self.step_s()).round().clamp(0.0, self.steps as f64) as usize
    }

    /// The first frame that is not before a time, but for rounding; may lie behind the last one.
    pub fn first_frame_from(&self, time_s: f64) -> usize {
        ((time_s - self.start_s) / self.step_s() - 1e-9).ceil().max(0.0) as usize
    }

    /// The last frame that is not after a time, but for rounding; `None` before the first.
    pub fn last_frame_until(&self, time_s: f64) -> Option<usize> {
        let at = ((time_s - self.start_s) / self.step_s() + 1e-9).floor();
        (at >= 0.0).then_some((at as usize).min(self.steps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_those_of_the_clip() {
        let g = TimeGrid::new(1.0, 2.0, 30.0);
        assert_eq!(
            (g.steps, g.time_at(30), g.nearest_frame(1.5), g.first_frame_from(1.1), g.last_frame_until(1.1)),
            (30, 2.0, 15, 3, Some(3))
        );
        assert_eq!(
            (g.first_frame_from(1.11), g.last_frame_until(1.11), g.last_frame_until(0.9), g.first_frame_from(2.02)),
            (4, Some(3), None, 31)
        );
        // Not whole frames away: a little denser.
        let g = TimeGrid::new(0.0, 0.95, 10.0);
        assert_eq!((g.steps, g.time_at(10)), (10, 0.95));
        assert_eq!(TimeGrid::new(0.0, 0.001, 30.0).steps, 1);
    }
}
