//! Algorithm 1 of the paper.

use super::grid::TimeGrid;
use super::tree::{Node, Tree, Weights};
use crate::collide::{Checker, EdgeCheck};
use crate::limits::{Sampler, Style};
use crate::problem::{Problem, State};
use crate::rotation::slerp;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// How the search goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchConfig {
    /// How far a tree grows at a time, in the metric (m, > 0).
    pub epsilon_m: f64,
    /// Of the metric.
    pub weights: Weights,
    /// How ways are looked at.
    pub edge: EdgeCheck,
    /// After so many draws poses are sampled from all of their ranges (> 0).
    pub widen_over: u32,
    /// Angles that the user wants.
    pub style: Style,
}

impl Default for SearchConfig {
    fn default() -> Self {
        Self {
            epsilon_m: 0.25,
            weights: Weights { time: 0.3, place: 1.0 },
            edge: EdgeCheck::Conservative,
            widen_over: 200,
            style: Style::default(),
        }
    }
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// A way.
    Way,
    /// None, within the draws and time there were.
    Nothing,
    /// It was told to stop.
    Cancelled,
}

/// Two trees; kept from search to search, so that nothing is allocated after the first one of its size.
#[derive(Clone, Debug, Default)]
pub struct Search {
    trees: [Tree; 2],
    /// Landmarks of the way that was found, from the start to the goal.
    pub way: Vec<State>,
    /// Samples drawn.
    pub draws: u32,
    /// Least distance between the trees where one could have gone on in the other, by places alone (m).
    pub nearest_m: f64,
}

/// What is searched, and how.
#[derive(Clone, Copy)]
pub(crate) struct Quest<'a> {
    pub problem: &'a Problem,
    pub config: &'a SearchConfig,
    pub grid: TimeGrid,
    /// Most samples.
    pub draws: u32,
}

/// What all steps of one search need.
struct Step<'a> {
    quest: Quest<'a>,
    problem: &'a Problem,
    sampler: Sampler,
}

impl Search {
    /// Number of nodes of both trees.
    pub fn num_nodes(&self) -> usize {
        self.trees.iter().map(|t| t.nodes.len()).sum()
    }

    /// Nodes of the tree at the start and of that at the goal: states, and indices of their parents.
    pub fn trees(&self) -> [impl Iterator<Item = (&State, usize)>; 2] {
        self.nodes().map(|nodes| nodes.iter().map(|n| (&n.state, n.parent as usize)))
    }

    /// Of the tree at the start and of that at the goal.
    pub(crate) fn nodes(&self) -> [&[Node]; 2] {
        let [a, b] = &self.trees;
        let (init, goal) = if a.from_goal { (b, a) } else { (a, b) };
        [init, goal].map(|t| &t.nodes[..])
    }

    /// SYNCPLANNER of the paper.
    ///
    /// - `keep_on`: asked after each of them: something else than `Way` stops the search.
    ///
    /// # Source
    /// Shapiro, Kallmann and Faloutsos 2007, algorithm 1. Differs: landmarks are on frames; only nodes from which a sample
    /// lies ahead in time are its nearest; a tree grows no faster than the joints' speed limits, and not to where no time
    /// would be left.
    pub(crate) fn run(
        &mut self,
        quest: Quest<'_>,
        checker: &mut Checker,
        rng: &mut Pcg64Mcg,
        mut keep_on: impl FnMut() -> Option<Found>,
    ) -> Found {
        let Quest { problem, config, draws, .. } = quest;
        let limits = *problem.limits();
        let sampler = Sampler::new(problem.chain.linkage, limits, &problem.init.pose, config.style, config.widen_over);
        let step = Step { quest, problem, sampler };
        let [init, goal] = [&problem.init, &problem.goal].map(|s| step.node(*s, 0));
        self.trees[0].plant(init, false);
        self.trees[1].plant(goal, true);
        self.way.clear();
        (self.draws, self.nearest_m) = (0, init.apart(&goal));
        while self.draws < draws {
            if let Some(stop) = keep_on() {
                return stop;
            }
            let Some(sample) = step.sample(&mut self.draws, checker, rng) else { return Found::Nothing };
            let [a, b] = &mut self.trees;
            let (near_a, near_b) = (a.nearest(&sample, &config.weights), b.nearest(&sample, &config.weights));
            if self.connect(&step, near_a, near_b, checker) {
                return Found::Way;
            }
            let [a, _] = &mut self.trees;
            if let Some(grown) = step.expand(a, near_a, &sample, checker) {
                let grown = a.add(grown);
                if self.connect(&step, grown, near_b, checker) {
                    return Found::Way;
                }
            }
            self.trees.swap(0, 1);
        }
        Found::Nothing
    }

