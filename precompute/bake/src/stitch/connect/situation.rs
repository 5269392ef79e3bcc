//! Unobstructed motion of a patch among the units around it: shared by all instances with equal surroundings.

use super::table::JointTable;
use crate::stitch::sets::rows::{BitRows, all_set, clear_bit};
use crate::{stitch::clearance::collision_span::CollisionSpan, stitch::place::relation::RelativePlacement};
use throng_core::patch::{NONE, PatchTables};
use throng_world::is_set;

/// A patch with the obstacles to its motion.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(in crate::stitch) struct PatchSurroundings {
    /// Number of the patch.
    pub patch: u32,
    /// Relative placements of the units that any of its links collides with; ascending.
    pub obstacles: Vec<RelativePlacement>,
}

/// Unobstructed motion of a patch.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct PatchSituation {
    /// Patch and obstacles.
    pub surroundings: PatchSurroundings,
    /// Bits of unobstructed links.
    pub link_words: Vec<u64>,
    /// Cells reached by each cell's links.
    pub out: BitRows,
    /// Cells from which links lead to each cell.
    pub into: BitRows,
}

impl PatchSituation {
    /// - `masks`: bits of the links that each of the obstacles obstructs.
    pub fn new<'m>(patches: &PatchTables, around: PatchSurroundings, masks: impl Iterator<Item = &'m [u64]>) -> Self {
        let patch = around.patch as usize;
        let (cells, links) = (patches.cells_of(patch), patches.links_of(patch));
        let mut link_words = all_set(links.len());
        for mask in masks {
            link_words.iter_mut().zip(mask).for_each(|(w, m)| *w &= !m);
        }
        // Links are sorted by the cell they begin in.
        // Links of interactions are skipped: one person alone does not use them.
        let left = (0u32..).zip(links).filter(|(l, link)| is_set(&link_words, 0, *l) && !link.is_for_two());
        let into = BitRows::new(cells.len(), left.map(|(_, link)| (link.to, link.from)));
        let out = into.transposed(cells.len());
        Self { surroundings: around, link_words, out, into }
    }

    /// Usable joints if links of side a collide: out of a link that is clear up to the joint, into one that is clear
    /// from there. Two bits a joint; `None` if all are usable.
    ///
    /// - `hit`: first and last colliding frame of a link of side a.
    pub fn joint_words(
        &self,
        table: &JointTable,
        mut hit: impl FnMut(u32) -> Option<CollisionSpan>,
    ) -> Option<Vec<u64>> {
        let mut words: Option<Vec<u64>> = None;
        let mut first = 0;
        for joints in table.joints.chunk_by(|j, k| j.a == k.a) {
            let numbers = first..;
            first += joints.len() as u32;
            let link = joints[0].a;
            if joints[0].a_offset == NONE || is_set(&self.link_words, 0, link) {
                continue;
            }
            let Some(found) = hit(link) else { continue };
            let words = words.get_or_insert_with(|| all_set(2 * table.joints.len()));
            for (k, joint) in numbers.zip(joints) {
                if u32::from(found.first) <= joint.a_offset {
                    clear_bit(words, 2 * k);
                }
                if u32::from(found.last) >= joint.a_offset {
                    clear_bit(words, 2 * k + 1);
                }
            }
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_world::JointRecord;

    #[test]
    fn a_link_may_be_left_before_and_entered_after_what_is_in_its_way() {
        let joint = |a, a_offset| JointRecord { a, a_offset, b: 0, reserved: 0 };
        let joints = vec![joint(1, 10), joint(1, 20), joint(1, 30), joint(2, 20), joint(20, NONE)];
        let table = JointTable { joints, ..JointTable::default() };
        let mut situation = PatchSituation {
            surroundings: PatchSurroundings { patch: 0, obstacles: Vec::new() },
            link_words: all_set(3),
            out: BitRows::default(),
            into: BitRows::default(),
        };
        assert_eq!(situation.joint_words(&table, |_| None), None);
        clear_bit(&mut situation.link_words, 1);
        let words = situation.joint_words(&table, |_| Some(CollisionSpan { first: 15, last: 25 })).unwrap();
        let ways: Vec<(bool, bool)> =
            (0..5).map(|k| (is_set(&words, 0, 2 * k), is_set(&words, 0, 2 * k + 1))).collect();
        assert_eq!(ways, [(true, false), (false, false), (false, true), (true, true), (true, true)]);
    }
}
