//! Points in a k-d tree whose nodes keep the box around their points.

use crate::features::projection::{DIMS, Point, squared_gap_within};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

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

    /// No more than the squared distance to any point of a node.
    fn squared_gap_to(&self, node: usize, at: &Point) -> f32 {
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

/// Sums of squares may differ in their last digits.
const ROUNDING: f32 = 1.0 - 1e-5;

/// A way through the nodes of trees, nearest first (Beis and Lowe 1997).
#[derive(Default)]
pub(super) struct Walk {
    /// Nodes it has not been to, the nearest on top: the bits of what is no more than the squared distance to any of its
    /// points (they order numbers that are not negative), its tree, its number.
    ahead: BinaryHeap<Reverse<(u32, u32, u32)>>,
}

impl Walk {
    /// Shows number and squared distance of the points of some trees within a squared reach; those of a leaf in turn, the
    /// nearest leaf first. `see` returns the reach for the rest, no larger than before.
    pub fn visit(&mut self, trees: &[Tree], at: &Point, mut reach: f32, mut see: impl FnMut(u32, f32) -> f32) {
        self.ahead.clear();
        (0..trees.len()).for_each(|tree| self.push(trees, tree as u32, 0, at, reach));
        while let Some(Reverse((gap, tree, node))) = self.ahead.pop()
            && f32::from_bits(gap) <= reach
        {
            let Tree { points, nodes } = &trees[tree as usize];
            let Node { points: [from, to], second, .. } = nodes[node as usize];
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

    fn push(&mut self, trees: &[Tree], tree: u32, node: u32, at: &Point, reach: f32) {
        let gap = trees[tree as usize].squared_gap_to(node as usize, at);
        if gap <= reach {
            self.ahead.push(Reverse((gap.to_bits(), tree, node)));
        }
    }
}
