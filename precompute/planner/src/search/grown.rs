//! The trees of searches, to be looked at.

use crate::planner::Planner;
use crate::problem::Problem;
use glam::DVec3;
use std::sync::{Mutex, PoisonError};

/// A node of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrownNode {
    /// Where the end of the hand or foot is (m).
    pub at: DVec3,
    /// When (s).
    pub time_s: f64,
    /// The node that it was reached from; the root's is itself.
    pub parent: usize,
}

/// Both trees of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Grown {
    /// From the start to the goal (s).
    pub window_s: [f64; 2],
    /// The tree at the start, and that at the goal.
    pub trees: [Vec<GrownNode>; 2],
    /// True where they met.
    pub is_solved: bool,
}

/// Keeps the trees of all searches that it is given to.
#[derive(Debug, Default)]
pub struct Trees(Mutex<Vec<Grown>>);

impl Trees {
    /// Keeps those of the last plan.
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

    /// Those kept since the last call, in their order.
    pub fn take(&self) -> Vec<Grown> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
