//! The bidirectional search: algorithm 1 of the paper.

use super::grid::TimeGrid;
use super::tree::{MetricWeights, SearchNode, SearchTree};
use crate::limits::{PoseSampler, Style};
use crate::problem::{LimbState, Problem};
use crate::rotation::{Rigid, rotation_between};
use crate::{collide::Checker, ik::LimbIk};
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Settings of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchConfig {
    /// How far a tree grows at a time, in the metric (m, > 0).
    pub epsilon_m: f64,
    /// Weights of the metric.
    pub weights: MetricWeights,
    /// Number of draws after which poses are sampled from all of their ranges (> 0).
    pub widen_over: u32,
    /// Angles that the user wants.
    pub style: Style,
}

impl Default for SearchConfig {
    fn default() -> Self {
        let weights = MetricWeights { time: 0.3, place: 1.0 };
        Self { epsilon_m: 0.25, weights, widen_over: 200, style: Style::default() }
    }
}

/// Result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchOutcome {
    /// A path was found.
    Path,
    /// No path was found within the draws and time that there were.
    NoPath,
    /// The search was cancelled.
    Cancelled,
}

/// Two trees; kept from search to search, so that nothing is allocated after the first one of its size.
#[derive(Clone, Debug, Default)]
pub struct TreeSearch {
    trees: [SearchTree; 2],
    /// Landmarks of the path that was found, from the start to the goal.
    pub path: Vec<LimbState>,
    /// Samples drawn.
    pub draws: u32,
    /// Least distance between the trees where one could have gone on in the other, by places alone (m).
    pub nearest_m: f64,
    /// Nodes in which the trees met: of the tree at the start, and of that at the goal.
    met: Option<[u32; 2]>,
    /// A tree of the last search, and the new index of each of its nodes.
    old_nodes: Vec<SearchNode>,
    kept_nodes: Vec<Option<u32>>,
}

/// Inputs of a search.
#[derive(Clone, Copy)]
pub(crate) struct SearchRequest<'a> {
    pub problem: &'a Problem,
    pub config: &'a SearchConfig,
    pub grid: TimeGrid,
    /// Most samples.
    pub draws: u32,
    /// True begins with the trees of the last search, as far as they still hold.
    pub warm: bool,
}

/// Inputs shared by all steps of one search.
struct SearchContext<'a> {
    request: SearchRequest<'a>,
    problem: &'a Problem,
    sampler: PoseSampler,
    /// Inverse kinematics of the limb whose object stays upright.
    ik: Option<LimbIk>,
}

impl TreeSearch {
    /// Number of nodes of both trees.
    pub fn num_nodes(&self) -> usize {
        self.trees.iter().map(|t| t.nodes.len()).sum()
    }

    /// Nodes of the tree at the start and of that at the goal: states, and indices of their parents.
    pub fn trees(&self) -> [impl Iterator<Item = (&LimbState, usize)>; 2] {
        self.nodes().map(|nodes| nodes.iter().map(|n| (&n.state, n.parent as usize)))
    }

    /// Nodes of the tree at the start and of that at the goal.
    pub(crate) fn nodes(&self) -> [&[SearchNode]; 2] {
        let [a, b] = &self.trees;
        let (init, goal) = if a.from_goal { (b, a) } else { (a, b) };
        [init, goal].map(|t| &t.nodes[..])
    }

