//! Technique of each punch and each defence: its postures, and the turn of the striking arm.

use super::{BoxingHandPose, BoxingPosture, Defence, HandPunch};
use glam::DVec3;

const GUARD: BoxingPosture = BoxingPosture::GUARD;
/// Posture in which the body gathers for an uppercut.
const CROUCHED: BoxingPosture = BoxingPosture { pitch: 0.27, flexion: 0.86, ..GUARD };
const LEAD_HAND: BoxingHandPose = BoxingHandPose::GUARD[0];
const REAR_HAND: BoxingHandPose = BoxingHandPose::GUARD[1];

/// Technique of a blow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Technique {
    /// Time before the hit and posture in which the body gathers; straights have none (s).
    pub load: Option<(f64, BoxingPosture)>,
    /// Posture of the body with the arm at its longest.
    pub strike: BoxingPosture,
    /// Pose of the striking arm at the hit.
    pub arm: BoxingHandPose,
    /// Time from the guard to the hit (s).
    pub extend: f64,
    /// Time from the arm at its longest back to the guard (s).
    pub retract: f64,
    /// Distance from shoulder to wrist at the hit, as a share of the arm's length.
    pub stretch: f64,
    /// Direction of the wrist at the hit: to the other side of the body, up, and away from the shoulder (share of the
    /// speed).
    pub along: DVec3,
    /// Mean speed of the wrist at the hit (m/s).
    pub speed: f64,
    /// Distance of follow-through: straight on to the arm's full length, or around the shoulder (m).
    pub follow: f64,
}

impl Technique {
    /// Time from the hit to the arm at its longest, by about an even deceleration (s).
    pub fn braking(&self, speed: f64) -> f64 {
        2.2 * self.follow / speed
    }
}

/// The technique of a blow.
pub fn technique_of(blow: HandPunch) -> Technique {
    let [lead, rear] = [[JAB, LEAD_HOOK, LEAD_UPPERCUT], [CROSS, REAR_HOOK, REAR_UPPERCUT]];
    (if blow.lead { lead } else { rear })[blow.punch as usize]
}

/// Posture of a blow: hips, chest, pitch, list, flexion and weight; heels and pivots, left and right.
const fn posture(
    [hips, chest, pitch, list, flexion, weight]: [f64; 6],
    heels: [f64; 2],
    pivots: [f64; 2],
) -> BoxingPosture {
    BoxingPosture { hips, chest, pitch, list, flexion, weight, heels, pivots, ..GUARD }
}

/// Arm of a blow: its elbow's direction; twist, reach and shrug.
const fn arm(hand: BoxingHandPose, pole: [f64; 3], [twist, reach, shrug]: [f64; 3]) -> BoxingHandPose {
    BoxingHandPose { pole: DVec3::from_array(pole), twist, reach, shrug, ..hand }
}

/// A technique without load. The numbers are extend, retract, stretch, speed and follow.
const fn technique(
    strike: BoxingPosture,
    arm: BoxingHandPose,
    along: DVec3,
    [extend, retract, stretch, speed, follow]: [f64; 5],
) -> Technique {
    Technique { load: None, strike, arm, extend, retract, stretch, along, speed, follow }
}

