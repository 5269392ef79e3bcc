//! Gym in which the motion takes place: positions and dimensions of its stairs, ladder, decks and slides.
//!
//! The numbers equal those of `data/units/playground.toml` and `data/environments/playground.toml`; a test compares
//! them.

use crate::walk::footsteps::FeetStance;
use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, PI};

/// Height from one level to the next (m).
pub const LEVEL: f64 = 2.1;
/// Height of a step of the stairs (m).
pub const RISE: f64 = 0.175;
/// Depth of a step of the stairs (m).
pub const GOING: f64 = 2.8 / 12.0;
/// Distance from rung to rung (m).
pub const RUNG: f64 = 0.3;
/// Radius of a rung (m).
pub const RUNG_RADIUS: f64 = 0.016;
/// Distance of rungs and rails before the deck's edge (m).
pub const LADDER_FRONT: f64 = 0.08;
/// Distance of each rail from the middle of the ladder (m).
pub const RAIL_ASIDE: f64 = 0.25;
/// Upper end of the rails (m).
pub const RAIL_TOP: f64 = 3.0;
/// Distance of each side of stairs from their middle (m).
const STAIRS_ASIDE: f64 = 0.6;

/// A flight of stairs; all climb towards +Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stairs {
    /// The foot of the first riser (x, z) (m).
    pub foot: DVec2,
    /// Number of steps.
    pub num_steps: usize,
}

impl Stairs {
    /// The upper end (x, z) (m).
    pub fn end(&self) -> DVec2 {
        self.foot + DVec2::Y * (GOING * self.num_steps as f64)
    }

    fn step_height(&self, p: DVec2) -> Option<f64> {
        let (aside, along) = ((p.x - self.foot.x).abs(), p.y - self.foot.y);
        let on = aside < STAIRS_ASIDE && along >= 0.0 && p.y < self.end().y;
        on.then(|| RISE * ((along / GOING).floor() + 1.0).min(self.num_steps as f64))
    }
}

/// A rectangle of panels above the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GymDeck {
    /// Corner with the lowest x and z (m).
    pub min: DVec2,
    /// The opposite corner (m).
    pub max: DVec2,
    /// Height (m).
    pub level: f64,
}

impl GymDeck {
    /// True if a point is within the deck, at least `margin` metres from its edges.
    pub fn contains(&self, p: DVec2, margin: f64) -> bool {
        p.cmpge(self.min + margin).all() && p.cmple(self.max - margin).all()
    }
}

/// The deck one level up, four panels large.
pub const DECK_A: GymDeck = GymDeck { min: DVec2::new(-1.4, -1.4), max: DVec2::new(4.2, 4.2), level: LEVEL };
/// The deck two levels up, two panels large.
pub const DECK_B: GymDeck = GymDeck { min: DVec2::new(-9.8, 1.4), max: DVec2::new(-4.2, 4.2), level: 2.0 * LEVEL };
/// The stairs to deck A.
pub const STAIRS_A: Stairs = Stairs { foot: DVec2::new(0.0, -4.2), num_steps: 12 };
/// The stairs to deck B.
pub const STAIRS_B: Stairs = Stairs { foot: DVec2::new(-5.6, -4.2), num_steps: 24 };
/// The ladder to deck A; climbers face +Z.
pub const LADDER: DVec2 = DVec2::new(2.8, -1.4);
/// Upper edge of the straight slide of deck A, and its direction.
pub const SLIDE_A: FeetStance = FeetStance { at: DVec2::new(0.0, 4.2), heading: 0.0 };
/// Upper edge of the curved slide, and its direction.
pub const SLIDE_CURVED: FeetStance = FeetStance { at: DVec2::new(4.2, 2.8), heading: FRAC_PI_2 };
/// Upper edge of the long slide of deck B, and its direction.
pub const SLIDE_B: FeetStance = FeetStance { at: DVec2::new(-8.4, 4.2), heading: 0.0 };

/// Height of the ground under a foot (m).
///
/// The ground beneath decks is not walked on.
pub fn ground(p: DVec2) -> f64 {
    let deck = [DECK_A, DECK_B].into_iter().find(|d| d.contains(p, 0.0)).map(|d| d.level);
    deck.or_else(|| [STAIRS_A, STAIRS_B].into_iter().find_map(|s| s.step_height(p))).unwrap_or(0.0)
}

/// Room for the elbows (m).
pub const ELBOWS: f64 = 0.45;
/// Least distance of characters from obstacles and edges (m).
pub const CLOSE: f64 = 0.2;

/// True if a point of the ground is at least `room` metres from all obstacles.
pub fn is_free(p: DVec2, room: f64) -> bool {
    let stairs = |s: Stairs| (s.foot - DVec2::X * STAIRS_ASIDE, s.end() + DVec2::X * STAIRS_ASIDE);
    let taken = [
        (DECK_A.min, DECK_A.max),
        (DECK_B.min, DECK_B.max),
        stairs(STAIRS_A),
        stairs(STAIRS_B),
        (SLIDE_A.at - DVec2::X * 0.35, SLIDE_A.at + DVec2::new(0.35, 3.2)),
        (SLIDE_B.at - DVec2::X * 0.35, SLIDE_B.at + DVec2::new(0.35, 6.0)),
        (SLIDE_CURVED.at - DVec2::new(0.0, 2.115), SLIDE_CURVED.at + DVec2::new(2.25, 0.35)),
    ];
    taken.iter().all(|(min, max)| !(p.cmpgt(*min - room).all() && p.cmplt(*max + room).all()))
}

/// Stance on the `k`-th step of the stairs on the way up; the ground before the stairs is step 0.
pub fn tread_up(stairs: &Stairs, aside: f64, k: usize) -> FeetStance {
    // The heel hangs over, so that the toes have room before the next riser.
    const HEEL_IN: f64 = 0.003;
    let along = if k == 0 { -0.3 } else { GOING * (k - 1) as f64 + HEEL_IN };
    FeetStance { at: stairs.foot + DVec2::new(aside, along), heading: 0.0 }
}

/// Stance on the `k`-th step of the stairs on the way down: step 0 is the deck before the stairs, step 1 the first one,
/// level with the deck, and the last one the ground.
pub fn tread_down(stairs: &Stairs, aside: f64, k: usize) -> FeetStance {
    // Heels close to the risers, toes a little over the edge.
    const HEEL_IN: f64 = 0.056;
    let along = if k == 0 { -0.26 } else { GOING * (k - 1) as f64 + HEEL_IN };
    FeetStance { at: stairs.end() + DVec2::new(aside, -along), heading: PI }
}
