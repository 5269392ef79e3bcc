//! Location of a target, and costs to reach it from the same part of the world.

use super::{PlanTarget, inside::ClusterSearch};
use crate::path_hierarchy::{PathHierarchy, class_of};
use crate::{WorldGraph, WorldNode};
use throng_core::patch::CellRecord;

/// Location of the target, with memory for it.
#[derive(Clone, Debug)]
pub(super) struct TargetLocation {
    pub instance: u32,
    /// Goals that its cells are among, where it is in a region: one, or classes, one bit each.
    goal: Option<u32>,
    classes: u32,
    /// Cluster of the target.
    pub cluster: Option<u32>,
    /// Least costs from each entrance of the cluster.
    pub from_entrance: Vec<f32>,
    inside: ClusterSearch,
}

impl TargetLocation {
    /// Memory for a world.
    pub fn new(graph: &WorldGraph, hierarchy: &PathHierarchy) -> Self {
        let clusters = 0..hierarchy.num_clusters() as u32;
        Self {
            instance: 0,
            goal: None,
            classes: 0,
            cluster: None,
            from_entrance: Vec::with_capacity(clusters.map(|d| hierarchy.entrances_of(d).len()).max().unwrap_or(0)),
            inside: ClusterSearch::new(graph, hierarchy),
        }
    }

    /// Finds out where a target lies; false where there is none.
    pub fn locate_target(&mut self, graph: &WorldGraph, hierarchy: &PathHierarchy, target: PlanTarget) -> bool {
        let instance = target.instance();
        (self.instance, self.goal, self.classes, self.cluster) = (instance, None, 0, None);
        self.from_entrance.clear();
        let nodes = || {
            let all = (0..graph.num_cells(instance)).map(move |cell| WorldNode { instance, cell });
            all.filter(|n| graph.is_node(*n) && target.is_at(graph, *n))
        };
        if nodes().next().is_none() {
            return false;
        }
        if let Some((cluster, first)) = hierarchy.cluster(instance) {
            self.cluster = Some(cluster);
            self.inside.begin(cluster, nodes().map(|n| first + n.cell));
            let entrances = 0..hierarchy.entrances_of(cluster).len() as u32;
            self.from_entrance.extend(entrances.map(|entrance| self.inside.cost_from(hierarchy, entrance)));
            return true;
        }
        let Some((_, plane)) = hierarchy.region_and_plane(instance) else { return false };
        let num_edges = graph.patches().patches[graph.instance(instance).patch as usize].num_edges;
        let mut all = nodes();
        let (first, several) = (all.next(), all.next().is_some());
        self.goal = match first {
            Some(node) if !several => plane.goal_at(Some(node.cell)),
            _ if nodes().all(|n| graph.cell(n).has_flags(CellRecord::IS_REST)) => plane.goal_at(None),
            _ => None,
        };
        nodes().for_each(|n| self.classes |= 1 << class_of(graph.cell(n), num_edges));
        true
    }

    /// Lower bound of the cost to the target without leaving its part of the world (frames).
    pub fn cost(&mut self, hierarchy: &PathHierarchy, node: WorldNode) -> f32 {
        if let Some((cluster, first)) = hierarchy.cluster(node.instance) {
            let here = self.cluster == Some(cluster);
            return if here { self.inside.cost(hierarchy, first + node.cell) } else { f32::INFINITY };
        }
        let (here, there) = (hierarchy.floors.region(node.instance), hierarchy.floors.region(self.instance));
        let Some(region) = here.filter(|_| here == there) else { return f32::INFINITY };
        self.cost_at(hierarchy, region, hierarchy.floors.offset(node.instance, self.instance), node.cell)
    }

    /// Lower bound of the cost to the target from a cell of a tile of its region, at an offset from it (copies).
    pub fn cost_at(&self, hierarchy: &PathHierarchy, region: u32, offset: [i32; 2], cell: u32) -> f32 {
        let Some(plane) = hierarchy.plane(region) else { return f32::INFINITY };
        let cost = |goal| plane.cost(plane.lookup(goal, offset), cell);
        match self.goal {
            Some(goal) => cost(goal),
            None => (0..u32::BITS).filter(|c| self.classes >> c & 1 == 1).map(cost).fold(f32::INFINITY, f32::min),
        }
    }
}
