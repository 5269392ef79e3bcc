//! Tracks of positions and rotations, and how far from its path a value lies.

use glam::{Quat, Vec3};
use throng_base::maths;

/// A position or a rotation.
pub trait Value: Copy {
    /// Distance (m) or angle (rad).
    fn apart(self, other: Self) -> f32;
    /// On the way to another.
    fn towards(self, other: Self, ratio: f32) -> Self;
}

impl Value for Vec3 {
    fn apart(self, other: Self) -> f32 {
        self.distance(other)
    }

    fn towards(self, other: Self, ratio: f32) -> Self {
        self.lerp(other, ratio)
    }
}

impl Value for Quat {
    fn apart(self, other: Self) -> f32 {
        // Exact for small angles, where a dot product says nothing.
        let d = maths::compose(self.inverse(), other);
        2.0 * d.xyz().length().atan2(d.w.abs())
    }

    fn towards(self, other: Self, ratio: f32) -> Self {
        maths::slerp_f32(self, other, ratio)
    }
}

/// Frames on either side that a measure is held against.
const AROUND: usize = 12;
/// What leaves its path does so by this much more than is common around it.
const CONTRAST: f32 = 6.0;
/// Frames on either side that are even around a sharp move.
const CALM: usize = 6;
/// A sharp move is this much farther than any around it.
const SHARP: f32 = 3.0;
/// What jumps does so this much farther than the frames next to it.
const STEP_CONTRAST: f32 = 3.0;
/// What comes back, does so to within this share of how far it was away.
const BACK: f32 = 0.5;

/// A run of frames that is away from its path, and how far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Away {
    pub start: usize,
    pub end: usize,
    pub by: f32,
}

/// Runs of up to `max_frames` frames that are farther than `limit` from the way between the frames around them, which
/// go on as if nothing had been. They are laid onto that way.
pub fn spikes<V: Value>(track: &mut [V], max_frames: usize, limit: f32) -> Vec<Away> {
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
                    out.push(Away { start: f, end: f + width, by });
                    f += width;
                }
                None => f += 1,
            }
        }
    }
    out
}

/// Single frames that are farther than `limit` from the way between their neighbours, in a stretch where nothing else is: what
/// is around goes on evenly, as no body does next to so sharp a move. They are laid onto that way.
pub fn sharp<V: Value>(track: &mut [V], limit: f32) -> Vec<Away> {
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
            out.push(Away { start: f, end: f + 1, by });
        }
    }
    out
}

/// How far the least of `width` frames from `f` on is away from the way past them.
fn residual<V: Value>(track: &[V], f: usize, width: usize) -> f32 {
    let (a, b) = (track[f - 1], track[f + width]);
    let off = |k: usize| track[f + k].apart(a.towards(b, (k + 1) as f32 / (width + 1) as f32));
    (0..width).map(off).fold(f32::INFINITY, f32::min)
}

fn spike<V: Value>(track: &[V], f: usize, width: usize, limit: f32) -> Option<f32> {
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
    (by > CONTRAST * common(f, width, n, |k| residual(track, k, width))).then_some(by)
}

/// The median of a measure around frames that do not touch those looked at.
fn common(f: usize, width: usize, n: usize, of: impl Fn(usize) -> f32) -> f32 {
    let (low, high) = (f.saturating_sub(AROUND + width).max(1), (f + AROUND + width).min(n.saturating_sub(width + 1)));
    let mut all: Vec<f32> =
        (low..high).filter(|&k| k + width < f || k > f + width).map(of).filter(|v| v.is_finite()).collect();
    all.sort_by(f32::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

/// Frames that are farther than `limit` from the one before, which the frames next to them do not lead to.
pub fn steps<V: Value>(track: &[V], limit: f32) -> Vec<Away> {
    let n = track.len();
    let step = |k: usize| if k == 0 || k >= n { 0.0 } else { track[k].apart(track[k - 1]) };
    let leap = |f: usize| {
        let by = step(f);
        let pace = step(f - 1).max(step(f + 1));
        (by > limit && by > STEP_CONTRAST * pace).then_some(Away { start: f, end: f, by })
    };
    (1..n).filter_map(leap).collect()
}
