//! When a bound enters and leaves cells (Kim, Kim and Shin 2003a, section 2.2).

use crate::{Space, space::plan::MotionPlan};
use serde::{Deserialize, Serialize};

/// A bound enters or leaves the cells behind a face.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Crossing {
    /// Time from the start of the bound (s).
    pub after: f32,
    pub axis: u8,
    /// The cells beyond the upper face of those it is in, or beyond the lower one.
    pub is_upper: bool,
    pub enters: bool,
}

impl Crossing {
    /// No face.
    pub const NEVER: Self = Self { after: f32::INFINITY, axis: 0, is_upper: false, enters: false };
}

/// Cells that a disc or ball occupies.
pub(crate) fn range<V: Space>(side: f32, plan: &MotionPlan<V>) -> ([i32; 3], [i32; 3]) {
    let x = plan.position.coordinates();
    let (mut low, mut high) = ([0; 3], [0; 3]);
    for axis in 0..V::DIMENSIONS {
        let (from, to) = (x[axis] - plan.radius, x[axis] + plan.radius);
        low[axis] = (from / side).floor() as i32;
        high[axis] = (to / side).floor() as i32;
        // As the gaps to faces are computed, so that these agree.
        if low[axis] as f32 * side > from {
            low[axis] -= 1;
        } else if (low[axis] + 1) as f32 * side <= from {
            low[axis] += 1;
        }
        high[axis] = high[axis].clamp(low[axis], low[axis] + 1);
        if high[axis] > low[axis] && high[axis] as f32 * side > to {
            high[axis] = low[axis];
        } else if (low[axis] + 1) as f32 * side <= to {
            high[axis] = low[axis] + 1;
        }
    }
    (low, high)
}

/// The next face of the cells it occupies that the growing bound of a plan crosses, `from` seconds after its start or later.
pub fn next_crossing<V: Space>(side: f32, plan: &MotionPlan<V>, low: [i32; 3], high: [i32; 3], from: f32) -> Crossing {
    let (x, v) = (plan.position.coordinates(), plan.velocity.coordinates());
    let mut first = Crossing::NEVER;
    for axis in 0..V::DIMENSIONS {
        let (above, below) = (x[axis] + plan.radius, x[axis] - plan.radius);
        for is_upper in [true, false] {
            let enters = low[axis] == high[axis];
            let face = (high[axis] + i32::from(enters && is_upper)) as f32 * side;
            // How far the bound is from the cells beyond the face, and how fast it goes away.
            let (gap, rate) = if is_upper { (face - above, -v[axis]) } else { (below - face, v[axis]) };
            let apart = apart(gap, rate, plan.limit);
            let after = match (enters, apart) {
                (true, Some((_, end))) => end.max(from),
                (true, None) => from,
                (false, Some((begin, _))) if begin >= from => begin,
                (false, _) => continue,
            };
            if after < first.after {
                first = Crossing { after, axis: axis as u8, is_upper, enters };
            }
        }
    }
    first
}

/// When gap + rate t - growth / 2 t^2 is above zero (growth > 0).
fn apart(gap: f32, rate: f32, growth: f32) -> Option<(f32, f32)> {
    let square = rate * rate + 2.0 * growth * gap;
    if square <= 0.0 {
        return None;
    }
    let root = square.sqrt();
    // Either form is exact; each loses digits where the other does not.
    Some(if rate > 0.0 {
        (-2.0 * gap / (rate + root), (rate + root) / growth)
    } else {
        ((rate - root) / growth, 2.0 * gap / (root - rate))
    })
}
