//! Places for characters to begin at.

use super::reservations::UnitReservations;
use crate::{WorldGraph, WorldNode, is_set};
use glam::Vec3;
use throng_core::characters::uniform_random;
use throng_core::patch::{CellRecord, NONE};

/// Rest cells at random places for up to `n` characters, each in an instance whose units are free.
///
/// - returns fewer where the world is full.
pub fn scatter_rest_nodes(graph: &WorldGraph, n: usize, seed: u64) -> Vec<WorldNode> {
    let mut order: Vec<u32> = (0..graph.num_instances() as u32).collect();
    for i in (1..order.len()).rev() {
        let other = (uniform_random(seed, 0, i as u64) * (i + 1) as f32) as usize;
        order.swap(i, other.min(i));
    }
    let mut reservations = UnitReservations::new(graph);
    let mut out = Vec::with_capacity(n.min(order.len()));
    for instance in order {
        if out.len() == n {
            break;
        }
        let units = graph.resources(instance);
        if units.iter().any(|&u| reservations.holder_of(u).is_some()) {
            continue;
        }
        let count = graph.rest_cells(instance).count();
        let chosen = (uniform_random(seed, 1, u64::from(instance)) * count as f32) as usize;
        if let Some(node) = graph.rest_cells(instance).nth(chosen.min(count.saturating_sub(1))) {
            reservations.take_units(units, 0);
            out.push(node);
        }
    }
    out
}

impl WorldGraph {
    /// Nodes of an instance where a character may stay (instance < num_instances).
    pub fn rest_cells(&self, instance: u32) -> impl Iterator<Item = WorldNode> + '_ {
        (0..self.num_cells(instance)).map(move |cell| WorldNode { instance, cell }).filter(|n| self.is_rest(*n))
    }

    /// False for a node of a tile that nothing leads to from its edges. Allocates nothing.
    pub(super) fn is_entered(&self, node: WorldNode) -> bool {
        let (cells, links) = (self.cells(node.instance), self.links(node.instance));
        // One bit a cell. Cells of a larger tile count as entered, as do all cells of a tile that blocks lead into.
        let mut found = [0u64; 64];
        if !self.is_tile(node.instance) || self.instance(node.instance).num_adjacencies > 0 || cells.len() > 64 * 64 {
            return true;
        }
        let first = self.instance(node.instance).first_neighbour;
        let is_entry = |cell: &CellRecord| {
            cell.has_flags(CellRecord::IS_ENTRY)
                && cell.edge != NONE
                && self.world().neighbours[(first + cell.edge) as usize] != NONE
        };
        found[node.cell as usize / 64] |= 1 << (node.cell % 64);
        loop {
            let before = found;
            for (k, l) in (0..).zip(links) {
                let is_new = is_set(&found, 0, l.to) && !is_set(&found, 0, l.from);
                if is_new
                    && self.is_link_enabled(node.instance, k)
                    && self.is_enabled(WorldNode { cell: l.from, ..node })
                {
                    found[l.from as usize / 64] |= 1 << (l.from % 64);
                }
            }
            let is_entered = (0..).zip(cells).any(|(k, cell)| is_set(&found, 0, k) && is_entry(cell));
            if is_entered || found == before {
                return is_entered;
            }
        }
    }

    /// The node nearest to a point where a character may stay, and to which it can come (m).
    pub fn nearest_rest(&self, point: Vec3) -> Option<WorldNode> {
        self.nearest_rest_of(point, |_| true)
    }

    /// The node nearest to a point where a character may stay, among instances that are wanted (m).
    pub fn nearest_rest_of(&self, point: Vec3, is_wanted: impl Fn(u32) -> bool) -> Option<WorldNode> {
        let mut best = (f32::INFINITY, None);
        for instance in 0..self.num_instances() as u32 {
            let r = self.instance(instance);
            let p = &self.patches().patches[r.patch as usize];
            let local = r.placement.inverse_transform_point(point);
            let inside = local.clamp(Vec3::from_array(p.min), Vec3::from_array(p.max));
            // Cells are on the ground of their patch or hips high; all of them lie in its bounds.
            if (local - inside).length_squared() > best.0 || !is_wanted(instance) {
                continue;
            }
            for node in self.rest_cells(instance) {
                let far = (self.place(node).translation() - point).length_squared();
                if far < best.0 && self.is_entered(node) {
                    best = (far, Some(node));
                }
            }
        }
        best.1
    }
}
