//! A tree of states, with the nearest node to a state.

use crate::problem::{LimbState, Problem};
use crate::{linkage::LIMB_JOINTS, planner::LimbPlanner};
use glam::DVec3;
use std::sync::{Mutex, PoisonError};

/// Weights of the metric: w_t |t1 - t2| + w_a max_i |p_i1 - p_i2| (Shapiro, Kallmann and Faloutsos 2007, section 4.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetricWeights {
    /// Weight of time (m/s, >= 0).
    pub time: f64,
    /// Weight of positions (> 0).
    pub place: f64,
}

/// A state, the ends of its joints' segments, and the node that it was reached from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SearchNode {
    pub state: LimbState,
    /// Ends of the segments in the world (m).
    pub ends: [DVec3; LIMB_JOINTS],
    pub parent: u32,
}

impl SearchNode {
    /// Distance in the paper's metric (m).
    pub fn distance(&self, other: &Self, weights: &MetricWeights) -> f64 {
        weights.time * (self.state.time_s - other.state.time_s).abs() + weights.place * self.end_distance(other)
    }

    /// Largest distance between ends: max_i |p_i1 - p_i2| (m).
    pub fn end_distance(&self, other: &Self) -> f64 {
        let squares = self.ends.iter().zip(&other.ends).map(|(a, b)| a.distance_squared(*b));
        squares.fold(0.0, f64::max).sqrt()
    }
}

/// A tree that grows from one end of the problem.
#[derive(Clone, Debug, Default)]
pub(crate) struct SearchTree {
    pub nodes: Vec<SearchNode>,
    /// True for the tree at the goal, which grows backwards in time.
    pub from_goal: bool,
}

impl SearchTree {
    /// Clears the tree, and sets its root.
    pub fn reset(&mut self, root: SearchNode, from_goal: bool) {
        self.nodes.clear();
        self.nodes.push(SearchNode { parent: 0, ..root });
        self.from_goal = from_goal;
    }

    pub fn add(&mut self, node: SearchNode) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// The nearest node to `at` among those from which it can be reached in time; the root is always one.
    pub fn nearest_node(&self, at: &SearchNode, weights: &MetricWeights) -> usize {
        let mut best = (f64::INFINITY, 0);
        let time_s = at.state.time_s;
        let may_grow =
            |n: &SearchNode| if self.from_goal { time_s <= n.state.time_s } else { time_s >= n.state.time_s };
        for (i, node) in self.nodes.iter().enumerate().filter(|(_, n)| may_grow(n)) {
            // Time alone often shows that a node is farther.
            if weights.time * (node.state.time_s - time_s).abs() < best.0 {
                let d = node.distance(at, weights);
                if d < best.0 {
                    best = (d, i);
                }
            }
        }
        best.1
    }

    /// Appends the states from a node to the root.
    pub fn append_path_to_root(&self, mut node: usize, out: &mut Vec<LimbState>) {
        while node != 0 {
            out.push(self.nodes[node].state);
            node = self.nodes[node].parent as usize;
        }
        out.push(self.nodes[0].state);
    }
}

/// A node of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoggedNode {
    /// Position of the end of the hand or foot (m).
    pub tip: DVec3,
    /// Time (s).
    pub time_s: f64,
    /// Index of the node that it was reached from; the root's is its own.
    pub parent: usize,
}

/// Both trees of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedTrees {
    /// Times of start and goal (s).
    pub window_s: [f64; 2],
    /// The tree at the start, and that at the goal.
    pub trees: [Vec<LoggedNode>; 2],
    /// True where the trees met.
    pub is_solved: bool,
}

/// Collects the trees of all searches that it is passed to.
#[derive(Debug, Default)]
pub struct TreeLog(Mutex<Vec<LoggedTrees>>);

impl TreeLog {
    /// Keeps the trees of the last plan.
    pub(crate) fn keep(&self, problem: &Problem, planner: &LimbPlanner) {
        let node = |n: &SearchNode| LoggedNode { tip: n.ends[2], time_s: n.state.time_s, parent: n.parent as usize };
        let trees = planner.search().nodes().map(|nodes| nodes.iter().map(node).collect());
        let window_s = [problem.init.time_s, problem.goal.time_s];
        let grown = LoggedTrees { window_s, trees, is_solved: planner.motion().is_some() };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(grown);
    }

    /// Takes the trees kept since the last call, in their order.
    pub fn take(&self) -> Vec<LoggedTrees> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
