//! Times at which two parabolas come within a distance of each other, or apart: by conservative advancement, so that no
//! crossing is missed.

use crate::{Space, senses::Sensors, space::plan::MotionPlan};

/// Shortest advance (s). What dips below a distance for less is less deep than rounding is.
const LEAST_S: f64 = 1e-4;

/// True where the positions of two plans are within a distance.
#[inline]
pub(crate) fn is_near<V: Space>(a: &MotionPlan<V>, b: &MotionPlan<V>, distance: f32, time: f64) -> bool {
    (a.motion_at(time).0 - b.motion_at(time).0).length_squared() <= distance * distance
}

/// The first time after `from`, and not after `until`, at which two plans come within a distance, or no longer are.
///
/// - `is_near`: they are within it at `from`.
/// - returns the first time (of those that f64 can tell apart by 1e-9 s) at which [`is_near`] says the other.
pub(crate) fn first_change<V: Space>(
    a: &MotionPlan<V>,
    b: &MotionPlan<V>,
    distance: f32,
    from: f64,
    until: f64,
    near: bool,
) -> Option<f64> {
    let mut at = from;
    // Within a piece, neither begins to stand.
    let ends = [a, b].map(|p| p.start + f64::from(p.moving));
    while at < until {
        let piece = ends.iter().copied().filter(|e| *e > at).fold(until, f64::min);
        let relative = |time: f64| a.motion_at(time).1 - b.motion_at(time).1;
        // The relative velocity changes linearly: it is greatest at an end of the piece. Just before its end, an agent
        // that comes to stand there still moves.
        let fastest = relative(at).length().max(relative(piece - 1e-9 * (1.0 + piece.abs())).length()) + 1e-6;
        let mut before = at;
        while at < piece {
            let gap = (a.motion_at(at).0 - b.motion_at(at).0).length() - distance;
            let advance = f64::from(gap.abs() / fastest).max(LEAST_S);
            at = (at + advance).min(piece);
            if is_near(a, b, distance, at) != near {
                return Some(bisect_change(before, at, |time| is_near(a, b, distance, time) == near));
            }
            before = at;
        }
        // The last time of a piece is tested again as the first of the next.
        at = piece;
    }
    None
}

/// Time between two others from which on something is as it was not before.
fn bisect_change(mut before: f64, mut after: f64, is_before: impl Fn(f64) -> bool) -> f64 {
    while after - before > 1e-9 {
        let middle = 0.5 * (before + after);
        if is_before(middle) { before = middle } else { after = middle }
    }
    after
}

/// The first time after `from`, and not after its end, at which a plan leaves the square cell that it is in at `from`.
pub(crate) fn leaves_cell<V: Space>(plan: &MotionPlan<V>, sensors: &Sensors<V>, from: f64) -> Option<f64> {
    let (cell, side) = (|time: f64| sensors.cell_at(plan.motion_at(time).0), sensors.senses.cell_m);
    let here = cell(from);
    let mut at = from;
    let end = plan.end.min(plan.start + f64::from(plan.moving)).max(from);
    let fastest = plan.motion_at(from).1.length().max(plan.motion_at(end - 1e-9 * (1.0 + end.abs())).1.length()) + 1e-6;
    while at < end {
        let place = plan.motion_at(at).0.on_ground();
        let low = glam::Vec2::new(here[0] as f32, here[1] as f32) * side;
        let gap = (place - low).min(low + side - place).min_element();
        let before = at;
        at = (at + f64::from(gap.max(0.0) / fastest).max(LEAST_S)).min(end);
        if cell(at) != here {
            return Some(bisect_change(before, at, |time| cell(time) == here));
        }
    }
    None
}
