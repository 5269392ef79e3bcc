//! Path planning in two layers (004 section 7): over the ways into and out of what stands on open ground, then over the
//! motion itself, towards what the upper layer says is near.

mod end;
mod gates;
mod heap;
mod inside;
mod near;
mod nodes;
mod pace;
mod upper;

use super::atlas::Atlas;
use super::{Node, Step, WorldGraph};
pub(crate) use nodes::{Found, Nodes, Space};
use upper::Upper;

/// A way takes at most this many times as long as the fastest one: estimates are bounds, and what they count in the lower
/// layer is the price of its speed (weighted A*, Pohl 1970).
pub const GREED: f32 = 1.05;

/// Where a plan leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// To one node.
    Node(Node),
    /// To any rest cell of an instance.
    Rest {
        /// The instance.
        instance: u32,
    },
    /// To where motion with a tag begins.
    Tag {
        /// The instance.
        instance: u32,
        /// See [`crate::patch::LinkRecord::tag`].
        tag: u16,
    },
}

impl Target {
    /// The instance that it is in.
    pub fn instance(&self) -> u32 {
        match *self {
            Self::Node(node) => node.instance,
            Self::Rest { instance } | Self::Tag { instance, .. } => instance,
        }
    }

    /// True where a node is what was meant.
    pub fn is_at(&self, graph: &WorldGraph<'_>, node: Node) -> bool {
        match *self {
            Self::Node(n) => n == node,
            Self::Rest { instance } => node.instance == instance && graph.is_rest(node),
            Self::Tag { instance, tag } => node.instance == instance && graph.begins(node, tag),
        }
    }
}

/// A way that was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plan {
    /// Steps of the whole way.
    pub num_steps: usize,
    /// Steps that there was room for: the first ones.
    pub num_stored: usize,
    /// Time it takes. [Unit: frames]
    pub num_frames: u32,
    /// Sum of the distances from the start to the end of what is played. [Unit: m]
    pub length_m: f32,
    /// No way takes less. [Unit: frames]
    pub least_frames: u32,
    /// Ways opened in the upper layer: into and out of what is climbed, sat on or slid down, and from room to room.
    pub opened_instances: usize,
    /// Nodes opened in the lower layer.
    pub opened_nodes: usize,
}

/// Plans ways through a world; all its memory is allocated when it is made.
#[derive(Clone, Debug)]
pub struct Planner {
    upper: Upper,
    pub(crate) nodes: Nodes,
}

impl Planner {
    /// Memory for a world. What is known of the world beforehand is worked out by the first planner and kept with it.
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        Self { upper: Upper::new(graph, graph.atlas()), nodes: Nodes::new(graph) }
    }

    /// Looks for a way from a node to a target that takes at most [`GREED`] times as long as the fastest one, and writes
    /// as many of its first steps as there is room for; a way to where it begins has none. Allocates nothing.
    ///
    /// - returns `None` where no way leads there.
    ///
    /// [Limit: nodes and instances exist]
    pub fn plan(&mut self, graph: &WorldGraph<'_>, from: Node, target: Target, out: &mut [Step]) -> Option<Plan> {
        self.plan_around(graph, from, target, |_| 0.0, out)
    }

    /// The same, with a toll for entering instances, which counts as time. [Unit: frames]
    pub(crate) fn plan_around(
        &mut self,
        graph: &WorldGraph<'_>,
        from: Node,
        target: Target,
        toll: impl Fn(u32) -> f32,
        out: &mut [Step],
    ) -> Option<Plan> {
        let (atlas, mut opened_nodes) = (graph.atlas(), 0);
        // Who finds no way among the best ones, or none that is surely good, looks everywhere.
        for all in [false, true] {
            if !self.upper.run(graph, atlas, target, from, all) {
                return None;
            }
            let least = self.upper.estimate(graph, atlas, from);
            let mut way = Way { graph, atlas, target, upper: &mut self.upper, toll: &toll };
            let found = self.nodes.search(graph, from, &mut way, usize::MAX);
            opened_nodes += self.nodes.opened;
            if let Found::Way(way) = found
                && self.nodes.cost(way) <= GREED * self.upper.limit
            {
                let plan = Plan { opened_nodes, opened_instances: self.upper.opened, ..self.report(graph, way, out) };
                let least = least.min(self.upper.limit).max(self.nodes.cost(way) / GREED);
                return Some(Plan { least_frames: (least.ceil() as u32).min(plan.num_frames), ..plan });
            }
        }
        None
    }

    /// Writes the steps of a way that was found.
    fn report(&mut self, graph: &WorldGraph<'_>, way: u32, out: &mut [Step]) -> Plan {
        let mut plan = Plan::default();
        let mut at = self.nodes.turn(way);
        while let Some((next, step)) = self.nodes.next(at) {
            if let Some(slot) = out.get_mut(plan.num_steps) {
                *slot = step;
                plan.num_stored += 1;
            }
            plan.num_steps += 1;
            plan.num_frames += step.num_frames();
            plan.length_m += graph.length(&step);
            at = next;
        }
        plan
    }
}

/// The lower layer's space: everything, towards the target.
struct Way<'a, 'w, T> {
    graph: &'a WorldGraph<'w>,
    atlas: &'a Atlas,
    target: Target,
    upper: &'a mut Upper,
    toll: &'a T,
}

impl<T: Fn(u32) -> f32> Space for Way<'_, '_, T> {
    fn admits(&self, _: u32) -> bool {
        true
    }

    fn is_target(&self, node: Node) -> bool {
        self.target.is_at(self.graph, node)
    }

    fn estimate(&mut self, node: Node) -> f32 {
        GREED * self.upper.estimate(self.graph, self.atlas, node)
    }

    fn cost(&self, step: &Step) -> f32 {
        let toll = if step.to.instance == step.instance { 0.0 } else { (self.toll)(step.to.instance) };
        step.num_frames() as f32 + toll
    }
}
