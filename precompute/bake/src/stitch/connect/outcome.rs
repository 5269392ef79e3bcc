//! What is left of an instance: the same for all in the same situation of which the same cells are taken out.

use super::settled::Standing;
use super::situation::Situation;
use crate::stitch::report::Reason;
use crate::stitch::sets::bits::{num_words, set};
use crate::stitch::sets::same::Same;
use std::hash::{Hash, Hasher};
use throng_core::patch::{CellRecord, Patches};
use throng_world::is_set;

/// Figures of a world, or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::stitch) struct Counts {
    /// Nodes left.
    pub cells: u64,
    /// Links left.
    pub links: u64,
    /// Joints left.
    pub joints: u64,
    /// Frames of the links left.
    pub frames: u64,
    /// Cells and links taken out, by reason.
    pub disabled: [u64; 4],
}

impl Counts {
    /// Counts more.
    pub fn add(&mut self, more: &Self) {
        self.cells += more.cells;
        self.links += more.links;
        self.joints += more.joints;
        self.frames += more.frames;
        self.disabled.iter_mut().zip(more.disabled).for_each(|(d, m)| *d += m);
    }
}

/// What an instance is to the component: what is left of it depends on that alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::stitch) struct State {
    /// What is in its way.
    pub situation: Same<Situation>,
    /// Bits of the cells that belong to the component.
    pub inside: Vec<u64>,
    /// Bits of the cells that lead to it.
    pub leads: Vec<u64>,
    /// For each edge, whether there is a neighbour.
    pub has_neighbour: Vec<bool>,
}

impl Hash for State {
    /// Many words for each instance of a world: they are taken together first.
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.situation.hash(state);
        let words = [&self.inside, &self.leads].map(|w| xxhash_rust::xxh3::xxh3_64(bytemuck::cast_slice(w)));
        (words, &self.has_neighbour).hash(state);
    }
}

impl State {
    /// Why a cell is taken out; none where it is left.
    fn cell(&self, cell: &CellRecord, number: u32) -> Option<Reason> {
        let standing = match (is_set(&self.inside, 0, number), is_set(&self.leads, 0, number)) {
            (true, _) => Standing::Inside,
            (false, true) => Standing::Unreached,
            (false, false) => Standing::DeadEnd,
        };
        of_cell(standing, is_end(cell) && !self.has_neighbour[cell.edge as usize])
    }
}

/// What is left of an instance.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct Outcome {
    /// Bits of its cells.
    pub cells: Vec<u64>,
    /// Bits of its links.
    pub links: Vec<u64>,
    /// How many there are.
    pub counts: Counts,
}

impl Outcome {
    /// Of all instances in that state.
    pub fn new(patches: &Patches, state: &State) -> Self {
        let situation = &state.situation.0;
        let patch = situation.surroundings.patch as usize;
        let (cells, links) = (patches.cells_of(patch), patches.links_of(patch));
        let mut out =
            Self { cells: state.inside.clone(), links: vec![0; num_words(links.len())], counts: Counts::default() };
        let taken_out: Vec<_> = (0u32..).zip(cells).map(|(c, cell)| state.cell(cell, c)).collect();
        for (cell, reason) in cells.iter().zip(&taken_out) {
            match reason {
                Some(reason) => out.counts.disabled[*reason as usize] += 1,
                // An exit is the neighbour's entry.
                None => out.counts.cells += u64::from(!cell.is(CellRecord::IS_EXIT)),
            }
        }
        for (l, link) in (0u32..).zip(links) {
            let free = is_set(&situation.link_words, 0, l);
            match of_link(free, taken_out[link.from as usize], || taken_out[link.to as usize]) {
                Some(reason) => out.counts.disabled[reason as usize] += 1,
                None => {
                    set(&mut out.links, l);
                    out.counts.links += 1;
                    out.counts.frames += u64::from(link.num_frames);
                }
            }
        }
        out
    }
}