    /// Joins a node of the first tree with one of the second, if the way between them is free.
    fn connect(&mut self, step: &Step<'_>, in_first: usize, in_second: usize, checker: &mut Checker) -> bool {
        let [a, b] = &self.trees;
        let (first, second) = (&a.nodes[in_first], &b.nodes[in_second]);
        let (from, to) = if a.from_goal { (second, first) } else { (first, second) };
        if from.state.time_s > to.state.time_s || !step.is_slow_enough(&from.state, &to.state) {
            return false;
        }
        self.nearest_m = self.nearest_m.min(from.apart(to));
        if !checker.is_way_free(step.problem, &from.state, &to.state, step.quest.config.edge) {
            return false;
        }
        let ((init, init_node), (goal, goal_node)) =
            if a.from_goal { ((b, in_second), (a, in_first)) } else { ((a, in_first), (b, in_second)) };
        init.to_root(init_node, &mut self.way);
        self.way.reverse();
        goal.to_root(goal_node, &mut self.way);
        true
    }
}

impl Step<'_> {
    fn node(&self, state: State, parent: u32) -> Node {
        let chain = &self.problem.chain;
        Node { state, ends: chain.ends(&self.problem.place(&state)), parent }
    }

    fn is_slow_enough(&self, from: &State, to: &State) -> bool {
        self.problem.least_time(&from.pose, &to.pose).0 <= to.time_s - from.time_s + 1e-9
    }

    /// A free state at random: a pose within limits, at a time at which it can be reached and left (4.2 of the paper).
    fn sample(&self, draws: &mut u32, checker: &mut Checker, rng: &mut Pcg64Mcg) -> Option<Node> {
        let (init, goal) = (&self.problem.init, &self.problem.goal);
        while *draws < self.quest.draws {
            let pose = self.sampler.draw(rng, *draws);
            let share: f64 = rng.random_range(0.0..1.0);
            *draws += 1;
            let first = self.quest.grid.from(init.time_s + self.problem.least_time(&init.pose, &pose).0);
            let last = self.quest.grid.until(goal.time_s - self.problem.least_time(&pose, &goal.pose).0);
            let Some(last) = last.filter(|last| *last >= first) else { continue };
            let frame = first + (share * (last - first + 1) as f64) as usize;
            let state = State { pose, time_s: self.quest.grid.at(frame.min(last)) };
            if checker.is_free(self.problem, &state) {
                return Some(self.node(state, 0));
            }
        }
        None
    }

    /// A new node on the way from one of a tree to a sample, if that way is free.
    fn expand(&self, tree: &Tree, near: usize, sample: &Node, checker: &mut Checker) -> Option<Node> {
        let from = &tree.nodes[near];
        let d = from.distance(sample, &self.quest.config.weights);
        let share = if d > 0.0 { (self.quest.config.epsilon_m / d).min(1.0) } else { 1.0 };
        let mut pose = sample.state.pose;
        if share < 1.0 {
            for i in 0..self.problem.chain.len() {
                pose.0[i] = slerp(from.state.pose.0[i], sample.state.pose.0[i], share);
            }
        }
        let even = from.state.time_s + share * (sample.state.time_s - from.state.time_s);
        // No faster than joints turn, and with time left to get to the other end.
        let least = self.problem.least_time(&from.state.pose, &pose).0;
        let (init, goal) = (&self.problem.init, &self.problem.goal);
        let frame = if tree.from_goal {
            let latest = self.quest.grid.until(from.state.time_s - least)?;
            let frame = self.quest.grid.nearest(even).min(latest);
            let needed = self.problem.least_time(&init.pose, &pose).0;
            (self.quest.grid.at(frame) - init.time_s + 1e-9 >= needed).then_some(frame)?
        } else {
            let frame = self.quest.grid.nearest(even).max(self.quest.grid.from(from.state.time_s + least));
            let needed = self.problem.least_time(&pose, &goal.pose).0;
            (frame <= self.quest.grid.steps && goal.time_s - self.quest.grid.at(frame) + 1e-9 >= needed)
                .then_some(frame)?
        };
        let state = State { pose, time_s: self.quest.grid.at(frame) };
        let (a, b) = if tree.from_goal { (&state, &from.state) } else { (&from.state, &state) };
        if !checker.is_free(self.problem, &state) || !checker.is_way_free(self.problem, a, b, self.quest.config.edge) {
            return None;
        }
        Some(self.node(state, near as u32))
    }
}
