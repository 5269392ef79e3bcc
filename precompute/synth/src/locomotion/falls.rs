//! Footfalls along a steady path, and the phase that they define.

use super::{LocomotionAct, Stride};
use crate::{side::LateralSide, walk::roll::Footfall};
use glam::DVec2;
use rand::{Rng, RngExt};
use std::ops::Range;

/// Alternating footfalls of both feet, the left one first.
pub struct AlternatingFootfalls {
    /// Footfalls of the left and the right foot.
    pub feet: [Vec<Footfall>; 2],
    /// Landings of both feet (s).
    lands: Vec<f64>,
}

/// Variation of landings: in time as a share of the period, in place along and across (m).
const TIME_VARIES: f64 = 0.005;
const PLACE_VARIES: [f64; 2] = [0.004, 0.003];

impl AlternatingFootfalls {
    /// Generates steps that fill a time with a margin at both ends, beginning at a random phase.
    ///
    /// - `outward`: offset from the body's path, to the left and ahead (m).
    pub fn generate(act: &LocomotionAct, outward: DVec2, time: Range<f64>, variation: f64, rng: &mut impl Rng) -> Self {
        let (drive, stride) = (&act.drive, Stride::for_act(act));
        let mut out = Self { feet: [Vec::new(), Vec::new()], lands: Vec::new() };
        let first = time.start - stride.period * rng.random_range(3.0..5.0);
        let count = ((time.end - first) / stride.period).ceil() as usize + 4;
        for k in 0..count {
            let side = LateralSide::BOTH[k % 2];
            let mut vary = |amount: f64| variation * amount * rng.random_range(-1.0..1.0);
            let land = first + stride.period * (k as f64 + vary(TIME_VARIES));
            let under = land + 0.5 * stride.stance;
            let left = 0.5 * stride.width * side.sign() + outward.x + vary(PLACE_VARIES[1]);
            let ahead = stride.ahead + outward.y + vary(PLACE_VARIES[0]);
            let lift = land + stride.stance;
            let flat = land + stride.landing;
            out.lands.push(land);
            out.feet[side.index()].push(Footfall {
                land,
                flat,
                heel_off: (lift - stride.rise).max(flat + 0.02),
                lift,
                ankle: drive.point_at(under, left, ahead),
                ground: 0.0,
                heading: drive.heading_at(under),
                yaw: drive.heading_at(under) + stride.toe_out * side.sign(),
                strike: stride.strike,
                push: stride.push,
            });
        }
        out
    }

    /// Phase of the cycle at `t`, in `[0, 1)`: 0 as the left foot lands, 0.5 as the right one does.
    pub fn phase_at(&self, t: f64) -> f64 {
        (0.5 * self.step_at(t)).fract()
    }

    /// Number of steps since the first landing, including the fraction of the present one.
    pub fn step_at(&self, t: f64) -> f64 {
        let k = self.lands.partition_point(|l| *l <= t).clamp(1, self.lands.len() - 1) - 1;
        k as f64 + (t - self.lands[k]) / (self.lands[k + 1] - self.lands[k])
    }

    /// Share of the left foot as `(time, share)` knots, for gaits in which the feet carry in turn: 1 while the right
    /// foot is in the air, 0 while the left one is, and linear in between.
    pub fn left_foot_load(&self) -> Vec<(f64, f64)> {
        let mut knots = Vec::new();
        for side in LateralSide::BOTH {
            let carried = if side == LateralSide::Left { 0.0 } else { 1.0 };
            self.feet[side.index()].windows(2).for_each(|w| knots.extend([(w[0].lift, carried), (w[1].land, carried)]));
        }
        knots.sort_by(|a: &(f64, f64), b| a.0.total_cmp(&b.0));
        knots
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::signal::interpolate;
    use super::super::motion_set::GaitKind;
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    fn falls(gait: GaitKind, variation: f64) -> (AlternatingFootfalls, Stride) {
        let act = LocomotionAct::all().into_iter().find(|a| a.gait == gait).unwrap();
        let stride = Stride::for_act(&act);
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        (AlternatingFootfalls::generate(&act, DVec2::ZERO, -1.0..6.0, variation, &mut rng), stride)
    }

    #[test]
    fn the_phase_is_that_of_the_landings() {
        let (falls, _) = falls(GaitKind::Run, 1.0);
        for (foot, phase) in falls.feet.iter().zip([0.0, 0.5]) {
            for fall in foot.iter().filter(|f| (-1.0..6.0).contains(&f.land)) {
                assert!((falls.phase_at(fall.land + 1e-9) - phase).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_foot_in_the_air_carries_nothing() {
        let (falls, _) = falls(GaitKind::Walk, 1.0);
        let load = falls.left_foot_load();
        for (foot, empty) in falls.feet.iter().zip([0.0, 1.0]) {
            for w in foot.windows(2) {
                assert_eq!(interpolate(&load, 0.5 * (w[0].lift + w[1].land)), empty);
            }
        }
    }

    #[test]
    fn steps_without_variation_go_with_the_body() {
        let (falls, stride) = falls(GaitKind::Walk, 0.0);
        for w in falls.feet[0].windows(2) {
            let travelled = (w[1].ankle - w[0].ankle).length();
            assert!((travelled - 2.0 * 0.7 * stride.period).abs() < 1e-9, "{travelled}");
        }
    }
}
