//! Curves of edges between the boxes of states, which avoid other boxes.

use eframe::egui::{Pos2, Rect, Vec2, vec2};

/// Offsets by which curves bend aside, the nearest free one first (points).
const BENDS: [f32; 9] = [9.0, -9.0, 26.0, -26.0, 48.0, -48.0, 75.0, -75.0, 110.0];
/// Points of a curve.
const POINTS: usize = 24;
/// Distance of a self edge from its box (points).
const LOOP: f32 = 15.0;
/// Length of the stroke of an edge from any state (points).
const STUB: f32 = 20.0;

/// The curve of an edge, from the side of a box to the side of a box (points).
pub type EdgeCurve = Vec<Pos2>;

/// The curves of all edges: from which box, any where absent, to which.
///
/// - `within`: bounds of the curves.
pub fn curves(edges: &[(Option<usize>, usize)], boxes: &[Rect], within: Rect) -> Vec<EdgeCurve> {
    let mut out: Vec<EdgeCurve> = Vec::new();
    for &(from, to) in edges {
        let num_alike = out.iter().zip(edges).filter(|(_, e)| **e == (from, to)).count();
        let curve = match from {
            None => stub(boxes[to], num_alike),
            Some(from) if from == to => turn(boxes[to], num_alike),
            Some(from) => {
                let all = BENDS.iter().map(|bend| arc(boxes[from], boxes[to], *bend));
                let cost = |c: &EdgeCurve| cost(c, (from, to), boxes, within, &out);
                // Of equally cheap curves, the first one.
                all.reduce(|best, next| if cost(&next) < cost(&best) { next } else { best }).unwrap_or_default()
            }
        };
        out.push(curve);
    }
    out
}

/// A curve that bends to its left.
fn arc(from: Rect, to: Rect, bend: f32) -> EdgeCurve {
    let (a, b) = (from.center(), to.center());
    let along = (b - a).normalized();
    // A quadratic curve reaches only half as far as its control point.
    let control = a + (b - a) * 0.5 + vec2(along.y, -along.x) * (2.0 * bend);
    let at = |t: f32| {
        let (p, q) = (a.lerp(control, t), control.lerp(b, t));
        p.lerp(q, t)
    };
    let (mut low, mut high) = (0.0, 1.0);
    let fine = 200;
    for i in 0..=fine {
        let t = i as f32 / fine as f32;
        if from.contains(at(t)) {
            low = t;
        }
        if to.contains(at(1.0 - t)) {
            high = 1.0 - t;
        }
    }
    let high: f32 = high.max(low);
    (0..=POINTS).map(|i| at(low + (high - low) * i as f32 / POINTS as f32)).collect()
}

/// A loop at the right of a box, the second one wider.
fn turn(of: Rect, number: usize) -> EdgeCurve {
    let reach = LOOP + 7.0 * number as f32;
    let (top, bottom) = (of.center().y - 5.0, of.center().y + 5.0);
    let at = |t: f32| {
        let angle = std::f32::consts::PI * t;
        let y = top + (bottom - top) * (0.5 - 0.5 * angle.cos()) - 4.0 * (2.0 * angle).sin();
        Pos2::new(of.right() + reach * angle.sin(), y)
    };
    (0..=POINTS).map(|i| at(i as f32 / POINTS as f32)).collect()
}

/// A short stroke into a box from its upper left, the second one beside the first.
fn stub(of: Rect, number: usize) -> EdgeCurve {
    let end = Pos2::new((of.left() + 12.0 + 12.0 * number as f32).min(of.right() - 4.0), of.top());
    let from = end + vec2(-0.5 * STUB, -STUB);
    (0..=POINTS).map(|i| from.lerp(end, i as f32 / POINTS as f32)).collect()
}

