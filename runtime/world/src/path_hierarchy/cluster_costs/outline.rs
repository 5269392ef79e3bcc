//! Outlines: what the costs of a cluster depends on.

use super::super::clusters::Clusters;
use super::super::floors::Floors;
use super::AdjacentPart;
use crate::WorldGraph;
use std::collections::BTreeMap;

/// Cluster, with the numbering of its parts.
pub(crate) struct ClusterOutline<'a> {
    /// The world.
    pub graph: &'a WorldGraph,
    /// Floors of the world.
    pub floors: &'a Floors,
    /// Clusters of the world.
    pub clusters: &'a Clusters,
    /// Number of this cluster.
    pub cluster: u32,
    /// Instances that overlap the cluster, in its order.
    pub adjacent_parts: Vec<AdjacentPart>,
    /// Number of each there.
    pub numbers: BTreeMap<AdjacentPart, u32>,
    /// Cells of all instances.
    pub num_cells: u32,
}

impl<'a> ClusterOutline<'a> {
    /// Numbers what a cluster overlaps.
    pub fn new(graph: &'a WorldGraph, floors: &'a Floors, clusters: &'a Clusters, cluster: u32) -> Self {
        let members = &clusters.members[cluster as usize];
        let num_cells = members.iter().map(|&m| graph.num_cells(m)).sum();
        let (beyond, numbers) = (Vec::new(), BTreeMap::new());
        let mut out = Self { graph, floors, clusters, cluster, adjacent_parts: beyond, numbers, num_cells };
        for &m in members {
            for (_, a, _) in graph.adjacencies(m) {
                let Some(beyond) = out.adjacent_part(a.other) else { continue };
                if out.numbers.contains_key(&beyond) {
                    continue;
                }
                out.numbers.insert(beyond, out.adjacent_parts.len() as u32);
                out.adjacent_parts.push(beyond);
            }
        }
        out
    }

    /// Part of the world that an instance is to the cluster; none for its own.
    pub fn adjacent_part(&self, instance: u32) -> Option<AdjacentPart> {
        match self.clusters.cluster_of(instance) {
            None => Some(AdjacentPart::Tile(instance)),
            Some(d) => (d != self.cluster).then_some(AdjacentPart::Cluster(d)),
        }
    }

    /// Key on which all its costs depend: clusters with the same key have the same costs.
    pub fn cost_key(&self) -> Vec<u64> {
        let (graph, world) = (self.graph, self.graph.world());
        let members = &self.clusters.members[self.cluster as usize];
        let number = |i: u32| match self.adjacent_part(i) {
            None => members.partition_point(|&m| m < i) as u64,
            Some(beyond) => u64::MAX - u64::from(self.numbers.get(&beyond).copied().unwrap_or(u32::MAX)),
        };
        let mut key = Vec::new();
        for &m in members {
            let r = graph.instance(m);
            let p = &graph.patches().patches[r.patch as usize];
            key.push(r.patch.into());
            key.extend(&world.cell_words[r.first_cell_word as usize..][..p.num_cells.div_ceil(64) as usize]);
            key.extend(&world.link_words[r.first_link_word as usize..][..p.num_links.div_ceil(64) as usize]);
            let neighbours = &world.neighbours[r.first_neighbour as usize..][..p.num_edges as usize];
            key.extend(neighbours.iter().map(|&n| if n == throng_core::patch::NONE { u64::MAX } else { number(n) }));
            for (_, a, t) in graph.adjacencies(m) {
                key.extend([number(a.other), a.table.into(), a.side.into()]);
                let words = (2 * t.num_joints).div_ceil(64) as usize;
                key.extend(&world.joint_words[a.first_word as usize..][..words]);
                if let Some(beyond) = self.adjacent_part(a.other) {
                    if let AdjacentPart::Cluster(d) = beyond {
                        key.push(self.clusters.instance_number(d, a.other).into());
                    }
                    let o = graph.instance(a.other);
                    let words = graph.num_cells(a.other).div_ceil(64) as usize;
                    key.extend(&world.cell_words[o.first_cell_word as usize..][..words]);
                }
            }
        }
        key
    }
}
