//! Long clips split into steady pieces, each of which is one arc at one speed (Kim, Kim and Shin 2003a, section 4.1).

use super::{ClipTrack, FacingTwist, StepCycle};

/// Limits of the variation of movement over a steady piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Difference of speeds, ahead or to the side (m/s).
    pub speed: f64,
    /// Difference of turning rates (rad/s).
    pub gyration: f64,
}

/// Runs of consecutive cycles that move alike: within one run, speeds and turning rates differ by no more than the
/// tolerance. Each run is as long as possible from the end of the last one.
pub fn steady_runs(track: &ClipTrack<'_>, cycles: &[StepCycle], tolerance: Tolerance) -> Vec<Vec<StepCycle>> {
    let mut out: Vec<Vec<StepCycle>> = Vec::new();
    let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
    for c in cycles {
        let t = FacingTwist::mean_of_cycles(track, &[*c], c.end - c.start);
        let here = [t.velocity.x, t.velocity.y, t.gyration];
        let limits = [tolerance.speed, tolerance.speed, tolerance.gyration];
        let fits = (0..3).all(|k| here[k].max(high[k]) - here[k].min(low[k]) <= limits[k]);
        match out.last_mut() {
            Some(piece) if fits && piece[piece.len() - 1].end == c.start => {
                piece.push(*c);
                low = std::array::from_fn(|k| here[k].min(low[k]));
                high = std::array::from_fn(|k| here[k].max(high[k]));
            }
            _ => {
                out.push(vec![*c]);
                (low, high) = (here, here);
            }
        }
    }
    out
}