/// Cost of a curve: through boxes, out of bounds, near other curves, long.
fn cost(curve: &EdgeCurve, ends: (usize, usize), boxes: &[Rect], within: Rect, others: &[EdgeCurve]) -> f32 {
    let is_in_box = |p: &Pos2| {
        let mut others = boxes.iter().enumerate().filter(|(i, _)| *i != ends.0 && *i != ends.1);
        others.any(|(_, b)| b.expand(3.0).contains(*p))
    };
    let hidden = curve.iter().filter(|p| is_in_box(p)).count();
    let outside = curve.iter().filter(|p| !within.contains(**p)).count();
    let inner = &curve[2..curve.len().max(4) - 2];
    let is_near = |p: &Pos2| others.iter().any(|o| o.iter().any(|q| q.distance(*p) < 5.0));
    let shared = inner.iter().filter(|p| is_near(p)).count();
    let length: f32 = curve.windows(2).map(|w| w[0].distance(w[1])).sum();
    20.0 * (hidden + outside) as f32 + 4.0 * shared as f32 + 0.1 * length
}

/// The middle of a curve.
pub fn middle(curve: &EdgeCurve) -> Pos2 {
    curve.get(curve.len() / 2).copied().unwrap_or(Pos2::ZERO)
}

/// Direction in which a curve bends, a unit vector; to the right for a straight curve.
pub fn bend(curve: &EdgeCurve) -> Vec2 {
    let (Some(&first), Some(&last)) = (curve.first(), curve.last()) else { return Vec2::X };
    let aside = middle(curve) - first.lerp(last, 0.5);
    if aside.length() > 1.0 { aside.normalized() } else { Vec2::X }
}

/// Corners of the head of an arrow at the end of a curve, of a length (points).
pub fn head(curve: &EdgeCurve, length: f32) -> [Pos2; 3] {
    let Some(&tip) = curve.last() else { return [Pos2::ZERO; 3] };
    let from = curve.iter().rev().find(|p| p.distance(tip) >= length).copied().unwrap_or(curve[0]);
    let back = (from - tip).normalized() * length;
    let aside = Vec2::new(-back.y, back.x) * 0.45;
    [tip, tip + back + aside, tip + back - aside]
}

/// Distance of a place from a curve (points).
pub fn distance(curve: &EdgeCurve, at: Pos2) -> f32 {
    curve.iter().map(|p| p.distance(at)).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::pos2;

    fn at(x: f32, y: f32) -> Rect {
        Rect::from_min_size(pos2(x, y), vec2(60.0, 20.0))
    }

    #[test]
    fn edges_begin_and_end_at_their_boxes_and_keep_clear_of_others() {
        let boxes = [at(100.0, 0.0), at(100.0, 60.0), at(100.0, 120.0)];
        let within = Rect::from_min_size(pos2(0.0, 0.0), vec2(300.0, 160.0));
        let edges = [(Some(0), 1), (Some(1), 0), (Some(0), 1), (Some(0), 2), (Some(2), 2), (None, 1)];
        let curves = curves(&edges, &boxes, within);
        for (curve, (from, to)) in curves.iter().zip(edges) {
            assert!(boxes[to].expand(2.0).contains(*curve.last().unwrap()), "{curve:?}");
            assert!(from.is_none_or(|f| boxes[f].expand(2.0).contains(curve[0])), "{curve:?}");
            assert!(curve.iter().all(|p| within.contains(*p)));
            let ends = [from.unwrap_or(to), to];
            let mut others = boxes.iter().enumerate().filter(|(i, _)| !ends.contains(i));
            assert!(others.all(|(_, b)| curve.iter().all(|p| !b.contains(*p))), "{curve:?}");
        }
        // Two edges of a pair of states lie apart, and so do both directions.
        for (i, k) in [(0, 1), (0, 2), (1, 2)] {
            assert!(distance(&curves[i], middle(&curves[k])) > 4.0, "{i} {k}");
        }
        assert!(bend(&curves[4]).x > 0.9, "a loop is at the right of its box");
        let [tip, a, b] = head(&curves[0], 7.0);
        assert!(tip == *curves[0].last().unwrap() && a.y < tip.y && b.y < tip.y);
    }
}
