//! Bars inferred from places that hands held.

use super::{super::UnitShape, InferredPiece, places::InferredTouch};
use glam::Vec3;
use throng_geometry::BoundingBox;

/// Largest distance of a hand on a bar from its axis (m).
const NEAR: f32 = 0.05;
/// Longest stretch of a bar without a hand (m).
const LONGEST_GAP: f32 = 0.6;
/// Least distance between two places that define a line (m).
const APART: f32 = 0.15;
/// Fewest places that determine the direction of a bar.
const FEWEST: usize = 3;
/// Fewest places on a slanting bar: lines through many places arise by chance, and most things that hands hold are
/// level or upright.
const FEWEST_SLANTING: usize = 5;
/// Greatest slope of a level bar (rise over length), and of an upright one (run over length).
const SLANTING: f32 = 0.3;
/// Shortest total time for which hands hold a bar (s).
const SHORTEST: f32 = 1.0;
/// Shortest hold of a single hand without other places on the bar; shorter ones are pauses (s).
const LONG_HOLD: f32 = 0.5;
/// Length of a bar beyond its outermost places (m).
const BEYOND: f32 = 0.12;
/// Radius of bars (m).
const RADIUS: f32 = 0.02;
/// Most places whose pairs are tried as bars.
const MOST: usize = 300;

/// A bar held by hands.
#[derive(Clone, Debug, PartialEq)]
pub struct InferredBar {
    from: Vec3,
    to: Vec3,
    /// Distances of the places from the axis (m).
    pub off: Vec<f32>,
    /// Total time for which it was held (s).
    pub held_s: f32,
}

impl InferredBar {
    /// The bar as a piece of geometry.
    pub fn piece(&self) -> InferredPiece {
        let shape = UnitShape::Bar { from: self.from.to_array(), to: self.to.to_array(), radius: RADIUS };
        (shape, BoundingBox::around_points([self.from, self.to]).expanded(RADIUS))
    }
}

/// Finds bars through all places: first the line with most places, then the one with most of the rest, and so on. Fewer
/// than three places on a line give only a short bar across the body, and only for long holds.
pub fn find_bars(places: &[InferredTouch]) -> Vec<InferredBar> {
    let mut left: Vec<InferredTouch> = places.to_vec();
    let mut bars = Vec::new();
    while let Some(chosen) = best_line(&left) {
        let held: Vec<InferredTouch> = chosen.iter().map(|&i| left[i]).collect();
        bars.push(fit_line(&held));
        let mut number = 0..;
        left.retain(|_| number.next().is_none_or(|i| !chosen.contains(&i)));
    }
    while let Some(first) = left.first().copied() {
        let together: Vec<InferredTouch> =
            left.iter().filter(|t| t.point.distance(first.point) < APART).copied().collect();
        left.retain(|t| t.point.distance(first.point) >= APART);
        let held_s = total_duration(&together);
        if held_s < LONG_HOLD {
            continue;
        }
        let middle = together.iter().map(|t| t.point).sum::<Vec3>() / together.len() as f32;
        let across = first.across.with_y(0.0).normalize_or(Vec3::X);
        let off = together.iter().map(|t| (t.point - middle).reject_from(across).length()).collect();
        let half = APART + BEYOND;
        bars.push(InferredBar { from: middle - across * half, to: middle + across * half, off, held_s });
    }
    bars
}

/// Total duration of places (s).
fn total_duration(places: &[InferredTouch]) -> f32 {
    places.iter().map(|t| t.lasts_s).sum()
}

/// True if the number and duration of places suffice for a bar in that direction.
fn is_bar(places: &[InferredTouch], chosen: &[usize], along: Vec3) -> bool {
    let slants = along.y.abs() > SLANTING && along.with_y(0.0).length() > SLANTING;
    let fewest = if slants { FEWEST_SLANTING } else { FEWEST };
    chosen.len() >= fewest && chosen.iter().map(|&i| places[i].lasts_s).sum::<f32>() >= SHORTEST
}

/// Indices of the places on the line with most of them; `None` if no line is a bar.
fn best_line(places: &[InferredTouch]) -> Option<Vec<usize>> {
    let step = places.len().div_ceil(MOST).max(1);
    let mut best: Vec<usize> = Vec::new();
    for i in (0..places.len()).step_by(step) {
        for j in (0..i).step_by(step) {
            let (a, b) = (places[i].point, places[j].point);
            let d = b - a;
            if d.length() < APART || d.length() > 2.0 * LONGEST_GAP {
                continue;
            }
            let chosen = places_on_line(places, a, d.normalize());
            if chosen.len() > best.len() && is_bar(places, &chosen, d.normalize()) {
                best = chosen;
            }
        }
    }
    (!best.is_empty()).then_some(best)
}

