//! Path planning in two layers (Lee, Choi and Lee 2006, section 7): over the entrances and exits of structures on open
//! ground, then over the motion itself, towards what the upper layer estimates as near.

mod inside;
mod next_entrances;
mod nodes;
mod target_location;
#[cfg(test)]
mod tests;
mod upper;

use super::path_hierarchy::PathHierarchy;
use super::{WorldGraph, WorldNode, WorldStep};
pub(crate) use nodes::{Nodes, SearchResult, SearchSpace};
use serde::{Deserialize, Serialize};
use upper::UpperSearch;

/// A path of [`WorldPlanner::plan`] takes at most this many times as long as the fastest one.
pub const WORST: f32 = 1.05;

/// Target of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlanTarget {
    /// A single node.
    Node(WorldNode),
    /// Any rest cell of an instance.
    Rest {
        /// The instance.
        instance: u32,
    },
    /// Any start of motion with a tag.
    Tag {
        /// The instance.
        instance: u32,
        /// See [`throng_core::patch::LinkRecord::tag`].
        tag: u16,
    },
}

impl PlanTarget {
    /// The instance that it is in.
    pub fn instance(&self) -> u32 {
        match *self {
            Self::Node(node) => node.instance,
            Self::Rest { instance } | Self::Tag { instance, .. } => instance,
        }
    }

    /// True where the world has what is named.
    pub(crate) fn exists(&self, graph: &WorldGraph) -> bool {
        let has_cell = |node: WorldNode| node.cell < graph.num_cells(node.instance);
        (self.instance() as usize) < graph.num_instances() && !matches!(*self, Self::Node(n) if !has_cell(n))
    }

    /// True where a node is what was meant.
    pub fn is_at(&self, graph: &WorldGraph, node: WorldNode) -> bool {
        match *self {
            Self::Node(n) => n == node,
            Self::Rest { instance } => node.instance == instance && graph.is_rest(node),
            Self::Tag { instance, tag } => node.instance == instance && graph.can_begin_tag(node, tag),
        }
    }
}

/// A path that was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorldPlan {
    /// Steps of the whole path.
    pub num_steps: usize,
    /// Number of steps written, the first ones.
    pub num_stored: usize,
    /// Time it takes (frames).
    pub num_frames: u32,
    /// Sum of the distances from the start to the end of what is played (m).
    pub length_m: f32,
    /// Lower bound of the time (frames).
    pub least_frames: u32,
    /// Portals and entrances opened in the upper layer.
    pub opened_instances: usize,
    /// Nodes opened in the lower layer.
    pub opened_nodes: usize,
}

/// Plans paths through a world; all its memory is allocated when it is made.
#[derive(Clone, Debug)]
pub struct WorldPlanner {
    upper: UpperSearch,
    pub(crate) nodes: Nodes,
}

impl WorldPlanner {
    /// Memory for a world. The tables of the world are computed by the first planner and kept with it.
    pub fn new(graph: &WorldGraph) -> Self {
        Self { upper: UpperSearch::new(graph, graph.hierarchy()), nodes: Nodes::new(graph) }
    }

    /// Finds a path from a node to a target that takes at most [`WORST`] times as long as the fastest one, and writes
    /// as many of its first steps as fit; a path to its own start has none. Allocates nothing.
    ///
    /// - returns `None` where no path leads there.
    ///
    /// (nodes and instances exist)
    pub fn plan(
        &mut self,
        graph: &WorldGraph,
        from: WorldNode,
        target: PlanTarget,
        out: &mut [WorldStep],
    ) -> Option<WorldPlan> {
        let plan = self.plan_soon(graph, from, target, out)?;
        let (hierarchy, enough) = (graph.hierarchy(), plan.num_frames as f32 / WORST);
        let least_frames = plan.least_frames.max(enough.ceil() as u32);
        if plan.least_frames as f32 >= enough {
            return Some(plan);
        }
        // Proves that no path takes so much less, or finds the fastest one. All nodes are opened through which such a
        // path might lead, and no others: of A* with estimates weighted by as much as the first path may be worse (Pohl
        // 1970), they would only be a part (Thayer and Ruml 2008).
        let (mut opened_instances, mut opened_nodes) = (plan.opened_instances, plan.opened_nodes);
        if self.upper.limit < enough {
            self.upper.run(graph, target, from, enough);
            opened_instances += self.upper.opened;
        }
        let (upper, toll) = (&mut self.upper, &|_: u32| 0.0);
        let mut path = TowardsTarget { graph, hierarchy, target, greed: 1.0, limit: enough, upper, toll };
        let found = self.nodes.search(graph, from, &mut path, usize::MAX);
        opened_nodes += self.nodes.opened;
        let SearchResult::Path(path) = found else {
            return Some(WorldPlan { opened_nodes, opened_instances, least_frames, ..plan });
        };
        let plan = self.report(graph, path, out);
        Some(WorldPlan { opened_nodes, opened_instances, least_frames: plan.num_frames, ..plan })
    }

