//! Path planning in two layers (004 section 7): over the ways into and out of what stands on open ground, then over the
//! motion itself, towards what the upper layer says is near.

mod gates;
mod heap;
mod leaps;
mod near;
mod nodes;

use super::atlas::Atlas;
use super::{Node, Step, WorldGraph};
use crate::patch::NONE;
use gates::Upper;
pub(crate) use nodes::{Found, Nodes, Space};

/// Most nodes that a search keeps at once. [Size: 32 bytes a node, touched only as far as searches go]
const MAX_NODES: usize = 1 << 23;

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
    /// Ways into and out of districts opened in the upper layer: of what is climbed, sat on or slid down.
    pub opened_instances: usize,
    /// Nodes opened in the lower layer, in all its tries.
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
        Self { upper: Upper::new(graph, graph.atlas()), nodes: Nodes::new(graph, MAX_NODES) }
    }

    /// Looks for a way from a node to a target, and writes as many of its first steps as there is room for; a way to
    /// where it begins has none. Allocates nothing.
    ///
    /// - returns `None` where no way leads there.
    ///
    /// [Limit: nodes and instances exist]
    pub fn plan(&mut self, graph: &WorldGraph<'_>, from: Node, target: Target, out: &mut [Step]) -> Option<Plan> {
        self.plan_around(graph, from, target, |_| 0.0, out)
    }

    /// The same, with a toll for entering instances. [Unit: frames]
    pub(crate) fn plan_around(
        &mut self,
        graph: &WorldGraph<'_>,
        from: Node,
        target: Target,
        toll: impl Fn(u32) -> f32,
        out: &mut [Step],
    ) -> Option<Plan> {
        let (atlas, mut opened_nodes) = (graph.atlas(), 0);
        let mut known = None;
        for tries in &TRIES {
            if known != Some(tries.all) && !self.upper.run(graph, atlas, target, from, tries.all) {
                return None;
            }
            known = Some(tries.all);
            let skip = if tries.leaps { self.upper.district() } else { NONE };
            let (upper, greed) = (&mut self.upper, tries.greed);
            let mut way = Way { graph, atlas, target, skip, leaps: tries.leaps, greed, upper, toll: &toll };
            let found = self.nodes.search(graph, from, &mut way, tries.most);
            opened_nodes += self.nodes.opened;
            if let Found::Way(way) = found
                && let Some(plan) = self.report(graph, from, way, out)
            {
                return Some(Plan { opened_nodes, opened_instances: self.upper.opened, ..plan });
            }
        }
        None
    }

    /// Writes the steps of a way that was found; none where what stands for many steps cannot be told step by step.
    fn report(&mut self, graph: &WorldGraph<'_>, from: Node, way: u32, out: &mut [Step]) -> Option<Plan> {
        let mut plan = Plan::default();
        let mut add = |step: Step| {
            if let Some(slot) = out.get_mut(plan.num_steps) {
                *slot = step;
                plan.num_stored += 1;
            }
            plan.num_steps += 1;
            plan.num_frames += step.num_frames();
            plan.length_m += graph.length(&step);
        };
        let (mut at, mut node) = (self.nodes.turn(way), from);
        while let Some((next, step)) = self.nodes.next(at) {
            match step.link {
                NONE => leaps::walk(graph, graph.atlas(), node, &step, &mut add)?,
                _ => add(step),
            }
            (at, node) = (next, step.to);
        }
        Some(plan)
    }
}

/// How a way is looked for.
struct Try {
    /// What estimates count in the lower layer: more than 1 opens far fewer nodes, for ways that take a little longer
    /// (weighted A*, Pohl 1970: at most this many times the best one where estimates are bounds).
    greed: f32,
    /// Most nodes that are opened.
    most: usize,
    /// In the upper layer, up to the last way in and out.
    all: bool,
    /// In the lower layer, over districts in one leap.
    leaps: bool,
}

/// Who finds no way soon looks for another one that may take longer; who finds none at all looks everywhere.
const TRIES: [Try; 5] = [
    Try { greed: 1.1, most: 1000, all: false, leaps: true },
    Try { greed: 1.4, most: 1500, all: false, leaps: true },
    Try { greed: 2.5, most: usize::MAX, all: false, leaps: true },
    Try { greed: 2.5, most: usize::MAX, all: true, leaps: true },
    Try { greed: 2.5, most: usize::MAX, all: true, leaps: false },
];

/// The lower layer's space: everything, towards the target.
struct Way<'a, 'w, T> {
    graph: &'a WorldGraph<'w>,
    atlas: &'a Atlas,
    target: Target,
    /// The district that is not leapt over: that of the target.
    skip: u32,
    leaps: bool,
    greed: f32,
    upper: &'a mut Upper,
    toll: &'a T,
}

impl<T: Fn(u32) -> f32> Space for Way<'_, '_, T> {
    fn admits(&self, _: u32) -> bool {
        true
    }

    fn for_each_step(&mut self, graph: &WorldGraph<'_>, node: Node, mut visit: impl FnMut(&mut Self, Step)) {
        match self.atlas.district(node.instance) {
            Some((district, first)) if self.leaps && district != self.skip => {
                let atlas = self.atlas;
                leaps::for_each(graph, atlas, district, first + node.cell, |step| visit(self, step));
            }
            _ => graph.for_each_step(node, |step| visit(self, step)),
        }
    }

    fn is_target(&self, node: Node) -> bool {
        self.target.is_at(self.graph, node)
    }

    fn estimate(&mut self, node: Node) -> f32 {
        self.greed * self.upper.estimate(self.atlas, node)
    }

    fn cost(&self, step: &Step) -> f32 {
        let toll = if step.to.instance == step.instance { 0.0 } else { (self.toll)(step.to.instance) };
        step.num_frames() as f32 + toll
    }
}
