//! Points in a k-d tree whose nodes keep the box around their points.

use crate::features::projection::{DIMS, ProjectedPoint, squared_gap_within};
use std::{cmp::Reverse, collections::BinaryHeap};

/// Points of a leaf, at most.
const LEAF: usize = 16;

/// k-d tree of points, split repeatedly along the axis of largest extent.
pub(super) struct PointTree {
    /// Number and coordinates of each point, in the order of the leaves.
    points: Vec<(u32, ProjectedPoint)>,
    /// Nodes, each before those of its first half, which precede those of its second.
    nodes: Vec<PointTreeNode>,
}

struct PointTreeNode {
    bounds: [ProjectedPoint; 2],
    /// Range of points: begin and end.
    points: [u32; 2],
    /// Node of the second half; 0 for a leaf. The first half follows its node.
    second: u32,
}

impl PointTree {
    /// Makes a tree of numbered points.
    pub fn new(points: Vec<(u32, ProjectedPoint)>) -> Self {
        let mut tree = Self { points, nodes: Vec::new() };
        tree.build_node(0, tree.points.len());
        tree
    }

    /// Adds the nodes of a range of points. Depth is logarithmic in their number.
    fn build_node(&mut self, from: usize, to: usize) {
        let points = &mut self.points[from..to];
        let mut bounds = [[f32::INFINITY; DIMS], [f32::NEG_INFINITY; DIMS]];
        for (_, p) in points.iter() {
            for d in 0..DIMS {
                bounds[0][d] = bounds[0][d].min(p[d]);
                bounds[1][d] = bounds[1][d].max(p[d]);
            }
        }
        let node = self.nodes.len();
        self.nodes.push(PointTreeNode { bounds, points: [from as u32, to as u32], second: 0 });
        if points.len() > LEAF {
            let spread = |d: &usize| bounds[1][*d] - bounds[0][*d];
            let widest = (0..DIMS).max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
            let middle = points.len() / 2;
            points.select_nth_unstable_by(middle, |a, b| a.1[widest].total_cmp(&b.1[widest]).then(a.0.cmp(&b.0)));
            self.build_node(from, from + middle);
            self.nodes[node].second = self.nodes.len() as u32;
            self.build_node(from + middle, to);
        }
    }

    /// Lower bound of the squared distance to the points of a node.
    fn squared_gap_to(&self, node: usize, at: &ProjectedPoint) -> f32 {
        let [low, high] = &self.nodes[node].bounds;
        let mut sums = [0.0f32; 4];
        for d in (0..DIMS).step_by(4) {
            for l in 0..4 {
                let gap = (low[d + l] - at[d + l]).max(at[d + l] - high[d + l]).max(0.0);
                sums[l] += gap * gap;
            }
        }
        ROUNDING * sums.iter().sum::<f32>()
    }
}

/// Tolerance for different last digits of sums of squares.
const ROUNDING: f32 = 1.0 - 1e-5;

/// Traversal of the nodes of trees, nearest first (Beis and Lowe 1997).
#[derive(Default)]
pub(super) struct PointTreeWalk {
    /// Unvisited nodes, nearest on top: the bits of a lower bound of the squared distance to their points (ordered as
    /// non-negative numbers), tree, node.
    ahead: BinaryHeap<Reverse<(u32, u32, u32)>>,
}

impl PointTreeWalk {
    /// Calls `see` with number and squared distance of the points of some trees within a squared radius, leaf by leaf,
    /// nearest leaf first. `see` returns the radius for the rest, no larger than before.
    pub fn visit(
        &mut self,
        trees: &[PointTree],
        at: &ProjectedPoint,
        mut reach: f32,
        mut see: impl FnMut(u32, f32) -> f32,
    ) {
        self.ahead.clear();
        (0..trees.len()).for_each(|tree| self.push(trees, tree as u32, 0, at, reach));
        while let Some(Reverse((gap, tree, node))) = self.ahead.pop()
            && f32::from_bits(gap) <= reach
        {
            let PointTree { points, nodes } = &trees[tree as usize];
            let PointTreeNode { points: [from, to], second, .. } = nodes[node as usize];
            if second != 0 {
                self.push(trees, tree, node + 1, at, reach);
                self.push(trees, tree, second, at, reach);
                continue;
            }
            for (number, p) in &points[from as usize..to as usize] {
                if let Some(gap) = squared_gap_within(at, p, reach) {
                    reach = see(*number, gap);
                }
            }
        }
    }

    fn push(&mut self, trees: &[PointTree], tree: u32, node: u32, at: &ProjectedPoint, reach: f32) {
        let gap = trees[tree as usize].squared_gap_to(node as usize, at);
        if gap <= reach {
            self.ahead.push(Reverse((gap.to_bits(), tree, node)));
        }
    }
}
