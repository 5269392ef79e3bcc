//! Path planning in two layers: over instances, then over the motion of those on the way and around it (004 section 7).

mod heap;
mod instances;
mod nodes;

use super::{Node, Step, WorldGraph};
use crate::patch::Placement;
use glam::Vec3;
use instances::Instances;
pub(crate) use nodes::{Found, Nodes, Space};

/// Most nodes that a search keeps at once. [Size: 32 bytes a node, touched only as far as searches go]
const MAX_NODES: usize = 1 << 23;
/// How far around the way over instances the lower layer looks, in instances; wider where nothing is found.
const SURROUNDINGS: [u32; 2] = [2, 5];

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
    /// States of instances opened in the upper layer.
    pub opened_instances: usize,
    /// Nodes opened in the lower layer, in all its tries.
    pub opened_nodes: usize,
}

/// Plans ways through a world; all its memory is allocated when it is made.
#[derive(Clone, Debug)]
pub struct Planner {
    instances: Instances,
    pub(crate) nodes: Nodes,
    /// The plan that put an instance in the corridor.
    corridor: Vec<u32>,
    stamp: u32,
    /// Instances of the corridor.
    list: Vec<u32>,
}

impl Planner {
    /// Memory for a world.
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        Self {
            instances: Instances::new(graph),
            nodes: Nodes::new(graph, MAX_NODES),
            corridor: vec![0; graph.num_instances()],
            stamp: 0,
            list: Vec::with_capacity(graph.num_instances()),
        }
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
        let state = self.instances.state_of(graph, from);
        let region = Region::of(graph, target)?;
        let end = match target {
            Target::Node(node) => self.instances.state_of(graph, node),
            Target::Rest { instance } | Target::Tag { instance, .. } => self.instances.inside_of(instance),
        };
        if !self.instances.run(graph, end, state, &toll) {
            return None;
        }
        let mut opened_nodes = 0;
        for around in SURROUNDINGS.map(Some).into_iter().chain([None]) {
            self.mark(graph, state, around);
            let corridor = around.map(|_| (self.corridor.as_slice(), self.stamp));
            let space = Way { graph, target, region, corridor, instances: &self.instances, toll: &toll };
            let found = self.nodes.search(graph, from, &space, usize::MAX);
            opened_nodes += self.nodes.opened;
            if let Found::Way(way) = found {
                return Some(self.report(graph, way, opened_nodes, out));
            }
        }
        None
    }

    fn report(&self, graph: &WorldGraph<'_>, way: u32, opened_nodes: usize, out: &mut [Step]) -> Plan {
        let num_steps = self.nodes.path(way, out);
        let (mut num_frames, mut length_m) = (0, 0.0);
        self.nodes.walk(way, |step| {
            num_frames += step.num_frames();
            length_m += graph.length(step);
        });
        let num_stored = num_steps.min(out.len());
        Plan { num_steps, num_stored, num_frames, length_m, opened_instances: self.instances.opened, opened_nodes }
    }

    /// Marks the instances on the way and around it.
    fn mark(&mut self, graph: &WorldGraph<'_>, from: u32, around: Option<u32>) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.corridor.fill(0);
            self.stamp = 1;
        }
        self.list.clear();
        let Self { instances, corridor, stamp, list, .. } = self;
        let mut add = |i: u32, list: &mut Vec<u32>| {
            if corridor[i as usize] != *stamp {
                corridor[i as usize] = *stamp;
                list.push(i);
            }
        };
        instances.way(from).for_each(|i| add(i, list));
        let mut first = 0;
        for _ in 0..around.unwrap_or(0) {
            let end = list.len();
            for k in first..end {
                let instance = list[k];
                let r = graph.instance(instance);
                let edges = graph.patches().patches[r.patch as usize].num_edges;
                let neighbours = &graph.world().neighbours[r.first_neighbour as usize..][..edges as usize];
                neighbours.iter().filter(|n| **n != crate::patch::NONE).for_each(|&n| add(n, list));
                graph.adjacencies(instance).for_each(|(_, a, _)| add(a.other, list));
            }
            first = end;
        }
    }
}

/// Where the nodes of a target are.
#[derive(Clone, Copy)]
struct Region {
    min: Vec3,
    max: Vec3,
}

impl Region {
    /// Of all nodes that are the target; none where there is none.
    fn of(graph: &WorldGraph<'_>, target: Target) -> Option<Self> {
        let instance = target.instance();
        let nodes = (0..graph.num_cells(instance)).map(|cell| Node { instance, cell });
        nodes.filter(|n| graph.is_node(*n) && target.is_at(graph, *n)).fold(None, |found: Option<Self>, node| {
            let p = graph.place(node).translation();
            Some(found.map_or(Self { min: p, max: p }, |r| Self { min: r.min.min(p), max: r.max.max(p) }))
        })
    }

    fn distance(&self, place: Placement) -> f32 {
        let p = place.translation();
        (p - p.clamp(self.min, self.max)).length()
    }
}

/// The lower layer's space: what is in the corridor, towards the target.
struct Way<'a, 'w, T> {
    graph: &'a WorldGraph<'w>,
    target: Target,
    region: Region,
    /// Stamps of the instances, and the one of the corridor; none where everything is admitted.
    corridor: Option<(&'a [u32], u32)>,
    instances: &'a Instances,
    toll: &'a T,
}

impl<T: Fn(u32) -> f32> Space for Way<'_, '_, T> {
    fn admits(&self, instance: u32) -> bool {
        self.corridor.is_none_or(|(stamps, stamp)| stamps[instance as usize] == stamp)
    }

    fn is_target(&self, node: Node) -> bool {
        self.target.is_at(self.graph, node)
    }

    fn estimate(&self, node: Node) -> f32 {
        let straight = self.region.distance(self.graph.place(node)) / self.graph.bounds.fastest;
        straight.max(self.instances.cost(self.instances.state_of(self.graph, node)))
    }

    fn cost(&self, step: &Step) -> f32 {
        let toll = if step.to.instance == step.instance { 0.0 } else { (self.toll)(step.to.instance) };
        step.num_frames() as f32 + toll
    }
}
