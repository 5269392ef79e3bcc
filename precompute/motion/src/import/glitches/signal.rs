//! Tracks of positions and rotations, and the distance of a value from its path.

use glam::{Quat, Vec3};
use throng_base::{maths, maths::quantile};

/// A position or a rotation.
pub trait TrackValue: Copy {
    /// Distance (m) or angle (rad).
    fn apart(self, other: Self) -> f32;
    /// Interpolation towards another value.
    fn towards(self, other: Self, ratio: f32) -> Self;
}

impl TrackValue for Vec3 {
    fn apart(self, other: Self) -> f32 {
        self.distance(other)
    }

    fn towards(self, other: Self, ratio: f32) -> Self {
        self.lerp(other, ratio)
    }
}

impl TrackValue for Quat {
    fn apart(self, other: Self) -> f32 {
        // Exact for small angles, where a dot product is not.
        let d = maths::compose(self.inverse(), other);
        2.0 * d.xyz().length().atan2(d.w.abs())
    }

    fn towards(self, other: Self, ratio: f32) -> Self {
        maths::slerp_f32(self, other, ratio)
    }
}

/// Number of frames on either side with which a measure is compared.
const AROUND: usize = 12;
/// Factor above the common distance around it at which a value leaves its path.
const CONTRAST: f32 = 6.0;
/// Number of frames on either side of a sharp move that are even.
const CALM: usize = 6;
/// Factor of a sharp move above any move around it.
const SHARP: f32 = 3.0;
/// Factor of a jump above the moves of the frames next to it.
const STEP_CONTRAST: f32 = 3.0;
/// Share of its departure within which a value counts as back.
const BACK: f32 = 0.5;

/// A run of frames that is away from its path, and its distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    pub start: usize,
    pub end: usize,
    pub distance: f32,
}

/// Finds runs of up to `max_frames` frames that are farther than `limit` from the interpolation between the frames around them,
/// which go on as if nothing had been, and replaces them by that interpolation.
pub fn spikes<V: TrackValue>(track: &mut [V], max_frames: usize, limit: f32) -> Vec<Deviation> {
    let mut out = Vec::new();
    for width in 1..=max_frames {
        let Some(last) = track.len().checked_sub(width + 1) else { break };
        let mut f = 1;
        while f < last.max(1) {
            match spike(track, f, width, limit) {
                Some(by) => {
                    let (a, b) = (track[f - 1], track[f + width]);
                    for k in 0..width {
                        track[f + k] = a.towards(b, (k + 1) as f32 / (width + 1) as f32);
                    }
                    out.push(Deviation { start: f, end: f + width, distance: by });
                    f += width;
                }
                None => f += 1,
            }
        }
    }
    out
}

/// Finds single frames that are farther than `limit` from the mean of their neighbours, in a stretch where no other is: the
/// frames around go on evenly, as no body does next to so sharp a move. Replaces them by that mean.
pub fn sharp_moves<V: TrackValue>(track: &mut [V], limit: f32) -> Vec<Deviation> {
    let n = track.len();
    let mut out = Vec::new();
    for f in 1..n.saturating_sub(1) {
        let by = residual(track, f, 1);
        if by.is_nan() || by < limit {
            continue;
        }
        let step = |k: usize| if k == 0 || k >= n { 0.0 } else { track[k].apart(track[k - 1]) };
        let (low, high) = (f.saturating_sub(CALM).max(1), (f + CALM + 1).min(n - 1));
        let around = (low..high).filter(|&k| k + 1 < f || k > f + 1).map(|k| residual(track, k, 1)).fold(0.0, f32::max);
        let pace = (low..=high.min(n - 1)).filter(|&k| k != f && k != f + 1).map(step).fold(0.0, f32::max);
        let gap = track[f - 1].apart(track[f + 1]);
        if by > SHARP * around && by > SHARP * pace && gap < 2.0 * pace + 0.1 * by {
            track[f] = track[f - 1].towards(track[f + 1], 0.5);
            out.push(Deviation { start: f, end: f + 1, distance: by });
        }
    }
    out
}

/// Least distance of `width` frames from `f` on from the interpolation past them.
fn residual<V: TrackValue>(track: &[V], f: usize, width: usize) -> f32 {
    let (a, b) = (track[f - 1], track[f + width]);
    let off = |k: usize| track[f + k].apart(a.towards(b, (k + 1) as f32 / (width + 1) as f32));
    (0..width).map(off).fold(f32::INFINITY, f32::min)
}

fn spike<V: TrackValue>(track: &[V], f: usize, width: usize, limit: f32) -> Option<f32> {
    let by = residual(track, f, width);
    if by.is_nan() || by < limit {
        return None;
    }
    let n = track.len();
    let step = |k: usize| if k == 0 || k >= n { 0.0 } else { track[k].apart(track[k - 1]) };
    let pace = step(f - 1).max(step(f + width + 1));
    let gap = track[f - 1].apart(track[f + width]) - pace * (width + 1) as f32;
    let leaps = step(f).min(step(f + width)) > STEP_CONTRAST * pace.min(by) * 0.5;
    if gap > BACK * by || pace > 0.6 * by || !leaps {
        return None;
    }
    (by > CONTRAST * median_around(f, width, n, |k| residual(track, k, width))).then_some(by)
}

/// Median of a measure around a run of frames, without the frames that touch it.
fn median_around(f: usize, width: usize, n: usize, of: impl Fn(usize) -> f32) -> f32 {
    let (low, high) = (f.saturating_sub(AROUND + width).max(1), (f + AROUND + width).min(n.saturating_sub(width + 1)));
    let all = (low..high).filter(|&k| k + width < f || k > f + width).map(of).filter(|v| v.is_finite());
    quantile(all, [1, 2]).unwrap_or_default()
}

/// Finds frames that are farther than `limit` from the one before, without a motion of the frames next to them that leads
/// there.
pub fn steps<V: TrackValue>(track: &[V], limit: f32) -> Vec<Deviation> {
    let n = track.len();
    let step = |k: usize| if k == 0 || k >= n { 0.0 } else { track[k].apart(track[k - 1]) };
    let leap = |f: usize| {
        let by = step(f);
        let pace = step(f - 1).max(step(f + 1));
        (by > limit && by > STEP_CONTRAST * pace).then_some(Deviation { start: f, end: f, distance: by })
    };
    (1..n).filter_map(leap).collect()
}
