//! The lower layer: A* over nodes, in memory that is used again by every search.

use crate::{WorldGraph, WorldNode, WorldStep, graph::StepVisitor, queue::Heap};
use bytemuck::{Pod, Zeroable};
use throng_core::patch::NONE;

/// Space of a search: its instances, target and costs.
pub(crate) trait SearchSpace {
    /// True where the search may go into an instance.
    fn admits(&self, instance: u32) -> bool;
    /// True where it ends.
    fn is_target(&self, node: WorldNode) -> bool;
    /// Estimated cost from a node to the target; infinite where no path leads there (frames).
    fn estimate(&mut self, _: WorldNode) -> f32 {
        0.0
    }
    /// Cost of a step (frames).
    fn cost(&self, step: &WorldStep) -> f32;
    /// Cost, with the estimate, from which paths are left out (frames).
    fn limit(&self) -> f32 {
        f32::INFINITY
    }
    /// True where a node is opened again when a cheaper path to it turns up: only then is a path as good as estimates
    /// promise which do not agree with each other, but it may take long.
    fn opens_again(&self) -> bool {
        true
    }
}

/// Result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SearchResult {
    /// A path to a target; the number is for [`Nodes::write_path`].
    Path(u32),
    /// No path leads to a target.
    Nothing,
    /// The most nodes were opened.
    Limit,
}

/// Memory of searches over nodes: of all nodes of a world, touched only as far as searches go.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// [`NodeState`] of each node.
    states: Vec<[u32; 4]>,
    /// Node before each, or after it on a path that was turned around.
    parents: Vec<u32>,
    /// The step that led to each; as whole numbers, since memory full of zeros costs nothing.
    steps: Vec<[u32; 5]>,
    heap: Heap,
    stamp: u32,
    /// Nodes opened by the last search.
    pub opened: usize,
}

/// State of a node: in one place, since every step there needs it.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct NodeState {
    /// The search that came to it, an even number, and 1 where it was opened.
    stamp: u32,
    /// Costs of the best path there, and from there on; not a number where not yet needed (frames).
    cost: f32,
    estimate: f32,
    /// Cost of the best path there when the links from it were followed; infinite before (frames).
    left: f32,
}

impl NodeState {
    /// State of a node that was not reached.
    fn new(stamp: u32) -> Self {
        Self { stamp, cost: f32::INFINITY, estimate: f32::NAN, left: f32::INFINITY }
    }
}

impl Nodes {
    /// Memory for a world (52 bytes a node).
    pub fn new(graph: &WorldGraph) -> Self {
        let room = graph.num_nodes();
        let (states, parents, steps) = (vec![[0; 4]; room], vec![0; room], vec![[0; 5]; room]);
        Self { states, parents, steps, heap: Heap::new(room), stamp: 0, opened: 0 }
    }

    /// Finds the cheapest path from a node to a target, opening at most `most` nodes.
    pub fn search(
        &mut self,
        graph: &WorldGraph,
        from: WorldNode,
        space: &mut impl SearchSpace,
        most: usize,
    ) -> SearchResult {
        self.begin();
        let start = NodeState { cost: 0.0, estimate: 0.0, ..NodeState::new(self.stamp) };
        let step = WorldStep { to: from, ..WorldStep::NONE };
        self.reach_node(graph.index(from) as u32, start, NONE, &step, f32::INFINITY);
        while let Some((_, at)) = self.heap.pop() {
            let node = self.step(at).to;
            if space.is_target(node) {
                return SearchResult::Path(at);
            }
            if self.opened == most {
                return SearchResult::Limit;
            }
            self.opened += 1;
            let state = self.state(at);
            self.states[at as usize] = bytemuck::cast(NodeState { stamp: self.stamp | 1, ..state });
            let cost = state.cost;
            graph.visit_steps(node, &mut NodeOpening { nodes: self, graph, space, at, cost });
        }
        SearchResult::Nothing
    }

