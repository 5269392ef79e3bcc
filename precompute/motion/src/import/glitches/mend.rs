//! Fills frames of glitches by interpolation.

use super::Glitch;
use crate::raw::RawClip;
use throng_base::maths;

/// Replaces the faulty joints in a run of frames by the interpolation from the frame before it to the one after; at the ends of
/// the clip the nearest sound frame is held.
pub fn bridge(clip: &mut RawClip, glitch: &Glitch) {
    let (n, frames) = (clip.joints.len(), &glitch.frames);
    let joints = if glitch.joints.is_empty() { (0..n).collect() } else { glitch.joints.clone() };
    let before = frames.start.checked_sub(1);
    let after = Some(frames.end).filter(|&f| f < clip.num_frames);
    let (Some(from), Some(to)) = (before.or(after), after.or(before)) else { return };
    for f in frames.clone() {
        let ratio = (f + 1 - frames.start) as f32 / (frames.len() + 1) as f32;
        for &j in &joints {
            let (a, b, at) = (from * n + j, to * n + j, f * n + j);
            clip.translations[at] = clip.translations[a].lerp(clip.translations[b], ratio);
            let (p, q) = (clip.rotations[a], clip.rotations[b]);
            clip.rotations[at] = maths::slerp_f32(p, q, ratio);
        }
    }
}
