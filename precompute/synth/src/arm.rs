//! Analytic arm IK: upper arm and forearm that bring a wrist to a position, with the elbow towards a pole.

use super::{leg::two_bone_angles, side::LateralSide};
use glam::{DMat3, DQuat, DVec3};

/// Result of arm IK: rotation of the upper arm, and flexion of the elbow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmReach {
    /// World rotation of the upper arm.
    pub upper_arm: DQuat,
    /// Flexion of the elbow, never negative (rad).
    pub elbow: f64,
}

/// Lengths of upper arm and forearm (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmShape {
    /// Distance from shoulder to elbow.
    pub upper_arm: f64,
    /// Distance from elbow to wrist.
    pub forearm: f64,
}

/// Largest and least distance of a wrist from its shoulder, as shares of the arm's length.
const STRETCHED: f64 = 0.985;
const FOLDED: f64 = 0.3;
/// Width of the rounding near either limit, so that no elbow snaps (share of the length).
const ROUNDING: f64 = 0.06;

impl ArmShape {
    /// Length of the straight arm (m).
    pub fn length(&self) -> f64 {
        self.upper_arm + self.forearm
    }

    /// Bends the arm so that it reaches from `shoulder` to `wrist`, the elbow towards `pole`.
    ///
    /// A wrist out of reach, or inside the shoulder, is approached as far as the elbow allows.
    ///
    /// - `pole`: direction, not along the arm.
    pub fn solve(&self, side: LateralSide, shoulder: DVec3, wrist: DVec3, pole: DVec3) -> ArmReach {
        let to_wrist = wrist - shoulder;
        let length = soft_clamp(to_wrist.length() / self.length()) * self.length();
        let [at_shoulder, elbow] = two_bone_angles([self.upper_arm, self.forearm], length);
        let along = to_wrist.normalize_or(DVec3::Z);
        let aside = (pole - along * pole.dot(along)).normalize_or(along.any_orthonormal_vector());
        let (sin, cos) = at_shoulder.sin_cos();
        let x = (along * cos + aside * sin) * side.sign();
        let z = along * sin - aside * cos;
        ArmReach { upper_arm: DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)), elbow }
    }

    /// Rotation of the forearm relative to the upper arm.
    ///
    /// - `twist`: about its own axis, palm down (pronation) positive (rad).
    pub fn forearm(side: LateralSide, elbow: f64, twist: f64) -> DQuat {
        DQuat::from_rotation_y(-side.sign() * elbow) * DQuat::from_rotation_x(twist)
    }
}

/// Clamps a distance smoothly to the limits of the arm.
fn soft_clamp(distance: f64) -> f64 {
    let rounded = |over: f64| if over > -ROUNDING { 0.25 * (over + ROUNDING).powi(2) / ROUNDING } else { 0.0 };
    let soft = |over: f64| if over > ROUNDING { over } else { rounded(over) };
    distance - soft(distance - STRETCHED) + soft(FOLDED - distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ARM: ArmShape = ArmShape { upper_arm: 0.29, forearm: 0.255 };

    fn wrist_of(side: LateralSide, shoulder: DVec3, reach: &ArmReach) -> (DVec3, DVec3) {
        let along = DVec3::X * side.sign();
        let elbow = shoulder + reach.upper_arm * along * ARM.upper_arm;
        let forearm = reach.upper_arm * ArmShape::forearm(side, reach.elbow, 0.7);
        (elbow, elbow + forearm * along * ARM.forearm)
    }

    proptest! {
        #[test]
        fn reaches_the_wrist_with_the_elbow_at_the_pole(
            direction in prop::array::uniform3(-1.0f64..1.0), share in 0.37f64..0.92,
            pole in prop::array::uniform3(-1.0f64..1.0), left in any::<bool>(),
        ) {
            let (direction, pole) = (DVec3::from(direction), DVec3::from(pole));
            prop_assume!(direction.length() > 0.1 && direction.normalize().cross(pole).length() > 0.1);
            let side = if left { LateralSide::Left } else { LateralSide::Right };
            let shoulder = DVec3::new(0.1, 1.4, -0.2);
            let wrist = shoulder + direction.normalize() * share * ARM.length();
            let reach = ARM.solve(side, shoulder, wrist, pole);
            let (elbow, reached) = wrist_of(side, shoulder, &reach);
            prop_assert!((reached - wrist).length() < 1e-9, "{reached} {wrist}");
            prop_assert!((elbow - shoulder).dot(pole - direction * pole.dot(direction) / direction.length_squared()) > 0.0);
            prop_assert!(reach.elbow > 0.0 && reach.elbow < 2.7);
        }

        #[test]
        fn the_elbow_neither_locks_nor_snaps(share in 0.05f64..1.6) {
            let elbow = |share: f64| ARM.solve(LateralSide::Left, DVec3::ZERO, DVec3::Z * share * ARM.length(), DVec3::NEG_Y).elbow;
            prop_assert!((0.3..2.56).contains(&elbow(share)), "{}", elbow(share));
            prop_assert!((elbow(share) - elbow(share + 1e-3)).abs() < 0.012);
        }
    }
}