    /// Runs SYNCPLANNER of the paper.
    ///
    /// - `keep_on`: asked before each sample; a result that it returns stops the search.
    ///
    /// # Source
    /// Shapiro, Kallmann and Faloutsos 2007, algorithm 1. Differs: landmarks are on frames; only nodes from which a sample
    /// lies ahead in time are its nearest; a tree grows no faster than the joints' speed limits, and not to where no time
    /// would be left.
    pub(crate) fn run(
        &mut self,
        quest: SearchRequest<'_>,
        checker: &mut Checker,
        rng: &mut Pcg64Mcg,
        mut keep_on: impl FnMut() -> Option<SearchOutcome>,
    ) -> SearchOutcome {
        let SearchRequest { problem, config, draws, .. } = quest;
        let limits = problem.limits;
        let sampler = PoseSampler::new(limits, &problem.init.pose, config.style, config.widen_over);
        let ik = problem.upright.map(|_| LimbIk::new(&problem.chain, &limits));
        let step = SearchContext { request: quest, problem, sampler, ik };
        let [init, goal] = [&problem.init, &problem.goal].map(|s| step.node(*s, 0));
        self.path.clear();
        (self.draws, self.nearest_m) = (0, init.end_distance(&goal));
        if quest.warm {
            self.reuse_trees(&step, [init, goal], checker);
            if self.met.take().is_some_and(|[a, b]| self.connect(&step, a as usize, b as usize, checker)) {
                return SearchOutcome::Path;
            }
        } else {
            self.met = None;
            self.trees[0].reset(init, false);
            self.trees[1].reset(goal, true);
        }
        while self.draws < draws {
            if let Some(stop) = keep_on() {
                return stop;
            }
            let Some(sample) = step.sample_node(&mut self.draws, checker, rng) else { return SearchOutcome::NoPath };
            let [a, b] = &mut self.trees;
            let (near_a, near_b) = (a.nearest_node(&sample, &config.weights), b.nearest_node(&sample, &config.weights));
            if self.connect(&step, near_a, near_b, checker) {
                return SearchOutcome::Path;
            }
            let [a, _] = &mut self.trees;
            if let Some(grown) = step.expand(a, near_a, &sample, checker) {
                let grown = a.add(grown);
                if self.connect(&step, grown, near_b, checker) {
                    return SearchOutcome::Path;
                }
            }
            self.trees.swap(0, 1);
        }
        SearchOutcome::NoPath
    }

    /// Keeps the part of the last trees that still holds: nodes that are free, in time, and reached from a node that is kept.
    ///
    /// The nodes in which the last trees met become those of the new trees, where both are kept.
    fn reuse_trees(&mut self, step: &SearchContext<'_>, roots: [SearchNode; 2], checker: &mut Checker) {
        if self.trees[0].from_goal {
            self.trees.swap(0, 1);
        }
        for (k, (tree, root)) in self.trees.iter_mut().zip(roots).enumerate() {
            std::mem::swap(&mut self.old_nodes, &mut tree.nodes);
            tree.reset(root, k == 1);
            self.kept_nodes.clear();
            // A tree with another start or goal is not reused.
            let is_same = self.old_nodes.first().is_some_and(|n| n.state == root.state);
            self.kept_nodes.push(is_same.then_some(0));
            for node in self.old_nodes.iter().skip(1) {
                let kept = self.kept_nodes[node.parent as usize].and_then(|parent| {
                    let from = tree.nodes[parent as usize].state;
                    let holds = step.is_still_valid(&from, &node.state, k == 1, checker);
                    holds.then(|| tree.add(step.node(node.state, parent)) as u32)
                });
                self.kept_nodes.push(kept);
            }
            self.met = self.met.and_then(|mut ends| {
                ends[k] = *self.kept_nodes.get(ends[k] as usize)?.as_ref()?;
                Some(ends)
            });
        }
    }

    /// Joins a node of the first tree with one of the second, if the edge between them is free.
    fn connect(&mut self, step: &SearchContext<'_>, in_first: usize, in_second: usize, checker: &mut Checker) -> bool {
        let [a, b] = &self.trees;
        let (first, second) = (&a.nodes[in_first], &b.nodes[in_second]);
        let (from, to) = if a.from_goal { (second, first) } else { (first, second) };
        if from.state.time_s > to.state.time_s || !step.is_slow_enough(&from.state, &to.state) {
            return false;
        }
        self.nearest_m = self.nearest_m.min(from.end_distance(to));
        if !checker.is_edge_free(step.problem, &from.state, &to.state) {
            return false;
        }
        let ((init, init_node), (goal, goal_node)) =
            if a.from_goal { ((b, in_second), (a, in_first)) } else { ((a, in_first), (b, in_second)) };
        self.met = Some([init_node as u32, goal_node as u32]);
        init.append_path_to_root(init_node, &mut self.path);
        self.path.reverse();
        goal.append_path_to_root(goal_node, &mut self.path);
        true
    }
}

