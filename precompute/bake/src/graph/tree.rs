//! Points in a k-d tree whose nodes keep the box around their points.

use crate::features::projection::{DIMS, Point, squared_gap};

/// Points of a leaf, at most.
const LEAF: usize = 16;

/// Some points, parted again and again where they spread most.
pub(super) struct Tree {
    /// Number and point of each, in the order of the leaves.
    points: Vec<(u32, Point)>,
    /// Each before the nodes of its first half, and those before the ones of its second.
    nodes: Vec<Node>,
}

struct Node {
    bounds: [Point; 2],
    /// Points from, and up to.
    points: [u32; 2],
    /// Node of the second half; 0 for a leaf. The first half follows its node.
    second: u32,
}

impl Tree {
    /// Makes a tree of numbered points.
    pub fn new(points: Vec<(u32, Point)>) -> Self {
        let mut tree = Self { points, nodes: Vec::new() };
        tree.part(0, tree.points.len());
        tree
    }

    /// Adds the nodes over some points. Depth is the logarithm of their number.
    fn part(&mut self, from: usize, to: usize) {
        let points = &mut self.points[from..to];
        let mut bounds = [[f32::INFINITY; DIMS], [f32::NEG_INFINITY; DIMS]];
        for (_, p) in points.iter() {
            for d in 0..DIMS {
                bounds[0][d] = bounds[0][d].min(p[d]);
                bounds[1][d] = bounds[1][d].max(p[d]);
            }
        }
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, points: [from as u32, to as u32], second: 0 });
        if points.len() > LEAF {
            let spread = |d: &usize| bounds[1][*d] - bounds[0][*d];
            let widest = (0..DIMS).max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
            let middle = points.len() / 2;
            points.select_nth_unstable_by(middle, |a, b| a.1[widest].total_cmp(&b.1[widest]).then(a.0.cmp(&b.0)));
            self.part(from, from + middle);
            self.nodes[node].second = self.nodes.len() as u32;
            self.part(from + middle, to);
        }
    }

    /// Shows every number whose point lies within a squared reach, nearer halves first; `see` returns the reach for the rest.
    pub fn visit(&self, at: &Point, reach: f32, see: &mut impl FnMut(u32) -> f32) {
        self.visit_node(0, at, reach, see);
    }

    fn visit_node(&self, node: usize, at: &Point, mut reach: f32, see: &mut impl FnMut(u32) -> f32) -> f32 {
        let Node { points: [from, to], second, .. } = self.nodes[node];
        if second == 0 {
            for (number, p) in &self.points[from as usize..to as usize] {
                if squared_gap(at, p) <= reach {
                    reach = see(*number);
                }
            }
            return reach;
        }
        let gap = |n: usize| {
            let [low, high] = &self.nodes[n].bounds;
            (0..DIMS).map(|d| (low[d] - at[d]).max(at[d] - high[d]).max(0.0).powi(2)).sum::<f32>()
        };
        let mut halves = [node + 1, second as usize].map(|n| (gap(n), n));
        halves.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for (gap, n) in halves {
            // Sums of the same squares in another order may differ in their last digits.
            if gap <= reach * (1.0 + 1e-5) {
                reach = self.visit_node(n, at, reach, see);
            }
        }
        reach
    }
}
