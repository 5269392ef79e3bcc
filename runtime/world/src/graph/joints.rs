//! Index of joints: the range of each cell and link in the tables.

use crate::WorldTables;
use std::ops::Range;
use throng_core::patch::{KIND_TILE, PatchTables};

/// Places of joints by what they are at.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointIndex {
    /// For each table, where its part for side a begins in `first`, and that for side b.
    begin: Vec<[u32; 2]>,
    /// For each cell of a patch, or link of a tile, the place of its first joint within the table, and then their number.
    first: Vec<u32>,
}

impl JointIndex {
    /// Indexes all tables of a checked world.
    pub fn new(patches: &PatchTables, world: &WorldTables) -> Self {
        let mut out = Self::default();
        for t in &world.tables {
            let range = t.first_joint as usize..(t.first_joint + t.num_joints) as usize;
            let (joints, order) = (&world.joints[range.clone()], &world.joints_by_b[range]);
            let (a, b) = (&patches.patches[t.patch_a as usize], &patches.patches[t.patch_b as usize]);
            let num_a = if a.kind == KIND_TILE { a.num_links } else { a.num_cells };
            let begin_a = out.add(num_a, joints.iter().map(|j| j.a));
            let begin_b = out.add(b.num_cells, order.iter().map(|&k| joints[k as usize].b));
            out.begin.push([begin_a, begin_b]);
        }
        out
    }

    /// Places in a table of joints on side a: of a block's cells, or of a tile's links.
    pub fn at_a(&self, table: u32, which: Range<u32>) -> Range<usize> {
        self.range(self.begin[table as usize][0], which)
    }

    /// Places in a table's order by b of joints at a cell on side b.
    pub fn at_b(&self, table: u32, cell: u32) -> Range<usize> {
        self.range(self.begin[table as usize][1], cell..cell + 1)
    }

    fn range(&self, begin: u32, which: Range<u32>) -> Range<usize> {
        let place = |at: u32| self.first[(begin + at) as usize] as usize;
        place(which.start)..place(which.end)
    }

    /// Counts joints by what they are at, ascending; says where that begins.
    fn add(&mut self, num: u32, at: impl Iterator<Item = u32>) -> u32 {
        let begin = self.first.len();
        self.first.resize(begin + num as usize + 1, 0);
        let counts = &mut self.first[begin..];
        at.for_each(|a| counts[a as usize + 1] += 1);
        for k in 0..num as usize {
            counts[k + 1] += counts[k];
        }
        begin as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn places_are_those_that_a_search_finds(mut at in prop::collection::vec(0u32..12, 0..40), others in 0u32..5) {
            at.sort_unstable();
            let mut index = JointIndex::default();
            // What comes before in the list belongs to another table.
            index.add(others, (0..others).take(1));
            let begin = index.add(12, at.iter().copied());
            for first in 0..12 {
                for end in first..=12 {
                    let expected = at.partition_point(|&a| a < first)..at.partition_point(|&a| a < end);
                    prop_assert_eq!(index.range(begin, first..end), expected);
                }
            }
        }
    }
}
