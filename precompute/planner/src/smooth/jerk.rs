//! Roughness of a motion.

use crate::linkage::{LIMB_JOINTS, LimbPose};
use crate::rotation::{angle_between, log};
use glam::DVec3;

/// Figures of a limb's motion, over all of its joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Roughness {
    /// Sum of all turns (rad).
    pub length_rad: f64,
    /// Greatest speed of a turn (rad/s).
    pub speed_max: f64,
    /// Largest angular acceleration (rad/s^2).
    pub acceleration_max: f64,
    /// Root mean square of the angular jerk (rad/s^3).
    pub jerk_rms: f64,
}

/// Measures poses that are `step_s` apart; only the first `num_joints` joints of each count.
pub fn roughness(frames: &[LimbPose], step_s: f64) -> Roughness {
    let mut out = Roughness::default();
    let (mut jerks, mut sum) = (0u32, 0.0);
    for i in 0..LIMB_JOINTS {
        let velocity = |f: usize| log(frames[f + 1].0[i] * frames[f].0[i].inverse()) / step_s;
        let acceleration = |f: usize| (velocity(f + 1) - velocity(f)) / step_s;
        for f in 0..frames.len().saturating_sub(1) {
            let turn = angle_between(frames[f].0[i], frames[f + 1].0[i]);
            out.length_rad += turn;
            out.speed_max = out.speed_max.max(turn / step_s);
        }
        let accelerations = (0..frames.len().saturating_sub(2)).map(|f| acceleration(f).length());
        out.acceleration_max = accelerations.fold(out.acceleration_max, f64::max);
        for f in 0..frames.len().saturating_sub(3) {
            let jerk: DVec3 = (acceleration(f + 1) - acceleration(f)) / step_s;
            sum += jerk.length_squared();
            jerks += 1;
        }
    }
    if jerks > 0 {
        out.jerk_rms = (sum / f64::from(jerks)).sqrt();
    }
    out
}
