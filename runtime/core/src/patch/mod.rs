//! Motion patches: building blocks of a world and the motion that is available within them (Lee, Choi and Lee (2006)).

mod records;

pub use crate::placement::Placement;
pub use records::{CellRecord, EdgeRecord, KIND_BLOCK, KIND_TILE, LinkRecord, NONE, PairRecord, PatchRecord};

use crate::format::Table;

/// The patches of a bundle. Clones share the rows.
#[derive(Clone, Debug)]
pub struct PatchTables {
    /// The patches; their names are `Meta::patches`.
    pub patches: Table<PatchRecord>,
    /// Edges of all tiles.
    pub edges: Table<EdgeRecord>,
    /// Cells of all patches.
    pub cells: Table<CellRecord>,
    /// Links of all patches.
    pub links: Table<LinkRecord>,
    /// Pairs of links for two people, ascending.
    pub pairs: Table<PairRecord>,
}

impl PatchTables {
    /// Edges of a patch (patch < patches.len()).
    pub fn edges_of(&self, patch: usize) -> &[EdgeRecord] {
        let p = &self.patches[patch];
        &self.edges[p.first_edge as usize..(p.first_edge + p.num_edges) as usize]
    }

    /// Cells of a patch (patch < patches.len()).
    pub fn cells_of(&self, patch: usize) -> &[CellRecord] {
        let p = &self.patches[patch];
        &self.cells[p.first_cell as usize..(p.first_cell + p.num_cells) as usize]
    }

    /// Links of a patch (patch < patches.len()).
    pub fn links_of(&self, patch: usize) -> &[LinkRecord] {
        let p = &self.patches[patch];
        &self.links[p.first_link as usize..(p.first_link + p.num_links) as usize]
    }
}
