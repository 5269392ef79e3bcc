//! Rounds corners: every frame becomes a mean of those around it, over as wide a window as keeps the motion free.

use super::Smoother;
use crate::linkage::{LIMB_JOINTS, LimbPose};
use glam::DQuat;

/// Number of frames to either side over which a frame becomes a mean.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundingWindow {
    reach: usize,
    /// True where the window has changed since its frame was made.
    is_new: bool,
    is_too_wide: bool,
}

impl RoundingWindow {
    const NEW: Self = Self { reach: 0, is_new: true, is_too_wide: false };

    fn narrow(&mut self, most: usize) {
        self.is_new |= most < self.reach;
        self.reach = self.reach.min(most);
    }
}

impl Smoother<'_> {
    /// Rounds the corners of `frames` within `window` frames to either side; where the result is not free, windows around that
    /// place halve until it is: without any window a frame stays as it was, so that a free path remains free.
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
        windows: &mut Vec<RoundingWindow>,
    ) {
        let last = frames.len() - 1;
        windows.clear();
        let reach = |f: usize| window.min(f / 2).min((last - f) / 2);
        windows.extend((0..=last).map(|f| RoundingWindow { reach: reach(f), ..RoundingWindow::NEW }));
        out.clear();
        out.extend_from_slice(frames);
        loop {
            for f in (0..=last).filter(|f| windows[*f].is_new) {
                out[f] = self.mean_pose(frames, f, windows[f].reach);
            }
            let mut is_free = true;
            // Where neither end has changed, no new proof is needed.
            let mut was_new = windows[0].is_new;
            for f in 0..last {
                let is_new = std::mem::replace(&mut was_new, windows[f + 1].is_new);
                windows[f].is_new = false;
                let untouched = windows[f].reach == 0 && windows[f + 1].reach == 0;
                if untouched || !(is_new || was_new) || self.is_edge_free(out, f) {
                    continue;
                }
                is_free = false;
                let (first, end) = (f.saturating_sub(windows[f].reach), f + 1 + windows[f + 1].reach);
                windows[first..=end.min(last)].iter_mut().for_each(|w| w.is_too_wide = true);
            }
            windows[last].is_new = false;
            if is_free {
                return;
            }
            for w in windows.iter_mut().filter(|w| w.is_too_wide) {
                w.narrow(w.reach / 2);
                w.is_too_wide = false;
            }
            // Windows that grow slowly from frame to frame make no new corners.
            for f in 1..=last {
                let before = windows[f - 1].reach;
                windows[f].narrow(before + 1);
                let behind = windows[last - f + 1].reach;
                windows[last - f].narrow(behind + 1);
            }
        }
    }

    /// Mean rotations of the frames around a frame, weighted less with distance.
    fn mean_pose(&self, frames: &[LimbPose], f: usize, window: usize) -> LimbPose {
        if window == 0 {
            return frames[f];
        }
        let mut sums = [DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0); LIMB_JOINTS];
        for k in f - window..=f + window {
            let weight = (window + 1 - f.abs_diff(k)) as f64;
            for (i, q) in frames[k].0.into_iter().enumerate() {
                let near = if q.dot(frames[f].0[i]) < 0.0 { -q } else { q };
                sums[i] += near * weight;
            }
        }
        LimbPose(sums.map(DQuat::normalize))
    }
}
