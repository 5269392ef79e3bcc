//! Rounds corners: every frame becomes a mean of those around it, over as wide a window as keeps the motion free.

use super::Smoother;
use crate::linkage::{LimbPose, MAX_JOINTS};
use glam::DQuat;

impl Smoother<'_> {
    /// Rounds the corners of `frames` within `window` frames to either side; where the outcome is not free, windows around
    /// that place halve until it is: without any window a frame stays as it was, and what was free remains so.
    ///
    /// A mean over a window turns a jump of velocity into an acceleration of at most that jump over half the window.
    ///
    /// - `out`: becomes the rounded frames.
    /// - `windows`: scratch.
    pub fn round_corners(
        &mut self,
        frames: &[LimbPose],
        window: usize,
        out: &mut Vec<LimbPose>,
        windows: &mut Vec<usize>,
    ) {
        let last = frames.len() - 1;
        windows.clear();
        windows.extend((0..=last).map(|f| window.min(f / 2).min((last - f) / 2)));
        loop {
            out.clear();
            out.extend((0..=last).map(|f| self.mean(frames, f, windows[f])));
            let mut is_free = true;
            for f in 0..last {
                let untouched = windows[f] == 0 && windows[f + 1] == 0;
                if untouched || self.is_edge_free(out, f) {
                    continue;
                }
                is_free = false;
                for k in f.saturating_sub(windows[f])..=(f + 1 + windows[f + 1]).min(last) {
                    windows[k] /= 2;
                }
            }
            if is_free {
                return;
            }
            // Windows that grow slowly from frame to frame make no corners of their own.
            for f in 1..=last {
                windows[f] = windows[f].min(windows[f - 1] + 1);
                windows[last - f] = windows[last - f].min(windows[last - f + 1] + 1);
            }
        }
    }

    /// Mean rotations of the frames around one, those farther away counting less.
    fn mean(&self, frames: &[LimbPose], f: usize, window: usize) -> LimbPose {
        let mut pose = frames[f];
        if window == 0 {
            return pose;
        }
        let mut sums = [DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0); MAX_JOINTS];
        for k in f - window..=f + window {
            let weight = (window + 1 - f.abs_diff(k)) as f64;
            for i in 0..self.problem.chain.len() {
                let q = frames[k].0[i];
                let near = if q.dot(frames[f].0[i]) < 0.0 { -q } else { q };
                sums[i] += near * weight;
            }
        }
        for i in 0..self.problem.chain.len() {
            pose.0[i] = sums[i].normalize();
        }
        pose
    }
}
