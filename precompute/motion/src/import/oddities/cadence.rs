//! Detection of steps faster than anybody takes them, as in a file whose rate is not that of the capture.

use crate::import::roles::RoleMap;
use crate::raw::RawClip;
use glam::Vec2;
use throng_base::maths::quantile;
use throng_base::thresholds::WALKING_MPS;
use throng_core::Joint;

/// Time over which the velocity of the hips is measured (s).
const WAY_S: f64 = 0.4;
/// Distance by which a foot is ahead of the other one (m).
const AHEAD_M: f32 = 0.08;
/// Least number of times from a step to the next that are conclusive.
const INTERVALS: usize = 2;
/// More steps a second than sprinters take (Hz).
const MOST_HZ: f64 = 5.5;

/// A warning of steps that are too fast: one foot gets ahead of the other along the path of the hips, by turns.
pub(super) fn find_fast_steps(clip: &RawClip, roles: &RoleMap) -> Option<String> {
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
             {rate_hz:.0} frames a second that it is read with? `import.rate_hz` in a config sets another rate."
        )
    })
}
