//! Records of search trees, for inspection.

use crate::planner::Planner;
use crate::problem::Problem;
use glam::DVec3;
use std::sync::{Mutex, PoisonError};

/// A node of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrownNode {
    /// Position of the end of the hand or foot (m).
    pub at: DVec3,
    /// Time (s).
    pub time_s: f64,
    /// Index of the node that it was reached from; the root's is its own.
    pub parent: usize,
}

/// Both trees of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Grown {
    /// Times of start and goal (s).
    pub window_s: [f64; 2],
    /// The tree at the start, and that at the goal.
    pub trees: [Vec<GrownNode>; 2],
    /// True where the trees met.
    pub is_solved: bool,
}

/// Collects the trees of all searches that it is passed to.
#[derive(Debug, Default)]
pub struct Trees(Mutex<Vec<Grown>>);

impl Trees {
    /// Keeps the trees of the last plan.
    pub(crate) fn keep(&self, problem: &Problem, planner: &Planner) {
        let last = problem.chain.len() - 1;
        let trees = planner.search().nodes().map(|nodes| {
            let node = |n: &super::tree::Node| GrownNode {
                at: n.ends[last],
                time_s: n.state.time_s,
                parent: n.parent as usize,
            };
            nodes.iter().map(node).collect()
        });
        let window_s = [problem.init.time_s, problem.goal.time_s];
        let grown = Grown { window_s, trees, is_solved: planner.motion().is_some() };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(grown);
    }

    /// Takes the trees kept since the last call, in their order.
    pub fn take(&self) -> Vec<Grown> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