const JAB: Technique = technique(
    posture([-0.64, -0.86, 0.22, 0.0, 0.52, 0.57], [0.0, 0.34], [0.0; 2]),
    arm(LEAD_HAND, [0.65, -1.0, 0.1], [1.15, 0.5, 0.22]),
    DVec3::Z,
    [0.17, 0.27, 0.72, 5.8, 0.21],
);
const CROSS: Technique = technique(
    posture([0.2, 0.5, 0.25, -0.07, 0.52, 0.68], [0.0, 0.72], [0.0, 0.72]),
    arm(REAR_HAND, [-0.7, -1.0, 0.1], [1.1, 0.5, 0.22]),
    DVec3::Z,
    [0.18, 0.31, 0.71, 6.6, 0.24],
);
const HOOK: [f64; 5] = [0.22, 0.34, 0.72, 6.7, 0.19];
const ACROSS: DVec3 = DVec3::new(0.82, 0.04, 0.55);
const LEAD_HOOK: Technique = Technique {
    load: Some((0.2, BoxingPosture { hips: -0.36, chest: -0.12, list: -0.07, weight: 0.6, flexion: 0.66, ..GUARD })),
    ..technique(
        posture([-0.95, -1.0, 0.17, 0.05, 0.54, 0.43], [0.42, 0.12], [-0.6, 0.0]),
        arm(LEAD_HAND, [1.0, 0.12, -0.35], [0.1, 0.42, 0.3]),
        ACROSS,
        HOOK,
    )
};
const REAR_HOOK: Technique = Technique {
    load: Some((0.2, BoxingPosture { hips: -0.6, chest: -0.66, list: 0.06, weight: 0.42, flexion: 0.62, ..GUARD })),
    ..technique(
        posture([0.28, 0.66, 0.22, -0.05, 0.54, 0.66], [0.0, 0.7], [0.0, 0.75]),
        arm(REAR_HAND, [-1.0, 0.12, -0.35], [0.1, 0.42, 0.3]),
        ACROSS,
        HOOK,
    )
};
const UPPERCUT: [f64; 5] = [0.25, 0.34, 0.56, 6.0, 0.12];
const UPWARDS: DVec3 = DVec3::new(0.05, 0.86, 0.5);
const LEAD_UPPERCUT: Technique = Technique {
    load: Some((0.2, BoxingPosture { hips: -0.36, chest: -0.2, list: -0.16, weight: 0.58, ..CROUCHED })),
    ..technique(
        posture([-0.78, -0.74, 0.1, 0.0, 0.4, 0.5], [0.3, 0.3], [-0.35, 0.0]),
        arm(LEAD_HAND, [0.25, -1.0, -0.35], [-1.1, 0.42, 0.12]),
        UPWARDS,
        UPPERCUT,
    )
};
const REAR_UPPERCUT: Technique = Technique {
    load: Some((0.2, BoxingPosture { hips: -0.6, chest: -0.64, list: 0.17, weight: 0.44, ..CROUCHED })),
    ..technique(
        posture([0.14, 0.42, 0.12, -0.03, 0.4, 0.66], [0.0, 0.68], [0.0, 0.6]),
        arm(REAR_HAND, [-0.3, -1.0, -0.35], [-1.1, 0.42, 0.12]),
        UPWARDS,
        UPPERCUT,
    )
};

/// One moment of a defence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefenceMoment {
    /// Time since the defence began (s).
    pub time: f64,
    /// Posture of the body.
    pub body: BoxingPosture,
    /// Poses of both hands.
    pub hands: [BoxingHandPose; 2],
}

/// Moments of a defence. The last one is held for a moment before the guard comes back.
pub fn defend(defence: Defence) -> Vec<DefenceMoment> {
    let on_guard = |time: f64, body: BoxingPosture| DefenceMoment { time, body, hands: BoxingHandPose::GUARD };
    let lean = |list: f64, hips: f64, chest: f64, weight: f64| {
        posture([hips, chest, 0.32, list, 0.78, weight], GUARD.heels, GUARD.pivots)
    };
    let back = BoxingPosture { pitch: -0.16, weight: 0.22, shift: [0.0, -0.05], flexion: 0.62, ..GUARD };
    let low = BoxingPosture { flexion: 1.55, pitch: 0.52, chin: 0.05, heels: [0.0, 0.5], ..GUARD };
    match defence {
        Defence::SlipLeft => vec![on_guard(0.2, lean(-0.43, -0.34, -0.1, 0.63))],
        Defence::SlipRight => vec![on_guard(0.2, lean(0.43, -0.66, -0.8, 0.35))],
        Defence::Duck => vec![on_guard(0.27, low)],
        Defence::RollLeft => vec![
            on_guard(0.16, BoxingPosture { flexion: 0.95, ..lean(0.2, -0.6, -0.6, 0.38) }),
            on_guard(0.33, low),
            on_guard(0.52, BoxingPosture { flexion: 0.85, ..lean(-0.38, -0.34, -0.15, 0.62) }),
        ],
        Defence::RollRight => vec![
            on_guard(0.16, BoxingPosture { flexion: 0.95, ..lean(-0.2, -0.36, -0.25, 0.6) }),
            on_guard(0.33, low),
            on_guard(0.52, BoxingPosture { flexion: 0.85, ..lean(0.38, -0.64, -0.75, 0.36) }),
        ],
        Defence::PullBack => vec![on_guard(0.22, back)],
        Defence::Block => vec![cover(0.0)],
        Defence::CoverLeft => vec![cover(1.0)],
        Defence::CoverRight => vec![cover(-1.0)],
        Defence::Parry => vec![parry()],
    }
}

