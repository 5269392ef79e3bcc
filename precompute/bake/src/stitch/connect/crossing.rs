//! Usable joints between two instances, as sets of cells, which a search over a world follows.

use super::{outcome::InstanceOutcome, situation::PatchSituation, table::JointTable};
use crate::stitch::clearance::collision_span::CollisionSpan;
use crate::stitch::sets::rows::{BitRows, num_words, set_bit};
use crate::{stitch::place::relation::RelativePlacement, stitch::sets::numbers::IdentityArc};
use std::sync::Arc;
use throng_core::patch::{LinkRecord, NONE, PatchTables};
use throng_world::is_set;

/// Joints of a table that are usable with side a in a certain situation: shared by all such pairs.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct CrossingJoints {
    /// Relative placement of the two sides.
    pub relation: RelativePlacement,
    /// All joints of the pair.
    pub table: Arc<JointTable>,
    /// Bits of usable joints, two a joint; `None` if all are.
    words: Option<Vec<u64>>,
    /// True if joints lead from cell to cell: after such a joint, a link must follow.
    pub between_cells: bool,
    /// Cells of the other side reached from each cell of side a, and of side b.
    pub out: [BitRows; 2],
    /// Cells of the other side that lead to each cell of side a, and of side b.
    pub into: [BitRows; 2],
}

impl CrossingJoints {
    /// - `situation`: of side a.
    /// - `hit`: as for [`PatchSituation::joint_words`].
    pub fn new(
        patches: &PatchTables,
        relation: RelativePlacement,
        table: &Arc<JointTable>,
        situation: &PatchSituation,
        hit: impl FnMut(u32) -> Option<CollisionSpan>,
    ) -> Self {
        let words = situation.joint_words(table, hit);
        let links = patches.links_of(relation.a as usize);
        let [cells_a, cells_b] = [relation.a, relation.b].map(|p| patches.cells_of(p as usize).len());
        let joints = &table.joints;
        let open = |bit: u32| words.as_ref().is_none_or(|w| is_set(w, 0, bit));
        // Joints are sorted by the cell of a that they leave, and `by_b` by the cell of b.
        let leave = (0u32..).zip(joints).filter(|(k, _)| open(2 * k)).map(|(_, j)| match j.a_offset {
            NONE => (j.b, j.a),
            _ => (j.b, links[j.a as usize].from),
        });
        let enter = table.by_b.iter().filter(|k| open(2 * **k + 1)).map(|k| {
            let j = &joints[*k as usize];
            (if j.a_offset == NONE { j.a } else { links[j.a as usize].to }, j.b)
        });
        let into = [BitRows::new(cells_a, enter), BitRows::new(cells_b, leave)];
        let out = [into[1].transposed(cells_a), into[0].transposed(cells_b)];
        let between_cells = joints.first().is_some_and(|j| j.a_offset == NONE);
        Self { relation, table: Arc::clone(table), words, between_cells, out, into }
    }

    /// Remaining joints.
    ///
    /// - `links`: of side a.
    /// - `a`, `b`: bits of the remaining cells of each side.
    pub fn remaining(&self, links: &[LinkRecord], a: &[u64], b: &[u64]) -> RemainingJoints {
        let joints = &self.table.joints;
        let mut left = RemainingJoints { words: vec![0; num_words(2 * joints.len())], count: 0 };
        for (k, joint) in (0u32..).zip(joints).filter(|(_, j)| is_set(b, 0, j.b)) {
            let (from, to) = match joint.a_offset {
                NONE => (joint.a, joint.a),
                _ => (links[joint.a as usize].from, links[joint.a as usize].to),
            };
            for (bit, own) in [(2 * k, from), (2 * k + 1, to)] {
                if is_set(a, 0, own) && self.words.as_ref().is_none_or(|w| is_set(w, 0, bit)) {
                    set_bit(&mut left.words, bit);
                    left.count += 1;
                }
            }
        }
        left
    }
}

/// Remaining joints between two instances.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct RemainingJoints {
    /// Two bits a joint of the table.
    pub words: Vec<u64>,
    /// Number of set bits.
    pub count: u64,
}

/// Key of the remaining joints between two instances.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(in crate::stitch) struct PairState {
    /// Usable joints.
    pub crossing: IdentityArc<CrossingJoints>,
    /// Remaining cells and links of side a and of side b.
    pub sides: [IdentityArc<InstanceOutcome>; 2],
}
