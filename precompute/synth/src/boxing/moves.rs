//! Repertoire of a boxer: punches and their combinations, defences, footwork.

use crate::side::LateralSide;

/// Kind of punch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Punch {
    /// Straight from the shoulder: the jab of the lead hand, the cross of the rear one.
    Straight,
    /// Across, with a bent arm.
    Hook,
    /// Upwards, with a bent arm.
    Uppercut,
}

/// A punch of one hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct HandPunch {
    /// Kind of punch.
    pub punch: Punch,
    /// True for the lead hand, which is the left one.
    pub lead: bool,
}

impl HandPunch {
    /// Side of the hand.
    pub fn side(self) -> LateralSide {
        if self.lead { LateralSide::Left } else { LateralSide::Right }
    }

    /// The tag of the blow in a clip.
    pub fn tag(self) -> &'static str {
        let [left, right] =
            [["left_jab", "left_hook", "left_uppercut"], ["right_straight", "right_hook", "right_uppercut"]];
        (if self.lead { left } else { right })[self.punch as usize]
    }
}

const JAB: HandPunch = HandPunch { punch: Punch::Straight, lead: true };
const CROSS: HandPunch = HandPunch { punch: Punch::Straight, lead: false };
const LEAD_HOOK: HandPunch = HandPunch { punch: Punch::Hook, lead: true };
const REAR_HOOK: HandPunch = HandPunch { punch: Punch::Hook, lead: false };
const LEAD_UPPER: HandPunch = HandPunch { punch: Punch::Uppercut, lead: true };
const REAR_UPPER: HandPunch = HandPunch { punch: Punch::Uppercut, lead: false };

/// Combinations of two to four punches. Consecutive hooks and uppercuts change hands, as the hips do.
pub const COMBINATIONS: [&[HandPunch]; 22] = [
    &[JAB, CROSS],
    &[JAB, JAB],
    &[JAB, JAB, CROSS],
    &[JAB, CROSS, LEAD_HOOK],
    &[JAB, CROSS, LEAD_HOOK, CROSS],
    &[JAB, CROSS, LEAD_UPPER, CROSS],
    &[JAB, LEAD_HOOK],
    &[JAB, LEAD_HOOK, CROSS],
    &[JAB, REAR_UPPER, LEAD_HOOK],
    &[JAB, REAR_HOOK, LEAD_HOOK],
    &[JAB, CROSS, JAB, CROSS],
    &[CROSS, LEAD_HOOK],
    &[CROSS, LEAD_HOOK, CROSS],
    &[CROSS, LEAD_UPPER, REAR_HOOK],
    &[LEAD_HOOK, CROSS],
    &[LEAD_HOOK, REAR_HOOK, LEAD_HOOK],
    &[LEAD_HOOK, REAR_UPPER],
    &[REAR_UPPER, LEAD_HOOK],
    &[REAR_UPPER, LEAD_HOOK, CROSS],
    &[REAR_HOOK, LEAD_UPPER, REAR_HOOK],
    &[LEAD_UPPER, REAR_UPPER],
    &[LEAD_UPPER, REAR_UPPER, LEAD_HOOK, CROSS],
];

/// Kind of defence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defence {
    /// The head moves off the line, to the left.
    SlipLeft,
    /// The head moves off the line, to the right.
    SlipRight,
    /// The knees bend, straight down.
    Duck,
    /// Down, under and up on the left.
    RollLeft,
    /// Down, under and up on the right.
    RollRight,
    /// The weight and the trunk go back.
    PullBack,
    /// Both hands come up before the face, elbows together.
    Block,
    /// The left arm covers the left side of the head.
    CoverLeft,
    /// The right arm covers the right side of the head.
    CoverRight,
    /// The rear hand brushes a straight aside.
    Parry,
}

impl Defence {
    /// All defences.
    pub const ALL: [Self; 10] = {
        use Defence::*;
        [SlipLeft, SlipRight, Duck, RollLeft, RollRight, PullBack, Block, CoverLeft, CoverRight, Parry]
    };

    /// The tag of the defence in a clip.
    pub fn tag(self) -> &'static str {
        const TAGS: [&str; 10] = [
            "slip_left",
            "slip_right",
            "duck",
            "roll_left",
            "roll_right",
            "pull_back",
            "block",
            "cover_left",
            "cover_right",
            "parry_right",
        ];
        TAGS[self as usize]
    }
}

/// A move of both feet that keeps the stance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shuffle {
    /// Distance forward (m).
    pub forward: f64,
    /// Distance to the left (m).
    pub aside: f64,
    /// Turn to the left (rad).
    pub turn: f64,
    /// The tag of the move in a clip; small ones have none.
    pub tag: Option<&'static str>,
}

const fn shuffle(forward: f64, aside: f64, turn: f64, tag: &'static str) -> Shuffle {
    Shuffle { forward, aside, turn, tag: Some(tag) }
}

/// Footwork in all directions; as far back as forward, as far left as right.
pub const FOOTWORK: [Shuffle; 16] = [
    shuffle(0.3, 0.0, 0.0, "advance"),
    shuffle(0.2, 0.0, 0.0, "advance"),
    shuffle(0.25, 0.1, 0.1, "advance"),
    shuffle(-0.3, 0.0, 0.0, "retreat"),
    shuffle(-0.22, 0.0, 0.0, "retreat"),
    shuffle(-0.23, -0.1, -0.1, "retreat"),
    shuffle(0.0, 0.28, -0.2, "circle_left"),
    shuffle(0.06, 0.24, -0.3, "circle_left"),
    shuffle(0.0, -0.28, 0.2, "circle_right"),
    shuffle(0.0, -0.22, 0.3, "circle_right"),
    shuffle(0.0, 0.34, 0.0, "side_step_left"),
    shuffle(-0.05, -0.34, 0.0, "side_step_right"),
    shuffle(0.0, 0.0, -0.7, "pivot_right"),
    shuffle(0.0, 0.0, 0.6, "pivot_left"),
    Shuffle { forward: 0.07, aside: 0.03, turn: 0.08, tag: None },
    Shuffle { forward: -0.07, aside: -0.03, turn: -0.08, tag: None },
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn combinations_differ_and_hold_every_blow() {
        let different: BTreeSet<_> = COMBINATIONS.iter().collect();
        assert!(different.len() == COMBINATIONS.len() && different.len() >= 20);
        assert!(COMBINATIONS.iter().all(|c| (2..=4).contains(&c.len())));
        let blows: BTreeSet<_> = COMBINATIONS.iter().flat_map(|c| c.iter()).collect();
        assert_eq!(blows.len(), 6);
    }

    #[test]
    fn bent_blows_change_hands() {
        for pair in COMBINATIONS.iter().flat_map(|c| c.windows(2)) {
            let twice = pair[0].lead == pair[1].lead;
            assert!(!twice || pair[0] == JAB, "{pair:?}");
        }
    }

    #[test]
    fn footwork_leads_nowhere_on_the_whole() {
        let sum = FOOTWORK.iter().fold([0.0; 3], |s, m| [s[0] + m.forward, s[1] + m.aside, s[2] + m.turn]);
        assert!(sum.iter().all(|s| s.abs() < 0.12), "{sum:?}");
    }
}