/// Cover behind both gloves; `side` is 1 if the left arm takes the blow, -1 for the right one, 0 for both.
fn cover(side: f64) -> DefenceMoment {
    let [mut left, mut right] = BoxingHandPose::GUARD;
    let (at_left, at_right) = (side.max(0.0), (-side).max(0.0));
    let front = 1.0 - side.abs();
    left.guard = DVec3::new(0.055 + 0.065 * at_left, 0.07 + 0.06 * at_left, 0.19 - 0.12 * at_left);
    right.guard = DVec3::new(-0.05 - 0.065 * at_right, 0.07 + 0.06 * at_right, 0.165 - 0.1 * at_right);
    left.pole = DVec3::new(0.18 + 0.3 * at_left, -1.0 + 0.4 * at_left, 0.3 + 0.5 * at_left);
    right.pole = DVec3::new(-0.18 - 0.3 * at_right, -1.0 + 0.4 * at_right, 0.3 + 0.5 * at_right);
    for hand in [&mut left, &mut right] {
        hand.twist = -0.25;
        hand.shrug = 0.26;
    }
    let body = BoxingPosture {
        pitch: 0.24 + 0.08 * front,
        list: 0.1 * side,
        chest: GUARD.chest + 0.22 * side,
        hips: GUARD.hips + 0.12 * side,
        flexion: 0.68,
        chin: 0.3,
        ..GUARD
    };
    DefenceMoment { time: 0.17, body, hands: [left, right] }
}

fn parry() -> DefenceMoment {
    let right = arm(REAR_HAND, [-0.5, -1.0, -0.1], [0.7, 0.42, REAR_HAND.shrug]);
    let right = BoxingHandPose { guard: DVec3::new(0.03, -0.01, 0.3), ..right };
    let body = BoxingPosture { chest: GUARD.chest + 0.14, weight: 0.4, pitch: 0.13, ..GUARD };
    DefenceMoment { time: 0.15, body, hands: [LEAD_HAND, right] }
}

#[cfg(test)]
mod tests {
    use super::super::moves::COMBINATIONS;
    use super::*;

    #[test]
    fn a_rear_blow_turns_the_hips_forward_and_lifts_the_heel() {
        for blow in COMBINATIONS.iter().flat_map(|c| c.iter()).filter(|b| !b.lead) {
            let strike = technique_of(*blow).strike;
            assert!(strike.hips > GUARD.hips + 0.5 && strike.chest > GUARD.chest + 0.7);
            assert!(strike.heels[1] > 0.5 && strike.pivots[1] > 0.5 && strike.weight > GUARD.weight);
        }
    }

    #[test]
    fn defences_take_the_head_off_the_line() {
        for defence in Defence::ALL {
            let moments = defend(defence);
            assert!(moments.windows(2).all(|m| m[0].time < m[1].time));
            let moved = |m: &DefenceMoment| {
                let b = m.body;
                (b.list.abs() + (b.pitch - GUARD.pitch).abs() + 0.3 * (b.flexion - GUARD.flexion).abs()) > 0.1
            };
            assert!(moments.iter().any(moved) || defence == Defence::Parry, "{defence:?}");
        }
    }
}
