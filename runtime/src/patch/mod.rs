//! Motion patches: building blocks of a world and the motion that is available within them (004).

mod placement;
mod records;

pub use placement::Placement;
pub use records::{CellRecord, EdgeRecord, KIND_BLOCK, KIND_TILE, LinkRecord, NONE, PatchRecord};

/// View on the patches of a bundle.
#[derive(Clone, Copy, Debug)]
pub struct Patches<'a> {
    /// The patches; their names are `Meta::patches`.
    pub patches: &'a [PatchRecord],
    /// Edges of all tiles.
    pub edges: &'a [EdgeRecord],
    /// Cells of all patches.
    pub cells: &'a [CellRecord],
    /// Links of all patches.
    pub links: &'a [LinkRecord],
}

impl<'a> Patches<'a> {
    /// Edges of a patch. [Limit: patch < patches.len()]
    pub fn edges_of(&self, patch: usize) -> &'a [EdgeRecord] {
        let p = &self.patches[patch];
        &self.edges[p.first_edge as usize..(p.first_edge + p.num_edges) as usize]
    }

    /// Cells of a patch. [Limit: patch < patches.len()]
    pub fn cells_of(&self, patch: usize) -> &'a [CellRecord] {
        let p = &self.patches[patch];
        &self.cells[p.first_cell as usize..(p.first_cell + p.num_cells) as usize]
    }

    /// Links of a patch. [Limit: patch < patches.len()]
    pub fn links_of(&self, patch: usize) -> &'a [LinkRecord] {
        let p = &self.patches[patch];
        &self.links[p.first_link as usize..(p.first_link + p.num_links) as usize]
    }
}
