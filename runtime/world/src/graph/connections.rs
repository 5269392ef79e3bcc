//! Open connections between instances.

use super::{WorldGraph, WorldNode};
use crate::WorldTables;
use serde::{Deserialize, Serialize};
use throng_core::patch::CellRecord;

/// Open connections by neighbour and by adjacency.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct OpenConnections {
    /// Per neighbour of the world: true where some link leads across that edge.
    open_edges: Vec<bool>,
    /// Per adjacency: true where some joint leads to the other instance.
    open_joints: Vec<bool>,
}

impl OpenConnections {
    pub fn new(graph: &WorldGraph) -> Self {
        let mut out = Self {
            open_edges: vec![false; graph.world().neighbours.len()],
            open_joints: vec![false; graph.world().adjacencies.len()],
        };
        for i in 0..graph.num_instances() as u32 {
            if graph.is_tile(i) {
                out.open_edges_of(graph, i);
            }
            for (k, a, t) in graph.adjacencies(i) {
                let [to_b, to_a] = open_directions(graph, a.first_word, t.num_joints);
                out.open_joints[k] = if a.side == 0 { to_b } else { to_a };
            }
        }
        out
    }

    /// True where there is one for each neighbour and adjacency of a world.
    pub fn is_sound(&self, world: &WorldTables) -> bool {
        [self.open_edges.len(), self.open_joints.len()] == [world.neighbours.len(), world.adjacencies.len()]
    }

    /// True where some link of the instance with that neighbour leads there.
    pub fn is_edge_open(&self, neighbour: u32) -> bool {
        self.open_edges[neighbour as usize]
    }

    /// Instance beyond an edge, where some link leads there.
    pub fn neighbour(&self, graph: &WorldGraph, slot: u32) -> Option<u32> {
        self.is_edge_open(slot).then(|| graph.world().neighbours[slot as usize])
    }

    /// True where some joint of an adjacency leads to the other instance.
    pub fn is_open_outwards(&self, adjacency: usize) -> bool {
        self.open_joints[adjacency]
    }

    fn open_edges_of(&mut self, graph: &WorldGraph, instance: u32) {
        let r = graph.instance(instance);
        for (k, l) in graph.links(instance).iter().enumerate() {
            let cell = graph.cell(WorldNode { instance, cell: l.to });
            if !cell.has_flags(CellRecord::IS_EXIT) {
                continue;
            }
            let slot = (r.first_neighbour + cell.edge) as usize;
            if !self.open_edges[slot] && graph.step_along(instance, k as u32).is_some() {
                self.open_edges[slot] = true;
            }
        }
    }
}

/// True where some joint may be taken, from side a to side b and back.
fn open_directions(graph: &WorldGraph, first_word: u32, num_joints: u32) -> [bool; 2] {
    let words = &graph.world().joint_words[first_word as usize..][..(2 * num_joints).div_ceil(64) as usize];
    let all = words.iter().fold(0, |a, w| a | w);
    [all & 0x5555_5555_5555_5555 != 0, all & 0xAAAA_AAAA_AAAA_AAAA != 0]
}
