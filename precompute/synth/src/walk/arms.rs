//! Arms: hanging at the sides, swinging against the legs, with more flexion in faster walks.

use super::trunk::Drift;
use crate::signal::{shifted, smooth};
use crate::{attitude::Trunk, frame::ArmPose, side::LateralSide};
use glam::DQuat;
use std::f64::consts::FRAC_PI_2;

/// Inputs of the arms' motion.
pub struct ArmInput<'a> {
    /// Distance of the left ankle in front of the right one (m).
    pub apart: &'a [f64],
    /// Speed (m/s).
    pub speed: &'a [f64],
    /// Trunk that carries the arms.
    pub trunk: &'a [Trunk],
    /// Breathing and slow changes of posture.
    pub drift: &'a Drift,
    /// Factor on swing and flexion, 1 on average, left and right.
    pub liveliness: [f64; 2],
    /// Time between samples (s).
    pub dt: f64,
}

/// Poses of both arms at every sample, left and right.
pub fn swing(input: &ArmInput) -> Vec<[ArmPose; 2]> {
    let frames = |seconds: f64| (seconds / input.dt).round() as usize;
    let follow = smooth(&shifted(input.apart, -0.05, input.dt), frames(0.05));
    let trail = smooth(&shifted(input.apart, -0.11, input.dt), frames(0.06));
    (0..input.speed.len()).map(|i| LateralSide::BOTH.map(|side| arm(input, side, i, follow[i], trail[i]))).collect()
}

fn arm(input: &ArmInput, side: LateralSide, i: usize, follow: f64, trail: f64) -> ArmPose {
    let (s, speed) = (side.sign(), input.speed[i]);
    let lively = input.liveliness[side.index()];
    let vigour = lively * 0.6 * (speed / 1.3).max(0.0).powf(0.45).min(1.3);
    // Forward (positive) while the other foot is in front.
    let drift = input.drift.arms[side.index()][i];
    let swing = -s * follow * vigour + drift;
    let bend = -s * trail * vigour + 1.5 * drift;
    let raise = 0.015 * input.drift.breath[i];
    // The elbow bends as the arm comes forward and hardly stretches as it goes back.
    let flexion = lively * (0.23 + 0.1 * speed) + 0.95 * soft_floor(bend, -0.1);
    ArmAngles {
        swing: swing + 0.02 + 0.75 * input.trunk[i][2].pitch * 0.6,
        abduction: 0.21 + 0.03 * speed,
        turn_in: 0.30 + 0.15 * swing,
        flexion,
        protraction: 0.16 * swing,
        shrug: raise - 0.05,
        wrist: 0.05 + 0.15 * bend,
    }
    .pose(side)
}

/// Angles of an arm, equal for both sides: at zero it hangs straight down beside an upright chest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ArmAngles {
    /// Forward swing of the upper arm (rad).
    pub swing: f64,
    /// Abduction of the upper arm (rad).
    pub abduction: f64,
    /// Turn of the upper arm about its own axis, which brings the forearm in (rad).
    pub turn_in: f64,
    /// Flexion of the elbow (rad, >= 0).
    pub flexion: f64,
    /// Forward turn of the shoulder (rad).
    pub protraction: f64,
    /// Upward turn of the shoulder (rad).
    pub shrug: f64,
    /// Flexion of the hand towards its palm (rad).
    pub wrist: f64,
}

impl ArmAngles {
    /// Joint rotations of that arm.
    pub fn pose(&self, side: LateralSide) -> ArmPose {
        let s = side.sign();
        let hang = DQuat::from_rotation_x(-self.swing)
            * DQuat::from_rotation_z(-s * (FRAC_PI_2 - self.abduction))
            * DQuat::from_rotation_x(self.turn_in);
        ArmPose {
            clavicle: DQuat::from_rotation_y(-s * self.protraction) * DQuat::from_rotation_z(s * self.shrug),
            upper_arm: hang,
            forearm: DQuat::from_rotation_y(-s * self.flexion) * DQuat::from_rotation_x(0.15),
            hand: DQuat::from_rotation_z(-s * 0.12) * DQuat::from_rotation_y(-s * self.wrist),
        }
    }
}

/// Smooth maximum of `x` and `floor`.
fn soft_floor(x: f64, floor: f64) -> f64 {
    const ROUNDING: f64 = 0.06;
    0.5 * (x + floor + (x - floor).hypot(ROUNDING))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Hands as seen from the shoulders, left and right, for a foot distance and a speed.
    fn hands(apart: f64, speed: f64) -> [DVec3; 2] {
        let n = 60;
        let still = vec![0.0; n];
        let drift = Drift {
            gaze: still.clone(),
            nod: still.clone(),
            arms: [still.clone(), still.clone()],
            breath: still.clone(),
        };
        let (apart, speed) = (vec![apart; n], vec![speed; n]);
        let arms = swing(&ArmInput {
            apart: &apart,
            speed: &speed,
            trunk: &[Trunk::default(); 60],
            drift: &drift,
            liveliness: [1.0; 2],
            dt: 1.0 / 120.0,
        });
        LateralSide::BOTH.map(|side| {
            let arm = &arms[n / 2][side.index()];
            let along = DVec3::X * side.sign();
            let upper = arm.clavicle * arm.upper_arm;
            upper * (along * 0.29 + arm.forearm * (along * 0.255))
        })
    }

    #[test]
    fn idle_arms_hang_beside_the_body_alike() {
        let [left, right] = hands(0.0, 0.0);
        assert!((left * DVec3::new(-1.0, 1.0, 1.0) - right).length() < 1e-9);
        assert!(left.y < -0.5 && left.x > 0.0 && left.x < 0.15 && (0.0..0.2).contains(&left.z), "{left}");
    }

    #[test]
    fn arms_swing_against_the_legs() {
        let [left, right] = hands(0.6, 1.3);
        assert!(left.z < -0.05 && right.z > 0.2, "{left} {right}");
    }
}
