//! Clusters: blocks, and tiles that fill no plane, that overlap: what is climbed, sat on and slid down as a whole.

use super::floors::Floors;
use crate::WorldGraph;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use throng_core::patch::NONE;

/// Instances with fewer joints between them stay apart.
const MIN_JOINTS: u32 = 8;
/// Most cells of a cluster that is more than what cannot be parted.
const MAX_CELLS: u32 = 1 << 16;

/// Clusters of a world.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Clusters {
    /// Cluster of each instance; [`NONE`] for tiles of floors (instances).
    #[serde(with = "crate::pod")]
    of: Vec<u32>,
    /// Number of each instance's first cell within its cluster (instances).
    #[serde(with = "crate::pod")]
    pub first_cell: Vec<u32>,
    /// Instances of each cluster, ascending.
    pub members: Vec<Vec<u32>>,
}

impl Clusters {
    /// Joins those with the most joints between them first.
    pub fn new(graph: &WorldGraph, floors: &Floors) -> Self {
        let n = graph.num_instances();
        let mut sets =
            Sets { parent: (0..n as u32).collect(), cells: (0..n as u32).map(|i| graph.num_cells(i)).collect() };
        let member = |i: u32| floors.floor_of(i).is_none();
        let mut pairs = Vec::new();
        for i in (0..n as u32).filter(|&i| member(i)) {
            let r = graph.instance(i);
            let num_edges = graph.patches().patches[r.patch as usize].num_edges;
            for &o in &graph.world().neighbours[r.first_neighbour as usize..][..num_edges as usize] {
                if o != NONE {
                    sets.join(i, o, u32::MAX);
                }
            }
            let overlaps = graph.adjacencies(i).filter(|(_, a, t)| i < a.other && t.num_joints >= MIN_JOINTS);
            pairs.extend(overlaps.filter(|(_, a, _)| member(a.other)).map(|(_, a, t)| (t.num_joints, i, a.other)));
        }
        pairs.sort_by_key(|&(joints, a, b)| (Reverse(joints), a, b));
        pairs.into_iter().for_each(|(_, a, b)| sets.join(a, b, MAX_CELLS));
        let mut out = Self { of: vec![NONE; n], first_cell: vec![0; n], members: Vec::new() };
        let mut number = vec![NONE; n];
        for i in (0..n as u32).filter(|&i| member(i)) {
            let root = sets.root(i) as usize;
            if number[root] == NONE {
                number[root] = out.members.len() as u32;
                out.members.push(Vec::new());
            }
            let cluster = number[root];
            let members = &mut out.members[cluster as usize];
            let before = members.last().map_or(0, |&m| out.first_cell[m as usize] + graph.num_cells(m));
            out.first_cell[i as usize] = before;
            out.of[i as usize] = cluster;
            members.push(i);
        }
        out
    }

    /// True where every instance that is in a cluster has its cells there.
    ///
    /// - `num_cells`: of a cluster, none where it does not exist.
    pub fn is_sound(&self, graph: &WorldGraph, num_cells: impl Fn(u32) -> Option<u32>) -> bool {
        let n = graph.num_instances();
        let inside = |i: usize| {
            let end = self.first_cell[i].checked_add(graph.num_cells(i as u32));
            self.of[i] == NONE || end.zip(num_cells(self.of[i])).is_some_and(|(end, all)| end <= all)
        };
        [self.of.len(), self.first_cell.len()] == [n; 2] && (0..n).all(inside)
    }

    /// Cluster of an instance; none for a tile of a floor.
    pub fn cluster_of(&self, instance: u32) -> Option<u32> {
        Some(self.of[instance as usize]).filter(|d| *d != NONE)
    }

    /// Number of an instance within its cluster.
    pub fn instance_number(&self, cluster: u32, instance: u32) -> u32 {
        self.members[cluster as usize].partition_point(|&m| m < instance) as u32
    }
}

/// Disjoint sets, each with the number of its cells (Tarjan 1975, with halving).
struct Sets {
    parent: Vec<u32>,
    cells: Vec<u32>,
}

impl Sets {
    fn root(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            self.parent[i as usize] = self.parent[self.parent[i as usize] as usize];
            i = self.parent[i as usize];
        }
        i
    }

    fn join(&mut self, a: u32, b: u32, most: u32) {
        let (a, b) = (self.root(a), self.root(b));
        let cells = self.cells[a as usize].saturating_add(self.cells[b as usize]);
        if a != b && cells <= most {
            self.parent[b.max(a) as usize] = a.min(b);
            self.cells[a.min(b) as usize] = cells;
        }
    }
}
