//! Oddities of a person's motion as a whole, which deserve a warning before anything is built of it.

mod in_place;
mod loops;

use super::roles::RoleMap;
use crate::{error::Warnings, raw::RawClip};
use glam::{Quat, Vec2, Vec3};
pub(super) use loops::unroll_loop;
use throng_base::{maths, maths::quantile, thresholds::WALKING_MPS};
use throng_core::Joint;

/// Warns of walks on the spot, of steps that are too fast, and of noise.
///
/// - `clip`: in metres, Y up, its glitches mended; a walk on the spot gets root motion.
/// - `root_motion`: false leaves it on the spot.
pub(super) fn treat_oddities(clip: &mut RawClip, roles: &RoleMap, root_motion: bool, warnings: &mut Warnings) {
    let found =
        [in_place::give_root_motion(clip, roles, root_motion), find_fast_steps(clip, roles), find_noise(clip, roles)];
    found.into_iter().flatten().for_each(|what| warnings.push(format!("{}: {what}", clip.path.display())));
}

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
fn find_noise(clip: &RawClip, roles: &RoleMap) -> Option<String> {
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
        tracks.iter_mut().zip(&joints).for_each(|(track, &j)| track.push(clip.rotations[f * clip.joints.len() + j]));
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

/// Time over which the velocity of the hips is measured (s).
const WAY_S: f64 = 0.4;
/// Distance by which a foot is ahead of the other one (m).
const AHEAD_M: f32 = 0.08;
/// Least number of times from a step to the next that are conclusive.
const INTERVALS: usize = 2;
/// More steps a second than sprinters take (Hz).
const MOST_HZ: f64 = 5.5;

/// A warning of steps that are too fast: one foot gets ahead of the other along the path of the hips, by turns.
fn find_fast_steps(clip: &RawClip, roles: &RoleMap) -> Option<String> {
    let [hips, left, right] = [Joint::Hips, Joint::LeftFoot, Joint::RightFoot].map(|j| roles.get(j));
    let (hips, left, right) = (hips?, left?, right?);
    let flat = |f: usize| {
        let world = clip.world(f);
        [hips, left, right].map(|j| Vec2::new(world[j].0.x, world[j].0.z))
    };
    let places: Vec<[Vec2; 3]> = (0..clip.num_frames).map(flat).collect();
    let half = (0.5 * WAY_S * clip.rate_hz).round().max(1.0) as usize;
    // Frames from each step to the next, and the speeds in between.
    let (mut intervals, mut speeds, mut last, mut ahead) = (Vec::new(), Vec::new(), None, 0.0);
    for f in 0..clip.num_frames {
        let (from, to) = (f.saturating_sub(half), (f + half).min(clip.num_frames - 1));
        let offset = places[to][0] - places[from][0];
        let speed = offset.length() * clip.rate_hz as f32 / (to - from).max(1) as f32;
        if speed < WALKING_MPS {
            (last, ahead) = (None, 0.0);
            continue;
        }
        let by = (places[f][1] - places[f][2]).dot(offset.normalize());
        if by.abs() < AHEAD_M {
            continue;
        }
        if by * ahead < 0.0 {
            intervals.extend(last.map(|l| f - l));
            speeds.push(speed);
            last = Some(f);
        }
        ahead = by;
    }
    if intervals.len() < INTERVALS {
        return None;
    }
    intervals.sort_unstable();
    // Medians.
    let steps_hz = clip.rate_hz / intervals[intervals.len() / 2] as f64;
    let (speed_mps, rate_hz) = (quantile(speeds, [1, 2])?, clip.rate_hz);
    (steps_hz > MOST_HZ).then(|| {
        format!(
            "takes {steps_hz:.1} steps a second, which nobody does, at {speed_mps:.1} m/s: was it captured at the \
             {rate_hz:.0} frames a second that it is read with? `--rate-hz`, or `import.rate_hz`, sets another rate."
        )
    })
}