    /// Writes the first steps of a path, as many as fit, and returns how many it has.
    pub fn write_path(&self, path: u32, out: &mut [WorldStep]) -> usize {
        let nodes = std::iter::successors(Some(path), |&at| Some(self.parents[at as usize]));
        // The last step comes first, and none leads to the start.
        let reached = nodes.take_while(|&at| self.parents[at as usize] != NONE);
        let len = reached.clone().count();
        for (place, at) in (0..len).rev().zip(reached) {
            if let Some(slot) = out.get_mut(place) {
                *slot = self.step(at);
            }
        }
        len
    }

    /// Turns a path around, so that it can be followed from its beginning with [`Nodes::next_step`]; it is no longer a path
    /// for the other functions.
    pub fn reverse_path(&mut self, path: u32) -> u32 {
        let (mut at, mut after) = (path, NONE);
        while at != NONE {
            after = std::mem::replace(&mut self.parents[at as usize], after);
            std::mem::swap(&mut at, &mut after);
        }
        after
    }

    /// The step that follows on a path that was turned around, and where it leads to.
    pub fn next_step(&self, at: u32) -> Option<(u32, WorldStep)> {
        let next = self.parents[at as usize];
        (next != NONE).then(|| (next, self.step(next)))
    }

    /// Cost of a path (frames).
    pub fn cost(&self, path: u32) -> f32 {
        self.state(path).cost
    }

    fn begin(&mut self) {
        self.stamp = self.stamp.wrapping_add(2);
        if self.stamp == 0 {
            self.states.fill([0; 4]);
            self.stamp = 2;
        }
        self.opened = 0;
        self.heap.clear();
    }

    /// State of a node in this search.
    fn state(&self, at: u32) -> NodeState {
        let state: NodeState = bytemuck::cast(self.states[at as usize]);
        if state.stamp & !1 == self.stamp { state } else { NodeState::new(self.stamp) }
    }

    /// Notes the best path to a node so far, which is followed where it may cost less than `limit`.
    fn reach_node(&mut self, at: u32, state: NodeState, parent: u32, step: &WorldStep, limit: f32) {
        let i = at as usize;
        self.states[i] = bytemuck::cast(state);
        let key = state.cost + state.estimate;
        if key >= limit {
            return;
        }
        self.parents[i] = parent;
        let offsets = u32::from(step.from_offset) << 16 | u32::from(step.to_offset);
        self.steps[i] = [step.to.instance, step.to.cell, step.instance, step.link, offsets];
        self.heap.push(at, key);
    }

    /// The step that led to a node.
    fn step(&self, at: u32) -> WorldStep {
        let [to, cell, instance, link, offsets] = self.steps[at as usize];
        let (from_offset, to_offset) = ((offsets >> 16) as u16, offsets as u16);
        WorldStep { to: WorldNode { instance: to, cell }, instance, link, from_offset, to_offset }
    }
}

/// A node that is opened.
struct NodeOpening<'a, S> {
    nodes: &'a mut Nodes,
    graph: &'a WorldGraph,
    space: &'a mut S,
    at: u32,
    cost: f32,
}

impl<S: SearchSpace> StepVisitor for NodeOpening<'_, S> {
    /// Follows the links of a cell once: where blocks overlap, many cells are joined to the same one.
    fn follows_links_of(&mut self, from: WorldNode) -> bool {
        let at = self.graph.index(from) as u32;
        let state = self.nodes.state(at);
        let first = self.cost < state.left;
        if first {
            self.nodes.states[at as usize] = bytemuck::cast(NodeState { left: self.cost, ..state });
        }
        first
    }

    fn visit_step(&mut self, step: WorldStep) {
        let (total, to) = (self.cost + self.space.cost(&step), self.graph.index(step.to) as u32);
        let mut state = self.nodes.state(to);
        if total >= state.cost || state.stamp & 1 == 1 && !self.space.opens_again() {
            return;
        }
        if state.estimate.is_nan() {
            if !self.space.admits(step.to.instance) {
                return;
            }
            state.estimate = self.space.estimate(step.to);
        }
        state.cost = total;
        self.nodes.reach_node(to, state, self.at, &step, self.space.limit());
    }
}
