//! Sitting down and standing up: timing of the hips' motion back and down, and lean of the trunk that keeps its weight
//! over the feet.
//!
//! Rising begins with the trunk, which leans forward while the seat still carries; the hips leave the seat when the
//! weight is over the feet; hips and trunk then straighten together (Schenkman et al. 1990, *Whole-body movements
//! during rising to standing from sitting*). Sitting down is the reverse, except that the trunk leans and the hips go
//! back from the first moment on.

use crate::signal::{PieceEnd, cruise, quintic};

/// A stay on a chair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChairStay {
    /// Time of sitting down, from the first bending of the knees until the trunk is upright again (s).
    pub down: [f64; 2],
    /// Time of standing up, from the first leaning of the trunk until it is upright (s).
    pub up: [f64; 2],
}

/// Degree to which the body is seated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeatedShare {
    /// Horizontal position of the hips: 0 over the feet, 1 over the seat.
    pub back: f64,
    /// Height of the hips: 0 standing, 1 on the seat.
    pub down: f64,
    /// Forward lean of the chest that keeps the balance (rad).
    pub lean: f64,
    /// True if the seat carries.
    pub carried: bool,
}

/// Lean of the chest while sitting down and while standing up (rad).
const LEAN: [f64; 2] = [0.62, 0.72];
/// Share of each movement after which the hips reach, or leave, the seat.
const TOUCH: [f64; 2] = [0.8, 0.34];

impl ChairStay {
    /// State at `t` seconds.
    pub fn state_at(&self, t: f64) -> SeatedShare {
        let share = |span: [f64; 2]| ((t - span[0]) / (span[1] - span[0])).clamp(0.0, 1.0);
        let (down, up) = (share(self.down), share(self.up));
        let piece = |u: f64, from: f64, to: f64| cruise(0.45, (u - from) / (to - from));
        SeatedShare {
            back: piece(down, 0.05, 0.74) - piece(up, 0.3, 0.86),
            down: piece(down, 0.03, TOUCH[0]) - piece(up, TOUCH[1], 0.97),
            lean: LEAN[0] * rise_and_fall(down, 0.5) + LEAN[1] * rise_and_fall(up, 0.42),
            carried: down >= TOUCH[0] && up <= TOUCH[1],
        }
    }
}

/// Rises from 0 to 1 at `top`, and falls back to 0 at 1, at rest at all three.
fn rise_and_fall(u: f64, top: f64) -> f64 {
    if u < top {
        quintic(PieceEnd::at_rest(0.0), PieceEnd::at_rest(1.0), top, u)
    } else {
        quintic(PieceEnd::at_rest(1.0), PieceEnd::at_rest(0.0), 1.0 - top, u - top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SITTING: ChairStay = ChairStay { down: [1.0, 3.0], up: [10.0, 12.0] };

    #[test]
    fn stands_sits_and_stands_again() {
        let still = |t: f64| SITTING.state_at(t);
        assert_eq!(still(0.0), SeatedShare::default());
        assert_eq!(still(5.0), SeatedShare { back: 1.0, down: 1.0, lean: 0.0, carried: true });
        assert_eq!(still(13.0), SeatedShare::default());
    }

    #[test]
    fn the_trunk_leans_before_the_hips_rise_and_the_seat_carries_only_on_the_chair() {
        for k in 0..1300 {
            let s = SITTING.state_at(f64::from(k) * 0.01);
            assert!(!s.carried || (s.down - 1.0).abs() < 1e-9, "{k}: {s:?}");
            assert!(s.down > 0.999 || !(1000..=1110).contains(&k) || s.lean > 0.5, "{k}: {s:?}");
            assert!((0.0..=1.0 + 1e-9).contains(&s.back) && (0.0..=1.0 + 1e-9).contains(&s.down));
        }
    }
}
