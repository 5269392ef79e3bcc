//! What a way between instances costs at least: the figures of the upper layer of planning.

use super::{Node, WorldGraph};
use crate::patch::{CellRecord, KIND_TILE, NONE, Patches};
use crate::world::JointTableRecord;
use glam::Vec3;

/// Stands where there is no way. [Unit: frames]
pub(crate) const CLOSED: f32 = f32::INFINITY;

/// Least costs, by patch and by table, and which ways between instances are open at all. [Unit: frames]
#[derive(Clone, Debug, Default)]
pub(crate) struct Bounds {
    /// Per patch: where its (edges + 1) x (edges + 1) costs begin in `across`.
    first: Vec<u32>,
    /// From what a tile is entered by (an edge, or its inside) to what it is left by.
    across: Vec<f32>,
    /// Per neighbour of the world: true where some link leads across that edge.
    open_edges: Vec<bool>,
    /// Per adjacency: true where some joint leads to the other instance, and from it.
    open_joints: Vec<[bool; 2]>,
    /// Per table: where its costs begin in `joints`.
    first_joint: Vec<u32>,
    /// Per table and port of side a: frames that are played at least from there to side b, and from side b to there.
    joints: Vec<[f32; 2]>,
    /// Largest distance between cells that a link covers. [Unit: m/frame]
    pub fastest: f32,
}

impl Bounds {
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        let patches = graph.patches();
        let mut out = Self { fastest: 1e-6, ..Self::default() };
        for p in 0..patches.patches.len() {
            out.add_patch(patches, p);
        }
        out.open_edges = vec![false; graph.world().neighbours.len()];
        for i in (0..graph.num_instances() as u32).filter(|&i| graph.is_tile(i)) {
            out.open_edges_of(graph, i);
        }
        for t in graph.world().tables {
            out.add_table(graph, t);
        }
        out.open_joints = vec![[false; 2]; graph.world().adjacencies.len()];
        for i in 0..graph.num_instances() as u32 {
            for (k, a, t) in graph.adjacencies(i) {
                let [to_b, to_a] = open_directions(graph, a.first_word, t.num_joints);
                out.open_joints[k] = if a.side == 0 { [to_b, to_a] } else { [to_a, to_b] };
            }
        }
        out
    }

    /// Cost from entering a tile by `from` to leaving it by `to`, each an edge or, past the last edge, the inside.
    pub fn across(&self, patch: u32, num_edges: u32, from: u32, to: u32) -> f32 {
        self.across[(self.first[patch as usize] + from * (num_edges + 1) + to) as usize]
    }

    /// True where some link of the instance with that neighbour leads there.
    pub fn is_edge_open(&self, neighbour: u32) -> bool {
        self.open_edges[neighbour as usize]
    }

    /// True where some joint of an adjacency leads into the instance that owns it.
    pub fn is_open_inwards(&self, adjacency: usize) -> bool {
        self.open_joints[adjacency][1]
    }

    /// True where some joint of an adjacency leads to the other instance.
    pub fn is_open_outwards(&self, adjacency: usize) -> bool {
        self.open_joints[adjacency][0]
    }

    /// Frames that are played at least on the way over a joint from side a, entered by a port, to side b.
    pub fn towards_b(&self, table: u32, port: u32) -> f32 {
        self.joints[(self.first_joint[table as usize] + port) as usize][0]
    }

    /// Frames that are played at least on the way over a joint from side b until side a is left by a port.
    pub fn out_of_b(&self, table: u32, port: u32) -> f32 {
        self.joints[(self.first_joint[table as usize] + port) as usize][1]
    }

    fn add_patch(&mut self, patches: &Patches<'_>, p: usize) {
        let (cells, num_edges) = (patches.cells_of(p), patches.patches[p].num_edges);
        let side = num_edges + 1;
        let first = self.across.len();
        self.first.push(first as u32);
        self.across.resize(first + (side * side) as usize, CLOSED);
        for l in patches.links_of(p) {
            let (from, to) = (&cells[l.from as usize], &cells[l.to as usize]);
            let frames = f32::from(l.num_frames);
            let cost = &mut self.across[first + (port(from, num_edges) * side + port(to, num_edges)) as usize];
            *cost = cost.min(frames);
            let covered = (to.placement.translation() - from.placement.translation()).length();
            self.fastest = self.fastest.max(covered / frames);
        }
    }

    fn add_table(&mut self, graph: &WorldGraph<'_>, t: &JointTableRecord) {
        let patches = graph.patches();
        self.first_joint.push(self.joints.len() as u32);
        let a = &patches.patches[t.patch_a as usize];
        if a.kind != KIND_TILE {
            // Nothing is played, but the blocks are as far apart as they are.
            let middle = |p: u32| {
                let p = &patches.patches[p as usize];
                (Vec3::from_array(p.min) + Vec3::from_array(p.max)) * 0.5
            };
            let apart = (t.placement.transform_point(middle(t.patch_b)) - middle(t.patch_a)).length();
            self.joints.push([apart / self.fastest; 2]);
            return;
        }
        let (cells, links) = (patches.cells_of(t.patch_a as usize), patches.links_of(t.patch_a as usize));
        let first = self.joints.len();
        self.joints.resize(first + a.num_edges as usize + 1, [CLOSED; 2]);
        for j in graph.joints(t) {
            let l = &links[j.a as usize];
            let [from, to] = [l.from, l.to].map(|c| first + port(&cells[c as usize], a.num_edges) as usize);
            self.joints[from][0] = self.joints[from][0].min(j.a_offset as f32);
            self.joints[to][1] = self.joints[to][1].min((u32::from(l.num_frames) - j.a_offset) as f32);
        }
    }

    fn open_edges_of(&mut self, graph: &WorldGraph<'_>, instance: u32) {
        let r = graph.instance(instance);
        for (k, l) in graph.links(instance).iter().enumerate() {
            let cell = graph.cell(Node { instance, cell: l.to });
            if !cell.is(CellRecord::IS_EXIT) {
                continue;
            }
            let slot = (r.first_neighbour + cell.edge) as usize;
            if !self.open_edges[slot] && graph.step_along(instance, k as u32).is_some() {
                self.open_edges[slot] = true;
            }
        }
    }
}

/// What a cell of a tile is entered or left by: its edge, or past the last one the inside.
fn port(cell: &CellRecord, num_edges: u32) -> u32 {
    if cell.edge == NONE { num_edges } else { cell.edge }
}

/// True where some joint may be taken, from side a to side b and back.
fn open_directions(graph: &WorldGraph<'_>, first_word: u32, num_joints: u32) -> [bool; 2] {
    let words = &graph.world().joint_words[first_word as usize..][..(2 * num_joints).div_ceil(64) as usize];
    let all = words.iter().fold(0, |a, w| a | w);
    [all & 0x5555_5555_5555_5555 != 0, all & 0xAAAA_AAAA_AAAA_AAAA != 0]
}
