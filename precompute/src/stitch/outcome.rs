//! What is left of an instance: the same for all in the same situation of which the same cells are taken out.

use super::bits::{num_words, set};
use super::report::Reason;
use super::situation::Situation;
use throng_runtime::patch::{CellRecord, Patches};
use throng_runtime::world::is_set;

/// Figures of a world, or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Counts {
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

/// What is left of an instance.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outcome {
    /// Bits of its cells.
    pub cells: Vec<u64>,
    /// Bits of its links.
    pub links: Vec<u64>,
    /// How many there are.
    pub counts: Counts,
}

impl Outcome {
    /// - `taken_out`: why each cell is, none where it is left.
    pub fn new(patches: &Patches<'_>, situation: &Situation, taken_out: &[Option<Reason>]) -> Self {
        let patch = situation.surroundings.patch as usize;
        let (cells, links) = (patches.cells_of(patch), patches.links_of(patch));
        let mut out = Self {
            cells: vec![0; num_words(cells.len())],
            links: vec![0; num_words(links.len())],
            counts: Counts::default(),
        };
        for ((c, cell), reason) in (0u32..).zip(cells).zip(taken_out) {
            match reason {
                Some(reason) => out.counts.disabled[*reason as usize] += 1,
                None => {
                    set(&mut out.cells, c);
                    // An exit is the neighbour's entry.
                    out.counts.cells += u64::from(!cell.is(CellRecord::IS_EXIT));
                }
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

/// Why a link is taken out; none where it is left.
///
/// - `free`: nothing is in its way.
/// - `from`, `to`: why the cells are taken out that it leads from and to.
pub(super) fn of_link(free: bool, from: Option<Reason>, to: impl FnOnce() -> Option<Reason>) -> Option<Reason> {
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
