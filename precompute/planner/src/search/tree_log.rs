//! Records of search trees, for inspection.

use super::tree::SearchNode;
use crate::planner::LimbPlanner;
use crate::problem::Problem;
use glam::DVec3;
use std::sync::{Mutex, PoisonError};

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
