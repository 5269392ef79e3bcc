//! Which links lead into each cell of a patch.

use crate::patch::Patches;

/// Links of all patches by where they end.
#[derive(Clone, Debug)]
pub(crate) struct Into {
    /// Where the links into each cell of all patches begin in the list. [Size: cells + 1]
    first: Vec<u32>,
    /// Links, by their number within the patch.
    links: Vec<u32>,
    /// First cell of each patch.
    first_cell: Vec<u32>,
}

impl Into {
    /// Sorts the links of all patches.
    pub fn new(patches: &Patches<'_>) -> Self {
        let mut out = Self { first: vec![0], links: Vec::new(), first_cell: Vec::new() };
        for p in 0..patches.patches.len() {
            out.first_cell.push(out.first.len() as u32 - 1);
            let (num_cells, links) = (patches.cells_of(p).len(), patches.links_of(p));
            let mut order: Vec<u32> = (0..links.len() as u32).collect();
            order.sort_by_key(|&l| links[l as usize].to);
            let base = out.links.len() as u32;
            let ends =
                (0..num_cells as u32).map(|c| base + order.partition_point(|&l| links[l as usize].to <= c) as u32);
            out.first.extend(ends);
            out.links.extend(order);
        }
        out
    }

    /// Links of a patch that end in a cell.
    pub fn of(&self, patch: u32, cell: u32) -> &[u32] {
        let at = (self.first_cell[patch as usize] + cell) as usize;
        &self.links[self.first[at] as usize..self.first[at + 1] as usize]
    }
}