impl SearchContext<'_> {
    fn node(&self, state: LimbState, parent: u32) -> SearchNode {
        let chain = &self.problem.chain;
        SearchNode { state, ends: chain.segment_ends(&self.problem.place_chain(&state)), parent }
    }

    /// True where a node of the last search is still valid: it is free, and so is the edge from its parent.
    fn is_still_valid(&self, parent: &LimbState, state: &LimbState, from_goal: bool, checker: &mut Checker) -> bool {
        let grid = &self.request.grid;
        let is_on_grid = (grid.time_at(grid.nearest_frame(state.time_s)) - state.time_s).abs() < 1e-9;
        let (a, b) = if from_goal { (state, parent) } else { (parent, state) };
        is_on_grid
            && self.is_slow_enough(a, b)
            && checker.is_free(self.problem, state)
            && checker.is_edge_free(self.problem, a, b)
    }

    fn is_slow_enough(&self, from: &LimbState, to: &LimbState) -> bool {
        self.problem.least_time(&from.pose, &to.pose).0 <= to.time_s - from.time_s + 1e-9
    }

    /// The state with the hand at the same place, turned until the object that it holds is upright; `None` where no pose does
    /// that. Unchanged where nothing has to be upright.
    fn make_upright(&self, state: LimbState) -> Option<LimbState> {
        let (Some(level), Some(ik)) = (self.problem.upright, &self.ik) else { return Some(state) };
        let base = self.problem.base_at(state.time_s);
        let hand = self.problem.place_chain(&state)[2];
        let turn = rotation_between(hand.rotation * level.up, DVec3::Y);
        let upright = Rigid { rotation: turn * hand.rotation, ..hand };
        Some(LimbState { pose: ik.solve_free(&base, &upright, &state.pose).ok()?, ..state })
    }

    /// A free state at random: a pose within limits, at a time at which it can be reached and left (4.2 of the paper).
    fn sample_node(&self, draws: &mut u32, checker: &mut Checker, rng: &mut Pcg64Mcg) -> Option<SearchNode> {
        let (init, goal) = (&self.problem.init, &self.problem.goal);
        let grid = &self.request.grid;
        while *draws < self.request.draws {
            let pose = self.sampler.draw_pose(rng, *draws);
            let share: f64 = rng.random_range(0.0..1.0);
            *draws += 1;
            let first = grid.first_frame_from(init.time_s + self.problem.least_time(&init.pose, &pose).0);
            let last = grid.last_frame_until(goal.time_s - self.problem.least_time(&pose, &goal.pose).0);
            let Some(last) = last.filter(|last| *last >= first) else { continue };
            let frame = first + (share * (last - first + 1) as f64) as usize;
            let sample = LimbState { pose, time_s: grid.time_at(frame.min(last)) };
            let Some(state) = self.make_upright(sample) else { continue };
            if checker.is_free(self.problem, &state) {
                return Some(self.node(state, 0));
            }
        }
        None
    }

    /// A new node on the edge from a node of a tree towards a sample, if that edge is free.
    fn expand(&self, tree: &SearchTree, near: usize, sample: &SearchNode, checker: &mut Checker) -> Option<SearchNode> {
        let (from, grid) = (&tree.nodes[near], &self.request.grid);
        let d = from.distance(sample, &self.request.config.weights);
        let share = if d > 0.0 { (self.request.config.epsilon_m / d).min(1.0) } else { 1.0 };
        let (own, other) = (&from.state.pose, &sample.state.pose);
        let pose = if share < 1.0 { own.slerp(other, share) } else { *other };
        let even = from.state.time_s + share * (sample.state.time_s - from.state.time_s);
        // The new state is no farther than joints turn in time, and leaves time to get to the other end.
        let least = self.problem.least_time(&from.state.pose, &pose).0;
        let (init, goal) = (&self.problem.init, &self.problem.goal);
        let frame = if tree.from_goal {
            let latest = grid.last_frame_until(from.state.time_s - least)?;
            let frame = grid.nearest_frame(even).min(latest);
            let needed = self.problem.least_time(&init.pose, &pose).0;
            (grid.time_at(frame) - init.time_s + 1e-9 >= needed).then_some(frame)?
        } else {
            let frame = grid.nearest_frame(even).max(grid.first_frame_from(from.state.time_s + least));
            let needed = self.problem.least_time(&pose, &goal.pose).0;
            (frame <= grid.steps && goal.time_s - grid.time_at(frame) + 1e-9 >= needed).then_some(frame)?
        };
        let state = self.make_upright(LimbState { pose, time_s: grid.time_at(frame) })?;
        let (a, b) = if tree.from_goal { (&state, &from.state) } else { (&from.state, &state) };
        let is_free = checker.is_free(self.problem, &state) && checker.is_edge_free(self.problem, a, b);
        is_free.then(|| self.node(state, near as u32))
    }
}