/// Places near a line that are connected to its point `a` without a long gap.
fn places_on_line(places: &[InferredTouch], a: Vec3, along: Vec3) -> Vec<usize> {
    let near = |&i: &usize| (places[i].point - a).reject_from(along).length() < NEAR;
    let at = |i: usize| (places[i].point - a).dot(along);
    let mut chosen: Vec<usize> = (0..places.len()).filter(near).collect();
    chosen.sort_by(|&i, &j| at(i).total_cmp(&at(j)));
    // The run without gaps that contains the point itself, at coordinate 0.
    let start = chosen.partition_point(|&i| at(i) < 0.0);
    let gap = |i: usize, j: usize| at(chosen[j]) - at(chosen[i]) > LONGEST_GAP;
    let (mut low, mut high) = (start, start);
    while low > 0 && !gap(low - 1, low) {
        low -= 1;
    }
    while high + 1 < chosen.len() && !gap(high, high + 1) {
        high += 1;
    }
    chosen[low..=high].to_vec()
}

/// Bar along the principal direction of the places, by power iteration on their scatter.
fn fit_line(places: &[InferredTouch]) -> InferredBar {
    let points: Vec<Vec3> = places.iter().map(|t| t.point).collect();
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    let ends = (points[0], points[points.len() - 1]);
    let mut along = (ends.1 - ends.0).normalize_or(Vec3::X);
    for _ in 0..20 {
        let next: Vec3 = points.iter().map(|p| (*p - middle) * (*p - middle).dot(along)).sum();
        along = next.normalize_or(along);
    }
    let reach = |p: &Vec3| (*p - middle).dot(along);
    let low = points.iter().map(reach).fold(f32::INFINITY, f32::min) - BEYOND;
    let high = points.iter().map(reach).fold(f32::NEG_INFINITY, f32::max) + BEYOND;
    let off = points.iter().map(|p| (*p - middle).reject_from(along).length()).collect();
    InferredBar { from: middle + along * low, to: middle + along * high, off, held_s: total_duration(places) }
}

#[cfg(test)]
mod tests {
    use super::super::places::TouchKind;
    use super::*;

    fn hold(p: Vec3) -> InferredTouch {
        InferredTouch {
            kind: TouchKind::Hand,
            point: p,
            extent: BoundingBox::around_points([p]),
            across: Vec3::X,
            lasts_s: 1.0,
        }
    }

    #[test]
    fn a_rung_and_a_pole_are_told_apart_and_lone_holds_are_short_bars() {
        let rung = (0..5).map(|i| Vec3::new(0.2 * i as f32, 2.0, 0.01 * (i % 2) as f32));
        let pole = (0..4).map(|i| Vec3::new(3.0, 1.0 + 0.3 * i as f32, 1.0));
        let places: Vec<InferredTouch> = rung.chain(pole).chain([Vec3::new(-4.0, 1.5, 0.0)]).map(hold).collect();
        let bars = find_bars(&places);
        let along = |b: &InferredBar| (b.to - b.from).normalize().abs();
        assert_eq!(bars.iter().map(|b| b.off.len()).collect::<Vec<_>>(), [5, 4, 1]);
        assert!(along(&bars[0]).x > 0.99 && along(&bars[1]).y > 0.99 && along(&bars[2]).x > 0.99);
        assert!(((bars[0].to - bars[0].from).length() - 1.04).abs() < 0.01);
        assert!(bars[0].off.iter().all(|d| *d < 0.011));
        let pause = InferredTouch { lasts_s: 0.3, ..places[9] };
        assert!(find_bars(&[pause]).is_empty() && find_bars(&[]).is_empty());
    }

    #[test]
    fn a_slanting_rail_takes_more_places_than_a_rung_and_pauses_are_no_bar() {
        let rail =
            |n: usize| (0..n).map(|i| hold(Vec3::new(0.2, 1.0 + 0.2 * i as f32, 0.2 * i as f32))).collect::<Vec<_>>();
        assert!(find_bars(&rail(4)).iter().all(|b| b.off.len() < 3));
        assert_eq!(find_bars(&rail(5))[0].off.len(), 5);
        let pauses: Vec<InferredTouch> =
            (0..4).map(|i| InferredTouch { lasts_s: 0.2, ..hold(Vec3::X * 0.3 * i as f32) }).collect();
        assert!(find_bars(&pauses).is_empty());
    }
}
