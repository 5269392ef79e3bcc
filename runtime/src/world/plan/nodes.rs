//! The lower layer: A* over nodes, in memory that is used again by every search.

use super::heap::Heap;
use crate::patch::NONE;
use crate::world::{Node, Step, WorldGraph};

/// What a search is about.
pub(crate) trait Space {
    /// True where the search may go into an instance.
    fn admits(&self, instance: u32) -> bool;
    /// True where it ends.
    fn is_target(&self, node: Node) -> bool;
    /// What it costs to go on from a node to the target; infinite where no way leads there. [Unit: frames]
    fn estimate(&mut self, node: Node) -> f32;
    /// What a step costs. [Unit: frames]
    fn cost(&self, step: &Step) -> f32;
    /// True where a node is opened again when a cheaper way to it turns up: only then is a way as good as estimates
    /// promise which do not agree with each other, but it may take long.
    fn opens_again(&self) -> bool {
        true
    }
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// At a target; the number is for [`Nodes::path`].
    Way(u32),
    /// There is none.
    Nothing,
    /// After the most nodes that it may open.
    Limit,
}

/// Memory of searches over nodes: of all nodes of a world, touched only as far as searches go.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    costs: Vec<f32>,
    stamps: Vec<u32>,
    parents: Vec<u32>,
    /// The step that led to each, as whole numbers: memory full of zeros costs nothing.
    steps: Vec<[u32; 5]>,
    /// The search that opened each.
    opened_by: Vec<u32>,
    heap: Heap,
    stamp: u32,
    /// Nodes opened by the last search.
    pub opened: usize,
}

impl Nodes {
    /// Memory for a world. [Size: 44 bytes a node]
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        let room = graph.num_nodes();
        Self {
            costs: vec![0.0; room],
            stamps: vec![0; room],
            opened_by: vec![0; room],
            parents: vec![0; room],
            steps: vec![[0; 5]; room],
            heap: Heap::new(room),
            stamp: 0,
            opened: 0,
        }
    }

    /// Looks for the cheapest way from a node to a target, opening at most `most` nodes.
    pub fn search(&mut self, graph: &WorldGraph<'_>, from: Node, space: &mut impl Space, most: usize) -> Found {
        self.begin();
        self.reach(graph.index(from) as u32, 0.0, NONE, Step { to: from, ..Step::NONE }, 0.0);
        while let Some((_, at)) = self.heap.pop() {
            let node = self.step(at).to;
            if space.is_target(node) {
                return Found::Way(at);
            }
            if self.opened == most {
                return Found::Limit;
            }
            self.opened += 1;
            self.opened_by[at as usize] = self.stamp;
            let cost = self.costs[at as usize];
            graph.for_each_step(node, |step| {
                let (total, to) = (cost + space.cost(&step), graph.index(step.to));
                let done = self.opened_by[to] == self.stamp && !space.opens_again();
                let known = done || self.stamps[to] == self.stamp && total >= self.costs[to];
                if known || !space.admits(step.to.instance) {
                    return;
                }
                let estimate = space.estimate(step.to);
                if estimate < f32::INFINITY {
                    self.reach(to as u32, total, at, step, estimate);
                }
            });
        }
        Found::Nothing
    }

    /// Writes the first steps of a way, as many as there is room for, and returns how many it has.
    pub fn path(&self, way: u32, out: &mut [Step]) -> usize {
        let mut len = 0;
        self.walk(way, |_| len += 1);
        let mut at = len;
        self.walk(way, |step| {
            at -= 1;
            if let Some(slot) = out.get_mut(at) {
                *slot = step;
            }
        });
        len
    }

    /// Calls `visit` with every step of a way, the last one first.
    pub fn walk(&self, way: u32, mut visit: impl FnMut(Step)) {
        let mut at = way;
        while self.parents[at as usize] != NONE {
            visit(self.step(at));
            at = self.parents[at as usize];
        }
    }

    /// Turns a way around, so that it can be followed from its beginning with [`Nodes::next`]; it is no way any more.
    pub fn turn(&mut self, way: u32) -> u32 {
        let (mut at, mut after) = (way, NONE);
        while at != NONE {
            after = std::mem::replace(&mut self.parents[at as usize], after);
            std::mem::swap(&mut at, &mut after);
        }
        after
    }

    /// The step that follows on a way that was turned around, and where it leads to.
    pub fn next(&self, at: u32) -> Option<(u32, Step)> {
        let next = self.parents[at as usize];
        (next != NONE).then(|| (next, self.step(next)))
    }

    /// Cost of a way. [Unit: frames]
    pub fn cost(&self, way: u32) -> f32 {
        self.costs[way as usize]
    }

    fn begin(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.opened_by.fill(0);
            self.stamp = 1;
        }
        self.opened = 0;
        self.heap.clear();
    }

    fn reach(&mut self, at: u32, cost: f32, parent: u32, step: Step, estimate: f32) {
        let i = at as usize;
        self.stamps[i] = self.stamp;
        self.costs[i] = cost;
        self.parents[i] = parent;
        let offsets = u32::from(step.from_offset) << 16 | u32::from(step.to_offset);
        self.steps[i] = [step.to.instance, step.to.cell, step.instance, step.link, offsets];
        self.heap.push(at, cost + estimate);
    }

    /// The step that led to a node.
    fn step(&self, at: u32) -> Step {
        let [to, cell, instance, link, offsets] = self.steps[at as usize];
        let (from_offset, to_offset) = ((offsets >> 16) as u16, offsets as u16);
        Step { to: Node { instance: to, cell }, instance, link, from_offset, to_offset }
    }
}
