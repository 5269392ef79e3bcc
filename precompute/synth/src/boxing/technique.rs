//! Technique of each punch and each defence: its postures, and the turn of the striking arm.

use super::moves::{Defence, HandPunch, Punch};
use super::posture::{BoxingHandPose, BoxingPosture};
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
    match (blow.punch, blow.lead) {
        (Punch::Straight, true) => JAB,
        (Punch::Straight, false) => CROSS,
        (Punch::Hook, true) => LEAD_HOOK,
        (Punch::Hook, false) => REAR_HOOK,
        (Punch::Uppercut, true) => LEAD_UPPERCUT,
        (Punch::Uppercut, false) => REAR_UPPERCUT,
    }
}

const JAB: Technique = Technique {
    load: None,
    strike: BoxingPosture {
        hips: -0.64,
        chest: -0.86,
        pitch: 0.22,
        weight: 0.57,
        flexion: 0.52,
        heels: [0.0, 0.34],
        ..GUARD
    },
    arm: BoxingHandPose { pole: DVec3::new(0.65, -1.0, 0.1), twist: 1.15, reach: 0.5, shrug: 0.22, ..LEAD_HAND },
    extend: 0.17,
    retract: 0.27,
    stretch: 0.72,
    along: DVec3::Z,
    speed: 5.8,
    follow: 0.21,
};
const CROSS: Technique = Technique {
    strike: BoxingPosture {
        hips: 0.2,
        chest: 0.5,
        pitch: 0.25,
        list: -0.07,
        weight: 0.68,
        flexion: 0.52,
        heels: [0.0, 0.72],
        pivots: [0.0, 0.72],
        ..GUARD
    },
    arm: BoxingHandPose { pole: DVec3::new(-0.7, -1.0, 0.1), twist: 1.1, reach: 0.5, shrug: 0.22, ..REAR_HAND },
    extend: 0.18,
    retract: 0.31,
    stretch: 0.71,
    speed: 6.6,
    follow: 0.24,
    ..JAB
};
const LEAD_HOOK: Technique = Technique {
    load: Some((0.2, BoxingPosture { hips: -0.36, chest: -0.12, list: -0.07, weight: 0.6, flexion: 0.66, ..GUARD })),
    strike: BoxingPosture {
        hips: -0.95,
        chest: -1.0,
        list: 0.05,
        weight: 0.43,
        flexion: 0.54,
        heels: [0.42, 0.12],
        pivots: [-0.6, 0.0],
        ..GUARD
    },
    arm: BoxingHandPose { pole: DVec3::new(1.0, 0.12, -0.35), twist: 0.1, reach: 0.42, shrug: 0.3, ..LEAD_HAND },
    extend: 0.22,
    retract: 0.34,
    stretch: 0.72,
    along: DVec3::new(0.82, 0.04, 0.55),
    speed: 6.7,
    follow: 0.19,
};
const REAR_HOOK: Technique = Technique {
    load: Some((0.2, BoxingPosture { hips: -0.6, chest: -0.66, list: 0.06, weight: 0.42, flexion: 0.62, ..GUARD })),
    strike: BoxingPosture {
        hips: 0.28,
        chest: 0.66,
        list: -0.05,
        pitch: 0.22,
        weight: 0.66,
        flexion: 0.54,
        heels: [0.0, 0.7],
        pivots: [0.0, 0.75],
        ..GUARD
    },
    arm: BoxingHandPose { pole: DVec3::new(-1.0, 0.12, -0.35), guard: REAR_HAND.guard, ..LEAD_HOOK.arm },
    ..LEAD_HOOK
};
const LEAD_UPPERCUT: Technique = Technique {
    load: Some((0.2, BoxingPosture { hips: -0.36, chest: -0.2, list: -0.16, weight: 0.58, ..CROUCHED })),
    strike: BoxingPosture {
        hips: -0.78,
        chest: -0.74,
        pitch: 0.1,
        flexion: 0.4,
        weight: 0.5,
        heels: [0.3, 0.3],
        pivots: [-0.35, 0.0],
        ..GUARD
    },
    arm: BoxingHandPose { pole: DVec3::new(0.25, -1.0, -0.35), twist: -1.1, reach: 0.42, shrug: 0.12, ..LEAD_HAND },
    extend: 0.25,
    retract: 0.34,
    stretch: 0.56,
    along: DVec3::new(0.05, 0.86, 0.5),
    speed: 6.0,
    follow: 0.12,
};
const REAR_UPPERCUT: Technique = Technique {
    load: Some((0.2, BoxingPosture { hips: -0.6, chest: -0.64, list: 0.17, weight: 0.44, ..CROUCHED })),
    strike: BoxingPosture {
        hips: 0.14,
        chest: 0.42,
        pitch: 0.12,
        list: -0.03,
        flexion: 0.4,
        weight: 0.66,
        heels: [0.0, 0.68],
        pivots: [0.0, 0.6],
        ..GUARD
    },
    arm: BoxingHandPose { pole: DVec3::new(-0.3, -1.0, -0.35), guard: REAR_HAND.guard, ..LEAD_UPPERCUT.arm },
    ..LEAD_UPPERCUT
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
    let lean = |list: f64, hips: f64, chest: f64, weight: f64| BoxingPosture {
        list,
        hips,
        chest,
        weight,
        pitch: 0.32,
        flexion: 0.78,
        ..GUARD
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
    let [left, mut right] = BoxingHandPose::GUARD;
    right.guard = DVec3::new(0.03, -0.01, 0.3);
    right.pole = DVec3::new(-0.5, -1.0, -0.1);
    right.twist = 0.7;
    right.reach = 0.42;
    let body = BoxingPosture { chest: GUARD.chest + 0.14, weight: 0.4, pitch: 0.13, ..GUARD };
    DefenceMoment { time: 0.15, body, hands: [left, right] }
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
