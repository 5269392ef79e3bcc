//! Target of a combination, and adaptation of a blow's technique to it.

use super::{BoxingPosture, HandPunch, Punch, Technique};
use rand::{Rng, RngExt};

/// Height at which a blow is meant to land.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlowLevel {
    /// Below the chest.
    Body,
    /// Chest to chin.
    Head,
    /// The head of a tall or upright opponent.
    High,
}

/// Target and manner of a combination.
#[derive(Clone, Copy, Debug)]
pub struct Attack {
    /// Direction as seen from the shoulder, left of straight ahead (rad).
    pub azimuth: f64,
    /// Lean: from close (-1) over none (0) to a lunge (1).
    pub reach: f64,
    /// Time between blows, as a share of the usual.
    pub tempo: f64,
}

impl Attack {
    /// Adapts the posture of a technique, or a share of the way to it, to a height and the direction: low blows come
    /// from low knees, long ones from a lean over the lead foot, and the trunk turns with the direction.
    pub fn aim_posture(&self, technique: &Technique, p: BoxingPosture, height: f64, share: f64) -> BoxingPosture {
        let lower = (1.3 - height).clamp(0.0, 0.2);
        let higher = (height - 1.55).clamp(0.0, 0.15);
        let lunge = self.reach.max(0.0) * if technique.load.is_none() { 1.0 } else { 0.5 };
        let close = (-self.reach).max(0.0);
        let onward = (p.chest - BoxingPosture::GUARD.chest).signum();
        BoxingPosture {
            flexion: (p.flexion + share * (4.0 * lower - 0.8 * higher)).max(0.36),
            pitch: p.pitch + share * (0.9 * lower + 0.48 * lunge - 0.12 * close - 0.4 * higher),
            hips: p.hips + 0.5 * share * self.azimuth,
            chest: p.chest + 0.8 * share * self.azimuth + 0.12 * share * lunge * onward,
            weight: p.weight + 0.2 * share * lunge,
            shift: [0.0, 0.12 * share * lunge],
            ..p
        }
    }

    /// Height of the wrist at the hit. A long blow is level, from a low shoulder (m).
    pub fn height(&self, punch: Punch, level: BlowLevel, rng: &mut impl Rng) -> f64 {
        let range = match (punch, level) {
            (Punch::Uppercut, BlowLevel::Body) => 1.18..1.28,
            (Punch::Uppercut, BlowLevel::Head) => 1.3..1.4,
            (Punch::Uppercut, BlowLevel::High) => 1.4..1.48,
            (_, BlowLevel::Body) => 1.2..1.32,
            (_, BlowLevel::Head) => 1.36..1.5,
            (_, BlowLevel::High) => 1.5..1.64,
        };
        rng.random_range(range) - 0.1 * self.reach.max(0.0)
    }

    /// Stretch of the arm at the hit, as a share of the usual: bent blows get shorter for a close target.
    pub fn stretch(&self, punch: Punch) -> f64 {
        if punch == Punch::Straight { 1.0 } else { 1.0 + 0.26 * self.reach.min(0.0) }
    }
}

/// Time from hit to hit (s).
pub fn seconds_between_hits(earlier: HandPunch, blow: HandPunch) -> f64 {
    if earlier.lead == blow.lead {
        return if blow.punch == Punch::Straight { 0.46 } else { 0.56 };
    }
    [0.31, 0.34, 0.38][blow.punch as usize]
}

#[cfg(test)]
mod tests {
    use super::super::moves::COMBINATIONS;
    use super::super::technique;
    use super::*;

    #[test]
    fn the_same_hand_is_back_before_it_strikes_again() {
        for pair in COMBINATIONS.iter().flat_map(|c| c.windows(2)).filter(|p| p[0].lead == p[1].lead) {
            let (first, second) = (technique::technique_of(pair[0]), technique::technique_of(pair[1]));
            let out = first.braking(first.speed) + second.extend;
            assert!(seconds_between_hits(pair[0], pair[1]) > out + 0.15, "{pair:?}");
        }
    }

    #[test]
    fn low_and_long_blows_lower_and_lean_the_body() {
        let blow = COMBINATIONS[0][1];
        let technique = technique::technique_of(blow);
        let aimed = |reach: f64, height: f64| {
            let attack = Attack { azimuth: 0.0, reach, tempo: 1.0 };
            attack.aim_posture(&technique, technique.strike, height, 1.0)
        };
        assert_eq!(aimed(0.0, 1.4), technique.strike);
        assert!(aimed(0.0, 1.15).flexion > technique.strike.flexion + 0.3);
        let long = aimed(1.0, 1.4);
        assert!(long.pitch > technique.strike.pitch + 0.3 && long.weight > technique.strike.weight);
        assert!(long.chest > technique.strike.chest);
    }
}