/// True for cells at an edge of a tile.
pub(in crate::stitch) fn is_end(cell: &CellRecord) -> bool {
    cell.flags & (CellRecord::IS_ENTRY | CellRecord::IS_EXIT) != 0
}

/// Why a cell is taken out; none where it is left.
///
/// - `alone`: it is at an edge across which there is no neighbour.
pub(in crate::stitch) fn of_cell(standing: Standing, alone: bool) -> Option<Reason> {
    match standing {
        Standing::Inside => None,
        _ if alone => Some(Reason::NoNeighbour),
        Standing::DeadEnd => Some(Reason::DeadEnd),
        Standing::Unreached => Some(Reason::OutsideComponent),
    }
}

/// Why a link is taken out; none where it is left.
///
/// - `free`: nothing is in its way.
/// - `from`, `to`: why the cells are taken out that it leads from and to.
pub(in crate::stitch) fn of_link(
    free: bool,
    from: Option<Reason>,
    to: impl FnOnce() -> Option<Reason>,
) -> Option<Reason> {
    if !free {
        return Some(Reason::Obstacle);
    }
    match to() {
        Some(Reason::NoNeighbour) => Some(Reason::NoNeighbour),
        None => from,
        // It would be part of the component if it led back to it.
        Some(_) => from.or(Some(Reason::DeadEnd)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stitch::connect::situation::Surroundings;
    use crate::stitch::sets::rows::Rows;
    use bytemuck::Zeroable;
    use std::sync::Arc;
    use throng_core::patch::{KIND_TILE, LinkRecord, NONE, PatchRecord, Placement};

    #[test]
    fn every_cell_and_link_is_left_or_counted_by_its_reason() {
        let cell = |flags: u32, edge: u32| CellRecord { flags, edge, twin: NONE, ..CellRecord::zeroed() };
        let inner = cell(0, NONE);
        let cells = [inner, cell(CellRecord::IS_EXIT, 0), cell(CellRecord::IS_ENTRY, 1), inner, inner];
        let at = Placement::IDENTITY;
        let link = |from, to| LinkRecord { from, to, frame: 0, num_frames: 25, tag: 0, start: at, end: at };
        let links = [link(0, 0), link(0, 1), link(0, 2), link(0, 3), link(4, 0), link(0, 0)];
        let patch = PatchRecord { kind: KIND_TILE, num_cells: 5, num_links: 6, ..PatchRecord::zeroed() };
        let patches = Patches {
            patches: (&[patch]).into(),
            edges: [].as_slice().into(),
            cells: (&cells).into(),
            links: (&links).into(),
            pairs: [].as_slice().into(),
        };
        let surroundings = Surroundings { patch: 0, obstacles: Vec::new() };
        // Something is in the way of the last link.
        let situation =
            Situation { surroundings, link_words: vec![0b01_1111], out: Rows::default(), into: Rows::default() };
        let state = State {
            situation: Same(Arc::new(situation)),
            inside: vec![0b0_0011],
            leads: vec![0b1_0011],
            has_neighbour: vec![true, false],
        };
        let outcome = Outcome::new(&patches, &state);
        assert_eq!((outcome.cells[0], outcome.links[0]), (0b11, 0b11));
        let c = outcome.counts;
        // The exit is no cell of its own. Cell 2 has no neighbour, nothing leads to 4, and 3 leads nowhere.
        assert_eq!((c.cells, c.links, c.frames, c.joints), (1, 2, 50, 0));
        let mut disabled = [0; 4];
        disabled[Reason::NoNeighbour as usize] = 2;
        disabled[Reason::OutsideComponent as usize] = 2;
        disabled[Reason::DeadEnd as usize] = 2;
        disabled[Reason::Obstacle as usize] = 1;
        assert_eq!(c.disabled, disabled);
        let mut sum = c;
        sum.add(&c);
        assert_eq!((sum.links, sum.disabled[Reason::DeadEnd as usize]), (4, 4));
    }
}