    /// Finds a path in less time, which may be worse. [`WorldPlan::least_frames`] bounds by how much.
    pub fn plan_soon(
        &mut self,
        graph: &WorldGraph,
        from: WorldNode,
        target: PlanTarget,
        out: &mut [WorldStep],
    ) -> Option<WorldPlan> {
        self.plan_around(graph, from, target, &|_| 0.0, &[(HASTE, usize::MAX)], out)
    }

    /// Lower bound of the time of the path from a node to a target, from the tables of the world (frames); `None` where
    /// it is plain that no path leads there.
    pub(crate) fn least_frames(&mut self, graph: &WorldGraph, from: WorldNode, target: PlanTarget) -> Option<f32> {
        let leads = self.upper.run(graph, target, from, 0.0);
        leads.then(|| self.upper.estimate(graph.hierarchy(), from).min(self.upper.limit))
    }

    /// Finds a path as [`WorldPlanner::plan_soon`] does, with a toll for entering instances, which counts as time (frames).
    ///
    /// - `tries`: weights of estimates, each with the most opened nodes; see [`TOLL_TRIES`].
    pub(crate) fn plan_around(
        &mut self,
        graph: &WorldGraph,
        from: WorldNode,
        target: PlanTarget,
        toll: &impl Fn(u32) -> f32,
        tries: &[(f32, usize)],
        out: &mut [WorldStep],
    ) -> Option<WorldPlan> {
        let (hierarchy, mut opened_nodes, mut opened_instances) = (graph.hierarchy(), 0, 0);
        let mut wide = 0.0;
        loop {
            if !self.upper.run(graph, target, from, wide) {
                return None;
            }
            opened_instances += self.upper.opened;
            let least = self.upper.estimate(hierarchy, from).min(self.upper.limit);
            let mut cost = f32::INFINITY;
            for &(greed, most) in tries {
                let (upper, limit) = (&mut self.upper, f32::INFINITY);
                let mut path = TowardsTarget { graph, hierarchy, target, greed, limit, upper, toll };
                let found = self.nodes.search(graph, from, &mut path, most);
                opened_nodes += self.nodes.opened;
                if let SearchResult::Path(path) = found {
                    cost = self.nodes.cost(path);
                    let plan = self.report(graph, path, out);
                    // A path around what it pays for may be far from the best ones.
                    if wide == 0.0 && cost > plan.num_frames as f32 && cost > self.upper.limit {
                        break;
                    }
                    let least_frames = (least.ceil() as u32).min(plan.num_frames);
                    return Some(WorldPlan { opened_nodes, opened_instances, least_frames, ..plan });
                }
            }
            // Without a path among the best ones, the search is repeated everywhere.
            if wide == f32::INFINITY {
                return None;
            }
            wide = cost;
        }
    }

    /// Writes the steps of a path that was found.
    fn report(&mut self, graph: &WorldGraph, path: u32, out: &mut [WorldStep]) -> WorldPlan {
        let mut plan = WorldPlan::default();
        let mut at = self.nodes.reverse_path(path);
        while let Some((next, step)) = self.nodes.next_step(at) {
            if let Some(slot) = out.get_mut(plan.num_steps) {
                *slot = step;
                plan.num_stored += 1;
            }
            plan.num_steps += 1;
            plan.num_frames += step.num_frames();
            plan.length_m += graph.step_length(&step);
            at = next;
        }
        plan
    }
}

/// Weight of estimates in the search for a first path (weighted A*, Pohl 1970).
const HASTE: f32 = 1.12;
/// Weights of estimates and most opened nodes where there are tolls, which estimates ignore.
pub(crate) const TOLL_TRIES: [(f32, usize); 3] = [(HASTE, 4000), (1.5, 10000), (3.0, usize::MAX)];

/// The lower layer's space: everything, towards the target.
struct TowardsTarget<'a, T> {
    graph: &'a WorldGraph,
    hierarchy: &'a PathHierarchy,
    target: PlanTarget,
    /// Weight of estimates.
    greed: f32,
    /// Length from which paths are useless (frames).
    limit: f32,
    upper: &'a mut UpperSearch,
    toll: &'a T,
}

impl<T: Fn(u32) -> f32> SearchSpace for TowardsTarget<'_, T> {
    fn admits(&self, _: u32) -> bool {
        true
    }

    fn is_target(&self, node: WorldNode) -> bool {
        self.target.is_at(self.graph, node)
    }

    fn estimate(&mut self, node: WorldNode) -> f32 {
        self.greed * self.upper.estimate(self.hierarchy, node)
    }

    fn cost(&self, step: &WorldStep) -> f32 {
        let toll = if step.to.instance == step.instance { 0.0 } else { (self.toll)(step.to.instance) };
        step.num_frames() as f32 + toll
    }

    fn limit(&self) -> f32 {
        self.limit
    }

    fn opens_again(&self) -> bool {
        self.limit < f32::INFINITY
    }
}
