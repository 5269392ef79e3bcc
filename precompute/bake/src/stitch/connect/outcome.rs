//! Remaining motion of an instance: shared by all in the same situation with the same cells removed.

use super::{component_cells::ComponentMembership, situation::PatchSituation};
use crate::stitch::sets::rows::{num_words, set_bit};
use crate::{stitch::report::RemovalReason, stitch::sets::numbers::IdentityArc};
use std::hash::{Hash, Hasher};
use throng_core::patch::{CellRecord, PatchTables};
use throng_world::is_set;

/// Counts of a world, or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::stitch) struct WorldCounts {
    /// Remaining nodes.
    pub cells: u64,
    /// Remaining links.
    pub links: u64,
    /// Remaining joints.
    pub joints: u64,
    /// Frames of the remaining links.
    pub frames: u64,
    /// Removed cells and links, by reason.
    pub disabled: [u64; 4],
}

impl WorldCounts {
    /// Adds other counts.
    pub fn add(&mut self, more: &Self) {
        self.cells += more.cells;
        self.links += more.links;
        self.joints += more.joints;
        self.frames += more.frames;
        self.disabled.iter_mut().zip(more.disabled).for_each(|(d, m)| *d += m);
    }
}

/// State of an instance relative to the component, which determines its remaining motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::stitch) struct InstanceState {
    /// Situation: the obstacles to its motion.
    pub situation: IdentityArc<PatchSituation>,
    /// Bits of the cells in the component.
    pub inside: Vec<u64>,
    /// Bits of the cells that lead to the component.
    pub leads: Vec<u64>,
    /// For each edge, true if there is a neighbour.
    pub has_neighbour: Vec<bool>,
}

impl Hash for InstanceState {
    /// Combines the many words of each instance before hashing.
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.situation.hash(state);
        let words = [&self.inside, &self.leads].map(|w| xxhash_rust::xxh3::xxh3_64(bytemuck::cast_slice(w)));
        (words, &self.has_neighbour).hash(state);
    }
}

impl InstanceState {
    /// Reason why a cell is removed; `None` if it remains.
    fn cell(&self, cell: &CellRecord, number: u32) -> Option<RemovalReason> {
        let standing = match (is_set(&self.inside, 0, number), is_set(&self.leads, 0, number)) {
            (true, _) => ComponentMembership::Inside,
            (false, true) => ComponentMembership::Unreached,
            (false, false) => ComponentMembership::DeadEnd,
        };
        cell_reason(standing, is_end(cell) && !self.has_neighbour[cell.edge as usize])
    }
}

/// Remaining motion of an instance.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct InstanceOutcome {
    /// Bits of its remaining cells.
    pub cells: Vec<u64>,
    /// Bits of its remaining links.
    pub links: Vec<u64>,
    /// Counts of its remaining motion.
    pub counts: WorldCounts,
}

impl InstanceOutcome {
    /// Remaining motion of all instances in a state.
    pub fn new(patches: &PatchTables, state: &InstanceState) -> Self {
        let situation = &state.situation.0;
        let patch = situation.surroundings.patch as usize;
        let (cells, links) = (patches.cells_of(patch), patches.links_of(patch));
        let mut out = Self {
            cells: state.inside.clone(),
            links: vec![0; num_words(links.len())],
            counts: WorldCounts::default(),
        };
        let taken_out: Vec<_> = (0u32..).zip(cells).map(|(c, cell)| state.cell(cell, c)).collect();
        for (cell, reason) in cells.iter().zip(&taken_out) {
            match reason {
                Some(reason) => out.counts.disabled[*reason as usize] += 1,
                // An exit is the neighbour's entry, and is counted there.
                None => out.counts.cells += u64::from(!cell.has_flags(CellRecord::IS_EXIT)),
            }
        }
        for (l, link) in (0u32..).zip(links) {
            let free = is_set(&situation.link_words, 0, l);
            match link_reason(free, taken_out[link.from as usize], || taken_out[link.to as usize]) {
                Some(reason) => out.counts.disabled[reason as usize] += 1,
                None => {
                    set_bit(&mut out.links, l);
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

/// Reason why a cell is removed; `None` if it remains.
///
/// - `alone`: true at an edge without a neighbour.
pub(in crate::stitch) fn cell_reason(standing: ComponentMembership, alone: bool) -> Option<RemovalReason> {
    match standing {
        ComponentMembership::Inside => None,
        _ if alone => Some(RemovalReason::NoNeighbour),
        ComponentMembership::DeadEnd => Some(RemovalReason::DeadEnd),
        ComponentMembership::Unreached => Some(RemovalReason::OutsideComponent),
    }
}

/// Reason why a link is removed; `None` if it remains.
///
/// - `free`: true if nothing obstructs it.
/// - `from`, `to`: reasons against the cells at its begin and end.
pub(in crate::stitch) fn link_reason(
    free: bool,
    from: Option<RemovalReason>,
    to: impl FnOnce() -> Option<RemovalReason>,
) -> Option<RemovalReason> {
    if !free {
        return Some(RemovalReason::Obstacle);
    }
    match to() {
        Some(RemovalReason::NoNeighbour) => Some(RemovalReason::NoNeighbour),
        None => from,
        // The cell would be part of the component if it led back to it.
        Some(_) => from.or(Some(RemovalReason::DeadEnd)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stitch::connect::situation::PatchSurroundings;
    use crate::stitch::sets::rows::BitRows;
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
        let patches = PatchTables {
            patches: (&[patch]).into(),
            edges: [].as_slice().into(),
            cells: (&cells).into(),
            links: (&links).into(),
            pairs: [].as_slice().into(),
        };
        let surroundings = PatchSurroundings { patch: 0, obstacles: Vec::new() };
        // Something is in the way of the last link.
        let situation = PatchSituation {
            surroundings,
            link_words: vec![0b01_1111],
            out: BitRows::default(),
            into: BitRows::default(),
        };
        let state = InstanceState {
            situation: IdentityArc(Arc::new(situation)),
            inside: vec![0b0_0011],
            leads: vec![0b1_0011],
            has_neighbour: vec![true, false],
        };
        let outcome = InstanceOutcome::new(&patches, &state);
        assert_eq!((outcome.cells[0], outcome.links[0]), (0b11, 0b11));
        let c = outcome.counts;
        // The exit is no cell of its own. Cell 2 has no neighbour, nothing leads to 4, and 3 leads nowhere.
        assert_eq!((c.cells, c.links, c.frames, c.joints), (1, 2, 50, 0));
        let mut disabled = [0; 4];
        disabled[RemovalReason::NoNeighbour as usize] = 2;
        disabled[RemovalReason::OutsideComponent as usize] = 2;
        disabled[RemovalReason::DeadEnd as usize] = 2;
        disabled[RemovalReason::Obstacle as usize] = 1;
        assert_eq!(c.disabled, disabled);
        let mut sum = c;
        sum.add(&c);
        assert_eq!((sum.links, sum.disabled[RemovalReason::DeadEnd as usize]), (4, 4));
    }
}
