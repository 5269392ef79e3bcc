//! Spine, neck and head: leaning with acceleration, turning against the pelvis, looking ahead into turns.

use super::pelvis::Pelvis;
use crate::attitude::{Attitude, Trunk, trunk_between};
use crate::side::{forward, leftward};
use crate::signal::{acceleration, shifted, smooth};
use glam::DVec2;

/// Slow wandering of attention and posture, different in every clip.
pub struct Drift {
    /// Angle of looking left and right (rad).
    pub gaze: Vec<f64>,
    /// Angle of looking up and down (rad).
    pub nod: Vec<f64>,
    /// Forward angle of the left and right hanging arm (rad).
    pub arms: [Vec<f64>; 2],
    /// Breathing, from -1 (out) to 1 (in).
    pub breath: Vec<f64>,
}

/// Poses of the trunk over the pelvis at every sample.
///
/// - `speed`: (m/s)
/// - `mass`: centre of mass on the ground (m).
pub fn balance(pelvis: &Pelvis, speed: &[f64], mass: &[DVec2], drift: &Drift, dt: f64) -> Vec<Trunk> {
    let frames = |seconds: f64| (seconds / dt).round() as usize;
    let chest_heading = shifted(&pelvis.heading, 0.12, dt);
    let gaze_heading = smooth(&shifted(&pelvis.heading, 0.38, dt), frames(0.07));
    let counter = smooth(&shifted(&pelvis.yaw, -0.03, dt), frames(0.03));
    let (surge, sideways) = lean(pelvis, mass, dt);
    let bob = bob(pelvis, frames(0.35));
    let out = (0..speed.len()).map(|i| {
        // Upstairs the trunk leans in; on all stairs the eyes are on the steps.
        let stoop = 0.4 * pelvis.climb[i].max(0.0);
        let hips = Attitude { yaw: pelvis.heading[i] + pelvis.yaw[i], pitch: pelvis.pitch[i], list: pelvis.list[i] };
        let chest = Attitude {
            yaw: chest_heading[i] - 0.5 * counter[i] + 0.15 * drift.gaze[i],
            pitch: 0.02 + 0.022 * speed[i] + surge[i] - 0.012 * drift.breath[i] + stoop,
            list: -0.45 * pelvis.list[i] + sideways[i],
        };
        let pitch = 0.06 + drift.nod[i] + 0.25 * surge[i] + bob[i] + 0.75 * pelvis.climb[i].abs();
        let head = Attitude { yaw: gaze_heading[i] + drift.gaze[i], pitch, list: 0.3 * sideways[i] };
        trunk_between(hips, chest, head)
    });
    out.collect()
}

/// Nod of the head that keeps the gaze steady: down as the body rises, up as it sinks (rad).
fn bob(pelvis: &Pelvis, radius: usize) -> Vec<f64> {
    let height: Vec<f64> = pelvis.position.iter().map(|p| p.y).collect();
    smooth(&height, radius).iter().zip(&height).map(|(slow, h)| 1.1 * (h - slow)).collect()
}

/// Forward tilt and list that lean into the body's acceleration over a step or so (rad).
fn lean(pelvis: &Pelvis, mass: &[DVec2], dt: f64) -> (Vec<f64>, Vec<f64>) {
    let radius = (0.16 / dt).round() as usize;
    let axis = |f: fn(&DVec2) -> f64| {
        let x: Vec<f64> = mass.iter().map(f).collect();
        acceleration(&smooth(&x, radius), dt)
    };
    let (ax, az) = (axis(|p| p.x), axis(|p| p.y));
    let along = |amount: f64, direction: fn(f64) -> DVec2| {
        let moved = |i: usize| amount * DVec2::new(ax[i], az[i]).dot(direction(pelvis.heading[i]));
        smooth(&(0..mass.len()).map(moved).collect::<Vec<_>>(), radius / 3)
    };
    (along(0.035, forward), along(-0.05, leftward))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A body that turns left by a right angle between 1 s and 2 s, on the spot.
    fn turning(n: usize, dt: f64) -> Vec<Trunk> {
        let still = vec![0.0; n];
        let heading = (0..n).map(|i| (i as f64 * dt - 1.0).clamp(0.0, 1.0) * 1.57).collect();
        let pelvis = Pelvis {
            heading,
            yaw: still.clone(),
            pitch: still.clone(),
            list: still.clone(),
            position: vec![DVec3::Y; n],
            apart: still.clone(),
            climb: still.clone(),
        };
        let drift = Drift {
            gaze: still.clone(),
            nod: still.clone(),
            arms: [still.clone(), still.clone()],
            breath: still.clone(),
        };
        balance(&pelvis, &still, &vec![DVec2::ZERO; n], &drift, dt)
    }

    #[test]
    fn the_head_turns_first_and_the_hips_last() {
        let at_one = &turning(360, 1.0 / 120.0)[132];
        assert!(at_one.windows(2).all(|s| s[1].yaw > s[0].yaw), "{at_one:?}");
    }

    #[test]
    fn a_body_at_rest_is_upright() {
        for s in turning(360, 1.0 / 120.0)[0] {
            assert!(s.yaw == 0.0 && s.list == 0.0 && (0.0..0.1).contains(&s.pitch));
        }
    }
}
