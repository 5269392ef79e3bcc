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
    /// Calls `visit` with every step that is looked at from a node, and with what stands for many steps at once.
    fn for_each_step(&mut self, graph: &WorldGraph<'_>, node: Node, mut visit: impl FnMut(&mut Self, Step)) {
        graph.for_each_step(node, |step| visit(self, step));
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

/// Memory of searches over nodes.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// Where each instance's nodes are in the arrays below, and the search that put them there.
    places: Vec<(u32, u32)>,
    used: usize,
    costs: Vec<f32>,
    stamps: Vec<u32>,
    parents: Vec<u32>,
    /// The step that led to each.
    steps: Vec<Step>,
    heap: Heap,
    stamp: u32,
    /// Nodes opened by the last search.
    pub opened: usize,
}

impl Nodes {
    /// Room for searches over at most `limit` nodes at once.
    pub fn new(graph: &WorldGraph<'_>, limit: usize) -> Self {
        let room = graph.num_nodes().min(limit);
        Self {
            places: vec![(0, NONE); graph.num_instances()],
            used: 0,
            costs: vec![0.0; room],
            stamps: vec![0; room],
            parents: vec![0; room],
            steps: vec![Step::NONE; room],
            heap: Heap::new(room),
            stamp: 0,
            opened: 0,
        }
    }

    /// Looks for the cheapest way from a node to a target, opening at most `most` nodes.
    pub fn search(&mut self, graph: &WorldGraph<'_>, from: Node, space: &mut impl Space, most: usize) -> Found {
        self.begin();
        let Some(first) = self.place(graph, from, space) else {
            return Found::Limit;
        };
        self.reach(first, 0.0, NONE, Step { to: from, ..Step::NONE }, 0.0);
        let mut full = false;
        while let Some((_, at)) = self.heap.pop() {
            let node = self.steps[at as usize].to;
            if space.is_target(node) {
                return Found::Way(at);
            }
            if self.opened == most {
                return Found::Limit;
            }
            self.opened += 1;
            let cost = self.costs[at as usize];
            space.for_each_step(graph, node, |space, step| {
                let total = cost + space.cost(&step);
                match self.place(graph, step.to, space) {
                    Some(to) if self.stamps[to as usize] != self.stamp || total < self.costs[to as usize] => {
                        let estimate = space.estimate(step.to);
                        if estimate < f32::INFINITY {
                            self.reach(to, total, at, step, estimate);
                        }
                    }
                    Some(_) => {}
                    None => full |= space.admits(step.to.instance),
                }
            });
        }
        if full { Found::Limit } else { Found::Nothing }
    }

    /// Writes the first steps of a way, as many as there is room for, and returns how many it has.
    pub fn path(&self, way: u32, out: &mut [Step]) -> usize {
        let mut len = 0;
        self.walk(way, |_| len += 1);
        let mut at = len;
        self.walk(way, |step| {
            at -= 1;
            if let Some(slot) = out.get_mut(at) {
                *slot = *step;
            }
        });
        len
    }

    /// Calls `visit` with every step of a way, the last one first.
    pub fn walk<'s>(&'s self, way: u32, mut visit: impl FnMut(&'s Step)) {
        let mut at = way;
        while self.parents[at as usize] != NONE {
            visit(&self.steps[at as usize]);
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
        (next != NONE).then(|| (next, self.steps[next as usize]))
    }

    /// Cost of a way. [Unit: frames]
    pub fn cost(&self, way: u32) -> f32 {
        self.costs[way as usize]
    }

    fn begin(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.places.fill((0, NONE));
            self.stamp = 1;
        }
        self.used = 0;
        self.opened = 0;
        self.heap.clear();
    }

    fn reach(&mut self, at: u32, cost: f32, parent: u32, step: Step, estimate: f32) {
        let i = at as usize;
        self.stamps[i] = self.stamp;
        self.costs[i] = cost;
        self.parents[i] = parent;
        self.steps[i] = step;
        self.heap.push(at, cost + estimate);
    }

    /// Where a node is in the arrays; the nodes of an instance get their places when the first of them is met.
    fn place(&mut self, graph: &WorldGraph<'_>, node: Node, space: &impl Space) -> Option<u32> {
        let (stamp, first) = self.places[node.instance as usize];
        if stamp == self.stamp {
            return (first != NONE).then(|| first + node.cell);
        }
        let num_cells = graph.num_cells(node.instance) as usize;
        let fits = self.used + num_cells <= self.costs.len() && space.admits(node.instance);
        let first = if fits { self.used as u32 } else { NONE };
        self.used += if fits { num_cells } else { 0 };
        self.places[node.instance as usize] = (self.stamp, first);
        (first != NONE).then(|| first + node.cell)
    }
}
