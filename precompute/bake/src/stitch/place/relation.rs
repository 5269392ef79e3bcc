//! Relative placement of two things, rounded so that equal placements compare equal.

use std::f32::consts::TAU;
use throng_core::patch::Placement;

/// Unit of positions (m).
const STEP_M: f32 = 0.001;
/// Number of heading steps of a full turn.
const TURN: i32 = 3600;

/// Numbers of two things, and the placement of the second relative to the first, in steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(in crate::stitch) struct RelativePlacement {
    /// Number of the first: a patch.
    pub a: u32,
    /// Number of the second: a patch or a unit.
    pub b: u32,
    /// x, y, z and heading.
    steps: [i32; 4],
}

impl RelativePlacement {
    /// The relation of `b` at `at_b` to `a` at `at_a`.
    pub fn new(a: u32, at_a: Placement, b: u32, at_b: Placement) -> Self {
        let r = at_a.to_local(at_b);
        let metres = |v: f32| (v / STEP_M).round() as i32;
        let turn = ((r.heading / TAU * TURN as f32).round() as i32).rem_euclid(TURN);
        Self { a, b, steps: [metres(r.x), metres(r.y), metres(r.z), turn] }
    }

    /// Placement of `b` relative to `a`.
    pub fn placement(&self) -> Placement {
        let [x, y, z, turn] = self.steps;
        let turn = if turn > TURN / 2 { turn - TURN } else { turn };
        let [x, y, z] = [x, y, z].map(|v| v as f32 * STEP_M);
        Placement::new(x, y, z, turn as f32 / TURN as f32 * TAU)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_that_stand_alike_anywhere_are_one_relation() {
        let pair = |at: Placement| {
            let b = at.compose(Placement::new(1.2344, -0.7, 2.0, 3.0));
            RelativePlacement::new(3, at, 4, b)
        };
        let here = pair(Placement::IDENTITY);
        assert_eq!(here, pair(Placement::new(70.0, 2.1, -31.0, 1.0)));
        let p = here.placement();
        assert!((p.x - 1.234).abs() < 1e-6 && (p.y + 0.7).abs() < 1e-6 && (p.heading - 3.0).abs() < 1e-3);
    }
}
