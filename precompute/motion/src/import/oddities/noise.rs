//! Shaking of joints from frame to frame, as unfiltered capture has it.

use crate::import::roles::RoleMap;
use crate::raw::RawClip;
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_base::maths::quantile;
use throng_core::Joint;

/// Rate at which frames are compared, so that clips of all rates compare (Hz).
const RATE_HZ: f64 = 30.0;
/// Shaking of captured motion: the median of the CMU database, the most of three studios (deg/s2).
const CAPTURED: f32 = 300.0;
/// Multiple of that from which a warning is given: no clip of the three studios reaches it.
const TIMES: f32 = 4.0;
/// Fewest accelerations of a joint that count.
const FEWEST: usize = 10;
/// Joints whose turns are measured.
const JOINTS: [Joint; 9] = {
    use Joint::*;
    [Hips, LeftThigh, RightThigh, LeftShin, RightShin, LeftUpperArm, RightUpperArm, LeftForearm, RightForearm]
};

/// A warning of a clip that shakes.
pub(super) fn find_noise(clip: &RawClip, roles: &RoleMap) -> Option<String> {
    let shaking = shaking(clip, roles).filter(|shaking| *shaking > TIMES * CAPTURED)?;
    let times = shaking / CAPTURED;
    Some(format!(
        "noisy: joints shake by {shaking:.0} deg/s2 from frame to frame, {times:.0} times what captured motion has. Smooth \
         it in the program that wrote it, or capture it again."
    ))
}

/// Shaking of joints: the acceleration that is taken back in the next frame, in the median frame of the median joint; `None`
/// for clips with few frames (deg/s2).
///
/// In smooth motion, however fast, accelerations go on from frame to frame, and it is 0; those of noise change their sign.
fn shaking(clip: &RawClip, roles: &RoleMap) -> Option<f32> {
    let stride = (clip.rate_hz / RATE_HZ).round().max(1.0) as usize;
    let rate = (clip.rate_hz / stride as f64) as f32;
    let joints: Vec<usize> = JOINTS.into_iter().filter_map(|j| roles.get(j)).collect();
    let mut tracks: Vec<Vec<Quat>> = vec![Vec::new(); joints.len()];
    for f in (0..clip.num_frames).step_by(stride) {
        for (track, &j) in tracks.iter_mut().zip(&joints) {
            track.push(clip.rotations[f * clip.joints.len() + j]);
        }
    }
    let median = |all: Vec<f32>| quantile(all, [1, 2]);
    let all = tracks.iter().map(|t| products(t)).filter(|all| all.len() >= FEWEST).filter_map(median);
    Some((-median(all.collect())?).max(0.0).sqrt().to_degrees() * rate * rate)
}

/// Each acceleration times the next one (rad a frame, squared, squared).
fn products(track: &[Quat]) -> Vec<f32> {
    let turn =
        |w: &[Quat]| maths::compose(w[0].inverse(), if w[0].dot(w[1]) < 0.0 { -w[1] } else { w[1] }).to_scaled_axis();
    let turns: Vec<Vec3> = track.windows(2).map(turn).collect();
    let accelerations: Vec<Vec3> = turns.windows(2).map(|w| w[1] - w[0]).collect();
    accelerations.windows(2).map(|w| w[0].dot(w[1])).collect()
}
