//! A tree of boxes over triangles; a node has four boxes, which are tested together.

use crate::{bounds::BoundingBox, segment::Segment};
use glam::{Vec3, Vec4};

/// Bit that marks an index as a triangle's, not a node's.
const TRIANGLE: u32 = 1 << 31;

/// A node: four boxes, and the content of each; the last ones may be empty.
#[derive(Clone, Copy, PartialEq)]
struct BoxNode {
    /// By axis (m).
    low: [Vec4; 3],
    high: [Vec4; 3],
    /// Index of a node, or of a triangle.
    inner: [u32; 4],
}

/// Tree that halves triangles along the longest side, over and over: its depth is at most the logarithm of their number to base
/// 4.
#[derive(Clone, PartialEq)]
pub(super) struct BoxTree {
    nodes: Vec<BoxNode>,
    /// Largest coordinate (m).
    largest: f32,
}

/// Most nodes that wait: three of each of 16 levels, and one.
const MAX_WAITING: usize = 64;

impl BoxTree {
    /// - `triangles`: at least one, fewer than 2^31 (m).
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let largest = triangles.iter().flatten().fold(0.0, |most, c| c.abs().max_element().max(most));
        let mut out = Self { nodes: Vec::with_capacity(triangles.len() / 2), largest };
        out.grow(triangles, &mut order);
        out
    }

    /// Appends a node over some triangles, and its descendants; returns its index.
    fn grow(&mut self, triangles: &[[Vec3; 3]], order: &mut [u32]) -> u32 {
        let nothing = BoxNode { low: [Vec4::INFINITY; 3], high: [Vec4::NEG_INFINITY; 3], inner: [TRIANGLE; 4] };
        let at = self.nodes.len();
        self.nodes.push(nothing);
        let (first, second) = halves(triangles, order);
        let ((a, b), (c, d)) = (halves(triangles, first), halves(triangles, second));
        for (k, part) in [a, b, c, d].into_iter().enumerate().filter(|(_, p)| !p.is_empty()) {
            let inner = if let [one] = part { TRIANGLE | *one } else { self.grow(triangles, part) };
            let bounds = BoundingBox::around_points(part.iter().flat_map(|i| triangles[*i as usize]));
            let node = &mut self.nodes[at];
            for axis in 0..3 {
                node.low[axis][k] = bounds.min[axis];
                node.high[axis][k] = bounds.max[axis];
            }
            node.inner[k] = inner;
        }
        at as u32
    }

    /// Calls `look` with triangles whose boxes may be within a limit; it returns the new limit, or `None` to stop (m).
    pub fn visit_near_triangles(&self, s: &Segment, limit: f64, mut visit: impl FnMut(u32) -> Option<f64>) {
        if limit.is_nan() || limit <= 0.0 {
            return;
        }
        let core = WideSegment::new(s, self.largest);
        let mut square = core.square(limit);
        let mut waiting = [(0, 0.0); MAX_WAITING];
        let mut len = 1;
        while len > 0 {
            len -= 1;
            let (node, apart) = waiting[len];
            if apart > square {
                continue;
            }
            let node = &self.nodes[node as usize];
            let (mut near, apart) = core.near_boxes(node, square);
            let first = len;
            while near != 0 {
                let k = near.trailing_zeros() as usize;
                near &= near - 1;
                let inner = node.inner[k];
                if inner & TRIANGLE == 0 {
                    // The nearest of a node's boxes waits last, and is visited first.
                    let mut at = len;
                    while at > first && waiting[at - 1].1 < apart[k] {
                        waiting[at] = waiting[at - 1];
                        at -= 1;
                    }
                    waiting[at] = (inner, apart[k]);
                    len += 1;
                } else if apart[k] <= square {
                    match visit(inner & !TRIANGLE) {
                        Some(limit) => square = core.square(limit),
                        None => return,
                    }
                }
            }
        }
    }
}

/// Halves of the triangles, split at the median along the axis on which their middles are spread the widest.
fn halves<'a>(triangles: &[[Vec3; 3]], order: &'a mut [u32]) -> (&'a mut [u32], &'a mut [u32]) {
    let half = order.len() / 2;
    if order.len() > 2 {
        let middle = |i: u32| triangles[i as usize].iter().sum::<Vec3>();
        let middles = BoundingBox::around_points(order.iter().map(|i| middle(*i)));
        let axis = (middles.max - middles.min).max_position();
        order.select_nth_unstable_by(half, |a, b| middle(*a)[axis].total_cmp(&middle(*b)[axis]));
    }
    order.split_at_mut(half)
}

/// A segment in floats, as boxes are, repeated four times, with a bound on what rounding takes away from a distance.
struct WideSegment {
    a: [Vec4; 3],
    d: [Vec4; 3],
    low: [Vec4; 3],
    high: [Vec4; 3],
    /// One over the square of its length; 0 for a point.
    over: f32,
    slack: f32,
}

impl WideSegment {
    /// - `largest`: largest coordinate of boxes (m).
    fn new(s: &Segment, largest: f32) -> Self {
        let (a, b) = (s.a.as_vec3(), s.b.as_vec3());
        let four = |v: Vec3| v.to_array().map(Vec4::splat);
        let square = (b - a).length_squared();
        let over = if square > 1e-12 { 1.0 / square } else { 0.0 };
        // A few units in the last place of the largest number involved.
        let slack = 1e-5 + 4e-6 * a.abs().max_element().max(b.abs().max_element()).max(largest);
        Self { a: four(a), d: four(b - a), low: four(a.min(b)), high: four(a.max(b)), over, slack }
    }

    /// Square of a limit, widened by the slack (m^2); that of an infinite one is finite, so that its product with 0 is 0.
    fn square(&self, limit: f64) -> f32 {
        let limit = (limit as f32).min(1e18) + self.slack;
        limit * limit
    }

    /// Bits of the boxes that may be within a limit, by the box around the segment, and along the line from the segment to the
    /// box's middle; and squared distances from the box around the segment (m^2).
    fn near_boxes(&self, node: &BoxNode, square: f32) -> (u32, Vec4) {
        let square = Vec4::splat(square);
        let sum = |v: [Vec4; 3]| v[0] + v[1] + v[2];
        let out = by_axis(|k| (node.low[k] - self.high[k]).max(self.low[k] - node.high[k]).max(Vec4::ZERO));
        let boxes = sum(out.map(|v| v * v));
        let near = boxes.cmple(square);
        if !near.any() {
            return (0, boxes);
        }
        let from = by_axis(|k| 0.5 * (node.low[k] + node.high[k]) - self.a[k]);
        let share = (sum(by_axis(|k| from[k] * self.d[k])) * self.over).clamp(Vec4::ZERO, Vec4::ONE);
        let line = by_axis(|k| from[k] - self.d[k] * share);
        // Along that line, no point of the segment is farther than the one nearest to the middle, and no point of the box is
        // nearer than half of the box's extent on it. Both sides are multiplied by the line's length, which spares a square
        // root.
        let apart = sum(line.map(|v| v * v));
        let rest = (apart - 0.5 * sum(by_axis(|k| line[k].abs() * (node.high[k] - node.low[k])))).max(Vec4::ZERO);
        ((near & (rest * rest).cmple(square * apart)).bitmask(), boxes)
    }
}

fn by_axis(f: impl Fn(usize) -> Vec4) -> [Vec4; 3] {
    std::array::from_fn(f)
}
